"""The elasto-plastic spring of the single-degree-of-freedom column and its time stepping.

Heng 2017, section 5.2 and chapter 3. The spring's state is a tuple (v, f, v_top, f_top, k,
yielded, dissipated): displacement and force; the largest displacement met on the envelope and its
force (before the first yielding: the elastic limit and its force); the unloading stiffness there;
whether it has yielded; the energy dissipated so far. The envelope is the `table` of the
resistance curve.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from workbench.impact import contact_loss, explicit_percussion, rebound, touches
from workbench.models.resistance._kernels import (
    START,
    force_in,
    piece_of,
    tangent_in,
    unloading_stiffness,
    work_between,
)

V, F, V_TOP, F_TOP, STIFFNESS, YIELDED, DISSIPATED = 0, 1, 2, 3, 4, 5, 6
MIDPOINT, MOREAU = 0, 1
OK, NO_CONVERGENCE, COLLAPSE = 0, 1, 2
ROWS = 9  # of a record: v, v', striker v', percussion, F, kinetic, elastic, dissipated, lost
_EPS = 2.220446049250313e-16
_TOUCHING = 1e-9  # m; a smaller gap is round-off, which must not open a lasting contact


@njit(cache=True, error_model="numpy")
def spring_at_rest(elastic_limit, table):
    """State of the spring before the impact."""
    i = piece_of(table, elastic_limit)
    force = force_in(table, i, elastic_limit - table[i, START])
    stiffness = unloading_stiffness(table, elastic_limit)
    return 0.0, 0.0, elastic_limit, force, stiffness, False, 0.0


@njit(cache=True, error_model="numpy")
def spring_path(state, v1, table):
    """Force, slope and work of the straight path from the state to v1, which is not taken.

    Below the first yielding the spring follows the envelope both ways; later it moves on the
    unloading line between -F_top and F_top, flows at these two, and rejoins the envelope at v_top.
    """
    v0, f0, v_top, f_top, k, yielded, _ = state
    if v1 >= v_top:
        i = piece_of(table, v1)
        x = v1 - table[i, START]
        f1, slope = force_in(table, i, x), tangent_in(table, i, x)
    if not yielded:
        a, b = abs(v0), min(abs(v1), v_top)
        work = work_between(table, a, b) if b >= a else -work_between(table, b, a)
        if v1 >= v_top:
            return f1, slope, work + work_between(table, v_top, v1)
        if v1 < -v_top:
            return -f_top, 0.0, work - f_top * (v1 + v_top)
        i = piece_of(table, b)
        x = b - table[i, START]
        f1, slope = force_in(table, i, x), tangent_in(table, i, x)
        return (f1 if v1 >= 0.0 else -f1), slope, work
    if v1 >= v0:
        if v0 == v_top:
            return f1, slope, work_between(table, v0, v1)
        bend = min(v0 + max(f_top - f0, 0.0) / k, v_top)  # back at F_top
        if v1 <= bend and v1 < v_top:
            f1 = f0 + k * (v1 - v0)
            return f1, k, 0.5 * (f0 + f1) * (v1 - v0)
        work = 0.5 * (f0 + f_top) * (bend - v0)
        if v1 < v_top:
            return f_top, 0.0, work + f_top * (v1 - bend)
        work += f_top * (v_top - bend)
        return f1, slope, work + work_between(table, v_top, v1)
    bend = v0 - (f0 + f_top) / k  # at -F_top
    if v1 >= bend:
        f1 = f0 + k * (v1 - v0)
        return f1, k, 0.5 * (f0 + f1) * (v1 - v0)
    return -f_top, 0.0, 0.5 * (f0 - f_top) * (bend - v0) - f_top * (v1 - bend)


@njit(cache=True, error_model="numpy")
def spring_energy(state, table):
    """Elastic energy of the spring."""
    if state[YIELDED]:
        return 0.5 * state[F] ** 2 / state[STIFFNESS]
    return work_between(table, 0.0, abs(state[V]))


@njit(cache=True, error_model="numpy")
def spring_moved(state, v1, table):
    """State after the straight path to v1: force, top, unloading stiffness, dissipation."""
    f1 = spring_path(state, v1, table)[0]
    v0, f0, v_top, f_top, k, yielded, dissipated = state
    if not yielded:
        if abs(v1) <= v_top:
            return v1, f1, v_top, f_top, k, False, dissipated
        # elastic energy of the curve gives way to that of the unloading line
        dissipated += work_between(table, 0.0, v_top) - 0.5 * f_top * f_top / k
        if v1 < 0.0:
            dissipated += f_top * (-v_top - v1)
    elif v1 < v0:
        dissipated += f_top * max(v0 - (f0 + f_top) / k - v1, 0.0)
    elif v0 < v_top:
        dissipated += f_top * max(min(v1, v_top) - (v0 + max(f_top - f0, 0.0) / k), 0.0)
    if v1 <= v_top:
        return v1, f1, v_top, f_top, k, True, dissipated
    stiffness = unloading_stiffness(table, v1)
    dissipated += work_between(table, v_top, v1)
    dissipated -= 0.5 * (f1 * f1 / stiffness - f_top * f_top / k)
    return v1, f1, v1, f1, stiffness, True, dissipated


@njit(cache=True, error_model="numpy")
def _solve_midpoint(dt, w0, mass, jump, state, table):
    """End velocity w1 of mass (w1 - w0) + jump + dt F_mean = 0; returns (w1, residual).

    F_mean is the work of the step over its displacement, so energy is kept whatever the curve.
    The residual grows with w1 unless the curve softens within the step faster than 2 mass / dt^2.
    """
    v0 = state[V]
    w1 = w0 - (jump + dt * state[F]) / mass
    low, high, residual = -np.inf, np.inf, np.inf
    for _ in range(200):
        v1 = v0 + 0.5 * dt * (w0 + w1)
        f1, slope, work = spring_path(state, v1, table)
        mean = work / (v1 - v0) if v1 != v0 else state[F]
        residual = mass * (w1 - w0) + jump + dt * mean
        scale = mass * (abs(w0) + abs(w1)) + abs(jump) + dt * (abs(mean) + abs(f1))
        scale += dt * abs(slope) * (abs(v0) + abs(v1))  # round-off of v in the force
        if abs(residual) <= 4.0 * _EPS * scale:
            return w1, 0.0
        if residual > 0.0:
            high = w1
        else:
            low = w1
        gradient = mass + 0.25 * dt * dt * slope
        new = w1 - residual / gradient if gradient > 0.0 else w1 - residual / mass
        if not low < new < high and high - low < np.inf:
            new = 0.5 * (low + high)
        if abs(new - w1) <= 2.0 * _EPS * (abs(w0) + abs(w1)):
            return new, 0.0
        w1 = new
    return w1, abs(residual) / scale


@njit(cache=True, error_model="numpy")
def _midpoint_step(dt, motion, masses, restitution, state, table):
    """One energy-conserving midpoint step (Heng 2017, eqs 3.31-3.33).

    `motion`: velocity of the hit point, position and velocity of the striker; `masses`: M_B and
    M_A. Contact is eliminated: closed, the striker follows with w_c1 = w1 + eps gamma_0.
    Returns (residual, motion, state, percussion, energy lost in contact).
    """
    (w0, xc, wc0), (mass, striker) = motion, masses
    gamma = w0 - wc0
    restitution = rebound(gamma, restitution)
    percussion, w1, residual = 0.0, 0.0, 0.0
    closed = touches(state[V] - xc - _TOUCHING, gamma, dt)
    if closed:
        jump = striker * (1.0 + restitution) * gamma
        w1, residual = _solve_midpoint(dt, w0, mass + striker, jump, state, table)
        percussion = -striker * (w1 - w0) - jump
        closed = percussion >= 0.0
    if not closed:
        percussion = 0.0
        w1, residual = _solve_midpoint(dt, w0, mass, 0.0, state, table)
    wc1 = wc0 - percussion / striker
    v1 = state[V] + 0.5 * dt * (w0 + w1)
    state = spring_moved(state, v1, table)
    motion = (w1, xc + 0.5 * dt * (wc0 + wc1), wc1)
    return residual, motion, state, percussion, contact_loss(percussion, gamma, w1 - wc1)


@njit(cache=True, error_model="numpy")
def _moreau_step(dt, motion, masses, restitution, state, table):
    """One explicit step of Moreau's scheme (eqs 3.26-3.30); as `_midpoint_step`."""
    (w0, xc, wc0), (mass, striker) = motion, masses
    gamma = w0 - wc0
    state = spring_moved(state, state[V] + 0.5 * dt * w0, table)
    xc += 0.5 * dt * wc0
    w1, wc1, percussion = w0 - dt * state[F] / mass, wc0, 0.0
    if state[V] - xc <= _TOUCHING:
        percussion = explicit_percussion(w1 - wc0, gamma, restitution, mass, striker)
        w1 += percussion / mass
        wc1 -= percussion / striker
    state = spring_moved(state, state[V] + 0.5 * dt * w1, table)
    motion = (w1, xc + 0.5 * dt * wc1, wc1)
    return 0.0, motion, state, percussion, contact_loss(percussion, gamma, w1 - wc1)


