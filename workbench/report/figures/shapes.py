"""Deformed shapes of a response over its record: its snapshots, or chords of a column.

A response without snapshots that knows displacement and shortening gives straight lines between
base, hit point and head of a column: that is all it says about its shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from workbench.content.formatting import NO_BREAK, THIN, number
from workbench.errors import InputError
from workbench.report.figures.drawing import Array
from workbench.report.figures.frames import FrameScenario, displacement_unit, frame_scenario_of
from workbench.responses import Response
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Frame
from workbench.study.definition import Case

INSTANTS = ("start", "half-way", "peak", "end")
_CHORDS = 60  # instants taken from a history that has no snapshots
_SMALL, _SHOWN = 0.015, 0.05  # of the size of the frame: too small to see; shown instead


@dataclass(frozen=True)
class Shapes:
    """Deformed shapes of one response.

    Arguments: `scenario`; `history`, time or step; `at` (snapshots,) in s or steps; `x`, `y`
    (members, points, snapshots) in m; `moved` (snapshots,), the displacement that the scenario
    follows; `peak`, the snapshot of its largest magnitude; `hinges` and their `used` (hinges,
    snapshots), the N-M utilisation (no hinges: not known); `chords`, whether only the ends of
    straight lines are known.
    """

    scenario: FrameScenario
    history: str
    at: Array
    x: Array
    y: Array
    moved: Array
    peak: int
    hinges: tuple[str, ...]
    used: Array
    chords: bool = False

    @property
    def frame(self) -> Frame:
        """The frame at rest."""
        return self.scenario.frame

    @cached_property
    def undeformed(self) -> tuple[Array, Array]:
        """Coordinates (members, points) at rest, in m."""
        return undeformed(self.frame, self.x.shape[1])

    def index(self, instant: str | float) -> int:
        """The snapshot of an instant: one of `INSTANTS`, or a time (s) or step."""
        if instant == "start":
            return 0
        if instant == "half-way":
            size = np.abs(self.moved)
            return int(np.argmax(size[: self.peak + 1] >= 0.5 * size[self.peak]))
        if instant == "peak":
            return self.peak
        if instant == "end":
            return len(self.at) - 1
        return int(np.argmin(np.abs(self.at - float(instant))))

    def words(self, snapshot: int) -> str:
        """When a snapshot was taken and how far the frame had moved."""
        if self.history == "time":
            when = f"{number(1e3 * self.at[snapshot], 3)}{THIN}ms"
        else:
            when = f"step {self.at[snapshot]:g}"
        unit = displacement_unit(self.scenario)
        size = float(self.moved[snapshot])
        if abs(size) < 1e-6 * abs(self.moved[self.peak]):
            size = 0.0  # rounding
        moved = number(size * unit.factor, 3)
        return f"{when}, {moved}{NO_BREAK}{unit.text}"

    def largest(self, snapshots: Sequence[int] | slice) -> float:
        """Largest displacement of any drawn point in some snapshots, in m."""
        x0, y0 = self.undeformed
        dx, dy = self.x[..., snapshots] - x0[..., None], self.y[..., snapshots] - y0[..., None]
        return float(np.hypot(dx, dy).max())

    def magnified(self, snapshot: int, times: float) -> tuple[Array, Array]:
        """Coordinates (members, points) with displacements drawn so many times."""
        x0, y0 = self.undeformed
        x, y = self.x[..., snapshot], self.y[..., snapshot]
        return x0 + times * (x - x0), y0 + times * (y - y0)


def instants_of(option: Any) -> tuple[str | float, ...]:
    """The option `instants` of a figure, checked. Raises `InputError`."""
    chosen = (option,) if isinstance(option, (str, float, int)) else tuple(option)
    for instant in chosen:
        known = instant in INSTANTS if isinstance(instant, str) else np.isfinite(instant)
        if not known or isinstance(instant, bool):
            allowed = f"must be among {', '.join(INSTANTS)}, or a time in s or a step"
            raise InputError("figure.options.instants", instant, allowed)
    if not 1 <= len(chosen) <= len(INSTANTS):
        raise InputError(
            "figure.options.instants", list(chosen), f"must name one to {len(INSTANTS)} instants"
        )
    return chosen


def undeformed(frame: Frame, points: int) -> tuple[Array, Array]:
    """Coordinates (members, points) of a frame at rest, in m."""
    ends = [(frame.node(m.start), frame.node(m.end)) for m in frame.members]
    share = np.linspace(0.0, 1.0, points)
    x = np.array([a.x + share * (b.x - a.x) for a, b in ends])
    y = np.array([a.y + share * (b.y - a.y) for a, b in ends])
    return x, y


def extent_of(frame: Frame) -> float:
    """The larger of width and height of a frame at rest, in m."""
    x, y = undeformed(frame, 2)
    return float(max(np.ptp(x), np.ptp(y)))


def magnification(largest: float, size: float) -> float:
    """How many times displacements are drawn: once, or a round number if they are small.

    Arguments: `largest` displacement and `size` of the frame, in m.
    """
    if largest >= _SMALL * size or largest <= 0.0:
        return 1.0
    wanted = _SHOWN * size / largest
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= wanted))


def shapes_of(case: Case, response: Response) -> Shapes | None:
    """The deformed shapes that a response knows, None if it knows none."""
    scenario = frame_scenario_of(case)
    if scenario is None or "displacement" not in response:
        return None
    history = "time" if "time" in response.coords else "step"
    when = np.asarray(response[history].values, dtype=float)
    displacement = np.asarray(response["displacement"].values, dtype=float)
    top = int(np.argmax(np.abs(displacement)))
    hinges: tuple[str, ...] = ()
    used = np.empty((0, 0))
    if "shape_x" in response:
        at = np.asarray(response["snapshot_at"].values, dtype=float)
        x, y = (np.asarray(response[name].values, dtype=float) for name in ("shape_x", "shape_y"))
        if "utilisation" in response:
            used = np.asarray(response["utilisation"].values, dtype=float)
            hinges = tuple(str(name) for name in response["hinge"].values)
        chords = False
    elif "shortening" in response and isinstance(case.scenario, (ColumnImpact, ColumnPushover)):
        even = np.linspace(0, len(when) - 1, min(_CHORDS, len(when))).round().astype(int)
        chosen = np.unique([*even, top])
        at = when[chosen]
        down = np.asarray(response["shortening"].values, dtype=float)[chosen]
        x, y = _chords(case.scenario.column, displacement[chosen], down)
        chords = True
    else:
        return None
    moved = np.interp(at, when, displacement)
    peak = int(np.argmax(np.abs(moved)))
    return Shapes(scenario, history, at, x, y, moved, peak, hinges, used, chords)


def _chords(column: Column, sideways: Array, down: Array) -> tuple[Array, Array]:
    # the hit point moves on a circle around the base: the lower segment keeps its length
    height = np.sqrt(np.maximum(column.length_below**2 - sideways**2, 0.0))
    nothing = np.zeros_like(sideways)
    x = np.array([[nothing, sideways], [sideways, nothing]])
    y = np.array([[nothing, height], [height, column.length - down]])
    return x, y
