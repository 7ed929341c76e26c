"""Refinement: ladders of the reference, meshes of one model, steps of integrators.

``convergence``, options: `quantity`, `cases`: the ladder of the reference, element size across.
``meshes``, options: `sizes`, label to element size in m; `quantity`, `case`.
``work-precision``, option: `time` (work is the time of solving, not evaluations of the forces).
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.content.formatting import axis_label, in_unit, number, title_of, unit_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, INTERVAL, MUTED, Style, entry, logarithmic

_EXTRAPOLATED: Style = {"color": INK, "linestyle": "--", "marker": "o", "markerfacecolor": "white"}
_BESIDE: Style = {"xytext": (4, 4), "textcoords": "offset points", "fontsize": "small"}
_FLOOR, _CEILING = 1e-12, 1e2  # errors of integrators beyond are drawn here


def convergence(request: Request) -> Drawing:
    """One panel per case: the levels, the Richardson value at size zero, the interval.

    All panels have one scale: percent of the value on the finest mesh.
    """
    steps, quantity = request.study.steps, request.quantity
    if len(steps) < 2:
        return nothing("The study refines no reference: its numerical uncertainty is unknown.")
    notes: list[str] = []
    rows = [(case, request.stored.ladder(case.name, quantity)) for case in request.chosen(notes)]
    laddered = [
        (case, row) for case, row in rows if row and any(row[step] is not None for step in steps)
    ]
    if not laddered:
        return nothing(f"No case has a refinement ladder of {title_of(quantity)}.", *notes)
    sheet = Sheet.grid(len(laddered), notes)
    for (case, row), panel in zip(laddered, sheet.panels, strict=True):
        base = _ladder(request, row, panel, sheet)
        title = f"{case.name}: {in_unit(base, quantity)}"
        sheet.name(panel, title, "element size (finest = 1)", "off the finest mesh (%)")
    sheet.legend(
        entry("levels", color=INK, marker="o"),
        entry("Richardson extrapolation", **_EXTRAPOLATED),
        Patch(**INTERVAL, label="numerical uncertainty of the reference"),
    )
    alt = f"{title_of(quantity)} against element size for the ladder {', '.join(steps)}"
    return sheet.finish(alt)


def _ladder(request: Request, row: dict[str, Any], panel: Axes, sheet: Sheet) -> float:
    """Draw a ladder in percent of the value on its finest mesh, which is returned."""
    steps = request.study.steps
    sizes = {label: 2.0**i for i, label in enumerate(reversed(steps))}
    known = {label: row[label] for label in steps if row[label] is not None}
    head, column = {"case": row["case"]}, f"{request.quantity}_SI"
    base = float([*known.values()][-1])

    def off(value: float) -> float:
        return 100.0 * (value - base) / abs(base) if base else 0.0

    x, y = [sizes[label] for label in known], [off(value) for value in known.values()]
    panel.plot(x, y, color=INK, marker="o", zorder=3)
    sheet.record(**head, label=list(known), size=x, **{column: list(known.values())})
    finest, uncertainty, limit = known.get(steps[-1]), row["uncertainty"], row["extrapolated"]
    if uncertainty is not None and finest is not None:
        panel.axhspan(off(finest - uncertainty), off(finest + uncertainty), **INTERVAL, zorder=0)
    if limit is not None and finest is not None:
        ends = [off(finest), off(limit)]
        panel.plot([1.0, 0.0], ends, **_EXTRAPOLATED, markevery=[1], zorder=3)
        sheet.record(**head, label="extrapolated", size=0.0, **{column: limit})
    panel.axvline(0.0, color=MUTED, linewidth=0.6)
    panel.set_xticks([0.0, *sorted(sizes.values())])
    panel.xaxis.set_major_formatter("{x:g}")
    panel.set_xlim(-0.04 * max(sizes.values()), 1.06 * max(sizes.values()))
    sheet.notes.append(f"{row['case']}: {row['note'] or 'no note'}.")
    return base


def meshes(request: Request) -> Drawing:
    """Value over element size, with the interval around the reference.

    The first case with an answer is drawn.
    """
    quantity, sizes = request.quantity, request.option("sizes", {})
    unit, reference = unit_of(quantity).factor, request.study.reference
    for case in request.named():
        values = {label: request.number(case, label, quantity) for label in sizes}
        known = {label: value for label, value in values.items() if value is not None}
        if known:
            break
    else:
        return nothing(f"No mesh has an answer with {title_of(quantity)}.")
    sheet = Sheet.table(1, 1, 3.0)
    panel = sheet.panel
    points = sorted((float(sizes[label]), unit * value) for label, value in known.items())
    panel.plot(*zip(*points, strict=True), color=INK, marker="o", label="uniform meshes")
    for label, value in known.items():
        size = float(sizes[label])
        panel.annotate(label, (size, unit * value), **_BESIDE, color=MUTED)
        sheet.record(case=case.name, label=label, size_m=size, **{f"{quantity}_SI": value})
    band = request.interval(case, quantity)
    if band is None:
        sheet.notes.append(f"The numerical uncertainty of {reference} is unknown.")
    else:
        name = f"{reference}, with its numerical uncertainty"
        panel.axhspan(unit * band[0], unit * band[1], **INTERVAL, zorder=0, label=name)
    panel.set_xlim(0.0, 1.3 * points[-1][0])
    sheet.name(panel, case.name, "element size (m)", axis_label(quantity))
    sheet.legend(*panel.get_legend_handles_labels()[0])
    return sheet.finish(f"{title_of(quantity)} against element size for {', '.join(known)}")


def work_precision(request: Request) -> Drawing:
    """Error against work of integrators: one panel per problem, one line per scheme."""
    timed = bool(request.option("time", False))
    what = "solving, ms" if timed else "evaluations of the forces"
    sheet, panels = request.case_panels()
    for case, panel in panels:
        needed = {"ladder.error", "ladder.evaluations"}
        for label, response in request.answers(case, sheet.absent, needed, "ladder").items():
            error, work = response["ladder.error"].values, response["ladder.evaluations"].values
            known = np.isfinite(error)
            if timed:
                seconds = request.number(case, label, "solve_time")
                if seconds is None:
                    continue
                work = 1e3 * seconds / work[-1] * work
            sheet.record(case=case.name, label=label, **{what: work[known]}, error=error[known])
            shown = np.clip(error[known], _FLOOR, _CEILING)
            panel.plot(work[known], shown, **request.looks[label].curve(linewidth=0.9))
        panel.set_xscale("log")
        panel.set_yscale("log")
        logarithmic(panel.xaxis, lambda value: number(value, 1))
        logarithmic(panel.yaxis, lambda value: f"{value:.0e}".replace("e-0", "e-"))
        sheet.name(panel, case.name, what, "relative error")
    sheet.legend(*(entry(label, **request.looks[label].curve()) for label in request.labels))
    text = f"Errors below {_FLOOR:g} are drawn there: they are round-off; so are those above"
    sheet.notes.append(f"{text} {_CEILING:g}, of steps that are not stable.")
    empty = "No integrator has answered a problem."
    return sheet.finish(f"error against {what}, a panel per problem", empty=empty)
