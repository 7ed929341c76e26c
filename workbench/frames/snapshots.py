"""Pictures of a frame over its record: deformed shapes and utilisation of the hinges."""

from typing import Any

import numpy as np

from workbench.arrays import Array, Indices
from workbench.frames.structure import FrameStructure

Picture = tuple[Array, Array]  # shapes and utilisation
FARTHER = 1.0 + 1e-9  # cycles of equal size: the first one counts
EVENLY = 60  # snapshots over the record; one more at the peak


class Snapshots:
    """Collects at most `EVENLY` + 1 snapshots while a run passes by.

    Arguments: the `structure`, whose committed state is read; `end` of the record, which starts
    at zero (time in s; None: unknown, snapshots are then even in the number of steps). Evenly
    spaced ones are those of the first step at or after their turn. The one of the peak follows the
    largest displacement by one step in time, and is the state where a path turns back in statics.
    """

    def __init__(self, structure: FrameStructure, end: float | None) -> None:
        self._structure = structure
        self._turns = None if end is None else np.linspace(0.0, end, EVENLY) * (1.0 - 1e-9)
        self._even: list[float] = []
        self._peak: float | None = None
        self._pictures: dict[float, Picture] = {}
        self._seen, self._stride, self._next = 0, 1, 0
        self._last: float | None = None
        self._largest = 0.0
        self._rising = False

    def see(self, at: Any, displacement: Any, *, turns: bool = False) -> None:
        """Look at the committed state at a time (s) or step, with its displacement (m).

        Or at several of them. `turns`, whether a static path ends or turns back here.
        """
        times, size = np.atleast_1d(at), np.abs(np.atleast_1d(displacement))
        if self._turns is None:
            self._count(float(at), float(size[0]), turns)
        else:
            self._follow(times, size, np.searchsorted(self._turns, times, side="right"))
        self._last = float(times[-1])
        kept = {*self._even, self._peak}
        if len(times) > 1:  # which may be all there are
            kept.add(self._last)
        rows = {when: row for row, when in enumerate(times.tolist()) if when in kept}
        if rows.keys() - self._pictures.keys():
            self._draw(rows)
            self._pictures = {when: p for when, p in self._pictures.items() if when in kept}

    def _count(self, at: float, size: float, turns: bool) -> None:
        """Look at a load step with a displacement of that size."""
        if turns and size > self._largest * FARTHER:
            self._largest, self._peak = size, at
        if len(self._even) == 2 * EVENLY:
            self._even = self._even[::2]
            self._stride *= 2
        if self._seen % self._stride == 0:
            self._even.append(at)
        self._seen += 1

    def _follow(self, times: Array, size: Array, turns: Indices) -> None:
        """Look at times (s) with displacements of that size (m), each after so many `turns`."""
        largest = np.maximum.accumulate(np.append(self._largest, size))
        rising = np.append(self._rising, size >= largest[:-1])
        tops = np.flatnonzero(rising[:-1] & ~rising[1:])
        if tops.size:
            self._peak = float(times[tops[-1]])
        self._largest, self._rising = float(largest[-1]), bool(rising[-1])
        passed = np.append(self._next, turns)
        self._even += times[passed[1:] > passed[:-1]].tolist()
        self._next = int(passed[-1])

    def values(self) -> dict[str, Any]:
        """Variables of the response; the state seen last must still be the committed one."""
        even = self._even
        if self._last is not None and even[-1] != self._last:
            even = [*even, self._last]
            if self._last not in self._pictures:
                self._draw({self._last: -1})
        if len(even) > EVENLY:
            even = [even[i] for i in np.linspace(0, len(even) - 1, EVENLY).round().astype(int)]
        shown = sorted({*even, *(() if self._peak is None else (self._peak,))})
        shapes, used = zip(*(self._pictures[at] for at in shown), strict=True)
        stacked = np.stack(shapes, axis=-1)
        return {
            "snapshot_at": shown,
            "shape_x": stacked[:, :, 0],
            "shape_y": stacked[:, :, 1],
            "utilisation": np.stack(used, axis=-1),
        }

    def _draw(self, rows: dict[float, int]) -> None:
        """Draw the pictures of some of the records that are looked at, by their rows."""
        structure = self._structure
        drawn = structure.members.pictures(structure.assembly, list(rows.values()))
        self._pictures |= dict(zip(rows, zip(*drawn, strict=True), strict=True))
