"""Error against refinement, work and cost.

``convergence``, options: `quantity`, `cases`: the ladder of the reference, element size across.
``meshes``, options: `sizes`, label to element size in m; `quantity`, `case`.
``work-precision``, option: `time` (work is the time of solving, not evaluations of the forces).
``cost``, options: `quantity` (a scalar, default the first of the study), `against` (a label).
``chooser``: ways to choose a model over drawn scenarios.

**Second part.** Maps of the errors of each model over two parameters, or over a parameter and a
displacement.

``sweep``: fields over `x` and `y`, small multiples over `facet` (names of case parameters; default
the first three that vary). Options: `rows` (a parameter for the rows of panels when a single model
is shown; default a fourth that varies), `quantity`, `metric`, `against` (default: of several
references the governing one of a case), `limit` (error at which the colours end, default 0.2).
Cases that differ only in further parameters share a field; the worst of them is shown.

``domain-map``: a point per case, coloured by the class of its error. Options: `x`, a case
parameter with numbers; `over`, a case parameter by which the value of `against` is divided for the
other axis, called `y`; `quantity`, `against`.
"""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, first, nothing
from workbench.report.drawing.style import (
    INK,
    INTERVAL,
    MUTED,
    TEXT_WIDTH,
    Look,
    Style,
    entry,
    logarithmic,
)
from workbench.report.page.formatting import (
    MINUS,
    axis_label,
    duration,
    in_unit,
    metric_title,
    number,
    title_of,
    unit_of,
)
from workbench.study.assessor import BEST
from workbench.study.chooser import CORRECTED, REACH, SURE
from workbench.study.definition import Case, holds_data

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
            error, work = (
                response["ladder.error"].to_numpy(),
                response["ladder.evaluations"].to_numpy(),
            )
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
    rows = [row for row in request.stored.records("chooser") if row["seconds"]]
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
        if way in (request.stored.tables["error-cells"]["anchor"].iloc[0], CORRECTED, SURE):
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


_MOST_FACETS, _MOST_MODELS = 6, 9
_HIGHEST = 8.6  # inches
_ROW = 16  # letters of values that stand beside each other below a panel
_CORNER = 0.38, 0.3  # of a field: where the mark of a warning leaves room for the number
_LEAST_FIELD = 0.26, 0.13  # inches of a field, wide and high, in which a number can be read
_COLLAPSE = "#6a3d9a"
_MARKS = {
    "warned": ("outside its domain (warning)", Look(INK, size=3.6).points(markerfacecolor="white")),
    "failed": ("no answer", Look("#b30000", marker="x", size=4.5).points()),
    "collapsed": ("collapse of one side", Look(_COLLAPSE, marker="v", size=4.5).points()),
    "both": (
        "collapse of both sides",
        Look(_COLLAPSE, marker="v", size=4.5).points(markerfacecolor="none"),
    ),
}
_NEAR, _FAR = 0.05, 0.10  # bounds of the classes of error
_CLASSES = {
    f"within {100 * _NEAR:g} %": Look("#009e73", size=3.4),
    f"within {100 * _FAR:g} %": Look("#e69f00", marker="s", size=3.2),
    f"more than {100 * _FAR:g} % too large": Look("#d55e00", marker="^", size=3.6),
    f"more than {100 * _FAR:g} % too small": Look("#0072b2", marker="v", size=3.6),
    "collapse": Look(_COLLAPSE, marker="D", size=3.2),
    "no answer": Look(INK, marker="x", size=3.4),
}


