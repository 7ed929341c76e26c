"""Compiled loops over the elements of the solid: forces, tangents and energies of a step."""

from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.base.compiled import njit
from workbench.models.references.solid.material import (
    SQUEEZE_STIFFNESS,
    SQUEEZED,
    SolidSteel,
    Tensor,
    add_return_tangent,
    add_squeeze_tangent,
    nominal_stress,
    nominal_tangent,
    return_mapping,
    squeeze,
    stretched,
)


class Elements(NamedTuple):
    """Nine-node quadrilaterals.

    `gradients` (elements, points, 2, nodes) of the shape functions by x and y, in 1/m; `weights`
    (elements, points), thickness times area, in m3; `dofs` (elements, 2 nodes), x and y in turn.
    """

    gradients: Array
    weights: Array
    dofs: Indices


class State(NamedTuple):
    """State of the points.

    `plastic` strain (elements, points, 3), equivalent plastic strain `hardened` (elements, points),
    Biot `stress` without squeeze guard (Pa) and `strain`, both as `plastic`.
    """

    plastic: Array
    hardened: Array
    stress: Array
    strain: Array


class Energies(NamedTuple):
    """Elastic energy at the end of a step and plastic work of the step, both in J.

    The plastic work takes the mean of the stresses at both ends. NaN where a point has no answer:
    it is turned inside out, or its return does not converge.
    """

    stored: float
    plastic: float


def empty_state(elements: Elements) -> State:
    """Points that nothing has happened to."""
    tensor = (*elements.weights.shape, 3)
    return State(
        np.zeros(tensor), np.zeros(elements.weights.shape), np.zeros(tensor), np.zeros(tensor)
    )


@njit(cache=True, error_model="numpy")
def respond(
    elements: Elements,
    u: Array,
    old: State,
    new: State,
    steel: SolidSteel,
    force: Array,
    matrices: Array,
) -> Energies:
    """Add the nodal forces of all elements to `force` (dofs,) and keep the trial state in `new`.

    Arguments: displacements `u` (dofs,) in m; committed state `old`; `matrices` (elements, dofs of
    one, dofs of one) for the tangents, empty where they are of no interest.
    """
    gradients, weights, dofs = elements
    nodes = gradients.shape[3]
    tangents = len(matrices) > 0
    moved, nodal = np.empty(2 * nodes), np.empty(2 * nodes)
    C, D, K = np.empty((3, 3)), np.empty((3, 4)), np.empty((4, 4))
    stored = plastic = 0.0
    for e in range(len(weights)):
        for a in range(2 * nodes):
            moved[a] = u[dofs[e, a]]
            nodal[a] = 0.0
        if tangents:
            matrices[e] = 0.0
        for g in range(weights.shape[1]):
            slope = gradients[e, g]
            f11, f12, f21, f22 = 1.0, 0.0, 0.0, 1.0
            for a in range(nodes):
                f11 += slope[0, a] * moved[2 * a]
                f12 += slope[1, a] * moved[2 * a]
                f21 += slope[0, a] * moved[2 * a + 1]
                f22 += slope[1, a] * moved[2 * a + 1]
            stretch = stretched(f11, f12, f21, f22)
            if not (stretch.trace > 0.0 and stretch.area > 0.0):
                return Energies(np.nan, np.nan)
            e1, e2, e3 = stretch.strain
            p1, p2, p3 = old.plastic[e, g]
            elastic = Tensor(e1 - p1, e2 - p2, e3 - p3)
            back = return_mapping(elastic, old.hardened[e, g], steel)
            if not np.isfinite(back.hardened):
                return Energies(np.nan, np.nan)
            weight = weights[e, g]
            t1, t2, t3 = back.stress
            d1, d2, d3 = back.flow
            before = old.stress[e, g]
            work = (before[0] + t1) * d1 + (before[1] + t2) * d2 + (before[2] + t3) * d3
            plastic += 0.5 * weight * work
            density = t1**2 + t2**2 - 2.0 * steel.poisson * t1 * t2
            density = (0.5 * density + (1.0 + steel.poisson) * t3**2) / steel.modulus
            keep(new, e, g, stretch.strain, back.stress, Tensor(p1 + d1, p2 + d2, p3 + d3))
            new.hardened[e, g] = back.hardened
            stress = back.stress
            squeezed = stretch.area < SQUEEZED
            if squeezed:
                s1, s2, s3 = squeeze(stretch, steel.modulus)
                stress = Tensor(t1 + s1, t2 + s2, t3 + s3)
                logarithm = np.log(SQUEEZED / stretch.area)
                density += 0.5 * SQUEEZE_STIFFNESS * steel.modulus * logarithm**2
            stored += weight * density
            n11, n12, n21, n22 = nominal_stress(stretch, stress)
            for a in range(nodes):
                nodal[2 * a] += weight * (n11 * slope[0, a] + n12 * slope[1, a])
                nodal[2 * a + 1] += weight * (n21 * slope[0, a] + n22 * slope[1, a])
            if tangents:
                C[:] = 0.0
                add_return_tangent(back, steel, C)
                if squeezed:
                    add_squeeze_tangent(stretch, steel.modulus, C)
                nominal_tangent(stretch, stress, C, D, K)
                add_stiffness(slope, weight, K, matrices[e])
        for a in range(2 * nodes):
            force[dofs[e, a]] += nodal[a]
    return Energies(stored, plastic)


@njit(cache=True, error_model="numpy")
def keep(new: State, e: int, g: int, strain: Tensor, stress: Tensor, plastic: Tensor) -> None:
    """Write what a point has come to."""
    for i in range(3):
        new.strain[e, g, i] = strain[i]
        new.stress[e, g, i] = stress[i]
        new.plastic[e, g, i] = plastic[i]


@njit(cache=True, error_model="numpy")
def add_stiffness(slope: Array, weight: float, K: Array, matrix: Array) -> None:
    """Add the stiffness of a point with tangent K (4, 4) to that of its element."""
    nodes = slope.shape[1]
    for a in range(nodes):
        for i in range(2):
            for j in range(2):
                x = weight * (slope[0, a] * K[2 * i, 2 * j] + slope[1, a] * K[2 * i + 1, 2 * j])
                y = slope[0, a] * K[2 * i, 2 * j + 1] + slope[1, a] * K[2 * i + 1, 2 * j + 1]
                y *= weight
                for b in range(nodes):
                    matrix[2 * a + i, 2 * b + j] += x * slope[0, b] + y * slope[1, b]
