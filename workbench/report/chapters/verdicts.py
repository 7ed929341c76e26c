"""What the gates say."""

from collections.abc import Iterable
from math import inf
from typing import Any

from workbench.assessment import Verdict
from workbench.content.bibliography import cited
from workbench.content.formatting import interval, metric_title, metric_value, spans
from workbench.content.page import Page
from workbench.content.tree import Block, Callout, Cell, Column, Section, Table
from workbench.report.stored import Stored

TONES = {verdict.value: "doubt" for verdict in Verdict} | {"pass": "good", "fail": "bad"}
PAGE = Page(__file__)
_PRINTED = 30
_VERDICT = Column(
    "verdict", width=1.25, of=lambda row: Cell(row["verdict"], tone=TONES[row["verdict"]])
)
Row = dict[str, Any]


def verdicts(stored: Stored) -> Section | None:
    """How the gates ended, one line each, why they are open and bounded so, and every case."""
    rows, cases = stored.rows["verdicts"], stored.rows["gates"]
    return PAGE.section(
        "verdicts",
        headline=headline(rows),
        table=summary_table(rows),
        reasons=reasons(rows, bounds=True),
        every_case=_every_case(cases) if len(cases) > len(rows) > 0 else None,
    )


def in_brief(stored: Stored) -> tuple[Block, ...]:
    """The verdicts without the reasons for the bounds."""
    rows = stored.rows["verdicts"]
    return (headline(rows), *summary_table(rows), *reasons(rows, bounds=False))


def headline(rows: list[Row]) -> Callout:
    """How the gates ended, and how many cases that were asked have no answer, and why."""
    verdicts = [row["verdict"] for row in rows]
    passed, failed, inconclusive = map(verdicts.count, ("pass", "fail", "inconclusive"))
    apart = [row for row in rows if row["verdict"] == "fail" and row["collapsed"]]
    missing = [row for row in rows if row["refused"] + row["unanswered"]]
    (callout,) = PAGE.blocks(
        "headline",
        tone="bad" if failed else "doubt" if inconclusive else "good",
        gates=len(rows),
        passed=passed,
        failed=failed,
        open=inconclusive,
        apart=_texts(apart, (f"{row['case']} ({_ended(row)})" for row in apart)),
        missing=_texts(missing, (text for row in missing for text in row["reasons"][:1])),
    )
    assert isinstance(callout, Callout)
    return callout


def _texts(rows: list[Row], texts: Iterable[str]) -> dict[str, Any]:
    return {"gates": len(rows), "texts": list(dict.fromkeys(texts))}


def question_of(row: Row) -> str:
    """What a gate asks, in words."""
    return PAGE.words("question", row=row, metric=metric_title(row["metric"]))


def summary_table(rows: list[Row]) -> tuple[Block, ...]:
    """Verdict, critical value and bound of every gate; nothing without one."""
    columns = (
        _VERDICT,
        Column("no.", width=0.4, of="number"),
        Column("what is judged", width=3.4, of=question_of),
        Column("critical value ± numerical or data uncertainty", True, 2.4, _critical),
        Column("bound", True, 0.9, _bound),
        Column(
            *("cases passed", True, 0.9),
            lambda row: Cell(
                f"{row['pass']} of {row['asked']}", row["pass"] / max(row["asked"], 1)
            ),
        ),
    )
    table = Table.of("verdict-table", "", columns, rows) if rows else None
    return PAGE.blocks("summary_table", table=table)


def reasons(rows: list[Row], *, bounds: bool) -> tuple[Block, ...]:
    """What keeps gates from passing and, with `bounds`, why they ask that: once for all alike."""
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


def _every_case(rows: list[Row]) -> Table:
    if len(rows) > _PRINTED:
        # paper shows the first rows only: what did not pass comes first, then the largest values
        order = [verdict.value for verdict in Verdict]
        rows = sorted(rows, key=lambda r: (order.index(r["verdict"]), -abs(r["value"] or 0.0)))

    def note(row: Row) -> Cell:
        return Cell("; ".join(filter(None, (row["doubt"], row["note"]))), tone="muted")

    columns = (
        _VERDICT,
        Column("what is judged", width=2.8, of=question_of),
        Column("case", width=1.6, of="case"),
        Column(
            *("value ± numerical or data uncertainty", True, 1.8),
            lambda row: Cell(_interval(row), row["value"]),
        ),
        Column("where the uncertainty comes from", width=3.0, of=note),
    )
    return Table.of("gate-cases", "", columns, rows, _PRINTED)
