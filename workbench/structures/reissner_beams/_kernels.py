"""The geometrically exact beam element with one point, its fiber section and energy ledger.

Symbols: r' = dx/ds, director a = (cos phi, sin phi), b normal to it, phi the initial angle plus
the rotation theta at the point; strains Gamma_1 = r'.a - 1, Gamma_2 = r'.b, kappa = theta'; forces
N, V, M; eps = Gamma_1 - y kappa. Over a time step x = (theta_1 - theta_0)/2, a_m and b_m at the
mean angle, and
  dGamma_1 = cos x a_m.dr' + (r'_mean.b_m)(sin x / x) dtheta,
  dGamma_2 = cos x b_m.dr' - (r'_mean.a_m)(sin x / x) dtheta
are exact, so that the work of the element forces is that of the weighted section forces.
Sources: Reissner 1972; Simo 1985; discrete gradients after Simo, Tarnow and Doblare 1995.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.structures.shear_beams._kernels import sheared
from workbench.structures.uniaxial._kernels import (
    LINEAR,
    LINEAR_RATE,
    SHEARED,
    linear,
    linear_rate,
    menegotto_pinto,
)

Vector = NDArray[np.float64]
SMALL_TURN = 1e-3  # rad; below it sin(x)/x is taken from its series


@njit(cache=True, error_model="numpy")
def section_response(sections, s, duration, gamma1, gamma2, kappa, old, new):
    """Section forces N, V, M and their tangent (NN, NV, NM, VV, VM, MM).

    Arguments: `sections` tables, number `s` of the section, `duration` of the step in s; strains;
    committed fiber states `old` (states, f). Writes the trial states `new`.
    """
    code, p = sections.code[s], sections.parameters[s]
    y, area, initial = sections.y[s], sections.area[s], sections.initial[s]
    N = V = M = 0.0
    c00 = c01 = c02 = c11 = c12 = c22 = 0.0
    if code == LINEAR:
        E, H, fy, Hi = p[0], p[1], p[2], p[3]
        for f in range(y.shape[0]):
            eps = gamma1 - y[f] * kappa + initial[f]
            stress, modulus, new[0, f], new[1, f] = linear(E, H, fy, Hi, eps, old[0, f], old[1, f])
            stress *= area[f]
            N += stress
            M -= stress * y[f]
            modulus *= area[f]
            c00 += modulus
            modulus *= y[f]
            c02 -= modulus
            c22 += modulus * y[f]
    elif code != SHEARED:
        for f in range(y.shape[0]):
            eps = gamma1 - y[f] * kappa + initial[f]
            if code == LINEAR_RATE:
                stress, modulus, new[0, f], new[1, f] = linear_rate(
                    p[0], p[1], p[2], p[3], p[4], p[5], duration, eps, old[0, f], old[1, f]
                )
            else:
                stress, modulus = menegotto_pinto(p, eps, old, new, f)
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
            new[0, f], new[1, f] = plastic, slid
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


@njit(cache=True, error_model="numpy")
def point_state(tables, e, x):
    """Stretch r' (two components), rotation and curvature of element `e` at displacements `x`."""
    dofs, gradients, values = tables.dofs[e], tables.gradients[e], tables.values[e]
    rx = tables.director[e, 0] + gradients[0] * x[dofs[0]] + gradients[1] * x[dofs[3]]
    ry = tables.director[e, 1] + gradients[0] * x[dofs[1]] + gradients[1] * x[dofs[4]]
    turn = values[0] * x[dofs[2]] + values[1] * x[dofs[5]]
    kappa = gradients[0] * x[dofs[2]] + gradients[1] * x[dofs[5]]
    return rx, ry, turn, kappa


