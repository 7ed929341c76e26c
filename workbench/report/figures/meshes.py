"""Answers of one model on several meshes against the size of their elements.

Options: `sizes`, label to element size in m; `quantity` (a scalar, default the first of the
study); `case` (default the first with an answer). The band is the interval around the reference.
"""

from __future__ import annotations

from typing import Any

from workbench.content.formatting import axis_label, title_of, unit_of
from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.style import INK, MUTED, legend_below, new_figure

_BAND = "#56b4e9"


def draw(request: Request) -> Drawing:
    """Value over element size, with the interval that the reference leaves at size zero."""
    quantity = str(request.option("quantity", request.study.quantities[0]))
    named = request.option("case", "")
    unit = unit_of(quantity).factor
    for case in request.cases:
        if named and case.name != named:
            continue
        known: dict[str, tuple[float, float]] = {}
        for label, size in request.option("sizes", {}).items():
            value = request.stored.number(case.name, label, quantity)
            if value is not None:
                known[label] = float(size), value
        if known:
            break
    else:
        return nothing(f"No mesh has an answer with {title_of(quantity)}.")
    canvas = new_figure(3.0)
    panel = canvas.subplots()
    blocks: list[Any] = []
    points = sorted(known.values())
    panel.plot(
        [size for size, _ in points],
        [value * unit for _, value in points],
        color=INK,
        marker="o",
        label="uniform meshes",
    )
    for label, (size, value) in known.items():
        panel.annotate(
            label,
            (size, value * unit),
            xytext=(4, 4),
            textcoords="offset points",
            fontsize="small",
            color=MUTED,
        )
        entry = {"case": case.name, "label": label, "size_m": size, f"{quantity}_SI": value}
        blocks.append(rows(entry, 1))
    statements: list[str] = []
    reference = request.study.reference
    value = request.stored.number(case.name, reference, quantity)
    row = request.stored.ladder(case.name, quantity)
    if value is not None and row is not None and row["uncertainty"] is not None:
        width = row["uncertainty"]
        panel.axhspan(
            *((value - width) * unit, (value + width) * unit),
            color=_BAND,
            alpha=0.35,
            linewidth=0.0,
            zorder=0,
            label=f"{reference}, with its uncertainty",
        )
    else:
        statements.append(f"The uncertainty of {reference} is unknown.")
    panel.set_xlim(0.0, 1.3 * points[-1][0])
    panel.set_xlabel("element size (m)")
    panel.set_ylabel(axis_label(quantity))
    panel.set_title(case.name, loc="left")
    legend_below(canvas, panel.get_legend_handles_labels()[0])
    alt = f"{title_of(quantity)} against element size for {', '.join(known)}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)
