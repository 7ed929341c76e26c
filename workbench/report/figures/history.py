"""Histories over time, all labels of a case in one panel.

Options: `quantity` (a history; `impulse` stands for the percussions summed up), `hinge` (a name,
for quantities that belong to hinges), `cases`, `until` (s).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import axis_label, title_of, unit_of
from workbench.report.figures.drawing import (
    Absences,
    Array,
    Drawing,
    Request,
    joined,
    nothing,
    rows,
    thinned,
)
from workbench.report.figures.panels import (
    IN_TIME,
    chosen_cases,
    handle,
    level,
    name_axes,
    panel_grid,
)
from workbench.report.figures.style import MUTED, legend_below
from workbench.responses import Response
from workbench.study.definition import Case

_PEAKS = {"displacement": ("peak_displacement", "time_of_peak")}


def draw(request: Request) -> Drawing:
    """Overlaid histories, one panel per case; models without a history show their peak."""
    quantity = str(request.option("quantity", "displacement"))
    cases, statements = chosen_cases(request, IN_TIME)
    if not cases:
        return nothing("Histories in time need an impact or a ground motion; no case is one.")
    canvas, axes = panel_grid(len(cases), share_y=False)
    absent = Absences()
    blocks: list[Any] = []
    handles: list[Any] = []
    for i, (case, panel) in enumerate(zip(cases, axes, strict=True)):
        handles.extend(_panel(request, case, panel, quantity, blocks, absent))
        panel.set_title(case.name, loc="left")
        name_axes(panel, i, len(cases), axis_label("time"), axis_label(quantity))
        panel.set_xlim(left=0.0)
        panel.margins(x=0.0)
        if not panel.lines:
            panel.text(0.5, 0.5, "no curve", transform=panel.transAxes, ha="center", color=MUTED)
    level(axes)
    hinge = request.option("hinge", "")
    if hinge:
        statements.append(f"Hinge: {hinge}.")
    statements += absent.sentences()
    if not blocks:
        return nothing(f"No model answered these cases with {title_of(quantity)}.", *statements)
    legend_below(canvas, handles)
    names = ", ".join(case.name for case in cases)
    alt = f"{title_of(quantity)} over time for {names}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _panel(
    request: Request, case: Case, panel: Axes, quantity: str, blocks: list[Any], absent: Absences
) -> list[Any]:
    handles: list[Any] = []
    time_unit, unit = unit_of("time").factor, unit_of(quantity).factor
    column = f"{quantity}_SI"
    until = float(request.option("until", np.inf))
    for label in request.shown(case):
        look = request.looks[label]
        response = request.stored.response(case.name, label)
        if response is None:
            absent.no_answer(label, case.name)
            continue
        curve = _curve(response, quantity, str(request.option("hinge", "")))
        if curve is not None:
            time, values = curve
            inside = time <= until
            time, values = thinned(time[inside], values[inside])
            panel.plot(time * time_unit, values * unit, **look.curve())
            block = {"case": case.name, "label": label, "time_s": time, column: values}
            blocks.append(rows(block, len(time)))
            handles.append(handle(label, look))
            continue
        peak, when = (
            request.stored.number(case.name, label, name) if name else None
            for name in _PEAKS.get(quantity, ("", ""))
        )
        if peak is None:
            hinge = request.option("hinge", "")
            where = f" of {hinge} in {case.name}" if hinge else ""
            absent.without(f"{title_of(quantity)} over time{where}", label)
        elif when is None:
            panel.axhline(peak * unit, **{**look.curve(), "linestyle": ":"})
            handles.append(handle(f"{label} (peak only)", look._replace(line=":")))
            blocks.append(
                rows({"case": case.name, "label": label, "time_s": np.nan, column: peak}, 1)
            )
        else:
            panel.plot([when * time_unit], [peak * unit], **look.points())
            handles.append(handle(f"{label} (peak only)", look, curve=False))
            blocks.append(
                rows({"case": case.name, "label": label, "time_s": when, column: peak}, 1)
            )
    return handles


def _curve(response: Response, quantity: str, hinge: str) -> tuple[Array, Array] | None:
    if "time" not in response.coords:
        return None
    time = np.asarray(response["time"].values, dtype=float)
    if quantity == "impulse":
        if "percussion" not in response:
            return None
        return time, np.cumsum(response["percussion"].values)
    if quantity not in response:
        return None
    values = response[quantity]
    if values.dims == ("hinge", "time") and hinge in values["hinge"].values:
        values = values.sel(hinge=hinge)
    if values.dims != ("time",):
        return None
    return time, np.asarray(values.values, dtype=float)
