"""Band storage: products, and rows that are held; largest entries; small dense systems; copies.

**Second part.** The co-rotational frame of a two-node planar element, shared by every local law.

A law knows only the deformations against the chord and their conjugate forces; here they become
global forces and tangent, for equilibrium or for an energy-exact step between two states.

Symbols: d chord vector, D initial chord, l length, e = d/l, n normal to e, alpha rotation of the
chord; r = dl/dd and g = d(alpha)/dd, or their discrete counterparts over a step. Local
deformations are (l - L, theta_1 - alpha, theta_2 - alpha), local forces (N, M_1, M_2).
Source: Heng 2017, section 5.3; discrete gradients after Simo and Tarnow 1992 and Gonzalez 1996.
"""

import math
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.base.compiled import njit

ROUNDINGS = 8 * float(np.finfo(float).eps)
STALLED = 100.0  # times the allowed residual; iterations that stall below it have converged too


@njit(cache=True, error_model="numpy")
def band_product(band: Array, width: int, x: Array, result: Array) -> None:
    """Product of a matrix in flat band storage with x.

    Arguments: `band`, column by column with 3 * width + 1 entries each, entry (i, j) in row
    2 * width + i - j (the storage of LAPACK gbsv); half-bandwidth `width`; writes `result`.
    """
    n = x.shape[0]
    rows = 3 * width + 1
    result[:] = 0.0
    for j in range(n):
        offset = j * rows + 2 * width - j
        for i in range(max(0, j - width), min(n, j + width + 1)):
            result[i] += band[offset + i] * x[j]


@njit(cache=True, error_model="numpy")
def hold(band: Array, width: int, held: Indices, n: int) -> None:
    """Replace rows and columns of held dofs by those of the identity, in place."""
    rows = 3 * width + 1
    for h in held:
        for j in range(max(0, h - width), min(n, h + width + 1)):
            band[j * rows + 2 * width + h - j] = 0.0
            band[h * rows + 2 * width + j - h] = 0.0
        band[h * rows + 2 * width] = 1.0


@njit(cache=True, error_model="numpy")
def largest(x: Array) -> float:
    """Largest magnitude in x; NaN if there is one."""
    top = 0.0
    for value in x:
        size = abs(value)
        if np.isnan(size):
            return float(size)
        if size > top:
            top = size
    return top


@njit(cache=True, error_model="numpy")
def copy(source, target):
    """Copy an array of the same shape: a sliced assignment takes numba two seconds to compile."""
    for i in np.ndindex(source.shape):
        target[i] = source[i]


@njit(cache=True, error_model="numpy")
def add_inertia(mass, width, moved, factor, start, force, held, result):
    """Residual of a time step: M moved factor - start + force, zero at held dofs."""
    band_product(mass, width, moved, result)
    for i in range(result.shape[0]):
        result[i] = result[i] * factor - start[i] + force[i]
    for h in held:
        result[h] = 0.0


@njit(cache=True, error_model="numpy")
def solve_dense(A, b):
    """Solve A x = b in place by Gaussian elimination with row pivoting; False if singular."""
    n = b.size
    for i in range(n):
        pivot = i
        for r in range(i + 1, n):
            if abs(A[r, i]) > abs(A[pivot, i]):
                pivot = r
        if A[pivot, i] == 0.0 or not np.isfinite(A[pivot, i]):
            return False
        if pivot != i:
            for k in range(n):
                A[i, k], A[pivot, k] = A[pivot, k], A[i, k]
            b[i], b[pivot] = b[pivot], b[i]
        for r in range(i + 1, n):
            factor = A[r, i] / A[i, i]
            if factor != 0.0:
                for k in range(i, n):
                    A[r, k] -= factor * A[i, k]
                b[r] -= factor * b[i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]
    return True


