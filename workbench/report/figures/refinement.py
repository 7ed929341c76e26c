"""Error against refinement, work and cost.

``convergence``, options: `quantity`, `cases`: the ladder of the reference, element size across.
``meshes``, options: `sizes`, label to element size in m; `quantity`, `case`.
``work-precision``, option: `time` (work is the time of solving, not evaluations of the forces).
``cost``, options: `quantity` (a scalar, default the first of the study), `against` (a label).
``chooser``: ways to choose a model over drawn scenarios.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, INTERVAL, MUTED, Look, Style, entry, logarithmic
from workbench.report.page.formatting import (
    axis_label,
    duration,
    in_unit,
    number,
    title_of,
    unit_of,
)
from workbench.study.chooser import CORRECTED, REACH, SURE
from workbench.study.definition import holds_data

_EXTRAPOLATED: Style = {"color": INK, "linestyle": "--", "marker": "o", "markerfacecolor": "white"}
_BESIDE: Style = {"xytext": (4, 4), "textcoords": "offset points", "fontsize": "small"}
_ROUND_OFF, _CEILING = 1e-12, 1e2  # errors of integrators beyond are drawn here
_FLOOR = 1e-4  # smaller deviations are drawn here: they are below what matters
_WAYS = ("o", "s", "D", "^")  # markers of ways to choose
_LEAST = 0.01  # smaller errors are drawn here
_FEW = 12  # cases up to which each has a marker


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
            shown = np.clip(error[known], _ROUND_OFF, _CEILING)
            panel.plot(work[known], shown, **request.looks[label].curve(linewidth=0.9))
        panel.set_xscale("log")
        panel.set_yscale("log")
        logarithmic(panel.xaxis, lambda value: number(value, 1))
        logarithmic(panel.yaxis, lambda value: f"{value:.0e}".replace("e-0", "e-"))
        sheet.name(panel, case.name, what, "relative error")
    sheet.legend(*(entry(label, **request.looks[label].curve()) for label in request.labels))
    text = f"Errors below {_ROUND_OFF:g} are drawn there: they are round-off; so are those above"
    sheet.notes.append(f"{text} {_CEILING:g}, of steps that are not stable.")
    empty = "No integrator has answered a problem."
    return sheet.finish(f"error against {what}, a panel per problem", empty=empty)


def cost(request: Request) -> Drawing:
    """One marker per case and label on logarithmic axes; down and left is better."""
    quantity, against = request.quantity, request.against
    errors = {key: row["error"] for key, row in request.errors(quantity).items()}
    for case in request.cases:  # the relative uncertainty of the reference stands for its error
        ladder = request.stored.ladder(case.name, quantity)
        errors[case.name, against] = None if ladder is None else ladder["relative"]
    sheet = Sheet.table(1, 1, 3.7)
    panel, few, least = sheet.panel, len(request.cases) <= _FEW, np.inf
    for label in request.labels:
        if holds_data(request.study.models[label]):
            continue  # a number that was looked up costs nothing
        look, points = request.looks[label], []
        for case in request.cases:
            seconds = request.number(case, label, "wall_time")
            error = errors.get((case.name, label))
            if request.stored.ok(case.name, label) and seconds and error is not None:
                points.append((seconds, abs(error)))
                sheet.record(case=case.name, label=label, wall_time_s=seconds, error=float(error))
        if not points:
            if label == against:
                sheet.notes.append(f"{label} is not refined: its numerical uncertainty is unknown.")
            elif any(request.stored.expects(case.name, label) for case in request.cases):
                sheet.notes.append(f"{label} has no {title_of(quantity)} to compare.")
            continue
        x, y = np.array(points).T
        least = min(least, y.min())
        if not few:
            panel.plot(x, np.maximum(y, _FLOOR), **look.points(markersize=2.5, alpha=0.35))
            x, y = np.array([np.median(x)]), np.array([np.median(y)])
        panel.plot(x, np.maximum(y, _FLOOR), **look.points())
        name = f"{label} (its numerical uncertainty)" if label == against else label
        sheet.legend(entry(name, **look.points()))
    panel.set_xscale("log")
    panel.set_yscale("log")
    low, high = panel.get_ylim()
    panel.set_ylim(max(0.8 * _FLOOR, 0.4 * low), 2.0 * high)
    panel.margins(x=0.12)
    deviation = f"deviation of the {title_of(quantity)}"
    sheet.name(panel, "", "wall time of one case", f"{deviation}\nfrom {against}")
    logarithmic(panel.xaxis, lambda value: duration(value, 1))
    logarithmic(panel.yaxis, lambda value: f"{100 * value:g} %")
    if not few:
        sheet.notes.append("Small markers are single cases, large ones the medians of a model.")
    if least < _FLOOR:
        floor = f"{100 * _FLOOR:g} %"
        sheet.notes.append(f"Deviations below {floor} are drawn at {floor}.")
    empty = f"No model has both a wall time and an error of {title_of(quantity)}."
    return sheet.finish(f"wall time against {deviation} from {against}", empty=empty)


def choices(request: Request) -> Drawing:
    """Nine of ten errors of the peak lie below the marks; down and left is better."""
    rows = [row for row in request.stored.rows["chooser"] if row["seconds"]]
    if not rows:
        return nothing("No drawn scenario has been judged.")
    sheet = Sheet.table(1, 1, 3.9)
    panel, chosen = sheet.panel, 0
    path = []
    for row in rows:
        way, place = row["way"], (row["seconds"], max(row["reach"], _LEAST))
        look = request.looks.get(way)
        if look is None:
            look, chosen = Look(INK, marker=_WAYS[chosen], size=7.0, order=5.0), chosen + 1
        panel.plot(*place, **look.points())
        sheet.legend(entry(way, **look.points()))
        if way in (request.stored.rows["error-cells"][0]["anchor"], CORRECTED, SURE):
            path.append(place)
        sheet.record(way=way, mean_seconds=row["seconds"], reach=row["reach"], within=row["within"])
    panel.plot(*zip(*path, strict=True), color=INK, linewidth=1.0, zorder=2)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.margins(x=0.12)
    sheet.name(panel, "", "mean time of a case", f"error of the peak that {REACH:.0%} stay below")
    logarithmic(panel.xaxis, lambda value: duration(value, 1))
    logarithmic(panel.yaxis, lambda value: f"{100 * value:g} %")
    sheet.notes.append("The line goes from the anchor to the reference where it is warned of.")
    return sheet.finish("error of the peak against the mean time of a case, by model and choice")
