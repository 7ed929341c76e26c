"""The Bernoulli beam element with fiber sections: local law, group assembly, energy ledger.

Symbols: eps = u/L - y (b1 theta_1 + b2 theta_2) with b1 = (6 xi - 4)/L and b2 = (6 xi - 2)/L at
the point xi along the element; N = sum(sigma A), M = -sum(sigma y A). Source: Heng 2017, 2.1.
"""

import math
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.mechanics.structures.corotation_kernels import add_element, chord_at
from workbench.mechanics.structures.fibers.kernels import section_energies, section_response

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
