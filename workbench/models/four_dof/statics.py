"""Equilibrium of the column: hinge forces, internal forces, massless unknowns, pushover.

Each bar is two generalized hinges in series (Heng 2017, section 2.2). With the forces N, M_end and
M_mid of the closest-point projection and its tangent D, virtual work gives the forces of a bar
over (v, x, b), f = B' (N, M_end, M_mid), and K = B' D B + K_g, rows of B: de, dpsi, db - dpsi.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.structures.kernels import copy, solve_four
from workbench.models.four_dof import kinematics as geometry
from workbench.models.four_dof.kinematics import ABOVE, BELOW, BETA, U1, U2, V, hinge_forces
from workbench.steel.hinges.kernels import LAW, MOST, newton_in_bracket
from workbench.steel.hinges.panel_kernels import WEB

OK, NO_CONVERGENCE, COLLAPSE = 0, 1, 2
TOLERANCE = 1e-10  # of the squash load
_FLOWS = 1e-13  # of the elastic stiffness; below it both middle hinges flow
COLUMN = np.dtype(
    [
        ("lengths", float, 2),  # of the bars below and above, m
        ("stiffness", float, (2, 3)),  # k_N, k_end, k_mid of each bar, N/m and N m/rad
        ("flexibility", float, (2, 4)),  # as a panel has it: 1/k_N, 1/k_end, 0, 1/k_mid
        ("pinned", np.uint8, (2, 2)),
        ("squash_loads", float, 2),  # of all hinges, in tension and compression, N
        ("plastic_moments", float, 2),  # of all hinges, positive and negative, N m
        ("alpha", float),  # exponents of the yield surface
        ("beta", float),
        ("web", WEB),  # of bars that slide
        ("sliding", bool),  # whether bars do
        ("load", float),  # at the head, compression positive, N
        ("weight", float),  # at the impact point, along the strike, N
        ("sag", float),  # displacement there before the hit, m
        ("spring", float),  # axial restraint at the head, N/m
        ("unstressed", float),  # displacement of the head without force in the spring, m
        ("mass", float, 4),  # of the degrees of freedom, kg
        ("small_rotations", bool),
        ("free_head", bool),  # to move along the column
    ]
)
STATE = np.dtype(
    [
        ("q", float, 4),  # degrees of freedom
        ("w", float, 4),  # their velocities
        ("stress", float, (2, 4)),  # N, M_end, M_mid, V of the bars below and above
        ("plastic", float, (2, 4)),  # plastic elongation, rotations and sliding
        ("force", float),  # F_v, the resistance to the hit, N
        ("dissipated", float),  # since the start, J
        ("elastic", float),  # of hinges, webs and the restraint spring, J
    ]
)
WORK = np.dtype(  # room for the numbers of one evaluation
    [
        *((name, float, 4) for name in ("F", "mean", "R", "moved", "step", "old", "q0", "w0")),
        ("F0", float, 4),  # forces with which the step began
        (
            "finish_below",
            float,
        ),  # residual over the squash load that one more Newton step removes; 0: none
        ("strike_mass", float),  # of all that moves along the strike, kg
        ("collision_mass", float),  # mass of the impact point that collides at an instant, kg
        ("nested", int),  # whether the rotation is balanced inside every evaluation
        ("dt", float),  # of the step that is solved, s
        ("rate", float, 4),  # mean velocities of the last step
        *((name, float, (4, 4)) for name in ("K", "J", "K0")),
        ("f", float, (2, 3)),
        ("stress0", float, (2, 4)),
        ("k", float, (2, 3, 3)),  # what is on and above the diagonal
        ("D", float, (2, 3, 3)),
        ("branch", int, 2),  # of the projection
        ("z", float, 2),  # where on the yield surface it began to look, and found it
        ("trial", float, 3),
        ("flow", float, (2, 5)),  # of it the fourth: how far the web slides
    ]
)


class Tables(NamedTuple):
    """Types of a column, its state and room: as above, or those of `VISCOPLASTIC` bars.

    Kernels are compiled for either when they are first called with it. The state of viscoplastic
    bars ends with lambda at their points, the flow with its increments.
    """

    column: Any
    state: Any
    work: Any


def _with(of, **fields):
    """A type of records with other or more fields, which come first.

    At the end numba would take the longer record for the shorter one.
    """
    kept = {name: of[name] for name in of.names if name not in fields}
    return np.dtype(list((fields | kept).items()))


HINGES = Tables(COLUMN, STATE, WORK)
_LAMBDA, _LAST = np.dtype((float, (2, 4 + MOST))), np.dtype((float, (2, 9)))
VISCOPLASTIC = Tables(  # the last deformations of a bar that were tried, and the tangent there
    _with(COLUMN, law=LAW), _with(STATE, plastic=_LAMBDA), _with(WORK, flow=_LAMBDA, last=_LAST)
)


@njit(cache=True, error_model="numpy")
def assign(source, target):
    """Copy a state field by field: as a whole it takes numba minutes to compile."""
    copy(source.q, target.q)
    copy(source.w, target.w)
    copy(source.stress, target.stress)
    copy(source.plastic, target.plastic)
    target.force, target.dissipated = source.force, source.dissipated
    target.elastic = source.elastic


@njit(cache=True, error_model="numpy")
def bar_forces(column, bar, state, work):
    """Forces `work.f` and tangent `work.k` of a bar over (v, x, b); its `state.stress`."""
    plastic, stress = state.plastic, state.stress
    small, length = column.small_rotations, column.lengths[bar]
    v, x, b = geometry.place(state.q, column.lengths, bar)
    stretch, angle = geometry.stretch_and_angle(v, x, length, small)
    elastic = stretch - plastic[bar, 0], angle - plastic[bar, 1], b - angle - plastic[bar, 2]
    NN, N1, N2, M11, M12, M22 = hinge_forces(column, bar, elastic, state, work)
    N, M = stress[bar, 0], stress[bar, 1] - stress[bar, 2]
    ev, ex, pv, px = geometry.gradients(v, x, length, small)
    f, K, D = work.f, work.k, work.D
    f[bar, 0], f[bar, 1], f[bar, 2] = N * ev + M * pv, N * ex + M * px, stress[bar, 2]
    D1, D2, D3 = D[bar, 0], D[bar, 1], D[bar, 2]  # D B
    D1[0], D1[1], D1[2] = NN * ev + (N1 - N2) * pv, NN * ex + (N1 - N2) * px, N2
    D2[0], D2[1], D2[2] = N1 * ev + (M11 - M12) * pv, N1 * ex + (M11 - M12) * px, M12
    D3[0], D3[1], D3[2] = N2 * ev + (M12 - M22) * pv, N2 * ex + (M12 - M22) * px, M22
    vv, vx, xx = geometry.geometric_stiffness(v, x, length, small, N, M)
    K[bar, 0, 0] = ev * D1[0] + pv * (D2[0] - D3[0]) + vv
    K[bar, 0, 1] = ev * D1[1] + pv * (D2[1] - D3[1]) + vx
    K[bar, 1, 1] = ex * D1[1] + px * (D2[1] - D3[1]) + xx
    K[bar, 0, 2], K[bar, 1, 2], K[bar, 2, 2] = D3[0], D3[1], D3[2]


@njit(cache=True, error_model="numpy")
def add_up(column, f, u2, F):
    """Forces `F` (4,) of the column from those of its bars, the restraint, its loads."""
    F[V] = f[BELOW, 0] + f[ABOVE, 0] - column.weight
    F[U1] = f[BELOW, 1] - f[ABOVE, 1]
    F[BETA] = f[BELOW, 2] - f[ABOVE, 2]
    F[U2] = f[ABOVE, 1] + column.spring * (u2 - column.unstressed) + column.load


@njit(cache=True, error_model="numpy")
def internal_forces(column, state, work):
    """Internal forces `work.F` (4,) and tangent `work.K` (4, 4) at `state.q`."""
    for bar in (BELOW, ABOVE):
        bar_forces(column, bar, state, work)
    add_up(column, work.f, state.q[U2], work.F)
    K, a, b = work.K, work.k[BELOW], work.k[ABOVE]
    K[V, V] = a[0, 0] + b[0, 0]
    K[V, U1] = K[U1, V] = a[0, 1] - b[0, 1]
    K[V, BETA] = K[BETA, V] = a[0, 2] - b[0, 2]
    K[V, U2] = K[U2, V] = b[0, 1]
    K[U1, U1] = a[1, 1] + b[1, 1]
    K[U1, BETA] = K[BETA, U1] = a[1, 2] + b[1, 2]
    K[U1, U2] = K[U2, U1] = -b[1, 1]
    K[BETA, BETA] = a[2, 2] + b[2, 2]
    K[BETA, U2] = K[U2, BETA] = -b[1, 2]
    K[U2, U2] = b[1, 1] + column.spring


@njit(cache=True, error_model="numpy")
def rotation_is_free(column, K):
    """Whether both middle hinges flow: then any rotation balances them."""
    stiffest = max(column.stiffness[BELOW, 2], column.stiffness[ABOVE, 2])
    return K[BETA, BETA] <= _FLOWS * stiffest


@njit(cache=True, error_model="numpy")
def balance_rotation(column, state, work):
    """Rotate the rigid surface until its two hinges balance: F_beta(q) = 0, q[BETA] changed.

    F_beta does not decrease with beta1, and its root lies between the rotations at which the
    trial moment of hinge 2 or of hinge 3 vanishes: safeguarded Newton in that bracket.
    """
    q, F, lengths = state.q, work.F, column.lengths
    v, x, _ = geometry.place(q, lengths, BELOW)
    _, below = geometry.stretch_and_angle(v, x, lengths[BELOW], column.small_rotations)
    v, x, _ = geometry.place(q, lengths, ABOVE)
    _, above = geometry.stretch_and_angle(v, x, lengths[ABOVE], column.small_rotations)
    one, two = below + state.plastic[BELOW, 2], -above - state.plastic[ABOVE, 2]
    low, high = min(one, two), max(one, two)
    if column.sliding:
        low, high = geometry.wider(state, low, high)
    if state.plastic.shape[1] > 4:  # flow near one end of a bar turns its other end as well
        reach = abs(below - state.plastic[BELOW, 1]) + abs(above - state.plastic[ABOVE, 1])
        low, high = low - reach, high + reach
    q[BETA] = min(max(q[BETA], low), high)
    for _ in range(100):
        internal_forces(column, state, work)
        closed = high - low <= 4e-16 * max(1.0, abs(q[BETA]))
        if closed or abs(F[BETA]) <= 1e-12 * column.plastic_moments[0]:
            return
        new, low, high, _ = newton_in_bracket(q[BETA], F[BETA], work.K[BETA, BETA], low, high)
        if new == q[BETA]:
            return
        q[BETA] = new


@njit(cache=True, error_model="numpy")
def hold(A, i):
    """Take the unknown i out of a system: its row and column become those of the identity."""
    for k in range(A.shape[0]):
        A[i, k] = A[k, i] = 0.0
    A[i, i] = 1.0


@njit(cache=True, error_model="numpy")
def axial_equilibrium(column, free_u2, state, work):
    """Solve F_u1 = F_u2 = F_beta = 0 at fixed v1 (and fixed u2 where not free).

    Newton on the axial unknowns with the rotation balanced inside every evaluation, backtracking
    on the larger residual over N_p, and a growing diagonal shift where backtracking fails.
    Returns the residual over N_p that is left.
    """
    q, F, K, J, step, old = state.q, work.F, work.K, work.J, work.step, work.old
    Np, shift = column.squash_loads[0], 0.0
    balance_rotation(column, state, work)
    norm = max(abs(F[U1]), abs(F[U2]) * free_u2) / Np
    for _ in range(60):
        if norm <= TOLERANCE:
            break
        r1, r2, k11, k12, k22 = F[U1], F[U2], K[U1, U1], K[U1, U2], K[U2, U2]
        if not rotation_is_free(column, K):
            k11 -= K[U1, BETA] ** 2 / K[BETA, BETA]
            k12 -= K[U1, BETA] * K[U2, BETA] / K[BETA, BETA]
            k22 -= K[U2, BETA] ** 2 / K[BETA, BETA]
        copy(q, old)
        better = False
        while not better and shift < 1e3:
            more = shift * column.stiffness[BELOW, 0]
            J[U1, U1], J[U1, U2], J[U2, U1], J[U2, U2] = k11 + more, k12, k12, k22 + more
            step[V], step[U1] = 0.0, -r1
            step[BETA], step[U2] = 0.0, -r2 if free_u2 else 0.0
            for i in range(4):
                if not (i == U1 or (i == U2 and free_u2)):
                    hold(J, i)
            factor = 1.0
            for _half in range(12 if solve_four(J, step) else 0):
                for i in range(4):
                    q[i] = old[i] + factor * step[i]
                balance_rotation(column, state, work)
                new = max(abs(F[U1]), abs(F[U2]) * free_u2) / Np
                if new < norm * (1.0 - 1e-4 * factor):
                    norm, better = new, True
                    break
                factor *= 0.5
            if better:
                shift = 0.0 if shift < 1e-8 else shift / 30.0
            else:
                shift = 1e-8 if shift == 0.0 else shift * 30.0
        if not better:
            break
    return norm


@njit(cache=True, error_model="numpy")
def update_plastic_deformations(column, start, state, work):
    """Plastic deformations from the converged forces, total less elastic, and what they dissipate.

    `start` (2, 4): the forces with which the step began; their mean with those at the end works.
    """
    for bar in range(2):
        v, x, b = geometry.place(state.q, column.lengths, bar)
        length, small = column.lengths[bar], column.small_rotations
        stretch, angle = geometry.stretch_and_angle(v, x, length, small)
        total = (stretch, angle, b - angle)
        if column.sliding:  # its work is in that of the moments, whose rotations it adds to
            sheared = state.stress[bar, 3] * length / column.web.stiffness / length
            state.plastic[bar, 3] += work.flow[bar, 3]
            total = (stretch, angle - sheared, b - angle + sheared)
        for j in range(3):
            new = total[j]  # a pin: all of its rotation is free
            if column.stiffness[bar, j] > 0.0:
                new -= state.stress[bar, j] / column.stiffness[bar, j]
            mean = 0.5 * (start[bar, j] + state.stress[bar, j])
            state.dissipated += mean * (new - state.plastic[bar, j])
            state.plastic[bar, j] = new
        for j in range(4, state.plastic.shape[1]):  # of viscoplastic bars
            state.plastic[bar, j] += work.flow[bar, j]


@njit(cache=True, error_model="numpy")
def store(column, state):
    """Write the elastic energy of a state."""
    f, Q = column.flexibility, state.stress
    energy = column.spring * (state.q[U2] - column.unstressed) ** 2
    for i in range(2):
        energy += f[i, 0] * Q[i, 0] ** 2 + f[i, 1] * Q[i, 1] ** 2 + f[i, 3] * Q[i, 2] ** 2
        if column.sliding:
            energy += Q[i, 3] ** 2 * column.lengths[i] / column.web.stiffness
    state.elastic = 0.5 * energy


@njit(cache=True, error_model="numpy")
def pushover(column, path, least, records, work):
    """Static path under imposed v1 = path[i]; returns (status, last step, residual).

    `records` (steps + 1,) of STATE begin with the preloaded column. Increments that do not
    converge are halved down to 1/1024. The path ends early once the force is below `least`.
    """
    residual = 0.0
    store(column, records[0])
    for i in range(path.size):
        assign(records[i], records[i + 1])
        state = records[i + 1]
        q, origin = state.q, state.q[V]
        at, stride = 0.0, 1.0
        while at < 1.0:
            copy(q, work.q0)
            stride = min(stride, 1.0 - at)
            q[V] = origin + (at + stride) * (path[i] - origin)
            residual = axial_equilibrium(column, column.free_head, state, work)
            if residual <= TOLERANCE:
                update_plastic_deformations(column, work.stress0, state, work)
                copy(state.stress, work.stress0)
                at += stride
                stride *= 2.0
            else:
                copy(work.q0, q)
                stride *= 0.5
                if stride < 1.0 / 1024.0:
                    return NO_CONVERGENCE, i, residual
        state.force = work.F[V]
        store(column, state)
        if state.force < least:
            return OK, i, residual
    return OK, path.size - 1, residual
