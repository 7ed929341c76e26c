"""Impacts in compiled steps: records that read many states at a time, and what follows them.

Steps are long once the structure has swung back; an impact whose peak comes later is followed anew,
with small steps as far as that.
"""

from collections.abc import Callable, Iterator
from typing import Any, ClassVar, TypeVar, cast

import numpy as np

from workbench.base.arrays import Array
from workbench.mechanics.frames import collapse
from workbench.mechanics.frames.runs import Record, Snapshots
from workbench.mechanics.frames.structure import FrameStructure
from workbench.mechanics.impact.pace import NEARLY, Pace, late_peak
from workbench.mechanics.structures.impact import PointMass, TimeStep
from workbench.mechanics.structures.march import (
    CollapseLimits,
    Records,
    follow_impact,
)
from workbench.mechanics.structures.paths import PathStep
from workbench.responses.kernels import side_of
from workbench.scenarios import FrameImpact

Answer = TypeVar("Answer")

PAST = 1.05  # times as long as it took to a late peak, steps are small
_COLUMNS = {"impulse": "percussion", "striker.velocity": "striker_velocity"}


def show(structure: FrameStructure, records: Records, rows: Any) -> None:
    """Make a structure show the states of these `rows` of the records, for its readers."""
    (group,), states = structure.assembly.groups, records.states
    group.show(type(states)(*(each[rows] for each in states)))
    structure.assembly.show(records.x[rows], records.v[rows], records.table["stored"][rows])


class StruckSnapshots(Snapshots):
    """Snapshots of many states at a time, those of `records`."""

    records: Records

    def see(self, at: Any, displacement: Any, *, turns: bool = False) -> None:
        """Look at the states at several times (s), with their displacements (m)."""
        turned = self._follow(cast(Array, self.turns), at, np.abs(displacement))
        rows = np.union1d(turned, [len(at) - 1])
        self._last = float(at[-1])
        show(self._structure, self.records, rows)
        members = self._structure.members
        pictures = members.shapes(self._structure.assembly), members.utilisation()
        self._pictures += zip(at[rows].tolist(), *pictures, strict=True)


class StruckRecord(Record):
    """Histories of an impact by `follow_impact`, many records at a time."""

    pictures: ClassVar[type[Snapshots]] = StruckSnapshots
    _snapshots: StruckSnapshots

    def _begin(self) -> None:
        """The first records hold the initial state."""

    @property
    def limits(self) -> CollapseLimits:
        """Limits of collapse, for compiled steps."""
        drift = self.watch.drift
        return CollapseLimits(
            collapse.TURNED_OVER,
            collapse.COLLAPSE_CONTRACTION,
            collapse.LEAST_LENGTH,
            self.structure.members.first,
            drift.corners,
            drift.transverse,
            drift.axial,
            drift.chain_average.argmax(axis=0),
            drift.chain_average.max(axis=0),
        )

    def take(self, step: TimeStep | PathStep | Records, at: Any, *, turns: bool = False) -> None:
        """Append several records, the states that they lead to, and those of the start.

        Raises `CollapseError` when the frame has collapsed, `OutOfDomainError` when an element
        crumples.
        """
        records = self._snapshots.records = cast(Records, step)
        self._steps.append(records)
        show(self.structure, records, slice(None))
        self.watch.follow(self.displacement, at)
        self._see(at, turns)
        if records.collapsed:
            show(self.structure, records, -1)
            self.watch.check(self.displacement, float(at[-1]))

    def column(self, name: str) -> Array:
        """History of a scalar (steps,), or of one of each hinge (hinges, steps)."""
        return np.ascontiguousarray(np.concatenate(self._rows[name]).T)

    def history(self, start: float, name: str) -> Array:
        """History as in `Record`; the kinetic energy is that of structure and striker."""
        if name == "length":
            return np.diff(self.column("at"), prepend=0.0)
        values = np.concatenate(
            [records.table[_COLUMNS.get(name, name)] for records in self._steps]
        )
        values[0] = start
        return values

    def moving(self, start: float) -> Array:
        """History (steps,) of the kinetic energy of structure and striker (J), from `start`."""
        return self.history(start, "kinetic")

    def total(self, name: str) -> Array:
        """History (steps,) of the sum as in `Record`; of evaluations and cuts the last value."""
        if name in ("evaluations", "cuts"):
            return np.array([getattr(self._steps[-1], name)])
        column = name.removeprefix("energies.")
        return np.concatenate([records.table[column] for records in self._steps])


class StruckNumbers(StruckRecord):
    """Record of an impact for its scalars alone: neither pictures nor moments nor shear."""

    def _see(self, at: Any, turns: bool) -> None:
        self._read(at)


def strike(
    scenario: FrameImpact,
    structure: FrameStructure,
    pace: Pace,
    kind: type[StruckRecord],
    answer: Callable[[FrameImpact, StruckRecord, Iterator[Records], float | None], Answer],
    largest_error: float | None,
    timed: Callable[[Iterator[Records]], Iterator[Records]],
) -> Answer:
    """The answer to an impact; anew where the peak came in long steps, with small ones that far.

    Arguments: the `structure`, which stays as it is; the `kind` of its record; the `answer`, which
    takes the steps, as `runs.run_impact` does; `largest_error` for that; a clock has the steps
    `timed`. Raises as the answer does.
    """
    striker = scenario.striker
    dof, sign = structure.dof(striker.node, striker.direction)
    mass, vibration_start, before = PointMass.of(scenario), 0.0, 0.0
    while True:
        view = structure.seen()
        record = kind(view, striker.node, striker.direction, scenario.duration)
        steps = follow_impact(
            view.assembly,
            dof,
            mass,
            pace,
            record.limits,
            sign=sign,
            vibration_start=vibration_start,
        )
        answered = answer(scenario, record, timed(steps), largest_error)
        time, moved, speed = map(record.column, ("at", "displacement", "velocity"))
        side, push = side_of(time, moved), record.history(0.0, "impulse")
        late = late_peak(pace, vibration_start, time, side * moved, side * speed, push)
        highest = float(np.abs(moved).max())
        gone = highest < NEARLY * before  # what small steps looked for: it may come yet later
        if vibration_start >= pace.duration or not (late or gone):
            return answered
        vibration_start, before = pace.duration if vibration_start else PAST * late, highest
