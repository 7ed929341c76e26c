"""Single values of all labels side by side, and their deviation from the reference.

Options: `quantity` (a scalar, default ``peak_displacement``), `against` (a label; default the
reference), `cases`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import axis_label, title_of, unit_of
from workbench.report.figures.drawing import Absences, Drawing, Request, nothing, rows
from workbench.report.figures.drawing import joined as joined_rows
from workbench.report.figures.panels import handle
from workbench.report.figures.style import GRID, INK, MUTED, legend_below, new_figure
from workbench.study.definition import Case

MOST_CASES = 8


def draw(request: Request) -> Drawing:
    """Values above, relative deviations from the reference with their uncertainty below."""
    quantity = str(request.option("quantity", "peak_displacement"))
    against = str(request.option("against", request.study.reference))
    named = request.option("cases", ())
    cases = [case for case in request.cases if not named or case.name in named]
    statements = []
    cases, without = _known(request, cases, quantity)
    if cases and without:
        statements.append(f"Without {title_of(quantity)} of any model: {', '.join(without)}.")
    if len(cases) > MOST_CASES:
        statements.append(
            f"Shown are the first {MOST_CASES} of {len(cases)} cases; the tables hold all of them."
        )
        cases = cases[:MOST_CASES]
    labels = [
        label
        for label in request.labels
        if any(request.stored.number(case.name, label, quantity) is not None for case in cases)
    ]
    if not labels:
        return nothing(f"No model answered these cases with {title_of(quantity)}.")
    canvas = new_figure(4.3)
    top, bottom = canvas.subplots(2, 1, sharex=True, height_ratios=[1.15, 1.0])
    middle, step = 0.5 * (len(labels) - 1), 0.8 / len(labels)
    slots = {label: (i - middle) * step for i, label in enumerate(labels)}
    blocks = _values(request, top, cases, slots, quantity)
    deviations = _deviations(request, bottom, cases, slots, quantity, against)
    statements.extend(_absences(request, cases, quantity))
    top.set_ylabel(axis_label(quantity))
    low, high = top.get_ylim()
    top.set_ylim(1.08 * min(low, 0.0), 1.08 * max(high, 0.0))
    bottom.set_ylabel(f"deviation from {against} (%)" if len(against) < 16 else "deviation (%)")
    bottom.margins(y=0.12)
    bottom.axhline(0.0, color=INK, linewidth=0.8, zorder=1)
    bottom.set_xticks(range(len(cases)), [_wrapped(case.name, len(cases)) for case in cases])
    for panel in (top, bottom):
        panel.grid(visible=False, axis="x")
        panel.set_xlim(-0.5, len(cases) - 0.5)
        panel.tick_params(axis="x", length=0)
        for edge in range(1, len(cases)):
            panel.axvline(edge - 0.5, color=GRID, linewidth=0.6, zorder=0)
    if not deviations:
        bottom.text(
            *(0.5, 0.5), f"no comparison with {against}", transform=bottom.transAxes, ha="center"
        )
    handles = [handle(label, request.looks[label], curve=False) for label in labels]
    legend_below(canvas, handles)
    alt = f"{title_of(quantity)} of {', '.join(labels)}, and deviations from {against}"
    data = joined_rows(blocks)
    if deviations:
        data = data.merge(joined_rows(deviations), on=["case", "label"], how="left")
    return Drawing(canvas, data, tuple(statements), alt)


def _known(request: Request, cases: list[Case], quantity: str) -> tuple[list[Case], list[str]]:
    """Cases that have the quantity, and names of answered ones that do not (statics, say)."""
    known, without = [], []
    for case in cases:
        labels = request.shown(case)
        if any(request.stored.number(case.name, label, quantity) is not None for label in labels):
            known.append(case)
        elif any(request.stored.ok(case.name, label) for label in labels):
            without.append(case.name)
    return known, without


def _values(
    request: Request, panel: Axes, cases: list[Case], slots: dict[str, float], quantity: str
) -> list[Any]:
    unit, blocks = unit_of(quantity).factor, []
    for i, case in enumerate(cases):
        _band(request, panel, case, i, quantity)
        for label, offset in slots.items():
            value = request.stored.number(case.name, label, quantity)
            if value is None:
                continue
            width = request.stored.data_uncertainty(case.name, label, quantity)
            if width is not None:
                panel.errorbar(
                    *(i + offset, value * unit), yerr=width * unit, fmt="none", ecolor=MUTED, lw=0.9
                )
            panel.plot([i + offset], [value * unit], **request.looks[label].points())
            entry = {
                "case": case.name,
                "label": label,
                f"{quantity}_SI": value,
                "data_uncertainty_SI": np.nan if width is None else width,
            }
            blocks.append(rows(entry, 1))
    return blocks


def _band(request: Request, panel: Axes, case: Case, i: int, quantity: str) -> None:
    """Interval that the refinement ladder leaves around the reference."""
    ladder = request.stored.ladder(case.name, quantity)
    value = request.stored.number(case.name, request.study.reference, quantity)
    if ladder is None or value is None or ladder["uncertainty"] is None:
        return
    unit, width = unit_of(quantity).factor, ladder["uncertainty"]
    panel.fill_between(
        *([i - 0.46, i + 0.46], (value - width) * unit, (value + width) * unit),
        color="#000000",
        alpha=0.13,
        linewidth=0.0,
        zorder=1,
    )


def _deviations(
    request: Request,
    panel: Axes,
    cases: list[Case],
    slots: dict[str, float],
    quantity: str,
    against: str,
) -> list[Any]:
    table = request.stored.errors(quantity, "relative_error", against)
    known = {(row["case"], row["model"]): row for row in table.to_dict("records")}
    blocks = []
    for i, case in enumerate(cases):
        ladder = request.stored.ladder(case.name, quantity)
        if against == request.study.reference and ladder and ladder["relative"] is not None:
            share = 100.0 * ladder["relative"]
            panel.fill_between(
                *([i - 0.46, i + 0.46], -share, share), color="#000000", alpha=0.13, linewidth=0.0
            )
        for label, offset in slots.items():
            row = known.get((case.name, label))
            if row is None:
                continue
            error, width = 100.0 * row["error"], 100.0 * row["uncertainty"]
            if np.isfinite(width):
                panel.errorbar(
                    i + offset, error, yerr=width, fmt="none", ecolor=MUTED, lw=0.9, capsize=2.0
                )
            panel.plot([i + offset], [error], **request.looks[label].points())
            entry = {
                "case": case.name,
                "label": label,
                "relative_error": row["error"],
                "uncertainty": row["uncertainty"],
            }
            blocks.append(rows(entry, 1))
    return blocks


def _absences(request: Request, cases: list[Case], quantity: str) -> list[str]:
    absent = Absences()
    for label in request.labels:
        for case in cases:
            if not request.stored.expects(case.name, label):
                continue
            if not request.stored.ok(case.name, label):
                absent.no_answer(label, case.name)
            elif request.stored.number(case.name, label, quantity) is None:
                absent.without(title_of(quantity), label)
    return absent.sentences()


def _wrapped(name: str, count: int) -> str:
    """A case name on several lines where the slots are narrow."""
    import textwrap

    return "\n".join(textwrap.wrap(name, max(10, 84 // count)))
