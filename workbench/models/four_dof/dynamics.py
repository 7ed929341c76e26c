"""Time stepping of the impacted column (Heng 2017, chapter 3).

The impact mass m1 moves with v1 and u1, the head mass m2 (may be zero) with u2; beta1 is massless.
The striker (mass m_c, position x_c) may touch the hit point: gap g = v1 - x_c >= 0, gap velocity
gamma, with the contact law of `workbench.impact.contact`.
"""

from workbench.compiled import njit
from workbench.hinges.kernels import ELASTIC
from workbench.impact import contact as law
from workbench.impact.pace import SLACK
from workbench.models.four_dof import kinematics as geometry
from workbench.models.four_dof import panels, statics
from workbench.models.four_dof.kinematics import ABOVE, BELOW, BETA, U1, U2, V
from workbench.structures.kernels import copy, solve_four

_EPS = 2.220446049250313e-16
_TOLERANCE = 1e-8  # of the squash load: the error of a step is far larger
MIDPOINT, MOREAU, GEAR_GUPTA_LEIMKUHLER = 0, 1, 2


@njit(cache=True, error_model="numpy")
def mean_forces(column, state, work):
    """Energy-consistent mean forces of a step: averaged stresses, discrete gradients."""
    lengths, a, b = column.lengths, work.stress0, state.stress
    for bar in range(2):
        N = 0.5 * (a[bar, 0] + b[bar, 0])
        M = 0.5 * (a[bar, 1] + b[bar, 1] - a[bar, 2] - b[bar, 2])
        v0, x0, _ = geometry.place(work.q0, lengths, bar)
        v1, x1, _ = geometry.place(state.q, lengths, bar)
        small = column.small_rotations
        if column.sliding == panels.SECTION:
            panels.section_mean_forces(bar, state, work)
            continue
        ev, ex, pv, px = geometry.step_gradients(v0, x0, v1, x1, lengths[bar], small)
        work.f[bar, 0], work.f[bar, 1] = N * ev + M * pv, N * ex + M * px
    statics.add_up(column, work.f, 0.5 * (work.q0[U2] + state.q[U2]), work.mean)


@njit(cache=True, error_model="numpy")
def step_residual(column, dt, nested, closed, jump, state, work):
    """Residual `work.R` (impulses) of a midpoint step and its Newton matrix; its scaled norm.

    With (3.31) to (3.33) w = 2 (q - q_0) / dt - w_0 and m (w - w_0) + dt F_mean = P for a massive
    unknown, F(q) = 0 for a massless one. A closed contact eliminates the percussion P = -m_c
    (change of striker velocity), with x_c' = v1' + eps gamma_0 and `jump` (1 + eps) gamma_0.
    `nested`: the rotation is balanced inside.
    """
    q, F, K, R, J = state.q, work.F, work.K, work.R, work.J
    if nested:
        statics.balance_rotation(column, state, work)
    else:
        statics.internal_forces(column, state, work)
    mean_forces(column, state, work)
    for i in range(4):
        m = column.mass[i]
        for k in range(4):
            J[i, k] = (0.5 * dt if m > 0.0 else dt) * K[i, k]
        if m > 0.0:
            R[i] = m * 2.0 * ((q[i] - work.q0[i]) / dt - work.w0[i]) + dt * work.mean[i]
            J[i, i] += 2.0 * m / dt
        else:
            R[i] = dt * F[i]
    if closed:
        change = 2.0 * ((q[V] - work.q0[V]) / dt - work.w0[V])
        R[V] += column.striker_mass * (change + jump)
        J[V, V] += 2.0 * column.striker_mass / dt
    if not column.free_head:
        R[U2] = 0.0
        statics.hold(J, U2)
    if statics.rotation_is_free(column, K):
        statics.hold(J, BETA)
        if nested:
            R[BETA] = 0.0
    axial = max(abs(R[V]), max(abs(R[U1]), abs(R[U2]))) / (dt * column.squash_loads[0])
    return max(axial, abs(R[BETA]) / (dt * column.plastic_moments[0]))


