"""Bars that flow at a rate and harden point by point: backward Euler as one convex problem.

N is constant along a bar and M linear, M(xi) = (1 - xi) M_1 + xi M_2. The gauge g(N, M) of a
section is the factor by which its exact N-M envelope must grow to pass through (N, M). With the
plastic deformation lambda, work over the squash load and the length, a section that flows obeys

    g = 1 + R lambda + c (lambda' / D)^(1/q),     (e', kappa') = N_p lambda' grad g,

and a step of dt of a bar with the elastic deformations E = (e, theta_1, theta_2) before it flows is

    min over S = (N, M_1, M_2) of  S'CS / 2 - E'S + l N_p int Psi(g - 1 - R lambda_n) dxi,

Psi' = phi the increment of lambda. Here S is over the strength and energy over N_p l. Derivation:
docs/theory/strain-rate.md.
"""

import numpy as np

from workbench.compiled import njit

MOST = 40  # points of a bar
LAW = np.dtype(
    [
        ("strength", float, 3),  # N_p and twice M_p, N and N m
        ("web_share", float),  # of N_p, below which the neutral axis lies in the web
        ("web_curve", float),  # C of the gauge there, over (M_p / N_p)^2
        ("flange_curve", float),  # elsewhere
        ("flange_moment", float),  # A_g there, over M_p
        ("flange_lever", float),  # y there, over M_p / N_p
        ("overstress", float),  # c, relative overstress of the section at lambda' = D
        ("reference", float),  # D, 1/s; 0: no rate
        ("exponent", float),  # q
        ("hardening", float),  # R
        ("points", int),
        ("place", float, MOST),  # xi
        ("weight", float, MOST),
    ]
)
_SMOOTH = 1e-4  # of M_p: the gauge has a kink at M = 0 where the neutral axis is in a flange
_NEARLY = 1e-9  # of the elastic strain at yield, residual that one more step of Newton removes
_ARMIJO = 1e-4
_ROUNDING = 1e-15  # of the terms of the energy
_ITERATIONS, _HALVINGS = 100, 40
_SHORT = 0.25  # share of a step


@njit(cache=True, error_model="numpy")
def gauge(law, n, moment, firm=0.0):
    """Gauge g at N/N_p and M/M_p; its slopes over both; second derivatives nn, nm, mm.

    `firm`: 1 takes the smoothed corner at M = 0 as curved everywhere as at its tip, or less: mm of
    a parabola that lies above it.
    """
    m = (moment * moment + _SMOOTH * _SMOOTH) ** 0.5
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
def flow_at(law, excess, time):
    """Increment phi of lambda, its slope and Psi at an `excess` x > 0; `time`, D dt."""
    R, c, q = law.hardening, law.overstress, law.exponent
    if law.reference == 0.0:
        return excess / R, 1.0 / R, 0.5 * excess * excess / R
    z = excess / c
    if R == 0.0:
        phi = time * z**q
        return phi, q * phi / excess, excess * phi / (q + 1.0)
    z = min(z, (excess / (R * time)) ** (1.0 / q))  # rises to the root of a convex function
    power = z**q
    for _ in range(_ITERATIONS):
        over = R * time * power + c * z - excess
        step = over * z / (R * time * q * power + c * z)
        z -= step
        power = z**q
        if abs(step) <= 1e-14 * z:
            break
    phi, steep = time * power, time * q * power / z
    return phi, steep / (R * steep + c), phi * (excess - 0.5 * R * phi - c * z * q / (q + 1.0))


