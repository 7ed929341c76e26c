"""Verdicts of the gates."""

from collections.abc import Iterable
from math import inf
from typing import Any

from workbench.report.page.bibliography import cited
from workbench.report.page.formatting import interval, metric_title, metric_value, spans
from workbench.report.page.markdown import Cell, Markdown, literal
from workbench.report.page.page import Page
from workbench.study.assessment import Verdict
from workbench.study.assessor import Assessment

TONES = {verdict.value: "doubt" for verdict in Verdict} | {"pass": "good", "fail": "bad"}
_PRINTED = 30
Row = dict[str, Any]


def verdicts(stored: Assessment) -> Markdown:
    """How the gates ended, one line each, why they are open and bounded so, and every case."""
    rows, cases = stored.records("verdicts"), stored.records("gates")
    return PAGE.blocks(
        "verdicts",
        headline=headline(rows),
        summary=summary_table(rows),
        reasons=reasons(rows, bounds=True),
        cases=_worst_first(cases) if len(cases) > len(rows) > 0 else [],
        printed=_PRINTED,
    )


def in_brief(stored: Assessment) -> Markdown:
    """The verdicts without the reasons for the bounds."""
    rows = stored.records("verdicts")
    return literal([headline(rows), summary_table(rows), reasons(rows, bounds=False)])


def headline(rows: list[Row]) -> Markdown:
    """How the gates ended, and how many cases that were asked have no answer, and why."""
    verdicts = [row["verdict"] for row in rows]
    passed, failed, inconclusive = map(verdicts.count, ("pass", "fail", "inconclusive"))
    apart = [row for row in rows if row["verdict"] == "fail" and row["collapsed"]]
    missing = [row for row in rows if row["refused"] + row["unanswered"]]
    return PAGE.blocks(
        "headline",
        tone="bad" if failed else "doubt" if inconclusive else "good",
        gates=len(rows),
        passed=passed,
        failed=failed,
        open=inconclusive,
        apart=_texts(apart, (f"{row['case']} ({_ended(row)})" for row in apart)),
        missing=_texts(missing, (text for row in missing for text in row["reasons"][:1])),
    )


def _texts(rows: list[Row], texts: Iterable[str]) -> dict[str, Any]:
    return {"gates": len(rows), "texts": list(dict.fromkeys(texts))}


def summary_table(rows: list[Row]) -> Markdown:
    """Verdict, critical value and bound of every gate; nothing without one."""
    return PAGE.blocks("summary_table", rows=rows)


def reasons(rows: list[Row], *, bounds: bool) -> Markdown:
    """Reasons against a pass and, with `bounds`, why gates ask that: once for all alike."""
    texts = [(reason, row["number"]) for row in rows for reason in row["reasons"]]
    why = [(f"{row['rationale']} {cited(row['source'])}".strip(), row["number"]) for row in rows]
    return PAGE.blocks("reasons", open_cases=_by_gates(texts), bounds=_by_gates(why) * bounds)


def _by_gates(texts: Iterable[tuple[str, int]]) -> list[tuple[str, str]]:
    """Numbers of the gates that have a text in common, and the text."""
    numbers: dict[str, list[int]] = {}
    for text, number in texts:
        numbers.setdefault(text, []).append(number)
    return [(f"gate{'s' * (len(n) > 1)} {spans(n)}", text) for text, n in numbers.items()]


def _critical(row: Row) -> Cell:
    if row["value"] is None and not row["collapsed"]:
        return Cell("not judged")
    text = _interval(row)
    reach = inf if row["value"] is None else abs(row["value"])
    return Cell(f"{text} ({row['case']})" if row["asked"] > 1 else text, reach)


def _ended(row: Row) -> str:
    """Which side collapses in the case of a row, in words."""
    return "both collapse" if len(row["collapsed"]) == 2 else f"{row['collapsed'][0]} collapses"


def _interval(row: Row) -> str:
    if row["collapsed"]:
        return _ended(row)
    limits = row.get("low"), row.get("high")
    return interval(row["metric"], row["quantity"], row["value"], row["uncertainty"], *limits)


def _bound(row: Row) -> Cell:
    bound = metric_value(row["metric"], row["quantity"], row["bound"], bound=True)
    return Cell(f"±{bound}", row["bound"])


def _worst_first(rows: list[Row]) -> list[Row]:
    """Rows of which paper shows only the first: those that did not pass, then by their values."""
    if len(rows) <= _PRINTED:
        return rows
    order = [verdict.value for verdict in Verdict]
    return sorted(rows, key=lambda r: (order.index(r["verdict"]), -abs(r["value"] or 0.0)))


PAGE = Page(
    __file__, tones=TONES, critical=_critical, bound=_bound, value=_interval, metric=metric_title
)