@njit(cache=True, error_model="numpy")
def solve_four(A, b):
    """Solve four unknowns as `solve_dense` does, in registers while all pivots are positive."""
    p, u01, u02, u03 = A[0, 0], A[0, 1], A[0, 2], A[0, 3]
    l1, l2, l3 = A[1, 0] / p, A[2, 0] / p, A[3, 0] / p
    u11, u12, u13 = A[1, 1] - l1 * u01, A[1, 2] - l1 * u02, A[1, 3] - l1 * u03
    a21, u22, u23 = A[2, 1] - l2 * u01, A[2, 2] - l2 * u02, A[2, 3] - l2 * u03
    a31, a32, u33 = A[3, 1] - l3 * u01, A[3, 2] - l3 * u02, A[3, 3] - l3 * u03
    y1, y2, y3 = b[1] - l1 * b[0], b[2] - l2 * b[0], b[3] - l3 * b[0]
    l2, l3 = a21 / u11, a31 / u11
    u22, u23, y2 = u22 - l2 * u12, u23 - l2 * u13, y2 - l2 * y1
    a32, u33, y3 = a32 - l3 * u12, u33 - l3 * u13, y3 - l3 * y1
    l3 = a32 / u22
    u33, y3 = u33 - l3 * u23, y3 - l3 * y2
    if not (p > 0.0 and u11 > 0.0 and u22 > 0.0 and 0.0 < u33 < np.inf):
        return solve_dense(A, b)
    b[3] = y3 / u33
    b[2] = (y2 - u23 * b[3]) / u22
    b[1] = (y1 - u12 * b[2] - u13 * b[3]) / u11
    b[0] = (b[0] - u01 * b[1] - u02 * b[2] - u03 * b[3]) / p
    return True


@njit(cache=True, error_model="numpy")
def allowed_residual(least: float, band: Array, width: int, size: float) -> float:
    """Largest residual entry with which a step counts as solved.

    The `least` asked for, or what the rounding of numbers of that `size` leaves in the largest
    diagonal entry of the tangent in `band`.
    """
    most = 0.0
    for i in range(2 * width, band.size, 3 * width + 1):
        most = max(most, abs(band[i]))
    return max(least, ROUNDINGS * most * size)


@njit(cache=True, error_model="numpy")
def solve_band(band: Array, width: int, x: Array, pivots: Indices) -> bool:
    """Solve a system in flat band storage in place by elimination with row pivoting.

    As LAPACK's gbtf2 and gbtrs, but without a call from Python; scratch `pivots` (dofs,). False if
    the matrix is singular.
    """
    n, rows, diagonal = x.shape[0], 3 * width + 1, 2 * width
    reach = 0  # last column that the rows so far extend to
    for j in range(n):
        column = j * rows + diagonal
        below = min(width, n - 1 - j)
        pivot, top, last = 0, abs(band[column]), 0
        for i in range(1, below + 1):
            size = abs(band[column + i])
            if size > 0.0:
                last = i
            if size > top:
                pivot, top = i, size
        if not (top > 0.0 and np.isfinite(top)):
            return False
        pivots[j] = pivot
        if last == 0:  # a held dof, or the last of a part
            continue
        reach = max(reach, min(j + width + pivot, n - 1))
        if pivot > 0:
            for k in range(j, reach + 1):
                at = k * rows + diagonal + j - k
                band[at], band[at + pivot] = band[at + pivot], band[at]
            x[j], x[j + pivot] = x[j + pivot], x[j]
        inverse = 1.0 / band[column]
        for i in range(1, last + 1):
            band[column + i] *= inverse
        for k in range(j + 1, reach + 1):
            at = k * rows + diagonal + j - k
            factor = band[at]
            if factor != 0.0:
                for i in range(1, last + 1):
                    band[at + i] -= band[column + i] * factor
        for i in range(1, last + 1):
            x[j + i] -= band[column + i] * x[j]
    for j in range(n - 1, -1, -1):
        column = j * rows + diagonal
        x[j] /= band[column]
        if x[j] != 0.0:
            for i in range(1, min(2 * width, j) + 1):
                x[j - i] -= band[column - i] * x[j]
    return True


