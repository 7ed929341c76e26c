"""Closest-point projection onto super-elliptic N-M surfaces (Heng 2017, section 2.2, 2.13-2.19).

One axial spring in series with two rotational springs that share its force: a rigid bar with a
hinge at each end, or one hinge beside a pin. Backward Euler is the unique minimiser of

    (N - N_tr)^2 / 2 k_N + sum_i (M_i - M_tr_i)^2 / 2 k_i
    subject to |M_i| <= M_p m(|N|/N_p),   m(n) = (1 - n^beta)^(1/alpha),

found on the boundary n = S^(1/beta), m = C^(1/alpha), S = sin^2 t, C = cos^2 t, with the
unknown z = ln tan t, which keeps full relative accuracy at both ends of the quarter curve.

**Second part.** Viscoplastic flow of a section under N, M and V: the whole section, or its flanges
and its web.

A body that flows grows with its overstress. With lambda, its plastic work over its static strength,

    size = 1 + R lambda + c (lambda' / D)^(1/q),

and the step of dt of a section under given forces is the least of the energies Psi at which it is
large enough for them, Psi' = phi the increment of lambda. A section that is rigid in shear is one
body, of the size of its gauge g(N, M). One whose web yields in shear is two, which share the plane
section but not the rate: flanges of the size s, and a web of the size (r^2 + (V / V_pl)^2)^(1/2)
of which r is left to carry normal stress. Derivation: docs/theory/strain-rate.md.

Forces are over N_p, M_p and V_pl, energies over N_p and the length.

**Third part.** Bars that flow at a rate and harden point by point: backward Euler as one convex
problem.

N is constant along a bar, V = (M_1 - M_2) / l too, and M linear, M(xi) = (1 - xi) M_1 + xi M_2.
With the energy Psi of the flow of a section a step of dt of a bar with the elastic
deformations E = (e, theta_1, theta_2) before it flows is

    min over S = (N, M_1, M_2) of  S'CS / 2 - E'S + l N_p int Psi(N, M(xi), V) dxi.

Here S is over the strength and energy over N_p l. Derivation: docs/theory/strain-rate.md.
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


MOST = 40  # points of a bar
OF_WEB = MOST // 2  # where the web's lambda begin; there are no more points than that then
BODY = np.dtype(
    [
        ("axial", float),  # share of N_p
        ("moment", float),  # share of M_p
        ("overstress", float),  # c, relative overstress at lambda' = D; 0: no rate
        ("hardening", float),  # R
    ]
)
LAW = np.dtype(
    [
        ("strength", float, 3),  # N_p and twice M_p, N and N m
        ("web_share", float),  # of N_p, below which the neutral axis lies in the web
        ("web_curve", float),  # C of the gauge there, over (M_p / N_p)^2
        ("flange_curve", float),  # elsewhere
        ("flange_moment", float),  # A_g there, over M_p
        ("flange_lever", float),  # y there, over M_p / N_p
        ("reference", float),  # D, 1/s; 0: no rate
        ("exponent", float),  # q
        ("whole", BODY),
        ("shear", float),  # V_pl of a web that yields in shear, N; 0: one body
        ("flanges", BODY),  # of two bodies
        ("web", BODY),
        ("half_web", float),  # half the height of the web, over M_p / N_p
        ("spread", float),  # N_p^2 / 4 b f_y M_p of the flanges
        ("points", int),
        ("place", float, MOST),  # xi
        ("weight", float, MOST),
    ]
)
SMOOTH = 1e-4  # of M_p: the size has a kink at M = 0 where the neutral axis is in a flange
_ITERATIONS = 100
_CLOSE, _NEARLY = 1e-5, 1e-7  # relative steps of Newton, which leave their square


@njit(cache=True, error_model="numpy")
def gauge(law, n, moment, firm=0.0):
    """Gauge g of the whole section; its slopes over n and m; second derivatives nn, nm, mm.

    `firm`: 1 takes the smoothed corner at M = 0 as curved everywhere as at its tip, or less: mm of
    a parabola that lies above it.
    """
    m = (moment * moment + SMOOTH * SMOOTH) ** 0.5
    x = abs(n)
    P, A, C, lever = m, 1.0, law.web_curve, 0.0
    r = (P * P + C * x * x) ** 0.5
    g = 0.5 * (P + r)
    if x > g * law.web_share:
        A, C, lever = law.flange_moment, law.flange_curve, law.flange_lever
        P = m + lever * x
        r = (P * P + C * x * x) ** 0.5
        g = 0.5 * (P + r) / A
    g_m = g / r
    g_x = 0.5 * C * x / (A * r) + lever * g_m
    bend, turn = 0.5 * C / (A * r * r * r), moment / m
    side = 1.0 if n >= 0.0 else -1.0
    smooth = g_m * (1.0 - (1.0 - firm) * turn * turn) / m
    second = bend * m * m, -bend * m * n * turn, bend * x * x * turn * turn + smooth
    return g, (side * g_x, g_m * turn), second


@njit(cache=True, error_model="numpy")
def flange_gauge(law, n, m, r):
    """Size s of the flanges that n, m >= 0 need beside a web of which r carries normal stress.

    Its slopes over n, m, r; its second derivatives are the product of a vector with itself times
    a factor: both.
    """
    web, flanges, k = law.web, law.flanges.moment, n - r * law.web.axial
    if k < 0.0:  # the neutral axis lies in the web
        share, curve = n / r, web.moment / (web.axial * web.axial * flanges)
        s = (m - r * web.moment) / flanges + curve * n * share
        s_r = -web.moment / flanges - curve * share * share
        return s, (2.0 * curve * share, 1.0 / flanges, s_r), 2.0 * curve / r, (1.0, 0.0, -share)
    P = m + law.half_web * k
    root = (P * P + 4.0 * flanges * law.spread * k * k) ** 0.5
    s = 0.5 * (P + root) / flanges
    s_m = s / root
    s_n = 2.0 * law.spread * k / root + law.half_web * s_m
    factor = 2.0 * law.spread / (root * root * root)
    return s, (s_n, s_m, -web.axial * s_n), factor, (-m, k, web.axial * m)


@njit(cache=True, error_model="numpy", forceinline=True)
def _power(z, q):
    """z^q, which for the usual q = 5 takes no logarithm."""
    return (z * z) * (z * z) * z if q == 5.0 else z**q


@njit(cache=True, error_model="numpy")
def _root(law, body, excess, time):
    """The z of phi = D dt z^q (without rate phi = z) at an `excess` of size, and its slope."""
    R, c, q = body.hardening, body.overstress, law.exponent
    if c == 0.0:
        return excess / R, 1.0 / R
    z, slow = excess / c, R * time
    if slow == 0.0:
        return z, 1.0 / c
    if slow * _power(z, q) > excess:
        z = (excess / slow) ** (
            1.0 / q
        )  # the smaller one: from above to the root of a convex function
    for _ in range(_ITERATIONS):
        power = slow * _power(z, q)
        step = (power + c * z - excess) * z / (q * power + c * z)
        z -= step
        if abs(step) <= _NEARLY * z:
            break
    return z, 1.0 / (slow * q * _power(z, q) / z + c)


@njit(cache=True, error_model="numpy")
def flow_at(law, body, excess, time):
    """Increment phi of lambda, its slope and Psi at an `excess` of size; `time`, D dt."""
    if excess <= 0.0:
        return 0.0, 0.0, 0.0
    z, steep = _root(law, body, excess, time)
    R, c, q = body.hardening, body.overstress, law.exponent
    if c == 0.0:
        return z, steep, 0.5 * excess * z
    phi = time * _power(z, q)
    work = phi * (excess - 0.5 * R * phi - c * z * q / (q + 1.0))
    return phi, q * phi / z * steep, work


@njit(cache=True, error_model="numpy")
def _most_of_web(law, n, m, size):
    """The r at which flanges of a `size` suffice."""
    web, flanges = law.web, law.flanges.moment
    left = m - size * flanges
    if left >= 0.0:
        spread = 2.0 * web.moment * n / web.axial
        return 0.5 * (left + (left * left + spread * spread) ** 0.5) / web.moment
    lever = law.half_web * size
    root = (lever * lever - 4.0 * law.spread * size * left) ** 0.5
    return (n - 0.5 * (root - lever) / law.spread) / web.axial


@njit(cache=True, error_model="numpy")
def _normal_share(law, n, m, v, time, sizes, low, short):
    """The r that takes the least energy where flanges and web, of such `sizes` before, both flow.

    Beyond `low`, which costs the web nothing and leaves the flanges too small by `short`. Newton in
    r^(1/q), in which the balance of their powers is nearly linear.
    """
    flanges, web, q = law.flanges, law.web, law.exponent if law.web.overstress > 0.0 else 1.0
    high = max(_most_of_web(law, n, m, sizes[0]), low)  # below it by round-off where flow begins
    r = low + (high - low) * short / (short + max((high * high + v * v) ** 0.5 - sizes[1], 0.0))
    if v > sizes[1]:  # no more than what balances a web that does not yet carry normal stress
        of_flanges, of_web = (
            _root(law, flanges, short, time)[0],
            _root(law, web, v - sizes[1], time)[0],
        )
        pushed = v * flanges.axial / web.axial * -flange_gauge(law, n, m, 0.0)[1][2]
        r = min(r, pushed * _power(of_flanges / of_web, q))
    for _ in range(_ITERATIONS):
        size = (r * r + v * v) ** 0.5
        s, (_, _, s_r), factor, (_, _, along) = flange_gauge(law, n, m, r)
        of_web, web_steep = _root(law, web, max(size - sizes[1], 0.0), time)
        of_flanges, steep = _root(law, flanges, max(s - sizes[0], 0.0), time)
        ratio = (r * web.axial / (size * flanges.axial * -s_r)) ** (1.0 / q)
        balance = ratio * of_web - of_flanges
        bent = (v / size) ** 2 - r * factor * along * along / s_r  # r d(ln ratio^q) / dr
        slope = ratio * (of_web * bent + q * web_steep * r * r / size) - q * r * steep * s_r
        low, high = (r, high) if balance < 0.0 else (low, r)
        new = r * _power(max(1.0 - balance / slope, 0.0), q)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        step, r = abs(new - r), new
        if step <= _CLOSE * r:
            break
    return r


@njit(cache=True, error_model="numpy")
def of_two_bodies(law, n, moment, v, time, sizes, firm=0.0):
    """Increments of lambda of flanges and web; Psi; slopes n, m, v; second nn, nm, mm, nv, mv, vv.

    Arguments: forces; D dt; `sizes` of flanges and web before they flow; `firm` of `gauge`.
    """
    m = (moment * moment + SMOOTH * SMOOTH) ** 0.5
    x, shear, turn, side = abs(n), abs(v), moment / m, 1.0 if n >= 0.0 else -1.0
    free = (max(sizes[1] * sizes[1] - v * v, 0.0)) ** 0.5
    short = flange_gauge(law, x, m, free)[0] - sizes[0]
    if short <= 0.0:  # a web that slides, or nothing
        b, b_steep, work = flow_at(law, law.web, shear - sizes[1], time)
        share = law.web.axial if v >= 0.0 else -law.web.axial
        second = 0.0, 0.0, 0.0, 0.0, 0.0, law.web.axial * b_steep
        return (0.0, b), law.web.axial * work, (0.0, 0.0, share * b), second
    r = _normal_share(law, x, m, shear, time, sizes, free, short)
    s, (s_n, s_m, s_r), factor, (w_n, w_m, w_r) = flange_gauge(law, x, m, r)
    size = (r * r + v * v) ** 0.5
    a, a_steep, work = flow_at(law, law.flanges, s - sizes[0], time)
    b, b_steep, of_web = flow_at(law, law.web, size - sizes[1], time)
    push, steep = law.flanges.axial * a, law.flanges.axial * a_steep
    pull, stiff, bend = law.web.axial * b, law.web.axial * b_steep, push * factor
    corner = push * s_m * (1.0 - (1.0 - firm) * turn * turn) / m
    s_n, w_n, s_m, w_m = side * s_n, side * w_n, turn * s_m, turn * w_m
    c, t = r / size, v / size  # shares of normal and shear stress in the web
    nn, nm = steep * s_n * s_n + bend * w_n * w_n, steep * s_n * s_m + bend * w_n * w_m
    mm = steep * s_m * s_m + bend * w_m * w_m + corner
    vv = stiff * t * t + pull * c * c / size
    nr, mr = steep * s_n * s_r + bend * w_n * w_r, steep * s_m * s_r + bend * w_m * w_r
    vr = (stiff - pull / size) * c * t
    rr = steep * s_r * s_r + bend * w_r * w_r + stiff * c * c + pull * t * t / size
    if rr > 0.0:  # at the r that follows the forces
        nn, nm, mm = nn - nr * nr / rr, nm - nr * mr / rr, mm - mr * mr / rr
        nv, mv, vv = -nr * vr / rr, -mr * vr / rr, vv - vr * vr / rr
    else:
        nv = mv = 0.0
    psi = law.flanges.axial * work + law.web.axial * of_web
    return (a, b), psi, (push * s_n, push * s_m, pull * t), (nn, nm, mm, nv, mv, vv)


_RATE_NEARLY = 1e-7  # of the elastic strain at yield, residual that one more step of Newton removes
_ARMIJO = 1e-4
_ROUNDING = 1e-15  # of the terms of the energy
_RATE_ITERATIONS, _HALVINGS = 100, 40
_SHORT = 0.25  # share of a step


@njit(cache=True, error_model="numpy")
def of_one_body(law, n, m, time, grown, firm):
    """Flow as in `of_two_bodies`, of a section that is rigid in shear and has grown by lambda."""
    g, (g_n, g_m), (nn, nm, mm) = gauge(law, n, m, firm)
    phi, slope, work = flow_at(law, law.whole, g - 1.0 - law.whole.hardening * grown, time)
    nn = slope * g_n * g_n + phi * nn
    nm = slope * g_n * g_m + phi * nm
    mm = slope * g_m * g_m + phi * mm
    return phi, work, (phi * g_n, phi * g_m, 0.0), (nn, nm, mm, 0.0, 0.0, 0.0)


@njit(cache=True, error_model="numpy")
def potential(law, s, time, grown, flow, slant=0.0, firm=0.0):
    """Integral of Psi, its gradient (3), that over V / V_pl, its Hessian 00, 01, 02, 11, 12, 22.

    Arguments: forces over the strength `s`; D dt; lambda at the points, `grown`; `flow`,
    overwritten by their increments; M_p / V_pl l of a web that yields in shear, `slant`; `firm` of
    `gauge`.
    """
    psi = g0 = g1 = g2 = gv = h00 = h01 = h02 = h11 = h12 = h22 = 0.0
    n, one, two = s
    v = slant * (one - two)
    for i in range(law.points):
        xi = law.place[i]
        m = one + xi * (two - one)
        flow[i] = 0.0
        if slant > 0.0:
            flow[OF_WEB + i] = 0.0
        if abs(n) + abs(m) + abs(v) + SMOOTH <= 1.0:
            continue
        if slant > 0.0:
            sizes = (
                1.0 + law.flanges.hardening * grown[i],
                1.0 + law.web.hardening * grown[OF_WEB + i],
            )
            lambdas, work, slopes, second = of_two_bodies(law, n, m, v, time, sizes, firm)
            flow[i], flow[OF_WEB + i] = lambdas
        else:
            flow[i], work, slopes, second = of_one_body(law, n, m, time, grown[i], firm)
        if work == 0.0:
            continue
        w, a, b = law.weight[i], 1.0 - xi, xi
        (d_n, d_m, d_v), (nn, nm, mm, nv, mv, vv) = slopes, second
        nv, mv, vv = slant * nv, slant * mv, slant * slant * vv
        psi += w * work
        gv += w * d_v
        g0 += w * d_n
        g1 += w * (d_m * a + slant * d_v)
        g2 += w * (d_m * b - slant * d_v)
        h00 += w * nn
        h01 += w * (nm * a + nv)
        h02 += w * (nm * b - nv)
        h11 += w * (mm * a * a + 2.0 * mv * a + vv)
        h12 += w * (mm * a * b + mv * (b - a) - vv)
        h22 += w * (mm * b * b - 2.0 * mv * b + vv)
    return psi, (g0, g1, g2), gv, (h00, h01, h02, h11, h12, h22)


@njit(cache=True, error_model="numpy")
def stays_elastic(law, s, slant):
    """Whether no section of a bar flows that has not hardened: its two ends do not."""
    n, one, two = s
    if slant == 0.0:
        return max(gauge(law, n, one)[0], gauge(law, n, two)[0]) <= 1.0
    v = abs(slant * (one - two))
    if v > 1.0:
        return False
    r, m = ((1.0 - v) * (1.0 + v)) ** 0.5, max(abs(one), abs(two))
    return flange_gauge(law, abs(n), (m * m + SMOOTH * SMOOTH) ** 0.5, r)[0] <= 1.0


@njit(cache=True, error_model="numpy", forceinline=True)
def _inverse(a):
    """The inverse of a symmetric matrix of three unknowns: 00, 01, 02, 11, 12, 22."""
    a00, a01, a02, a11, a12, a22 = a
    c00, c01, c02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
    d = 1.0 / (a00 * c00 + a01 * c01 + a02 * c02)
    c11, c12, c22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
    return c00 * d, c01 * d, c02 * d, c11 * d, c12 * d, c22 * d


@njit(cache=True, error_model="numpy", forceinline=True)
def _times(a, x):
    """Product of a symmetric matrix with three numbers."""
    a00, a01, a02, a11, a12, a22 = a
    x0, x1, x2 = x
    return (
        a00 * x0 + a01 * x1 + a02 * x2,
        a01 * x0 + a11 * x1 + a12 * x2,
        a02 * x0 + a12 * x1 + a22 * x2,
    )


@njit(cache=True, error_model="numpy", forceinline=True)
def _dot(x, y):
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


@njit(cache=True, error_model="numpy", forceinline=True)
def _energy(law, C, e, s, time, grown, flow, slant, firm):
    """The minimised energy, the size of its terms, its gradient and Hessian, its slope over V."""
    strain = _times(C, s)
    psi, G, slides, H = potential(law, s, time, grown, flow, slant, firm)
    stored, given = 0.5 * _dot(s, strain), _dot(e, s)
    r = strain[0] - e[0] + G[0], strain[1] - e[1] + G[1], strain[2] - e[2] + G[2]
    A = C[0] + H[0], C[1] + H[1], C[2] + H[2], C[3] + H[3], C[4] + H[4], C[5] + H[5]
    return stored - given + psi, stored + abs(given) + psi, r, A, slides


@njit(cache=True, error_model="numpy")
def _unpin(A, r, pinned):
    """The system without the moments of pins, which stay zero."""
    a00, a01, a02, a11, a12, a22 = A
    r0, r1, r2 = r
    if pinned[0]:
        a01, a11, a12, r1 = 0.0, 1.0, 0.0, 0.0
    if pinned[1]:
        a02, a12, a22, r2 = 0.0, 0.0, 1.0, 0.0
    return (a00, a01, a02, a11, a12, a22), (r0, r1, r2)


@njit(cache=True, error_model="numpy")
def flow_of_bar(law, length, flexibility, pinned, elastic, dt, grown, forces, flow):
    """Forces of a bar after a step of `dt` (s), and how they change with its deformations.

    Arguments: `law`, of LAW; `length` (m); `flexibility` 1/k_N, f_11, f_12, f_22 of hinges, bar and
    web (m/N, rad/(N m)); `pinned` (2,), ends without moment; deformations (m, rad) if the step were
    `elastic`; lambda at the points before it, `grown`; `forces` (N, M_1, M_2), those to begin with,
    overwritten by the result; `flow`, overwritten by the increments of lambda. Result: whether the
    bar flows; the tangent NN, N1, N2, 11, 12, 22; how far its web slides (m). Without a minimum
    forces are NaN.
    """
    Np, Mp = law.strength[0], law.strength[1]
    unit, time = 1.0 / (Np * length), law.reference * dt
    slant = Mp / (law.shear * length) if law.shear > 0.0 else 0.0
    f_n, f11, f12, f22 = flexibility[0], flexibility[1], flexibility[2], flexibility[3]
    nn, nm, mm = unit * Np * Np, unit * Np * Mp, unit * Mp * Mp
    C = nn * f_n, 0.0, 0.0, mm * f11, mm * f12, mm * f22
    e = unit * Np * elastic[0], unit * Mp * elastic[1], unit * Mp * elastic[2]
    C, e = _unpin(C, e, pinned)
    stiff = _inverse(C)
    s, flows, slides = _times(stiff, e), False, 0.0
    done = stays_elastic(law, s, slant)
    if done:
        for i in range(flow.size):
            flow[i] = 0.0
    else:
        s = forces[0] / Np, forces[1] / Mp, forces[2] / Mp
        if not np.isfinite(s[0] + s[1] + s[2]):
            s = 0.0, 0.0, 0.0
        firm = 0.0
        value, terms, r, A, slides = _energy(law, C, e, s, time, grown, flow, slant, firm)
        for _ in range(_RATE_ITERATIONS):
            A, r = _unpin(A, r, pinned)
            stiff = _inverse(A)
            d = _times(stiff, r)
            size = max(abs(r[0]) / C[0], max(abs(r[1]) / C[3], abs(r[2]) / C[5]))
            if size <= _RATE_NEARLY and firm == 0.0:
                s = s[0] - d[0], s[1] - d[1], s[2] - d[2]
                done = True
                break
            start, fall, share, firm = s, _ARMIJO * _dot(r, d), 1.0, 0.0
            allowed = value + _ROUNDING * terms
            for _half in range(_HALVINGS):
                s = start[0] - share * d[0], start[1] - share * d[1], start[2] - share * d[2]
                value, terms, r, A, slides = _energy(law, C, e, s, time, grown, flow, slant, firm)
                if value <= allowed - share * fall:
                    break
                share *= 0.5
                if share <= _SHORT:  # Newton's steps go to and fro over the corner at M = 0
                    firm = 1.0
        for i in range(flow.size):
            flows = flows or flow[i] > 0.0
    if not done:
        s = np.nan, np.nan, np.nan
    forces[0], forces[1], forces[2] = Np * s[0], Mp * s[1], Mp * s[2]
    t00, t01, t02, t11, t12, t22 = stiff
    t11, t22 = 0.0 if pinned[0] else t11, 0.0 if pinned[1] else t22
    tangent = nn * t00, nm * t01, nm * t02, mm * t11, mm * t12, mm * t22
    return flows, tangent, length * Np / law.shear * slides if slant > 0.0 else 0.0
