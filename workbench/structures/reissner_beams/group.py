"""The group object: all geometrically exact beams of a structure, with two state buffers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.structures.ledger import StepEnergies
from workbench.structures.reissner_beams import _kernels
from workbench.structures.reissner_beams.section import BeamSection, section_tables
from workbench.structures.reissner_beams.tables import LineTables, line_basis, line_tables

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class BeamState(NamedTuple):
    """State of all elements: `fibers` (e, states, f); `stress` (e, 3) N, V, M; `strain` (e, 3)."""

    fibers: Array
    stress: Array
    strain: Array


class ReissnerBeams:
    """Two-node geometrically exact beams with one point; states are committed by a swap.

    Arguments: `nodes` (elements, 2), node numbers; `section_of` (elements,), which of `sections`
    each element has; `sections`. Raises `InputError` from the laws of the sections.
    """

    crumples = False  # a short element turns into a hinge that may shorten by more than its length

    def __init__(
        self, nodes: ArrayLike, section_of: ArrayLike, sections: Sequence[BeamSection]
    ) -> None:
        self.nodes: Indices = np.asarray(nodes, dtype=np.int64).reshape(-1, 2)
        self.sections = tuple(sections)
        self._sections = section_tables(np.asarray(section_of, dtype=np.int64), self.sections)
        count, fibers = len(self.nodes), self._sections.y.shape[1]
        states = max(section.law.states for section in sections)
        self._old, self._new = (
            BeamState(np.zeros((count, states, fibers)), np.zeros((count, 3)), np.zeros((count, 3)))
            for _ in range(2)
        )
        self._duration = np.inf

    def place(self, dofs: Indices, chords: Array) -> None:
        """Take from the assembly the dofs (elements, 6) and initial chords (elements, 2) in m."""
        self.lengths: Array = np.hypot(chords[:, 0], chords[:, 1])
        self.basis = line_basis(self.lengths)
        self._tables = line_tables(self.basis, dofs, chords)

    @property
    def tables(self) -> LineTables:
        """The discretisation as the kernel sees it."""
        return self._tables

    def begin_step(self, duration: float) -> None:
        """Take the duration of the step to come, in s, for laws that depend on the rate."""
        self._duration = duration

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
        self._kernel(force, band, positions, start, end, weight, True)

    def resist(self, force: Array, end: Array) -> None:
        """Add the forces at the displacements `end` alone, for explicit time steps."""
        self._kernel(force, _NO_BAND, _NO_POSITIONS, end, end, None, False)

    def _kernel(
        self,
        force: Array,
        band: Array,
        positions: Indices,
        start: Array,
        end: Array,
        weight: float | None,
        tangent: bool,
    ) -> None:
        _kernels.assemble(
            force,
            band,
            positions,
            start,
            end,
            1.0 if weight is None else weight,
            weight is not None,
            tangent,
            self._duration,
            self._tables,
            self._sections,
            self._old,
            self._new,
        )

    def respond(self, end: Array) -> tuple[Array, Array, Array, Array]:
        """Strains (e, 3), section forces at both ends of the step (e, 3) and tangents (e, 3, 3).

        For assembly by other means at the displacements `end`; keeps the trial state as
        `assemble` does. The second and third entry are the committed and the trial forces.
        """
        tangent = np.empty((len(self.nodes), 3, 3))
        _kernels.strains(self._tables, end, self._new.strain)
        _kernels.respond(self._duration, self._sections, self._old, self._new, tangent)
        return self._new.strain, self._old.stress, self._new.stress, tangent

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        return StepEnergies(
            *_kernels.account(weight, self._tables, self._sections, self._old, self._new)
        )

    def commit(self) -> None:
        """Make the state assembled last the committed one."""
        self._old, self._new = self._new, self._old

    def masses(self) -> tuple[Array, Array]:
        """Mass (kg) and rotary inertia (kg m2) of every element, (elements,) each."""
        of = self._sections.of
        mass = np.array([s.mass_per_length for s in self.sections])[of] * self.lengths
        return mass, mass * np.array([s.radius_squared for s in self.sections])[of]

    @property
    def strains(self) -> Array:
        """Committed axial and shear strain and curvature of the elements (elements, 3)."""
        return self._old.strain

    @property
    def section_forces(self) -> Array:
        """Committed N, V, M of the elements (elements, 3)."""
        return self._old.stress

    @property
    def fiber_states(self) -> Array:
        """Committed states of the fibers (elements, states, fibers); the first: plastic strain."""
        return self._old.fibers

    @property
    def local_forces(self) -> Array:
        """Committed N and end moments M1, M2 (elements, 3); internal moments are -M1 and M2."""
        force, strain = self._old.stress, self._old.strain
        N, V, M = force.T
        mean = 0.5 * self.lengths * (N * strain[:, 1] - V * (1.0 + strain[:, 0]))
        return np.stack([N, mean - M, mean + M], axis=1)

    @property
    def elongations(self) -> Array:
        """Committed change of length of the axis of the elements (elements,), in m."""
        return np.asarray(self._old.strain[:, 0] * self.lengths)

    @property
    def shear_forces(self) -> Array:
        """Committed shear force of the elements (elements,), in N."""
        return self._old.stress[:, 1]

    @property
    def shear_strains(self) -> Array:
        """Committed shear strain of the elements (elements,)."""
        return self._old.strain[:, 1]

    def plastic_rotations(self) -> Array:
        """Committed plastic curvature integrated over each element (elements,), in rad."""
        result = np.zeros(len(self.nodes))
        _kernels.plastic_rotations(self._tables, self._sections, self._old.fibers, result)
        return result


_NO_BAND: Array = np.zeros(1)
_NO_POSITIONS: Indices = np.zeros((1, 36), dtype=np.int64)
