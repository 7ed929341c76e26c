"""Error budgets of one case: bars per term and their sums, one panel per model, same axes.

Options: `case` (default the first with a budget), `quantity` (default ``peak_displacement``). Of
the forms of a budget the first is drawn: with the strain rate of the steel.
"""

from typing import Any

from matplotlib.axes import Axes

from workbench.assessment.budget import COVERAGE, PEAK, SUMS
from workbench.content.formatting import in_unit, title_of
from workbench.report.chapters.budgets import change, scale
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, MUTED, PALETTE, Style

_KEPT = ("case", "label", "form", "quantity", "term", "shift", "low", "high")
_ROOM = 0.45  # of the axis, to the right of all bars, for the numbers
_AT_THE_EDGE: Style = {
    **{"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "ha": "right"},
    **{"va": "center", "fontsize": "small", "color": INK},
}


def draw(request: Request) -> Drawing:
    """Bars of every source of error, as changes of the answer."""
    quantity = str(request.option("quantity", PEAK))
    panels: dict[str, list[dict[str, Any]]] = {}
    for row in request.stored.rows["budget"]:
        named = request.option("case", row["case"])
        if row["quantity"] == quantity and row["case"] == named and row["label"] in request.labels:
            rows = panels.setdefault(row["label"], [])
            if not rows or rows[0]["form"] == row["form"]:
                rows.append(row)
    if not panels:
        return nothing("No answer whose errors are budgeted has been run.")
    height = sum(0.2 * len(rows) + 0.35 for rows in panels.values()) + 0.35
    sheet = Sheet.table(len(panels), 1, height, sharex=True)
    low, high = scale([row for rows in panels.values() for row in rows])
    for (label, rows), panel in zip(panels.items(), sheet.panels, strict=True):
        _bars(panel, rows, high)
        panel.set_xlim(100.0 * (low - 0.04), 100.0 * (high + _ROOM * (high - low)))
        value = in_unit(rows[0]["value"], quantity)
        sheet.name(panel, f"{label}: {value} {rows[0]['form']}", "", "")
        for row in rows:
            sheet.record(**{name: row[name] for name in _KEPT}, value_SI=row["value"])
    sheet.panels[-1].set_xlabel(
        f"change of the {title_of(quantity)} (%), {100 * COVERAGE:g} % intervals"
    )
    return sheet.finish(f"error budgets of the {title_of(quantity)} of {', '.join(panels)}")


def _bars(panel: Axes, rows: list[dict[str, Any]], most: float) -> None:
    """The bars of a model from the first term down, each with its numbers."""
    for place, row in enumerate(rows):
        summed = row["term"] in SUMS
        if row["low"] is not None:
            left, right = 100.0 * row["low"], 100.0 * min(row["high"], most)
            color = PALETTE[0] if summed else MUTED
            panel.barh(place, right - left, left=left, height=0.62, color=color, zorder=2)
            if row["shift"]:
                at = 100.0 * row["shift"]
                panel.plot([at, at], [place - 0.31, place + 0.31], color="white", zorder=3)
        numbers = panel.annotate(change(row), (1.0, place), (-3, 0), **_AT_THE_EDGE)
        numbers.set_in_layout(False)  # they lie inside, and would push the labels off the page
    panel.set_yticks(range(len(rows)), [row["term"] for row in rows])
    panel.set_ylim(len(rows) - 0.4, -0.6)
    panel.axvline(0.0, color=INK, linewidth=0.8, zorder=4)
    panel.axhline(sum(row["term"] not in SUMS for row in rows) - 0.5, color=MUTED, linewidth=0.6)
    panel.grid(visible=False, axis="y")
    panel.tick_params(axis="y", length=0)
