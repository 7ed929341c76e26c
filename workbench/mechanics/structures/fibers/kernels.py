"""Stress updates of one fiber; forces, tangent and energies of a section of fibers.

Stresses start from the committed state of the step. Parameters p are (E, H, fy, ...). Linear law:
p[3] isotropic modulus; with rate p[4], p[5], the Cowper-Symonds D and q. Menegotto-Pinto: p[3] b,
p[4] R0, p[5] cR1, p[6] cR2. The first state of every law is the plastic strain, so that
stress = E (strain - plastic strain) always.
Normal and shear stress together: eps, gamma strains, p their plastic parts; xi = (sigma - H eps_p,
tau - H gamma_p / 3) the stress from the centre of the yield ellipse xi_1^2 + 3 xi_2^2 = s^2; flow
(xi_1, 3 xi_2) lam by closest-point projection, s = fy, or s = fy (1 + (lam s / (D dt))^(1/q)).
Sections: strains Gamma_1 of the axis, Gamma_2 of shear, curvature kappa; forces N, V, M; fiber
strain eps = Gamma_1 - y kappa, so that M = -sum(sigma y A).
Sources: Simo and Hughes 1998, boxes 1.5 and 1.6, section 3.3; Menegotto and Pinto 1973; Filippou
et al. 1983.
"""

import math

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.structures.overstress import ITERATIONS, rate_flow, rate_multiplier

LINEAR, LINEAR_RATE, MENEGOTTO_PINTO, SHEARED, SHEARED_RATE = 0, 1, 2, 3, 4


@njit(cache=True, error_model="numpy")
def linear(E, H, fy, Hi, eps, plastic, accumulated):
    """Linear hardening: stress, tangent, and the new plastic and accumulated plastic strain."""
    trial = E * (eps - plastic) - H * plastic
    excess = abs(trial) - fy - Hi * accumulated
    modulus = E
    if excess > 0.0:
        inverse = 1.0 / (E + H + Hi)
        flow = excess * inverse
        modulus = E * (H + Hi) * inverse
        plastic += math.copysign(flow, trial)
        accumulated += flow
    return E * (eps - plastic), modulus, plastic, accumulated


@njit(cache=True, error_model="numpy")
def linear_rate(p, duration, eps, plastic, accumulated):
    """Linear hardening with Cowper-Symonds overstress over a step of `duration` (s)."""
    E, H, fy, Hi = p[0], p[1], p[2], p[3]
    if duration == np.inf:
        return linear(E, H, fy, Hi, eps, plastic, accumulated)
    trial = E * (eps - plastic) - H * plastic
    excess = abs(trial) - fy - Hi * accumulated
    modulus = E
    if excess > 0.0:
        flow, slope = rate_flow(excess, E + H + Hi, fy, p[4], p[5], duration)
        modulus = E * (1.0 - E * slope)
        plastic += math.copysign(flow, trial)
        accumulated += flow
    return E * (eps - plastic), modulus, plastic, accumulated


@njit(cache=True, error_model="numpy")
def menegotto_pinto(p, eps, old, new, f):
    """Menegotto-Pinto: stress and tangent of fiber `f`; `old` and `new` are states (10, fibers).

    States: plastic strain at the end of the step, which the caller writes; strain; strain and
    stress at the last reversal; those where its elastic line meets the hardening line; largest
    and smallest strain; direction (0: virgin); plastic strain at the strain sampled last.
    """
    E, fy, b = p[0], p[2], p[3]
    yielding = fy / E
    for k in range(10):
        new[k, f] = old[k, f]
    last = old[1, f]
    change = eps - last
    direction = old[8, f]
    if change == 0.0:
        if direction == 0.0:
            return E * (eps - old[9, f]), E
    elif direction == 0.0:
        direction = math.copysign(1.0, change)
        new[2, f] = new[3, f] = 0.0
        new[4, f], new[5, f] = direction * yielding, direction * fy
        new[6, f], new[7, f] = yielding, -yielding
    elif change * direction < 0.0:
        direction = -direction
        stress = E * (last - old[9, f])
        new[2, f], new[3, f] = last, stress
        if direction > 0.0:
            new[7, f] = min(old[7, f], last)
        else:
            new[6, f] = max(old[6, f], last)
        # where the elastic line from the reversal meets the hardening line
        meeting = (direction * fy * (1.0 - b) - stress + E * last) / (E * (1.0 - b))
        new[4, f] = meeting
        new[5, f] = direction * fy + b * E * (meeting - direction * yielding)
    new[8, f] = direction
    extreme = new[6, f] if direction > 0.0 else new[7, f]
    excursion = abs(extreme - new[4, f]) / yielding
    R = p[4] * (1.0 - p[5] * excursion / (p[6] + excursion))
    span = new[4, f] - new[2, f]
    x = (eps - new[2, f]) / span
    # 1 / (1 + |x|^R)^(1/R), written so that large |x|^R do not overflow
    size = abs(x)
    if size <= 1.0:
        power = size**R
        root = (1.0 + power) ** (-1.0 / R)
        bend = root / (1.0 + power)
    else:
        power = size**-R
        root = (1.0 + power) ** (-1.0 / R) / size
        bend = root * power / (1.0 + power)
    ratio = (new[5, f] - new[3, f]) / span
    stress = new[3, f] + (b * x + (1.0 - b) * x * root) * (new[5, f] - new[3, f])
    new[9, f] = eps - stress / E
    new[1, f] = eps
    return stress, ratio * (b + (1.0 - b) * bend)


