"""The column hit from any side: two rigid bars whose hinges yield under N, My and Mz.

Unknowns q = (n, t, u, b_n, b_t, twist, u_h): displacements of the impact point along the hit and
across it, along the column; rotation of the rigid surface between its two hinges, its twist; axial
displacement of the head. The bar below has (n, t, x = L_a + u, b), the bar above (n, t,
x = L_b + u_h - u, -b). With r = |(n, t)|, l = |(r, x)| and chi = atan2(r, x) / r,

    e = l - L,   psi = chi (n, t),   theta_end = R(a) psi,   theta_hit = R(a - twist) (b - psi).

psi turns the axis into the chord, R takes components along and across the hit to those along the
height and the width of the section, the hit comes at the angle a to the height. In a plane that is
the four-DOF column, exact for any rotation; out of it b - psi differs from the true rotation of the
hinges by products of psi and b that are not parallel.

The twist turns the axes of the hinges at the impact point, and has a torque even where the hit is
central, as moments and rotations of a section are not parallel. St Venant torsion and warping, held
at clamped ends, resist it elastically.

Energy is exact in a step: mean forces stand on discrete gradients, of e and R in closed form, of
psi after Gonzalez 1996. b has no mass and is in equilibrium at the end of a step.

A face with friction holds the impact point sideways (the striker keeps its line) with an impulse of
at most mu times that along the hit: a step is solved sticking, and sliding where that needs more.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.frames.collapse import COLLAPSE_CONTRACTION, COLLAPSE_SIDEWAYS
from workbench.mechanics.impact.contact import called, inner
from workbench.mechanics.impact.integrator import (
    COLLAPSE,
    COMMON,
    DONE,
    PROGRESS,
    StepFunctions,
    begin,
    march_of,
    standstill,
)
from workbench.mechanics.impact.newton import Equations, newton_of
from workbench.mechanics.impact.pace import EPS
from workbench.mechanics.structures.kernels import copy, solve_dense
from workbench.models.batch import COLLAPSES, UNKNOWN
from workbench.responses.histories import FORCE_WINDOW
from workbench.responses.kernels import largest_window, mean_of_cycles, signed_peak
from workbench.steel.hinges.biaxial_kernels import (
    ELASTIC,
    FAILED,
    ROOM,
    SURFACE,
    factorise,
    project,
    substitute,
)

N, T, U, BN, BT, TWIST, HEAD = range(7)
BELOW, ABOVE = 0, 1
PLACES = np.array([N, T, U, BN, BT, TWIST])  # of the unknowns of a bar
SIGNS = np.array([[1.0] * 6, [1.0, 1.0, -1.0, -1.0, -1.0, 1.0]])
COLUMN = np.dtype(
    [
        ("lengths", float, 2),  # of the bars below and above, m
        ("surface", SURFACE),  # of all hinges
        ("strength", float, 5),  # plastic N, My and Mz at the end, My and Mz at the hit, N and N m
        ("stiffness", float, (2, 5, 5)),  # of each bar, over the strength, 1/J
        ("angle", float, 2),  # of the hit to the height of the section: cosine, sine
        ("torsion", float),  # torque over twist, N m/rad
        ("friction", float),  # of the face of the striker
        ("load", float),  # at the head, compression positive, N
        ("weight", float),  # at the impact point, along the strike, N
        ("sag", float),  # displacement there before the hit, m
        ("spring", float),  # axial restraint at the head, N/m
        ("unstressed", float),  # displacement of the head without force in the spring, m
        ("mass", float, 7),  # of the unknowns, kg and kg m2
        ("free_head", bool),  # to move along the column
    ]
)
STATE = np.dtype(
    [
        ("q", float, 7),
        ("w", float, 7),  # their velocities
        ("stress", float, (2, 5)),  # N, My and Mz at the end, My and Mz at the hit, of both bars
        ("plastic", float, (2, 5)),  # elongation and rotations
        ("force", float),  # the resistance along the hit, N
        ("dissipated", float),  # by hinges and friction since the start, J
        ("elastic", float),  # of hinges, twist and the restraint spring, J
    ]
)
WORK = np.dtype(  # room for the numbers of one evaluation
    [
        *((name, float, 7) for name in ("F", "mean", "R", "moved", "step", "old", "q0", "w0")),
        *((name, float, 7) for name in ("F0", "rate")),  # with which the step began; mean velocity
        *((name, float, (7, 7)) for name in ("K", "J", "K0")),
        ("stress0", float, (2, 5)),
        *(("f", float, 6), ("place", float, 6), ("start", float, 6), ("middle", float, 7)),
        *(("k", float, (6, 6)), ("G", float, (3, 3)), ("trial", float, 5)),
        *(("B", float, (2, 5, 6)), ("D", float, (2, 5, 5)), ("DB", float, (5, 6))),
        ("branch", int, 2),
        ("sideways", int),  # 0: the impact point slides freely, 2: it sticks, -1 or 1: it slides so
        ("push", float),  # impulse across the hit, N s
        ("finish_below", float),  # residual that one more Newton step removes; 0: none
        ("strike_mass", float),  # of all that moves along the strike, kg
        ("collision_mass", float),  # mass of the impact point that collides at an instant, kg
    ]
)
STICKS = 2
_TOLERANCE = 1e-10  # of the squash load
_HELD = 1e-7  # of the stiffness at the impact point: holds a rotation between hinges that flow
_SMALL = 1e-3  # angle of a chord below which chi is taken from its series
_FARTHEST = 0.03  # step of Newton, m and rad


class System(NamedTuple):
    """Column (1,), committed and trial state (2,), scratch (1,), hinges of both bars (2,)."""

    columns: Any
    states: Any
    room: Any
    hinges: Any


@njit(cache=True, error_model="numpy")
def place(q, lengths, bar, y):
    """Write the unknowns (n, t, x, b_n, b_t, twist) of a bar into `y` (6,)."""
    for i in range(6):
        y[i] = SIGNS[bar, i] * q[PLACES[i]]
    y[U] += lengths[BELOW] if bar == BELOW else lengths[ABOVE] + q[HEAD]


@njit(cache=True, error_model="numpy")
def chord(y, G):
    """Length l, chi, and k = chi' / r; gradients of l and of both psi by (n, t, x) in `G` (3, 3)."""
    n, t, x = y[N], y[T], y[U]
    square = n * n + t * t
    long = square + x * x
    ratio = square / (x * x)
    if x > 0.0 and ratio < _SMALL * _SMALL:
        chi = (1.0 - ratio * (1.0 / 3.0 - ratio * (0.2 - ratio / 7.0))) / x
        k = (-2.0 / 3.0 + ratio * (0.8 - ratio * 6.0 / 7.0)) / x**3
    else:
        across = np.sqrt(square)
        chi = np.arctan2(across, x) / across
        k = (x / long - chi) / square
    length = np.sqrt(long)
    G[0, 0], G[0, 1], G[0, 2] = n / length, t / length, x / length
    G[1, 0], G[1, 1], G[1, 2] = chi + n * n * k, n * t * k, -n / long
    G[2, 0], G[2, 1], G[2, 2] = n * t * k, chi + t * t * k, -t / long
    return length, chi, k


