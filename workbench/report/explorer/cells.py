"""One answer on the page: its curves, its shapes, its numbers, its findings.

Curves are few whole numbers: thinned, rounded to a step, each as its difference from the last. The
page's script decodes them by sums.
"""

import json
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
from workbench.report.stored import CellState
from workbench.responses import Outcome, Response
from workbench.responses.uncertainty import directions_of, estimate, uncertainty_of, variants
from workbench.scenarios import ColumnImpact, FrameImpact
from workbench.study.assessment.budget import PEAK, RESIDUAL
from workbench.study.definition import DATA, Case

MEDIAN = "velocity.at_50"  # of a fragility curve
_BOW = 0.002  # of the size of the structure: a member that bends less is sent by its ends


class Plane(NamedTuple):
    """What the curves of a page show: titles, units and factors of their axes, and the numbers.

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
    "Displacement of the hit point",
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


class Detail(NamedTuple):
    """Most points of a history, snapshots, and points of bands and energies on a page."""

    points: int
    snapshots: int
    coarse: int


# from fine to rough; the first that fits counts
DETAILS = (
    Detail(500, 61, 80),
    Detail(300, 61, 50),
    Detail(200, 31, 40),
    Detail(120, 21, 25),
    Detail(60, 11, 15),
    Detail(24, 5, 8),
)
FINE, ROUGH = 10_000, 2_000  # steps of the largest magnitude of a curve; of a shape


def packed(values: ArrayLike, fine: int = FINE) -> dict[str, Any]:
    """Values (..., n) as whole multiples of a step, along the first axis each less the last one.

    The step is the largest magnitude over `fine`, rounded to three digits.
    """
    table = np.asarray(values, dtype=float)
    largest = float(np.abs(table).max(initial=0.0))
    step = float(f"{largest / fine:.3g}") or 1.0  # nothing to tell apart, or too small for that
    whole = np.round(table / step).astype(np.int64)
    first = np.zeros_like(whole[:1])
    return {"step": step, "n": np.diff(whole, axis=0, prepend=first).ravel().tolist()}


@dataclass(frozen=True)
class Record:
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

    def kept(self, detail: Detail) -> dict[str, Any]:
        """The curves as the page holds them."""
        time, moved = thinned(self.time, self.moved, detail.points)
        curves: dict[str, Any] = {"t": packed(time), "d": packed(moved)}
        if self.band is not None:
            curves["band"] = dict(zip(("t", "low", "high"), map(packed, self.band), strict=True))
        if self.energies is not None:
            at, parts, brought = self.energies
            few = evenly(len(at), detail.coarse)
            kinds = {name: packed(part[few]) for name, part in parts.items()}
            curves["energy"] = {"t": packed(at[few]), "parts": kinds, "in": packed(brought[few])}
        if self.shapes is not None:
            curves["shape"] = _shape(self.shapes, detail)
        return curves


def record_of(case: Case, response: Response, *, band: bool) -> Record | None:
    """The curves of a response, None if it has none; with `band` the numerical one of a history."""
    if "curve.median" in response:
        velocity, median, low, high = (
            response[f"curve.{name}"].values for name in ("velocity", "median", "low", "high")
        )
        return Record(velocity, median, (velocity, low, high), None, None)
    if "time" not in response.coords or "displacement" not in response:
        return None
    time, moved = (response[name].values.astype(float) for name in ("time", "displacement"))
    energies = None
    if {"dissipated", "elastic", "kinetic", "input_energy"} <= set(response.data_vars):
        struck = isinstance(case.scenario, ColumnImpact | FrameImpact)
        energies = ledger(response, "time", struck)
    known = _band(time, moved, response) if band else None
    return Record(time, moved, known, energies, shapes_of(case.scenario, response))


def _band(time: Array, moved: Array, response: Response) -> tuple[Array, Array, Array] | None:
    """Edges of the displacement at some instants, by the rule that holds for every number."""
    directions = directions_of(response)
    if not directions:
        return None
    few = evenly(len(time), DETAILS[0].coarse)
    curves = {name: run["displacement"].values[few] for name, run in variants(response)}
    widths = [
        estimate(directions, {name: float(curve[i]) for name, curve in curves.items()}).width
        for i in range(len(few))
    ]
    if any(width is None for width in widths):
        return None
    half = np.array(widths, dtype=float)
    return time[few], moved[few] - half, moved[few] + half


def _shape(shapes: Shapes, detail: Detail) -> dict[str, Any]:
    """Displacements of the members at some snapshots, the peak among them.

    Numbers of a snapshot: x and y of each point, member after member.
    """
    few = np.unique([*evenly(len(shapes.at), detail.snapshots), shapes.peak])
    moved = (shapes.curves - shapes.rest[..., None])[..., few]
    tracks = [_track(moved[i], _BOW * shapes.size) for i in range(len(moved))]
    pairs = np.concatenate([np.stack([z.real, z.imag], axis=-1) for z in tracks], axis=1)
    shape: dict[str, Any] = {
        "t": packed(shapes.at[few]),
        "points": [track.shape[1] for track in tracks],
        "n": packed(pairs.reshape(len(few), -1), ROUGH),
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
    content: dict[str, Any] = {
        "outcome": cell.outcome,
        "text": dict(_texts(cell, numbers, response, errors, plane)),
    }
    if not cell.ok:
        content["message"] = cell.message
    if cell.collapse is not None:
        content["collapse"] = [cell.collapse.time, cell.collapse.displacement]
    if cell.outside:
        content["outside"] = 1
    for name, quantity in (("main", main), ("begin", plane.begin)):
        if quantity in numbers:
            content[name] = _short(numbers[quantity])
    if (width := _width(response, main)[0]) and main in numbers:
        content["width"] = _short(width)
    if main in errors:
        error, width = (errors[main][name] for name in ("error", "uncertainty"))
        content |= {"error": _short(error), "tone": _tone(error, width, sure) if best else ""}
    if best is not None and {cell.outcome, best.outcome} == {Outcome.OK, Outcome.COLLAPSE}:
        content["apart"] = f"{best.label} {'survives' if best.ok else 'collapses'}"
    return content


def _texts(
    cell: CellState,
    numbers: Mapping[str, float],
    response: Response | None,
    errors: Mapping[str, Mapping[str, Any]],
    plane: Plane,
) -> Iterator[tuple[str, str]]:
    """The numbers of a cell as the reader sees them; those that it does not know are absent."""
    for quantity in plane.numbers:
        if quantity not in numbers:
            continue
        yield quantity, plane.text(quantity, numbers[quantity], *_width(response, quantity))
        if quantity in errors:
            row = errors[quantity]
            text = interval("relative_error", quantity, row["error"], row["uncertainty"])
            yield f"{quantity} error", text
    took = cell.numbers.get("solve_time", cell.numbers.get("wall_time"))
    looked_up = response is not None and response.attrs.get("model") in DATA
    if took is not None and not looked_up:
        yield "cost", "may hold compiling" if cell.numbers.get("cold") else duration(took)


def _width(response: Response | None, quantity: str) -> tuple[float | None, str]:
    """Half-width of a number (zero: none is shown) and what it is of: the runs behind it, data."""
    if response is None:
        return 0.0, ""
    if directions_of(response):
        return uncertainty_of(response, quantity), "numerical"
    for kind in ("data", "sampling"):
        stated: float = json.loads(response.attrs.get(f"{kind}_uncertainty", "{}")).get(quantity, 0)
        if stated:
            return stated, kind
    return 0.0, ""


def _tone(error: float, width: float | None, sure: bool) -> str:
    """Of one error, as the matrix has it: doubtful at best with an unknown width or not `sure`."""
    far = abs(error) + (width or 0.0)
    if far <= GOOD and width is not None and sure:
        return "good"
    return "bad" if far > FAIR and sure else "doubt"


def _short(value: float) -> float:
    return float(f"{value:.5g}")
