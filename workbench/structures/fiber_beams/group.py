"""The group object: all fiber beams of a structure, with two state buffers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.structures.fiber_beams import _kernels
from workbench.structures.ledger import StepEnergies

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class FiberSection:
    """A layered cross section with its material, in SI units.

    Arguments: fiber ordinates `y` (f,) and areas `area` (f,); `elastic_modulus`, `yield_stress`
    and the kinematic `hardening_modulus` in Pa; `mass_per_length` in kg/m; elastic
    `shear_stiffness` GA in N, or 0 for a beam without shear strain. Rotary inertia per length is
    the mass times I / A of the fibers.
    """

    y: Array
    area: Array
    elastic_modulus: float
    yield_stress: float
    hardening_modulus: float
    mass_per_length: float
    shear_stiffness: float = 0.0

    @property
    def radius_squared(self) -> float:
        """Square of the radius of gyration, I / A, in m2."""
        return float(np.sum(self.y**2 * self.area) / np.sum(self.area))


class Rule(NamedTuple):
    """Quadrature along the elements: `abscissae` in 0..1 and `weights`, (elements, points)."""

    abscissae: Array
    weights: Array


def gauss_rule(elements: int, points: int = 2) -> Rule:
    """The same Gauss-Legendre points in every element."""
    abscissae, weights = np.polynomial.legendre.leggauss(points)
    tile = (elements, 1)
    return Rule(np.tile(0.5 * (1.0 + abscissae), tile), np.tile(0.5 * weights, tile))


def radau_rule(hinge_at_end: ArrayLike) -> Rule:
    """Two Gauss-Radau points: one at the end where a hinge is expected, one a third from the other.

    Argument: `hinge_at_end` (elements,), True for end 2, False for end 1. Elastic stiffness is
    exact as with two Gauss points, and the plastic section is sampled where the moment is
    largest, so that the moment capacity at that end has no error of the order of the length.
    """
    at_end = np.asarray(hinge_at_end, dtype=bool)[:, None]
    abscissae = np.where(at_end, [[1.0 / 3.0, 1.0]], [[0.0, 2.0 / 3.0]])
    weights = np.where(at_end, [[0.75, 0.25]], [[0.25, 0.75]])
    return Rule(abscissae, weights)


@dataclass
class _State:
    plastic: Array  # (elements, points, fibers) plastic strain
    local: Array  # (elements, 3) N, M1, M2
    strains: Array  # (elements, 5) elongation, bending rotations, shear strain, axial amplitude


class FiberBeams:
    """Two-node co-rotational Bernoulli beams; states are committed by swapping two buffers.

    Arguments: `nodes` (elements, 2), node numbers; `section_of` (elements,), which of `sections`
    each element has; `sections`; `rule`, points along each element (default: two Gauss points);
    `balanced`: the axial strain differs between the two points such that N is the same (without
    it the axial displacement is linear, as in the classical displacement-based element).
    """

    crumples = True  # the direction of a chord without length is undefined

    def __init__(
        self,
        nodes: ArrayLike,
        section_of: ArrayLike,
        sections: Sequence[FiberSection],
        rule: Rule | None = None,
        balanced: bool = False,
    ) -> None:
        self.nodes: Indices = np.asarray(nodes, dtype=np.int64).reshape(-1, 2)
        self.section_of: Indices = np.asarray(section_of, dtype=np.int64)
        self.sections = tuple(sections)
        fibers = max(len(section.y) for section in sections)
        self._y = np.zeros((len(sections), fibers))
        self._area = np.zeros((len(sections), fibers))  # shorter sections get empty fibers
        for i, section in enumerate(sections):
            self._y[i, : len(section.y)] = section.y
            self._area[i, : len(section.y)] = section.area
        self._steel = np.array(
            [[s.elastic_modulus, s.yield_stress, s.hardening_modulus] for s in sections]
        )
        self._shear = np.array([section.shear_stiffness for section in sections])
        self._second = np.sum(self._y**2 * self._area, axis=1)
        rule = gauss_rule(len(self.nodes)) if rule is None else rule
        self._xi, self._weights = rule.abscissae, rule.weights
        self._spread = np.zeros_like(self._weights)
        if balanced:
            if self._xi.shape[1] != 2:
                raise ValueError("the axial force can be balanced between two points only")
            # no mean: sum(w spread) = 0
            self._spread = self._weights[:, ::-1] * np.array([1.0, -1.0])
        shape = (len(self.nodes), self._xi.shape[1], fibers)
        self._old = self._empty(shape)
        self._new = self._empty(shape)
        self.dofs: Indices = np.zeros((0, 6), dtype=np.int64)
        self.chords: Array = np.zeros((0, 2))
        self.lengths: Array = np.zeros(0)

    @staticmethod
    def _empty(shape: tuple[int, int, int]) -> _State:
        return _State(np.zeros(shape), np.zeros((shape[0], 3)), np.zeros((shape[0], 5)))

    def place(self, dofs: Indices, chords: Array) -> None:
        """Take from the assembly the dofs (elements, 6) and initial chords (elements, 2) in m."""
        self.dofs = np.ascontiguousarray(dofs)
        self.chords = np.ascontiguousarray(chords)
        self.lengths = np.hypot(chords[:, 0], chords[:, 1])

    def assemble(
        self,
        force: Array,
        band: Array,
        positions: Indices,
        start: Array,
        end: Array,
        weight: float | None,
    ) -> None:
        """Add forces and tangent at the displacements `end`, from the committed state.

        Arguments: `force` (dofs,) and flat `band` to add to; `positions` (elements, 36) in it;
        committed displacements `start`; `weight` of the end state in the energy-exact forces of a
        time step, None for equilibrium at the end.
        """
        _kernels.assemble(
            force,
            band,
            start,
            end,
            1.0 if weight is None else weight,
            weight is not None,
            self.dofs,
            positions,
            self.chords,
            self.lengths,
            self.section_of,
            self._y,
            self._area,
            self._steel,
            self._shear,
            self._second,
            self._xi,
            self._weights,
            self._spread,
            self._old.plastic,
            self._old.local,
            self._old.strains,
            self._new.plastic,
            self._new.local,
            self._new.strains,
        )

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        return StepEnergies(
            *_kernels.account(
                weight,
                self.lengths,
                self.section_of,
                self._y,
                self._area,
                self._steel,
                self._shear,
                self._xi,
                self._weights,
                self._spread,
                self._old.plastic,
                self._old.strains,
                self._new.plastic,
                self._new.strains,
            )
        )

    def commit(self) -> None:
        """Make the state assembled last the committed one."""
        self._old, self._new = self._new, self._old

    def masses(self) -> tuple[Array, Array]:
        """Mass (kg) and rotary inertia (kg m2) of every element, (elements,) each."""
        mass = np.array([s.mass_per_length for s in self.sections])[self.section_of] * self.lengths
        radius = np.array([s.radius_squared for s in self.sections])[self.section_of]
        return mass, mass * radius

    @property
    def local_forces(self) -> Array:
        """Committed N, M1, M2 of the elements (elements, 3); internal moments are -M1 and M2."""
        return self._old.local

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return self._old.strains[:, 0]

    @property
    def shear_forces(self) -> Array:
        """Committed shear force (M1 + M2) / l of the elements (elements,), in N."""
        local, state = self._old.local, self._old.strains
        return np.asarray((local[:, 1] + local[:, 2]) / (self.lengths + state[:, 0]))

    @property
    def shear_strains(self) -> Array:
        """Committed elastic shear strain of the elements (elements,)."""
        return self._old.strains[:, 3]

    @property
    def plastic_strains(self) -> Array:
        """Committed plastic strains (elements, points, fibers)."""
        return self._old.plastic

    @plastic_strains.setter
    def plastic_strains(self, values: ArrayLike) -> None:
        self._old.plastic[:] = values

    def plastic_rotations(self) -> Array:
        """Committed plastic curvature integrated over each element (elements,), in rad."""
        result = np.zeros(len(self.nodes))
        _kernels.plastic_rotations(
            self.lengths,
            self.section_of,
            self._y,
            self._area,
            self._weights,
            self._old.plastic,
            result,
        )
        return result
