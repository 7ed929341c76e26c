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
psi after Gonzalez 1996. b has no mass and is in equilibrium at the end of a step: the moments on
both sides of the impact point are then equal, and do no work in the mean either.
"""

import numpy as np

from workbench.base.compiled import njit
from workbench.models.four_dof.statics import Tables
from workbench.steel.hinges.biaxial_kernels import FAILED, SURFACE, project

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
        *((name, float, (2, 2)) for name in ("chord0", "chord")),  # of both bars: length, chi
        ("branch", int, 2),
        ("sideways", int),  # 0: the impact point slides freely, 2: it sticks, -1 or 1: it slides so
        ("push", float),  # impulse across the hit, N s
        ("finish_below", float),  # residual that one more Newton step removes; 0: none
        ("strike_mass", float),  # of all that moves along the strike, kg
        ("collision_mass", float),  # mass of the impact point that collides at an instant, kg
    ]
)
TABLES = Tables(COLUMN, STATE, WORK)
_SMALL = 1e-3  # angle of a chord below which chi is taken from its series


@njit(cache=True, error_model="numpy")
def place(q, lengths, bar, y):
    """Write the unknowns (n, t, x, b_n, b_t, twist) of a bar into `y` (6,)."""
    for i in range(6):
        y[i] = SIGNS[bar, i] * q[PLACES[i]]
    y[U] += lengths[BELOW] if bar == BELOW else lengths[ABOVE] + q[HEAD]


@njit(cache=True, error_model="numpy")
def chord(y, G):
    """Length l, chi, k = chi' / r; gradients of l and of both psi by (n, t, x) in `G` (3, 3)."""
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
    """Write the five deformations of a bar into `d`; length, chi, k of its chord, its `axes`."""
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
    return length, chi, k, ch, sh


@njit(cache=True, error_model="numpy")
def bar_forces(column, bar, state, work, hinges):
    """Forces `work.f` (6,) and tangent `work.k` (6, 6) of a bar over its unknowns; its stress."""
    trial, plastic, stress = work.trial, state.plastic[bar], state.stress[bar]
    strength, G, B, D = column.strength, work.G, work.B[bar], work.D[bar]
    length, chi, k, ch, sh = deformations(column, bar, state.q, work, trial)
    work.chord[bar, 0], work.chord[bar, 1] = length, chi
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
    for j in range(3):
        B[0, j] = G[0, j]
        B[1, j], B[2, j] = c * G[1, j] - s * G[2, j], s * G[1, j] + c * G[2, j]
        B[3, j], B[4, j] = sh * G[2, j] - ch * G[1, j], -sh * G[1, j] - ch * G[2, j]
        B[0, 3 + j] = B[1, 3 + j] = B[2, 3 + j] = 0.0
    B[3, BN], B[3, BT], B[3, TWIST] = ch, -sh, turned[1]
    B[4, BN], B[4, BT], B[4, TWIST] = sh, ch, -turned[0]
    f, K, DB = work.f, work.k, work.DB
    for j in range(6):
        total = 0.0
        for i in range(5):
            total += B[i, j] * stress[i]
            grown = 0.0
            for m in range(5):
                grown += D[i, m] * B[m, j]
            DB[i, j] = grown
        f[j] = total
        for i in range(j + 1):
            total = 0.0
            for m in range(5):
                total += B[m, i] * DB[m, j]
            K[i, j] = K[j, i] = total
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
        place(state.q, column.lengths, bar, y)
        length0, chi0 = work.chord0[bar, 0], work.chord0[bar, 1]
        length1, chi1 = work.chord[bar, 0], work.chord[bar, 1]
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
