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

**Second part.** The Bernoulli beam element with fiber sections: local law, group assembly, energy
ledger.

Symbols: eps = u/L - y (b1 theta_1 + b2 theta_2) with b1 = (6 xi - 4)/L and b2 = (6 xi - 2)/L at
the point xi along the element; N = sum(sigma A), M = -sum(sigma y A). Source: Heng 2017, 2.1.
"""

import math
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.mechanics.structures.elements import ITERATIONS, rate_flow, rate_multiplier
from workbench.mechanics.structures.kernels import add_element, chord_at

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


BALANCE = 1e-13  # of squash load and of 6 EI / L: inner unknowns are solved to round-off
INNER_ITERATIONS = 100


class Beam(NamedTuple):
    """One element as its law sees it.

    `length` in m; number of its `section`; points `xi` along it with `weights` (points,);
    `spread` (points,) of the axial strain, all zero for linear axial displacement; fiber states
    `old` and `new` (points, states, f); `inner` (5,): elongation (m), bending rotations of both
    ends (rad), shear strain, and the amplitude a of the strain that `spread` adds; `local` (3,)
    forces N, M1, M2; `weight` and `duration` (s) of the step, see `section_response`.
    """

    length: float
    section: int
    xi: Array
    weights: Array
    spread: Array
    old: Array
    new: Array
    inner: Array
    local: Array
    weight: float
    duration: float


@njit(cache=True, error_model="numpy", forceinline=True)
def point_strain(length, xi, spread, inner):
    """Axial strain and curvature at a point, and the factors b1 and b2 of the end rotations."""
    b1 = (6.0 * xi - 4.0) / length
    b2 = (6.0 * xi - 2.0) / length
    return inner[0] / length + spread * inner[4], b1 * inner[1] + b2 * inner[2], b1, b2


@njit(cache=True, error_model="numpy", forceinline=True)
def point_sums(beam, sections, k, coupling):
    """Sums over the points of a `beam` at its `inner` state.

    Writes the new fiber states, the local forces, their tangent `k` (3, 3), and `coupling` (4,):
    derivatives of the force R_a = L sum(w spread N) conjugate to a with respect to the elongation,
    both rotations and a. Result: R_a.
    """
    local, length = beam.local, beam.length
    local[:] = 0.0
    k[:] = 0.0
    coupling[:] = 0.0
    difference = 0.0
    for g in range(beam.xi.shape[0]):
        spread = beam.spread[g]
        strain, curvature, b1, b2 = point_strain(length, beam.xi[g], spread, beam.inner)
        strains = strain, 0.0, curvature
        n, _, m, c0, _, c1, _, _, c2 = section_response(
            sections, beam.section, beam.weight, beam.duration, strains, beam.old[g], beam.new[g]
        )
        w = beam.weights[g]
        wl = w * length
        local[0] += w * n
        local[1] += wl * b1 * m
        local[2] += wl * b2 * m
        k[0, 0] += w * c0 / length
        k[0, 1] += w * b1 * c1
        k[0, 2] += w * b2 * c1
        k[1, 1] += wl * b1 * b1 * c2
        k[1, 2] += wl * b1 * b2 * c2
        k[2, 2] += wl * b2 * b2 * c2
        difference += wl * spread * n
        coupling[0] += w * spread * c0
        coupling[1] += wl * b1 * spread * c1
        coupling[2] += wl * b2 * spread * c1
        coupling[3] += wl * spread * spread * c0
    k[1, 0] = k[0, 1]
    k[2, 0] = k[0, 2]
    k[2, 1] = k[1, 2]
    return difference


@njit(cache=True, error_model="numpy", forceinline=True)
def inside(new, low, high):
    """A Newton iterate, or the middle of the bracket if it leaves that; its end if open."""
    if low < new < high:
        return new
    if low == -np.inf:
        return high
    if high == np.inf:
        return low
    return 0.5 * (low + high)


@njit(cache=True, error_model="numpy", forceinline=True)
def balanced_law(beam, sections, k, coupling):
    """`point_sums` with the amplitude a such that N is the same at both points.

    With linear axial displacement alone, a section that yields under N and M cannot shorten or
    lengthen freely, because its element's other section is elastic: N is relieved, and the
    moment capacity overestimated. The force R_a rises with a, so that a safeguarded Newton
    iteration from the last a finds it. Writes the condensed `k` as well.
    """
    s = beam.section
    tolerance = BALANCE * sections.parameters[s, 2] * np.sum(sections.area[s]) * beam.length
    a = beam.inner[4]
    low, high = -np.inf, np.inf
    for _ in range(INNER_ITERATIONS):
        beam.inner[4] = a
        difference = point_sums(beam, sections, k, coupling)
        if abs(difference) <= tolerance:
            break
        if difference > 0.0:
            high = a
        else:
            low = a
        a = inside(a - difference / coupling[3], low, high)
        if a == beam.inner[4]:
            break
    for i in range(3):
        for j in range(3):
            k[i, j] -= coupling[i] * coupling[j] / coupling[3]


@njit(cache=True, error_model="numpy", forceinline=True)
def element_law(beam, sections, theta1, theta2, k, coupling):
    """Local forces (N, M1, M2) of a `beam` and their tangent `k` (3, 3).

    Arguments: `beam` with its elongation, and from the last trial the other entries of `inner`,
    from which the solution starts and into which it is written; end rotations `theta1`, `theta2`
    against the chord; scratch `coupling` (4,).

    The elastic shear strain g, constant along the element, turns both ends against the chord:
    bending rotations are theta + g, and GA L g + M1 + M2 = 0 fixes g.
    """
    s, inner, local = beam.section, beam.inner, beam.local
    balanced = beam.spread[0] != 0.0
    sheared = sections.shear[s] > 0.0
    stiffness = sections.shear[s] * beam.length
    elastic = 6.0 * sections.parameters[s, 0] * sections.second[s] / beam.length
    g = 0.0
    if sheared:
        # exact if all fibers respond elastically from the last trial
        g = inner[3]
        change = theta1 + theta2 - (inner[1] - g) - (inner[2] - g)
        g -= elastic * change / (stiffness + 2.0 * elastic)
    low, high = -np.inf, np.inf
    tolerance = BALANCE * elastic
    for _ in range(INNER_ITERATIONS):
        inner[1] = theta1 + g
        inner[2] = theta2 + g
        inner[3] = g
        if balanced:
            balanced_law(beam, sections, k, coupling)
        else:
            point_sums(beam, sections, k, coupling)
        if not sheared:
            return
        residual = stiffness * g + local[1] + local[2]
        pivot = stiffness + k[1, 1] + 2.0 * k[1, 2] + k[2, 2]
        if abs(residual) <= tolerance:
            break
        # the residual rises with g: Newton's step, kept inside the bracket
        if residual > 0.0:
            high = g
        else:
            low = g
        g = inside(g - residual / pivot, low, high)
        if g == inner[3]:
            break
    for i in range(3):
        coupling[i] = k[i, 1] + k[i, 2]
    for i in range(3):
        for j in range(3):
            k[i, j] -= coupling[i] * coupling[j] / pivot


@njit(cache=True, error_model="numpy")
def assemble(step, bars, points, sections, old, new):
    """Add forces and tangent of all elements of a group for a `step`; write the state `new`."""
    k = np.empty((3, 3))
    coupling = np.empty(4)
    work = np.empty((7, 4))
    weight = step.weight
    rest = 1.0 - weight
    for e in range(bars.dofs.shape[0]):
        chord = chord_at(bars, e, step.end)
        begin, inner = old.inner[e], new.inner[e]
        # fibers yield within the step; `inner` then goes on to its end
        inner[0] = chord.elongation
        for i in range(inner.size):
            at = rest * begin[i] + weight * inner[i]
            inner[i] = at if math.isfinite(at) else begin[i]  # no wild trial spoils the next one
        beam = Beam(
            bars.lengths[e],
            sections.of[e],
            points.xi[e],
            points.weights[e],
            points.spread[e],
            old.fibers[e],
            new.fibers[e],
            inner,
            new.local[e],
            weight,
            step.duration,
        )
        turn1 = weight * (step.end[bars.dofs[e, 2]] - chord.rotation) + rest * (begin[1] - begin[3])
        turn2 = weight * (step.end[bars.dofs[e, 5]] - chord.rotation) + rest * (begin[2] - begin[3])
        element_law(beam, sections, turn1, turn2, k, coupling)
        for i in range(1, inner.size):
            inner[i] = begin[i] + (inner[i] - begin[i]) / weight
        inner[0] = chord.elongation
        add_element(step, bars, e, chord, new.local[e], new.local[e], k, work)


@njit(cache=True, error_model="numpy")
def account(weight, bars, points, sections, old, new):
    """Energies of a step from the committed to the trial state of a group, see `StepEnergies`."""
    stored = plastic = algorithmic = ideal = 0.0
    for e in range(bars.lengths.shape[0]):
        L, inner0, inner1 = bars.lengths[e], old.inner[e], new.inner[e]
        for g in range(points.xi.shape[1]):
            xi, spread = points.xi[e, g], points.spread[e, g]
            strain0, kappa0, _, _ = point_strain(L, xi, spread, inner0)
            strain1, kappa1, _, _ = point_strain(L, xi, spread, inner1)
            parts = section_energies(
                sections,
                sections.of[e],
                weight,
                points.weights[e, g] * L,
                (strain0, inner0[3], kappa0),
                (strain1, inner1[3], kappa1),
                old.fibers[e, g],
                new.fibers[e, g],
            )
            stored += parts[0]
            plastic += parts[1]
            algorithmic += parts[2]
            ideal += parts[3]
    return stored, plastic, algorithmic, ideal
