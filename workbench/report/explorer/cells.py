"""One answer on the page: its curves, its shapes, its numbers, its findings.

Curves are thinned and rounded to whole numbers of 16 bits.
"""

from base64 import b64encode
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.report.chapters.answer import GOOD
from workbench.report.chapters.choice import FAIR
from workbench.report.drawing.shapes import YIELDS, Points, Shapes, shapes_of
from workbench.report.drawing.sheet import evenly, thinned
from workbench.report.figures.curves import ledger
from workbench.report.page.formatting import duration, in_unit, interval
from workbench.responses import PEAK, RESIDUAL, Outcome, Response
from workbench.responses.uncertainty import (
    DATA_WIDTHS,
    SAMPLE_WIDTHS,
    directions_of,
    estimate,
    uncertainty_of,
    variants,
)
from workbench.scenarios import ColumnImpact, FrameImpact
from workbench.study.assessor import CellState
from workbench.study.definition import DATA, Case

MEDIAN = "velocity.at_50"  # of a fragility curve
_ENDS = {
    "ok": "answered",
    "collapse": "collapses",
    "out-of-domain": "refused",
    "not-converged": "not converged",
    "not run": "not run",
    "timed-out": "out of time",
    "crashed": "crashed",
    "invalid-input": "input refused",
}
_BOW = 0.002  # of the size of the structure: a member that bends less is sent by its ends


class Plane(NamedTuple):
    """Axes of the curves of a page: titles, units and factors of their axes, and the numbers.

    The first of the `numbers` (of quantities, with titles) is drawn over all cases; it and the
    second have an error. The cursor begins at the quantity `begin`. `band`: what a band is of.
    """

    heading: str
    across: tuple[str, str, float]
    upward: tuple[str, str, float]
    numbers: dict[str, tuple[str, str, float]]
    begin: str
    band: str = ""

    def text(self, quantity: str, value: float, width: float | None, kind: str) -> str:
        """A number of the page with its half-width, see `in_unit`."""
        text, unit = in_unit(value, quantity, width=width), self.numbers[quantity][1]
        text = text if text.endswith(unit) else f"{text}\u00a0{unit}"
        return f"{text} ({kind})" if kind and width != 0.0 else text


HISTORIES = Plane(
    "Displacement of the impact point",
    ("time", "ms", 1e3),
    ("displacement", "mm", 1e3),
    {
        PEAK: ("peak displacement", "mm", 1e3),
        RESIDUAL: ("residual displacement", "mm", 1e3),
        "time_of_peak": ("time of the peak", "ms", 1e3),
    },
    "time_of_peak",
)
FRAGILITIES = Plane(
    "Probability of exceeding the limit",
    ("impact velocity", "m/s", 1.0),
    ("probability of exceedance", "", 1.0),
    {
        MEDIAN: ("velocity at 50 %", "m/s", 1.0),
        "velocity.at_10": ("velocity at 10 %", "m/s", 1.0),
        "velocity.at_90": ("velocity at 90 %", "m/s", 1.0),
    },
    MEDIAN,
    "Bands of 90 %: samples, and of corrected curves model and reference.",
)


# most points of a history on a page, from fine to rough; the first that fits counts
DETAILS = (500, 300, 200, 120, 60, 24)
_FINEST = 32_000  # steps of the largest magnitude of a curve, in whole numbers of 16 bits


