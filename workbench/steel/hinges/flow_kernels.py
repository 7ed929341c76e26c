"""Viscoplastic flow of a section under N, M and V: the whole section, or its flanges and its web.

A body that flows grows with its overstress. With lambda, its plastic work over its static strength,

    size = 1 + R lambda + c (lambda' / D)^(1/q),

and the step of dt of a section under given forces is the least of the energies Psi at which it is
large enough for them, Psi' = phi the increment of lambda. A section that is rigid in shear is one
body, of the size of its gauge g(N, M). One whose web yields in shear is two, which share the plane
section but not the rate: flanges of the size s, and a web of the size (r^2 + (V / V_pl)^2)^(1/2)
of which r is left to carry normal stress. Derivation: docs/theory/strain-rate.md.

Forces are over N_p, M_p and V_pl, energies over N_p and the length.
"""

import numpy as np

from workbench.base.compiled import njit

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
