"""Contact of several bodies: impulses of simultaneous impacts, by Newton's or Poisson's law.

Given the Delassus matrix G = W' M^-1 W (symmetric, positive semi-definite; singular where contacts
depend on each other) and the gap velocities q without impulses, `complementary` finds impulses z,

    0 <= z  perp  w = G z + q >= 0,

by complementary pivoting with lexicographic ratio tests (Lemke 1965; Cottle, Pang and Stone 1992,
section 4.4), which cannot cycle; it ends on a solution or, for these G, on a proof that there is
none. Steps to the minimum of z'Gz/2 + q'z over the contacts that push, cut where an impulse would
pull, take out round-off. w is unique, z only where contacts are independent. Residuals are measured
with G scaled to a unit diagonal and q to a largest entry of 1.

Rigid contacts answer with impulses. With gap velocities gamma- before and gamma = gamma_free + G P
after:

* Newton: 0 <= P perp gamma + e gamma- >= 0, contact by contact (Heng 2017, eq. 3.21).
* Poisson: P = P_c + P_e. Compression ends at 0 <= P_c perp gamma_c >= 0; expansion gives back
  P_e = e P_c, and more only where bodies would overlap otherwise (Glocker and Pfeiffer 1995).

For one contact, and for equal coefficients where all contacts are compressed, Newton and Poisson
agree; where they differ both are right by their own definitions.
"""

from dataclasses import dataclass

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.base.fields import Choice, Declared, Many, Number, checked
from workbench.mechanics.impact.contact import rebound

NEWTON, POISSON = "newton", "poisson"
TOLERANCE = 1e-10
_TIE, _PIVOT = 1e-12, 1e-10
_FLAT = 1e-8
_LARGEST = 1e6  # of a scaled impulse; beyond it round-off has solved what has no solution
_POLISH = 400


@njit(cache=True, error_model="numpy")
def _scaled(G, q):
    """Scale of the impulses (n,), and the problem with a unit diagonal and largest |q| 1."""
    n = q.size
    root = np.ones(n)
    for i in range(n):
        if G[i, i] > 0.0:
            root[i] = 1.0 / np.sqrt(G[i, i])
    size = max(np.abs(root * q).max(), 1e-300)
    scaled = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            scaled[i, j] = root[i] * G[i, j] * root[j]
    return root * size, scaled, root * q / size


@njit(cache=True, error_model="numpy")
def residual_of(G, q, z):
    """Largest violation of 0 <= z perp G z + q >= 0, as min(z, w)."""
    worst = 0.0
    for i in range(q.size):
        w = q[i]
        for j in range(q.size):
            w += G[i, j] * z[j]
        worst = max(worst, abs(min(z[i], w)))
    return worst


@njit(cache=True, error_model="numpy")
def complementary(G, q):
    """Impulses by pivoting, and their residual (infinite where there are none)."""
    n = q.size
    if n == 0 or q.min() >= 0.0:
        return np.zeros(n), 0.0
    if n == 1:
        if G[0, 0] <= 0.0:
            return np.zeros(1), np.inf
        return -q / G[0, 0], 0.0
    scale, A, b = _scaled(G, q)
    table = np.zeros((n, 2 * n + 2))  # of w, z, the artificial z_0, and the right-hand side
    basis = np.arange(n)
    for i in range(n):
        table[i, i], table[i, 2 * n], table[i, 2 * n + 1] = 1.0, -1.0, b[i]
        table[i, n : 2 * n] = -A[i]
    entering, row = 2 * n, int(np.argmin(b))
    for _ in range(200 + 50 * n):
        table[row] /= table[row, entering]
        for i in range(n):
            if i != row and table[i, entering] != 0.0:
                table[i] -= table[i, entering] * table[row]
        leaving, basis[row] = basis[row], entering
        entering = leaving + n if leaving < n else leaving - n
        row = -1 if leaving == 2 * n else _leaving_row(table, basis, entering, n)
        if row < 0:  # solved; or a ray, which in round-off may stand for a solution too
            break
    z = np.zeros(n)
    for i in range(n):
        if n <= basis[i] < 2 * n:
            z[basis[i] - n] = max(table[i, 2 * n + 1], 0.0)
    if z.max() > _LARGEST:
        z[:] = 0.0
    residual = _swept(A, b, z)
    return z * scale, residual


@njit(cache=True, error_model="numpy")
def _leaving_row(table, basis, entering, n):
    """Row of the lexicographically least ratio, that of z_0 if it ties; -1 for a ray."""
    best = -1
    for i in range(n):
        if table[i, entering] <= _PIVOT:
            continue
        if best < 0:
            best = i
            continue
        for k in range(n + 1):
            column = 2 * n + 1 if k == 0 else k - 1
            mine = table[i, column] / table[i, entering]
            other = table[best, column] / table[best, entering]
            if abs(mine - other) > _TIE * (1.0 + abs(other)):
                if mine < other:
                    best = i
                break
            if k == 0 and basis[best] == 2 * n:
                break
            if k == 0 and basis[i] == 2 * n:
                best = i
                break
    return best


