"""Closest-point projection onto super-elliptic N-M surfaces (Heng 2017, section 2.2, 2.13-2.19).

One axial spring in series with two rotational springs that share its force: a rigid bar with a
hinge at each end, or one hinge beside a pin. Backward Euler is the unique minimiser of

    (N - N_tr)^2 / 2 k_N + sum_i (M_i - M_tr_i)^2 / 2 k_i
    subject to |M_i| <= M_p m(|N|/N_p),   m(n) = (1 - n^beta)^(1/alpha),

found on the boundary n = S^(1/beta), m = C^(1/alpha), S = sin^2 t, C = cos^2 t, with the
unknown z = ln tan t, which keeps full relative accuracy at both ends of the quarter curve.
"""

import math

import numpy as np

from workbench.base.compiled import njit

ELASTIC, CURVE, CORNER, APEX, SMOOTH_APEX, AXIS = 0, 1, 2, 3, 4, 5
ITERATIONS = 200
ROUNDING = 4e-16  # of the sum of the terms of G, taken without their signs
Z_LIMIT = 340.0
ANYWHERE = 0.0  # no z to start from
_LINEAR = 2e-8  # a step of z whose square is below round-off


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
def project(stiffness, bounds, exponents, trial, start):
    """Project trial forces onto the yield surface.

    `stiffness` (k_N, k_1, k_2) in N/m and N m/rad, zero of a pin; `bounds` of N in tension and
    compression, of M positive and negative, all as positive numbers; `exponents` (alpha, beta) of
    at least 1; elastic `trial` (N, M_1, M_2), zero at a pin; `start`, z of a trial nearby or
    `ANYWHERE`.
    Result: branch; forces; consistent tangent (NN, N1, N2, 11, 12, 22); z. All are numbers in
    tuples: tables cost more than the rest.
    """
    (kN, k1, k2), (N, M1, M2), (alpha, beta) = stiffness, trial, exponents
    T, Np = abs(N), bounds[0] if N >= 0.0 else bounds[1]
    A1, Mp1 = abs(M1), bounds[2] if M1 >= 0.0 else bounds[3]
    A2, Mp2 = abs(M2), bounds[2] if M2 >= 0.0 else bounds[3]
    largest = max(A1 / Mp1, A2 / Mp2)
    if T / Np + largest <= 1.0 or (Np >= T and largest <= capacity(T / Np, alpha, beta)):
        return ELASTIC, trial, (kN, 0.0, 0.0, k1, 0.0, k2), start

    # the end points of the quarter curve
    cN = Np / (kN * beta)
    c1 = Mp1 / (k1 * alpha) if k1 > 0.0 else 0.0
    c2 = Mp2 / (k2 * alpha) if k2 > 0.0 else 0.0
    at_axis = max(A1 - Mp1, 0.0) * c1 + max(A2 - Mp2, 0.0) * c2 - T * cN
    at_apex = A1 * c1 + A2 * c2 + (Np - T) * cN
    if (beta == 1.0 and at_axis >= 0.0) or (beta > 1.0 and T == 0.0):
        curvature = 2.0 / Np**2 * (max(A1 - Mp1, 0.0) * c1 + max(A2 - Mp2, 0.0) * c2)
        return _axis_point(stiffness, (Mp1, Mp2), beta, trial, curvature)
    if (alpha == 1.0 and at_apex <= 0.0) or (alpha > 1.0 and largest == 0.0):
        excess = (T - Np) * 2.0 * cN
        return _apex(stiffness, math.copysign(Np, N), alpha, excess / Mp1**2, excess / Mp2**2)

    # between them, the point with G(z) = 0
    ea, eb = 2.0 - 2.0 / alpha, 2.0 - 2.0 / beta
    z = start
    if not 0.0 < abs(z) < Z_LIMIT:
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
        GA = (Np * n - T) * cN * Ca
        over1, over2 = max(A1 - Mp1 * m, 0.0) * c1 * Sb, max(A2 - Mp2 * m, 0.0) * c2 * Sb
        G = GA + over1 + over2
        size = (Np * n + T) * cN * Ca + ((A1 + Mp1 * m) * c1 + (A2 + Mp2 * m) * c2) * Sb
        if last or abs(G) <= ROUNDING * size:
            break
        steep = (Mp1 * c1 if over1 > 0.0 else 0.0) + (Mp2 * c2 if over2 > 0.0 else 0.0)
        slope = 2.0 / beta * Np * n * C * cN * Ca - ea * S * GA
        slope += 2.0 / alpha * m * S * Sb * steep + eb * C * (over1 + over2)
        new, low, high, last = newton_in_bracket(z, G, slope, low, high)
        dz, z = new - z, new
        if abs(dz) <= _LINEAR:  # all follow linearly
            n, m = n * (1.0 + 2.0 / beta * C * dz), m * (1.0 - 2.0 / alpha * S * dz)
            S, C = S * (1.0 + 2.0 * C * dz), C * (1.0 - 2.0 * S * dz)
            Ca, Sb = C / m, S / n
            break

    # forces; consistent tangent of rank one along the curve, plus the hinges that stay elastic
    a = 2.0 / beta * Np * Ca
    pa = 0.0 if ea == 0.0 else -2.0 / beta * Np * ea * C ** (1.0 - 2.0 / alpha) * Sb
    pb = 0.0 if eb == 0.0 else -2.0 / alpha * eb * S ** (1.0 - 2.0 / beta) * Ca
    H = (a * a + (Np * n - T) * pa) / kN
    M1, b1, k1, h1 = _at_yield(M1, k1, Mp1, m, -2.0 / alpha * Sb, pb)
    M2, b2, k2, h2 = _at_yield(M2, k2, Mp2, m, -2.0 / alpha * Sb, pb)
    H, a = H + h1 + h2, math.copysign(a, N)
    r = 1.0 / H if np.isfinite(H) and H > 0.0 else 0.0
    tangent = a * a * r, a * b1 * r, a * b2 * r, b1 * b1 * r + k1, b1 * b2 * r, b2 * b2 * r + k2
    return CURVE, (math.copysign(Np * n, N), M1, M2), tangent, z