@njit(cache=True, error_model="numpy")
def _geometric_stiffness(y, length, k, G, forces, K):
    """Add the second derivatives of N l + m psi, with `forces` N, m_n, m_t that do not change."""
    n, t, x = y[N], y[T], y[U]
    axial, along, across = forces
    square, long = n * n + t * t, length * length
    four, ratio = long * long, square / (x * x)
    if x > 0.0 and ratio < _SMALL * _SMALL:
        third = (1.6 - ratio * 24.0 / 7.0) / x**5
    else:
        third = -(2.0 * x / four + 3.0 * k) / square
    both = along * n + across * t
    for i in range(3):
        for j in range(3):
            K[i, j] -= axial / length * G[0, i] * G[0, j]
        K[i, i] += axial / length
    K[0, 0] += k * (2.0 * along * n + both) + third * both * n * n
    K[1, 1] += k * (2.0 * across * t + both) + third * both * t * t
    K[2, 2] += 2.0 * x / four * both
    shared = k * (along * t + across * n) + third * both * n * t
    first, second = 2.0 * both * n / four - along / long, 2.0 * both * t / four - across / long
    K[0, 1] += shared
    K[1, 0] += shared
    K[0, 2] += first
    K[2, 0] += first
    K[1, 2] += second
    K[2, 1] += second


