"""Force-based element: exact bending moments, sections of fibers at points along the element.

N and M(x) = (x/L - 1) M_1 + x/L M_4 are in equilibrium whatever yields. Section strains e_p and
forces Q are unknown: s(e_p) = b_p Q at every point and sum w_p L b_p^T e_p + F_r Q = q, with the
flexibility F_r of joints and of elastic shear. It is the minimum of a convex energy under the
latter constraint; Newton's steps keep to it and are cut where the energy would rise again.
Sources: Spacone, Filippou and Taucer 1996; the line search is ours.
"""

import numpy as np

from workbench.base.compiled import njit
from workbench.extras.frame_models.bars.resultant_kernels import (
    resultant_energies,
    resultant_response,
)
from workbench.mechanics.structures.fibers.kernels import section_energies, section_response
from workbench.mechanics.structures.kernels import add_element, deform

ITERATIONS = 200
CUTS = 12
CLOSED = 1e-10  # of squash load and elastic moment
# fibers that switch between elastic and plastic at one strain keep steps from closing further
PATIENT, STALLED = 60, 1e-5


@njit(cache=True, error_model="numpy")
def respond(tables, e, p, duration, strain, old, new):
    """N, M and tangent NN, NM, MM of a point at `strain` (2,): axial strain and curvature."""
    if tables.elastic[e, p]:
        area, second = tables.modulus[e] * tables.area[e], tables.modulus[e] * tables.second[e]
        return area * strain[0], second * strain[1], area, 0.0, second
    if tables.resultants.shape[0] > 0:
        return resultant_response(tables.resultants[e], strain, old[p], new[p])
    strains = strain[0], 0.0, strain[1]  # yields at the end of a step
    n, _, m, c00, _, c02, _, _, c22 = section_response(
        tables.sections, tables.sections.of[e], 1.0, duration, strains, old[p], new[p]
    )
    return n, m, c00, c02, c22


@njit(cache=True, error_model="numpy")
def rise(tables, e, duration, strains, change, carried, onwards, goal, old, new):
    """Derivative of the energy along a `change` of strains (points, 2) at `strains`.

    Arguments: forces `carried` (3,) by joints and shear, and their change `onwards`; strains are
    weighted by the length of the element. The forces of the `goal` are taken off, whose work on the
    change is zero but for rounding, which would be more than what is sought.
    """
    total = onwards @ (tables.rest[e] @ (carried - goal))
    xi = tables.xi[e]
    for p in range(strains.shape[0]):
        n, m, _, _, _ = respond(tables, e, p, duration, strains[p], old, new)
        dn, dm = n - goal[0], m - (xi[p] - 1.0) * goal[1] - xi[p] * goal[2]
        total += tables.weights[e, p] * tables.lengths[e] * (dn * change[p, 0] + dm * change[p, 1])
    return total


