"""Bars that flow at a rate and harden point by point: backward Euler as one convex problem.

N is constant along a bar, V = (M_1 - M_2) / l too, and M linear, M(xi) = (1 - xi) M_1 + xi M_2.
With the energy Psi of the flow of a section (`flow_kernels`) a step of dt of a bar with the elastic
deformations E = (e, theta_1, theta_2) before it flows is

    min over S = (N, M_1, M_2) of  S'CS / 2 - E'S + l N_p int Psi(N, M(xi), V) dxi.

Here S is over the strength and energy over N_p l. Derivation: docs/theory/strain-rate.md.
"""

import numpy as np

from workbench.base.compiled import njit
from workbench.steel.hinges.flow_kernels import (
    OF_WEB,
    SMOOTH,
    flange_gauge,
    flow_at,
    gauge,
    of_two_bodies,
)

_NEARLY = 1e-7  # of the elastic strain at yield, residual that one more step of Newton removes
_ARMIJO = 1e-4
_ROUNDING = 1e-15  # of the terms of the energy
_ITERATIONS, _HALVINGS = 100, 40
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