@njit(cache=True, error_model="numpy")
def potential(law, s, time, grown, flow, firm=0.0):
    """Integral of Psi, its gradient (3) and its Hessian 00, 01, 02, 11, 12, 22; writes `flow`.

    Arguments: forces over the strength `s`; D dt; lambda at the points, `grown`; `firm` of `gauge`.
    """
    psi = g0 = g1 = g2 = h00 = h01 = h02 = h11 = h12 = h22 = 0.0
    n, one, two = s
    for i in range(law.points):
        xi = law.place[i]
        m = one + xi * (two - one)
        flow[i] = 0.0
        if abs(n) + abs(m) + _SMOOTH <= 1.0:
            continue
        g, (g_n, g_m), (nn, nm, mm) = gauge(law, n, m, firm)
        excess = g - 1.0 - law.hardening * grown[i]
        if excess <= 0.0:
            continue
        phi, slope, work = flow_at(law, excess, time)
        flow[i] = phi
        w, a, b = law.weight[i], 1.0 - xi, xi
        psi += w * work
        g0 += w * phi * g_n
        g1 += w * phi * g_m * a
        g2 += w * phi * g_m * b
        nn = slope * g_n * g_n + phi * nn
        nm = slope * g_n * g_m + phi * nm
        mm = slope * g_m * g_m + phi * mm
        h00 += w * nn
        h01 += w * nm * a
        h02 += w * nm * b
        h11 += w * mm * a * a
        h12 += w * mm * a * b
        h22 += w * mm * b * b
    return psi, (g0, g1, g2), (h00, h01, h02, h11, h12, h22)


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
def _energy(law, C, e, s, time, grown, flow, firm):
    """The minimised energy at `s`, the size of its terms, its gradient and its Hessian."""
    strain = _times(C, s)
    psi, G, H = potential(law, s, time, grown, flow, firm)
    stored, given = 0.5 * _dot(s, strain), _dot(e, s)
    r = strain[0] - e[0] + G[0], strain[1] - e[1] + G[1], strain[2] - e[2] + G[2]
    A = C[0] + H[0], C[1] + H[1], C[2] + H[2], C[3] + H[3], C[4] + H[4], C[5] + H[5]
    return stored - given + psi, stored + abs(given) + psi, r, A


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

    Arguments: `law`, of LAW; `length` (m); `flexibility` 1/k_N, f_11, f_12, f_22 (m/N, rad/(N m));
    `pinned` (2,), ends without moment; deformations (m, rad) if the step were `elastic`; lambda at
    the points before it, `grown`; `forces` (N, M_1, M_2), those to begin with, overwritten by the
    result; `flow`, overwritten by the increments of lambda. Result: whether the bar flows; the
    tangent NN, N1, N2, 11, 12, 22. Without a minimum forces are NaN.
    """
    Np, Mp = law.strength[0], law.strength[1]
    unit, time = 1.0 / (Np * length), law.reference * dt
    f_n, f11, f12, f22 = flexibility[0], flexibility[1], flexibility[2], flexibility[3]
    nn, nm, mm = unit * Np * Np, unit * Np * Mp, unit * Mp * Mp
    C = nn * f_n, 0.0, 0.0, mm * f11, mm * f12, mm * f22
    e = unit * Np * elastic[0], unit * Mp * elastic[1], unit * Mp * elastic[2]
    C, e = _unpin(C, e, pinned)
    stiff = _inverse(C)
    s, flows = _times(stiff, e), False
    done = max(gauge(law, s[0], s[1])[0], gauge(law, s[0], s[2])[0]) <= 1.0
    if done:
        for i in range(law.points):
            flow[i] = 0.0
    else:
        s = forces[0] / Np, forces[1] / Mp, forces[2] / Mp
        if not np.isfinite(s[0] + s[1] + s[2]):
            s = 0.0, 0.0, 0.0
        firm = 0.0
        value, terms, r, A = _energy(law, C, e, s, time, grown, flow, firm)
        for _ in range(_ITERATIONS):
            A, r = _unpin(A, r, pinned)
            stiff = _inverse(A)
            d = _times(stiff, r)
            size = max(abs(r[0]) / C[0], max(abs(r[1]) / C[3], abs(r[2]) / C[5]))
            if size <= _NEARLY and firm == 0.0:
                s = s[0] - d[0], s[1] - d[1], s[2] - d[2]
                done = True
                break
            start, fall, share, firm = s, _ARMIJO * _dot(r, d), 1.0, 0.0
            allowed = value + _ROUNDING * terms
            for _half in range(_HALVINGS):
                s = start[0] - share * d[0], start[1] - share * d[1], start[2] - share * d[2]
                value, terms, r, A = _energy(law, C, e, s, time, grown, flow, firm)
                if value <= allowed - share * fall:
                    break
                share *= 0.5
                if share <= _SHORT:  # Newton's steps go to and fro over the corner at M = 0
                    firm = 1.0
        for i in range(law.points):
            flows = flows or flow[i] > 0.0
    if not done:
        s = np.nan, np.nan, np.nan
    forces[0], forces[1], forces[2] = Np * s[0], Mp * s[1], Mp * s[2]
    t00, t01, t02, t11, t12, t22 = stiff
    t11, t22 = 0.0 if pinned[0] else t11, 0.0 if pinned[1] else t22
    return flows, (nn * t00, nm * t01, nm * t02, mm * t11, mm * t12, mm * t22)