@njit(cache=True, error_model="numpy")
def axes(column, twist):
    """Cosine and sine of the angle from the height of a twisted section to the hit."""
    (c, s), ct, st = (column.angle[0], column.angle[1]), np.cos(twist), np.sin(twist)
    return c * ct + s * st, s * ct - c * st


@njit(cache=True, error_model="numpy")
def deformations(column, bar, q, work, d):
    """Write the five deformations of a bar into `d`; length, chi, k of the chord, its b - psi."""
    y = work.place
    place(q, column.lengths, bar, y)
    length, chi, k = chord(y, work.G)
    n, t, whole = y[N], y[T], column.lengths[bar]
    along, across = y[BN] - chi * n, y[BT] - chi * t
    c, s = column.angle[0], column.angle[1]
    ch, sh = axes(column, y[TWIST])
    d[0] = ((y[U] - whole) * (y[U] + whole) + n * n + t * t) / (length + whole)
    d[1], d[2] = chi * (c * n - s * t), chi * (s * n + c * t)
    d[3], d[4] = ch * along - sh * across, sh * along + ch * across
    return length, k, along, across


@njit(cache=True, error_model="numpy")
def bar_forces(column, bar, state, work, hinges):
    """Forces `work.f` (6,) and tangent `work.k` (6, 6) of a bar over its unknowns; its stress."""
    trial, plastic, stress = work.trial, state.plastic[bar], state.stress[bar]
    strength, G, B, D = column.strength, work.G, work.B[bar], work.D[bar]
    length, k, along, across = deformations(column, bar, state.q, work, trial)
    turned = trial[3], trial[4]
    for i in range(5):
        trial[i] = (trial[i] - plastic[i]) * strength[i]
    room = hinges[bar]
    work.branch[bar] = project(column.surface, column.stiffness[bar], trial, room)
    for i in range(5):
        stress[i] = room.force[i] * strength[i]
        for j in range(5):
            D[i, j] = room.tangent[i, j] * strength[i] * strength[j]
    c, s = column.angle[0], column.angle[1]
    ch, sh = axes(column, work.place[TWIST])
    for j in range(3):
        B[0, j] = G[0, j]
        B[1, j], B[2, j] = c * G[1, j] - s * G[2, j], s * G[1, j] + c * G[2, j]
        B[3, j], B[4, j] = sh * G[2, j] - ch * G[1, j], -sh * G[1, j] - ch * G[2, j]
        B[0, 3 + j] = B[1, 3 + j] = B[2, 3 + j] = 0.0
    B[3, BN], B[3, BT], B[3, TWIST] = ch, -sh, turned[1]
    B[4, BN], B[4, BT], B[4, TWIST] = sh, ch, -turned[0]
    f, K, DB = work.f, work.k, work.DB
    for j in range(6):
        f[j] = 0.0
        for i in range(5):
            f[j] += B[i, j] * stress[i]
            DB[i, j] = 0.0
            for m in range(5):
                DB[i, j] += D[i, m] * B[m, j]
    for i in range(6):
        for j in range(6):
            K[i, j] = 0.0
            for m in range(5):
                K[i, j] += B[m, i] * DB[m, j]
    first, second = stress[3], stress[4]
    m_n = c * stress[1] + s * stress[2] - ch * first - sh * second
    m_t = c * stress[2] - s * stress[1] + sh * first - ch * second
    _geometric_stiffness(work.place, length, k, G, (stress[0], m_n, m_t), K)
    a_n, a_t = first * sh - second * ch, first * ch + second * sh
    K[TWIST, TWIST] -= first * turned[0] + second * turned[1]
    for j, more in ((BN, a_n), (BT, a_t)):
        K[TWIST, j] += more
        K[j, TWIST] += more
    for j in range(3):
        more = a_n * G[1, j] + a_t * G[2, j]
        K[TWIST, j] -= more
        K[j, TWIST] -= more