@njit(cache=True, error_model="numpy")
def _refine(A, b, z):
    """Move z to the least of its energy over the contacts that push, as far as none pulls.

    Where the energy has none, as contacts depend on each other, z moves down until one opens;
    if none does, no impulses solve the problem: false.
    """
    for _ in range(z.size):
        on = np.flatnonzero(z > 0.0)
        if on.size == 0:
            break
        rows = np.ascontiguousarray(A[on][:, on])
        slope = -(b[on] + A[on] @ z)
        change = np.linalg.lstsq(rows, slope, _PIVOT)[0]
        left = slope - rows @ change
        share, stop = 1.0, -1
        if np.abs(left).max() > _FLAT:
            change, share = left, np.inf
        for k in range(on.size):
            if z[on[k]] + share * change[k] < 0.0:
                share, stop = z[on[k]] / -change[k], on[k]
        if share == np.inf:
            return False
        z[on] += share * change
        if stop < 0:
            break
        z[stop] = 0.0
    return True


@njit(cache=True, error_model="numpy")
def _swept(A, b, z):
    """Improve z until it solves the problem; its residual, infinite where z grows without end."""
    n = z.size
    for sweep in range(_POLISH):
        if sweep % 4 == 0 and not _refine(A, b, z):
            return np.inf
        residual = residual_of(A, b, z)
        if residual <= 0.1 * TOLERANCE:
            break
        for i in range(n):
            if A[i, i] > 0.0:
                w = b[i]
                for j in range(n):
                    w += A[i, j] * z[j]
                z[i] = max(z[i] - w / A[i, i], 0.0)
    return residual if z.max() <= _LARGEST else np.inf


@njit(cache=True, error_model="numpy")
def fixed_point(G, q, turns):
    """Impulses by z <- max(z - r (G z + q), 0), their residual, and how many turns that took.

    Heng 2017, eq. 3.28, of all contacts at once; 1 / r is the largest sum of the moduli of a row of
    G, its single entry for one contact, in the units of `complementary`. At most `turns`.
    """
    if q.size == 0 or q.min() >= 0.0:
        return np.zeros(q.size), 0.0, 0
    scale, A, b = _scaled(G, q)
    z, r, residual, turn = np.zeros(q.size), 1.0 / np.abs(A).sum(axis=1).max(), np.inf, 0
    while turn < turns and residual > 0.1 * TOLERANCE:
        z = np.maximum(z - r * (A @ z + b), 0.0)
        residual, turn = residual_of(A, b, z), turn + 1
    return z * scale, residual, turn


@njit(cache=True, error_model="numpy")
def _solution(G, q, turns):
    """Impulses and residual: by pivoting, or in at most so many `turns` of the fixed point."""
    if turns == 0:
        return complementary(G, q)
    z, residual, _ = fixed_point(G, q, turns)
    return z, residual


@dataclass(frozen=True)
class Restitution(Declared, table="restitution"):
    """Restitution law of contacts.

    Arguments: `coefficients` of the contacts, 0 (plastic) to 1 (elastic), one for each or one for
    all; `law`, newton or poisson.
    """

    coefficients: tuple[float, ...] | float = checked(Many(Number(0.0, 1.0), 1), (0.0,))
    law: str = checked(Choice((NEWTON, POISSON)), NEWTON)

    def __post_init__(self) -> None:
        if isinstance(self.coefficients, int | float):
            object.__setattr__(self, "coefficients", (self.coefficients,))
        super().__post_init__()

    def each(self, contacts: int) -> Array:
        """Coefficients of that many contacts. Raises `InputError` if they are not as many."""
        given = np.atleast_1d(self.coefficients)
        if given.size not in (1, contacts):
            raise self.refusal("coefficients", f"must be one number or {contacts}, one per contact")
        return np.full(contacts, given)


@njit(cache=True, error_model="numpy")
def percussions(G, free, start, e, poisson, turns=0):
    """Impulses of simultaneous impacts, and their residual.

    Arguments: `G` (n, n) in 1/kg; `free` and `start`, gap velocities (n,) in m/s without impulses
    and before the impact; `e` (n,), coefficients; whether the law is Poisson's; `turns`, at most,
    of the fixed point instead of pivots.
    """
    if not poisson:
        xi = np.empty(free.size)
        for i in range(free.size):
            xi[i] = free[i] + rebound(start[i], e[i]) * start[i]
        return _solution(G, xi, turns)
    pressed, first = _solution(G, free, turns)
    back = (1.0 + e) * pressed
    extra, second = _solution(G, free + G @ back, turns)
    return back + extra, max(first, second)
