"""Cost against error: of each label in each case, and of ways to choose over drawn scenarios.

Options of the first: `quantity` (a scalar, default the first of the study), `against` (a label).
"""

import numpy as np

from workbench.content.formatting import duration, title_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, Look, entry, logarithmic
from workbench.study.chooser import CORRECTED, REACH, SURE
from workbench.study.definition import holds_data

_FLOOR = 1e-4  # smaller deviations are drawn here: they are below what matters
_WAYS = ("o", "s", "D", "^")  # markers of ways to choose
_LEAST = 0.01  # smaller errors are drawn here
_FEW = 12  # cases up to which each has a marker


def draw(request: Request) -> Drawing:
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
