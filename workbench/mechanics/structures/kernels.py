"""Band storage: products, and rows that are held; largest entries; small dense systems; copies."""

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
