"""The geometrically exact beam element with one point: assembly and energy ledger.

Symbols: r' = dx/ds, director a = (cos phi, sin phi), b normal to it, phi the initial angle plus
the rotation theta at the point; strains Gamma_1 = r'.a - 1, Gamma_2 = r'.b, kappa = theta'; forces
N, V, M. Over a time step x = (theta_1 - theta_0)/2, a_m and b_m at the mean angle, and
  dGamma_1 = cos x a_m.dr' + (r'_mean.b_m)(sin x / x) dtheta,
  dGamma_2 = cos x b_m.dr' - (r'_mean.a_m)(sin x / x) dtheta
are exact, so that the work of the element forces is that of the weighted section forces.
Sources: Reissner 1972; Simo 1985; discrete gradients after Simo, Tarnow and Doblare 1995.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from workbench.structures.fibers._kernels import section_energies, section_response

SMALL_TURN = 1e-3  # rad; below it sin(x)/x is taken from its series


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
def point_response(tables, sections, e, x, duration, old, new):
    """Stretch r', rotation and director of element `e` at displacements `x`; its section tangent.

    Writes its strains, section forces and fiber states into `new`.
    """
    rx, ry, turn, kappa = point_state(tables, e, x)
    Dx, Dy = tables.director[e, 0], tables.director[e, 1]
    c, s = math.cos(turn), math.sin(turn)
    ax, ay = Dx * c - Dy * s, Dy * c + Dx * s
    gamma1 = rx * ax + ry * ay - 1.0
    gamma2 = ry * ax - rx * ay
    N, V, M, c00, c01, c02, c11, c12, c22 = section_response(
        sections, sections.of[e], duration, gamma1, gamma2, kappa, old.fibers[e], new.fibers[e]
    )
    new.strain[e, 0], new.strain[e, 1], new.strain[e, 2] = gamma1, gamma2, kappa
    new.stress[e, 0], new.stress[e, 1], new.stress[e, 2] = N, V, M
    return rx, ry, turn, ax, ay, (c00, c01, c02, c11, c12, c22)


@njit(cache=True, error_model="numpy")
def respond(step, tables, sections, old, new, tangent):
    """Section forces and tangents (e, 3, 3) of all elements; write the state `new`."""
    for e in range(tables.measure.shape[0]):
        _, _, _, _, _, c = point_response(tables, sections, e, step.end, step.duration, old, new)
        tangent[e, 0, 0], tangent[e, 0, 1], tangent[e, 0, 2] = c[0], c[1], c[2]
        tangent[e, 1, 0], tangent[e, 1, 1], tangent[e, 1, 2] = c[1], c[3], c[4]
        tangent[e, 2, 0], tangent[e, 2, 1], tangent[e, 2, 2] = c[2], c[4], c[5]


@njit(cache=True, error_model="numpy")
def sinc(x):
    """sin(x)/x and its derivative."""
    if abs(x) < SMALL_TURN:
        square = x * x
        return 1.0 - square / 6.0 + square * square / 120.0, x * (-1.0 / 3.0 + square / 30.0)
    value = math.sin(x) / x
    return value, (math.cos(x) - value) / x


@njit(cache=True, error_model="numpy")
def assemble(step, positions, tables, sections, old, new):
    """Add forces, and the tangent if asked for, of all elements for a `step`; write `new`.

    Arguments: `positions` (e, 36) of the elements in the band; then the group's tables and its
    committed and trial states.
    """
    force, weight = step.force, step.weight
    reduced = np.empty((4, 4))
    right = np.empty((3, 4))
    for e in range(tables.dofs.shape[0]):
        dofs, g = tables.dofs[e], tables.gradients[e]
        h, dx = tables.values[e], tables.measure[e]
        Dx, Dy = tables.director[e, 0], tables.director[e, 1]
        r1x, r1y, turn1, a1x, a1y, section_tangent = point_response(
            tables, sections, e, step.end, step.duration, old, new
        )
        gamma1, gamma2 = new.strain[e, 0], new.strain[e, 1]
        N, V, M = new.stress[e, 0], new.stress[e, 1], new.stress[e, 2]
        c00, c01, c02, c11, c12, c22 = section_tangent
        if step.dynamic:
            r0x, r0y, turn0, _ = point_state(tables, e, step.start)
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
        if not step.tangent:
            continue
        share = weight * dx
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
        if step.dynamic:
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
        spread(step.band, positions[e], reduced, g, h)


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
    """Energies of a step from the committed to the trial state of a group, see `StepEnergies`."""
    stored = plastic = algorithmic = ideal = 0.0
    for e in range(tables.measure.shape[0]):
        parts = section_energies(
            sections,
            sections.of[e],
            weight,
            tables.measure[e],
            old.strain[e],
            new.strain[e],
            old.fibers[e],
            new.fibers[e],
        )
        stored += parts[0]
        plastic += parts[1]
        algorithmic += parts[2]
        ideal += parts[3]
    return stored, plastic, algorithmic, ideal
