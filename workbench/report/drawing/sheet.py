"""Figures from request to drawing: stored answers, panels with legend and notes, numbers.

**Second part.** Charts that verbs draw: pulses on logarithmic axes, a sweep.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from workbench.base.arrays import Array as Array
from workbench.base.arrays import Indices
from workbench.base.errors import InputError
from workbench.report.drawing.style import (
    MUTED,
    TEXT_WIDTH,
    Look,
    Style,
    entry,
    house_style,
    legend_below,
    logarithmic,
    new_figure,
    numbered,
    settle,
)
from workbench.report.page.formatting import axis_label, unit_of
from workbench.responses import PEAK, Response
from workbench.study.assessor import Assessment
from workbench.study.definition import Case, Figure, Study

T = TypeVar("T")

MOST_PANELS = 6


@dataclass(frozen=True)
class Request:
    """Request to draw: a `figure` of a `study` from `stored` results.

    `cases` are those that name the figure (or all), `labels` those that it shows, `looks` the
    look of every label.
    """

    study: Study
    figure: Figure
    stored: Assessment
    cases: tuple[Case, ...]
    labels: tuple[str, ...]
    looks: Mapping[str, Look]

    def option(self, name: str, default: Any) -> Any:
        """A drawing option of the figure."""
        return self.figure.options.get(name, default)

    @property
    def quantity(self) -> str:
        """The option `quantity`, by default the first quantity of the study."""
        return str(self.option("quantity", self.study.quantities[0]))

    @property
    def against(self) -> str:
        """The option `against`, by default the reference; the best one if the form left it out."""
        label = str(self.option("against", self.study.reference))
        return label if label in self.study.models else self.study.ranked[0]

    def number(self, case: Case, label: str, name: str) -> float | None:
        """A scalar of a cell, None if it is not known."""
        return self.stored.number(case.name, label, name)

    def errors(self, quantity: str, metric: str = "relative_error") -> dict[tuple[str, str], Any]:
        """Rows of the comparisons with `against`, by (case, label)."""
        return self.stored.errors(quantity, metric, self.against)

    def interval(self, case: Case, quantity: str) -> tuple[float, float] | None:
        """Ends of the interval that refinement leaves around the reference, in SI."""
        value = self.number(case, self.study.reference, quantity)
        row = self.stored.ladder(case.name, quantity)
        if value is None or row is None or row["uncertainty"] is None:
            return None
        return value - row["uncertainty"], value + row["uncertainty"]

    def shown(self, case: Case) -> list[str]:
        """The labels that are to answer a case, in order."""
        return [label for label in self.labels if self.stored.expects(case.name, label)]

    def chosen(self, notes: list[str], static: bool | None = None) -> list[Case]:
        """The cases that get a panel: the option `cases`, else the first six.

        Arguments: `notes` gets a statement if some do not; `static` keeps scenarios of that kind,
        what is pushed or what moves in time (None: all).
        """
        cases = [case for case in self.cases if static in (None, case.scenario.STATIC)]
        if self.option("cases", ()):
            return cases
        return first(cases, MOST_PANELS, "cases; the tables hold all of them", notes)

    def case_panels(
        self, static: bool | None = None, **options: Any
    ) -> tuple[Sheet, list[tuple[Case, Axes]]]:
        """A sheet with a panel for each of the `chosen` cases; `options` as of `Sheet.grid`."""
        notes: list[str] = []
        cases = self.chosen(notes, static)
        sheet = Sheet.grid(len(cases), notes, **{"sharey": False, **options})
        return sheet, list(zip(cases, sheet.panels, strict=True))

    def named(self) -> tuple[Case, ...]:
        """The case of the option `case`, else all."""
        named = self.option("case", "")
        return tuple(case for case in self.cases if not named or case.name == named)

    def answers(
        self, case: Case, absent: Absences, needed: Iterable[str] = (), what: str = ""
    ) -> dict[str, Response]:
        """Responses to a case by label; `absent` gets those without what is `needed`, in words."""
        answers = {}
        for label in self.shown(case):
            response = self.stored.response(case.name, label)
            if response is None:
                absent.no_answer(label, case.name, self.stored.collapses(case.name, label))
            elif not set(needed) <= set(response.data_vars):
                absent.without(what, label)
            else:
                answers[label] = response
        return answers

    def first_answered(
        self, needed: set[str], what: str, notes: list[str]
    ) -> tuple[Case | None, dict[str, Response]]:
        """The first of the `named` cases with an answer that has what is `needed`, and its answers.

        Six of them at most; `notes` gets what is said of the others. The case is None if there
        is no answer at all.
        """
        for case in self.named():
            absent = Absences()
            answers = self.answers(case, absent, needed, what)
            if answers:
                notes += absent.sentences()
                return case, dict(first(list(answers.items()), MOST_PANELS, "answers", notes))
        return None, {}


@dataclass(frozen=True)
class Drawing:
    """A drawn figure: `canvas` (None if there was nothing to draw), the numbers in it, its text.

    `data` is a long table of everything drawn; `statements` say what is absent and why; `alt`
    describes the picture in words; `width` is its share of the text width.
    """

    canvas: Canvas | None
    data: pd.DataFrame
    statements: tuple[str, ...] = ()
    alt: str = ""
    width: float = 1.0


class Absences:
    """Answers that a figure cannot show: missing ones, and those without a needed quantity."""

    def __init__(self) -> None:
        self._names: dict[str, dict[str, None]] = {}

    def no_answer(self, label: str, case: str, collapses: bool = False) -> None:
        """A label gave no answer to a case, or answered that the structure collapses."""
        head = f"Collapse in {label}" if collapses else f"No answer from {label}"
        self._names.setdefault(head, {})[case] = None

    def without(self, what: str, label: str) -> None:
        """A label answers, but does not know something."""
        self._names.setdefault(f"Without {what}", {})[label] = None

    def sentences(self) -> list[str]:
        """One sentence per kind of absence."""
        heads = sorted(self._names, key=lambda head: head.startswith("Without"))
        return [f"{head}: {', '.join(self._names[head])}." for head in heads]


class Sheet:
    """A figure in the making: panels, the numbers drawn, legend entries, notes.

    Arguments: a `canvas`, its `panels` and how many of them stand side by side; `notes`
    so far.
    """

    def __init__(
        self,
        canvas: Canvas,
        panels: Iterable[Axes],
        notes: Sequence[str] = (),
        columns: int = 1,
    ) -> None:
        self.canvas, self.panels, self.columns = canvas, list(panels), columns
        self.notes, self.absent = list(notes), Absences()
        self._blocks: list[pd.DataFrame] = []
        self._legend: dict[str, Any] = {}

    @classmethod
    def grid(
        cls, count: int, notes: Sequence[str] = (), *, height: float = 2.2, **options: Any
    ) -> Sheet:
        """A sheet with a number of panels; rows are `height` inches high, a single one higher.

        `options`: `width` in inches, `sharex` (default not) and `sharey` (default yes).
        """
        rows, columns = grid_shape(max(count, 1))
        if count <= 1:
            height *= 1.25
        whole = height * rows + 0.55
        return cls.table(rows, columns, whole, notes, count=count, **{"sharey": True, **options})

    @classmethod
    def table(
        cls,
        rows: int,
        columns: int,
        height: float,
        notes: Sequence[str] = (),
        *,
        count: int | None = None,
        width: float = TEXT_WIDTH,
        **options: Any,
    ) -> Sheet:
        """A sheet `height` inches high with rows and columns of panels, the first `count`.

        `options`, those of `subplots` of matplotlib.
        """
        canvas = new_figure(height, width)
        axes = canvas.subplots(rows, columns, squeeze=False, **options)
        for spare in axes.flat[axes.size if count is None else count :]:
            spare.remove()
        return cls(canvas, axes.flat[:count], notes, columns)

    @property
    def panel(self) -> Axes:
        """The only, or the first panel."""
        return self.panels[0]

    def name(self, panel: Axes, title: str, x: str, y: str) -> None:
        """A panel's title, and axis labels where they are needed: outside, below and left."""
        index = self.panels.index(panel)
        if title:
            panel.set_title(title, loc="left")
        if index + self.columns >= len(self.panels):
            panel.set_xlabel(x)
        if index % self.columns == 0:
            panel.set_ylabel(y)

    def level(self, most: float = 4.0) -> None:
        """One scale up for all panels; if their ranges differ by a factor above `most`, say so."""
        limits = np.array([panel.get_ylim() for panel in self.panels if panel.lines])
        if not len(limits):
            return
        if np.ptp(limits, axis=1).max() <= most * np.ptp(limits, axis=1).min():
            for panel in self.panels:
                panel.set_ylim(limits.min(), limits.max())
        else:
            self.notes.append("Each panel has an upright scale of its own.")

    def record(self, table: pd.DataFrame | None = None, /, **columns: Any) -> None:
        """Numbers for the data file: a table, or columns with single values repeated."""
        if table is None:
            single = not any(np.ndim(value) for value in columns.values())
            table = pd.DataFrame(columns, index=[0] if single else None)
        self._blocks.append(table)

    def legend(self, *entries: Any) -> None:
        """Legend entries; equal names appear once."""
        self._legend |= {str(each.get_label()): each for each in entries}

    def finish(self, alt: str, *, empty: str = "", beside: str = "", width: float = 1.0) -> Drawing:
        """The drawing, its legend below the panels, or `beside` them (upper, center).

        Without a number that was recorded it only says so, in the sentence `empty`.
        """
        notes = (*self.notes, *self.absent.sentences())
        if not self._blocks:
            return nothing(*([empty] if empty else []), *notes)
        if beside:
            place: Any = f"outside right {beside}"
            self.canvas.legend(handles=[*self._legend.values()], loc=place, handletextpad=0.6)
        elif self._legend:
            legend_below(self.canvas, self._legend.values())
        numbers = pd.concat(self._blocks, ignore_index=True)
        return Drawing(self.canvas, numbers, notes, alt, width)


