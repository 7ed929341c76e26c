"""Pictures of a frame over its record: deformed shapes and utilisation of the hinges."""

from typing import Any

import numpy as np

from workbench.arrays import Array
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
        times = np.atleast_1d(at).tolist()
        for when, moved in zip(times, np.atleast_1d(displacement).tolist(), strict=True):
            self._see(when, moved, turns)
        kept = {*self._even, self._peak}
        rows = {when: row for row, when in enumerate(times) if when in kept}
        if rows.keys() - self._pictures.keys():
            self._draw(rows)
            self._pictures = {when: p for when, p in self._pictures.items() if when in kept}

    def _see(self, at: float, displacement: float, turns: bool) -> None:
        if self._turns is None:
            if turns and abs(displacement) > self._largest * FARTHER:
                self._largest, self._peak = abs(displacement), at
        else:
            falling = abs(displacement) < self._largest
            if falling and self._rising:
                self._peak = at
            self._rising = not falling
            self._largest = max(self._largest, abs(displacement))
        if self._has_turn(at):
            self._even.append(at)
        self._seen += 1
        self._last = at

    def _has_turn(self, at: float) -> bool:
        if self._turns is not None:
            if self._next == EVENLY or at < self._turns[self._next]:
                return False
            self._next = int(np.searchsorted(self._turns, at, side="right"))
            return True
        if len(self._even) == 2 * EVENLY:
            self._even = self._even[::2]
            self._stride *= 2
        return self._seen % self._stride == 0

    def values(self) -> dict[str, Any]:
        """Variables of the response; the state seen last must still be the committed one."""
        even = self._even
        if self._last is not None and even[-1] != self._last:
            even = [*even, self._last]
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
