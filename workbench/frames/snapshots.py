"""Pictures of a frame over its record: deformed shapes and utilisation of the hinges."""

from typing import Any

import numpy as np

from workbench.arrays import Array
from workbench.frames.structure import FrameStructure

FARTHER = 1.0 + 1e-9  # cycles of equal size: the first one counts
EVENLY = 60  # snapshots over the record; one more at the peak
_SHARES = np.linspace(0.0, 1.0 - 1e-9, EVENLY)


class Snapshots:
    """Collects at most `EVENLY` + 1 snapshots while a run passes by.

    Arguments: the `structure`, whose committed state is read; `end` of the record, which starts
    at zero (time in s; None: unknown, snapshots are then even in the number of steps). Evenly
    spaced ones are those of the first step at or after their turn (`turns`, s). That of the peak
    follows the largest displacement by one step in time, and is where a path turns in statics.
    """

    def __init__(self, structure: FrameStructure, end: float | None) -> None:
        self._structure = structure
        self.turns = None if end is None else end * _SHARES
        self._even: list[float] = []
        self._peak: float | None = None
        self._pictures: list[tuple[float, Array, Array]] = []  # times, shapes, utilisation
        self._seen, self._stride, self._next = 0, 1, 0
        self._last: float | None = None
        self._largest = 0.0
        self._rising = False

    def see(self, at: float, displacement: float, *, turns: bool = False) -> None:
        """Look at the committed state at a time (s) or step, with its displacement (m).

        `turns`, whether a static path ends or turns back here.
        """
        size = abs(displacement)
        if self.turns is None:
            drawn = self._count(at, size, turns)
        else:
            drawn = self._follow(self.turns, at, size)
        self._last = at
        if drawn:
            self._draw(at)

    def _count(self, at: float, size: float, turns: bool) -> bool:
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
        return peak or even

    def _follow(self, turns: Array, at: float, size: float) -> bool:
        """Look at a time (s) with a displacement of that size (m); whether it is to be drawn."""
        peak = self._rising and size < self._largest
        if peak:
            self._peak = at
        self._rising, self._largest = size >= self._largest, max(self._largest, size)
        passed = int(np.searchsorted(turns, at, side="right"))
        even = passed > self._next
        if even:
            self._even.append(at)
        self._next = max(passed, self._next)
        return peak or even

    def values(self) -> dict[str, Any]:
        """Variables of the response; the state seen last must still be the committed one."""
        even = self._even
        if self._last is not None and even[-1] != self._last:
            even = [*even, self._last]
        if len(even) > EVENLY:
            even = [even[i] for i in np.linspace(0, len(even) - 1, EVENLY).round().astype(int)]
        shown = even if self._peak is None or self._peak in even else sorted([*even, self._peak])
        shapes, used = self._drawn(shown)
        return {
            "snapshot_at": shown,
            "shape_x": shapes[0],
            "shape_y": shapes[1],
            "utilisation": used,
        }

    def _drawn(self, shown: list[float]) -> tuple[Array, Array]:
        """Shapes (2, members, points, pictures) and utilisation (hinges, pictures) shown then."""
        if self._last is not None and self._pictures[-1][0] != self._last:
            self._draw(self._last)
        times, shapes, used = zip(*self._pictures, strict=True)
        rows = np.searchsorted(times, shown)
        drawn = np.stack([shapes[row] for row in rows], axis=-1)  # (members, points, 2, pictures)
        return drawn.transpose(2, 0, 1, 3), np.stack([used[row] for row in rows], axis=-1)

    def _draw(self, at: float) -> None:
        """Draw a picture of the committed state."""
        members = self._structure.members
        shape = members.shapes(self._structure.assembly)
        self._pictures.append((at, shape, members.utilisation()))
