"""Refinement of the reference: value against element size, with extrapolation and interval.

Options: `quantity` (a scalar, default the first of the study), `cases`.
"""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from workbench.content.formatting import axis_label, title_of, unit_of
from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.panels import chosen_cases, name_axes, panel_grid
from workbench.report.figures.style import INK, MUTED, legend_below
from workbench.study.definition import Case

_BAND = "#56b4e9"


def draw(request: Request) -> Drawing:
    """One panel per case: the levels, the Richardson value at size zero, the interval."""
    steps = request.study.steps
    if len(steps) < 2:
        return nothing("The study refines no reference: its numerical uncertainty is unknown.")
    quantity = str(request.option("quantity", request.study.quantities[0]))
    cases, statements = chosen_cases(request)
    laddered = [case for case in cases if _levels(request, case, quantity)]
    if not laddered:
        return nothing(f"No case has a refinement ladder of {title_of(quantity)}.", *statements)
    canvas, axes = panel_grid(len(laddered), share_y=False)
    blocks: list[Any] = []
    for i, (case, panel) in enumerate(zip(laddered, axes, strict=True)):
        note = _panel(request, case, panel, quantity, blocks)
        statements.append(f"{case.name}: {note}.")
        panel.set_title(case.name, loc="left")
        size = "element size (finest = 1)"
        name_axes(panel, i, len(laddered), size, axis_label(quantity))
    if not blocks:
        return nothing(*statements)
    handles = [
        Line2D([], [], color=INK, marker="o", label="levels"),
        Line2D(
            *([], []),
            color=INK,
            marker="o",
            markerfacecolor="white",
            linestyle="--",
            label="Richardson extrapolation",
        ),
        Patch(color=_BAND, alpha=0.35, linewidth=0, label="interval around the reference"),
    ]
    legend_below(canvas, handles)
    alt = f"{title_of(quantity)} against element size for the ladder {', '.join(steps)}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _levels(request: Request, case: Case, quantity: str) -> list[str]:
    """Levels of the ladder that know the quantity in a case."""
    row = request.stored.ladder(case.name, quantity) or {}
    return [label for label in request.study.steps if row.get(label) is not None]


def _panel(request: Request, case: Case, panel: Axes, quantity: str, blocks: list[Any]) -> str:
    row = request.stored.ladder(case.name, quantity)
    assert row is not None
    unit, steps = unit_of(quantity).factor, request.study.steps
    sizes = {label: 2.0 ** (len(steps) - 1 - i) for i, label in enumerate(steps)}
    known = {label: row[label] for label in _levels(request, case, quantity)}
    values = {label: value * unit for label, value in known.items()}
    panel.plot(
        [sizes[label] for label in known], list(values.values()), color=INK, marker="o", zorder=3
    )
    for label, value in known.items():
        block = {"case": case.name, "label": label, "size": sizes[label], f"{quantity}_SI": value}
        blocks.append(rows(block, 1))
    finest, uncertainty, limit = steps[-1], row["uncertainty"], row["extrapolated"]
    if uncertainty is not None and finest in values:
        low, high = values[finest] - uncertainty * unit, values[finest] + uncertainty * unit
        panel.axhspan(low, high, color=_BAND, alpha=0.35, linewidth=0.0, zorder=0)
    if limit is not None and finest in values:
        panel.plot(
            *([sizes[finest], 0.0], [values[finest], limit * unit]),
            color=INK,
            linestyle="--",
            marker="o",
            markevery=[1],
            markerfacecolor="white",
            zorder=3,
        )
        block = {"case": case.name, "label": "extrapolated", "size": 0.0, f"{quantity}_SI": limit}
        blocks.append(rows(block, 1))
    panel.axvline(0.0, color=MUTED, linewidth=0.6)
    panel.set_xticks([0.0, *sorted(sizes.values())])
    panel.xaxis.set_major_formatter("{x:g}")
    panel.set_xlim(-0.04 * max(sizes.values()), 1.06 * max(sizes.values()))
    panel.ticklabel_format(axis="y", useOffset=False)
    return str(row["note"] or "no note")
