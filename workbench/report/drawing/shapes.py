"""Deformed shapes of a response over its record: its snapshots, or chords of a column.

A response without snapshots that knows displacement and shortening gives straight lines between
base, impact point and head of a column: that is all it says about its shape. Points are complex
numbers, x + iy in m.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.base.errors import InputError
from workbench.report.drawing.frame import (
    displacement_unit,
    frame_scenario_of,
    node_on_paper,
    on_paper,
)
from workbench.report.drawing.sheet import Absences, Array, Request
from workbench.report.drawing.style import PALETTE
from workbench.report.page.formatting import NO_BREAK, THIN, number
from workbench.responses import Response
from workbench.scenarios import Column, ColumnScenario, Frame, FrameScenario, Scenario
from workbench.study.definition import Case

Points = NDArray[np.complex128]
INSTANTS = ("start", "half-way", "peak", "end")
REST, YIELDING = "#a8a8a8", PALETTE[1]  # colours: structure at rest, yielding member ends
YIELDS = 0.995  # utilisation from which a section counts as yielding
_CHORDS = 60  # instants taken from a history that has no snapshots
_BESIDE = 1e-6  # of the displacement along the hit, that a column moves out of its plane
_SMALL, _SHOWN = 0.015, 0.05  # of the size of the frame: too small to see; shown instead


def rest_lines(frame: Frame, points: int = 2) -> Points:
    """Members at rest, complex places (members, points) in m from their start to their end."""
    nodes = {node.name: node_on_paper(node) for node in frame.nodes}
    ends = np.array([(nodes[m.start], nodes[m.end]) for m in frame.members])
    lines: Points = ends[:, :1] + np.linspace(0.0, 1.0, points) * (ends[:, 1:] - ends[:, :1])
    return lines


@dataclass(frozen=True)
class Shapes:
    """Deformed shapes of one response.

    Arguments: `scenario`; `history`, time or step; `at` (snapshots,) in s or steps; `places` in m
    (x, y and z, members, points, snapshots); `moved` (snapshots,), the displacement that the
    scenario follows; `hinges` and their `used` (hinges, snapshots), the N-M utilisation (no
    hinges: not known); `chords`, whether only the ends of straight lines are known.
    """

    scenario: FrameScenario
    history: str
    at: Array
    places: Array
    moved: Array
    hinges: tuple[str, ...] = ()
    used: Array = field(default_factory=lambda: np.empty((0, 0)))
    chords: bool = False

    @property
    def frame(self) -> Frame:
        """The frame at rest."""
        return self.scenario.frame

    @cached_property
    def curves(self) -> Points:
        """The members (members, points, snapshots) on paper, without the depth of a plane frame."""
        x, y, z = self.places
        return np.asarray(on_paper(x, y, z if self.frame.spatial else 0.0))

    @property
    def along(self) -> Shapes:
        """The shapes as seen along the hit."""
        return replace(self, places=self.places[[2, 1, 0]])

    @property
    def aside(self) -> Shapes | None:
        """The shapes of a column as seen along the hit; None of one that stays in its plane."""
        moves = not self.frame.spatial and np.ptp(self.places[2]) > _BESIDE * np.ptp(self.places[0])
        return self.along if moves else None

    @property
    def peak(self) -> int:
        """The snapshot of the largest displacement."""
        return int(np.argmax(np.abs(self.moved)))

    @cached_property
    def rest_places(self) -> Array:
        """Places at rest in m (x, y and z, members, points)."""
        start, end = self.frame.places[self.frame.ends.T]
        share = np.linspace(0.0, 1.0, self.places.shape[2])
        return np.moveaxis(start[:, None] + share[:, None] * (end - start)[:, None], -1, 0)

    @cached_property
    def rest(self) -> Points:
        """The members (members, points) at rest."""
        return rest_lines(self.frame, self.places.shape[2])

    @property
    def size(self) -> float:
        """The larger of width and height at rest, in m."""
        return float(max(np.ptp(self.rest.real), np.ptp(self.rest.imag)))

    def index(self, instant: str | float) -> int:
        """Return the snapshot of an instant: one of `INSTANTS`, or a time (s) or step."""
        if instant == "half-way":
            size = np.abs(self.moved)
            return int(np.argmax(size[: self.peak + 1] >= 0.5 * size[self.peak]))
        named = {"start": 0, "peak": self.peak, "end": len(self.at) - 1}
        if instant in named:
            return named[str(instant)]
        return int(np.argmin(np.abs(self.at - float(instant))))

    def words(self, snapshot: int) -> str:
        """Say when a snapshot was taken and how far the frame had moved."""
        when = f"step {self.at[snapshot]:g}"
        if self.history == "time":
            when = f"{number(1e3 * self.at[snapshot], 3)}{THIN}ms"
        unit, size = displacement_unit(self.scenario), float(self.moved[snapshot])
        if abs(size) < 1e-6 * abs(self.moved[self.peak]):
            size = 0.0  # rounding
        return f"{when}, {number(size * unit.factor, 3)}{NO_BREAK}{unit.text}"

    def largest(self, snapshots: Sequence[int]) -> float:
        """Largest displacement of any drawn point in some snapshots, in m."""
        return float(np.abs(self.curves[..., snapshots] - self.rest[..., None]).max())

    def magnified(self, snapshot: int, times: float) -> Points:
        """Return the members (members, points) with displacements drawn so many times."""
        moved: Points = self.rest + times * (self.curves[..., snapshot] - self.rest)
        return moved

    def numbers(self, instant: str | float) -> Iterator[dict[str, Any]]:
        """Yield the numbers of a drawn shape: points of the members, then states of their ends."""
        snapshot, points = self.index(instant), self.places.shape[2]
        head = {"instant": str(instant), self.history: self.at[snapshot]}
        names = [member.name for member in self.frame.members]
        place = {
            "member": np.repeat(names, points),
            "point": np.tile(np.linspace(0.0, 1.0, points), len(names)),
        }
        drawn = self.curves[..., snapshot].ravel()
        paper = "on_paper_" if self.frame.spatial else ""
        yield {**head, **place, f"{paper}x_m": drawn.real, f"{paper}y_m": drawn.imag}
        if self.hinges:
            yield {**head, "hinge": list(self.hinges), "utilisation": self.used[:, snapshot]}


ShapesOfCases = list[tuple[Case, dict[str, Shapes]]]  # by label


def collected(request: Request, cases: Iterable[Case], notes: list[str]) -> ShapesOfCases:
    """Return the shapes by case and label; `notes` gets what is absent."""
    absent, chords = Absences(), dict[str, None]()
    shapes_of_cases: ShapesOfCases = []
    for case in cases:
        by_label = {}
        for label, response in request.answers(case, absent).items():
            shapes = shapes_of(case.scenario, response)
            if shapes is None:
                absent.without("deformed shape", label)
                continue
            by_label[label] = shapes
            chords |= {label: None} if shapes.chords else {}
        if by_label:
            shapes_of_cases.append((case, by_label))
    notes += absent.sentences()
    if chords:
        notes.append(
            f"Straight lines, {', '.join(chords)}: these models state the displacement of the hit "
            "point and the shortening only; the shape between is not known."
        )
    return shapes_of_cases


def instants_of(option: Any) -> tuple[str | float, ...]:
    """Return the option `instants` of a figure, checked. Raises `InputError`."""
    chosen = (option,) if isinstance(option, (str, float, int)) else tuple(option)
    for instant in chosen:
        known = instant in INSTANTS if isinstance(instant, str) else np.isfinite(instant)
        if not known or isinstance(instant, bool):
            allowed = f"must be among {', '.join(INSTANTS)}, or a time in s or a step"
            raise InputError("figure.options.instants", instant, allowed)
    if not 1 <= len(chosen) <= len(INSTANTS):
        allowed = f"must name one to {len(INSTANTS)} instants"
        raise InputError("figure.options.instants", list(chosen), allowed)
    return chosen


def magnification(largest: float, size: float) -> float:
    """Return how many times displacements are drawn: once, or a round number if they are small.

    Arguments: `largest` displacement and `size` of the frame, in m.
    """
    if largest >= _SMALL * size or largest <= 0.0:
        return 1.0
    wanted = _SHOWN * size / largest
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= wanted))


def corners_of(curves: Iterable[Points]) -> tuple[complex, complex]:
    """Lower left and upper right corner of everything in some curves."""
    z = np.concatenate([np.ravel(each) for each in curves])
    return complex(z.real.min(), z.imag.min()), complex(z.real.max(), z.imag.max())


def shapes_of(scenario: Scenario, response: Response) -> Shapes | None:
    """Return the deformed shapes that a response to a scenario knows, None if it knows none."""
    on_frame = frame_scenario_of(scenario)
    if on_frame is None or "displacement" not in response:
        return None
    history = "time" if "time" in response.coords else "step"
    when, moved = (response[name].values.astype(float) for name in (history, "displacement"))
    if "shape_x" in response:
        at = response["snapshot_at"].values.astype(float)
        x, y = response["shape_x"].values, response["shape_y"].values
        z = response["shape_z"].values if "shape_z" in response else np.zeros_like(x)
        states: dict[str, Any] = {}
        if "utilisation" in response:
            states["hinges"] = tuple(str(name) for name in response["hinge"].values)
            states["used"] = response["utilisation"].values.astype(float)
        places = np.stack([x, y, z])
        return Shapes(on_frame, history, at, places, np.interp(at, when, moved), **states)
    if "shortening" in response and isinstance(scenario, ColumnScenario):
        even = np.linspace(0, len(when) - 1, min(_CHORDS, len(when))).round().astype(int)
        few = np.unique([*even, int(np.argmax(np.abs(moved)))])
        down = response["shortening"].values.astype(float)[few]
        across = response["sideways"].values[few] if "sideways" in response else 0.0 * down
        curves, still = _chords(scenario.column, moved[few], across, down), np.zeros_like(down)
        places = np.stack([curves.real, curves.imag, [[still, across], [across, still]]])
        return Shapes(on_frame, history, when[few], places, moved[few], chords=True)
    return None


def _chords(column: Column, moved: Array, across: Array, down: Array) -> Points:
    # the impact point moves on a sphere around the base: the lower segment keeps its length
    high = np.sqrt(np.maximum(column.length_below**2 - moved**2 - across**2, 0.0))
    hit = moved + 1j * high
    return np.array([[np.zeros_like(hit), hit], [hit, 1j * (column.length - down)]])
