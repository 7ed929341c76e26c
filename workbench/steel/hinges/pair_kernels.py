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

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.base.compiled import njit
from workbench.steel.hinges import kernels as surface
from workbench.steel.hinges.kernels import APEX, AXIS, CURVE, ELASTIC, capacity

Vector = NDArray[np.float64]

_NO_MOMENT = 1e-14  # of a plastic moment; a trial that is closer to a smooth apex is at it


class Pair(NamedTuple):
    """Two hinges and the bar between them.

    `flexibility` (4,): f_N, f_11, f_14, f_44 (those of a pinned end are not used); `bounds`
    (2, 4) of each hinge: N in tension and in compression, M_h positive and negative, all as
    positive numbers; `exponents` (2, 2): alpha, beta >= 1 of each; `pinned` (2,): ends that
    carry no moment. All may be tuples, of which kernels need no reference counts.
    """

    flexibility: Any
    bounds: Any
    exponents: Any
    pinned: Any


class End(NamedTuple):
    """One hinge for the sign of N at hand: yield surface, flexibility and trial rotation."""

    Np: float
    low: float
    high: float
    alpha: float
    beta: float
    pinned: bool
    f: float
    e: float


@njit(cache=True, error_model="numpy")
def _end(pair, h, e):
    """Hinge 1 (h = 0) or hinge 4 (h = 1) of the pair."""
    bounds, (alpha, beta) = pair.bounds[h], pair.exponents[h]
    Np, low, high = bounds[0 if e[0] >= 0.0 else 1], -bounds[3], bounds[2]
    return End(Np, low, high, alpha, beta, pair.pinned[h], pair.flexibility[1 + 2 * h], e[1 + h])


@njit(cache=True, error_model="numpy")
def _clipped(end, share):
    """Moment, plastic rotation and whether it is at a bound, of one hinge by itself."""
    moment, low, high = end.e / end.f, end.low * share, end.high * share
    if moment > high or moment < low:
        moment = high if moment > high else low
        return moment, end.e - end.f * moment, True
    return moment, 0.0, False


@njit(cache=True, error_model="numpy")
def moments_in_box(one, four, f14, share1, share4):
    """Moments that minimise (e - f M) f^-1 (e - f M) / 2 between bounds; pinned ends carry none.

    The bounds are the `share` of the plastic moments. Result: both moments, the plastic rotations
    r = e - f M, and which moments are at a bound.
    """
    if one.pinned or four.pinned:
        m1, m4, r1, r4, at1, at4 = 0.0, 0.0, 0.0, 0.0, False, False
        if not one.pinned:
            m1, r1, at1 = _clipped(one, share1)
        if not four.pinned:
            m4, r4, at4 = _clipped(four, share4)
        if one.pinned:
            r1 = one.e - f14 * m4
        if four.pinned:
            r4 = four.e - f14 * m1
        return m1, m4, r1, r4, at1, at4
    f11, e1, low1, high1 = one.f, one.e, one.low * share1, one.high * share1
    f44, e4, low4, high4 = four.f, four.e, four.low * share4, four.high * share4
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
    best, m1, m4, r1, r4 = -np.inf, high1, high4, 0.0, 0.0
    for i in range(2):
        for j in range(2):
            b1, b4 = low1 if i else high1, low4 if j else high4
            p1, p4 = e1 - f11 * b1 - f14 * b4, e4 - f14 * b1 - f44 * b4
            outward = min(-p1 if i else p1, -p4 if j else p4)
            if outward > best:
                best, m1, m4, r1, r4 = outward, b1, b4, p1, p4
    return m1, m4, r1, r4, True, True


@njit(cache=True, error_model="numpy")
def _moment_block(f11, f14, f44, fixed1, fixed4, tangent):
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
def _slope(end, r, N, power, rest, m):
    """|d(M_p m)/dN| of a hinge, and the ratio of the second derivative to it, times N.

    `power` is n^beta, `rest` is 1 - n^beta, `m` its capacity; the sign of `r` chooses M_p.
    """
    bound = end.high if r > 0.0 else -end.low
    slope = bound * end.beta / end.alpha * power * m / (rest * N)
    return slope, (end.beta - 1.0) + (1.0 - 1.0 / end.alpha) * end.beta * power / rest


@njit(cache=True, error_model="numpy")
def _push_at_axis(end, M, r):
    """Push of a hinge at its plastic moment at N = 0, and its curvature there."""
    slope = abs(M) / (end.alpha * end.Np)
    push = slope * abs(r) if end.beta == 1.0 else 0.0
    if end.beta < 2.0:
        return push, np.inf
    return push, 2.0 * slope / end.Np * abs(r) if end.beta == 2.0 else 0.0