def drawn(draw: Callable[..., Drawing], *arguments: Any) -> Drawing:
    """Return the drawing of a function, in the house style and laid out."""
    with house_style():
        drawing = draw(*arguments)
        if drawing.canvas is not None:
            settle(drawing.canvas)
    return drawing


def canvas_of(draw: Callable[..., Drawing], *arguments: Any) -> Canvas:
    """Return the canvas of a function that always has something to draw."""
    canvas = drawn(draw, *arguments).canvas
    assert canvas is not None
    return canvas


def nothing(*notes: str) -> Drawing:
    """A drawing that only says why nothing could be drawn."""
    return Drawing(None, pd.DataFrame(), notes or ("There is nothing to draw.",))


def first(items: Sequence[T], most: int, what: str, notes: list[str]) -> list[T]:
    """The first few of many things; `notes` gets a statement if that leaves some out."""
    if len(items) > most:
        notes.append(f"Shown are the first {most} of {len(items)} {what}.")
    return list(items[:most])


def grid_shape(count: int, most: int = 3) -> tuple[int, int]:
    """Rows and columns for a number of panels, at most `most` side by side."""
    columns = 2 if count == 4 and most < 4 else min(count, most)
    return -(-count // columns), columns


def thinned(x: Array, y: Array, most: int = 700) -> tuple[Array, Array]:
    """Fewer points of a curve for drawing; extremes of x and y within each bucket are kept.

    The order of the points stays, so that loops stay loops.
    """
    if len(x) <= most:
        return x, y
    edges = np.linspace(0, len(x), most // 2 + 1).astype(int)
    keep = {0, len(x) - 1}
    turns = bool(np.any(np.diff(x) < 0.0))
    for low, high in itertools.pairwise(edges):
        for values in (y, x) if turns else (y,):
            keep |= {low + int(find(values[low:high])) for find in (np.argmin, np.argmax)}
    index = np.array(sorted(keep))
    return x[index], y[index]


def evenly(size: int, most: int) -> Indices:
    """Indices of at most so many points, evenly spread, both ends among them."""
    return np.unique(np.linspace(0, size - 1, min(size, most)).astype(np.int64))


_MOST_LINES = 10  # told apart by their colours and dashes
_HIGH, _WIDE = 3.6, 4.6  # inches
_ASYMPTOTE: Style = {"color": MUTED, "linewidth": 0.6, "linestyle": ":"}


class Line(NamedTuple):
    """Points of a curve, and its two asymptotes: where it goes in x and in y, if known."""

    x: Sequence[float]
    y: Sequence[float]
    left: float | None = None
    floor: float | None = None


def chart(lines: Mapping[str, Line], x: str, y: str) -> Canvas:
    """A chart of labelled lines over the quantities `x` and `y`, on logarithmic axes."""
    return canvas_of(_chart, lines, x, y)


def _chart(lines: Mapping[str, Line], x: str, y: str) -> Drawing:
    sheet = Sheet.table(1, 1, _HIGH, width=_WIDE)
    for i, (label, line) in enumerate(lines.items()):
        sheet.panel.plot(line.x, line.y, **numbered(i).curve())
        sheet.record(label=label, x=line.x, y=line.y)
        if len(lines) > 1:
            sheet.legend(entry(label, **numbered(i).curve()))
    sheet.panel.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
    for line in lines.values():
        if line.left is not None:
            sheet.panel.axvline(line.left, **_ASYMPTOTE)
        if line.floor is not None:
            sheet.panel.axhline(line.floor, **_ASYMPTOTE)
    for axis in (sheet.panel.xaxis, sheet.panel.yaxis):
        logarithmic(axis, lambda value: f"{value:g}")
    return sheet.finish(f"{y} over {x}")


def sweep_chart(answers: xr.Dataset, name: str) -> Canvas:
    """The peak over the first key of a sweep, a line for each model and other value.

    Raises `InputError` where no peak is known, or lines cannot be told apart; `name`, the picture.
    """
    peaks = answers.get(PEAK)
    if peaks is None:
        raise InputError("--plot", name, "there is no peak to draw", "see the outcomes")
    _, key, *others = peaks.dims
    lines = peaks.stack(line=("model", *others)).transpose("line", key)  # noqa: PD013 (of xarray)
    if len(lines) > _MOST_LINES or lines[key].dtype.kind not in "if":
        text = f"needs numbers first, and at most {_MOST_LINES} lines"
        raise InputError("--plot", name, text, "vary less, or write the table alone")
    of = ", as if hit through the shear centre" if "edge_factor" in answers else ""
    return canvas_of(_sweep, lines, str(key), others, f"{axis_label(PEAK)}{of}")


def _sweep(lines: xr.DataArray, key: str, others: Sequence[str], peak: str) -> Drawing:
    sheet, x = Sheet.table(1, 1, _HIGH, width=_WIDE), lines[key].to_numpy()
    for i, (names, line) in enumerate(zip(lines["line"].to_numpy(), lines, strict=True)):
        model, *values = names
        texts = (f"{other} = {value}" for other, value in zip(others, values, strict=True))
        label = ", ".join([str(model), *texts])
        sheet.panel.plot(x, unit_of(PEAK).factor * line.to_numpy(), **numbered(i).curve(marker="o"))
        sheet.record(label=label, x=x, y=line.to_numpy())
        sheet.legend(entry(label, **numbered(i).curve()))
    of = lines[key].attrs.get("units", "")
    sheet.panel.set(xlabel=f"{key} ({of})" if of else key, ylabel=peak)
    return sheet.finish(f"peaks over {key}")
