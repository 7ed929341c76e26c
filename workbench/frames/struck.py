"""The record of an impact on superelements, whose states come many at a time."""

from operator import attrgetter
from typing import Any, ClassVar, cast

import numpy as np

from workbench.arrays import Array
from workbench.frames import collapse_watch as watch
from workbench.frames.record import Record
from workbench.frames.snapshots import Snapshots
from workbench.frames.structure import FrameStructure
from workbench.structures.paths import PathStep
from workbench.structures.superelements import Superelements, SuperelementState
from workbench.structures.superelements.march import Read
from workbench.structures.superelements.march_kernels import CollapseLimits
from workbench.structures.time_steps import TimeStep


def show(structure: FrameStructure, step: TimeStep, records: Any) -> None:
    """Make a structure show the states of these `records` of a step, for its readers."""
    states = cast(Read, step.read).states
    (group,) = structure.assembly.groups
    cast(Superelements, group).show(SuperelementState(*(each[records] for each in states.elements)))
    stored = np.asarray(step.energies.stored)[records]
    structure.assembly.show(states.x[records], states.v[records], stored)


class StruckSnapshots(Snapshots):
    """Snapshots of many states at a time, `step`."""

    step: TimeStep

    def see(self, at: Any, displacement: Any, *, turns: bool = False) -> None:
        """Look at the states at several times (s), with their displacements (m)."""
        size, turns_at = np.abs(displacement), cast(Array, self.turns)
        highest = np.maximum.accumulate(np.append(self._largest, size))
        rising = np.append(self._rising, size >= highest[:-1])
        after_peak = np.flatnonzero(rising[:-1] & ~rising[1:])[-1:]
        passed = np.append(self._next, np.searchsorted(turns_at, at, side="right"))
        even = np.flatnonzero(passed[1:] > passed[:-1])
        self._largest, self._rising, self._next = float(highest[-1]), rising[-1], passed[-1]
        self._even += at[even].tolist()
        self._last = float(at[-1])
        for peak in at[after_peak].tolist():
            self._peak = peak
        rows = np.unique(np.concatenate([even, after_peak, [len(at) - 1]]))
        show(self._structure, self.step, rows)
        members = self._structure.members
        pictures = members.shapes(self._structure.assembly), members.utilisation()
        self._pictures += zip(at[rows].tolist(), *pictures, strict=True)


class StruckRecord(Record):
    """Histories of an impact as `follow_impact` tells of it: many records at a time."""

    pictures: ClassVar[type[Snapshots]] = StruckSnapshots
    _snapshots: StruckSnapshots

    def _begin(self) -> None:
        """Nothing is seen yet: the first records tell of the start as well."""

    @property
    def limits(self) -> CollapseLimits:
        """Beyond what the frame has collapsed, for compiled steps."""
        structure, lines = self.structure, self.watch.lines
        if "limits" not in structure.found:
            frame, dof = structure.frame, structure.assembly.dof
            number = {node.name: i for i, node in enumerate(frame.nodes)}
            ends = [(number[member.start], number[member.end]) for member in frame.members]
            corners = np.array([[dof(n, c) for n in pair for c in "uv"] for pair in ends])
            rows = np.arange(len(ends))[:, None]
            structure.found["limits"] = CollapseLimits(
                watch.COLLAPSE_SIDEWAYS,
                watch.COLLAPSE_CONTRACTION,
                watch.LEAST_LENGTH,
                structure.members.first,
                corners,
                lines.across[rows, corners[:, 2:]],
                lines.along[rows, corners[:, 2:]],
                lines.chained.argmax(axis=0),
                lines.chained.max(axis=0),
            )
        return cast(CollapseLimits, structure.found["limits"])

    def take(self, step: TimeStep | PathStep, at: Any, *, turns: bool = False) -> None:
        """Append several steps, the states that they lead to, and those of the start.

        Raises `CollapseError` when the frame has collapsed, `OutOfDomainError` when an element
        crumples.
        """
        steps = self._snapshots.step = cast(TimeStep, step)
        self._steps.append(steps)
        self._totals.clear()
        show(self.structure, steps, slice(None))
        self._see(at, turns)
        if cast(Read, steps.read).collapsed:
            show(self.structure, steps, -1)
            self.watch.check(self.displacement, float(at[-1]))

    def column(self, name: str) -> Array:
        """As of other records."""
        return np.ascontiguousarray(np.concatenate(self._rows[name]).T)

    def told(self, start: float, name: str) -> Array:
        """As of other records."""
        values = np.concatenate([*map(attrgetter(name), self._steps)])
        values[0] = start
        return values
