"""Single values of all labels side by side, and their deviation from the reference.

Options: `quantity` (a scalar, default ``peak_displacement``), `against` (a label; default the
reference), `cases`.
"""

import textwrap

import pandas as pd
from matplotlib.patches import Patch

from workbench.content.formatting import axis_label, title_of, unit_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, first, nothing
from workbench.report.drawing.style import GRID, INK, MUTED, Style, entry
from workbench.study.definition import Case

MOST_CASES = 8
_ROOM = 0.8  # share of a case's slot that its markers take
_BAND: Style = {"color": "#000000", "alpha": 0.13, "linewidth": 0.0, "zorder": 1}


def draw(request: Request) -> Drawing:
    """Values above, relative deviations from the reference with their uncertainty below."""
    quantity, against = str(request.option("quantity", "peak_displacement")), request.against
    notes: list[str] = []
    cases = _known(request, quantity, notes)
    table = _values(request, cases, quantity)
    if table.empty:
        return nothing(f"No model answered these cases with {title_of(quantity)}.")
    sheet = Sheet.table(2, 1, 4.3, notes, sharex=True, height_ratios=[1.15, 1.0])
    (top, bottom), unit = sheet.panels, unit_of(quantity).factor
    labels = [label for label in request.labels if label in set(table["label"])]
    if _bands(request, sheet, cases, quantity):
        sheet.legend(Patch(**_BAND, label=f"numerical uncertainty of {request.study.reference}"))
    for i, label in enumerate(labels):
        rows, look = table[table["label"] == label], request.looks[label].points()
        x = rows.pop("slot") + _ROOM * ((i + 0.5) / len(labels) - 0.5)
        values, deviations = unit * rows.iloc[:, 2:4], 100.0 * rows.iloc[:, 4:6]
        for panel, shown, cap in ((top, values, 0.0), (bottom, deviations, 2.0)):
            y, width = shown.to_numpy(float).T
            panel.errorbar(x, y, yerr=width, fmt="none", ecolor=MUTED, lw=0.9, capsize=cap)
            panel.plot(x, y, **look)
        sheet.legend(entry(label, **look))
    _slots(sheet, [case.name for case in cases])
    for case in cases:  # for the notes on what is absent
        request.answers(case, sheet.absent, (quantity,), title_of(quantity))
    top.set_ylabel(axis_label(quantity))
    low, high = top.get_ylim()
    top.set_ylim(1.08 * min(low, 0.0), 1.08 * max(high, 0.0))
    bottom.set_ylabel(f"deviation from {against} (%)" if len(against) < 16 else "deviation (%)")
    bottom.margins(y=0.12)
    bottom.axhline(0.0, color=INK, linewidth=0.8, zorder=1)
    if table["relative_error"].isna().all():
        words = f"no comparison with {against}"
        bottom.text(0.5, 0.5, words, transform=bottom.transAxes, ha="center")
    sheet.record(table.drop(columns="slot"))
    alt = f"{title_of(quantity)} of {', '.join(labels)}, and deviations from {against}"
    return sheet.finish(alt)


def _known(request: Request, quantity: str, notes: list[str]) -> list[Case]:
    """Cases that have the quantity; answered ones that do not (statics, say) are named."""
    known, without = [], []
    for case in request.cases:
        labels = request.shown(case)
        if any(request.number(case, label, quantity) is not None for label in labels):
            known.append(case)
        elif any(request.stored.ok(case.name, label) for label in labels):
            without.append(case.name)
    if known and without:
        notes.append(f"Without {title_of(quantity)} of any model: {', '.join(without)}.")
    return first(known, MOST_CASES, "cases; the tables hold all of them", notes)


def _values(request: Request, cases: list[Case], quantity: str) -> pd.DataFrame:
    """A row per case and label with a value: the value and its deviation, each with its width."""
    compared = request.errors(quantity)
    names = ["case", "label", f"{quantity}_SI", "data_uncertainty_SI"]
    names += ["relative_error", "uncertainty"]
    rows = []
    for slot, case in enumerate(cases):
        for label in request.labels:
            value = request.number(case, label, quantity)
            if value is not None:
                width = request.stored.data_uncertainty(case.name, label, quantity)
                row = compared.get((case.name, label), {})
                deviation = row.get("error"), row.get("uncertainty")
                rows.append((case.name, label, value, width, *deviation, slot))
    table = pd.DataFrame(rows, columns=[*names, "slot"])
    return table.astype(dict.fromkeys(names[2:], float))


def _bands(request: Request, sheet: Sheet, cases: list[Case], quantity: str) -> bool:
    """Intervals that refinement leaves around the reference, above and below; whether there are."""
    drawn = False
    top, bottom = sheet.panels
    for i, case in enumerate(cases):
        where, row = [i - 0.46, i + 0.46], request.stored.ladder(case.name, quantity)
        band = request.interval(case, quantity)
        if band is not None:
            low, high = (unit_of(quantity).factor * end for end in band)
            top.fill_between(where, low, high, **_BAND)
            drawn = True
        if request.against == request.study.reference and row and row["relative"] is not None:
            share = 100.0 * row["relative"]
            bottom.fill_between(where, -share, share, **_BAND)
    return drawn


def _slots(sheet: Sheet, names: list[str]) -> None:
    """A slot per case, its name wrapped to the width."""
    room = max(10, 84 // len(names))
    words = ["\n".join(textwrap.wrap(name, room)) for name in names]
    sheet.panels[-1].set_xticks(range(len(names)), words)
    for panel in sheet.panels:
        panel.grid(visible=False, axis="x")
        panel.set_xlim(-0.5, len(names) - 0.5)
        panel.tick_params(axis="x", length=0)
        for edge in range(1, len(names)):
            panel.axvline(edge - 0.5, color=GRID, linewidth=0.6, zorder=0)
