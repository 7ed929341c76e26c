"""The group object: all superelements of a structure, with two state buffers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.structures.ledger import StepEnergies
from workbench.structures.superelements import _kernels
from workbench.structures.superelements.element import Superelement

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
REGULARISATION = 1e-6  # share of elastic stiffness; below 1e-5 a frame's peak changes by < 0.1 %


class SuperelementState(NamedTuple):
    """State of all elements.

    `plastic` (e, 4): u, theta of hinge 1, then of hinge 4; `carried` (e, 3): N, M_1, M_4 of hinges
    and bar; `local` (e, 3), the same with the regularising stiffness; `deformation` (e, 3):
    elongation and end rotations against the chord; `rate` (e,): angular velocity of the chord.
    """

    plastic: Array
    carried: Array
    local: Array
    deformation: Array
    rate: Array


class Superelements:
    """Two-node superelements; states are committed by swapping two buffers.

    Arguments: `nodes` (elements, 2), node numbers; `section_of` (elements,), which of `sections`
    each element is; `regularisation`, the share of the elastic stiffness that acts beside the
    perfectly plastic hinges and keeps the tangent of a mechanism regular; `first_order`,
    equilibrium of the undeformed structure (shapes are then drawn with the chords as they move).
    """

    crumples = True  # the direction of a chord without length is undefined

    def __init__(
        self,
        nodes: ArrayLike,
        *,
        sections: Sequence[Superelement],
        section_of: ArrayLike,
        regularisation: float = REGULARISATION,
        first_order: bool = False,
    ) -> None:
        self.nodes: Indices = np.asarray(nodes, dtype=np.int64).reshape(-1, 2)
        self.section_of: Indices = np.asarray(section_of, dtype=np.int64)
        self.sections = tuple(sections)
        self.regularisation = regularisation
        self.first_order = first_order
        self._own = [self.sections[i] for i in self.section_of]  # of each element
        self._bounds = np.stack([section.bounds() for section in self._own])
        self._exponents = np.stack([section.exponents() for section in self._own])
        self._pinned = np.array([[s.start.pinned, s.end.pinned] for s in self._own])
        count = len(self.nodes)
        self._old, self._new = (
            SuperelementState(
                np.zeros((count, 4)),
                np.zeros((count, 3)),
                np.zeros((count, 3)),
                np.zeros((count, 3)),
                np.zeros(count),
            )
            for _ in range(2)
        )
        self._duration = np.inf

    def place(self, dofs: Indices, chords: Array) -> None:
        """Take from the assembly the dofs (elements, 6) and initial chords (elements, 2) in m."""
        self.dofs: Indices = np.ascontiguousarray(dofs)
        self.chords: Array = np.ascontiguousarray(chords)
        self.lengths: Array = np.hypot(chords[:, 0], chords[:, 1])
        self._flexibility = np.stack(
            [s.flexibility(length) for s, length in zip(self._own, self.lengths, strict=True)]
        )
        self._stiffness = _inverse(self._flexibility, self._pinned)
        self._rotary = self._rotary_inertias("nonlinear")

    def _rotary_inertias(self, kind: str) -> Array:
        """Inertia of the turning chord (elements,) in kg m2 where it is of a kind, else zero."""
        inertia = [s.rotary_inertia if s.rotation_inertia == kind else 0.0 for s in self._own]
        return np.array(inertia) * self.lengths

    def begin_step(self, duration: float) -> None:
        """Take the duration of the step to come, in s, for the rotary inertia."""
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
        time step, None for equilibrium at the end. The forces of a time step include those of the
        nonlinear rotary inertia.
        """
        _kernels.assemble(
            force,
            band,
            start,
            end,
            1.0 if weight is None else weight,
            weight is not None,
            self._duration,
            self.regularisation,
            self.first_order,
            self.dofs,
            positions,
            self.chords,
            self.lengths,
            self._flexibility,
            self._stiffness,
            self._bounds,
            self._exponents,
            self._pinned,
            self._rotary,
            self._old.plastic,
            self._old.local,
            self._old.rate,
            *self._new,
        )

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        return StepEnergies(
            *_kernels.account(
                weight,
                self.regularisation,
                self._flexibility,
                self._stiffness,
                self._old.plastic,
                self._old.carried,
                self._old.deformation,
                self._new.plastic,
                self._new.carried,
                self._new.deformation,
            )
        )

    def commit(self) -> None:
        """Make the state assembled last the committed one."""
        self._old, self._new = self._new, self._old

    def masses(self) -> tuple[Array, Array]:
        """Mass (kg) of every element (elements,); their nodes' rotations have no inertia."""
        mass = np.array([section.mass_per_length for section in self._own]) * self.lengths
        return mass, np.zeros_like(mass)

    def mass_matrices(self) -> Array:
        """Constant rotary inertia (elements, 6, 6) of the initial chords, where it is linear."""
        along = self.chords / self.lengths[:, None]
        normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / self.lengths[:, None]
        gradient = np.zeros((len(self.nodes), 6))
        gradient[:, 0:2], gradient[:, 3:5] = -normal, normal
        inertia = self._rotary_inertias("linear")
        return np.asarray(inertia[:, None, None] * gradient[:, :, None] * gradient[:, None, :])

    def kinetic_energy(self) -> float:
        """Committed kinetic energy of the nonlinear rotary inertia, in J."""
        return 0.5 * float(self._rotary @ self._old.rate**2)

    def turn_with(self, displacement: Array, velocity: Array) -> None:
        """Give the chords the angular velocities that the nodes have (dofs,), in m and m/s."""
        d = self.chords + displacement[self.dofs[:, 3:5]] - displacement[self.dofs[:, 0:2]]
        v = velocity[self.dofs[:, 3:5]] - velocity[self.dofs[:, 0:2]]
        self._old.rate[:] = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / np.sum(d**2, axis=1)

    @property
    def local_forces(self) -> Array:
        """Committed N, M1, M4 of the elements (elements, 3); internal moments are -M1 and M4."""
        return self._old.local

    @property
    def plastic(self) -> Array:
        """Committed plastic deformations (elements, 4): u, theta of hinge 1, then of hinge 4.

        In m and rad, conjugate to N, M1 and M4; a pin's rotation is all of it.
        """
        return self._old.plastic

    @plastic.setter
    def plastic(self, values: ArrayLike) -> None:
        self._old.plastic[:] = values

    @property
    def elongations(self) -> Array:
        """Committed change of chord length of the elements (elements,), in m."""
        return self._old.deformation[:, 0]

    @property
    def shear_forces(self) -> Array:
        """Committed shear force (M1 + M4) / l of the elements (elements,), in N."""
        local = self._old.local
        chord = self.lengths + (0.0 if self.first_order else self.elongations)
        return np.asarray((local[:, 1] + local[:, 2]) / chord)

    def utilisation(self) -> Array:
        """Left side of the yield condition at both hinges (elements, 2): 1 on the surface."""
        carried = self._old.carried
        side = np.where(carried[:, :1] >= 0.0, self._bounds[:, :, 0], self._bounds[:, :, 1])
        n = np.abs(carried[:, :1]) / side
        moment = carried[:, 1:]
        m = np.abs(moment) / np.where(moment >= 0.0, self._bounds[:, :, 2], self._bounds[:, :, 3])
        return np.asarray(m ** self._exponents[:, :, 0] + n ** self._exponents[:, :, 1])

    def shapes(self, displacement: Array, points: ArrayLike) -> Array:
        """Displaced axis (elements, points, 2) less the initial position of the first node, in m.

        Arguments: displacements (dofs,); `points` (points,) in 0..1 along each element. A flexible
        bar is bent by its committed moments, a rigid one is straight.
        """
        x = np.asarray(points, dtype=float)
        first = displacement[self.dofs[:, 0:2]]
        d = self.chords + displacement[self.dofs[:, 3:5]] - first
        bends = np.array([1.0 / s.bending_stiffness if s.flexible else 0.0 for s in self._own])
        m1, m4 = self._old.carried[:, 1], self._old.carried[:, 2]
        turn1 = self.lengths / 6.0 * bends * (2.0 * m1 - m4)
        turn4 = self.lengths / 6.0 * bends * (2.0 * m4 - m1)
        across = turn1[:, None] * x * (1.0 - x) ** 2 - turn4[:, None] * x**2 * (1.0 - x)
        normal = np.stack([-d[:, 1], d[:, 0]], axis=1)
        return np.asarray(
            first[:, None] + x[:, None] * d[:, None] + across[:, :, None] * normal[:, None]
        )


def _inverse(flexibility: Array, pinned: NDArray[np.bool_]) -> Array:
    """Elastic stiffness k_N, k_11, k_14, k_44 (elements, 4), zero where an end is pinned."""
    f_n, f11, f14, f44 = flexibility.T
    coupled = np.where(np.any(pinned, axis=1), 0.0, f14)
    f11 = np.where(pinned[:, 0], np.inf, f11)
    f44 = np.where(pinned[:, 1], np.inf, f44)
    # divided through by f_11 f_44, which may be infinite
    share = 1.0 / (1.0 - coupled**2 / (f11 * f44))
    return np.stack([1.0 / f_n, share / f11, -share * coupled / (f11 * f44), share / f44], axis=1)