@njit(cache=True, error_model="numpy")
def multiplier(first, second, a, b, fy):
    """Solve (first / (1 + a lam))^2 + (second / (1 + b lam))^2 = fy^2 for lam > 0.

    The inverse of the equivalent stress is nearly linear in lam (exactly so for one component
    alone): Newton's method on it, kept inside the bracket.
    """
    size = math.sqrt(first * first + second * second) / fy - 1.0
    low, high = size / max(a, b), size / min(a, b)
    lam = 0.5 * (low + high)
    for _ in range(ITERATIONS):
        u = first / (1.0 + a * lam)
        v = second / (1.0 + b * lam)
        square = u * u + v * v
        q = math.sqrt(square)
        # d(1/q)/dlam = (u^2 a/(1 + a lam) + v^2 b/(1 + b lam)) / q^3
        slope = (u * u * a / (1.0 + a * lam) + v * v * b / (1.0 + b * lam)) / (square * q)
        value = 1.0 / q - 1.0 / fy
        if value < 0.0:
            low = lam
        else:
            high = lam
        change = value / slope
        lam -= change
        if not low <= lam <= high:
            lam = 0.5 * (low + high)
        if abs(change) <= 4e-16 * (lam + 1.0 / max(a, b)):
            break
    return lam


@njit(cache=True, error_model="numpy")
def sheared(p, duration, eps, gamma, eps_p, gamma_p):
    """Stresses, tangent (11, 12, 22) and new plastic strains of a fiber.

    Arguments: parameters (E, H, fy, G, D, q) of the law; `duration` of the step in s, infinite
    without a rate; strains; committed plastic strains. Result: sigma, tau, three tangent moduli,
    plastic strain and plastic shear strain.
    """
    E, H, fy, G = p[0], p[1], p[2], p[3]
    sigma = E * (eps - eps_p)
    tau = G * (gamma - gamma_p)
    first = sigma - H * eps_p
    second = tau - H * gamma_p / 3.0
    if first * first + 3.0 * second * second <= fy * fy:
        return sigma, tau, E, 0.0, G, eps_p, gamma_p
    a, b = E + H, 3.0 * G + H
    third = math.sqrt(3.0) * second
    if duration == np.inf:
        lam, stiffness = multiplier(first, third, a, b, fy), 0.0
    else:
        lam, stiffness = rate_multiplier(first, third, a, b, fy, 0.0, fy, p[4], p[5], duration)
    one, two = 1.0 / (1.0 + a * lam), 1.0 / (1.0 + b * lam)
    first *= one
    second *= two
    eps_p += lam * first
    gamma_p += 3.0 * lam * second
    # d(xi) = X W d(strain) - u (u . W d(strain)) / (n . u + s ds/dlam) with X = diag(a one,
    # b two / 3), W = diag(E / a, 3 G / b), n = (xi_1, 3 xi_2), u = X n, s^2 = n . xi; and
    # d(stress) = (D - D W) d(strain) + W d(xi) with D = diag(E, G)
    w1, w2 = E / a, 3.0 * G / b
    u1, u2 = a * one * first, b * two * second
    across = first * u1 + 3.0 * second * u2 + stiffness
    k11 = E * (1.0 - w1) + w1 * w1 * (a * one - u1 * u1 / across)
    k12 = -w1 * w2 * u1 * u2 / across
    k22 = G * (1.0 - w2) + w2 * w2 * (b * two / 3.0 - u2 * u2 / across)
    return E * (eps - eps_p), G * (gamma - gamma_p), k11, k12, k22, eps_p, gamma_p