@njit(cache=True, error_model="numpy")
def force_law(tables, e, duration, old, new, k):
    """Forces of element `e` at the deformations of the state `new` from the committed `old` one.

    Writes forces, strains and fibers of `new`, see `FiberBarState`, and the tangent `k` (3, 3); NaN
    forces mean that there is no solution.
    """
    q, Q, strains = new.deformation[e], new.local[e], new.strains[e]
    before, after = old.fibers[e], new.fibers[e]
    Q[:], strains[:] = old.local[e], old.strains[e]
    points = strains.shape[0]
    pinned, xi, weights = tables.pinned[e], tables.xi[e], tables.weights[e]
    loose, change = np.empty((points, 2)), np.empty((points, 2))
    soft = np.empty((points, 3))
    carried, F, gap = Q.copy(), np.empty((3, 3)), np.empty(3)
    for count in range(ITERATIONS):
        F[:] = tables.rest[e]
        gap[:] = q - F @ Q
        worst = 0.0
        for p in range(points):
            n, m, c00, c02, c22 = respond(tables, e, p, duration, strains[p], before, after)
            b1, b4, w = xi[p] - 1.0, xi[p], weights[p] * tables.lengths[e]
            dn, dm = Q[0] - n, b1 * Q[1] + b4 * Q[2] - m
            worst = max(worst, abs(dn) / tables.scale[e, 0], abs(dm) / tables.scale[e, 1])
            if count == 0 and tables.resultants.shape[0] > 0:
                # elastic first: a surface left with its plastic tangent is left by far too much
                c00, c02, c22 = tables.resultants[e].axial, 0.0, tables.resultants[e].bending
            det = c00 * c22 - c02 * c02
            f00, f02, f22 = c22 / det, -c02 / det, c00 / det
            soft[p, 0], soft[p, 1], soft[p, 2] = f00, f02, f22
            loose[p, 0], loose[p, 1] = f00 * dn + f02 * dm, f02 * dn + f22 * dm
            strain, curvature = w * (strains[p, 0] + loose[p, 0]), w * (strains[p, 1] + loose[p, 1])
            gap[0] -= strain
            gap[1] -= b1 * curvature
            gap[2] -= b4 * curvature
            F[0, 0] += w * f00
            F[0, 1] += w * b1 * f02
            F[0, 2] += w * b4 * f02
            F[1, 1] += w * b1 * b1 * f22
            F[1, 2] += w * b1 * b4 * f22
            F[2, 2] += w * b4 * b4 * f22
        F[1, 0], F[2, 0], F[2, 1] = F[0, 1], F[0, 2], F[1, 2]
        for i in range(1, 3):
            if pinned[i - 1]:
                F[i, :] = 0.0
                F[:, i] = 0.0
                F[i, i] = 1.0
                gap[i] = 0.0
        if not np.isfinite(F.sum()):
            break
        k[:] = np.linalg.inv(F)
        step = k @ gap
        if count > 0 and worst <= (CLOSED if count < PATIENT else STALLED):
            for i in range(1, 3):
                if pinned[i - 1]:
                    k[i, i] = 0.0
            return
        goal = Q + step
        for p in range(points):
            dn, dm = step[0], (xi[p] - 1.0) * step[1] + xi[p] * step[2]
            change[p, 0] = loose[p, 0] + soft[p, 0] * dn + soft[p, 1] * dm
            change[p, 1] = loose[p, 1] + soft[p, 1] * dn + soft[p, 2] * dm
        t = 1.0
        if count > 0:  # the first step, elastic or not, makes strains compatible
            on = goal - carried
            first = abs(
                rise(tables, e, duration, strains, change, carried, on, goal, before, after)
            )
            low, fall, high, climb = 0.0, -first, 1.0, np.inf
            for _ in range(CUTS):
                there, at = carried + t * on, strains + t * change
                end = rise(tables, e, duration, at, change, there, on, goal, before, after)
                if end > 0.5 * first:
                    high, climb = t, end
                elif end < -0.5 * first and t < 1.0:
                    low, fall = t, end
                else:
                    break
                # between the secant, which a kink leaves far from the minimum, and the middle
                t = 0.5 * (low - fall * (high - low) / (climb - fall)) + 0.25 * (low + high)
        strains += t * change
        carried += t * (goal - carried)
        Q[:] = goal
    Q[:] = np.nan


@njit(cache=True, error_model="numpy")
def assemble(step, bars, tables, old, new):
    """Add forces and tangents of all elements for a `step`; write the state `new`."""
    k, work = np.empty((3, 3)), np.empty((7, 4))
    for e in range(bars.dofs.shape[0]):
        chord = deform(bars, e, step.end, new.deformation[e])
        force_law(tables, e, step.duration, old, new, k)
        add_element(step, bars, e, chord, old.local[e], new.local[e], k, work)


@njit(cache=True, error_model="numpy")
def account(weight, bars, tables, old, new):
    """Energies of a step from the committed to the trial state of a group, see `StepEnergies`."""
    stored = plastic = algorithmic = ideal = 0.0
    for e in range(bars.lengths.shape[0]):
        rest, change = tables.rest[e], new.local[e] - old.local[e]
        stored += 0.5 * new.local[e] @ (rest @ new.local[e])
        algorithmic += (weight - 0.5) * change @ (rest @ change)
        for p in range(tables.xi.shape[1]):
            dx = tables.weights[e, p] * bars.lengths[e]
            before, after = old.strains[e, p], new.strains[e, p]
            if tables.elastic[e, p]:
                E, d0, d1 = tables.modulus[e], after[0] - before[0], after[1] - before[1]
                axial, bending = E * tables.area[e], E * tables.second[e]
                stored += 0.5 * dx * (axial * after[0] ** 2 + bending * after[1] ** 2)
                algorithmic += (weight - 0.5) * dx * (axial * d0 * d0 + bending * d1 * d1)
                continue
            states = old.fibers[e, p], new.fibers[e, p]
            if tables.resultants.shape[0] > 0:
                row = tables.resultants[e]
                parts = resultant_energies(row, weight, dx, before, after, *states)
                ideal += parts[3]
            else:
                s, start, end = (
                    tables.sections.of[e],
                    (before[0], 0.0, before[1]),
                    (after[0], 0.0, after[1]),
                )
                parts = section_energies(tables.sections, s, weight, dx, start, end, *states)
                ideal += section_energies(tables.sections, s, 1.0, dx, start, end, *states)[1]
            stored += parts[0]
            plastic += parts[1]
            algorithmic += parts[2]
    return stored, plastic, algorithmic, ideal
