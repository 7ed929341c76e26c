"""Measured against predicted, one panel per model, with the half-widths of both sides.

Options: `quantity` (a scalar, default the first of the study). Made numbers are named so.
"""

import json

import numpy as np
import pandas as pd

from workbench.content.formatting import number, title_of, unit_of
from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import MUTED, WARNING, entry, framed
from workbench.responses.uncertainty import uncertainty_of

_MARK = "SYNTHETIC"


def draw(request: Request) -> Drawing:
    """Measured values up, predicted values across, with bias and coverage of the model."""
    unit = unit_of(request.quantity)
    tables = {label: _rows(request, label) for label in request.labels if label != request.against}
    tables = {label: table for label, table in tables.items() if not table.empty}
    if not tables:
        return nothing(f"No model answered a test with {title_of(request.quantity)}.")
    everything = pd.concat(list(tables.values()))
    looks = studs.campaign_looks(everything["campaign"], filled=True)
    ends = (
        everything[["test", "prediction"]].to_numpy()
        + everything[["test_width", "prediction_width"]].to_numpy()
    )
    top = 1.06 * unit.factor * float(np.nanmax(ends))
    sheet = Sheet.grid(len(tables), height=2.45, sharex=True)
    for panel, (label, table) in zip(sheet.panels, tables.items(), strict=True):
        studs.draw_diagonal(panel, top)
        for campaign, rows in table.groupby("campaign", sort=False):
            values = (
                unit.factor * rows[name]
                for name in ("prediction", "test", "prediction_width", "test_width")
            )
            x, y, wide, high = values
            panel.errorbar(x, y, yerr=high, xerr=wide, fmt="none", ecolor=MUTED, lw=0.8)
            panel.plot(x, y, **looks[str(campaign)].points())
        sheet.name(panel, label, f"predicted ({unit.text})", f"measured ({unit.text})")
        note, text = _summary(request, label)
        panel.text(0.96, 0.05, note, transform=panel.transAxes, ha="right", fontsize=7.0)
        if request.stored.synthetic:
            framed(panel, 0.04, 0.86, _MARK, WARNING, fontsize=7.0)
        sheet.notes.append(text)
        sheet.record(table)
    for case in request.cases:  # for the notes on what is absent
        request.answers(case, sheet.absent)
    sheet.legend(*(entry(name, **look.points()) for name, look in looks.items()))
    sheet.legend(*studs.diagonal_entries("measured = predicted"))
    made = f"{_MARK}, " if request.stored.synthetic else ""
    return sheet.finish(f"{made}measured against predicted {title_of(request.quantity)}")


def _rows(request: Request, label: str) -> pd.DataFrame:
    """A row per test that the model answers: both values and half-widths ."""
    rows = []
    for case in request.cases:
        values = [request.number(case, side, request.quantity) for side in (request.against, label)]
        test = request.stored.response(case.name, request.against)
        answer = request.stored.response(case.name, label)
        if test is None or answer is None or None in values:
            continue
        test_width = request.stored.data_uncertainty(case.name, request.against, request.quantity)
        prediction_width = uncertainty_of(answer, request.quantity)
        campaign = json.loads(test.attrs.get("data", "{}")).get("campaign", "all")
        rows.append(
            (label, case.name, campaign, *values, test_width or 0.0, prediction_width or 0.0)
        )
    columns = ["label", "case", "campaign", "test", "prediction", "test_width", "prediction_width"]
    return pd.DataFrame(rows, columns=columns)


def _summary(request: Request, label: str) -> tuple[str, str]:
    """Return the note in the panel and the sentence below the figure."""
    wanted = (label, request.against, request.quantity)
    rows = request.stored.rows["validation"]
    matching = (r for r in rows if (r["model"], r["against"], r["quantity"]) == wanted)
    row = next(matching, None)
    if row is None or row["bias"] is None:
        return "", f"{label}: no bias over tests."
    ends = row["low"], row["high"]
    span = "" if None in ends else f" ({number(ends[0], 3)} to {number(ends[1], 3)})"
    held = f"{row['covered']:.0f} of {row['counted']:.0f}"
    text = f"{label}: median of test over prediction {number(row['bias'], 3)}{span}, "
    made = f" {_MARK}: no test." if row["synthetic"] else ""
    return (
        f"median {number(row['bias'], 3)}\n{held} inside",
        f"{text}{held} inside the stated interval.{made}",
    )