SMALL_TURN = 1e-3  # rad; below it xi / sin(xi) is taken from its series


class Chord(NamedTuple):
    """Chord (x, y) and its `length` in m, `rotation` (rad) and `elongation` (m) since the start."""

    x: float
    y: float
    length: float
    rotation: float
    elongation: float


class Gradients(NamedTuple):
    """Gradients r and g, then their derivatives with respect to d at the end of the step."""

    rx: float
    ry: float
    gx: float
    gy: float
    rxx: float
    rxy: float
    ryx: float
    ryy: float
    gxx: float
    gxy: float
    gyx: float
    gyy: float


@njit(cache=True, error_model="numpy", forceinline=True)
def chord_rotation(Dx: float, Dy: float, dx: float, dy: float, mean_rotation: float) -> float:
    """Rotation of the chord (rad), unwrapped to the branch nearest to the mean end rotation.

    The branch needs no history, so an element may turn any number of times.
    """
    raw = math.atan2(Dx * dy - Dy * dx, Dx * dx + Dy * dy)
    turns = math.floor((mean_rotation - raw) / (2.0 * math.pi) + 0.5)
    return raw + 2.0 * math.pi * turns


@njit(cache=True, error_model="numpy", forceinline=True)
def chord_at(bars, e, q):
    """The chord of element `e` at displacements `q` (dofs,); of first order where bars are."""
    d = bars.dofs
    Dx, Dy, L = bars.chords[e, 0], bars.chords[e, 1], bars.lengths[e]
    ux, uy = q[d[e, 3]] - q[d[e, 0]], q[d[e, 4]] - q[d[e, 1]]
    if bars.first_order:
        return Chord(Dx, Dy, L, (Dx * uy - Dy * ux) / (L * L), (ux * Dx + uy * Dy) / L)
    dx, dy = Dx + ux, Dy + uy
    if not bars.relative:
        dx, dy = Dx + q[d[e, 3]] - q[d[e, 0]], Dy + q[d[e, 4]] - q[d[e, 1]]
        ux, uy = dx - Dx, dy - Dy
    length = math.sqrt(dx * dx + dy * dy)
    rotation = chord_rotation(Dx, Dy, dx, dy, 0.5 * (q[d[e, 2]] + q[d[e, 5]]))
    # l - L without cancellation: elements of centimetres carry strains of 1e-6
    return Chord(dx, dy, length, rotation, (ux * (dx + Dx) + uy * (dy + Dy)) / (length + L))


@njit(cache=True, error_model="numpy", forceinline=True)
def deform(bars, e, q, deformation):
    """Chord of element `e` at displacements `q`; writes elongation and end rotations (3,)."""
    chord = chord_at(bars, e, q)
    deformation[0] = chord.elongation
    deformation[1] = q[bars.dofs[e, 2]] - chord.rotation
    deformation[2] = q[bars.dofs[e, 5]] - chord.rotation
    return chord


@njit(cache=True, error_model="numpy", forceinline=True)
def end_gradients(dx: float, dy: float, length: float) -> Gradients:
    """Gradients of chord length and rotation at a chord (dx, dy) of the given length (m)."""
    c, s = dx / length, dy / length
    inverse = 1.0 / length
    # dr/dd = n n^T / l;  dg/dd = -(e n^T + n e^T) / l^2 with n = (-s, c)
    shear = (s * s - c * c) * inverse * inverse
    twist = 2.0 * c * s * inverse * inverse
    rxx, rxy, ryy = s * s * inverse, -c * s * inverse, c * c * inverse
    gx, gy = -s * inverse, c * inverse
    return Gradients(c, s, gx, gy, rxx, rxy, rxy, ryy, twist, shear, shear, -twist)


