"""Figures and tables of numbers, and what the answers cost."""

from collections.abc import Iterable, Iterator
from functools import partial
from math import nan
from statistics import median
from typing import Any, NamedTuple

from workbench.assessment import METRICS, Scope
from workbench.content.formatting import (
    count,
    duration,
    in_unit,
    interval,
    metric_title,
    share,
    span_cell,
    title_of,
    unit_of,
    valued,
)
from workbench.content.tree import ABSENT, Block, Cell, Column, Paragraph, Section, Table
from workbench.report.stored import BEST, Stored
from workbench.responses.uncertainty import sampled_interval
from workbench.study.assess import width_of
from workbench.study.definition import Study, holds_data

_PRINTED = 40
_ONE_LINE = 3  # columns up to which value and deviation share a line
_WIDEST = 6  # cases side by side


def numbers(study: Study, stored: Stored) -> Section:
    """Values and deviations of every quantity, curve and history metrics, bias and scatter."""
    tables = {quantity: _values(study, stored, quantity) for quantity in study.quantities}
    silent = [title_of(quantity) for quantity, table in tables.items() if table is None]
    blocks: list[Block] = [table for table in tables.values() if table is not None]
    blocks.extend(_shapes(study, stored))
    blocks.extend(_bias(stored))
    if silent:
        blocks.append(Paragraph(f"No model answered with: {', '.join(silent)}."))
    return Section("numbers", "Numbers", tuple(blocks))


def _values(study: Study, stored: Stored, quantity: str) -> Table | None:
    values = stored.values(quantity)
    if not values:
        return None
    cases = list(dict.fromkeys(case for case, _ in values))
    labels = [label for label in study.models if any(label == own for _, own in values)]
    several = len(study.ranked) > 1
    errors = stored.errors(quantity, "relative_error", BEST if several else study.reference)
    few = len(cases) <= _WIDEST
    gap = "\n" if len(cases if few else labels) > _ONE_LINE else "\u2002"
    unit = unit_of(quantity)

    def cell(case: str, label: str) -> Cell:
        if (case, label) not in values:
            return Cell("collapse") if stored.collapses(case, label) else ABSENT
        width = stored.number(case, label, width_of(quantity)) or 0.0
        text = in_unit(values[case, label], quantity, width=width, named=False)
        if (case, label) in errors:
            row = errors[case, label]
            ends = row.get("low"), row.get("high")
            if None not in ends:
                text = _sampled(stored, case, label, quantity)
            said = interval("relative_error", quantity, row["error"], row["uncertainty"], *ends)
            text += f"{gap}{said.replace(' (uncertainty unknown)', '')}"
        return Cell(text, values[case, label])

    shown = f"{title_of(quantity).capitalize()}{f' in {unit.text}' if unit.text else ''}"
    what = "the reference that counts in a case, which has none" if several else study.reference
    width = "its numerical uncertainty or that of the data"
    caption = f"{shown}, with {width}, and deviation from {what}."
    rows, columns = labels, [Column("model", width=2.0, of=str)]
    if few:
        columns += (Column(case, True, 1.4, partial(cell, case)) for case in cases)
    else:
        rows, columns = cases, [Column("case", width=2.4, of=str)]
        columns += (Column(label, True, 1.3, partial(cell, label=label)) for label in labels)
    return Table.of(f"values-{quantity}", caption, columns, rows, _PRINTED)


def _sampled(stored: Stored, case: str, label: str, quantity: str) -> str:
    """A value with its interval over tests."""
    response = stored.response(case, label)
    ends = None if response is None else sampled_interval(response, quantity)
    values = (stored.number(case, label, quantity), *(ends or ()))
    value, *known = (in_unit(each, quantity, named=False) for each in values)
    return f"{value} ({' to '.join(known)})" if known else value