@njit(cache=True, error_model="numpy", forceinline=True)
def section_response(sections, s, weight, duration, strains, old, new):
    """Section forces N, V, M within a step and their tangent (NN, NV, NM, VV, VM, MM).

    Arguments: `sections` tables, number `s` of the section; `weight`, the instant within the step
    of `duration` (s) at which fibers yield; `strains` (Gamma_1, Gamma_2, kappa) there; committed
    fiber states `old` (states, f). Writes the trial states `new` at the end of the step: plastic
    strains go on over the rest of the step as they went so far.
    """
    gamma1, gamma2, kappa = strains
    duration *= weight
    on = 1.0 / weight
    code, p = sections.code[s], sections.parameters[s]
    y, area, initial = sections.y[s], sections.area[s], sections.initial[s]
    N = V = M = 0.0
    c00 = c01 = c02 = c11 = c12 = c22 = 0.0
    if code < SHEARED:
        E, H, fy, Hi = p[0], p[1], p[2], p[3]
        for f in range(y.shape[0]):
            eps = gamma1 - y[f] * kappa + initial[f]
            if code == LINEAR:
                stress, modulus, plastic, other = linear(E, H, fy, Hi, eps, old[0, f], old[1, f])
            elif code == LINEAR_RATE:
                stress, modulus, plastic, other = linear_rate(
                    p, duration, eps, old[0, f], old[1, f]
                )
            else:
                stress, modulus = menegotto_pinto(p, eps, old, new, f)
                plastic, other = new[9, f], 0.0
            new[0, f] = old[0, f] + on * (plastic - old[0, f])
            if code != MENEGOTTO_PINTO:
                new[1, f] = old[1, f] + on * (other - old[1, f])
            stress *= area[f]
            N += stress
            M -= stress * y[f]
            modulus *= area[f]
            c00 += modulus
            modulus *= y[f]
            c02 -= modulus
            c22 += modulus * y[f]
    else:
        share = sections.share[s]
        lasting = duration if code == SHEARED_RATE else np.inf
        for f in range(y.shape[0]):
            eps = gamma1 - y[f] * kappa + initial[f]
            w = share[f]
            sigma, tau, k11, k12, k22, plastic, slid = sheared(
                p, lasting, eps, w * gamma2, old[0, f], old[1, f]
            )
            new[0, f] = old[0, f] + on * (plastic - old[0, f])
            new[1, f] = old[1, f] + on * (slid - old[1, f])
            A, yf = area[f], y[f]
            N += sigma * A
            V += tau * A * w
            M -= sigma * A * yf
            c00 += k11 * A
            c02 -= k11 * A * yf
            c22 += k11 * A * yf * yf
            c01 += k12 * A * w
            c12 -= k12 * A * w * yf
            c11 += k22 * A * w * w
    shear = sections.shear[s]
    return N, V + shear * gamma2, M, c00, c01, c02, c11 + shear, c12, c22


@njit(cache=True, error_model="numpy", forceinline=True)
def section_energies(sections, s, weight, dx, before, after, old, new):
    """Energies of a piece of a beam in a step, in J.

    Arguments: `sections` tables, number `s` of the section; `weight` of the end stresses; length
    `dx` in m; committed and trial strains (Gamma_1, Gamma_2, kappa) `before` and `after`, and
    fiber states `old` and `new` (states, f). Result: stored energy at the end; plastic dissipation
    of the step with stresses weighted as in its forces; algorithmic dissipation; and the plastic
    work of stresses at yield, which is the second where fibers yield within the step. The work of
    the isotropic part of hardening counts as dissipated; of the Menegotto-Pinto law only
    E eps_e^2 / 2 counts as stored.
    """
    code = sections.code[s]
    E, H, G = sections.parameters[s, 0], sections.parameters[s, 1], sections.parameters[s, 3]
    lag = weight - 0.5
    shear, slip = dx * sections.shear[s], after[1] - before[1]
    stored = 0.5 * shear * after[1] * after[1]
    algorithmic = lag * shear * slip * slip
    plastic = 0.0
    for f in range(sections.y.shape[1]):
        y, volume = sections.y[s, f], dx * sections.area[s, f]
        p0, p1 = old[0, f], new[0, f]
        elastic0 = before[0] - y * before[2] + sections.initial[s, f] - p0
        elastic1 = after[0] - y * after[2] + sections.initial[s, f] - p1
        change, flow = elastic1 - elastic0, p1 - p0
        stored += 0.5 * volume * (E * elastic1 * elastic1 + H * p1 * p1)
        algorithmic += lag * volume * (E * change * change + H * flow * flow)
        start, end = E * elastic0 - H * p0, E * elastic1 - H * p1
        work = ((1.0 - weight) * start + weight * end) * flow
        if code >= SHEARED:
            w = sections.share[s, f]
            p0, p1 = old[1, f], new[1, f]
            elastic0, elastic1 = w * before[1] - p0, w * after[1] - p1
            change, flow = elastic1 - elastic0, p1 - p0
            stored += 0.5 * volume * (G * elastic1 * elastic1 + H * p1 * p1 / 3.0)
            algorithmic += lag * volume * (G * change * change + H * flow * flow / 3.0)
            start, end = G * elastic0 - H * p0 / 3.0, G * elastic1 - H * p1 / 3.0
            work += ((1.0 - weight) * start + weight * end) * flow
        plastic += volume * work
    return stored, plastic, algorithmic, plastic