@njit(cache=True, error_model="numpy")
def strains(tables, x, result):
    """Gamma_1, Gamma_2 and kappa of all elements at displacements `x`, into `result` (e, 3)."""
    for e in range(result.shape[0]):
        rx, ry, turn, kappa = point_state(tables, e, x)
        c, s = math.cos(turn), math.sin(turn)
        ax = tables.director[e, 0] * c - tables.director[e, 1] * s
        ay = tables.director[e, 1] * c + tables.director[e, 0] * s
        result[e, 0] = rx * ax + ry * ay - 1.0
        result[e, 1] = ry * ax - rx * ay
        result[e, 2] = kappa


@njit(cache=True, error_model="numpy")
def respond(duration, sections, old, new, tangent):
    """Section forces and tangents (e, 3, 3) of all elements at the strains of the `new` state."""
    for e in range(new.strain.shape[0]):
        N, V, M, c00, c01, c02, c11, c12, c22 = section_response(
            sections, sections.of[e], duration,
            new.strain[e, 0], new.strain[e, 1], new.strain[e, 2], old.fibers[e], new.fibers[e],
        )  # fmt: skip
        new.stress[e, 0], new.stress[e, 1], new.stress[e, 2] = N, V, M
        tangent[e, 0, 0], tangent[e, 0, 1], tangent[e, 0, 2] = c00, c01, c02
        tangent[e, 1, 0], tangent[e, 1, 1], tangent[e, 1, 2] = c01, c11, c12
        tangent[e, 2, 0], tangent[e, 2, 1], tangent[e, 2, 2] = c02, c12, c22


@njit(cache=True, error_model="numpy")
def sinc(x):
    """sin(x)/x and its derivative."""
    if abs(x) < SMALL_TURN:
        square = x * x
        return 1.0 - square / 6.0 + square * square / 120.0, x * (-1.0 / 3.0 + square / 30.0)
    value = math.sin(x) / x
    return value, (math.cos(x) - value) / x


