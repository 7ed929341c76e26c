"""Error against cost over drawn scenarios: each model by itself, and ways to choose among them."""

from workbench.content.formatting import duration
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, Look, entry, logarithmic
from workbench.study.chooser import CORRECTED, REACH, SURE

_WAYS = ("o", "s", "D", "^")  # markers of ways to choose
_FLOOR = 0.01  # smaller errors are drawn here


def draw(request: Request) -> Drawing:
    """Nine of ten errors of the peak lie below the marks; down and left is better."""
    rows = [row for row in request.stored.rows["chooser"] if row["seconds"]]
    if not rows:
        return nothing("No drawn scenario has been judged.")
    sheet = Sheet.table(1, 1, 3.9)
    panel, chosen = sheet.panel, 0
    path = []
    for row in rows:
        way, place = row["way"], (row["seconds"], max(row["reach"], _FLOOR))
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