@njit(cache=True, error_model="numpy")
def predict(column, dt, closed, jump, state, work):
    """First guess of a step: forces grow along the last tangent, bars stretch as linearised.

    `jump` as in `step_residual`. That the chords turn about their ends is taken into account.
    """
    q, q0, w0, step, J = state.q, work.q0, work.w0, work.step, work.J
    copy(q0, q)
    for i in range(4):
        m = column.mass[i] + (column.striker_mass if closed and i == V else 0.0)
        for k in range(4):
            J[i, k] = 0.5 * dt * work.K0[i, k] if m > 0.0 else work.K0[i, k]
        J[i, i] += 2.0 * m / dt
        step[i] = 2.0 * m * w0[i] - (dt * work.F0[i] if m > 0.0 else work.F0[i])
    if closed:
        step[V] -= column.striker_mass * jump
    if not column.free_head:
        step[U2] = 0.0
        statics.hold(J, U2)
    if statics.rotation_is_free(column, work.K0):
        step[BETA] = dt * work.rate[BETA]
        statics.hold(J, BETA)
    if not solve_four(J, step):
        return
    q[V], q[U1], q[BETA], q[U2] = q0[V] + step[V], q0[U1] + step[U1], q0[BETA] + step[BETA], q0[U2]
    if not column.free_head or column.small_rotations:
        q[U2] += step[U2]
        return
    for bar, i in ((BELOW, U1), (ABOVE, U2)):  # each end moves along as its bar stretches
        v, x, _ = geometry.place(q0, column.lengths, bar)
        dx = step[U1] if bar == BELOW else step[U2] - step[U1]
        chord = (v * v + x * x) ** 0.5
        chord += (v * step[V] + x * dx) / chord
        moved = max(chord * chord - q[V] * q[V], 0.0) ** 0.5 - x
        q[i] = q0[i] + moved if bar == BELOW else q0[i] + q[U1] - q0[U1] + moved


@njit(cache=True, error_model="numpy")
def solve_step(column, dt, nested, closed, jump, state, work):
    """Solve a midpoint step by Newton with backtracking; returns (converged, scaled residual).

    Below `work.nearly` one more Newton step is taken without an evaluation.
    """
    q, step, old = state.q, work.step, work.old
    predict(column, dt, closed, jump, state, work)
    total = 2.0 * column.mass[V] + column.mass[U2] + column.striker_mass
    norm = step_residual(column, dt, nested, closed, jump, state, work)
    for _ in range(30):
        size = abs(q[V]) + abs(q[U2]) + 1e-3
        rounding = 8.0 * _EPS * total * size / (dt**2 * column.squash_loads[0])
        tolerance = max(_TOLERANCE, rounding)
        if norm <= tolerance and work.nearly == 0.0:
            return True, norm
        for i in range(4):
            step[i], old[i] = -work.R[i], q[i]
        solved = solve_four(work.J, step)
        if solved and norm <= max(work.nearly, tolerance):
            step_along_tangent(column, state, work)
            return True, norm * norm
        factor, new, better = 1.0, norm, False
        for _half in range(12 if solved else 0):
            for i in range(4):
                q[i] = old[i] + factor * step[i]
            new = step_residual(column, dt, nested, closed, jump, state, work)
            better = new < norm or new <= tolerance
            if better:
                break
            factor *= 0.5
        if not better:
            break
        norm = new
    return False, norm


@njit(cache=True, error_model="numpy")
def step_along_tangent(column, state, work):
    """Take the last Newton step `work.step` with forces along the tangent, not evaluated anew.

    Those of an elastic bar are exact: along the tangent it would seem to flow by a round-off.
    """
    step, D, elastic = work.step, work.D, column.stiffness
    for i in range(4):
        state.q[i] += step[i]
        for k in range(4):
            work.F[i] += work.K[i, k] * step[k]
    for bar in range(2):
        plastic, stress = state.plastic[bar], state.stress[bar]
        if work.branch[bar] == ELASTIC:
            v, x, b = geometry.place(state.q, column.lengths, bar)
            length, small = column.lengths[bar], column.small_rotations
            stretch, angle = geometry.stretch_and_angle(v, x, length, small)
            stress[0] = elastic[bar, 0] * (stretch - plastic[0])
            stress[1] = elastic[bar, 1] * (angle - plastic[1])
            stress[2] = elastic[bar, 2] * (b - angle - plastic[2])
            continue
        sign = 1.0 if bar == BELOW else -1.0
        dx = step[U1] if bar == BELOW else step[U2] - step[U1]
        for j in range(3):
            stress[j] += D[bar, j, 0] * step[V] + D[bar, j, 1] * dx
            stress[j] += sign * D[bar, j, 2] * step[BETA]


