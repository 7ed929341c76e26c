"""Rotational springs between tied nodes: pins, semi-rigid and partial-strength joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.errors import InputError
from workbench.structures.ledger import StepEnergies

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class JointSpring:
    """Elastic, perfectly plastic rotational spring.

    Arguments: `stiffness` in N m/rad (0: a pin); `strength` for positive and
    `strength_negative` for negative moments, in N m (inf: elastic). Raises `InputError`.
    """

    stiffness: float
    strength: float = inf
    strength_negative: float = inf

    def __post_init__(self) -> None:
        if not 0.0 <= self.stiffness < inf:
            raise InputError(
                "joint.stiffness",
                self.stiffness,
                "must be finite and not negative",
                "a rigid joint needs no spring",
            )
        for name in ("strength", "strength_negative"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"joint.{name}", getattr(self, name), "must be positive")


class _State:
    def __init__(self, count: int) -> None:
        self.rotation: Array = np.zeros(count)
        self.plastic: Array = np.zeros(count)
        self.moment: Array = np.zeros(count)


class JointSprings:
    """An element group of rotational springs; states are committed by swapping two buffers.

    Arguments: `nodes` (springs, 2), pairs of tied nodes, in the order in which they come along
    the member; `springs`, one for each pair. The rotation of a spring is that of its second node
    less that of its first one, so that its moment is the internal moment of the member there:
    positive where it stretches the fibers on the right of somebody who looks along the member.
    """

    def __init__(self, nodes: ArrayLike, springs: Sequence[JointSpring]) -> None:
        self.nodes: Indices = np.asarray(nodes, dtype=np.int64).reshape(-1, 2)
        if len(springs) != len(self.nodes):
            raise ValueError("one spring for each pair of nodes")
        self.springs = tuple(springs)
        self._stiffness: Array = np.array([spring.stiffness for spring in springs])
        self._most: Array = np.array([spring.strength for spring in springs])
        self._least: Array = -np.array([spring.strength_negative for spring in springs])
        self._old, self._new = _State(len(springs)), _State(len(springs))

    def place(self, dofs: Indices, chords: Array) -> None:
        """Take from the assembly the dofs (springs, 6); the chords must have no length."""
        if np.any(chords != 0.0):
            raise ValueError("joint springs connect nodes at one place")
        self._first, self._second = dofs[:, 2].copy(), dofs[:, 5].copy()

    def assemble(
        self,
        force: Array,
        band: Array,
        positions: Indices,
        start: Array,
        end: Array,
        weight: float | None,
    ) -> None:
        """Add moments and tangent at the displacements `end`, from the committed state.

        Arguments as those of `FiberBeams.assemble`.
        """
        old, new, k = self._old, self._new, self._stiffness
        new.rotation[:] = end[self._second] - end[self._first]
        trial = k * (new.rotation - old.plastic)
        new.moment[:] = np.clip(trial, self._least, self._most)
        yields = new.moment != trial
        new.plastic[:] = old.plastic
        new.plastic[yields] += (trial[yields] - new.moment[yields]) / k[yields]
        pinned = k == 0.0
        new.plastic[pinned] = new.rotation[pinned]
        share = 1.0 if weight is None else weight
        moment = share * new.moment + (1.0 - share) * old.moment
        np.add.at(force, self._first, -moment)
        np.add.at(force, self._second, moment)
        tangent = np.where(yields, 0.0, share * k)
        for row, column, sign in ((2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)):
            np.add.at(band, positions[:, 6 * row + column], sign * tangent)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        old, new, k = self._old, self._new, self._stiffness
        softness = np.divide(1.0, k, out=np.zeros_like(k), where=k > 0.0)
        flow = new.plastic - old.plastic
        moment = weight * new.moment + (1.0 - weight) * old.moment
        return StepEnergies(
            0.5 * float(softness @ new.moment**2),
            float(moment @ flow),
            (weight - 0.5) * float(softness @ (new.moment - old.moment) ** 2),
            float(new.moment @ flow),
        )

    def commit(self) -> None:
        """Make the state assembled last the committed one."""
        self._old, self._new = self._new, self._old

    def masses(self) -> tuple[Array, Array]:
        """Mass and rotary inertia of the springs (springs,): none."""
        none = np.zeros(len(self.nodes))
        return none, none

    @property
    def moments(self) -> Array:
        """Committed moments (springs,), in N m."""
        return self._old.moment

    @property
    def rotations(self) -> Array:
        """Committed rotations (springs,), in rad."""
        return self._old.rotation

    @property
    def plastic(self) -> Array:
        """Committed plastic rotations (springs,) in rad; of a pin all of its rotation."""
        return self._old.plastic

    def utilisation(self) -> Array:
        """Committed moments over the strengths (springs,): 1 at yield, 0 at a pin."""
        moment = self._old.moment
        return np.asarray(np.maximum(moment / self._most, moment / self._least))
