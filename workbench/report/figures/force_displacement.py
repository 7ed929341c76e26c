"""Force against displacement of static loading, with all of its reversals.

Options: `cases`, `quantity` (``force``, the default, or ``load_factor``), `until` (m: the record
up to the first displacement beyond it).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import Unit, title_of, unit_of
from workbench.fields import Choice
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
from workbench.report.figures.frames import displacement_unit, frame_scenario_of
from workbench.report.figures.panels import (
    STATIC,
    chosen_cases,
    handle,
    name_axes,
    panel_grid,
)
from workbench.report.figures.style import MUTED, legend_below
from workbench.study.definition import Case

_QUANTITY = Choice(("force", "load_factor"))
_LOOPS = 0.8  # width of a line that turns back, over that of one that does not


def draw(request: Request) -> Drawing:
    """Overlaid force-displacement curves, one panel per case."""
    quantity = request.option("quantity", "force")
    quantity = _QUANTITY.check("figure.options.quantity", quantity)
    cases, statements = chosen_cases(request, STATIC)
    if not cases:
        return nothing("Force-displacement curves need static loading; no case is static.")
    canvas, axes = panel_grid(len(cases), height=2.6, share_y=False)
    until = float(request.option("until", np.inf))
    blocks: list[Any] = []
    handles: list[Any] = []
    absent = Absences()
    for i, (case, panel) in enumerate(zip(cases, axes, strict=True)):
        along, up = _units(case, quantity)
        turning = False
        for label in request.shown(case):
            look = request.looks[label]
            response = request.stored.response(case.name, label)
            if response is None:
                absent.no_answer(label, case.name)
                continue
            if quantity not in response or "displacement" not in response:
                absent.without(f"{title_of(quantity)} and displacement", label)
                continue
            x, y = _until(response["displacement"].values, response[quantity].values, until)
            back = bool(np.any(np.diff(x) < 0.0))
            turning |= back
            x, y = thinned(x, y, 2400 if back else 700)
            style = look.curve()
            if back:
                style["linewidth"] *= _LOOPS
            panel.plot(x * along.factor, y * up.factor, **style)
            handles.append(handle(label, look))
            block = {"case": case.name, "label": label, "displacement_SI": x, f"{quantity}_SI": y}
            blocks.append(rows(block, len(x)))
        panel.set_title(case.name, loc="left")
        _finish(panel, turning)
        moment = up.text == "kN m" and quantity == "force"
        shown = "moment" if moment else title_of(quantity)
        turned = "rotation" if along.text == "rad" else "displacement"
        name_axes(panel, i, len(cases), f"{turned} ({along.text})", _with(shown, up))
    statements += absent.sentences()
    if not blocks:
        return nothing("No model answered these cases with a curve.", *statements)
    legend_below(canvas, handles)
    alt = f"{title_of(quantity)} over displacement for {', '.join(case.name for case in cases)}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _units(case: Case, quantity: str) -> tuple[Unit, Unit]:
    """Display units of displacement and of the quantity: patterns may hold moments only."""
    scenario = frame_scenario_of(case)
    along = unit_of("displacement") if scenario is None else displacement_unit(scenario)
    loads = getattr(scenario, "loads", ())
    if quantity == "force" and loads and not any(load.x or load.y for load in loads):
        return along, unit_of("moment")
    return along, unit_of(quantity)


def _with(name: str, unit: Unit) -> str:
    return f"{name} ({unit.text})" if unit.text else name


def _until(x: Array, y: Array, limit: float) -> tuple[Array, Array]:
    """The record up to the first displacement beyond a limit."""
    beyond = np.flatnonzero(np.abs(x) > limit)
    end = int(beyond[0]) if len(beyond) else len(x)
    return x[:end], y[:end]


def _finish(panel: Axes, turning: bool) -> None:
    """Loops get axes through the origin and air around them, other curves start on the axis."""
    if turning:
        panel.axhline(0.0, color=MUTED, linewidth=0.6, zorder=1)
        panel.axvline(0.0, color=MUTED, linewidth=0.6, zorder=1)
        panel.margins(x=0.04, y=0.06)
        return
    panel.margins(x=0.0)
    panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