@njit(cache=True, error_model="numpy")
def midpoint_step(column, dt, closing, state, work):
    """One energy-conserving step (eqs 3.31-3.33) of `state`; returns (converged, residual).

    If the gap forecast for its middle is closed, the contact is; it opens if it would pull.
    `closing`: a gap that is negative afterwards is closed (Gear-Gupta-Leimkuhler). Bodies that
    touch then do so exactly, and are in contact whatever their velocity (Signorini's law on
    velocity level); whether they push is for the law to say, not for a forecast.
    """
    q, w, mass = state.q, state.w, column.striker_mass
    copy(q, work.q0)
    copy(w, work.w0)
    copy(state.stress, work.stress0)
    copy(state.turn, work.turn0)
    before = state.striker_velocity
    gamma = w[V] - before
    eps = law.rebound(gamma, column.restitution)
    gap = q[V] - state.striker
    closed = gap + 0.5 * dt * gamma <= 0.0 or (closing and gap <= SLACK)
    while True:
        jump, percussion = (1.0 + eps) * gamma, 0.0
        for nested in (False, True):
            done, residual = solve_step(column, dt, nested, closed, jump, state, work)
            if done:
                break
        if not done:
            return False, residual
        if closed:
            velocity = 2.0 * (q[V] - work.q0[V]) / dt - work.w0[V]
            percussion = -mass * (velocity + eps * gamma - before)
        if percussion >= 0.0:
            break
        closed = False
    for i in range(4):
        w[i] = 2.0 * (q[i] - work.q0[i]) / dt - work.w0[i]
    state.striker_velocity = before - percussion / mass
    state.striker += 0.5 * dt * (before + state.striker_velocity)
    statics.commit(column, work.stress0, state, work)
    state.percussion += percussion
    state.contact_loss += law.contact_loss(percussion, gamma, w[V] - state.striker_velocity)
    if closing and percussion > 0.0 and q[V] < state.striker:
        return close_gap(column, state, work)
    return True, residual


@njit(cache=True, error_model="numpy")
def close_gap(column, state, work):
    """Move a penetrating contact back (eqs 3.34-3.35); the massless unknowns follow.

    The distances are as the inverse masses, so that the centre of mass stays; (3.34) prints
    equal ones.
    """
    mass, striker = column.mass, column.striker_mass
    push = (state.striker - state.q[V]) / (1.0 / mass[V] + 1.0 / striker)
    state.q[V] += push / mass[V]
    state.striker -= push / striker
    return follow(column, state, work)


@njit(cache=True, error_model="numpy")
def follow(column, state, work):
    """Equilibrium of the massless unknowns, and its plastic flow."""
    massless = column.free_head and column.mass[U2] == 0.0
    residual = statics.axial_equilibrium(column, statics.HELD, massless, state, work)
    if residual > statics.TOLERANCE:
        return False, residual
    statics.commit(column, state.stress, state, work)
    return True, residual


@njit(cache=True, error_model="numpy")
def drift(column, dt, state):
    """Move all masses with their velocities."""
    for i in (V, U1, U2):
        if i != U2 or (column.free_head and column.mass[U2] > 0.0):
            state.q[i] += dt * state.w[i]
    state.striker += dt * state.striker_velocity


@njit(cache=True, error_model="numpy")
def moreau_step(column, dt, state, work):
    """One explicit Moreau midpoint step (eqs 3.26-3.30); returns (converged, residual).

    (3.30) adds the old velocity once more in print.
    """
    w, m, striker = state.w, column.mass, column.striker_mass
    drift(column, 0.5 * dt, state)
    done, residual = follow(column, state, work)
    if not done:
        return False, residual
    gamma = w[V] - state.striker_velocity
    for i in (V, U1, U2):
        if i != U2 or (column.free_head and m[U2] > 0.0):
            w[i] -= dt * work.F[i] / m[i]
    if state.q[V] - state.striker <= 0.0:
        free, eps = w[V] - state.striker_velocity, column.restitution
        percussion = law.explicit_percussion(free, gamma, eps, m[V], striker)
        w[V] += percussion / m[V]
        state.striker_velocity -= percussion / striker
        state.percussion += percussion
        state.contact_loss += law.contact_loss(percussion, gamma, w[V] - state.striker_velocity)
    drift(column, 0.5 * dt, state)
    return True, residual


@njit(cache=True, error_model="numpy")
def step(column, scheme, dt, state, work):
    """One step of the scheme; returns (converged, residual)."""
    if scheme == MOREAU:
        return moreau_step(column, dt, state, work)
    return midpoint_step(column, dt, scheme == GEAR_GUPTA_LEIMKUHLER, state, work)
