"""The geometrically exact beam element with one point: assembly and energy ledger.

Symbols: r' = dx/ds, director a = (cos phi, sin phi), b normal to it, phi the initial angle plus
the rotation theta at the point; strains Gamma_1 = r'.a - 1, Gamma_2 = r'.b, kappa = theta'; forces
N, V, M. Over a time step x = (theta_1 - theta_0)/2, a_m and b_m at the mean angle, and
  dGamma_1 = cos x a_m.dr' + (r'_mean.b_m)(sin x / x) dtheta,
  dGamma_2 = cos x b_m.dr' - (r'_mean.a_m)(sin x / x) dtheta
are exact, so that the work of the element forces is that of the weighted section forces.
Sources: Reissner 1972; Simo 1985; discrete gradients after Simo, Tarnow and Doblare 1995.
"""

import math

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.structures.fibers.kernels import section_energies, section_response

SMALL_TURN = 1e-3  # rad; below it sin(x)/x is taken from its series


@njit(cache=True, error_model="numpy", forceinline=True)
def point_state(bars, e, x):
    """Stretch r', rotation, curvature and initial director of element `e` at displacements `x`."""
    i1, i2, i3, i4, i5, i6 = bars.dofs[e]
    Dx, Dy, L = bars.chords[e, 0], bars.chords[e, 1], bars.lengths[e]
    rx, ry = (Dx + (x[i4] - x[i1])) / L, (Dy + (x[i5] - x[i2])) / L
    return rx, ry, 0.5 * (x[i3] + x[i6]), (x[i6] - x[i3]) / L, Dx / L, Dy / L


@njit(cache=True, error_model="numpy")
def sinc(x):
    """sin(x)/x and its derivative."""
    if abs(x) < SMALL_TURN:
        square = x * x
        return 1.0 - square / 6.0 + square * square / 120.0, x * (-1.0 / 3.0 + square / 30.0)
    value = math.sin(x) / x
    return value, (math.cos(x) - value) / x


@njit(cache=True, error_model="numpy")
def assemble(step, bars, sections, old, new):
    """Add forces, and the tangent if asked for, of all elements for a `step`; write `new`."""
    force, weight = step.force, step.weight
    reduced = np.empty((4, 4))
    right = np.empty((3, 4))
    for e in range(bars.lengths.shape[0]):
        dofs, dx = bars.dofs[e], bars.lengths[e]
        r1x, r1y, turn1, kappa, Dx, Dy = point_state(bars, e, step.end)
        c, s = math.cos(turn1), math.sin(turn1)
        a1x, a1y = Dx * c - Dy * s, Dy * c + Dx * s
        gamma1 = r1x * a1x + r1y * a1y - 1.0
        gamma2 = r1y * a1x - r1x * a1y
        before, rest = old.strain[e], 1.0 - weight
        within = (
            rest * before[0] + weight * gamma1,
            rest * before[1] + weight * gamma2,
            rest * before[2] + weight * kappa,
        )
        N, V, M, c00, c01, c02, c11, c12, c22 = section_response(
            sections, sections.of[e], weight, step.duration, within, old.fibers[e], new.fibers[e]
        )
        new.stress[e, 0], new.stress[e, 1], new.stress[e, 2] = N, V, M
        new.strain[e, 0], new.strain[e, 1], new.strain[e, 2] = gamma1, gamma2, kappa
        if step.dynamic:
            r0x, r0y, turn0, _, _, _ = point_state(bars, e, step.start)
            half, mid = 0.5 * (turn1 - turn0), 0.5 * (turn1 + turn0)
            c, s = math.cos(mid), math.sin(mid)
            amx, amy = Dx * c - Dy * s, Dy * c + Dx * s
            rmx, rmy = 0.5 * (r0x + r1x), 0.5 * (r0y + r1y)
            sc, slope = sinc(half)
            cx = math.cos(half)
            ax, ay = cx * amx, cx * amy
            along, across = rmx * amx + rmy * amy, rmy * amx - rmx * amy
            turn_1, turn_2 = sc * across, -sc * along
        else:
            ax, ay = a1x, a1y
            turn_1, turn_2 = gamma2, -(1.0 + gamma1)
        # with b = (-a_y, a_x): what works on r' and on theta
        fx, fy = N * ax - V * ay, N * ay + V * ax
        moment = 0.5 * dx * (N * turn_1 + V * turn_2)
        force[dofs[0]] -= fx
        force[dofs[1]] -= fy
        force[dofs[2]] += moment - M
        force[dofs[3]] += fx
        force[dofs[4]] += fy
        force[dofs[5]] += moment + M
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
        spread(step.band, bars.positions[e], reduced, dx)


@njit(cache=True, error_model="numpy")
def spread(band, positions, reduced, length):
    """Add the tangent `reduced` over (r'_x, r'_y, theta, kappa) to the band, for all six dofs.

    Dof k of node i counts +-1 / length in r' (k = 0, 1), and 1/2 in theta with +-1 / length in
    kappa (k = 2).
    """
    h = 0.5
    for i in range(2):
        for j in range(2):
            at = 18 * i + 3 * j
            gi, gj = (2 * i - 1) / length, (2 * j - 1) / length
            gg = gi * gj
            band[positions[at]] += gg * reduced[0, 0]
            band[positions[at + 1]] += gg * reduced[0, 1]
            band[positions[at + 6]] += gg * reduced[1, 0]
            band[positions[at + 7]] += gg * reduced[1, 1]
            gh, hg, hh = gi * h, h * gj, h * h
            band[positions[at + 2]] += gh * reduced[0, 2] + gg * reduced[0, 3]
            band[positions[at + 8]] += gh * reduced[1, 2] + gg * reduced[1, 3]
            band[positions[at + 12]] += hg * reduced[2, 0] + gg * reduced[3, 0]
            band[positions[at + 13]] += hg * reduced[2, 1] + gg * reduced[3, 1]
            band[positions[at + 14]] += (
                hh * reduced[2, 2] + hg * reduced[2, 3] + gh * reduced[3, 2] + gg * reduced[3, 3]
            )


@njit(cache=True, error_model="numpy")
def account(weight, bars, sections, old, new):
    """Energies of a step from the committed to the trial state of a group, see `StepEnergies`."""
    stored = plastic = algorithmic = ideal = 0.0
    for e in range(bars.lengths.shape[0]):
        states = old.strain[e], new.strain[e], old.fibers[e], new.fibers[e]
        parts = section_energies(sections, sections.of[e], weight, bars.lengths[e], *states)
        stored += parts[0]
        plastic += parts[1]
        algorithmic += parts[2]
        ideal += parts[3]
    return stored, plastic, algorithmic, ideal
