"""Models over tests, tables of numbers, how well the reference is known, what answers cost."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import pandas as pd

from workbench.base.tables import plain_rows
from workbench.report.page.formatting import (
    axis_label,
    duration,
    in_unit,
    interval,
    metric_title,
    share,
    title_of,
    unit_of,
    valued,
)
from workbench.report.page.markdown import ABSENT, Cell, Markdown, PageColumn, Picture, Table
from workbench.report.page.page import Page
from workbench.responses import Outcome, attribute
from workbench.responses.uncertainty import sampled_interval
from workbench.study.assessment import METRICS, Scope
from workbench.study.assessor import BEST, Assessment, width_of
from workbench.study.definition import DATA, Study, holds_data
from workbench.study.tables import Row
from workbench.study.validation import MEASURED

MARK = "SYNTHETIC, no tests: "  # before every caption of a report that shows made numbers
_PRINTED = 40
PAGE = Page(__file__, printed=_PRINTED, duration=duration)
_ONE_LINE = 3  # columns up to which value and deviation share a line
_WIDEST = 6  # cases side by side
_MEASURED = (*DATA, "stud-measured")
_BEAMS = ("fiber-reissner", "fiber-corotational", "fiber-shear")


def synthetic(stored: Assessment) -> Markdown:
    """Callout of a study whose numbers are made, not measured."""
    return PAGE.blocks("synthetic") if stored.synthetic else Markdown()


def footnote(study: Study, stored: Assessment) -> Markdown:
    """Remark under a study of impacts without a single test."""
    struck = any(hasattr(case.scenario, "striker") for case in study.cases)
    return (
        PAGE.blocks("footnote")
        if struck and (stored.synthetic or not _tests(study))
        else Markdown()
    )


def _tests(study: Study) -> list[str]:
    return [label for label, model in study.models.items() if model.name == MEASURED]


def validation(study: Study, stored: Assessment) -> Markdown:
    """Bias, scatter and coverage over tests, and the sources of the tests; None without tests."""
    rows = stored.tables["validation"]
    sources = sources_of_tests(study, stored) if len(rows) else []
    return PAGE.blocks("validation", rows=rows, sources=sources)


def sources_of_tests(study: Study, stored: Assessment) -> list[dict[str, Any]]:
    """Data sets of the tests, as stored with the answers, and how many tests each gave."""
    datasets: dict[str, dict[str, Any]] = {}
    for case in study.cases:
        for label in _tests(study):
            response = stored.response(case.name, label)
            if response is None:
                continue
            given = attribute(response, "data")
            for entry in given["datasets"]:
                known = datasets.setdefault(entry["name"], {**entry, "tests": 0})
                known["tests"] += len(given["tests"])
    return list(datasets.values())


def numbers(study: Study, stored: Assessment) -> Markdown:
    """Values and deviations of every quantity, curve and history metrics, bias and scatter."""
    tables = {quantity: _values(study, stored, quantity) for quantity in study.quantities}
    return PAGE.blocks(
        "numbers",
        values=[table for table in tables.values() if table is not None],
        shapes=list(_shapes(study, stored)),
        bias=[] if len(stored.tables["matrix"]) else stored.tables["bias"],  # the matrix says more
        silent=[title_of(quantity) for quantity, table in tables.items() if table is None],
    )


def _values(study: Study, stored: Assessment, quantity: str) -> Table | None:
    values = stored.values(quantity)
    if not values:
        return None
    cases = list(dict.fromkeys(case for case, _ in values))
    labels = [label for label in study.models if any(label == other for _, other in values)]
    governing = len(study.ranked) > 1
    errors = stored.errors(quantity, "relative_error", BEST if governing else study.reference)
    few = len(cases) <= _WIDEST
    gap = "\n" if len(cases if few else labels) > _ONE_LINE else "\u2002"

    def cell(case: str, label: str) -> Cell:
        if (case, label) not in values:
            return Cell("collapse") if stored.collapses(case, label) else ABSENT
        width = stored.number(case, label, width_of(quantity)) or 0.0
        text = in_unit(values[case, label], quantity, width=width, named=False)
        if (case, label) in errors:
            row = errors[case, label]
            if None not in (row.get("low"), row.get("high")):
                text = _sampled(stored, case, label, quantity)
            text += f"{gap}{_interval('relative_error', row)}"
        return Cell(text, values[case, label])

    rows, columns = labels, [PageColumn("model", width=2.0, of=str)]
    if few:
        columns += (PageColumn(case, True, 1.4, partial(cell, case)) for case in cases)
    else:
        rows, columns = cases, [PageColumn("case", width=2.4, of=str)]
        columns += (PageColumn(label, True, 1.3, partial(cell, label=label)) for label in labels)
    against = "" if governing else study.reference
    caption = PAGE.words("values", quantity=quantity, unit=unit_of(quantity).text, against=against)
    return Table.of(f"values-{quantity}", caption, columns, rows, _PRINTED)


def _interval(metric: str, row: Row) -> str:
    """The value of a comparison with what is known of its uncertainty."""
    ends = row.get("low"), row.get("high")
    return interval(metric, row["quantity"], row["error"], row["uncertainty"], *ends, unknown="")


def _sampled(stored: Assessment, case: str, label: str, quantity: str) -> str:
    """Value and interval of a quantity that is a statistic of tests."""
    response = stored.response(case, label)
    ends = None if response is None else sampled_interval(response, quantity)
    values = (stored.number(case, label, quantity), *(ends or ()))
    value, *known = (in_unit(each, quantity, named=False) for each in values)
    return f"{value} ({' to '.join(known)})" if known else value


_SHAPE = ["case", "model", "quantity", "metric", "error", "uncertainty", "low", "high"]


def _shapes(study: Study, stored: Assessment) -> Iterator[Table]:
    """Metrics of histories and curves against the reference."""
    for scope, word in ((Scope.HISTORY, "Histories"), (Scope.CURVE, "Curves")):
        metrics = [name for name, metric in METRICS.items() if metric.scope is scope]
        rows: dict[tuple[str, str, str], dict[str, dict[str, Any]]] = {}
        table = stored.tables["comparisons"]
        table = table[(table["against"] == study.reference) & table["metric"].isin(metrics)]
        for row in plain_rows(table[_SHAPE]):
            key = row["case"], row["model"], row["quantity"]
            rows.setdefault(key, {})[row["metric"]] = row
        if not rows:
            continue
        columns = (
            PageColumn("case", width=1.6, of=lambda pair: pair[0][0]),
            PageColumn("model", width=1.7, of=lambda pair: pair[0][1]),
            PageColumn("quantity", width=1.3, of=lambda pair: title_of(pair[0][2])),
            *(
                PageColumn(metric_title(name), True, 1.35, partial(_metric, name))
                for name in metrics
            ),
        )
        caption = PAGE.words(
            "shapes",
            scope=word,
            reference=study.reference,
            cites=[f"[@{key}]" for key in dict.fromkeys(METRICS[m].citation for m in metrics)],
            meanings=[f"{METRICS[m].title} = {METRICS[m].meaning}" for m in metrics],
        )
        yield Table.of(f"shapes-{scope.value}", caption, columns, rows.items(), _PRINTED)


def _metric(metric: str, pair: tuple[Any, dict[str, dict[str, Any]]]) -> Cell:
    """The cell of a metric in the row of a case, model and quantity."""
    row = pair[1].get(metric)
    return ABSENT if row is None else Cell(_interval(metric, row), row["error"])


def convergence(study: Study, stored: Assessment, figures: Iterable[Picture]) -> Markdown:
    """How well the reference is known: the table of its ladder and the figures that show it."""
    name = study.models[study.reference].name
    rows = [row for row in stored.records("ladder") if _has_level(study, stored, row)]
    return PAGE.blocks(
        "convergence",
        reference=study.reference,
        measured=name in _MEASURED,
        refined=len(study.steps) >= 2,
        steps=study.steps,
        alone=study.steps != study.ladder,  # a reference that makes these runs itself
        beams=name in _BEAMS,
        figures=list(figures),
        ladder=Table.of("ladder", "", _ladder_columns(study), rows, 40) if rows else None,
    )


def _has_level(study: Study, stored: Assessment, row: dict[str, Any]) -> bool:
    """Whether a row of the ladder is shown: it has values, or a level should have answered."""
    return any(row[label] is not None for label in study.steps) or any(
        stored.expects(row["case"], label) and not stored.ok(row["case"], label)
        for label in (*study.ladder, study.reference)
    )


def _ladder_columns(study: Study) -> Iterator[PageColumn]:
    def value(name: str) -> Callable[[Any], Cell]:
        return lambda row: valued(row[name], 4, factor=unit_of(row["quantity"]).factor)

    yield PageColumn("case", width=1.6, of="case")
    yield PageColumn("quantity", width=1.7, of=lambda row: axis_label(row["quantity"]))
    for label in study.steps:
        yield PageColumn(label, True, 1.15, value(label))
    yield PageColumn("order", True, 0.7, lambda row: valued(row["order"], 3))
    yield PageColumn("extrapolated", True, 1.1, value("extrapolated"))
    yield PageColumn(
        *("numerical uncertainty", True, 1.05),
        lambda row: share(row["relative"], "" if row["accepted"] else "doubt"),
    )
    yield PageColumn("note", width=2.4, of=lambda row: Cell(row["note"], tone="muted"))


def cost(study: Study, stored: Assessment, figures: Iterable[Picture]) -> Markdown:
    """Wall times per model and the figures that set them against errors."""
    return PAGE.blocks(
        "cost",
        times=_times(study, stored),
        figures=list(figures),
        kinds=len(stored.provenance),
    )


def _times(study: Study, stored: Assessment) -> pd.DataFrame:
    """Wall times (s) by label and kind of scenario: whole answers, and the median of solving."""
    cells = stored.tables["cells"]
    kinds = {case.name: case.scenario.KIND for case in study.cases}
    labels = [label for label, model in study.models.items() if not holds_data(model)]
    timed = cells[(cells["outcome"] == Outcome.OK) & cells["wall_time"].notna()]
    whole = timed.assign(kind=timed["case"].map(kinds)).groupby(["label", "kind"], sort=False)
    times = whole["wall_time"].agg(["count", "min", "median", "max"])
    times["solving"] = whole["solve_time"].median()
    order = [(label, kind) for label in labels for kind in dict.fromkeys(kinds.values())]
    return times.reindex([key for key in order if key in times.index]).reset_index()