@njit(cache=True, error_model="numpy")
def add_up(column, bar, f, F):
    """Add the forces of a bar over its unknowns to those of the column."""
    for i in range(6):
        F[PLACES[i]] += SIGNS[bar, i] * f[i]
    if bar == ABOVE:
        F[HEAD] += f[U]


@njit(cache=True, error_model="numpy")
def add_loads(column, q, F):
    """Add the forces of restraint, loads and torsion at the places `q`."""
    F[N] -= column.weight
    F[TWIST] += column.torsion * q[TWIST]
    F[HEAD] += column.spring * (q[HEAD] - column.unstressed) + column.load


@njit(cache=True, error_model="numpy")
def internal_forces(column, state, work, hinges):
    """Internal forces `work.F` (7,) and tangent `work.K` (7, 7) at `state.q`; whether there are."""
    F, K, k = work.F, work.K, work.k
    for i in range(7):
        F[i] = 0.0
        for j in range(7):
            K[i, j] = 0.0
    for bar in (BELOW, ABOVE):
        bar_forces(column, bar, state, work, hinges)
        if work.branch[bar] == FAILED:
            return False
        add_up(column, bar, work.f, F)
        for i in range(6):
            for j in range(6):
                K[PLACES[i], PLACES[j]] += SIGNS[bar, i] * SIGNS[bar, j] * k[i, j]
            if bar == ABOVE:
                K[PLACES[i], HEAD] += SIGNS[bar, i] * k[i, U]
                K[HEAD, PLACES[i]] += SIGNS[bar, i] * k[U, i]
    K[HEAD, HEAD] += k[U, U] + column.spring
    K[TWIST, TWIST] += column.torsion
    add_loads(column, state.q, F)
    return True


@njit(cache=True, error_model="numpy")
def mean_forces(column, state, work):
    """Energy-consistent mean forces of a step: averaged stresses, discrete gradients."""
    mean, f, G, start, y = work.mean, work.f, work.G, work.start, work.place
    c, s = column.angle[0], column.angle[1]
    for i in range(7):
        mean[i] = 0.0
    for bar in (BELOW, ABOVE):
        place(work.q0, column.lengths, bar, start)
        length0, chi0, _ = chord(start, G)
        place(state.q, column.lengths, bar, y)
        length1, chi1, _ = chord(y, G)
        # what is left of both psi over the step beside the gradient in the middle
        left_n, left_t = chi1 * y[N] - chi0 * start[N], chi1 * y[T] - chi0 * start[T]
        g_n = 0.5 * (y[BN] + start[BN] - chi1 * y[N] - chi0 * start[N])
        g_t = 0.5 * (y[BT] + start[BT] - chi1 * y[T] - chi0 * start[T])
        turn, way = 0.5 * (y[TWIST] - start[TWIST]), 0.0
        for i in range(3):
            f[i] = y[i] - start[i]
            way += f[i] * f[i]
        for i in range(6):
            y[i] = 0.5 * (y[i] + start[i])
        chord(y, G)
        for i in range(3):
            left_n -= G[1, i] * f[i]
            left_t -= G[2, i] * f[i]
        if way > 1e-24:
            for i in range(3):
                G[1, i] += left_n * f[i] / way
                G[2, i] += left_t * f[i] / way
        a, b = work.stress0[bar], state.stress[bar]
        axial, first, second = 0.5 * (a[0] + b[0]), 0.5 * (a[3] + b[3]), 0.5 * (a[4] + b[4])
        end_y, end_z = 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])
        ch, sh = axes(column, y[TWIST])
        shorter = np.cos(turn)
        slope = 1.0 - turn * turn / 6.0 if abs(turn) < 1e-4 else np.sin(turn) / turn
        hit_n, hit_t = ch * first + sh * second, ch * second - sh * first
        m_n = c * end_y + s * end_z - shorter * hit_n
        m_t = c * end_z - s * end_y - shorter * hit_t
        for i in range(3):
            along = 2.0 * y[i] / (length0 + length1)
            f[i] = axial * along + m_n * G[1, i] + m_t * G[2, i]
        f[BN], f[BT] = shorter * hit_n, shorter * hit_t
        f[TWIST] = slope * (hit_n * g_t - hit_t * g_n)
        add_up(column, bar, f, mean)
    for i in range(7):
        work.middle[i] = 0.5 * (work.q0[i] + state.q[i])
    add_loads(column, work.middle, mean)


