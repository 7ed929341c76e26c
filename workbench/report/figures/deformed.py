"""Deformed shapes at the peak and at the end, true to scale, all labels of a case in one panel.

The column lies on its side, base at the left. Its members are drawn straight between base, hit
point and head: the displacement of the hit point and the shortening of the head are what
responses hold. Options: `cases`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from workbench.report.figures.drawing import (
    Absences,
    Array,
    Drawing,
    Request,
    joined,
    nothing,
    rows,
)
from workbench.report.figures.panels import chosen_cases, handle
from workbench.report.figures.style import INK, MUTED, TEXT_WIDTH, Look, legend_below, new_figure
from workbench.report.formatting import in_unit
from workbench.responses import Response
from workbench.study.definition import Case

_DOTS: Any = (0, (1, 1.5))
Shapes = dict[str, list[tuple[Array, Array]]]  # at the peak, then at the end of the record


def draw(request: Request) -> Drawing:
    """The polyline base, hit point, head at the largest displacement, dotted at the end."""
    cases, statements = chosen_cases(request)
    cases = [case for case in cases if hasattr(case.scenario, "column")]
    if not cases:
        return nothing("None of the cases is a column, the only structure drawn so far.")
    found: list[tuple[Case, Shapes]] = []
    absent = Absences()
    for case in cases:
        shapes: Shapes = {}
        for label in request.shown(case):
            response = request.stored.response(case.name, label)
            if response is None:
                absent.no_answer(label, case.name)
                continue
            if {"displacement", "shortening"} <= set(response.data_vars):
                top = int(np.argmax(response["displacement"].values))
                shapes[label] = [_shape(case, response, at) for at in (top, -1)]
            else:
                absent.without("displacement and shortening", label)
        if shapes:
            found.append((case, shapes))
    statements += absent.sentences()
    if not found:
        return nothing("No model states displacement and shortening together.", *statements)
    length = max(case.scenario.column.length for case, _ in found)
    most = max(float(y.max()) for _, shapes in found for pair in shapes.values() for _, y in pair)
    edge = 0.04 * length
    scale = (TEXT_WIDTH - 0.8) / (1.08 * length)  # inches per metre
    height = scale * (most + 2.0 * edge) + 0.32
    canvas = new_figure(height * len(found) + 0.85)
    axes = canvas.subplots(len(found), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    blocks: list[Any] = []
    handles: list[Any] = []
    for (case, shapes), panel in zip(found, axes, strict=True):
        _undeformed(panel, case, edge)
        for label, pair in shapes.items():
            look = request.looks[label]
            handles.append(handle(label, look))
            for instant, (x, y) in zip(("peak", "end"), pair, strict=True):
                panel.plot(x, y, **(look.curve() if instant == "peak" else _end(look)))
                block: dict[str, Any] = {"case": case.name, "label": label, "instant": instant}
                block |= {"height_m": x, "displacement_m": y}
                blocks.append(rows(block, len(x)))
            x, y = pair[0]
            panel.plot(x[1:2], y[1:2], **{**look.points(), "markersize": 3.5})
        panel.set_aspect("equal")
        panel.set_title(case.name, loc="left")
        panel.set_ylabel("(m)")
        panel.set_xlim(-0.04 * length, 1.04 * length)
        panel.set_ylim(-edge, most + edge)
    axes[-1].set_xlabel("height above the base (m), displacement upwards (m), same scale")
    grey = Line2D([], [], label="at the end of the record", color=MUTED, linestyle=_DOTS)
    legend_below(canvas, [*handles, grey])
    at = ", ".join(f"{case.name}: {_largest(request, case)}" for case, _ in found)
    alt = f"deformed shapes at the largest displacement ({at})"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _undeformed(panel: Axes, case: Case, size: float) -> None:
    """The straight column and the symbol of its base."""
    column = case.scenario.column
    panel.plot([0.0, column.length], [0.0, 0.0], color=MUTED, linewidth=0.8, linestyle=":")
    if column.base == "clamped":
        panel.plot([0.0, 0.0], [-size, size], color=INK, linewidth=2.2, zorder=1)
    else:
        panel.plot([0.0], [0.0], marker="o", color=INK, markerfacecolor="white", zorder=5)


def _end(look: Look) -> dict[str, Any]:
    return {**look.curve(), "linestyle": _DOTS, "linewidth": 1.0}


def _shape(case: Case, response: Response, at: int) -> tuple[Array, Array]:
    column = case.scenario.column
    sideways = float(response["displacement"].values[at])
    down = float(response["shortening"].values[at])
    # the hit point moves on a circle around the base: the lower segment keeps its length
    height = float(np.sqrt(max(column.length_below**2 - sideways**2, 0.0)))
    return np.array([0.0, height, column.length - down]), np.array([0.0, sideways, 0.0])


def _largest(request: Request, case: Case) -> str:
    found = [
        request.stored.number(case.name, label, "peak_displacement")
        for label in request.shown(case)
    ]
    known = [value for value in found if value is not None]
    return in_unit(max(known), "peak_displacement", 3) if known else "no peak"