@njit(cache=True, error_model="numpy")
def _at_axis(pair, one, four, e, forces, tangent, flow):
    """N = 0 with full plastic moments, if the minimiser is there."""
    f_n, f11, f14, f44 = pair.flexibility
    m1, m4, r1, r4, at1, at4 = moments_in_box(one, four, f14, 1.0, 1.0)
    push1, curvature1 = _push_at_axis(one, m1, r1) if at1 else (0.0, 0.0)
    push4, curvature4 = _push_at_axis(four, m4, r4) if at4 else (0.0, 0.0)
    pushed = push1 + push4
    if pushed < abs(e[0]):
        return False
    forces[0], forces[1], forces[2] = 0.0, m1, m4
    _moment_block(f11, f14, f44, at1 or one.pinned, at4 or four.pinned, tangent)
    tangent[0, 0] = 1.0 / (f_n + (curvature1 + curvature4))
    share = push1 / pushed if pushed > 0.0 else 0.5
    flow[0], flow[1], flow[2], flow[3] = share * e[0], r1, (1.0 - share) * e[0], r4
    return True


@njit(cache=True, error_model="numpy")
def _push_at_apex(end, N, m, r, at):
    """At N = N_p of the weaker hinge: whether this one is admitted, what it pushes on N.

    Further whether its moment is fixed.
    """
    if end.pinned or not at:
        return True, 0.0, end.pinned
    if end.Np > N:
        power = (N / end.Np) ** end.beta
        slope, _ = _slope(end, r, N, power, 1.0 - power, m)
        return True, slope * abs(r), True
    bound = end.high if r > 0.0 else -end.low
    if end.alpha == 1.0:
        return True, bound * end.beta / N * abs(r), True
    return abs(r) <= _NO_MOMENT * end.f * bound, 0.0, False


@njit(cache=True, error_model="numpy")
def _softening(end, N, total):
    """Flexibility that the curvature of the surface adds at a smooth apex (inf: M is fixed)."""
    if end.pinned or end.Np > N or end.alpha > 2.0:
        return 0.0
    if end.alpha < 2.0:
        return np.inf
    return total * 2.0 * N / (end.beta * min(end.high, -end.low) ** 2)


@njit(cache=True, error_model="numpy")
def _at_apex(pair, one, four, e, forces, tangent, flow):
    """|N| = N_p of the weaker hinge, if the minimiser is there."""
    f_n, f11, f14, f44 = pair.flexibility
    N = min(one.Np, four.Np)
    c1, c4 = capacity(N / one.Np, one.alpha, one.beta), capacity(N / four.Np, four.alpha, four.beta)
    m1, m4, r1, r4, at1, at4 = moments_in_box(one, four, f14, c1, c4)
    total = abs(e[0]) - f_n * N
    admits1, push1, fixed1 = _push_at_apex(one, N, c1, r1, at1)
    admits4, push4, fixed4 = _push_at_apex(four, N, c4, r4, at4)
    left = total - push1 - push4
    if not (admits1 and admits4 and left >= 0.0):
        return False
    forces[0], forces[1], forces[2] = math.copysign(N, e[0]), m1, m4
    soft1, soft4 = _softening(one, N, total), _softening(four, N, total)
    fixed1, fixed4 = fixed1 or soft1 == np.inf, fixed4 or soft4 == np.inf
    _moment_block(f11 + soft1, f14, f44 + soft4, fixed1, fixed4, tangent)
    # only the sum is determined when both hinges are at the apex: the rest is shared equally
    share = 0.5 if one.Np == four.Np else (1.0 if one.Np < four.Np else 0.0)
    flow[0] = math.copysign(push1 + share * left, e[0])
    flow[2] = math.copysign(push4 + (1.0 - share) * left, e[0])
    flow[1], flow[3] = r1, r4
    return True