@njit(cache=True, error_model="numpy")
def hold(A, i):
    """Take the unknown i out of a system: its row and column become those of the identity."""
    for k in range(7):
        A[i, k] = A[k, i] = 0.0
    A[i, i] = 1.0


@njit(cache=True, error_model="numpy")
def evaluate(s, dt, closed, touch, striker):
    """Residual `R` (impulses) and tangent `J` of a midpoint step; the scaled size of the residual.

    m (w - w_0) + dt F_mean = P with w = 2 (q - q_0) / dt - w_0 of a massive unknown, F(q) = 0 of a
    massless one.
    """
    column, state, work = s.columns[0], s.states[1], s.room[0]
    q, K, R, J = state.q, work.K, work.R, work.J
    for i in range(7):
        q[i] = work.q0[i] + work.moved[i]
    if not internal_forces(column, state, work, s.hinges):
        R[N] = np.nan
        return np.inf
    mean_forces(column, state, work)
    for i in range(7):
        m = column.mass[i]
        for k in range(7):
            J[i, k] = 0.5 * dt * K[i, k]
        J[i, i] += 2.0 * m / dt
        R[i] = 0.5 * dt * work.F[i]
        if m > 0.0:
            R[i] = 2.0 * m * (work.moved[i] / dt - work.w0[i]) + dt * work.mean[i]
    held = 0.5 * dt * _HELD * column.stiffness[BELOW, 3, 3] * column.strength[3] ** 2
    J[BN, BN] += held
    J[BT, BT] += held
    if closed:
        end = 2.0 * work.moved[N] / dt - work.w0[N]
        R[N] += striker * (end - touch)
        J[N, N] += 2.0 * striker / dt
        if work.sideways == STICKS:
            work.push = R[T]
            R[T] = 0.0
            hold(J, T)
        elif work.sideways != 0:
            share = work.sideways * column.friction * striker
            work.push = share * (end - touch)
            R[T] -= work.push
            J[T, N] -= 2.0 * share / dt
    if not column.free_head:
        R[HEAD] = 0.0
        hold(J, HEAD)
    forces = max(max(abs(R[N]), abs(R[T])), max(abs(R[U]), abs(R[HEAD]))) / column.strength[0]
    moments = max(abs(R[TWIST]), max(abs(R[BN]), abs(R[BT]))) / column.strength[3]
    return max(forces, moments) / dt


@njit(cache=True, error_model="numpy")
def solved(A, b, symmetric):
    """Solve seven equations in place."""
    if symmetric and factorise(A, 0, 7):
        substitute(A, b, 0, 7)
        return True
    if symmetric:
        for i in range(7):
            for k in range(i):  # the diagonal is lost as well: this system has no step
                A[i, k] = A[k, i]
        return False
    return solve_dense(A, b)


