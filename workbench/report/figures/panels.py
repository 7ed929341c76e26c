"""Panels side by side, one per case, and the legend they share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from workbench.report.figures.drawing import Absences, Request
from workbench.report.figures.style import TEXT_WIDTH, Look, grid_shape, new_figure
from workbench.responses import Response
from workbench.study.definition import Case

MOST_PANELS = 6


STATIC = ("pushover", "static")
IN_TIME = ("impact", "motion")


def chosen_cases(
    request: Request, kinds: str | tuple[str, ...] = ""
) -> tuple[list[Case], list[str]]:
    """The cases that get a panel, and a statement if some do not.

    Arguments: `kinds` keeps scenarios whose kind ends so (empty: all). The option `cases` names
    them; otherwise the first six are taken.
    """
    cases = [case for case in request.cases if case.scenario.KIND.endswith(kinds)]
    named = request.option("cases", ())
    if named:
        return [case for case in cases if case.name in named], []
    if len(cases) <= MOST_PANELS:
        return cases, []
    return cases[:MOST_PANELS], [
        f"Shown are the first {MOST_PANELS} of {len(cases)} cases; the tables hold all of them."
    ]


def first_answered(
    request: Request, needed: set[str], what: str
) -> tuple[Case | None, dict[str, Response], list[str]]:
    """The case of a figure that shows one: the option `case`, or the first with an answer.

    Arguments: `needed`, the variables a response must have; `what` they are, in words. Result:
    the case (None: no answer at all), its responses by label, and statements on absent ones.
    """
    named = request.option("case", "")
    for case in request.cases:
        if named and case.name != named:
            continue
        found, absent = {}, Absences()
        for label in request.shown(case):
            response = request.stored.response(case.name, label)
            if response is None:
                absent.no_answer(label, case.name)
            elif not needed <= set(response.data_vars):
                absent.without(what, label)
            else:
                found[label] = response
        if found:
            return case, found, absent.sentences()
    return None, {}, []


def panel_grid(
    count: int,
    *,
    height: float = 2.2,
    width: float = TEXT_WIDTH,
    share_x: bool = False,
    share_y: bool = True,
    most: int = 3,
) -> tuple[Canvas, list[Axes]]:
    """A figure with a number of panels; each row is `height` inches high, a single one higher."""
    rows, columns = grid_shape(count, most)
    if count == 1:
        height *= 1.25
    canvas = new_figure(height * rows + 0.55, width)
    axes = canvas.subplots(rows, columns, sharex=share_x, sharey=share_y, squeeze=False)
    flat = list(axes.flat)
    for spare in flat[count:]:
        spare.remove()
    return canvas, flat[:count]


def name_axes(panel: Axes, index: int, count: int, x: str, y: str, most: int = 3) -> None:
    """Axis labels where they are needed: below the lowest panels, left of the first ones."""
    columns = grid_shape(count, most)[1]
    if index + columns >= count:
        panel.set_xlabel(x)
    if index % columns == 0:
        panel.set_ylabel(y)


def level(axes: Sequence[Axes], most: float = 4.0) -> None:
    """One scale up for all panels whose ranges differ by no more than a factor `most`."""
    limits = [panel.get_ylim() for panel in axes if panel.lines]
    sizes = [high - low for low, high in limits]
    if not limits or max(sizes) > most * min(sizes):
        return
    common = min(low for low, _ in limits), max(high for _, high in limits)
    for panel in axes:
        panel.set_ylim(*common)


def handle(label: str, look: Look, *, curve: bool = True) -> Line2D:
    """Legend entry of a label: its line, or its marker."""
    style: dict[str, Any] = look.curve() if curve else look.points()
    return Line2D([], [], label=label, **style)
