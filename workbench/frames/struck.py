"""The record of an impact on superelements: many states at a time, read in compiled code."""

from operator import attrgetter
from typing import Any, ClassVar, cast

import numpy as np

from workbench.arrays import Array
from workbench.frames import collapse_watch as watch
from workbench.frames.record import Record
from workbench.frames.snapshots import Snapshots
from workbench.frames.superelements import SuperelementMembers
from workbench.structures.paths import PathStep
from workbench.structures.superelements.march import reading_of
from workbench.structures.superelements.reading_kernels import Lost, Pictures, Reading
from workbench.structures.time_steps import TimeStep

_TOLD = {  # of steps
    name: attrgetter(name)
    for name in (
        *("length", "impulse", "contact_loss", "external_work", "kinetic", "evaluations"),
        *("cuts", "striker.velocity", "striker.kinetic_energy"),
        *("energies.plastic", "energies.algorithmic", "energies.ideal"),
    )
}
LOST = Lost(watch.COLLAPSE_SIDEWAYS, watch.COLLAPSE_CONTRACTION, watch.LEAST_LENGTH)


class StruckSnapshots(Snapshots):
    """The same of states that were kept while the impact was followed, drawn at the end."""

    kept: Pictures

    def values(self) -> dict[str, Any]:
        """As of other records."""
        last, count = len(self.kept.turns), int(self.kept.seen[3])
        times = self.kept.time.tolist()
        self._even, self._last = times[:count], times[last + 1]
        self._peak = None if np.isnan(times[last]) else times[last]
        return super().values()

    def _drawn(self, shown: list[float]) -> tuple[Array, Array]:
        place = {time: row for row, time in enumerate(self.kept.time.tolist())}
        rows = [place[time] for time in shown]
        members = cast(SuperelementMembers, self._structure.members)
        return members.pictures(self.kept.moved[rows], self.kept.carried[rows])


class StruckRecord(Record):
    """Histories of an impact as `follow_impact` tells of it: many records at a time."""

    pictures: ClassVar[type[Snapshots]] = StruckSnapshots
    _snapshots: StruckSnapshots
    reading: Reading

    def _begin(self) -> None:
        """Nothing is seen yet: the first records tell of the start as well."""
        structure, members = self.structure, cast(SuperelementMembers, self.structure.members)
        key = f"places of {self._dof}"
        if key not in structure.found:
            structure.found[key] = members.places(structure, self.watch.lines, self._dof)
        turns = self._snapshots.turns
        self.reading = reading_of(structure.assembly, structure.found[key], LOST, turns)
        self._most, self.drift = self.reading.most, self.reading.drift
        self._snapshots.kept = self.reading.pictures

    def take(self, step: TimeStep | PathStep, at: Any, *, turns: bool = False) -> None:
        """Append several steps, the states that they lead to, and those of the start.

        Raises `CollapseError` when the frame has collapsed, `OutOfDomainError` when an element
        crumples.
        """
        told = cast(TimeStep, step)
        rows, lost = told.read
        moved, slid = rows.watched.T, rows.sliding.T
        displacement = self._sign * (moved[0] - self.structure.start[self._dof])
        watched = zip(self.structure.watched.items(), moved[1:], strict=True)
        seen = {
            "at": at,
            "displacement": displacement,
            "velocity": self._sign * rows.velocity,
            "elastic": told.energies.stored,
            **{name: sign * one for (name, (_, sign)), one in watched},
            **{name: get(step) for name, get in _TOLD.items()},
            "axial_force": rows.axial_force.T,
            "moment": rows.moment.T,
            "plastic_rotation": rows.plastic_rotation.T,
            "sliding": slid if len(slid) else None,
        }
        for name, values in seen.items():
            self._rows.setdefault(name, []).append(values)
        self._totals.clear()
        if lost:
            self.watch.check(float(displacement[-1]), float(at[-1]))

    def column(self, name: str) -> Array:
        """As of other records."""
        rows = self._rows[name]
        return rows[0] if len(rows) == 1 else np.concatenate(rows, axis=-1)

    def told(self, start: float, name: str) -> Array:
        """As of other records."""
        told = self.column(name)
        told[0] = start
        return told
