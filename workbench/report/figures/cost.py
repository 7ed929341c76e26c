"""Cost against error: wall time of each label and its deviation from the reference.

Options: `quantity` (a scalar, default the first of the study), `against` (a label).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from workbench.content.formatting import duration, title_of
from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.panels import handle
from workbench.report.figures.style import legend_below, new_figure

_FLOOR = 1e-4  # smaller deviations are drawn here: they are below what matters


def draw(request: Request) -> Drawing:
    """One marker per case and label on logarithmic axes; down and left is better."""
    quantity = str(request.option("quantity", request.study.quantities[0]))
    reference = request.study.reference
    against = str(request.option("against", reference))
    table = request.stored.errors(quantity, "relative_error", against)
    errors = {(r["case"], r["model"]): float(r["error"]) for r in table.to_dict("records")}
    statements: list[str] = []
    blocks: list[Any] = []
    handles: list[Any] = []
    canvas = new_figure(3.7)
    panel = canvas.subplots()
    few = len(request.cases) <= 12
    for label in request.labels:
        if request.study.models[label].name == "published":
            continue  # a number that was looked up costs nothing
        look, is_reference = request.looks[label], label == against
        points = []
        for case in request.cases:
            seconds = request.stored.number(case.name, label, "wall_time")
            error = _own_error(request, case.name, quantity) if is_reference else None
            if not is_reference:
                error = errors.get((case.name, label))
            if not request.stored.ok(case.name, label) or not seconds or error is None:
                continue
            points.append((seconds, abs(error)))
            entry = {"case": case.name, "label": label, "wall_time_s": seconds, "error": error}
            blocks.append(rows(entry, 1))
        if not points and is_reference:
            statements.append(f"{label} is not refined: its own uncertainty is unknown.")
            continue
        if not points:
            if any(request.stored.expects(case.name, label) for case in request.cases):
                statements.append(f"{label} has no {title_of(quantity)} to compare.")
            continue
        x, y = np.array(points).T
        style = look.points()
        if not few:
            panel.plot(x, np.maximum(y, _FLOOR), **{**style, "markersize": 2.5, "alpha": 0.35})
            x, y = np.array([np.median(x)]), np.array([np.median(y)])
        panel.plot(x, np.maximum(y, _FLOOR), **style)
        name = f"{label} (its own uncertainty)" if is_reference else label
        handles.append(handle(name, look, curve=False))
    if not blocks:
        return nothing(f"No model has both a wall time and an error of {title_of(quantity)}.")
    if not few:
        statements.append("Small markers are single cases, large ones the medians of a model.")
    panel.set_xscale("log")
    panel.set_yscale("log")
    low, high = panel.get_ylim()
    panel.set_ylim(max(0.8 * _FLOOR, 0.4 * low), 2.0 * high)
    panel.margins(x=0.12)
    panel.set_xlabel("wall time of one case")
    panel.set_ylabel(f"deviation of the {title_of(quantity)}\nfrom {against}")
    _logarithmic(panel.xaxis, lambda value: duration(value, 1))
    _logarithmic(panel.yaxis, lambda value: f"{100 * value:g} %")
    legend_below(canvas, handles)
    if any(abs(float(block["error"].iloc[0])) < _FLOOR for block in blocks):
        statements.append(f"Deviations below {100 * _FLOOR:g} % are drawn at {100 * _FLOOR:g} %.")
    alt = f"wall time against deviation of the {title_of(quantity)} from {against}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _logarithmic(axis: Axis, words: Callable[[float], str]) -> None:
    """A decade at least; ticks at 1, 2, 5 over short ranges, at full decades over long ones."""
    low, high = sorted(axis.get_view_interval())
    if high < 10.0 * low:
        middle = (low * high) ** 0.5
        low, high = middle / 10.0**0.5, middle * 10.0**0.5
        axis.set_view_interval(low, high, ignore=True)
    short = high / low < 150.0
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if short else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: words(float(value))))
    axis.set_minor_formatter(NullFormatter())


def _own_error(request: Request, case: str, quantity: str) -> float | None:
    """The relative numerical uncertainty of the reference stands for its error."""
    ladder = request.stored.ladder(case, quantity)
    return None if ladder is None else ladder["relative"]