@njit(cache=True, error_model="numpy")
def _at_yield(M, k, Mp, m, along, bend):
    """A hinge at the capacity `m`: its moment, dM along the curve, what stays elastic of its k.

    And what it adds to the curvature H of the minimised energy.
    """
    over = abs(M) - Mp * m
    if not over > 0.0:
        return M, 0.0, k, 0.0
    b = Mp * along
    return math.copysign(Mp * m, M), math.copysign(b, -M), 0.0, (b * b - over * Mp * bend) / k


@njit(cache=True, error_model="numpy")
def _axis_point(stiffness, plastic_moments, beta, trial, curvature):
    """N = 0, full plastic moments: corner of the surface (beta = 1) or smooth axis point."""
    (kN, k1, k2), (_, M1, M2), (Mp1, Mp2) = stiffness, trial, plastic_moments
    if Mp1 < abs(M1):
        M1, k1 = math.copysign(Mp1, M1), 0.0
    if Mp2 < abs(M2):
        M2, k2 = math.copysign(Mp2, M2), 0.0
    axial = 0.0
    if beta > 2.0:
        axial = kN
    elif beta == 2.0:
        axial = 1.0 / (1.0 / kN + curvature)
    branch = CORNER if beta == 1.0 else AXIS
    return branch, (0.0, M1, M2), (axial, 0.0, 0.0, k1, 0.0, k2), ANYWHERE


@njit(cache=True, error_model="numpy")
def _apex(stiffness, N, alpha, curvature1, curvature2):
    """|N| = N_p, no moment: corner of the surface (alpha = 1) or smooth apex."""
    _, k1, k2 = stiffness
    if alpha < 2.0:
        k1 = k2 = 0.0
    elif alpha == 2.0:
        k1, k2 = k1 / (1.0 + k1 * curvature1), k2 / (1.0 + k2 * curvature2)
    branch = APEX if alpha == 1.0 else SMOOTH_APEX
    return branch, (N, 0.0, 0.0), (0.0, 0.0, 0.0, k1, 0.0, k2), ANYWHERE