@njit(cache=True, error_model="numpy")
def predict(s, dt, closed, touch, striker):
    """First guess of a step: forces grow along the last tangent, bars stretch as linearised.

    That the chords turn about their ends is taken into account.
    """
    column, work = s.columns[0], s.room[0]
    q0, w0, moved, step, J = work.q0, work.w0, work.moved, work.step, work.J
    held = _HELD * column.stiffness[BELOW, 3, 3] * column.strength[3] ** 2
    for i in range(7):
        m = column.mass[i] + (striker if closed and i == N else 0.0)
        for k in range(7):
            J[i, k] = 0.5 * dt * work.K0[i, k]
        J[i, i] += 2.0 * m / dt
        step[i] = 2.0 * m * w0[i] - (dt if m > 0.0 else 0.5 * dt) * work.F0[i]
        moved[i] = 0.0
    for i in (BN, BT):
        J[i, i] += 0.5 * dt * held
        step[i] += 0.5 * dt * held * dt * work.rate[i]
    if closed:
        step[N] -= striker * (w0[N] - touch)
    if not column.free_head:
        step[HEAD] = 0.0
        hold(J, HEAD)
    if not solved(J, step, True):
        for i in range(7):
            step[i] = dt * w0[i] if column.mass[i] > 0.0 else dt * work.rate[i]
    if closed and work.sideways == STICKS:
        step[T] = 0.5 * dt * w0[T]
    copy(step, moved)
    if not column.free_head:
        return
    for bar in (BELOW, ABOVE):  # each end moves along as its bar stretches
        n, t = q0[N], q0[T]
        x = column.lengths[bar] + (q0[U] if bar == BELOW else q0[HEAD] - q0[U])
        dx = step[U] if bar == BELOW else step[HEAD] - step[U]
        long = (n * n + t * t + x * x) ** 0.5
        long += (n * step[N] + t * step[T] + x * dx) / long
        left = long * long - (n + step[N]) ** 2 - (t + step[T]) ** 2
        along = max(left, 0.0) ** 0.5 - x
        if bar == BELOW:
            moved[U] = along
        else:
            moved[HEAD] = moved[U] + along


@inner
def vectors(s):
    """Displacements of the step, where Newton's step began, that step, the residual."""
    return s.room[0].moved, s.room[0].old, s.room[0].step, s.room[0].R


@inner
def allowed(s, dt, size):
    """Residual of a solved step: 1e-10, or what the round-off of velocities leaves."""
    work, column = s.room[0], s.columns[0]
    velocity = abs(work.w0[N]) + 2.0 * abs(work.moved[N]) / dt
    rounded = 8.0 * EPS * work.strike_mass * velocity / (dt * column.strength[0])
    return max(_TOLERANCE, rounded)


@inner
def aim(s):
    """Newton's step, not too far."""
    work = s.room[0]
    step = work.step
    for i in range(7):
        step[i] = -work.R[i]
    free = work.sideways == 0 or work.sideways == STICKS
    if not solved(work.J, step, free):
        return False
    farthest = 0.0
    for i in range(7):
        farthest = max(farthest, abs(step[i]))
    if farthest > _FARTHEST:
        for i in range(7):
            step[i] *= _FARTHEST / farthest
    return True


@inner
def bend(s):
    """Return d'Kd of the step d with the tangent K."""
    total = 0.0
    for i in range(7):
        for k in range(7):
            total += s.room[0].step[i] * s.room[0].J[i, k] * s.room[0].step[k]
    return total


@njit(cache=True, error_model="numpy")
def finish(s, size):
    """Take the last Newton step with forces along the tangent, not evaluated anew.

    Those of an elastic bar are exact: along the tangent it would seem to flow by a round-off.
    """
    column, state, work = s.columns[0], s.states[1], s.room[0]
    if size > work.finish_below or work.sideways != 0 or not aim(s):
        return False
    step, strength = work.step, column.strength
    for i in range(7):
        work.moved[i] += step[i]
        state.q[i] = work.q0[i] + work.moved[i]
        for k in range(7):
            work.F[i] += work.K[i, k] * step[k]
    for bar in (BELOW, ABOVE):
        plastic, stress = state.plastic[bar], state.stress[bar]
        if work.branch[bar] == ELASTIC:
            deformations(column, bar, state.q, work, work.trial)
            for i in range(5):
                stiff = column.stiffness[bar, i, i] * strength[i] ** 2
                stress[i] = stiff * (work.trial[i] - plastic[i])
            continue
        y = work.start
        for i in range(6):
            y[i] = SIGNS[bar, i] * step[PLACES[i]]
        y[U] += 0.0 if bar == BELOW else step[HEAD]
        for i in range(5):
            for m in range(5):
                for j in range(6):
                    stress[i] += work.D[bar, i, m] * work.B[bar, m, j] * y[j]
    return True


