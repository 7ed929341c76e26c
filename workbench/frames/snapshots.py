"""Pictures of a frame over its record: deformed shapes and utilisation of the hinges."""

from typing import Any

import numpy as np

from workbench.arrays import Array, Flags, Indices
from workbench.frames.structure import FrameStructure

FARTHER = 1.0 + 1e-9  # cycles of equal size: the first one counts
EVENLY = 60  # snapshots over the record; one more at the peak
_SHARES = np.linspace(0.0, 1.0 - 1e-9, EVENLY)


class Snapshots:
    """Collects at most `EVENLY` + 1 snapshots while a run passes by.

    Arguments: the `structure`, whose committed state is read; `end` of the record, which starts
    at zero (time in s; None: unknown, snapshots are then even in the number of steps). Evenly
    spaced ones are those of the first step at or after their turn. The one of the peak follows the
    largest displacement by one step in time, and is the state where a path turns back in statics.
    """

    def __init__(self, structure: FrameStructure, end: float | None) -> None:
        self._structure = structure
        self._turns = None if end is None else end * _SHARES
        self._even: list[float] = []
        self._peak: float | None = None
        self._pictures: list[tuple[Array, Array, Array]] = []  # times, shapes, utilisation
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
            kept = self._count(float(at), float(size[0]), turns)
        else:
            kept = self._follow(times, size, np.searchsorted(self._turns, times, side="right"))
        self._last = float(times[-1])
        if len(times) > 1:  # which may be all there are
            kept[-1] = True
        self._draw(times, np.flatnonzero(kept))

    def _count(self, at: float, size: float, turns: bool) -> Flags:
        """Look at a load step with a displacement of that size; whether it is to be drawn."""
        peak = turns and size > self._largest * FARTHER
        if peak:
            self._largest, self._peak = size, at
        if len(self._even) == 2 * EVENLY:
            self._even = self._even[::2]
            self._stride *= 2
        even = self._seen % self._stride == 0
        if even:
            self._even.append(at)
        self._seen += 1
        return np.array([peak or even])

    def _follow(self, times: Array, size: Array, turns: Indices) -> Flags:
        """Look at times (s) with displacements of that size (m), each after so many `turns`.

        Tells which are to be drawn.
        """
        largest = np.maximum.accumulate(np.append(self._largest, size))
        rising = np.append(self._rising, size >= largest[:-1])
        tops = np.flatnonzero(rising[:-1] & ~rising[1:])
        if tops.size:
            self._peak = float(times[tops[-1]])
        self._largest, self._rising = float(largest[-1]), bool(rising[-1])
        passed = np.append(self._next, turns)
        kept = passed[1:] > passed[:-1]
        self._even += times[kept].tolist()
        self._next = int(passed[-1])
        kept[tops[-1:]] = True
        return kept

    def values(self) -> dict[str, Any]:
        """Variables of the response; the state seen last must still be the committed one."""
        even = self._even
        if self._last is not None and even[-1] != self._last:
            even = [*even, self._last]
            if self._pictures[-1][0][-1] != self._last:
                self._draw(np.array([self._last]), np.array([-1]))
        if len(even) > EVENLY:
            even = [even[i] for i in np.linspace(0, len(even) - 1, EVENLY).round().astype(int)]
        shown = sorted({*even, *(() if self._peak is None else (self._peak,))})
        times, shapes, used = (np.concatenate(parts) for parts in zip(*self._pictures, strict=True))
        rows = np.searchsorted(times, shown)
        drawn = shapes[rows].T  # (2, points, members, snapshots)
        return {
            "snapshot_at": shown,
            "shape_x": drawn[0].swapaxes(0, 1),
            "shape_y": drawn[1].swapaxes(0, 1),
            "utilisation": used[rows].T,
        }

    def _draw(self, times: Array, rows: Indices) -> None:
        """Draw the pictures of some of the records that are looked at, by their rows."""
        if rows.size:
            structure = self._structure
            drawn = structure.members.pictures(structure.assembly, rows)
            self._pictures.append((times[rows], *drawn))
