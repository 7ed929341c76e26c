"""Forces, tangent and energies of a fiber section.

Symbols: strains Gamma_1 of the axis, Gamma_2 of shear, curvature kappa; forces N, V, M; fiber
strain eps = Gamma_1 - y kappa, so that M = -sum(sigma y A).
"""

from workbench.compiled import njit
from workbench.structures.uniaxial.kernels import (
    LINEAR,
    LINEAR_RATE,
    MENEGOTTO_PINTO,
    SHEARED,
    linear,
    linear_rate,
    menegotto_pinto,
    sheared,
)


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
    if code != SHEARED:
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
        E, H, fy, G = p[0], p[1], p[2], p[3]
        share = sections.share[s]
        for f in range(y.shape[0]):
            eps = gamma1 - y[f] * kappa + initial[f]
            w = share[f]
            sigma, tau, k11, k12, k22, plastic, slid = sheared(
                E, G, H, fy, eps, w * gamma2, old[0, f], old[1, f]
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
        if code == SHEARED:
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