newton = newton_of(Equations(vectors, evaluate, allowed, aim, bend, finish))


@njit(cache=True, error_model="numpy")
def assign(source, target):
    """Copy a state field by field: as a whole it takes numba minutes to compile."""
    copy(source.q, target.q)
    copy(source.w, target.w)
    copy(source.stress, target.stress)
    copy(source.plastic, target.plastic)
    target.force, target.dissipated = source.force, source.dissipated
    target.elastic = source.elastic


@inner
def hit(s):
    """Displacement along the hit, and its velocity."""
    return s.states[0].q[N] - s.columns[0].sag, s.states[0].w[N]


@called
def _attempt(s, dt, closed, touch, striker):
    """A midpoint step with what holds the impact point sideways as `room.sideways` says."""
    predict(s, dt, closed, touch, striker)
    done, residual, count = newton(s, dt, closed, touch, striker)
    work, trial = s.room[0], s.states[1]
    for i in range(7):
        trial.w[i] = 2.0 * work.moved[i] / dt - work.w0[i]
    return done, residual, count


@called
def solve(s, dt, closed, touch, striker):
    """A midpoint step; with friction sticking if the face can hold so much, else sliding."""
    assign(s.states[0], s.states[1])
    now, work, column = s.states[0], s.room[0], s.columns[0]
    copy(now.q, work.q0)
    copy(now.w, work.w0)
    copy(now.stress, work.stress0)
    work.strike_mass = 2.0 * column.mass[N] + column.mass[HEAD] + striker
    work.push, rubs = 0.0, closed and column.friction > 0.0
    work.sideways = STICKS if rubs else 0
    done, residual, count = _attempt(s, dt, closed, touch, striker)
    trial = s.states[1]
    pressed = striker * (touch - trial.w[N])
    if rubs and done and pressed > 0.0 and abs(work.push) > column.friction * pressed:
        work.sideways = -1 if work.push < 0.0 else 1
        work.sideways = -work.sideways
        done, residual, more = _attempt(s, dt, closed, touch, striker)
        count += more
    return done, trial.w[N], residual, count


@called
def settle(s, dt):
    """Plastic flow; the largest one of a hinge over its elastic deformation at yielding."""
    column, start, end, work = s.columns[0], s.states[0], s.states[1], s.room[0]
    most, total = 0.0, work.trial
    for bar in (BELOW, ABOVE):
        deformations(column, bar, end.q, work, total)
        for j in range(5):
            strength = column.strength[j]
            stiff = column.stiffness[bar, j, j] * strength
            if stiff > 0.0:  # a pin: all of its rotation is free
                total[j] -= end.stress[bar, j] / (stiff * strength)
            flow = total[j] - start.plastic[bar, j]
            end.dissipated += 0.5 * (work.stress0[bar, j] + end.stress[bar, j]) * flow
            end.plastic[bar, j] = total[j]
            most = max(most, abs(flow) * stiff)
    if work.sideways != 0:
        end.dissipated -= 0.5 * work.push * (work.w0[T] + end.w[T])
    return most


@called
def accept(s, dt):
    """Commit the trial, and what the next first guess starts from."""
    now, trial, work = s.states[0], s.states[1], s.room[0]
    for i in range(7):
        work.rate[i] = (trial.q[i] - now.q[i]) / dt
    assign(s.states[1], s.states[0])
    at_place(s)


