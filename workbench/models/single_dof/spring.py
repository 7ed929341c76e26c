"""The elasto-plastic spring of the single-degree-of-freedom column (Heng 2017, section 5.2).

The envelope of the spring is a resistance curve, `pieces`.
"""

from typing import NamedTuple

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.impact.pace import EPS
from workbench.models.resistance.kernels import on_curve, unloading_stiffness, work_between


class Spring(NamedTuple):
    """Displacement `v` and `force`; farthest place on the envelope, either way, and its force.

    Before the first yielding `top` is the elastic limit. Further the unloading `stiffness` there,
    whether the spring has `yielded`, and the energy `dissipated` so far.
    """

    v: float
    force: float
    top: float
    top_force: float
    stiffness: float
    yielded: bool
    dissipated: float


@njit(cache=True, error_model="numpy")
def spring_at_rest(elastic_limit, pieces):
    """State of the spring before the impact."""
    force, _ = on_curve(pieces, elastic_limit)
    stiffness = unloading_stiffness(pieces, elastic_limit)
    return Spring(0.0, 0.0, elastic_limit, force, stiffness, False, 0.0)


@njit(cache=True, error_model="numpy")
def spring_path(state, v1, pieces):
    """Force, slope and work of the straight path from the state to v1, which is not taken.

    Below the first yielding the spring follows the envelope both ways; later it moves on the
    unloading line between -F_top and F_top, flows at these two, and rejoins the envelope at v_top,
    at -v_top the mirrored one. What goes down is the mirror image of what goes up.
    """
    way = 1.0 if v1 >= state.v else -1.0
    v0, f0, v_top, f_top, k, yielded, _ = state
    v0, f0, v1 = way * v0, way * f0, way * v1
    if v1 >= v_top:
        f1, slope = on_curve(pieces, v1)
    if not yielded:
        a, b = abs(v0), min(abs(v1), v_top)
        work = work_between(pieces, a, b) if b >= a else -work_between(pieces, b, a)
        if v1 >= v_top:
            return way * f1, slope, work + work_between(pieces, v_top, v1)
        f1, slope = on_curve(pieces, b)
        return way * (f1 if v1 >= 0.0 else -f1), slope, work
    if v0 == v_top:
        return way * f1, slope, work_between(pieces, v0, v1)
    bend = min(v0 + max(f_top - f0, 0.0) / k, v_top)  # back at F_top
    if v1 <= bend and v1 < v_top:
        f1 = f0 + k * (v1 - v0)
        return way * f1, k, 0.5 * (f0 + f1) * (v1 - v0)
    work = 0.5 * (f0 + f_top) * (bend - v0)
    if v1 < v_top:
        return way * f_top, 0.0, work + f_top * (v1 - bend)
    work += f_top * (v_top - bend)
    return way * f1, slope, work + work_between(pieces, v_top, v1)


@njit(cache=True, error_model="numpy")
def spring_energy(state, pieces):
    """Elastic energy of the spring."""
    if state.yielded:
        return 0.5 * state.force**2 / state.stiffness
    return work_between(pieces, 0.0, abs(state.v))


@njit(cache=True, error_model="numpy")
def spring_moved(state, v1, pieces):
    """State after the straight path to v1: force, top, unloading stiffness, dissipation."""
    v0, f0, v_top, f_top, k, yielded, dissipated = state
    if unloads(state, v1):
        return Spring(v1, f0 + k * (v1 - v0), v_top, f_top, k, True, dissipated)
    f1 = spring_path(state, v1, pieces)[0]
    way = 1.0 if v1 >= v0 else -1.0
    start, far = way * v0, way * v1
    if not yielded:
        if far <= v_top:
            return Spring(v1, f1, v_top, f_top, k, False, dissipated)
        # elastic energy of the curve gives way to that of the unloading line
        dissipated += work_between(pieces, 0.0, v_top) - 0.5 * f_top * f_top / k
    elif start < v_top:
        flows = start + max(f_top - way * f0, 0.0) / k
        dissipated += f_top * max(min(far, v_top) - flows, 0.0)
    if far <= v_top:
        return Spring(v1, f1, v_top, f_top, k, True, dissipated)
    stiffness = unloading_stiffness(pieces, far)
    dissipated += work_between(pieces, v_top, far)
    dissipated -= 0.5 * (f1 * f1 / stiffness - f_top * f_top / k)
    return Spring(v1, f1, far, abs(f1), stiffness, True, dissipated)


@njit(cache=True, error_model="numpy")
def unloads(state, v1):
    """Whether the spring stays on its unloading line on the way to v1."""
    v0, f0, v_top, f_top, k, yielded, _ = state
    rise = k * (v1 - v0)
    return yielded and abs(v0) < v_top and abs(v1) < v_top and -f_top <= f0 + rise <= f_top


@njit(cache=True, error_model="numpy")
def solve_midpoint(dt, w0, mass, jump, state, pieces):
    """End velocity w1 of mass (w1 - w0) + jump + dt F_mean = 0; returns (w1, residual).

    F_mean is the work of the step over its displacement, so energy is kept whatever the curve.
    The residual grows with w1 unless the curve softens within the step faster than 2 mass / dt^2.
    """
    v0 = state.v
    elastic = state.stiffness if state.yielded and abs(state.v) < state.top else 0.0
    ahead = jump + dt * (state.force + 0.5 * dt * elastic * w0)  # exact on the unloading line
    w1 = w0 - ahead / (mass + 0.25 * dt * dt * elastic)
    if unloads(state, v0 + 0.5 * dt * (w0 + w1)):
        return w1, 0.0
    low, high, residual = -np.inf, np.inf, np.inf
    for _ in range(200):
        v1 = v0 + 0.5 * dt * (w0 + w1)
        f1, slope, work = spring_path(state, v1, pieces)
        mean = work / (v1 - v0) if v1 != v0 else state.force
        residual = mass * (w1 - w0) + jump + dt * mean
        scale = mass * (abs(w0) + abs(w1)) + abs(jump) + dt * (abs(mean) + abs(f1))
        scale += dt * abs(slope) * (abs(v0) + abs(v1))  # round-off of v in the force
        if abs(residual) <= 4.0 * EPS * scale:
            return w1, 0.0
        if residual > 0.0:
            high = w1
        else:
            low = w1
        gradient = mass + 0.25 * dt * dt * slope
        new = w1 - residual / gradient if gradient > 0.0 else w1 - residual / mass
        if not low < new < high and high - low < np.inf:
            new = 0.5 * (low + high)
        if abs(new - w1) <= 2.0 * EPS * (abs(w0) + abs(w1)):
            return new, 0.0
        w1 = new
    return w1, abs(residual) / scale


@njit(cache=True, error_model="numpy")
def pushed(path, elastic_limit, pieces):
    """Force, elastic and dissipated energy, (n, 3), along displacements `path` (n,)."""
    state, out = spring_at_rest(elastic_limit, pieces), np.empty((path.size, 3))
    for n in range(path.size):
        state = spring_moved(state, path[n], pieces)
        out[n] = state.force, spring_energy(state, pieces), state.dissipated
    return out