def sweep(request: Request) -> Drawing:
    """Rows of panels are models (or values of a parameter), columns values of the facet."""
    cases = [case for case in request.cases if case.parameters]
    names = dict.fromkeys(name for case in cases for name in case.parameters)
    varying = [name for name in names if len(_values(cases, name)) > 1]
    if len(varying) < 2:
        return nothing("A map needs cases with two parameters that vary.")
    x = str(request.option("x", varying[0]))
    y = str(request.option("y", next(name for name in varying if name != x)))
    further = [name for name in varying if name not in (x, y)]
    facet = str(request.option("facet", further[0] if further else ""))
    models, metric = _models(request, cases), str(request.option("metric", "relative_error"))
    best = BEST if len(request.study.ranked) > 1 else request.against
    against = str(request.option("against", best))
    if not models:
        return nothing("No model of the sweep is held against another.")
    what = f"{metric_title(metric)} of the {title_of(request.quantity)}"
    notes = [f"Colours and numbers: {what} against {against}, in %."]
    further = [name for name in further if name != facet]
    by = str(request.option("rows", further[0] if further else "")) if len(models) == 1 else ""
    values = _values(cases, facet) if facet else [None]
    columns = first(values, _MOST_FACETS, f"values of {facet}", notes)
    rows = _values(cases, by)[:_MOST_FACETS] if by else models
    table = _errors(request, cases, models, metric, against)
    grid = (x, _values(cases, x)), (y, _values(cases, y))
    height = min(_HIGHEST, 0.95 + len(rows) * max(1.35, 0.3 * len(grid[1][1]) + 0.5))
    room = int(14.0 * (height - 0.95) / len(rows))  # characters along a panel's height
    sheet = Sheet.table(len(rows), len(columns), height, notes, sharex=True, sharey=True)
    limit = float(request.option("limit", 0.2))
    wide = (TEXT_WIDTH - 1.3) / len(columns) / len(grid[0][1])
    tall = 0.8 * (height - 0.95) / len(rows) / len(grid[1][1])
    legible = wide >= _LEAST_FIELD[0] and tall >= _LEAST_FIELD[1]
    panels = iter(sheet.panels)
    for i, row in enumerate(rows):
        for j, value in enumerate(columns):
            panel = next(panels)
            here = table[(table[by or "model"] == row) & (not facet or table[facet] == value)]
            image = _fields(panel, here, grid, limit, legible)
            sheet.record(here)
            head = "" if i or not facet else _text(value) if j else f"{facet}: {_text(value)}"
            sheet.name(panel, head, x, "\n".join([_text(row), *textwrap.wrap(y, room)]))
    place: Style = {"extend": "both", "shrink": 0.85, "aspect": 30, "pad": 0.015}
    bar = sheet.canvas.colorbar(image, ax=sheet.panels, **place)
    bar.set_label(metric_title(metric))
    bar.ax.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    bar.outline.set_linewidth(0.4)
    present = (mark for name, mark in _MARKS.items() if table[name].any())
    sheet.legend(*(entry(label, **style) for label, style in present))
    if by:
        sheet.notes.append(f"Model: {models[0]}. Rows of panels: {by}.")
    merged = ", ".join(name for name in further if name != by)
    if merged:
        sheet.notes.append(f"Each field shows the worst of the cases that differ in {merged}.")
    alt = f"maps of the {metric_title(metric)} of {title_of(request.quantity)} over {x} and {y}"
    return sheet.finish(alt)


def _errors(
    request: Request, cases: Sequence[Case], models: Sequence[str], metric: str, against: str
) -> pd.DataFrame:
    """A row per case and model: parameters, error, and which of `_MARKS` there is to see."""
    stored, rows = request.stored, []
    errors = stored.errors(request.quantity, metric, against)
    for case in cases:
        reference = stored.held_against(case.name, against)
        for label in models:
            collapses = sum(stored.collapses(case.name, side) for side in (label, reference))
            answers = sum(stored.ok(case.name, side) for side in (label, reference))
            row = {"case": case.name, "model": label, "against": reference, **case.parameters}
            row["error"] = errors.get((case.name, label), {}).get("error", np.nan)
            warned = bool(stored.cells[case.name, label].outside)
            row |= {"warned": answers == 2 and warned, "failed": answers + collapses < 2}
            row |= {"collapsed": collapses == answers == 1, "both": collapses == 2}
            rows.append(row)
    return pd.DataFrame(rows)


def _fields(panel: Axes, table: pd.DataFrame, grid: Any, limit: float, legible: bool) -> AxesImage:
    """Draw the worst error of every field, its number if `legible`, and marks."""
    (x, xs), (y, ys) = grid
    finite = table[np.isfinite(table["error"])]
    worst = finite.pivot_table("error", y, x, lambda errors: max(errors, key=abs))
    field: Array = np.asarray(worst.reindex(index=ys, columns=xs), dtype=float)
    style: Style = {"origin": "lower", "aspect": "auto", "cmap": "PuOr_r"}
    image = panel.imshow(field, vmin=-limit, vmax=limit, **style)
    panel.set_facecolor("#e8e8e8")
    panel.grid(visible=False)
    panel.spines[:].set_visible(True)
    across, up = table[x].map(xs.index), table[y].map(ys.index)
    for column, (_, mark) in _MARKS.items():
        if table[column].any():
            aside = _CORNER if column == "warned" else (0.0, 0.0)
            panel.plot(across[table[column]] + aside[0], up[table[column]] + aside[1], **mark)
    panel.set_xticks(range(len(xs)), [_text(value) for value in xs])
    panel.set_yticks(range(len(ys)), [_text(value) for value in ys])
    if sum(len(_text(value)) for value in xs) > _ROW:
        panel.tick_params(axis="x", labelrotation=90)
    panel.tick_params(length=0)
    for (row, column), value in np.ndenumerate(field):
        if legible and np.isfinite(value):
            text = "0" if abs(value) < 0.005 else f"{100.0 * value:+.0f}".replace("-", MINUS)
            color = "white" if abs(value) > 0.75 * limit else INK
            panel.text(column, row, text, color=color, fontsize=6.5, ha="center", va="center")
    return image


