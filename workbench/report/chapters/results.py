"""Figures and tables of numbers."""

from __future__ import annotations

from workbench.assessment import METRICS, Scope
from workbench.content.formatting import (
    interval,
    metric_title,
    number,
    percent,
    title_of,
    unit_of,
)
from workbench.content.tree import Block, Cell, Column, Paragraph, Picture, Section, Table
from workbench.report.stored import Stored
from workbench.study.definition import Study

_PRINTED = 40
_ONE_LINE = 4  # columns up to which value and deviation share a line
_WIDEST = 6  # cases side by side


def pictures(drawn: dict[str, Picture], keys: list[str]) -> Section:
    """The figures of the study, each under its title."""
    sections = tuple(Section(f"figure-{key}", drawn[key].title, (drawn[key],)) for key in keys)
    return Section("results", "Results", sections)


def numbers(study: Study, stored: Stored) -> Section:
    """Values and deviations of every quantity, curve and history metrics, bias and scatter."""
    blocks: list[Block] = []
    silent = []
    for quantity in study.quantities:
        table = _values(study, stored, quantity)
        if table is None:
            silent.append(title_of(quantity))
        else:
            blocks.append(table)
    blocks.extend(_shapes(study, stored))
    bias = _bias(stored)
    if bias is not None:
        blocks.append(bias)
    if silent:
        blocks.append(Paragraph(f"No model answered with: {', '.join(silent)}."))
    return Section("numbers", "Numbers", tuple(blocks))


def _values(study: Study, stored: Stored, quantity: str) -> Table | None:
    labels = [
        label
        for label in study.models
        if any(stored.number(c.name, label, quantity) is not None for c in study.cases)
    ]
    cases = [
        case.name
        for case in study.cases
        if any(stored.number(case.name, label, quantity) is not None for label in labels)
    ]
    if not labels:
        return None
    errors = {
        (row["case"], row["model"]): float(row["error"])
        for row in stored.errors(quantity, "relative_error", study.reference).to_dict("records")
    }

    beside = len(cases) if len(cases) <= _WIDEST else len(labels)
    gap = "\n" if beside > _ONE_LINE else "\u2002"

    def cell(case: str, label: str) -> Cell:
        value = stored.number(case, label, quantity)
        if value is None:
            return Cell("–", tone="muted")
        text = number(value * unit_of(quantity).factor)
        error = errors.get((case, label))
        if error is not None and label != study.reference:
            text += f"{gap}{percent(error)}"
        return Cell(text, value)

    unit = unit_of(quantity).text
    caption = f"{title_of(quantity).capitalize()}{f' in {unit}' if unit else ''}"
    caption += f", and deviation from {study.reference}."
    if len(cases) <= _WIDEST:
        columns = (Column("model", width=2.0), *(Column(name, True, 1.4) for name in cases))
        rows = tuple((Cell(label), *(cell(case, label) for case in cases)) for label in labels)
    else:
        columns = (Column("case", width=2.4), *(Column(label, True, 1.3) for label in labels))
        rows = tuple((Cell(case), *(cell(case, label) for label in labels)) for case in cases)
    return Table(f"values-{quantity}", caption, columns, rows, _PRINTED)


def _shapes(study: Study, stored: Stored) -> list[Block]:
    """Metrics of histories and curves against the reference."""
    table = stored.tables["comparisons"]
    table = table[table["against"] == study.reference]
    blocks: list[Block] = []
    for scope, word in ((Scope.HISTORY, "Histories"), (Scope.CURVE, "Curves")):
        metrics = [name for name, metric in METRICS.items() if metric.scope is scope]
        found = table[table["metric"].isin(metrics)]
        if found.empty:
            continue
        rows = []
        for (case, model, quantity), group in found.groupby(
            ["case", "model", "quantity"], sort=False
        ):
            by_metric = {row["metric"]: row for row in group.to_dict("records")}
            cells = [Cell(str(case)), Cell(str(model)), Cell(title_of(str(quantity)))]
            for metric in metrics:
                row = by_metric.get(metric)
                if row is None:
                    cells.append(Cell("–", tone="muted"))
                    continue
                text = interval(metric, str(quantity), row["error"], row["uncertainty"])
                cells.append(Cell(text.replace(" (uncertainty unknown)", ""), row["error"]))
            rows.append(tuple(cells))
        columns = (
            Column("case", width=1.6),
            Column("model", width=1.7),
            Column("quantity", width=1.3),
            *(Column(metric_title(metric), True, 1.35) for metric in metrics),
        )
        cites = " ".join(f"[@{key}]" for key in dict.fromkeys(METRICS[m].citation for m in metrics))
        meanings = "; ".join(f"{METRICS[m].title} = {METRICS[m].meaning}" for m in metrics)
        caption = f"{word} against {study.reference} {cites}: {meanings}."
        blocks.append(Table(f"shapes-{scope.value}", caption, columns, tuple(rows), _PRINTED))
    return blocks


def _bias(stored: Stored) -> Table | None:
    """Bias and scatter over all cases, if the assessment has written them."""
    table = stored.tables.get("bias")
    if table is None or table.empty:
        return None
    rows = []
    for row in table.to_dict("records"):
        span = f"{number(row['low'], 3)} to {number(row['high'], 3)}"
        rows.append(
            (
                Cell(str(row["model"])),
                Cell(str(row["against"])),
                Cell(title_of(str(row["quantity"]))),
                Cell(str(int(row["count"])), row["count"]),
                Cell(number(row["bias"], 4), row["bias"]),
                Cell(span, row["low"]),
                Cell(percent(row["model_scatter"], signed=False), row["model_scatter"]),
            )
        )
    columns = (
        Column("model", width=1.8),
        Column("against", width=1.8),
        Column("quantity", width=1.8),
        Column("cases", True, 0.7),
        Column("bias", True, 0.9),
        Column("95 % interval", True, 1.5),
        Column("scatter", True, 0.9),
    )
    caption = (
        "Bias (expected ratio of model to what it is held against) and relative scatter over all "
        "cases that both answered [@fds-validation]."
    )
    return Table("bias", caption, columns, tuple(rows), _PRINTED)