@njit(cache=True, error_model="numpy")
def impact(
    scheme, steps, dt, velocity, masses, restitution, elastic_limit, limit,
    table, records,
):  # fmt: skip
    """Follow the impact for `steps` of `dt`: (status, last step, residual, final state).

    The first collision, whose instant is known, comes before the first step; later ones are
    found by the steps. Its percussion is recorded with the first step. `records`
    (ROWS, steps + 1) is written. COLLAPSE when v passes `limit`.
    """
    state = spring_at_rest(elastic_limit, table)
    mass, striker = masses
    records[:, 0] = 0.0
    records[2, 0] = velocity
    records[5, 0] = 0.5 * striker * velocity**2
    first = explicit_percussion(-velocity, -velocity, restitution, mass, striker)
    motion = (first / mass, 0.0, velocity - first / striker)
    lost = contact_loss(first, -velocity, motion[0] - motion[2])
    for n in range(1, steps + 1):
        if scheme == MOREAU:
            residual, motion, state, percussion, loss = _moreau_step(
                dt, motion, masses, restitution, state, table
            )
        else:
            residual, motion, state, percussion, loss = _midpoint_step(
                dt, motion, masses, restitution, state, table
            )
            if residual > 1e-9:
                return NO_CONVERGENCE, n, residual, state
        if n == 1:
            percussion += first
        lost += loss
        records[0, n], records[1, n], records[2, n] = state[V], motion[0], motion[2]
        records[3, n], records[4, n] = percussion, state[F]
        records[5, n] = 0.5 * (mass * motion[0] ** 2 + striker * motion[2] ** 2)
        records[6, n] = spring_energy(state, table)
        records[7, n] = state[DISSIPATED]
        records[8, n] = lost
        if state[V] > limit:
            return COLLAPSE, n, 0.0, state
    return OK, steps, 0.0, state


@njit(cache=True, error_model="numpy")
def follow(path, elastic_limit, table, records):
    """Move the spring along displacements `path` (n,), forth and back.

    `records` (3, n) takes force, elastic energy and dissipation.
    """
    state = spring_at_rest(elastic_limit, table)
    for n in range(path.size):
        state = spring_moved(state, path[n], table)
        records[0, n] = state[F]
        records[1, n] = spring_energy(state, table)
        records[2, n] = state[DISSIPATED]
