"""What the gates say."""

from collections.abc import Iterator
from math import inf
from typing import Any

from workbench.assessment import Verdict
from workbench.content.bibliography import cited
from workbench.content.formatting import (
    count,
    interval,
    metric_title,
    metric_value,
    spans,
    title_of,
)
from workbench.content.tree import (
    Block,
    Callout,
    Cell,
    Column,
    Definitions,
    Paragraph,
    Section,
    Table,
)
from workbench.report.stored import Stored

TONES = {verdict.value: "doubt" for verdict in Verdict} | {"pass": "good", "fail": "bad"}
_PRINTED = 30
_NOTES = 2  # reasons shown in the summary; the table of cases has all
_RULE = (
    "A case passes if the whole interval, value ± numerical uncertainty, lies within the bound, "
    "fails if none of it does (an interval over tests is skewed and stands as low to high), and is "
    "inconclusive otherwise, as the validation comparison of "
    "[@asme-vv20] asks. Where one side collapses and the other survives it fails; where both "
    "collapse it passes without a number. A gate fails if one of its cases fails, and passes only "
    "if every case that was asked passes: one without an answer may be the worst."
)
_EVERY = " [#gate-cases] has them one by one."
_VERDICT = Column(
    "verdict", width=1.25, of=lambda row: Cell(row["verdict"], tone=TONES[row["verdict"]])
)


def verdicts(stored: Stored) -> Section:
    """How the gates ended, one line each, why they are open and bounded so, and every case."""
    rows, cases = stored.rows["verdicts"], stored.rows["gates"]
    blocks: list[Block] = [headline(rows)]
    if rows:
        blocks.append(summary_table(rows))
        blocks.extend(reasons(rows))
        every = len(cases) > len(rows)
        blocks.append(Paragraph(f"{_RULE}{_EVERY if every else ''}"))
        blocks.extend([_every_case(cases)] if every else [])
    return Section("verdicts", "Verdicts", tuple(blocks))


def headline(rows: list[dict[str, Any]]) -> Callout:
    """How the gates ended, and how many cases that were asked have no answer, and why."""
    if not rows:
        return Callout("note", "The study sets no acceptance gates: it reports, it does not judge.")
    found = [row["verdict"] for row in rows]
    passed, failed, open_ = map(found.count, ("pass", "fail", "inconclusive"))
    tone = "bad" if failed else "doubt" if open_ else "good"
    gates = count(len(rows), "gate")
    text = f"Of {gates}, {passed} passed, {failed} failed, {open_} inconclusive."
    apart = [row for row in rows if row["verdict"] == "fail" and row["collapsed"]]
    if apart:
        said = dict.fromkeys(f"{row['case']} ({_ended(row)})" for row in apart)
        shown = "; ".join([*said][:_NOTES]) + ("; more below" if len(said) > _NOTES else "")
        text += f" One side collapses where the other survives in {count(len(apart), 'gate')}: "
        text += f"{shown}."
    missing = [row for row in rows if row["refused"] + row["unanswered"]]
    if missing:
        lost = {reason: None for row in missing for reason in row["reasons"][:1]}
        shown = "; ".join(list(lost)[:_NOTES]) + ("; more below" if len(lost) > _NOTES else "")
        text += f" Answers are missing in {count(len(missing), 'gate')}: {shown}."
    return Callout(tone, text)


def question_of(row: dict[str, Any]) -> str:
    """What a gate asks, in words."""
    quantity = title_of(str(row["quantity"]))
    if row["model"] == row["against"]:
        return f"{row['model']}: {metric_title(row['metric'])} of {quantity}"
    return f"{row['model']} against {row['against']}: {metric_title(row['metric'])} of {quantity}"


def summary_table(rows: list[dict[str, Any]]) -> Table:
    """Verdict, critical value and bound of every gate."""
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
    return Table.of("verdict-table", "Verdicts of the acceptance gates.", columns, rows)


def reasons(rows: list[dict[str, Any]], *, bounds: bool = True) -> Iterator[Block]:
    """What keeps gates from passing and, with `bounds`, why they ask that: once for all alike."""
    kept: dict[str, list[int]] = {}
    why: dict[str, list[int]] = {}
    for row in rows:
        for reason in row["reasons"]:
            kept.setdefault(reason, []).append(row["number"])
        rationale = f"{row['rationale']} {cited(row['source'])}".strip()
        why.setdefault(rationale, []).append(row["number"])
    for title, texts in (("Open cases:", kept), ("Why these bounds:", why if bounds else {})):
        if texts:
            yield Paragraph(title)
            pairs = ((f"gate{'s' * (len(n) > 1)} {spans(n)}", text) for text, n in texts.items())
            yield Definitions(tuple(pairs))


def _critical(row: dict[str, Any]) -> Cell:
    if row["value"] is None and not row["collapsed"]:
        return Cell("not judged")
    text = _interval(row)
    reach = inf if row["value"] is None else abs(row["value"])
    return Cell(f"{text} ({row['case']})" if row["asked"] > 1 else text, reach)


def _ended(row: dict[str, Any]) -> str:
    """Which side collapses in the case of a row, in words."""
    return "both collapse" if len(row["collapsed"]) == 2 else f"{row['collapsed'][0]} collapses"


def _interval(row: dict[str, Any]) -> str:
    if row["collapsed"]:
        return _ended(row)
    ends = row.get("low"), row.get("high")
    return interval(row["metric"], row["quantity"], row["value"], row["uncertainty"], *ends)


def _bound(row: dict[str, Any]) -> Cell:
    bound = metric_value(row["metric"], row["quantity"], row["bound"], bound=True)
    return Cell(f"±{bound}", row["bound"])


def _every_case(rows: list[dict[str, Any]]) -> Table:
    if len(rows) > _PRINTED:
        # paper shows the first rows only: what did not pass comes first, then the largest values
        order = [verdict.value for verdict in Verdict]
        rows = sorted(rows, key=lambda r: (order.index(r["verdict"]), -abs(r["value"] or 0.0)))

    def note(row: dict[str, Any]) -> Cell:
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
    return Table.of("gate-cases", "Every case of every gate.", columns, rows, _PRINTED)
