"""Closest-point projection onto super-elliptic N-M yield surfaces (Heng 2017, eqs 2.12-2.19).

One axial spring in series with any number of rotational springs that share its force: one
hinge, or a rigid bar with a hinge at each end. Backward Euler is the unique minimiser of

    (N - N_tr)^2 / 2 k_N + sum_i (M_i - M_tr_i)^2 / 2 k_i
    subject to |M_i| <= M_p m(|N|/N_p),   m(n) = (1 - n^beta)^(1/alpha),

found on the boundary n = S^(1/beta), m = C^(1/alpha), S = sin^2 t, C = cos^2 t, with the
unknown z = ln tan t, which keeps full relative accuracy at both ends of the quarter curve.
"""

from __future__ import annotations

import numpy as np
from numba import njit

ELASTIC, CURVE, CORNER, APEX, SMOOTH_APEX, AXIS = 0, 1, 2, 3, 4, 5
_EPS = 2.220446049250313e-16
_Z_LIMIT = 340.0


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
def _on_curve(z):
    """sin^2 t and cos^2 t for z = ln tan t."""
    w = np.exp(-2.0 * abs(z))
    big = 1.0 / (1.0 + w)
    if z >= 0.0:
        return big, w * big
    return w * big, big


@njit(cache=True, error_model="numpy")
def project(k_axial, k_rotation, squash, moment, alpha, beta, trial, stress, tangent):
    """Project trial forces onto the yield surface; write forces and consistent tangent.

    `k_axial` (N/m); `k_rotation` (hinges,) (N m/rad), zero for a hinge that carries no moment;
    `squash` (2,) axial bounds in tension and compression (N); `moment` (hinges, 2) moment
    bounds for positive and negative moment (N m); exponents `alpha`, `beta` >= 1;
    `trial` (1 + hinges,) elastic trial N and M_i. Writes `stress` (1 + hinges,) and `tangent`
    (1 + hinges, 1 + hinges); returns the branch.
    """
    hinges = k_rotation.shape[0]
    size = hinges + 1
    for i in range(size):
        for j in range(size):
            tangent[i, j] = 0.0
    T = abs(trial[0])
    Np = squash[0] if trial[0] >= 0.0 else squash[1]

    # 1. elastic
    cap = capacity(T / Np, alpha, beta)
    elastic = Np >= T
    for i in range(hinges):
        Mp = moment[i, 0] if trial[i + 1] >= 0.0 else moment[i, 1]
        if abs(trial[i + 1]) > Mp * cap:
            elastic = False
    if elastic:
        stress[0] = trial[0]
        tangent[0, 0] = k_axial
        for i in range(hinges):
            stress[i + 1] = trial[i + 1]
            tangent[i + 1, i + 1] = k_rotation[i]
        return ELASTIC

    # 4. end points of the quarter curve
    at_axis = -T * Np / (k_axial * beta)
    at_apex = (Np - T) * Np / (k_axial * beta)
    largest = 0.0
    for i in range(hinges):
        if k_rotation[i] == 0.0:
            continue
        A = abs(trial[i + 1])
        Mp = moment[i, 0] if trial[i + 1] >= 0.0 else moment[i, 1]
        largest = max(largest, A / Mp)
        if Mp < A:
            at_axis += (A - Mp) * Mp / (k_rotation[i] * alpha)
        at_apex += A * Mp / (k_rotation[i] * alpha)
    if (beta == 1.0 and at_axis >= 0.0) or (beta > 1.0 and T == 0.0):
        return _axis_point(k_axial, k_rotation, Np, moment, alpha, beta, trial, stress, tangent)
    if (alpha == 1.0 and at_apex <= 0.0) or (alpha > 1.0 and largest == 0.0):
        return _apex(k_axial, k_rotation, Np, moment, alpha, beta, trial, stress, tangent)

    # 3., 5. bracketed Newton on G(z) = 0
    ea, eb = 2.0 - 2.0 / alpha, 2.0 - 2.0 / beta
    if T == 0.0:
        z = -5.0
    elif largest == 0.0:
        z = 5.0
    else:
        z = 0.5 * (beta * np.log(T / Np) - alpha * np.log(largest))
        z = min(max(z, -300.0), 300.0)
    low, high = -_Z_LIMIT, _Z_LIMIT
    for _ in range(200):
        S, C = _on_curve(z)
        n, m = S ** (1.0 / beta), C ** (1.0 / alpha)
        Ca, Sb = C ** (0.5 * ea), S ** (0.5 * eb)
        factor = Np / (k_axial * beta) * Ca
        GA = (Np * n - T) * factor
        size_of_terms = (Np * n + T) * factor
        dG = 2.0 / beta * Np * n * C * factor - ea * S * GA
        GB = 0.0
        for i in range(hinges):
            if k_rotation[i] == 0.0:
                continue
            A = abs(trial[i + 1])
            Mp = moment[i, 0] if trial[i + 1] >= 0.0 else moment[i, 1]
            factor = Mp / (k_rotation[i] * alpha) * Sb
            size_of_terms += (A + Mp * m) * factor
            if Mp * m < A:
                GB += (A - Mp * m) * factor
                dG += 2.0 / alpha * Mp * m * S * factor
        dG += eb * C * GB
        G = GA + GB
        if abs(G) <= 4e-16 * size_of_terms:
            break
        if G < 0.0:
            low = z
        else:
            high = z
        new = z - G / dG if dG > 0.0 else low - 1.0
        if not (low < new < high):
            new = 0.5 * (low + high)
        small = 2e-16 * max(1.0, abs(z))
        if abs(new - z) <= small or high - low <= small:
            z = new
            break
        z = new

    # 6. forces
    S, C = _on_curve(z)
    n, m = S ** (1.0 / beta), C ** (1.0 / alpha)
    stress[0] = np.copysign(Np * n, trial[0])
    # 1.5 consistent tangent: rank one along the curve plus the hinges that stay elastic
    Ca, Sb = C ** (0.5 * ea), S ** (0.5 * eb)
    a = 2.0 / beta * Np * Ca
    pa = 0.0 if ea == 0.0 else -2.0 / beta * Np * ea * C ** (1.0 - 2.0 / alpha) * Sb
    H = a * a / k_axial + (Np * n - T) * pa / k_axial
    tangent[0, 0] = 1.0  # mark: axial always takes part
    for i in range(hinges):
        A = abs(trial[i + 1])
        Mp = moment[i, 0] if trial[i + 1] >= 0.0 else moment[i, 1]
        if k_rotation[i] > 0.0 and Mp * m < A:
            stress[i + 1] = np.copysign(Mp * m, trial[i + 1])
            b = -2.0 / alpha * Mp * Sb
            pb = 0.0 if eb == 0.0 else -2.0 / alpha * Mp * eb * S ** (1.0 - 2.0 / beta) * Ca
            H += b * b / k_rotation[i] - (A - Mp * m) * pb / k_rotation[i]
            tangent[i + 1, 0] = b if trial[i + 1] >= 0.0 else -b
        else:
            stress[i + 1] = trial[i + 1]
    first = np.copysign(a, trial[0])
    finite = np.isfinite(H) and H > 0.0
    for i in range(1, size):
        for j in range(1, size):
            tangent[i, j] = tangent[i, 0] * tangent[j, 0] / H if finite else 0.0
        active = k_rotation[i - 1] > 0.0 and abs(stress[i]) < abs(trial[i])
        if not active:
            tangent[i, i] += k_rotation[i - 1]
    for i in range(1, size):
        tangent[i, 0] = first * tangent[i, 0] / H if finite else 0.0
        tangent[0, i] = tangent[i, 0]
    tangent[0, 0] = first * first / H if finite else 0.0
    return CURVE


