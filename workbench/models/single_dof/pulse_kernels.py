"""The elasto-plastic spring of the single-degree-of-freedom column under a force over time.

    M(v) v'' + R(v) = F(t)

The mass belongs to a shape of deflection, which changes once the spring has come to the next stage
(Biggs), and the velocity by a factor that the stage brings; the kinetic energy that this leaves is
lost. Steps keep the energy whatever the curve, and take the mean force exactly.
"""

import numpy as np

from workbench.compiled import njit
from workbench.models.single_dof.kernels import (
    COLLAPSE,
    NO_CONVERGENCE,
    OK,
    solve_midpoint,
    spring_at_rest,
    spring_energy,
    spring_moved,
)


@njit(cache=True, error_model="numpy")
def follow(dt, stages, means, elastic_limit, limit, pieces, records):
    """Follow a push in steps of `dt`: (status, last step, residual, final spring, works).

    Arguments: `stages` (n, 3), displacement (m) from which on a mass (kg) moves and the factor on
    the velocity there; `means` (steps,) of the force; the rest as `kernels.impact`. `works`
    (steps + 1,) of the force so far; the energy lost between stages counts as dissipated.
    """
    state = spring_at_rest(elastic_limit, pieces)
    stage, mass, w, lost = 0, stages[0, 1], 0.0, 0.0
    works = np.zeros(records.size)
    for n in range(1, records.size):
        push = dt * means[n - 1]
        w1, residual = solve_midpoint(dt, w, mass, -push, state, pieces)
        if residual > 1e-9:
            return NO_CONVERGENCE, n, residual, state, works
        v1 = state.v + 0.5 * dt * (w + w1)
        works[n] = works[n - 1] + means[n - 1] * (v1 - state.v)
        state = spring_moved(state, v1, pieces)
        w = w1
        while stage + 1 < stages.shape[0] and abs(v1) >= stages[stage + 1, 0]:
            stage += 1
            kinetic, mass = 0.5 * mass * w * w, stages[stage, 1]
            w *= stages[stage, 2]
            lost += kinetic - 0.5 * mass * w * w
        row = records[n]
        row.displacement, row.velocity, row.force = v1, w, state.force
        row.kinetic, row.elastic = 0.5 * mass * w * w, spring_energy(state, pieces)
        row.dissipated = state.dissipated + lost
        if v1 > limit:
            return COLLAPSE, n, 0.0, state, works
    return OK, records.size - 1, 0.0, state, works