@njit(cache=True, error_model="numpy", forceinline=True)
def initial_gradients(Dx: float, Dy: float, L: float) -> Gradients:
    """Gradients of first-order theory: those of the initial chord, which do not change."""
    c, s = Dx / L, Dy / L
    return Gradients(c, s, -s / L, c / L, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@njit(cache=True, error_model="numpy", forceinline=True)
def step_gradients(
    d0x: float, d0y: float, l0: float, d1x: float, d1y: float, l1: float, turn: float
) -> Gradients:
    """Discrete gradients over a step, exact: r.(d1 - d0) = l1 - l0, g.(d1 - d0) = turn.

    Arguments: chords (m) and lengths (m) at both ends of the step, and the rotation `turn` of the
    chord (rad). The derivatives are with respect to d1.
    """
    xi = 0.5 * turn
    if abs(xi) < SMALL_TURN:
        square = xi * xi
        phi = 1.0 + square / 6.0 + 7.0 * square * square / 360.0
        slope = xi / 3.0 + 7.0 * xi * square / 90.0
        cos_xi = 1.0 - square / 2.0 + square * square / 24.0
        sin_xi = xi * (1.0 - square / 6.0 + square * square / 120.0)
    else:
        cos_xi, sin_xi = math.cos(xi), math.sin(xi)
        phi = xi / sin_xi
        slope = (sin_xi - xi * cos_xi) / (sin_xi * sin_xi)
    mean = 0.5 * (l0 + l1)
    rx, ry = 0.5 * (d0x + d1x) / mean, 0.5 * (d0y + d1y) / mean
    # bisector direction: the first chord turned by half the turn
    emx = (d0x * cos_xi - d0y * sin_xi) / l0
    emy = (d0y * cos_xi + d0x * sin_xi) / l0
    gx, gy = -phi / mean * emy, phi / mean * emx
    e1x, e1y = d1x / l1, d1y / l1
    half = 0.5 / mean
    ax = (-emx * phi - emy * slope) / mean
    ay = (-emy * phi + emx * slope) / mean
    bx, by = -0.5 * e1y / l1, 0.5 * e1x / l1
    rxx, rxy = half * (1.0 - rx * e1x), -half * rx * e1y
    ryx, ryy = -half * ry * e1x, half * (1.0 - ry * e1y)
    gxx, gxy = ax * bx - gx * half * e1x, ax * by - gx * half * e1y
    gyx, gyy = ay * bx - gy * half * e1x, ay * by - gy * half * e1y
    return Gradients(rx, ry, gx, gy, rxx, rxy, ryx, ryy, gxx, gxy, gyx, gyy)


@njit(cache=True, error_model="numpy", forceinline=True)
def add_element(step, bars, e, chord, local_old, local, k, work):
    """Add the forces and the tangent of element `e` for a `step`.

    Arguments: its `chord` at the end; local forces (3,) `local_old` committed and `local` at the
    end; `k` (3, 3), derivative of the latter by the local deformations; `work`, scratch (7, 4).
    Result: the gradients used, and the rotation of the chord in a time step.
    """
    before = chord_at(bars, e, step.start) if step.dynamic else chord
    return add_moved_element(step, bars, e, before, chord, local_old, local, k, work)


@njit(cache=True, error_model="numpy", forceinline=True)
def chord_before(bars, e, q, deformation):
    """The chord at displacements `q` (dofs,) where local `deformation` (e, 3) is known."""
    d, elongation = bars.dofs, deformation[e, 0]
    x = bars.chords[e, 0] + (q[d[e, 3]] - q[d[e, 0]])
    y = bars.chords[e, 1] + (q[d[e, 4]] - q[d[e, 1]])
    turned = q[d[e, 2]] - deformation[e, 1]
    return Chord(x, y, bars.lengths[e] + elongation, turned, elongation)


@njit(cache=True, error_model="numpy", forceinline=True)
def add_moved_element(step, bars, e, before, chord, local_old, local, k, work):
    """Add an element, as `add_element` does, by its known chord `before` the step."""
    turn = chord.rotation - before.rotation
    if bars.first_order:
        gradients = initial_gradients(chord.x, chord.y, chord.length)
    elif step.dynamic:
        gradients = step_gradients(
            before.x, before.y, before.length, chord.x, chord.y, chord.length, turn
        )
    else:
        gradients = end_gradients(chord.x, chord.y, chord.length)
    N, M1, M2 = local[0], local[1], local[2]
    if step.dynamic:
        rest = 1.0 - step.weight
        N = rest * local_old[0] + step.weight * N
        M1 = rest * local_old[1] + step.weight * M1
        M2 = rest * local_old[2] + step.weight * M2
    add_force(step.force, bars.dofs, e, N, M1, M2, gradients)
    if step.tangent:
        add_tangent(step, bars.positions, e, k, N, M1 + M2, gradients, chord, work)
    return gradients, turn


@njit(cache=True, error_model="numpy", forceinline=True)
def add_force(force, dofs, e, N, M1, M2, gradients):
    """Add the six global forces of element `e` with local forces (N, M1, M2) to `force`."""
    rx, ry, gx, gy = gradients[0], gradients[1], gradients[2], gradients[3]
    fx = N * rx - (M1 + M2) * gx
    fy = N * ry - (M1 + M2) * gy
    force[dofs[e, 0]] -= fx
    force[dofs[e, 1]] -= fy
    force[dofs[e, 2]] += M1
    force[dofs[e, 3]] += fx
    force[dofs[e, 4]] += fy
    force[dofs[e, 5]] += M2


@njit(cache=True, error_model="numpy", forceinline=True)
def add_tangent(step, positions, e, k, N, moment, gradients, chord, work):
    """Add the 6 x 6 tangent of element `e` to the band of a `step`.

    Arguments: `positions` (e, 36), where each entry goes; `k` (3, 3), see `add_element`; N and the
    sum of both end moments, weighted as in the step; `gradients` used for the forces; `chord` at
    the end; `work`, scratch (7, 4).
    """
    band, weight, l1 = step.band, step.weight, chord.length
    rx, ry, gx, gy, rxx, rxy, ryx, ryy, gxx, gxy, gyx, gyy = gradients
    e1x, e1y = chord.x / l1, chord.y / l1
    # columns of the end gradient over (d_x, d_y, theta_1, theta_2); k B_1 in the first three
    # rows of `work`, what is left of it with the gradients of the forces in the others
    nx, ny = -e1y / l1, e1x / l1
    for i in range(3):
        pair = k[i, 1] + k[i, 2]
        work[i, 0] = weight * (k[i, 0] * e1x - pair * nx)
        work[i, 1] = weight * (k[i, 0] * e1y - pair * ny)
        work[i, 2] = weight * k[i, 1]
        work[i, 3] = weight * k[i, 2]
    for j in range(4):
        pair = work[1, j] + work[2, j]
        work[3, j] = rx * work[0, j] - gx * pair
        work[4, j] = ry * work[0, j] - gy * pair
        work[5, j] = work[1, j]
        work[6, j] = work[2, j]
    work[3, 0] += N * rxx - moment * gxx
    work[3, 1] += N * rxy - moment * gxy
    work[4, 0] += N * ryx - moment * gyx
    work[4, 1] += N * ryy - moment * gyy
    for i in range(6):
        node_i, row = i // 3, i % 3
        a = 2 + node_i if row == 2 else row
        sign_i = -1.0 if (row != 2 and node_i == 0) else 1.0
        for j in range(6):
            node_j, column = j // 3, j % 3
            b = 2 + node_j if column == 2 else column
            sign_j = -1.0 if (column != 2 and node_j == 0) else 1.0
            band[positions[e, 6 * i + j]] += sign_i * sign_j * work[3 + a, b]
