"""Time stepping of the impacted four-degree-of-freedom column (Heng 2017, chapter 3).

Unknown q at the end of the step; massive degrees of freedom v1, u1 (both the impact mass m1)
and u2 (head mass m2, may be zero); beta1 is massless. The striker (mass m_c, position x_c) may
touch the hit point: gap g = v1 - x_c >= 0, Newton restitution with coefficient eps.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from workbench.impact._kernels import (
    contact_loss,
    explicit_percussion,
    rebound,
    touches,
)
from workbench.models.four_dof._kernels import (
    BETA,
    COLLAPSE,
    NO_CONVERGENCE,
    OK,
    U1,
    U2,
    V,
    axial_equilibrium,
    balance_rotation,
    commit,
    elastic_energy,
    internal,
    solve_small,
)

_EPS = 2.220446049250313e-16
MIDPOINT, MOREAU, GEAR_GUPTA_LEIMKUHLER = 0, 1, 2
COLUMNS = 24  # of a record, see `_record`


@njit(cache=True, error_model="numpy")
def _bar_gradients(v0, x0, v1, x1, length, small):
    """Discrete gradients of stretch and chord angle over (v, x): exact differences per step."""
    if small:
        return 0.5 * (v0 + v1) / length, 1.0, 1.0 / length, 0.0
    l0, l1 = np.sqrt(v0 * v0 + x0 * x0), np.sqrt(v1 * v1 + x1 * x1)
    vm, xm = 0.5 * (v0 + v1), 0.5 * (x0 + x1)
    sine = (x0 * v1 - x1 * v0) / (l0 * l1)
    chi = 1.0 + sine * sine / 6.0 if abs(sine) < 1e-4 else np.arcsin(sine) / sine
    return 2.0 * vm / (l0 + l1), 2.0 * xm / (l0 + l1), chi * xm / (l0 * l1), -chi * vm / (l0 * l1)


@njit(cache=True, error_model="numpy")
def _discrete_forces(q0, q1, stress0, stress1, lengths, small, head, F):
    """Energy-consistent mean forces over the step: averaged stresses, discrete gradients."""
    N = 0.5 * (stress0[0, 0] + stress1[0, 0])
    dM = 0.5 * (stress0[0, 1] + stress1[0, 1] - stress0[0, 2] - stress1[0, 2])
    ev, ex, pv, px = _bar_gradients(
        q0[V], lengths[0] + q0[U1], q1[V], lengths[0] + q1[U1], lengths[0], small
    )
    F[V] = N * ev + dM * pv
    F[U1] = N * ex + dM * px
    N = 0.5 * (stress0[1, 0] + stress1[1, 0])
    dM = 0.5 * (stress0[1, 1] + stress1[1, 1] - stress0[1, 2] - stress1[1, 2])
    ev, ex, pv, px = _bar_gradients(
        q0[V], lengths[1] + q0[U2] - q0[U1], q1[V], lengths[1] + q1[U2] - q1[U1], lengths[1], small
    )
    F[V] += N * ev + dM * pv
    F[U1] -= N * ex + dM * px
    F[U2] = N * ex + dM * px + head[1] * (0.5 * (q0[U2] + q1[U2]) - head[2]) + head[0]


@njit(cache=True, error_model="numpy")
def _residual(
    nested, closed, dt, q0, w0, q1, contact, masses, free_u2,
    lengths, stiffness, bounds, exponents, small, head, plastic, work, stress0, stress1,
    F, K, mean, R, J,
):  # fmt: skip
    """Step residual R (impulses) and its Newton matrix J at q1; returns the scaled norm."""
    if nested:
        balance_rotation(
            q1, lengths, stiffness, bounds, exponents, small, head, plastic, work, stress1, F, K
        )
    else:
        internal(
            q1, lengths, stiffness, bounds, exponents, small, head, plastic, work, stress1, F, K
        )
    _discrete_forces(q0, q1, stress0, stress1, lengths, small, head, mean)
    m1, m2 = masses[0], masses[1]
    for i in range(4):
        massive = i in (V, U1) or (i == U2 and m2 > 0.0)
        if massive:
            m = m2 if i == U2 else m1
            R[i] = m * 2.0 * ((q1[i] - q0[i]) / dt - w0[i]) + dt * mean[i]
            for k in range(4):
                J[i, k] = 0.5 * dt * K[i, k]
            J[i, i] += 2.0 * m / dt
        else:
            R[i] = dt * F[i]
            for k in range(4):
                J[i, k] = dt * K[i, k]
    if closed:
        # percussion eliminated: P = -m_c (change of striker velocity), x_c' = v' + eps gamma_0
        mc, eps, gamma = contact[0], contact[1], contact[2]
        R[V] += mc * (2.0 * ((q1[V] - q0[V]) / dt - w0[V]) + (1.0 + eps) * gamma)
        J[V, V] += 2.0 * mc / dt
    if not free_u2:
        R[U2] = 0.0
        for k in range(4):
            J[U2, k] = J[k, U2] = 0.0
        J[U2, U2] = 1.0
    if K[BETA, BETA] < 1e-13 * max(stiffness[0, 2], stiffness[1, 2]):
        # both middle hinges flow: any rotation balances them, keep the present one
        for k in range(4):
            J[BETA, k] = J[k, BETA] = 0.0
        J[BETA, BETA] = 1.0
        if nested:
            R[BETA] = 0.0
    Np, Mp = bounds[0, 0], max(bounds[1, 0], bounds[2, 0])
    axial = max(abs(R[V]), max(abs(R[U1]), abs(R[U2]))) / (dt * Np)
    return max(axial, abs(R[BETA]) / (dt * Mp))


@njit(cache=True, error_model="numpy")
def _newton(
    nested, closed, dt, q0, w0, q1, contact, masses, free_u2,
    lengths, stiffness, bounds, exponents, small, head, plastic, work, stress0, stress1, scratch,
):  # fmt: skip
    """Solve one step by Newton with backtracking; returns (converged, scaled residual)."""
    F, mean, R, step, old = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4]
    K, J = scratch[5:9], scratch[9:13]
    total = 2.0 * masses[0] + masses[1] + contact[0]
    norm = _residual(
        nested, closed, dt, q0, w0, q1, contact, masses, free_u2, lengths, stiffness, bounds,
        exponents, small, head, plastic, work, stress0, stress1, F, K, mean, R, J,
    )  # fmt: skip
    for _ in range(30):
        floor = 8.0 * _EPS * total * (abs(q1[V]) + abs(q1[U2]) + 1e-3) / (dt**2 * bounds[0, 0])
        tolerance = max(1e-10, floor)
        if norm <= tolerance:
            return True, norm
        for i in range(4):
            step[i], old[i] = -R[i], q1[i]
        if not solve_small(J, step, 4):
            return False, norm
        factor, better = 1.0, False
        for _half in range(12):
            for i in range(4):
                q1[i] = old[i] + factor * step[i]
            new = _residual(
                nested, closed, dt, q0, w0, q1, contact, masses, free_u2, lengths, stiffness,
                bounds, exponents, small, head, plastic, work, stress0, stress1, F, K, mean, R, J,
            )  # fmt: skip
            if new < norm or new <= tolerance:
                better = True
                break
            factor *= 0.5
        if not better:
            return False, norm
        norm = new
    return False, norm


@njit(cache=True, error_model="numpy")
def _midpoint_step(
    dt, project_gap, q, w, striker, masses, restitution, free_u2,
    lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, sums, scratch,
):  # fmt: skip
    """One energy-conserving step (eqs 3.31-3.33); state is changed only if it converges.

    `striker` (x_c, velocity); `sums` (percussion of the step, dissipation, contact loss) are
    added to. `project_gap` moves a penetrating contact back (Gear-Gupta-Leimkuhler, eq. 3.34,
    with the mass weighting that keeps the centre of mass). Returns (converged, residual).
    """
    q0, w0, stress0, stress1 = scratch[13], scratch[14], scratch[15:17, :3], scratch[17:19, :3]
    q1, increments, contact = scratch[19], scratch[20:22, :3], scratch[22]
    for i in range(4):
        q0[i], w0[i] = q[i], w[i]
    stress0[:] = stress
    mc = masses[2]
    gap, gamma = q[V] - striker[0], w[V] - striker[1]
    restitution = rebound(gamma, restitution)
    contact[0], contact[1], contact[2] = mc, restitution, gamma
    percussion, residual, done = 0.0, 0.0, False
    first = 0 if touches(gap, gamma, dt) else 1
    for attempt in range(first, 2):
        closed = attempt == 0
        done = False
        for nested in (False, True):
            q1[:] = q0
            done, residual = _newton(
                nested, closed, dt, q0, w0, q1, contact, masses, free_u2, lengths, stiffness,
                bounds, exponents, small, head, plastic, work, stress0, stress1, scratch,
            )  # fmt: skip
            if done:
                break
        if not done:
            return False, residual
        v_new = 2.0 * (q1[V] - q0[V]) / dt - w0[V]
        if not closed:
            percussion = 0.0
            break
        percussion = -mc * (v_new + restitution * gamma - striker[1])
        if percussion >= 0.0:
            break
    for i in range(4):
        w[i] = 2.0 * (q1[i] - q0[i]) / dt - w0[i]
        q[i] = q1[i]
    before = striker[1]
    striker[1] = before - percussion / mc
    striker[0] += 0.5 * dt * (before + striker[1])
    stress[:] = stress1
    commit(q, lengths, stiffness, small, stress, plastic, increments)
    sums[0] += percussion
    for a in range(2):
        for j in range(3):
            sums[1] += 0.5 * (stress0[a, j] + stress1[a, j]) * increments[a, j]
    sums[2] += contact_loss(percussion, gamma, w[V] - striker[1])
    if project_gap and percussion > 0.0 and q[V] < striker[0]:
        push = (striker[0] - q[V]) / (1.0 / masses[0] + 1.0 / mc)
        q[V] += push / masses[0]
        striker[0] -= push / mc
        residual = axial_equilibrium(
            q, False, free_u2 and masses[1] == 0.0, 1e-10, lengths, stiffness, bounds, exponents,
            small, head, plastic, work, stress, scratch[0], scratch[5:9],
        )  # fmt: skip
        if residual > 1e-10:
            return False, residual
        commit(q, lengths, stiffness, small, stress, plastic, increments)
        for a in range(2):
            for j in range(3):
                sums[1] += stress[a, j] * increments[a, j]
    return True, residual


@njit(cache=True, error_model="numpy")
def _moreau_step(
    dt, q, w, striker, masses, restitution, free_u2,
    lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, sums, scratch,
):  # fmt: skip
    """One explicit Moreau midpoint step (eqs 3.26-3.30); returns (converged, residual)."""
    m1, m2, mc = masses[0], masses[1], masses[2]
    F, K, increments = scratch[0], scratch[5:9], scratch[20:22, :3]
    stress0 = scratch[15:17, :3]
    stress0[:] = stress
    for i in (V, U1):
        q[i] += 0.5 * dt * w[i]
    massive_u2 = free_u2 and m2 > 0.0
    if massive_u2:
        q[U2] += 0.5 * dt * w[U2]
    striker[0] += 0.5 * dt * striker[1]
    residual = axial_equilibrium(
        q, False, free_u2 and not massive_u2, 1e-10, lengths, stiffness, bounds, exponents,
        small, head, plastic, work, stress, F, K,
    )  # fmt: skip
    if residual > 1e-10:
        return False, residual
    commit(q, lengths, stiffness, small, stress, plastic, increments)
    for a in range(2):
        for j in range(3):
            sums[1] += stress[a, j] * increments[a, j]
    gamma = w[V] - striker[1]
    w[V] -= dt * F[V] / m1
    w[U1] -= dt * F[U1] / m1
    if massive_u2:
        w[U2] -= dt * F[U2] / m2
    if q[V] - striker[0] <= 0.0:
        percussion = explicit_percussion(w[V] - striker[1], gamma, restitution, m1, mc)
        w[V] += percussion / m1
        striker[1] -= percussion / mc
        sums[0] += percussion
        sums[2] += contact_loss(percussion, gamma, w[V] - striker[1])
    for i in (V, U1):
        q[i] += 0.5 * dt * w[i]
    if massive_u2:
        q[U2] += 0.5 * dt * w[U2]
    striker[0] += 0.5 * dt * striker[1]
    return True, residual


@njit(cache=True, error_model="numpy")
def _record(row, q, w, striker, stress, plastic, stiffness, head, masses, free_u2, F, sums):
    """One line of the record: state, forces, energies."""
    row[:4] = q
    row[4], row[5], row[6] = w[V], striker[1], sums[0]
    row[7:10], row[10:13] = stress[0], stress[1]
    row[13:16], row[16:19] = plastic[0], plastic[1]
    kinetic = masses[0] * (w[V] ** 2 + w[U1] ** 2) + masses[2] * striker[1] ** 2
    if free_u2:
        kinetic += masses[1] * w[U2] ** 2
    row[19] = 0.5 * kinetic
    row[20] = elastic_energy(stress, stiffness, head, q[U2])
    row[21], row[22] = sums[1], sums[2]
    row[23] = F


@njit(cache=True, error_model="numpy")
def impact(
    scheme, steps, dt, velocity, masses, restitution, free_u2, lengths, stiffness, bounds,
    exponents, small, head, q, records,
):  # fmt: skip
    """Follow the impact for `steps` of `dt`; returns (status, steps done, residual, cuts).

    `masses` (m1, m2, m_c) in kg; `q` (4,) preloaded state; `records` (steps + 1, COLUMNS).
    A step that does not converge is redone with 2, 4, ... 64 substeps. Stops with COLLAPSE when
    a bar squashes or v1 passes nine tenths of the shorter bar.
    """
    work, scratch = np.zeros((18, 3)), np.zeros((23, 4))
    stress, plastic, F, K = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(4), np.zeros((4, 4))
    w, striker, sums = np.zeros(4), np.array([0.0, velocity]), np.zeros(3)
    limit = 0.9 * min(lengths[0], lengths[1])
    squashed = -bounds[0, 1] * (1.0 - 1e-9)
    internal(q, lengths, stiffness, bounds, exponents, small, head, plastic, work, stress, F, K)
    _record(
        records[0], q, w, striker, stress, plastic, stiffness, head, masses, free_u2, F[V], sums
    )
    cuts = 0
    for n in range(1, steps + 1):
        sums[0] = 0.0
        old_q, old_w, old_striker = q.copy(), w.copy(), striker.copy()
        old_stress, old_plastic, old_sums = stress.copy(), plastic.copy(), sums.copy()
        pieces = 1
        while True:
            done, residual = True, 0.0
            for _ in range(pieces):
                if scheme == MOREAU:
                    done, residual = _moreau_step(
                        dt / pieces, q, w, striker, masses, restitution, free_u2, lengths,
                        stiffness, bounds, exponents, small, head, plastic, work, stress, sums,
                        scratch,
                    )  # fmt: skip
                else:
                    done, residual = _midpoint_step(
                        dt / pieces, scheme == GEAR_GUPTA_LEIMKUHLER, q, w, striker,
                        masses, restitution, free_u2, lengths, stiffness, bounds, exponents, small,
                        head, plastic, work, stress, sums, scratch,
                    )  # fmt: skip
                if not done:
                    break
            if done:
                break
            q[:], w[:], striker[:] = old_q, old_w, old_striker
            stress[:], plastic[:], sums[:] = old_stress, old_plastic, old_sums
            pieces *= 2
            cuts += 1
            if pieces > 64:
                return NO_CONVERGENCE, n, residual, cuts
        _record(
            records[n], q, w, striker, stress, plastic, stiffness, head, masses, free_u2,
            scratch[0, V], sums,
        )  # fmt: skip
        if q[V] > limit or min(stress[0, 0], stress[1, 0]) <= squashed:
            return COLLAPSE, n, residual, cuts
    return OK, steps, residual, cuts