@called
def at_place(s):
    """Forces and energy of the committed state, which was evaluated last."""
    column, state = s.columns[0], s.states[0]
    copy(s.room[0].F, s.room[0].F0)
    copy(s.room[0].K, s.room[0].K0)
    state.force = s.room[0].F[N]
    energy = column.spring * (state.q[HEAD] - column.unstressed) ** 2
    energy += column.torsion * state.q[TWIST] ** 2
    for bar in (BELOW, ABOVE):
        for j in range(5):
            stiff = column.stiffness[bar, j, j] * column.strength[j] ** 2
            if stiff > 0.0:
                energy += state.stress[bar, j] ** 2 / stiff
    state.elastic = 0.5 * energy


SCALARS = (
    *("peak_displacement", "time_of_peak", "residual_displacement", "peak_force", "impulse"),
    *("largest_plastic_rotation", "largest_compression", "largest_tension"),
)
RECORD = np.dtype(
    [
        *((name, float) for name in (*COMMON, "force", "elastic", "dissipated")),
        *(("q", float, 7), ("stress", float, (2, 5)), ("plastic", float, (2, 5))),
    ]
)


@called
def write(s, records, n):
    """Places, forces, plastic deformations, energies."""
    row, now, column = records[n], s.states[0], s.columns[0]
    copy(now.q, row.q)
    copy(now.stress, row.stress)
    copy(now.plastic, row.plastic)
    row.force, row.elastic, row.dissipated = now.force, now.elastic, now.dissipated
    row.external_work, row.kinetic = column.weight * now.q[N] - column.load * now.q[HEAD], 0.0
    for i in range(7):
        if i != HEAD or column.free_head:
            row.kinetic += 0.5 * column.mass[i] * now.w[i] ** 2


@inner
def lost(s):
    """Whether a chord turns by more than nine tenths of its bar, or the bars are squashed.

    The length of a bar is its first one, or the distance left between its ends if that is shorter.
    """
    lengths, q = s.columns[0].lengths, s.states[0].q
    across = q[N] ** 2 + q[T] ** 2
    below = (across + (lengths[0] + q[U]) ** 2) ** 0.5
    above = (across + (lengths[1] + q[HEAD] - q[U]) ** 2) ** 0.5
    shorter = min(min(lengths[0], lengths[1]), min(below, above))
    squashed = below + above < (1.0 - COLLAPSE_CONTRACTION) * (lengths[0] + lengths[1])
    return squashed or across**0.5 > COLLAPSE_SIDEWAYS * shorter


@inner
def mass_of(s):
    """The impact mass; in equal steps none, the striker is met within a step as in the thesis."""
    return s.room[0].collision_mass


@inner
def apply_impulse(s, dv):
    """Change the velocity of the impact point; a face with friction takes some of it sideways."""
    now, column = s.states[0], s.columns[0]
    now.w[N] += dv
    before, most = now.w[T], column.friction * abs(dv)
    now.w[T] -= min(max(before, -most), most)
    now.dissipated += 0.5 * column.mass[T] * (before**2 - now.w[T] ** 2)


_march = march_of(
    StepFunctions(
        hit, solve, settle, accept, write, lost, mass=mass_of, apply_impulse=apply_impulse
    )
)


@njit(cache=True, error_model="numpy")
def impact(columns, states, room, hinges, drive, progress, records):
    """Follow an impact: (status, rows).

    Arguments: `columns` (1,) of COLUMN, `states` (2,) of STATE, `room` (1,) of WORK, `hinges` (2,)
    of ROOM; `drive`, `progress` and `records` of `workbench.mechanics.impact`.
    """
    pace, s = begin(drive, progress[0]), System(columns, states, room, hinges)
    internal_forces(s.columns[0], s.states[0], s.room[0], s.hinges)
    at_place(s)
    s.room[0].collision_mass = s.columns[0].mass[N] if pace.error < np.inf else 0.0
    return _march(s, pace, progress[0], records)