@njit(cache=True, error_model="numpy")
def assemble(
    force, band, positions, x0, x1, weight, step, tangent, duration, tables, sections, old, new
):
    """Add forces, and the tangent if asked for, of all elements of a group.

    Arguments: `force` (dofs,) and flat `band` to add to, entries of an element at `positions`
    (e, 36); displacements committed `x0` and at the end `x1`; `weight` of the end state in the
    forces of a time `step` (False: equilibrium at the end); `duration` of the step in s; then
    the group's tables and its committed and trial states. Writes the trial state.
    """
    reduced = np.empty((4, 4))
    right = np.empty((3, 4))
    for e in range(tables.dofs.shape[0]):
        dofs, g = tables.dofs[e], tables.gradients[e]
        h, dx = tables.values[e], tables.measure[e]
        Dx, Dy = tables.director[e, 0], tables.director[e, 1]
        r1x, r1y, turn1, kappa = point_state(tables, e, x1)
        c, s = math.cos(turn1), math.sin(turn1)
        a1x, a1y = Dx * c - Dy * s, Dy * c + Dx * s
        gamma1 = r1x * a1x + r1y * a1y - 1.0
        gamma2 = r1y * a1x - r1x * a1y
        N, V, M, c00, c01, c02, c11, c12, c22 = section_response(
            sections, sections.of[e], duration, gamma1, gamma2, kappa, old.fibers[e], new.fibers[e]
        )
        new.stress[e, 0], new.stress[e, 1], new.stress[e, 2] = N, V, M
        new.strain[e, 0], new.strain[e, 1], new.strain[e, 2] = gamma1, gamma2, kappa
        if step:
            r0x, r0y, turn0, _ = point_state(tables, e, x0)
            half, mid = 0.5 * (turn1 - turn0), 0.5 * (turn1 + turn0)
            c, s = math.cos(mid), math.sin(mid)
            amx, amy = Dx * c - Dy * s, Dy * c + Dx * s
            rmx, rmy = 0.5 * (r0x + r1x), 0.5 * (r0y + r1y)
            sc, slope = sinc(half)
            cx = math.cos(half)
            ax, ay = cx * amx, cx * amy
            along, across = rmx * amx + rmy * amy, rmy * amx - rmx * amy
            turn_1, turn_2 = sc * across, -sc * along
            rest = 1.0 - weight
            N = rest * old.stress[e, 0] + weight * N
            V = rest * old.stress[e, 1] + weight * V
            M = rest * old.stress[e, 2] + weight * M
        else:
            ax, ay = a1x, a1y
            turn_1, turn_2 = gamma2, -(1.0 + gamma1)
        # with b = (-a_y, a_x): what works on r', on theta and on kappa
        fx, fy = dx * (N * ax - V * ay), dx * (N * ay + V * ax)
        moment, M = dx * (N * turn_1 + V * turn_2), dx * M
        force[dofs[0]] += g[0] * fx
        force[dofs[1]] += g[0] * fy
        force[dofs[2]] += h[0] * moment + g[0] * M
        force[dofs[3]] += g[1] * fx
        force[dofs[4]] += g[1] * fy
        force[dofs[5]] += h[1] * moment + g[1] * M
        if not tangent:
            continue
        share = weight * dx if step else dx
        # right = C B at the end, over (r'_x, r'_y, theta, kappa)
        t1, t2 = gamma2, -(1.0 + gamma1)
        right[0, 0], right[0, 1] = c00 * a1x - c01 * a1y, c00 * a1y + c01 * a1x
        right[1, 0], right[1, 1] = c01 * a1x - c11 * a1y, c01 * a1y + c11 * a1x
        right[2, 0], right[2, 1] = c02 * a1x - c12 * a1y, c02 * a1y + c12 * a1x
        right[0, 2], right[0, 3] = c00 * t1 + c01 * t2, c02
        right[1, 2], right[1, 3] = c01 * t1 + c11 * t2, c12
        right[2, 2], right[2, 3] = c02 * t1 + c12 * t2, c22
        for j in range(4):
            n, v, m = share * right[0, j], share * right[1, j], share * right[2, j]
            reduced[0, j] = ax * n - ay * v
            reduced[1, j] = ay * n + ax * v
            reduced[2, j] = turn_1 * n + turn_2 * v
            reduced[3, j] = m
        if step:
            # derivative of the discrete gradients at fixed section forces
            reduced[0, 2] += 0.5 * dx * (-N * a1y - V * a1x)
            reduced[1, 2] += 0.5 * dx * (N * a1x - V * a1y)
            reduced[2, 0] += 0.5 * dx * sc * (-N * amy - V * amx)
            reduced[2, 1] += 0.5 * dx * sc * (N * amx - V * amy)
            reduced[2, 2] += (
                0.5 * dx * (slope * (N * across - V * along) - sc * (N * along + V * across))
            )
        else:
            reduced[0, 2] += dx * (-N * a1y - V * a1x)
            reduced[1, 2] += dx * (N * a1x - V * a1y)
            reduced[2, 0] += dx * (-N * a1y - V * a1x)
            reduced[2, 1] += dx * (N * a1x - V * a1y)
            reduced[2, 2] -= dx * (N * (1.0 + gamma1) + V * gamma2)
        spread(band, positions[e], reduced, g, h)


@njit(cache=True, error_model="numpy")
def spread(band, positions, reduced, g, h):
    """Add the tangent `reduced` over (r'_x, r'_y, theta, kappa) to the band, for all six dofs.

    Arguments: gradients `g` (2,) and values `h` (2,) of the shape functions; dof k of node i is
    g[i] in r' (k = 0, 1), and h[i] in theta with g[i] in kappa (k = 2).
    """
    for i in range(2):
        for j in range(2):
            at = 18 * i + 3 * j
            gg = g[i] * g[j]
            band[positions[at]] += gg * reduced[0, 0]
            band[positions[at + 1]] += gg * reduced[0, 1]
            band[positions[at + 6]] += gg * reduced[1, 0]
            band[positions[at + 7]] += gg * reduced[1, 1]
            gh, hg, hh = g[i] * h[j], h[i] * g[j], h[i] * h[j]
            band[positions[at + 2]] += gh * reduced[0, 2] + gg * reduced[0, 3]
            band[positions[at + 8]] += gh * reduced[1, 2] + gg * reduced[1, 3]
            band[positions[at + 12]] += hg * reduced[2, 0] + gg * reduced[3, 0]
            band[positions[at + 13]] += hg * reduced[2, 1] + gg * reduced[3, 1]
            band[positions[at + 14]] += (
                hh * reduced[2, 2] + hg * reduced[2, 3] + gh * reduced[3, 2] + gg * reduced[3, 3]
            )


