"""The record of an impact on superelements, whose states come many at a time."""

from typing import Any, ClassVar, cast

import numpy as np

from workbench.arrays import Array
from workbench.frames import collapse_watch as watch
from workbench.frames.record import Record, Snapshots
from workbench.frames.structure import FrameStructure
from workbench.structures.paths import PathStep
from workbench.structures.superelements import Superelements, SuperelementState
from workbench.structures.superelements.march import CollapseLimits, Records
from workbench.structures.time_steps import TimeStep

_COLUMNS = {"impulse": "percussion", "striker.velocity": "striker_velocity"}


def show(structure: FrameStructure, records: Records, rows: Any) -> None:
    """Make a structure show the states of these `rows` of the records, for its readers."""
    (group,) = structure.assembly.groups
    cast(Superelements, group).show(SuperelementState(*(each[rows] for each in records.states)))
    structure.assembly.show(records.x[rows], records.v[rows], records.table["stored"][rows])


class StruckSnapshots(Snapshots):
    """Snapshots of many states at a time, those of `records`."""

    records: Records

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
        show(self._structure, self.records, rows)
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
        lines = self.watch.lines
        return CollapseLimits(
            watch.COLLAPSE_SIDEWAYS,
            watch.COLLAPSE_CONTRACTION,
            watch.LEAST_LENGTH,
            self.structure.members.first,
            lines.corners,
            lines.across,
            lines.along,
            lines.chained.argmax(axis=0),
            lines.chained.max(axis=0),
        )

    def take(self, step: TimeStep | PathStep | Records, at: Any, *, turns: bool = False) -> None:
        """Append several records, the states that they lead to, and those of the start.

        Raises `CollapseError` when the frame has collapsed, `OutOfDomainError` when an element
        crumples.
        """
        records = self._snapshots.records = cast(Records, step)
        self._steps.append(records)
        show(self.structure, records, slice(None))
        self._see(at, turns)
        if records.collapsed:
            show(self.structure, records, -1)
            self.watch.check(self.displacement, float(at[-1]))

    def column(self, name: str) -> Array:
        """As of other records."""
        return np.ascontiguousarray(np.concatenate(self._rows[name]).T)

    def history(self, start: float, name: str) -> Array:
        """As of other records; the kinetic energy is that of structure and striker."""
        if name == "length":
            return np.diff(self.column("at"), prepend=0.0)
        values = np.concatenate(
            [records.table[_COLUMNS.get(name, name)] for records in self._steps]
        )
        values[0] = start
        return values

    def moving(self, start: float) -> Array:
        """As of other records."""
        return self.history(start, "kinetic")

    def total(self, name: str) -> Array:
        """As of other records."""
        if name in ("evaluations", "cuts"):
            return np.array([getattr(self._steps[-1], name)])
        column = name.removeprefix("energies.")
        return np.concatenate([records.table[column] for records in self._steps])