@njit(cache=True, error_model="numpy")
def project_pair(pair, e, forces, tangent, flow):
    """Project elastic trial deformations of two hinges and a bar onto both yield surfaces.

    Elastic trial deformations `e` (3,): elongation (m), end rotations. Writes `forces` (3,):
    N, M_1, M_4; `tangent` (3, 3), their derivative by `e`, symmetric and positive semi-definite;
    `flow` (4,): increments of plastic elongation and rotation of hinge 1, then of hinge 4 (the
    whole rotation of a pin). Returns the branch.
    """
    f_n, f11, f14, f44 = pair.flexibility
    one, four = _end(pair, 0, e), _end(pair, 1, e)
    tangent[:] = 0.0
    eN = abs(e[0])
    T = eN / f_n
    if not max(T / one.Np, T / four.Np) > 1.0:
        c1, c4 = 1.0 - T / one.Np, 1.0 - T / four.Np  # what a straight surface has, without powers
        for exact in (False, True):
            if exact:
                c1 = capacity(T / one.Np, one.alpha, one.beta)
                c4 = capacity(T / four.Np, four.alpha, four.beta)
            m1, m4, r1, r4, at1, at4 = moments_in_box(one, four, f14, c1, c4)
            if not (at1 or at4):
                forces[0], forces[1], forces[2] = e[0] / f_n, m1, m4
                tangent[0, 0] = 1.0 / f_n
                _moment_block(f11, f14, f44, one.pinned, four.pinned, tangent)
                flow[0], flow[1], flow[2], flow[3] = 0.0, r1, 0.0, r4
                return ELASTIC
    if _at_axis(pair, one, four, e, forces, tangent, flow):
        return AXIS
    if f_n * min(one.Np, four.Np) < eN and _at_apex(pair, one, four, e, forces, tangent, flow):
        return APEX

    # the weaker hinge leads; of two equal ones the one whose capacity drops more steeply
    leads1 = one.Np < four.Np or (one.Np == four.Np and one.alpha >= four.alpha)
    a, b = (one, four) if leads1 else (four, one)
    alike = a.Np == b.Np and a.beta == b.beta
    ratio = math.log(a.Np / b.Np)
    steep = 1.0 - 1.0 / a.alpha

    m1, m4, r1, r4, at1, at4 = moments_in_box(one, four, f14, np.inf, np.inf)
    largest1 = m1 / (one.high if m1 > 0.0 else one.low)
    largest4 = m4 / (four.high if m4 > 0.0 else four.low)
    z = surface.first_on_curve(T / a.Np, max(largest1, largest4), a.alpha, a.beta)
    if not math.isfinite(z):
        z = 5.0
    low, high, last = -surface.Z_LIMIT, surface.Z_LIMIT, False
    N = kappa = d1 = d4 = push1 = push4 = H = 0.0
    for _ in range(surface.ITERATIONS):
        S, C = surface.on_curve(z)
        log_n = (math.log1p(-C) if C < 0.5 else math.log(S)) / a.beta
        N = a.Np * math.exp(log_n)
        Sb, Cb = S, C
        if not alike:
            Sb = math.exp(b.beta * (log_n + ratio))
            Cb = -math.expm1(b.beta * (log_n + ratio))
        S1, C1, S4, C4 = (S, C, Sb, Cb) if leads1 else (Sb, Cb, S, C)
        c1 = C1 if one.alpha == 1.0 else C1 ** (1.0 / one.alpha)
        c4 = C4 if four.alpha == 1.0 else C4 ** (1.0 / four.alpha)
        m1, m4, r1, r4, at1, at4 = moments_in_box(one, four, f14, c1, c4)
        kappa = 1.0 if steep == 0.0 else C**steep
        # G = kappa (f_N N - e_N + sum |b_h'| |r_h|); its slope H kappa^2 in N, scaled likewise
        slope1, curve1 = _slope(one, r1, N, S1, C1, c1) if at1 else (0.0, 0.0)
        slope4, curve4 = _slope(four, r4, N, S4, C4, c4) if at4 else (0.0, 0.0)
        d1, d4 = kappa * slope1, kappa * slope4
        push1, push4 = d1 * abs(r1), d4 * abs(r4)
        G = kappa * (f_n * N - eN) + push1 + push4
        size = kappa * (f_n * N + eN)
        size += d1 * (abs(one.e) + f11 * abs(m1) + abs(f14 * m4))
        size += d4 * (abs(four.e) + f44 * abs(m4) + abs(f14 * m1))
        bend = push1 * curve1 / N + push4 * curve4 / N
        d1, d4 = -math.copysign(d1, r1), -math.copysign(d4, r4)
        if at1 and at4:
            square = f11 * d1 * d1 + 2.0 * f14 * d1 * d4 + f44 * d4 * d4
        elif at1:
            square = (f11 if four.pinned else f11 - f14 * f14 / f44) * d1 * d1
        else:
            square = (f44 if one.pinned else f44 - f14 * f14 / f11) * d4 * d4
        H = kappa * kappa * f_n + kappa * bend + square
        if last or abs(G) <= surface.ROUNDING * size:
            break
        dG = 2.0 / a.beta * N * C * (kappa * f_n + bend + square / kappa) - 2.0 * steep * S * G
        z, low, high, last = surface.newton_in_bracket(z, G, dG, low, high)

    # tangent: rank one along the curve, plus the moments that stay elastic
    fixed1, fixed4 = at1 or one.pinned, at4 or four.pinned
    _moment_block(f11, f14, f44, fixed1, fixed4, tangent)
    along = (
        math.copysign(kappa, e[0]),
        d1 if fixed1 else -f14 * d4 / f11,
        d4 if fixed4 else -f14 * d1 / f44,
    )
    if H > 0.0 and math.isfinite(H):
        for i in range(3):
            for j in range(3):
                tangent[i, j] += along[i] * along[j] / H
    forces[0], forces[1], forces[2] = math.copysign(N, e[0]), m1, m4
    total = eN - f_n * N
    share = push1 / (push1 + push4) if push1 + push4 > 0.0 else 0.5
    flow[0] = math.copysign(share * total, e[0])
    flow[2] = math.copysign(total, e[0]) - flow[0]
    flow[1], flow[3] = r1, r4
    return CURVE
