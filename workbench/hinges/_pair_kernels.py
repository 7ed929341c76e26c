"""Closest-point projection of two hinges in series with a bar (Heng 2017, papers III and IV).

Both hinges share the axial force N; each has its own end moment. With the elastic flexibility

    F = [f_N, 0, 0; 0, f_11, f_14; 0, f_14, f_44]

of hinges and bar together, backward Euler in both hinges plus equilibrium inside the element is
the unique minimiser of (Q - Q_tr) F (Q - Q_tr) / 2 over the forces Q = (N, M_1, M_4) that both
surfaces admit: |M_h| <= M_p,h m_h(|N| / N_p,h), m_h(n) = (1 - n^beta_h)^(1/alpha_h).

At a given N the moments solve a quadratic problem in a box, in closed form. What is left is
convex in N alone, so that a bracketed Newton iteration finds it however far away the trial is.
The unknown is z = ln tan t with n^beta = sin^2 t at the weaker hinge in axial force, which
keeps full relative accuracy at both ends of its curve.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.hinges._kernels import APEX, AXIS, CURVE, ELASTIC, capacity

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_Z_LIMIT = 340.0
_ITERATIONS = 200
_ROUNDING = 4e-16
_NO_MOMENT = 1e-14  # of a plastic moment; a trial that is closer to a smooth apex is at it


@njit(cache=True, error_model="numpy")
def moments_in_box(
    f11: float,
    f14: float,
    f44: float,
    e1: float,
    e4: float,
    low1: float,
    high1: float,
    low4: float,
    high4: float,
    pin1: bool,
    pin4: bool,
) -> tuple[float, float, float, float, bool, bool]:
    """Moments that minimise (e - f M) f^-1 (e - f M) / 2 between bounds; pinned ends carry none.

    Arguments: flexibility; elastic trial rotations; bounds. Result: both moments, the plastic
    rotations r = e - f M, and which moments are at a bound.
    """
    if pin1 or pin4:
        m1, m4, r1, r4, at1, at4 = 0.0, 0.0, 0.0, 0.0, False, False
        if not pin1:
            m1 = e1 / f11
            if m1 > high1 or m1 < low1:
                m1, at1 = (high1 if m1 > high1 else low1), True
                r1 = e1 - f11 * m1
        if not pin4:
            m4 = e4 / f44
            if m4 > high4 or m4 < low4:
                m4, at4 = (high4 if m4 > high4 else low4), True
                r4 = e4 - f44 * m4
        if pin1:
            r1 = e1 - f14 * m4
        if pin4:
            r4 = e4 - f14 * m1
        return m1, m4, r1, r4, at1, at4
    determinant = f11 * f44 - f14 * f14
    t1 = (f44 * e1 - f14 * e4) / determinant
    t4 = (f11 * e4 - f14 * e1) / determinant
    out1 = t1 > high1 or t1 < low1
    out4 = t4 > high4 or t4 < low4
    if not (out1 or out4):
        return t1, t4, 0.0, 0.0, False, False
    if out1:
        m1 = high1 if t1 > high1 else low1
        m4 = (e4 - f14 * m1) / f44
        if low4 <= m4 <= high4:
            return m1, m4, e1 - f11 * m1 - f14 * m4, 0.0, True, False
    if out4:
        m4 = high4 if t4 > high4 else low4
        m1 = (e1 - f14 * m4) / f11
        if low1 <= m1 <= high1:
            return m1, m4, 0.0, e4 - f14 * m1 - f44 * m4, False, True
    # both at a bound: the corner whose plastic rotations point outwards
    best = -np.inf
    m1, m4, r1, r4 = high1, high4, 0.0, 0.0
    for i in range(2):
        for j in range(2):
            b1 = high1 if i == 0 else low1
            b4 = high4 if j == 0 else low4
            p1 = e1 - f11 * b1 - f14 * b4
            p4 = e4 - f14 * b1 - f44 * b4
            outward = min(p1 if i == 0 else -p1, p4 if j == 0 else -p4)
            if outward > best:
                best, m1, m4, r1, r4 = outward, b1, b4, p1, p4
    return m1, m4, r1, r4, True, True


@njit(cache=True, error_model="numpy")
def _moment_block(
    f11: float, f14: float, f44: float, fixed1: bool, fixed4: bool, tangent: Matrix
) -> None:
    """Write the tangent of the moments that are not fixed while N is."""
    if not (fixed1 or fixed4):
        determinant = f11 * f44 - f14 * f14
        tangent[1, 1] = f44 / determinant
        tangent[2, 2] = f11 / determinant
        tangent[1, 2] = tangent[2, 1] = -f14 / determinant
    elif not fixed1:
        tangent[1, 1] = 1.0 / f11
    elif not fixed4:
        tangent[2, 2] = 1.0 / f44


@njit(cache=True, error_model="numpy")
def _slope(
    bound: float, alpha: float, beta: float, force: float, power: float, rest: float, m: float
) -> tuple[float, float]:
    """|d(M_p m)/dN| and the ratio of the second derivative to it, times N.

    `power` is n^beta, `rest` is 1 - n^beta, `m` its capacity.
    """
    slope = bound * beta / alpha * power * m / (rest * force)
    return slope, (beta - 1.0) + (1.0 - 1.0 / alpha) * beta * power / rest


@njit(cache=True, error_model="numpy")
def _at_axis(
    flexibility: Vector,
    e: Vector,
    squash: tuple[float, float],
    bounds: Matrix,
    exponents: Matrix,
    pin1: bool,
    pin4: bool,
    forces: Vector,
    tangent: Matrix,
    flow: Vector,
) -> bool:
    """N = 0 with full plastic moments, if the minimiser is there."""
    f_n, f11, f14, f44 = flexibility
    m1, m4, r1, r4, at1, at4 = moments_in_box(
        f11, f14, f44, e[1], e[2],
        -bounds[0, 3], bounds[0, 2], -bounds[1, 3], bounds[1, 2], pin1, pin4,
    )  # fmt: skip
    push1 = push4 = 0.0
    curvature = 0.0
    for h in range(2):
        at, r, m = (at1, r1, m1) if h == 0 else (at4, r4, m4)
        if not at:
            continue
        alpha, beta = exponents[h]
        slope = abs(m) / (alpha * squash[h])
        if beta == 1.0:
            if h == 0:
                push1 = slope * abs(r)
            else:
                push4 = slope * abs(r)
        if beta < 2.0:
            curvature = np.inf
        elif beta == 2.0:
            curvature += 2.0 * slope / squash[h] * abs(r)
    pushed = push1 + push4
    if pushed < abs(e[0]):
        return False
    forces[0], forces[1], forces[2] = 0.0, m1, m4
    _moment_block(f11, f14, f44, at1 or pin1, at4 or pin4, tangent)
    tangent[0, 0] = 1.0 / (f_n + curvature)
    share = push1 / pushed if pushed > 0.0 else 0.5
    flow[0], flow[1], flow[2], flow[3] = share * e[0], r1, (1.0 - share) * e[0], r4
    return True


@njit(cache=True, error_model="numpy")
def _at_apex(
    flexibility: Vector,
    e: Vector,
    squash: tuple[float, float],
    bounds: Matrix,
    exponents: Matrix,
    pin1: bool,
    pin4: bool,
    forces: Vector,
    tangent: Matrix,
    flow: Vector,
) -> bool:
    """|N| = N_p of the weaker hinge, if the minimiser is there."""
    f_n, f11, f14, f44 = flexibility
    N = min(squash[0], squash[1])
    m1 = 0.0 if pin1 else capacity(N / squash[0], exponents[0, 0], exponents[0, 1])
    m4 = 0.0 if pin4 else capacity(N / squash[1], exponents[1, 0], exponents[1, 1])
    M1, M4, r1, r4, at1, at4 = moments_in_box(
        f11, f14, f44, e[1], e[2],
        -bounds[0, 3] * m1, bounds[0, 2] * m1, -bounds[1, 3] * m4, bounds[1, 2] * m4, pin1, pin4,
    )  # fmt: skip
    total = abs(e[0]) - f_n * N
    left = total
    slope1 = slope4 = 0.0
    for h in range(2):
        pin, at, r = (pin1, at1, r1) if h == 0 else (pin4, at4, r4)
        if pin or not at:
            continue
        alpha, beta = exponents[h]
        bound = bounds[h, 2] if r > 0.0 else bounds[h, 3]
        if squash[h] > N:
            power = (N / squash[h]) ** beta
            m = m1 if h == 0 else m4
            slope, _ = _slope(bound, alpha, beta, N, power, 1.0 - power, m)
        elif alpha == 1.0:
            slope = bound * beta / N
        elif abs(r) <= _NO_MOMENT * (f11 if h == 0 else f44) * bound:
            slope = 0.0
            if h == 0:
                at1 = False
            else:
                at4 = False
        else:
            return False
        if h == 0:
            slope1 = slope * abs(r)
        else:
            slope4 = slope * abs(r)
        left -= slope * abs(r)
    if not left >= 0.0:
        return False
    forces[0], forces[1], forces[2] = math.copysign(N, e[0]), M1, M4
    # smooth apexes: the curvature of the surface there adds to the flexibility of the moment
    soft1 = soft4 = 0.0
    fixed1, fixed4 = at1 or pin1, at4 or pin4
    for h in range(2):
        if squash[h] > N or (pin1 if h == 0 else pin4):
            continue
        alpha, beta = exponents[h]
        soft = 0.0
        if alpha == 2.0:
            soft = total * 2.0 * N / (beta * min(bounds[h, 2], bounds[h, 3]) ** 2)
        if h == 0:
            fixed1, soft1 = fixed1 or alpha < 2.0, soft
        else:
            fixed4, soft4 = fixed4 or alpha < 2.0, soft
    _moment_block(f11 + soft1, f14, f44 + soft4, fixed1, fixed4, tangent)
    # only the sum is determined when both hinges are at the apex: the rest is shared equally
    share = 0.5 if squash[0] == squash[1] else (1.0 if squash[0] < squash[1] else 0.0)
    flow[0] = math.copysign(slope1 + share * left, e[0])
    flow[2] = math.copysign(slope4 + (1.0 - share) * left, e[0])
    flow[1], flow[3] = r1, r4
    return True


@njit(cache=True, error_model="numpy")
def project_pair(
    flexibility: Vector,
    e: Vector,
    bounds: Matrix,
    exponents: Matrix,
    pinned: NDArray[np.bool_],
    forces: Vector,
    tangent: Matrix,
    flow: Vector,
) -> int:
    """Project elastic trial deformations of two hinges and a bar onto both yield surfaces.

    Arguments: `flexibility` (4,): f_N, f_11, f_14, f_44 (those of a pinned end are not used);
    elastic trial deformations `e` (3,): elongation (m), end rotations; `bounds` (2, 4) of each
    hinge: N in tension and in compression, M_h positive and negative, all as positive numbers;
    `exponents` (2, 2): alpha, beta >= 1 of each; `pinned` (2,): ends that carry no moment.
    Writes `forces` (3,): N, M_1, M_4; `tangent` (3, 3), their derivative by `e`, symmetric and
    positive semi-definite; `flow` (4,): increments of plastic elongation and rotation of hinge 1,
    then of hinge 4 (the whole rotation of a pin). Returns the branch.
    """
    f_n, f11, f14, f44 = flexibility
    pin1, pin4 = pinned[0], pinned[1]
    for i in range(3):
        for j in range(3):
            tangent[i, j] = 0.0
    side = 0 if e[0] >= 0.0 else 1
    Np1, Np4 = bounds[0, side], bounds[1, side]
    alpha1, beta1 = exponents[0]
    alpha4, beta4 = exponents[1]
    high1, low1, high4, low4 = bounds[0, 2], bounds[0, 3], bounds[1, 2], bounds[1, 3]

    # elastic
    T = abs(e[0]) / f_n
    if not max(T / Np1, T / Np4) > 1.0:
        c1, c4 = capacity(T / Np1, alpha1, beta1), capacity(T / Np4, alpha4, beta4)
        m1, m4, r1, r4, at1, at4 = moments_in_box(
            f11, f14, f44, e[1], e[2],
            -low1 * c1, high1 * c1, -low4 * c4, high4 * c4, pin1, pin4,
        )  # fmt: skip
        if not (at1 or at4):
            forces[0], forces[1], forces[2] = e[0] / f_n, m1, m4
            tangent[0, 0] = 1.0 / f_n
            _moment_block(f11, f14, f44, pin1, pin4, tangent)
            flow[0], flow[1], flow[2], flow[3] = 0.0, r1, 0.0, r4
            return ELASTIC

    squash = (Np1, Np4)
    if _at_axis(flexibility, e, squash, bounds, exponents, pin1, pin4, forces, tangent, flow):
        return AXIS
    if f_n * min(Np1, Np4) < abs(e[0]) and _at_apex(
        flexibility, e, squash, bounds, exponents, pin1, pin4, forces, tangent, flow
    ):
        return APEX

    # the weaker hinge leads; of two equal ones the one whose capacity drops more steeply
    leads1 = Np1 < Np4 or (Np1 == Np4 and alpha1 >= alpha4)
    Na, beta_a, alpha_a = (Np1, beta1, alpha1) if leads1 else (Np4, beta4, alpha4)
    Nb, beta_b = (Np4, beta4) if leads1 else (Np1, beta1)
    alike = Na == Nb and beta_a == beta_b
    ratio = math.log(Na / Nb)
    steep = 1.0 - 1.0 / alpha_a
    eN = abs(e[0])

    m1, m4, r1, r4, at1, at4 = moments_in_box(
        f11, f14, f44, e[1], e[2], -np.inf, np.inf, -np.inf, np.inf, pin1, pin4
    )
    largest = max(
        m1 / high1 if m1 > 0.0 else -m1 / low1,
        m4 / high4 if m4 > 0.0 else -m4 / low4,
    )
    z = 0.5 * (beta_a * math.log(T / Na) - alpha_a * math.log(largest))
    z = min(max(z, -300.0), 300.0)
    if not math.isfinite(z):
        z = 5.0
    low, high = -_Z_LIMIT, _Z_LIMIT
    last = False
    N = kappa = d1 = d4 = H = 0.0
    for _ in range(_ITERATIONS):
        w = math.exp(-2.0 * abs(z))
        big = 1.0 / (1.0 + w)
        S, C = (big, w * big) if z >= 0.0 else (w * big, big)
        log_n = (math.log1p(-C) if C < 0.5 else math.log(S)) / beta_a
        N = Na * math.exp(log_n)
        Sb, Cb = S, C
        if not alike:
            Sb = math.exp(beta_b * (log_n + ratio))
            Cb = -math.expm1(beta_b * (log_n + ratio))
        S1, C1, S4, C4 = (S, C, Sb, Cb) if leads1 else (Sb, Cb, S, C)
        c1 = C1 if alpha1 == 1.0 else C1 ** (1.0 / alpha1)
        c4 = C4 if alpha4 == 1.0 else C4 ** (1.0 / alpha4)
        m1, m4, r1, r4, at1, at4 = moments_in_box(
            f11, f14, f44, e[1], e[2],
            -low1 * c1, high1 * c1, -low4 * c4, high4 * c4, pin1, pin4,
        )  # fmt: skip
        kappa = 1.0 if steep == 0.0 else C**steep
        # G = kappa (f_N N - e_N + sum |b_h'| |r_h|); its slope H kappa^2 in N, scaled likewise
        axial = kappa * (f_n * N - eN)
        size = kappa * (f_n * N + eN)
        G = axial
        d1 = d4 = 0.0
        bend = 0.0
        if at1:
            slope, curve = _slope(high1 if r1 > 0.0 else low1, alpha1, beta1, N, S1, C1, c1)
            d1 = kappa * slope
            G += d1 * abs(r1)
            size += d1 * (abs(e[1]) + f11 * abs(m1) + abs(f14 * m4))
            bend += d1 * abs(r1) * curve / N
            d1 = -math.copysign(d1, r1)
        if at4:
            slope, curve = _slope(high4 if r4 > 0.0 else low4, alpha4, beta4, N, S4, C4, c4)
            d4 = kappa * slope
            G += d4 * abs(r4)
            size += d4 * (abs(e[2]) + f44 * abs(m4) + abs(f14 * m1))
            bend += d4 * abs(r4) * curve / N
            d4 = -math.copysign(d4, r4)
        if at1 and at4:
            square = f11 * d1 * d1 + 2.0 * f14 * d1 * d4 + f44 * d4 * d4
        elif at1:
            square = (f11 if pin4 else f11 - f14 * f14 / f44) * d1 * d1
        else:
            square = (f44 if pin1 else f44 - f14 * f14 / f11) * d4 * d4
        H = kappa * kappa * f_n + kappa * bend + square
        if last or abs(G) <= _ROUNDING * size:
            break
        if G < 0.0:
            low = z
        else:
            high = z
        dG = 2.0 / beta_a * N * C * (kappa * f_n + bend + square / kappa) - 2.0 * steep * S * G
        new = z - G / dG if dG > 0.0 else low - 1.0
        if not (low < new < high):
            new = 0.5 * (low + high)
        small = 2e-16 * max(1.0, abs(z))
        last = abs(new - z) <= small or high - low <= small
        z = new

    forces[0], forces[1], forces[2] = math.copysign(N, e[0]), m1, m4
    # rank one along the curve, plus the moments that stay elastic
    _moment_block(f11, f14, f44, at1 or pin1, at4 or pin4, tangent)
    x0 = math.copysign(kappa, e[0])
    x1, x4 = d1, d4
    if not (at1 or pin1):
        x1 = -f14 * d4 / f11
    if not (at4 or pin4):
        x4 = -f14 * d1 / f44
    if H > 0.0 and math.isfinite(H):
        tangent[0, 0] = x0 * x0 / H
        tangent[0, 1] = tangent[1, 0] = x0 * x1 / H
        tangent[0, 2] = tangent[2, 0] = x0 * x4 / H
        tangent[1, 1] += x1 * x1 / H
        tangent[2, 2] += x4 * x4 / H
        tangent[1, 2] = tangent[2, 1] = tangent[1, 2] + x1 * x4 / H
    total = eN - f_n * N
    push1, push4 = abs(d1 * r1), abs(d4 * r4)
    share = push1 / (push1 + push4) if push1 + push4 > 0.0 else 0.5
    flow[0] = math.copysign(share * total, e[0])
    flow[2] = math.copysign(total, e[0]) - flow[0]
    flow[1], flow[3] = r1, r4
    return CURVE
