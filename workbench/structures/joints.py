"""Rotational springs between tied nodes: pins, semi-rigid and partial-strength joints."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.structures.elements import Bars, ElementGroup, Step, StepEnergies


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


class JointState(NamedTuple):
    """Rotations and their plastic parts in rad, moments in N m, (springs,) each."""

    rotation: Array
    plastic: Array
    moment: Array


class JointSprings(ElementGroup):
    """An element group of rotational springs.

    Arguments: `nodes` (springs, 2), pairs of tied nodes, in the order in which they come along
    the member; `springs`, one for each pair. The rotation of a spring is that of its second node
    less that of its first one, so that its moment is the internal moment of the member there:
    positive where it stretches the fibers on the right of somebody who looks along the member.
    """

    _old: JointState
    _new: JointState

    def __init__(self, nodes: ArrayLike, springs: Sequence[JointSpring]) -> None:
        super().__init__(nodes, JointState(*np.zeros((3, len(springs)))))
        if len(springs) != len(self.nodes):
            raise ValueError("one spring for each pair of nodes")
        self.springs = tuple(springs)
        self._stiffness: Array = np.array([spring.stiffness for spring in springs])
        self._most: Array = np.array([spring.strength for spring in springs])
        self._least: Array = -np.array([spring.strength_negative for spring in springs])

    def place(self, bars: Bars) -> None:
        """Take its place in a structure; the chords must have no length."""
        if np.any(bars.chords != 0.0):
            raise ValueError("joint springs connect nodes at one place")
        super().place(bars)

    def assemble(self, step: Step) -> None:
        """Add moments and tangent of a step from the committed state; keep the trial state."""
        first, second = self.bars.dofs[:, 2], self.bars.dofs[:, 5]
        old, new, k = self._old, self._new, self._stiffness
        new.rotation[:] = step.end[second] - step.end[first]
        within = old.rotation + step.weight * (new.rotation - old.rotation)
        trial = k * (within - old.plastic)
        new.moment[:] = np.clip(trial, self._least, self._most)
        yields = new.moment != trial
        new.plastic[:] = old.plastic
        new.plastic[yields] += (trial[yields] - new.moment[yields]) / (step.weight * k[yields])
        pinned = k == 0.0
        new.plastic[pinned] = new.rotation[pinned]
        np.add.at(step.force, first, -new.moment)
        np.add.at(step.force, second, new.moment)
        tangent = np.where(yields, 0.0, step.weight * k)
        for row, column, sign in ((2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)):
            np.add.at(step.band, self.bars.positions[:, 6 * row + column], sign * tangent)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step from the committed state to the one assembled last."""
        old, new, k = self._old, self._new, self._stiffness
        start, elastic = old.rotation - old.plastic, new.rotation - new.plastic
        change = elastic - start
        moment = k * ((1.0 - weight) * start + weight * elastic)
        plastic = float(moment @ (new.plastic - old.plastic))
        return StepEnergies(
            0.5 * float(k @ elastic**2), plastic, (weight - 0.5) * float(k @ change**2), plastic
        )

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