@njit(cache=True, error_model="numpy")
def account(weight, tables, sections, old, new):
    """Energies of a step from the committed to the trial state of a group, in J.

    Result: stored energy at the end; plastic dissipation of the step with stresses weighted as in
    its forces; algorithmic dissipation; and the plastic work of end stresses alone, against
    which the plastic dissipation is judged. The work of the isotropic part of hardening counts
    as dissipated; of the Menegotto-Pinto law only E eps_e^2 / 2 counts as stored.
    """
    stored = plastic = algorithmic = ideal = 0.0
    lag = weight - 0.5
    for e in range(tables.measure.shape[0]):
        s = sections.of[e]
        code = sections.code[s]
        E, H, G = sections.parameters[s, 0], sections.parameters[s, 1], sections.parameters[s, 3]
        dx = tables.measure[e]
        shear = dx * sections.shear[s]
        gamma0, gamma1 = old.strain[e, 1], new.strain[e, 1]
        stored += 0.5 * shear * gamma1 * gamma1
        algorithmic += lag * shear * (gamma1 - gamma0) ** 2
        for f in range(sections.y.shape[1]):
            y, volume = sections.y[s, f], dx * sections.area[s, f]
            p0, p1 = old.fibers[e, 0, f], new.fibers[e, 0, f]
            elastic0 = old.strain[e, 0] - y * old.strain[e, 2] + sections.initial[s, f] - p0
            elastic1 = new.strain[e, 0] - y * new.strain[e, 2] + sections.initial[s, f] - p1
            change, flow = elastic1 - elastic0, p1 - p0
            stored += 0.5 * volume * (E * elastic1 * elastic1 + H * p1 * p1)
            algorithmic += lag * volume * (E * change * change + H * flow * flow)
            start, end = E * elastic0 - H * p0, E * elastic1 - H * p1
            work = ((1.0 - weight) * start + weight * end) * flow
            whole = end * flow
            if code == SHEARED:
                w = sections.share[s, f]
                p0, p1 = old.fibers[e, 1, f], new.fibers[e, 1, f]
                elastic0, elastic1 = w * gamma0 - p0, w * gamma1 - p1
                change, flow = elastic1 - elastic0, p1 - p0
                stored += 0.5 * volume * (G * elastic1 * elastic1 + H * p1 * p1 / 3.0)
                algorithmic += lag * volume * (G * change * change + H * flow * flow / 3.0)
                start, end = G * elastic0 - H * p0 / 3.0, G * elastic1 - H * p1 / 3.0
                work += ((1.0 - weight) * start + weight * end) * flow
                whole += end * flow
            plastic += volume * work
            ideal += volume * whole
    return stored, plastic, algorithmic, ideal


@njit(cache=True, error_model="numpy")
def plastic_rotations(tables, sections, fibers, result):
    """Plastic curvature of each element integrated along it (rad), into `result` (elements,).

    The plastic curvature of a section is -sum(eps_p y A) / sum(y^2 A): what bends the section
    when its stresses are removed.
    """
    for e in range(result.shape[0]):
        s = sections.of[e]
        second = moment = 0.0
        for f in range(sections.y.shape[1]):
            lever = sections.y[s, f] * sections.area[s, f]
            second += sections.y[s, f] * lever
            moment -= fibers[e, 0, f] * lever
        result[e] = tables.measure[e] * moment / second
