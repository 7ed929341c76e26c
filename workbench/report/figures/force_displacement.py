"""Force against displacement of pushovers. Options: `cases`, `until` (m)."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.report.figures.drawing import (
    Absences,
    Drawing,
    Request,
    joined,
    nothing,
    rows,
    thinned,
)
from workbench.report.figures.panels import chosen_cases, handle, name_axes, panel_grid
from workbench.report.figures.style import legend_below
from workbench.report.formatting import axis_label, unit_of


def draw(request: Request) -> Drawing:
    """Overlaid force-displacement curves, one panel per case."""
    cases, statements = chosen_cases(request, "pushover")
    if not cases:
        return nothing("Force-displacement curves need a pushover; none of the cases is one.")
    canvas, axes = panel_grid(len(cases), height=2.6, share_y=False)
    until = float(request.option("until", np.inf))
    blocks: list[Any] = []
    handles: list[Any] = []
    absent = Absences()
    length, force = unit_of("displacement").factor, unit_of("force").factor
    for i, (case, panel) in enumerate(zip(cases, axes, strict=True)):
        for label in request.shown(case):
            look = request.looks[label]
            response = request.stored.response(case.name, label)
            if response is None:
                absent.no_answer(label, case.name)
                continue
            if "force" not in response or "displacement" not in response:
                absent.without("force and displacement", label)
                continue
            x, y = response["displacement"].values, response["force"].values
            inside = x <= until
            x, y = thinned(x[inside], y[inside])
            panel.plot(x * length, y * force, **look.curve())
            handles.append(handle(label, look))
            block = {"case": case.name, "label": label, "displacement_m": x, "force_N": y}
            blocks.append(rows(block, len(x)))
        panel.set_title(case.name, loc="left")
        name_axes(panel, i, len(cases), axis_label("displacement"), axis_label("force"))
        panel.margins(x=0.0)
        panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
    statements += absent.sentences()
    if not blocks:
        return nothing("No model answered these pushovers.", *statements)
    legend_below(canvas, handles)
    alt = "force over displacement for " + ", ".join(case.name for case in cases)
    return Drawing(canvas, joined(blocks), tuple(statements), alt)
