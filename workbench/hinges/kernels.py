"""Closest-point projection onto super-elliptic N-M yield surfaces (Heng 2017, eqs 2.12-2.19).

One axial spring in series with any number of rotational springs that share its force: one
hinge, or a rigid bar with a hinge at each end. Backward Euler is the unique minimiser of

    (N - N_tr)^2 / 2 k_N + sum_i (M_i - M_tr_i)^2 / 2 k_i
    subject to |M_i| <= M_p m(|N|/N_p),   m(n) = (1 - n^beta)^(1/alpha),

found on the boundary n = S^(1/beta), m = C^(1/alpha), S = sin^2 t, C = cos^2 t, with the
unknown z = ln tan t, which keeps full relative accuracy at both ends of the quarter curve.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

ELASTIC, CURVE, CORNER, APEX, SMOOTH_APEX, AXIS = 0, 1, 2, 3, 4, 5
ITERATIONS = 200
ROUNDING = 4e-16  # of the sum of the terms of G, taken without their signs
Z_LIMIT = 340.0


class Hinges(NamedTuple):
    """An axial spring in series with rotational springs, and the yield surface of each.

    `axial_stiffness` k_N (N/m); `rotational_stiffness` k_i (hinges,) (N m/rad), zero for a hinge
    that carries no moment; `squash_loads` (2,) in tension and compression (N); `plastic_moments`
    (hinges, 2) for positive and negative moment (N m); exponents `alpha`, `beta` >= 1.
    """

    axial_stiffness: float
    rotational_stiffness: Vector
    squash_loads: Vector
    plastic_moments: Matrix
    alpha: float
    beta: float


@njit(cache=True, error_model="numpy")
def capacity(n, alpha, beta):
    """Moment capacity m(n) = (1 - n^beta)^(1/alpha) per unit plastic moment, 0 <= n <= 1."""
    if n >= 1.0:
        return 0.0
    if n <= 0.0:
        return 1.0
    # -expm1(beta ln n) is 1 - n^beta without cancellation near n = 1
    return (-np.expm1(beta * np.log(n))) ** (1.0 / alpha)


@njit(cache=True, error_model="numpy")
def on_curve(z):
    """sin^2 t and cos^2 t for z = ln tan t."""
    w = np.exp(-2.0 * abs(z))
    big = 1.0 / (1.0 + w)
    if z >= 0.0:
        return big, w * big
    return w * big, big


@njit(cache=True, error_model="numpy")
def first_on_curve(n, m, alpha, beta):
    """Where the ray through (n, m) meets the quarter curve, roughly: z to start from."""
    z = 0.5 * (beta * np.log(n) - alpha * np.log(m))
    return min(max(z, -300.0), 300.0)


@njit(cache=True, error_model="numpy")
def newton_in_bracket(x, value, slope, low, high):
    """Next x towards the root of a function that rises through zero between `low` and `high`.

    Newton's x, or the middle where that leaves the bracket; the bracket that is left; whether x
    moves no more.
    """
    if value < 0.0:
        low = x
    else:
        high = x
    new = x - value / slope if slope > 0.0 else low - 1.0
    if not (low < new < high):
        new = 0.5 * (low + high)
    small = 2e-16 * max(1.0, abs(x))
    return new, low, high, abs(new - x) <= small or high - low <= small


@njit(cache=True, error_model="numpy")
def _moment(hinges, trial, i):
    """Magnitude of the trial moment of hinge i, and the plastic moment of its sign."""
    M = trial[i + 1]
    return abs(M), hinges.plastic_moments[i, 0 if M >= 0.0 else 1]


@njit(cache=True, error_model="numpy")
def project(hinges, trial, stress, tangent):
    """Project trial forces onto the yield surface; write forces and consistent tangent.

    `trial` (1 + hinges,): elastic trial N and M_i. Writes `stress` (1 + hinges,) and `tangent`
    (1 + hinges, 1 + hinges); returns the branch.
    """
    k, kN = hinges.rotational_stiffness, hinges.axial_stiffness
    alpha, beta = hinges.alpha, hinges.beta
    count = k.shape[0]
    tangent[:] = 0.0
    T, Np = abs(trial[0]), hinges.squash_loads[0 if trial[0] >= 0.0 else 1]
    share = 0.0
    for i in range(count):
        A, Mp = _moment(hinges, trial, i)
        share = max(share, A / Mp)
    elastic = T / Np + share <= 1.0 or (Np >= T and share <= capacity(T / Np, alpha, beta))
    if elastic:
        stress[0], tangent[0, 0] = trial[0], kN
        for i in range(count):
            stress[i + 1] = trial[i + 1]
            tangent[i + 1, i + 1] = k[i]
        return ELASTIC

    # the end points of the quarter curve
    at_axis = -T * Np / (kN * beta)
    at_apex = (Np - T) * Np / (kN * beta)
    largest = 0.0
    for i in range(count):
        if k[i] == 0.0:
            continue
        A, Mp = _moment(hinges, trial, i)
        largest = max(largest, A / Mp)
        if Mp < A:
            at_axis += (A - Mp) * Mp / (k[i] * alpha)
        at_apex += A * Mp / (k[i] * alpha)
    if (beta == 1.0 and at_axis >= 0.0) or (beta > 1.0 and T == 0.0):
        return _axis_point(hinges, Np, trial, stress, tangent)
    if (alpha == 1.0 and at_apex <= 0.0) or (alpha > 1.0 and largest == 0.0):
        return _apex(hinges, Np, trial, stress, tangent)

    # between them, the point with G(z) = 0
    ea, eb = 2.0 - 2.0 / alpha, 2.0 - 2.0 / beta
    if T == 0.0:
        z = -5.0
    elif largest == 0.0:
        z = 5.0
    else:
        z = first_on_curve(T / Np, largest, alpha, beta)
    low, high, last = -Z_LIMIT, Z_LIMIT, False
    S = C = n = m = Ca = Sb = 0.0
    for _ in range(ITERATIONS):
        S, C = on_curve(z)
        n = S if beta == 1.0 else S ** (1.0 / beta)
        m = C if alpha == 1.0 else C ** (1.0 / alpha)
        Ca, Sb = C / m, S / n  # C^(1 - 1 / alpha) and S^(1 - 1 / beta) without two more powers
        factor = Np / (kN * beta) * Ca
        GA = (Np * n - T) * factor
        size = (Np * n + T) * factor
        slope = 2.0 / beta * Np * n * C * factor - ea * S * GA
        GB = 0.0
        for i in range(count):
            if k[i] == 0.0:
                continue
            A, Mp = _moment(hinges, trial, i)
            factor = Mp / (k[i] * alpha) * Sb
            size += (A + Mp * m) * factor
            if Mp * m < A:
                GB += (A - Mp * m) * factor
                slope += 2.0 / alpha * Mp * m * S * factor
        slope += eb * C * GB
        if last or abs(GA + GB) <= ROUNDING * size:
            break
        z, low, high, last = newton_in_bracket(z, GA + GB, slope, low, high)

    # forces; consistent tangent of rank one along the curve, plus the hinges that stay elastic
    stress[0] = np.copysign(Np * n, trial[0])
    a = 2.0 / beta * Np * Ca
    pa = 0.0 if ea == 0.0 else -2.0 / beta * Np * ea * C ** (1.0 - 2.0 / alpha) * Sb
    H = a * a / kN + (Np * n - T) * pa / kN
    tangent[0, 0] = np.copysign(a, trial[0])
    for i in range(count):
        A, Mp = _moment(hinges, trial, i)
        if k[i] > 0.0 and Mp * m < A:
            stress[i + 1] = np.copysign(Mp * m, trial[i + 1])
            b = -2.0 / alpha * Mp * Sb
            pb = 0.0 if eb == 0.0 else -2.0 / alpha * Mp * eb * S ** (1.0 - 2.0 / beta) * Ca
            H += b * b / k[i] - (A - Mp * m) * pb / k[i]
            tangent[i + 1, 0] = b if trial[i + 1] >= 0.0 else -b
        else:
            stress[i + 1] = trial[i + 1]
    finite = np.isfinite(H) and H > 0.0
    for i in range(count, -1, -1):  # column 0 holds the direction until it is overwritten
        for j in range(i, -1, -1):
            rank_one = tangent[i, 0] * tangent[j, 0] / H if finite else 0.0
            tangent[i, j] = tangent[j, i] = rank_one
    for i in range(count):
        if not (k[i] > 0.0 and abs(stress[i + 1]) < abs(trial[i + 1])):
            tangent[i + 1, i + 1] += k[i]
    return CURVE


@njit(cache=True, error_model="numpy")
def _axis_point(hinges, Np, trial, stress, tangent):
    """N = 0, full plastic moments: corner of the surface (beta = 1) or smooth axis point."""
    k, beta = hinges.rotational_stiffness, hinges.beta
    stress[0] = 0.0
    curvature = 0.0
    for i in range(k.shape[0]):
        A, Mp = _moment(hinges, trial, i)
        if k[i] > 0.0 and Mp < A:
            stress[i + 1] = np.copysign(Mp, trial[i + 1])
            curvature += (A - Mp) * 2.0 * Mp / (hinges.alpha * Np**2 * k[i])
        else:
            stress[i + 1] = trial[i + 1]
            tangent[i + 1, i + 1] = k[i]
    if beta == 1.0:
        return CORNER
    if beta > 2.0:
        tangent[0, 0] = hinges.axial_stiffness
    elif beta == 2.0:
        tangent[0, 0] = 1.0 / (1.0 / hinges.axial_stiffness + curvature)
    return AXIS


@njit(cache=True, error_model="numpy")
def _apex(hinges, Np, trial, stress, tangent):
    """|N| = N_p, no moment: corner of the surface (alpha = 1) or smooth apex."""
    k, alpha = hinges.rotational_stiffness, hinges.alpha
    stress[0] = np.copysign(Np, trial[0])
    for i in range(k.shape[0]):
        stress[i + 1] = 0.0
        _, Mp = _moment(hinges, trial, i)
        if alpha > 2.0:
            tangent[i + 1, i + 1] = k[i]
        elif alpha == 2.0 and k[i] > 0.0:
            kN = hinges.axial_stiffness
            curvature = (abs(trial[0]) - Np) * 2.0 * Np / (hinges.beta * Mp**2 * kN)
            tangent[i + 1, i + 1] = 1.0 / (1.0 / k[i] + curvature)
    return APEX if alpha == 1.0 else SMOOTH_APEX