def _shapes(study: Study, stored: Stored) -> Iterator[Table]:
    """Metrics of histories and curves against the reference."""
    for scope, word in ((Scope.HISTORY, "Histories"), (Scope.CURVE, "Curves")):
        metrics = [name for name, metric in METRICS.items() if metric.scope is scope]
        found: dict[tuple[str, str, str], dict[str, dict[str, Any]]] = {}
        for row in stored.rows["comparisons"]:
            if row["against"] == study.reference and row["metric"] in metrics:
                key = row["case"], row["model"], row["quantity"]
                found.setdefault(key, {})[row["metric"]] = row
        if not found:
            continue
        columns = (
            Column("case", width=1.6, of=lambda pair: pair[0][0]),
            Column("model", width=1.7, of=lambda pair: pair[0][1]),
            Column("quantity", width=1.3, of=lambda pair: title_of(pair[0][2])),
            *(Column(metric_title(name), True, 1.35, partial(_of, name)) for name in metrics),
        )
        cites = " ".join(f"[@{key}]" for key in dict.fromkeys(METRICS[m].citation for m in metrics))
        meanings = "; ".join(f"{METRICS[m].title} = {METRICS[m].meaning}" for m in metrics)
        caption = f"{word} against {study.reference} {cites}: {meanings}."
        yield Table.of(f"shapes-{scope.value}", caption, columns, found.items(), _PRINTED)


def _of(metric: str, pair: tuple[Any, dict[str, dict[str, Any]]]) -> Cell:
    """The cell of a metric in the row of a case, model and quantity."""
    row = pair[1].get(metric)
    if row is None:
        return ABSENT
    ends = row.get("low"), row.get("high")
    text = interval(metric, row["quantity"], row["error"], row["uncertainty"], *ends)
    return Cell(text.replace(" (uncertainty unknown)", ""), row["error"])


def _bias(stored: Stored) -> Iterator[Table]:
    """Bias and scatter over all cases, where there are enough of them and no matrix says more."""
    rows = [] if stored.rows["matrix"] else stored.rows["bias"]
    columns = (
        Column("model", width=1.8, of="model"),
        Column("against", width=1.8, of="against"),
        Column("quantity", width=1.8, of=lambda row: title_of(row["quantity"])),
        Column("cases", True, 0.7, "count"),
        Column("bias", True, 0.9, lambda row: valued(row["bias"])),
        Column("95 % interval", True, 1.5, span_cell),
        Column("scatter", True, 0.9, lambda row: share(row["model_scatter"])),
    )
    caption = (
        "Bias (expected ratio of model to what it is held against) and relative scatter over all "
        "cases that both answered with a number: none where one side collapses [@fds-validation]."
    )
    if rows:
        yield Table.of("bias", caption, columns, rows, _PRINTED)


class _Times(NamedTuple):
    """Wall times of a label in one kind of scenario, s: whole answers, and solving alone."""

    label: str
    kind: str
    whole: list[float]
    solving: list[float]


_COLUMNS = (
    Column("model", width=2.0, of="label"),
    Column("scenario", width=1.6, of="kind"),
    Column("cases", True, 0.7, lambda times: len(times.whole)),
    Column("fastest", True, 1.0, lambda times: valued(min(times.whole), duration)),
    Column("median", True, 1.0, lambda times: valued(median(times.whole), duration)),
    Column("slowest", True, 1.0, lambda times: valued(max(times.whole), duration)),
    Column("solving alone", True, 1.2, lambda t: valued(median(t.solving or [nan]), duration)),
)


def cost(study: Study, stored: Stored, figures: Iterable[Block]) -> Section:
    """Wall times per model and the figures that set them against errors."""
    rows = list(_times(study, stored))
    caption = (
        "Wall time of one answer on one core, after compilation: the whole response with its "
        "histories, and where the model measures it the median of solving the equations alone."
    )
    text = (
        "Wall times depend on the machine and on what else ran on it: "
        f"{count(len(stored.provenance), 'kind', 'kinds')} of machine and software, listed under "
        "provenance, answered the cells of this report."
    )
    table: Block = Table.of("cost-table", caption, _COLUMNS, rows)
    if not rows:
        table = Paragraph("No model that computes has answered yet.")
    return Section("cost", "Cost", (table, *figures, Paragraph(text)))


def _times(study: Study, stored: Stored) -> Iterator[_Times]:
    times = stored.values("wall_time"), stored.values("solve_time")
    for label, model in study.models.items():
        for kind in dict.fromkeys(case.scenario.KIND for case in study.cases):
            own = [
                (case.name, label)
                for case in study.cases
                if kind == case.scenario.KIND and stored.ok(case.name, label)
            ]
            whole, solving = ([known[key] for key in own if key in known] for known in times)
            if whole and not holds_data(model):
                yield _Times(label, kind, whole, solving)
