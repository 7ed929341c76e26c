"""Closest-point projection of a panel: two hinges and the bar between, whose web yields in shear.

Uniform shear stress in the web, none in the flanges, von Mises (a solid rectangle: one shear rate,
exactly): |M_i| <= M_c(|N|, rho) at both
ends, |V| <= V_pl, with V = V_pl sin a, rho = cos a what shear leaves of the web, which has no
infinite slope at V = V_pl. Normal force and shear force are constant along the panel and the
moment is linear, so that every section is a convex combination of the two ends: no other
condition is needed. Rotations e - d of the ends and the sliding displacement l d share the
angle d of the panel; backward Euler is the unique minimiser over (N, V, M_1, M_4) of the
complementary energy less the work on the deformations (e_N, l d, e_1 - d, e_4 - d).

Here d is given; `panel_elements` finds it from the equilibrium of the panel.

**Second part.** Closest-point projection of two hinges in series with a bar (Heng 2017, papers III
and IV).

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
from workbench.steel.hinges.kernels import APEX, AXIS, CURVE, ELASTIC, capacity, newton_in_bracket

Vector = NDArray[np.float64]

_NO_MOMENT = 1e-14  # of a plastic moment; a trial that is closer to a smooth apex is at it


class HingePair(NamedTuple):
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


LIMIT = 0.5 * np.pi
SMALLEST = 1e-9  # mu of a section without shear


WEB = np.dtype(
    [
        ("stiffness", float),  # elastic, of the web against shear, G A_w, N
        ("shear", float),  # V_pl, N
        ("web_axial", float),  # N_w, N
        ("web_moment", float),  # M_w, N m
        ("flange_axial", float),  # N_f
        ("flange_moment", float),  # M_f
        ("half_web", float),  # half the height of the web, m
        ("half_height", float),  # half that of the section
        ("flanges", float),  # force per depth of both sides of the flanges, 2 b f_y, N/m
        ("solid", np.uint8),  # a solid rectangle beside a core, `flange_axial`: `solid_capacity`
    ]
)


class Panel(NamedTuple):
    """Elasticity and strength of a panel.

    `flexibility` (4,): f_N, f_11, f_14, f_44 of bending and stretching; `pinned` (2,): ends that
    carry no moment; `length` (m); `web`, a record of WEB. The first two may be tuples.
    """

    flexibility: Any
    pinned: Any
    length: float
    web: Any


class PanelPoint(NamedTuple):
    """Response of a panel at (N, a, d).

    `capacity` C, C_N, C_a; `moments` of both ends and their plastic `rotations`; `slopes` p of the
    moments with C; `block` B_11, B_14, B_44, their stiffness at fixed C; `shear` V, dV/da;
    `residual` of the minimum over N and a and of the equilibrium; `hessian` J_NN, J_Na, J_aa.
    """

    capacity: tuple[float, float, float]
    moments: tuple[float, float]
    rotations: tuple[float, float]
    slopes: tuple[float, float]
    block: tuple[float, float, float]
    shear: tuple[float, float]
    residual: tuple[float, float, float]
    hessian: tuple[float, float, float]


@njit(cache=True, error_model="numpy")
def strain_ratio(s):
    """The mu and L = ln coth(mu / 2) of a shear s = L sinh(mu), 0 <= s < 1."""
    mu, low, high, last = 0.5 * s, 0.0, 20.0, False
    for _ in range(60):
        L = np.log1p(2.0 / np.expm1(max(mu, SMALLEST)))
        if last:
            break
        slope = np.cosh(mu) * L - 1.0
        mu, low, high, last = newton_in_bracket(mu, np.sinh(mu) * L - s, slope, low, high)
    return max(mu, SMALLEST), L


@njit(cache=True, error_model="numpy")
def solid_capacity(web, N, rho):
    """`moment_capacity` of a solid rectangle with one shear rate and plane sections.

    A core on its axis takes what it can of N first, and carries no moment.

    With the strain rate (e + eta) and the shear rate g sqrt(3) over the height, -1 <= eta <= 1, the
    von Mises stresses integrate in elliptic coordinates e = cosh mu cos nu, g = sinh mu sin nu to
    n = cos nu, v = q s(mu) and m = q^2 t(mu), q^2 = 1 - n^2, with s = L sinh mu,
    t = cosh mu - s sinh mu. Of C = M_pl t(s) q^2 all derivatives follow from dt/ds = -2 sinh mu.
    """
    Np, Mp = web.web_axial, web.web_moment
    n, v = min(max(N - web.flange_axial, 0.0) / Np, 1.0 - 1e-15), np.sqrt(max(1.0 - rho * rho, 0.0))
    q2 = 1.0 - n * n
    s = min(v / np.sqrt(q2), 1.0 - 1e-12)
    mu, L = strain_ratio(s)
    sinh, cosh = np.sinh(mu), np.cosh(mu)
    t = np.exp(-mu) + sinh * (1.0 - s)
    ds = max(cosh * L - 1.0, 1e-30)  # ds / dmu
    CN, Cr = -2.0 * Mp / Np * n * cosh, 2.0 * Mp * rho / L
    CNN = -2.0 * Mp / Np**2 * (cosh + n * n * sinh * s / (q2 * ds))
    if web.flange_axial > N:  # the core takes all of it
        CNN = 0.0
    CNr = 2.0 * Mp / Np * n * rho / (q2 * L * ds)
    Crr = 2.0 * Mp * (1.0 / L - rho * rho / (L**3 * sinh * sinh * q2 * ds))
    return Mp * q2 * t, CN, Cr, CNN, CNr, Crr


@njit(cache=True, error_model="numpy")
def moment_capacity(web, N, rho):
    """M_c and its derivatives (C, C_N, C_r, C_NN, C_Nr, C_rr) for N, rho >= 0."""
    if web.solid:
        return solid_capacity(web, N, rho)
    limit, Nw = rho * web.web_axial, web.web_axial
    if limit > N or (N == 0.0 and rho > 0.0):
        share, Mw = N / limit, web.web_moment
        C = web.flange_moment + rho * Mw * (1.0 - share * share)
        CN, Cr = -2.0 * Mw * share / Nw, Mw * (1.0 + share * share)
        CNN, CNr = -2.0 * Mw / (Nw * limit), 2.0 * Mw * share / limit
        return C, CN, Cr, CNN, CNr, -2.0 * Mw * share * share / rho
    c = web.flanges
    y = web.half_web + (N - limit) / c
    return 0.5 * c * (web.half_height**2 - y * y), -y, y * Nw, -1.0 / c, Nw / c, -Nw * Nw / c


@njit(cache=True, error_model="numpy")
def utilisation(web, length, forces, used):
    """Write how far both ends (n, 2) of panels of a `length` (m) are used by forces (n, 3).

    Forces are N, M_1, M_4. Largest of |V| / V_pl, |N| over what V leaves and |M| over what both
    leave; 1: yields.
    """
    for i in range(forces.shape[0]):
        N = abs(forces[i, 0])
        share = min(abs(forces[i, 1] + forces[i, 2]) / (length * web.shear), 1.0)
        rho = ((1.0 - share) * (1.0 + share)) ** 0.5
        top = web.flange_axial + rho * web.web_axial
        capacity = moment_capacity(web, min(N, top), rho)[0]
        for j in range(2):
            bent = abs(forces[i, 1 + j]) / capacity if capacity > 0.0 else 1.0
            used[i, j] = max(bent, max(N / top, share))


@njit(cache=True, error_model="numpy")
def _panel_end(panel, h, e):
    """End h of the panel with its rotation, as `moments_in_box` takes it."""
    return End(0.0, -1.0, 1.0, 1.0, 1.0, panel.pinned[h], panel.flexibility[1 + 2 * h], e)


@njit(cache=True, error_model="numpy")
def elastic(panel):
    """Elastic stiffness B_11, B_14, B_44 of the moments."""
    _, f11, f14, f44 = panel.flexibility
    if panel.pinned[0] or panel.pinned[1]:
        return 0.0 if panel.pinned[0] else 1.0 / f11, 0.0, 0.0 if panel.pinned[1] else 1.0 / f44
    determinant = f11 * f44 - f14 * f14
    return f44 / determinant, -f14 / determinant, f11 / determinant


@njit(cache=True, error_model="numpy")
def point(panel, e, N, a, d):
    """The `PanelPoint` (N >= 0, a, d) for deformations e_N >= 0, e_1, e_4."""
    f_n, f11, f14, f44 = panel.flexibility
    rho, sine = np.cos(a), np.sin(a)
    C, CN, Cr, CNN, CNr, Crr = moment_capacity(panel.web, N, rho)
    Ca, CNa, Caa = -sine * Cr, -sine * CNr, sine * sine * Crr - rho * Cr
    one, four = _panel_end(panel, 0, e[1] - d), _panel_end(panel, 1, e[2] - d)
    m1, m4, r1, r4, at1, at4 = moments_in_box(one, four, f14, C, C)
    s1, s4 = (1.0 if r1 >= 0.0 else -1.0), (1.0 if r4 >= 0.0 else -1.0)
    p1 = p4 = Q = B11 = B14 = B44 = 0.0
    if at1 and at4:
        p1, p4, Q = s1, s4, f11 + f44 + 2.0 * s1 * s4 * f14
    elif at1:
        p1, Q = s1, f11
        if not four.pinned:
            p4, Q, B44 = -s1 * f14 / f44, f11 - f14 * f14 / f44, 1.0 / f44
    elif at4:
        p4, Q = s4, f44
        if not one.pinned:
            p1, Q, B11 = -s4 * f14 / f11, f44 - f14 * f14 / f11, 1.0 / f11
    else:
        B11, B14, B44 = elastic(panel)
    r1, r4 = (r1 if at1 else 0.0), (r4 if at4 else 0.0)
    push = abs(r1) + abs(r4)
    V, Va = panel.web.shear * sine, panel.web.shear * rho
    soft = panel.length / panel.web.stiffness
    over = soft * V - panel.length * d  # minus the plastic sliding
    gN, ga = f_n * N - e[0] - push * CN, over * Va - push * Ca
    gd = V * panel.length - m1 - m4
    JNN, JNa = f_n + Q * CN * CN - push * CNN, Q * CN * Ca - push * CNa
    Jaa = soft * Va * Va - over * V + Q * Ca * Ca - push * Caa
    residual, hessian, block = (gN, ga, gd), (JNN, JNa, Jaa), (B11, B14, B44)
    slopes, shear = (p1, p4), (V, Va)
    return PanelPoint((C, CN, Ca), (m1, m4), (r1, r4), slopes, block, shear, residual, hessian)


@njit(cache=True, error_model="numpy")
def _least_axial(panel, e, a, d, N):
    """N that minimises at given a and d; whether it is the apex N_f + rho N_w without moment."""
    top = panel.web.flange_axial + np.cos(a) * panel.web.web_axial
    low, high = 0.0, min(e[0] / panel.flexibility[0], top)
    if high == top and point(panel, e, top, a, d).residual[0] <= 0.0:
        return top, True
    N, last = min(max(N, low), high), False
    for _ in range(100):
        at = point(panel, e, N, a, d)
        g, slope = at.residual[0], at.hessian[0] * top
        if last or g == 0.0:
            break
        N, low, high, last = newton_in_bracket(N / top, g, slope, low / top, high / top)
        N, low, high = N * top, low * top, high * top
    return N, False


@njit(cache=True, error_model="numpy")
def inside(web, N, a):
    """Whether N and a are where both forces and the capacity are defined and smooth."""
    top = web.flange_axial + np.cos(a) * web.web_axial
    return 0.0 <= N < top and abs(a) < LIMIT


@njit(cache=True, error_model="numpy")
def slides_back(web, V, a, d):
    """Whether a web would slide against its shear force: then the point is no minimum."""
    return (V - web.stiffness * d) * a > 1e-12 * web.shear


@njit(cache=True, error_model="numpy")
def _least(panel, e, d, N, a):
    """(N, a, at the apex) that minimise at given d: by Newton, or a in a bracket, N inside."""
    top, start = panel.web.flange_axial + panel.web.web_axial, (N, a)
    for _ in range(12):
        at = point(panel, e, N, a, d)
        (JNN, JNa, Jaa), (gN, ga, _) = at.hessian, at.residual
        det = JNN * Jaa - JNa * JNa
        dN, da = (JNa * ga - Jaa * gN) / det, (JNa * gN - JNN * ga) / det
        if not (det > 0.0 and inside(panel.web, N + dN, a + da)):
            break
        N, a = N + dN, a + da
        if abs(dN) <= 1e-13 * top and abs(da) <= 1e-13:
            if slides_back(panel.web, panel.web.shear * np.sin(a), a, d):
                break
            return N, a, False
    N, a = start
    slide, sign = panel.length * d, 1.0 if d >= 0.0 else -1.0
    low, high = 0.0, np.arcsin(min(1.0, panel.web.stiffness * abs(d) / panel.web.shear))
    guess, a, last, apex = min(abs(a), high), high, False, False
    for i in range(200):
        N, apex = _least_axial(panel, e, sign * a, d, N)
        at = point(panel, e, N, sign * a, d)
        (JNN, JNa, Jaa), (V, Va) = at.hessian, at.shear
        slope, bend = sign * at.residual[1], Jaa - JNa * JNa / JNN
        if apex:  # along its ridge there are no moments
            slope = sign * (panel.length * V / panel.web.stiffness - slide) * Va
            slope -= panel.web.web_axial * np.sin(a) * (panel.flexibility[0] * N - e[0])
            bend = -1.0
        if last or (i == 0 and slope <= 0.0):
            break
        if i == 0:
            a = guess if 0.0 < guess < high else 0.5 * high
        else:
            a, low, high, last = newton_in_bracket(a, slope, bend, low, high)
    return N, sign * a, apex


@njit(cache=True, error_model="numpy")
def project_panel(panel, e, forces, tangent):
    """Nearest admissible forces at a given sliding displacement; their consistent tangent.

    `e` (4,): elongation, sliding displacement, rotations of both ends, less what is plastic.
    Writes `forces` (4,): N, V, M_1, M_4, which also are where the search begins, and `tangent`
    (4, 4), their derivatives by `e`.
    """
    d = e[1] / panel.length
    size = (abs(e[0]), e[2] + d, e[3] + d)
    a = np.arcsin(min(max(forces[1] / panel.web.shear, -1.0), 1.0))
    N, a, apex = _least(panel, size, d, min(abs(forces[0]), size[0] / panel.flexibility[0]), a)
    at, sign = point(panel, size, N, a, d), 1.0 if e[0] >= 0.0 else -1.0
    (V, Va), (_, CN, Ca), (JNN, JNa, Jaa) = at.shear, at.capacity, at.hessian
    forces[0], forces[1], forces[2], forces[3] = sign * N, V, at.moments[0], at.moments[1]
    if apex:  # along the ridge N = N_f + rho N_w, without moments
        along = (-sign * panel.web.web_axial * np.sin(a), Va, 0.0, 0.0)
        soft, f_n = panel.length / panel.web.stiffness, panel.flexibility[0]
        bend = f_n * along[0] ** 2 - (f_n * N - size[0]) * panel.web.web_axial * np.cos(a)
        bend += soft * Va * Va - (soft * V - e[1]) * V
        for i in range(4):
            for j in range(4):
                tangent[i, j] = along[i] * along[j] / bend if bend > 0.0 else 0.0
        return
    det = JNN * Jaa - JNa * JNa
    p, (B11, B14, B44) = (0.0, 0.0, at.slopes[0], at.slopes[1]), at.block
    tangent[:] = 0.0
    tangent[2, 2], tangent[2, 3], tangent[3, 2], tangent[3, 3] = B11, B14, B14, B44
    for j in range(4):
        x = sign if j == 0 else p[j] * CN
        y = Va if j == 1 else p[j] * Ca
        dN, da = x / JNN, 0.0
        if det > 0.0:  # else V is at its bound and stays there
            dN, da = (Jaa * x - JNa * y) / det, (JNN * y - JNa * x) / det
        tangent[0, j] += sign * dN
        tangent[1, j] += Va * da
        for i in range(2, 4):
            tangent[i, j] += p[i] * (CN * dN + Ca * da)