def _models(request: Request, cases: Sequence[Case]) -> list[str]:
    if request.figure.models:
        return [label for label in request.labels if label != request.against]
    skipped = {request.against, *request.study.ladder}
    return [
        label
        for label in request.labels
        if label not in skipped
        and not holds_data(request.study.models[label])
        and any(request.stored.expects(case.name, label) for case in cases)
    ]


def _values(cases: Sequence[Case], name: str) -> list[Any]:
    """The values of a parameter: numbers in rising order, words as they come."""
    values = list(dict.fromkeys(c.parameters[name] for c in cases if name in c.parameters))
    return sorted(values) if all(isinstance(value, (int, float)) for value in values) else values


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)


def domain_map(request: Request) -> Drawing:
    """A panel per model; both axes are logarithmic."""
    x, y = str(request.option("x", "")), str(request.option("y", "relative displacement"))
    left: list[str] = []
    labels = [label for label in request.labels if label != request.against]
    labels = first(labels, _MOST_MODELS, "models", left)
    sheet = Sheet.grid(len(labels), left, height=2.0, sharex=True)
    errors, names = request.errors(request.quantity), list(_CLASSES)
    for panel, label in zip(sheet.panels, labels, strict=True):
        table = _points(request, label, errors, x)
        error, beyond = table["error"], table["error"].abs() > _FAR
        classes = [error.abs() <= _NEAR, error.abs() <= _FAR, error > _FAR, error < -_FAR]
        table["class"] = np.select([*classes, table["collapsed"]], names[:-1], default=names[-1])
        for (name, warned), part in table.groupby(["class", "warned"]):
            face = {"markerfacecolor": "none"} if warned else {}
            style = _CLASSES[str(name)].points(markeredgewidth=0.8, **face)
            panel.plot(part["x"], part["y"], **style)
        panel.set_xscale("log")
        panel.set_yscale("log")
        if len(table):
            sheet.record(table.assign(model=label))
        inside = int((error.abs() <= _FAR).sum())
        title = f"{label}\n{inside} of {len(table)} within {100 * _FAR:g} %"
        sheet.name(panel, title, x, y)
        if silent := int((beyond & ~table["warned"]).sum()):
            text = f"{label}: {silent} errors beyond {100 * _FAR:g} % carry no warning."
            sheet.notes.append(text)
    for panel in sheet.panels:  # once all points are in: the panels share their axes
        for axis in (panel.xaxis, panel.yaxis):
            logarithmic(axis, "{:g}".format)
    collapses = sum(request.stored.collapses(case.name, request.against) for case in request.cases)
    if collapses:
        text = f"{request.against} collapses in {collapses} cases, which have no place in this map."
        sheet.notes.append(text)
    for name, look in _CLASSES.items():
        sheet.legend(entry(name, **look.points(markeredgewidth=0.8)))
    open_point = Look(INK, size=3.4).points(markerfacecolor="none", markeredgewidth=0.8)
    sheet.legend(entry("open: with a warning", **open_point))
    empty = f"No case has an answer of {request.against} and the parameter {x}."
    return sheet.finish(f"classes of error over {x} and {y}, a panel per model", empty=empty)


def _points(
    request: Request, label: str, errors: dict[tuple[str, str], Any], x: str
) -> pd.DataFrame:
    """A row per case that both sides answer: place on the map, error, whether it was warned."""
    over, stored = str(request.option("over", "")), request.stored
    rows = []
    for case in request.cases:
        value = request.number(case, request.against, request.quantity)
        if value is None or x not in case.parameters:
            continue
        scale = float(case.parameters[over]) if over else 1.0
        error = errors.get((case.name, label), {}).get("error")
        cell = stored.cells.get((case.name, label))
        warned = cell is not None and bool(cell.outside)
        place = float(case.parameters[x]), value / scale
        rows.append((case.name, *place, error, stored.collapses(case.name, label), warned))
    kinds = {"x": float, "y": float, "error": float, "collapsed": bool, "warned": bool}
    return pd.DataFrame(rows, columns=["case", *kinds]).astype(kinds)
