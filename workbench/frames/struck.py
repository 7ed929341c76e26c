"""The record of an impact on superelements: many states at a time, read in compiled code."""

from operator import attrgetter
from typing import Any, ClassVar, cast

import numpy as np

from workbench.arrays import Array
from workbench.frames import collapse_watch as watch
from workbench.frames.record import Record
from workbench.frames.snapshots import Snapshots
from workbench.frames.struck_kernels import TABLES, Lost, choose, read
from workbench.frames.superelements import SuperelementMembers
from workbench.structures.paths import PathStep
from workbench.structures.time_steps import TimeStep

_TOLD = {  # of steps
    name: attrgetter(name)
    for name in (
        *("length", "percussion", "contact_loss", "external_work", "kinetic", "evaluations"),
        *("cuts", "striker.velocity", "striker.kinetic_energy"),
        *("energies.plastic", "energies.algorithmic", "energies.ideal"),
    )
}
LOST = Lost(watch.COLLAPSE_SIDEWAYS, watch.COLLAPSE_CONTRACTION, watch.LEAST_LENGTH)


class StruckSnapshots(Snapshots):
    """The same of many records at a time, drawn at the end: nothing but what is shown."""

    def __init__(self, structure: Any, end: float | None) -> None:
        super().__init__(structure, end)
        self._passed: Array = np.zeros(3)
        self._kept: list[tuple[Array, Array, Array]] = []  # times, displacements, forces carried

    def keep(self, times: Array, displacement: Array, moved: Array, carried: Array) -> None:
        """Look at records at `times` (s) with a `displacement` (m), and keep what may be drawn.

        That is what their dofs have `moved` (records, dofs), and forces `carried` by elements.
        """
        even, kept = np.empty((2, len(times)), dtype=bool)
        peak = choose(times, displacement, self._turns, self._passed, even, kept)
        if peak >= 0:
            self._peak = float(times[peak])
        self._even += times[even].tolist()
        self._last = float(times[-1])
        self._kept.append((times[kept], moved[kept], carried[kept]))

    def _drawn(self, shown: list[float]) -> tuple[Array, Array]:
        times, moved, carried = self._kept[0]
        if len(self._kept) > 1:
            times, moved, carried = map(np.concatenate, zip(*self._kept, strict=True))
        rows = np.searchsorted(times, shown)
        return cast(SuperelementMembers, self._structure.members).pictures(
            moved[rows], carried[rows]
        )


class StruckRecord(Record):
    """Histories of an impact as `follow_impact` tells of it: many records at a time."""

    pictures: ClassVar[type[Snapshots]] = StruckSnapshots
    _snapshots: StruckSnapshots

    def _begin(self) -> None:
        """The first records tell of the start as well."""

    def take(self, step: TimeStep | PathStep, at: Any, *, turns: bool = False) -> None:
        """Append several steps, the states that they lead to, and those of the start.

        Raises `CollapseError` when the frame has collapsed, `OutOfDomainError` when an element
        crumples.
        """
        structure, assembly = self.structure, self.structure.assembly
        members = cast(SuperelementMembers, structure.members)
        if "places" not in structure.found:
            structure.found["places"] = members.places(structure, self.watch.lines)
        places, moved, states = structure.found["places"], assembly.displacement, members.states
        tables = np.empty((len(TABLES), len(places.hinge), len(moved)))
        slid = np.empty((len(places.chain) if places.slide.any() else 0, len(moved)))
        lost = read(places, LOST, moved, states, tables, slid, self._most, self.drift)
        seen = {
            "at": at,
            **self._committed(),
            **{name: get(step) for name, get in _TOLD.items()},
            **dict(zip(TABLES, tables, strict=True)),
            "sliding": slid if len(slid) else None,
        }
        for name, values in seen.items():
            self._rows.setdefault(name, []).append(values)
        self._totals.clear()
        displacement = seen["displacement"]
        self._snapshots.keep(at, displacement, moved, states.carried)
        if lost >= 0:
            members.show(lost)
            assembly.show(moved[lost], assembly.velocity[lost], seen["elastic"][lost])
            self.watch.check(float(displacement[lost]), float(at[lost]))

    def column(self, name: str) -> Array:
        """As of other records."""
        rows = self._rows[name]
        return rows[0] if len(rows) == 1 else np.concatenate(rows, axis=-1)

    def told(self, start: float, name: str) -> Array:
        """As of other records."""
        told = self.column(name)
        told[0] = start
        return told
