"""What an assembly knows of the elements of one kind: their bars, two states, and the step."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from copy import copy
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array, Flags, Indices


class Bars(NamedTuple):
    """Two-node elements in their structure.

    `dofs` (e, 6); `positions` (e, 36) of their tangents in the flat band; initial `chords` (e, 2)
    and `lengths` (e,) in m; `first_order`, geometry and equilibrium of the undeformed structure;
    `relative`, chords from relative displacements, not from places (the same but for rounding).
    """

    dofs: Indices
    positions: Indices
    chords: Array
    lengths: Array
    first_order: bool = False
    relative: bool = False


class Step(NamedTuple):
    """What an assembly asks of its groups: forces and tangent at the displacements `end`.

    `force` (dofs,) and flat `band` to add to; committed displacements `start` (dofs,). If
    `dynamic`, forces are the energy-exact ones of a time step of `duration` (s), with `weight` of
    the end state; otherwise those of equilibrium at the end (weight 1). Without `tangent` the band
    is of no interest.
    """

    force: Array
    band: Array
    start: Array
    end: Array
    weight: float
    dynamic: bool
    duration: float
    tangent: bool


class StepEnergies(NamedTuple):
    """Energies of one step of a group or a whole structure, in J.

    `stored` at the end of the step; `plastic` and `algorithmic` dissipation of the step; `ideal`,
    the plastic work of stresses that stay at yield: `plastic / ideal` is the yield ratio, which
    falls below 1 where averaged stresses soften the material artificially.
    """

    stored: float
    plastic: float
    algorithmic: float
    ideal: float

    def __add__(self, other: object) -> StepEnergies:
        """Sum of two groups, entry by entry."""
        if not isinstance(other, StepEnergies):
            return NotImplemented
        return StepEnergies(*(a + b for a, b in zip(self, other, strict=True)))


class ElementGroup(ABC):
    """All elements of one kind; states are committed by swapping two buffers.

    Arguments: `nodes` (elements, 2), node numbers; an empty `state`, a NamedTuple of arrays.
    """

    def __init__(self, nodes: ArrayLike, state: Any) -> None:
        self.nodes: Indices = np.asarray(nodes, dtype=np.int64).reshape(-1, 2)
        self._old = state
        self._new = type(state)(*(values.copy() for values in state))

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        self.bars = bars

    def copy(self) -> Self:
        """The same elements in the same place, with states of their own."""
        other = copy(self)
        for name in ("_old", "_new"):
            state = getattr(self, name)
            setattr(other, name, type(state)(*(values.copy() for values in state)))
        return other

    @abstractmethod
    def assemble(self, step: Step) -> None:
        """Add forces and tangent of a step from the committed state; keep the trial state."""

    @abstractmethod
    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""

    def commit(self) -> None:
        """Make the state assembled last the committed one."""
        self._old, self._new = self._new, self._old

    def masses(self) -> tuple[Array, Array]:
        """Mass (kg) and rotary inertia (kg m2) of every element, (elements,) each: none."""
        none = np.zeros(len(self.nodes))
        return none, none

    def mass_matrices(self) -> Array | None:
        """Constant mass matrices (elements, 6, 6) in addition to `masses`, if there are any."""
        return None

    def kinetic_energy(self) -> float:
        """Committed kinetic energy that is not in the mass matrix, in J."""
        return 0.0

    @property
    def turning_inertia(self) -> bool:
        """Whether there is rotary inertia that turns with the elements."""
        return False

    def turn_with(self, displacement: Array, velocity: Array) -> None:  # noqa: B027
        """Give velocities that a group keeps of its own the values of the nodes (dofs,), SI."""

    @property
    def lengths(self) -> Array:
        """Initial lengths (elements,), in m."""
        return self.bars.lengths


class MemberElements(ElementGroup):
    """Elements of members with compiled kernels; what is read off them is committed, in SI units.

    `kernels`, their module with `assemble` and `account`; `crumples`, whether an element means
    nothing once a plastic hinge has shortened it to nothing, as the direction of a chord without
    length is undefined. Forces are those of a co-rotational element unless a kind has its own.
    """

    kernels: ClassVar[Any]
    crumples: ClassVar[bool] = True

    @property
    @abstractmethod
    def tables(self) -> tuple[Any, ...]:
        """What the kernels take besides bars and states."""

    def assemble(self, step: Step) -> None:
        """Add forces and tangent of a step from the committed state; keep the trial state."""
        self.kernels.assemble(step, self.bars, *self.tables, self._old, self._new)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        energies = self.kernels.account(weight, self.bars, *self.tables, self._old, self._new)
        return StepEnergies(*energies)

    @property
    def local_forces(self) -> Array:
        """N and end moments M1, M2 (elements, 3); internal moments are -M1 and M2."""
        return np.asarray(self._old.local)

    @property
    @abstractmethod
    def elongations(self) -> Array:
        """Changes of length along the axis or chord (elements,), in m."""

    @property
    def shear_forces(self) -> Array:
        """Shear force (M1 + M2) / l of the elements (elements,), in N."""
        chord = self.lengths + (0.0 if self.bars.first_order else self.elongations)
        return np.asarray((self._old.local[..., 1] + self._old.local[..., 2]) / chord)

    @property
    def slide(self) -> Flags:
        """Whether webs yield in shear (elements,)."""
        return np.zeros(len(self.lengths), dtype=bool)

    def bent(
        self, displacement: Array, elements: Indices, points: Array, bends: Array, moments: Array
    ) -> Array:
        """Displaced axis (points, 2) less the initial position of the first node, in m.

        Arguments: displacements (dofs,); `elements` (points,), and the `points` along them in
        0..1; flexibility 1 / EI (elements,) of the bars, 0 of straight ones; end `moments`
        (elements, 2).
        """
        x, dofs, bars = points, self.bars.dofs[elements], self.bars
        first = displacement[..., dofs[..., 0:2]]
        d = bars.chords[elements] + displacement[..., dofs[..., 3:5]] - first
        place = first + x[..., None] * d
        if np.any(bends):
            m1, m4 = moments[..., elements, 0], moments[..., elements, 1]
            soft = (bars.lengths / 6.0 * bends)[elements] * x * (1.0 - x)
            across = soft * ((1.0 - x) * (2.0 * m1 - m4) - x * (2.0 * m4 - m1))
            place[..., 0] -= across * d[..., 1]
            place[..., 1] += across * d[..., 0]
        return np.asarray(place)


class HingedElements(MemberElements):
    """Elements whose plasticity is told of as that of two hinges, at their ends.

    Arguments: `nodes` (elements, 2), node numbers; the `bars` (elements,), each with its
    `mass_per_length`; an empty `state`; `first_order`, equilibrium of the undeformed structure.
    A kind makes the `_tables` of its kernels as it takes its place.
    """

    _old: Any
    _tables: Any

    def __init__(
        self, nodes: ArrayLike, bars: Sequence[Any], state: Any, first_order: bool
    ) -> None:
        super().__init__(nodes, state)
        self._own, self.first_order = list(bars), first_order

    def place(self, bars: Bars) -> None:
        """Take its place in a structure from the assembly."""
        super().place(bars._replace(first_order=self.first_order, relative=True))

    @property
    def tables(self) -> tuple[Any, ...]:
        """What the kernels take besides bars and states."""
        return (self._tables,)

    def masses(self) -> tuple[Array, Array]:
        """Mass (kg) of every element (elements,); their nodes' rotations have no inertia."""
        mass = np.array([bar.mass_per_length for bar in self._own]) * self.lengths
        return mass, np.zeros_like(mass)

    @property
    @abstractmethod
    def plastic(self) -> Array:
        """Committed plastic deformations (elements, 4): u, theta of hinge 1, then of hinge 4.

        In m and rad, conjugate to N, M1 and M4; a pin's rotation is all of it.
        """

    @abstractmethod
    def utilisation(self) -> Array:
        """Left side of the yield condition at both hinges (elements, 2): 1 on the surface."""

    @abstractmethod
    def shapes(self, displacement: Array, elements: Indices, points: Array) -> Array:
        """Displaced axis (points, 2), see `bent`."""
