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
        self._even: dict[float, Picture] = {}
        self._peak: dict[float, Picture] = {}
        self._seen, self._stride, self._next = 0, 1, 0
        self._last: float | None = None
        self._drawn: Picture | None = None  # of all records that are looked at
        self._largest = 0.0
        self._rising = False

    def see(self, at: Any, displacement: Any, *, turns: bool = False) -> None:
        """Look at the committed state at a time (s) or step, with its displacement (m).

        Or at several of them. `turns`, whether a static path ends or turns back here.
        """
        self._drawn = None
        records = zip(np.atleast_1d(at), np.atleast_1d(displacement), strict=True)
        for row, (when, moved) in enumerate(records):
            self._see(float(when), float(moved), row, turns)

    def _see(self, at: float, displacement: float, row: int, turns: bool) -> None:
        if self._turns is None:
            if turns and abs(displacement) > self._largest * FARTHER:
                self._largest = abs(displacement)
                self._peak = {at: self._picture(row)}
        else:
            falling = abs(displacement) < self._largest
            if falling and self._rising:
                self._peak = {at: self._picture(row)}
            self._rising = not falling
            self._largest = max(self._largest, abs(displacement))
        if self._has_turn(at):
            self._even[at] = self._peak.get(at) or self._picture(row)
        self._seen += 1
        self._last = at

    def _has_turn(self, at: float) -> bool:
        if self._turns is not None:
            if self._next == EVENLY or at < self._turns[self._next]:
                return False
            self._next = int(np.searchsorted(self._turns, at, side="right"))
            return True
        if len(self._even) == 2 * EVENLY:
            self._even = dict(list(self._even.items())[::2])
            self._stride *= 2
        return self._seen % self._stride == 0

    def values(self) -> dict[str, Any]:
        """Variables of the response; the state seen last must still be the committed one."""
        even = list(self._even)
        if self._last is not None and even[-1] != self._last:
            even.append(self._last)
            self._even[self._last] = self._picture(-1)
        if len(even) > EVENLY:
            even = [even[i] for i in np.linspace(0, len(even) - 1, EVENLY).round().astype(int)]
        pictures = dict(sorted({**self._peak, **{at: self._even[at] for at in even}}.items()))
        shapes = np.stack([shape for shape, _ in pictures.values()], axis=-1)
        return {
            "snapshot_at": list(pictures),
            "shape_x": shapes[:, :, 0],
            "shape_y": shapes[:, :, 1],
            "utilisation": np.stack([used for _, used in pictures.values()], axis=-1),
        }

    def _picture(self, row: int) -> Picture:
        """The picture of one of the records that are looked at; all are drawn at once."""
        if self._drawn is None:
            members = self._structure.members
            shapes, used = members.shapes(self._structure.assembly), members.utilisation()
            self._drawn = shapes.reshape(-1, *shapes.shape[-3:]), np.atleast_2d(used)
        shapes, used = self._drawn
        return shapes[row], used[row]
