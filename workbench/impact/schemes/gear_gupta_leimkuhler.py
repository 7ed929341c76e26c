"""Both constraints at once (Gear, Gupta and Leimkuhler 1985; Acary 2013; Heng 2017, 3.34-3.35).

A second impulse Psi (kg m) moves bodies apart that velocities alone would let overlap:

    q1 = q0 + h (v0 + v1) / 2 + M^-1 W Psi,   0 <= Psi perp g1 >= 0,

besides M (v1 - v0) + h f_mean = W P and 0 <= P perp gamma_1 + e gamma_0 >= 0. In the simultaneous
form the forces see the moved place; the split form takes a midpoint step first and moves then. The
mass weighting M^-1 W Psi keeps the centre of mass; (3.34) prints W Psi. Moving does work against
the forces: energy is not kept.
"""

import numpy as np

from workbench.compiled import register_jitable
from workbench.impact.complementarity import complementary
from workbench.impact.laboratory import REACH, State, Step, Stepper, forecast, gaps_of, implicit
from workbench.impact.system import commit

_OVERLAP = 1e-13  # m
_TURNS = 30
_POLISH = 10
_EPS = 1e-15


@register_jitable
def move_apart(system, gaps, moved, among):
    """Psi (m,) that closes the overlaps `among` contacts, and residual; `moved` is in `gaps`."""
    psi, on = np.zeros(among.size), np.flatnonzero(among)
    if on.size == 0:
        return psi, 0.0
    W = np.ascontiguousarray(system.normals[:, on])
    G = W.T @ np.linalg.solve(system.mass, W)
    bare = gaps[on] - G @ moved[on]
    closing, residual = complementary(G, bare)
    psi[on] = _exact(G, bare, closing)
    return psi, residual


@register_jitable
def _exact(G, bare, psi):
    """Solve for the contacts that `psi` has found, each to the round-off of its own gap.

    The complementarity problem is solved to a share of its largest gap: metres where a wall is far.
    """
    for _ in range(_POLISH):
        gap = bare + G @ psi
        on = np.flatnonzero((psi > 0.0) | (gap < 0.0))
        if on.size == 0 or np.abs(gap[on]).max() <= _OVERLAP:
            break
        rows = np.ascontiguousarray(G[on][:, on])
        psi[on] = np.maximum(psi[on] - np.linalg.lstsq(rows, gap[on], _EPS)[0], 0.0)
    return psi


def gear_gupta_leimkuhler(
    reach: float = 1.0, split: bool = False, all_gaps: bool = True
) -> Stepper:
    """The step, simultaneous or `split`; `reach` as in `energy_midpoint`.

    Without `all_gaps` the split form moves only contacts that push, as `four-dof` does: an overlap
    that ends a step without impulse stays for that step.
    """
    reach = REACH.check("ggl.reach", reach)

    @register_jitable
    def step(system, law, state, h):
        closed = forecast(system, state, reach * h)
        t, evaluations, psi, shift = state.t + h, 0, np.zeros(closed.size), np.zeros(state.q.size)
        for _ in range(_TURNS):
            q, v, P, count, residual = implicit(system, law, state, h, 0.0, shift, closed)
            evaluations += count
            if split:
                commit(system, q)
                closed = (P > 0.0) | all_gaps
            gaps, change = gaps_of(system, q, t), np.zeros(q.size)
            if (closed & ((gaps < -_OVERLAP) | (psi > 0.0))).any():
                new, left = move_apart(system, gaps, psi, closed)
                change = np.linalg.solve(system.mass, system.normals @ (new - psi))
                psi, shift, residual = new, shift + change, max(residual, left)
                gaps = gaps_of(system, q + change, t)
            if split:
                q = q + change
                break
            # a contact may meet that the forecast has not seen
            met = (gaps < -_OVERLAP) & ~closed
            if np.abs(change).max() <= _OVERLAP and not met.any():
                break
            closed |= met
        commit(system, q)
        return Step(State(q, v, state.a, P / h, t), P, evaluations, residual, np.nan)

    return step
