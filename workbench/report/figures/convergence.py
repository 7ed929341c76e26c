"""Refinement of the reference: value against element size, with extrapolation and interval.

Options: `quantity` (a scalar, default the first of the study), `cases`.
"""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.content.formatting import in_unit, title_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, INTERVAL, MUTED, Style, entry

_WHITE: Style = {"marker": "o", "markerfacecolor": "white"}
_EXTRAPOLATED: Style = {"color": INK, "linestyle": "--", **_WHITE}


def draw(request: Request) -> Drawing:
    """One panel per case: the levels, the Richardson value at size zero, the interval.

    All panels have one scale: percent of the value on the finest mesh.
    """
    steps, quantity = request.study.steps, request.quantity
    if len(steps) < 2:
        return nothing("The study refines no reference: its numerical uncertainty is unknown.")
    said: list[str] = []
    rows = [(case, request.stored.ladder(case.name, quantity)) for case in request.chosen(said)]
    laddered = [
        (case, row) for case, row in rows if row and any(row[step] is not None for step in steps)
    ]
    if not laddered:
        return nothing(f"No case has a refinement ladder of {title_of(quantity)}.", *said)
    sheet = Sheet.grid(len(laddered), said)
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
    case, column = row["case"], f"{request.quantity}_SI"
    base = float([*known.values()][-1])

    def off(value: float) -> float:
        return 100.0 * (value - base) / abs(base) if base else 0.0

    values = [off(value) for value in known.values()]
    panel.plot([sizes[label] for label in known], values, color=INK, marker="o", zorder=3)
    for label, value in known.items():
        sheet.record(case=case, label=label, size=sizes[label], **{column: value})
    finest, uncertainty, limit = known.get(steps[-1]), row["uncertainty"], row["extrapolated"]
    if uncertainty is not None and finest is not None:
        low, high = (off(finest + sign * uncertainty) for sign in (-1.0, 1.0))
        panel.axhspan(low, high, **INTERVAL, zorder=0)
    if limit is not None and finest is not None:
        ends = [off(finest), off(limit)]
        panel.plot([1.0, 0.0], ends, **_EXTRAPOLATED, markevery=[1], zorder=3)
        sheet.record(case=case, label="extrapolated", size=0.0, **{column: limit})
    panel.axvline(0.0, color=MUTED, linewidth=0.6)
    panel.set_xticks([0.0, *sorted(sizes.values())])
    panel.xaxis.set_major_formatter("{x:g}")
    panel.set_xlim(-0.04 * max(sizes.values()), 1.06 * max(sizes.values()))
    sheet.said.append(f"{case}: {row['note'] or 'no note'}.")
    return base