def coarse(points: int) -> int:
    """Most instants of bands, energies and deformed shapes beside histories of so many points."""
    return max(points // 7, 6)


def packed(values: ArrayLike) -> dict[str, Any]:
    """Values as whole multiples of a step, in two bytes each, as text."""
    table = np.asarray(values, dtype=float)
    step = float(np.abs(table).max(initial=0.0)) / _FINEST or 1.0
    return {"step": step, "n": b64encode(np.round(table / step).astype("<i2").tobytes()).decode()}


@dataclass(frozen=True)
class CurveRecord:
    """The curves of one answer as fine as any page keeps them.

    `time` (s) and `moved` (m), the history, or velocity (m/s) and probability; `band`, places and
    edges of its uncertainty; `energies`, times, energies by part and what came in (J); `shapes`,
    the deformed ones.
    """

    time: Array
    moved: Array
    band: tuple[Array, Array, Array] | None
    energies: tuple[Array, dict[str, Array], Array] | None
    shapes: Shapes | None

    def kept(self, points: int, aside: bool = False) -> dict[str, Any]:
        """The curves as the page holds them; with `aside`, shapes as seen along the hit, too."""
        time, moved = thinned(self.time, self.moved, points)
        curves: dict[str, Any] = {"t": packed(time), "d": packed(moved)}
        if self.band is not None:
            curves["band"] = dict(zip(("t", "low", "high"), map(packed, self.band), strict=True))
        if self.energies is not None:
            at, parts, brought = self.energies
            few = evenly(len(at), coarse(points))
            kinds = {name: packed(part[few]) for name, part in parts.items()}
            curves["energy"] = {"t": packed(at[few]), "parts": kinds, "in": packed(brought[few])}
        if self.shapes is not None:
            curves["shape"] = _shape(self.shapes, coarse(points), aside)
        return curves


def record_of(case: Case, response: Response, *, band: bool) -> CurveRecord | None:
    """The curves of a response, None if it has none; with `band` the numerical one of a history."""
    if "curve.median" in response:
        velocity, median, low, high = (
            response[f"curve.{name}"].values for name in ("velocity", "median", "low", "high")
        )
        return CurveRecord(velocity, median, (velocity, low, high), None, None)
    if "time" not in response.coords or "displacement" not in response:
        return None
    time, moved = (response[name].values.astype(float) for name in ("time", "displacement"))
    energies = None
    if {"dissipated", "elastic", "kinetic", "input_energy"} <= set(response.data_vars):
        struck = isinstance(case.scenario, ColumnImpact | FrameImpact)
        energies = ledger(response, "time", struck)
    known = _band(time, moved, response) if band else None
    return CurveRecord(time, moved, known, energies, shapes_of(case.scenario, response))


def _band(time: Array, moved: Array, response: Response) -> tuple[Array, Array, Array] | None:
    """Edges of the displacement at some instants, by the rule that holds for every number."""
    directions = directions_of(response)
    if not directions:
        return None
    few = evenly(len(time), coarse(DETAILS[0]))
    curves = {name: run["displacement"].values[few] for name, run in variants(response)}
    widths = [
        estimate(directions, {name: float(curve[i]) for name, curve in curves.items()}).width
        for i in range(len(few))
    ]
    if any(width is None for width in widths):
        return None
    half = np.array(widths, dtype=float)
    return time[few], moved[few] - half, moved[few] + half


def is_upright(rest: Points) -> bool:
    """Whether all members (members, points) stand in one vertical line: they are drawn lying."""
    return bool(np.ptp(rest.real) == 0.0)


def _shape(shapes: Shapes, snapshots: int, aside: bool) -> dict[str, Any]:
    """Displacements of the members at some snapshots, the peak among them.

    Numbers of a snapshot: x and y of each point, member after member; with `aside` as seen along
    the hit after that.
    """
    few = np.unique([*evenly(len(shapes.at), snapshots), shapes.peak])
    views = (shapes, shapes.along) if aside else (shapes,)
    moved = np.concatenate([(view.curves - view.rest[..., None])[..., few] for view in views])
    if is_upright(shapes.rest):
        moved = moved.imag + 1j * moved.real
    tracks = [_track(moved[i], _BOW * shapes.size) for i in range(len(moved))]
    pairs = np.concatenate([np.stack([z.real, z.imag], axis=-1) for z in tracks], axis=1)
    shape: dict[str, Any] = {
        "t": packed(shapes.at[few]),
        "points": [track.shape[1] for track in tracks],
        "moved": packed(pairs),
        "chords": shapes.chords,
    }
    if shapes.hinges:
        yields = shapes.used[:, few].T >= YIELDS
        shape["yields"] = [np.flatnonzero(row).tolist() for row in yields]
    return shape


def _track(moved: Points, bow: float) -> Points:
    """Displacements (snapshots, points) of a member, of its ends alone if it stays straight."""
    track: Points = moved.T
    share = np.linspace(0.0, 1.0, track.shape[1])
    off = track - track[:, :1] - share * (track[:, -1:] - track[:, :1])
    return track[:, [0, -1]] if np.abs(off).max() < bow else track


def numbers_of(
    cell: CellState,
    response: Response | None,
    errors: Mapping[str, Mapping[str, Any]],
    plane: Plane,
    *,
    best: CellState | None,
    sure: bool,
) -> dict[str, Any]:
    """Return the facts of a cell: outcome, numbers of the `plane`, their `errors` by quantity.

    `best`, the governing reference (None: none may judge, as it is made of no tests); `sure`,
    whether it is inside its domain.
    """
    main, *_ = plane.numbers
    numbers = dict(cell.numbers)
    if response is not None:
        numbers |= {each: float(response[each]) for each in plane.numbers if each in response}
    words = "answered, outside its domain" if cell.ok and cell.outside else _ENDS[cell.outcome]
    content: dict[str, Any] = {"ends": words, "outside": bool(cell.outside)}
    if not cell.ok:
        words = f"{words}: {cell.message}"
    if best is not None and {cell.outcome, best.outcome} == {Outcome.OK, Outcome.COLLAPSE}:
        content["apart"] = True
        words = f"{words}; {best.label} {'survives' if best.ok else 'collapses'}"
    if cell.collapse is not None:
        content["collapse"] = [cell.collapse.time, cell.collapse.displacement]
    for name, quantity in (("main", main), ("begin", plane.begin)):
        if quantity in numbers:
            content[name] = _short(numbers[quantity])
    if (width := _width(response, main)[0]) and main in numbers:
        content["width"] = _short(width)
    if main in errors:
        error, width = (errors[main][name] for name in ("error", "uncertainty"))
        content |= {"error": _short(error), "tone": _tone(error, width, sure) if best else ""}
    return {**content, "row": [words, *_texts(cell, numbers, response, errors, plane)]}


def _texts(
    cell: CellState,
    numbers: Mapping[str, float],
    response: Response | None,
    errors: Mapping[str, Mapping[str, Any]],
    plane: Plane,
) -> Iterator[str]:
    """The numbers of a cell as the reader sees them, empty where it does not know them.

    The first two are followed by their error.
    """
    for i, quantity in enumerate(plane.numbers):
        known = quantity in numbers
        value = numbers.get(quantity, 0.0)
        yield plane.text(quantity, value, *_width(response, quantity)) if known else ""
        if i < 2 and known and quantity in errors:
            row = errors[quantity]
            yield interval("relative_error", quantity, row["error"], row["uncertainty"])
        elif i < 2:
            yield ""
    took = cell.numbers.get("solve_time", cell.numbers.get("wall_time"))
    looked_up = response is not None and response.attrs.get("model") in DATA
    cold = "may hold compiling" if cell.numbers.get("cold") else ""
    yield "" if took is None or looked_up else cold or duration(took)


def _width(response: Response | None, quantity: str) -> tuple[float | None, str]:
    """Half-width of a number (zero: none is shown) and what it is of: the runs behind it, data."""
    if response is None:
        return 0.0, ""
    if directions_of(response):
        return uncertainty_of(response, quantity), "numerical"
    for kind, words in ((DATA_WIDTHS, "data"), (SAMPLE_WIDTHS, "sampling")):
        if stated := uncertainty_of(response, quantity, kind):
            return stated, words
    return 0.0, ""


def _tone(error: float, width: float | None, sure: bool) -> str:
    """Of one error, as the matrix has it: doubtful at best with an unknown width or not `sure`."""
    far = abs(error) + (width or 0.0)
    if far <= GOOD and width is not None and sure:
        return "good"
    return "bad" if far > FAIR and sure else "doubt"


def _short(value: float) -> float:
    return float(f"{value:.5g}")