@njit(cache=True, error_model="numpy")
def _axis_point(k_axial, k_rotation, Np, moment, alpha, beta, trial, stress, tangent):
    """N = 0, full plastic moments: corner of the surface (beta = 1) or smooth axis point."""
    stress[0] = 0.0
    curvature = 0.0
    for i in range(k_rotation.shape[0]):
        A = abs(trial[i + 1])
        Mp = moment[i, 0] if trial[i + 1] >= 0.0 else moment[i, 1]
        if k_rotation[i] > 0.0 and Mp < A:
            stress[i + 1] = np.copysign(Mp, trial[i + 1])
            curvature += (A - Mp) * 2.0 * Mp / (alpha * Np**2 * k_rotation[i])
        else:
            stress[i + 1] = trial[i + 1]
            tangent[i + 1, i + 1] = k_rotation[i]
    if beta == 1.0:
        return CORNER
    if beta > 2.0:
        tangent[0, 0] = k_axial
    elif beta == 2.0:
        tangent[0, 0] = 1.0 / (1.0 / k_axial + curvature)
    return AXIS


@njit(cache=True, error_model="numpy")
def _apex(k_axial, k_rotation, Np, moment, alpha, beta, trial, stress, tangent):
    """|N| = N_p, no moment: corner of the surface (alpha = 1) or smooth apex."""
    T = abs(trial[0])
    stress[0] = np.copysign(Np, trial[0])
    for i in range(k_rotation.shape[0]):
        stress[i + 1] = 0.0
        Mp = moment[i, 0] if trial[i + 1] >= 0.0 else moment[i, 1]
        if alpha > 2.0:
            tangent[i + 1, i + 1] = k_rotation[i]
        elif alpha == 2.0 and k_rotation[i] > 0.0:
            curvature = (T - Np) * 2.0 * Np / (beta * Mp**2 * k_axial)
            tangent[i + 1, i + 1] = 1.0 / (1.0 / k_rotation[i] + curvature)
    return APEX if alpha == 1.0 else SMOOTH_APEX
