"""Deformed shapes of a response over its record: its snapshots, or chords of a column.

A response without snapshots that knows displacement and shortening gives straight lines between
base, hit point and head of a column: that is all it says about its shape. Points are complex
numbers, x + iy in m.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.content.formatting import NO_BREAK, THIN, number
from workbench.errors import InputError
from workbench.report.drawing.layout import displacement_unit, frame_scenario_of
from workbench.report.drawing.sheet import Absences, Array, Request
from workbench.responses import Response
from workbench.scenarios import Column, ColumnScenario, Frame, FrameScenario
from workbench.study.definition import Case

Points = NDArray[np.complex128]
INSTANTS = ("start", "half-way", "peak", "end")
_CHORDS = 60  # instants taken from a history that has no snapshots
_SMALL, _SHOWN = 0.015, 0.05  # of the size of the frame: too small to see; shown instead


@dataclass(frozen=True)
class Shapes:
    """Deformed shapes of one response.

    Arguments: `scenario`; `history`, time or step; `at` (snapshots,) in s or steps; `curves`
    (members, points, snapshots); `moved` (snapshots,), the displacement that the scenario
    follows; `hinges` and their `used` (hinges, snapshots), the N-M utilisation (no hinges: not
    known); `chords`, whether only the ends of straight lines are known.
    """

    scenario: FrameScenario
    history: str
    at: Array
    curves: Points
    moved: Array
    hinges: tuple[str, ...]
    used: Array
    chords: bool = False

    @property
    def frame(self) -> Frame:
        """The frame at rest."""
        return self.scenario.frame

    @property
    def peak(self) -> int:
        """The snapshot of the largest displacement."""
        return int(np.argmax(np.abs(self.moved)))

    @cached_property
    def rest(self) -> Points:
        """The members (members, points) at rest."""
        share = np.linspace(0.0, 1.0, self.curves.shape[1])
        nodes = {node.name: complex(node.x, node.y) for node in self.frame.nodes}
        ends = np.array([(nodes[m.start], nodes[m.end]) for m in self.frame.members])
        lines: Points = ends[:, :1] + share * (ends[:, 1:] - ends[:, :1])
        return lines

    @property
    def size(self) -> float:
        """The larger of width and height at rest, in m."""
        return float(max(np.ptp(self.rest.real), np.ptp(self.rest.imag)))

    def index(self, instant: str | float) -> int:
        """The snapshot of an instant: one of `INSTANTS`, or a time (s) or step."""
        if instant == "half-way":
            size = np.abs(self.moved)
            return int(np.argmax(size[: self.peak + 1] >= 0.5 * size[self.peak]))
        named = {"start": 0, "peak": self.peak, "end": len(self.at) - 1}
        if instant in named:
            return named[str(instant)]
        return int(np.argmin(np.abs(self.at - float(instant))))

    def words(self, snapshot: int) -> str:
        """When a snapshot was taken and how far the frame had moved."""
        when = f"step {self.at[snapshot]:g}"
        if self.history == "time":
            when = f"{number(1e3 * self.at[snapshot], 3)}{THIN}ms"
        unit, size = displacement_unit(self.scenario), float(self.moved[snapshot])
        if abs(size) < 1e-6 * abs(self.moved[self.peak]):
            size = 0.0  # rounding
        return f"{when}, {number(size * unit.factor, 3)}{NO_BREAK}{unit.text}"

    def largest(self, snapshots: Sequence[int] | slice) -> float:
        """Largest displacement of any drawn point in some snapshots, in m."""
        return float(np.abs(self.curves[..., snapshots] - self.rest[..., None]).max())

    def magnified(self, snapshot: int, times: float) -> Points:
        """The members (members, points) with displacements drawn so many times."""
        moved: Points = self.rest + times * (self.curves[..., snapshot] - self.rest)
        return moved

    def numbers(self, instant: str | float) -> Iterator[dict[str, Any]]:
        """The numbers of a drawn shape: points of the members, then states of their ends."""
        snapshot = self.index(instant)
        head = {"instant": str(instant), self.history: self.at[snapshot]}
        names = [member.name for member in self.frame.members]
        points = self.curves.shape[1]
        drawn = self.curves[..., snapshot].ravel()
        yield {
            **head,
            "member": np.repeat(names, points),
            "point": np.tile(np.linspace(0.0, 1.0, points), len(names)),
            "x_m": drawn.real,
            "y_m": drawn.imag,
        }
        if self.hinges:
            yield {**head, "hinge": list(self.hinges), "utilisation": self.used[:, snapshot]}


Found = list[tuple[Case, dict[str, Shapes]]]


def collected(request: Request, cases: Iterable[Case], said: list[str]) -> Found:
    """Shapes by case and label; `said` gets statements on what is absent."""
    absent, chords = Absences(), dict[str, None]()
    found: Found = []
    for case in cases:
        by_label = {}
        for label, response in request.answers(case, absent).items():
            shapes = shapes_of(case, response)
            if shapes is None:
                absent.without("deformed shape", label)
                continue
            by_label[label] = shapes
            chords |= {label: None} if shapes.chords else {}
        if by_label:
            found.append((case, by_label))
    said += absent.sentences()
    if chords:
        said.append(
            f"Straight lines, {', '.join(chords)}: these models state the displacement of the hit "
            "point and the shortening only; the shape between is not known."
        )
    return found


def instants_of(option: Any) -> tuple[str | float, ...]:
    """The option `instants` of a figure, checked. Raises `InputError`."""
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
    """How many times displacements are drawn: once, or a round number if they are small.

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


def shapes_of(case: Case, response: Response) -> Shapes | None:
    """The deformed shapes that a response knows, None if it knows none."""
    scenario = frame_scenario_of(case)
    if scenario is None or "displacement" not in response:
        return None
    history = "time" if "time" in response.coords else "step"
    when, moved = (response[name].values.astype(float) for name in (history, "displacement"))
    hinges: tuple[str, ...] = ()
    used = np.empty((0, 0))
    if "shape_x" in response:
        at = response["snapshot_at"].values.astype(float)
        curves = response["shape_x"].values + 1j * response["shape_y"].values
        if "utilisation" in response:
            used = response["utilisation"].values.astype(float)
            hinges = tuple(str(name) for name in response["hinge"].values)
    elif "shortening" in response and isinstance(case.scenario, ColumnScenario):
        even = np.linspace(0, len(when) - 1, min(_CHORDS, len(when))).round().astype(int)
        chosen = np.unique([*even, int(np.argmax(np.abs(moved)))])
        at, down = when[chosen], response["shortening"].values.astype(float)[chosen]
        curves = _chords(case.scenario.column, moved[chosen], down)
    else:
        return None
    moved = np.interp(at, when, moved)
    return Shapes(scenario, history, at, curves, moved, hinges, used, "shape_x" not in response)


def _chords(column: Column, sideways: Array, down: Array) -> Points:
    # the hit point moves on a circle around the base: the lower segment keeps its length
    hit = sideways + 1j * np.sqrt(np.maximum(column.length_below**2 - sideways**2, 0.0))
    return np.array([[np.zeros_like(hit), hit], [hit, 1j * (column.length - down)]])
