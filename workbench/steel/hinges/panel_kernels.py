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
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.base.compiled import njit
from workbench.steel.hinges.kernels import newton_in_bracket
from workbench.steel.hinges.pair_kernels import End, moments_in_box

Vector = NDArray[np.float64]
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
        ("solid", np.uint8),  # a solid rectangle, all web: `solid_capacity`
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


class Point(NamedTuple):
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

    With the strain rate (e + eta) and the shear rate g sqrt(3) over the height, -1 <= eta <= 1, the
    von Mises stresses integrate in elliptic coordinates e = cosh mu cos nu, g = sinh mu sin nu to
    n = cos nu, v = q s(mu) and m = q^2 t(mu), q^2 = 1 - n^2, with s = L sinh mu,
    t = cosh mu - s sinh mu. Of C = M_pl t(s) q^2 all derivatives follow from dt/ds = -2 sinh mu.
    """
    Np, Mp = web.web_axial, web.web_moment
    n, v = min(N / Np, 1.0 - 1e-15), np.sqrt(max(1.0 - rho * rho, 0.0))
    q2 = 1.0 - n * n
    s = min(v / np.sqrt(q2), 1.0 - 1e-12)
    mu, L = strain_ratio(s)
    sinh, cosh = np.sinh(mu), np.cosh(mu)
    t = np.exp(-mu) + sinh * (1.0 - s)
    ds = max(cosh * L - 1.0, 1e-30)  # ds / dmu
    CN, Cr = -2.0 * Mp / Np * n * cosh, 2.0 * Mp * rho / L
    CNN = -2.0 * Mp / Np**2 * (cosh + n * n * sinh * s / (q2 * ds))
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
def _end(panel, h, e):
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
    """The `Point` (N >= 0, a, d) for deformations e_N >= 0, e_1, e_4."""
    f_n, f11, f14, f44 = panel.flexibility
    rho, sine = np.cos(a), np.sin(a)
    C, CN, Cr, CNN, CNr, Crr = moment_capacity(panel.web, N, rho)
    Ca, CNa, Caa = -sine * Cr, -sine * CNr, sine * sine * Crr - rho * Cr
    one, four = _end(panel, 0, e[1] - d), _end(panel, 1, e[2] - d)
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
    return Point((C, CN, Ca), (m1, m4), (r1, r4), slopes, block, shear, residual, hessian)


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
