"""What was asked, and what the gates say."""

from math import inf
from typing import Any

from workbench.assessment import Verdict
from workbench.content.bibliography import cited
from workbench.content.formatting import count, interval, metric_title, metric_value, title_of
from workbench.content.tree import Block, Callout, Cell, Column, Paragraph, Section, Table
from workbench.report.stored import Stored
from workbench.study.definition import Study

TONES = {verdict.value: "doubt" for verdict in Verdict} | {"pass": "good", "fail": "bad"}
_PRINTED = 30
_WELL_KNOWN = 0.015  # relative uncertainty below which a reference counts as fine
_LISTED = 6
_NOTES = 2  # reasons shown in the summary; the table of cases has all
_RULE = (
    "A case passes if the whole interval, value ± numerical uncertainty, lies within the bound, "
    "fails if none of it does, and is inconclusive otherwise, as the validation comparison of "
    "[@asme-vv20] asks. Where one side collapses and the other survives it fails; where both "
    "collapse it passes without a number. A gate fails if one of its cases fails, and passes only "
    "if every case that was asked passes: one without an answer may be the worst."
)
_VERDICT = Column(
    "verdict", width=1.25, of=lambda row: Cell(row["verdict"], tone=TONES[row["verdict"]])
)


def asked(study: Study, stored: Stored) -> Section:
    """The question and what was done to answer it."""
    cells = stored.cells.values()
    answered = sum(cell.ok or cell.collapse is not None for cell in cells)
    done = (
        f"{count(len(study.cases), 'case')} and {count(len(study.models), 'model')} ask for "
        f"{count(len(cells), 'cell')}; {answered} of them hold an answer."
    )
    reference = f"The reference is {study.reference}"
    if len(study.steps) > 1:
        reference += f", refined in {count(len(study.steps), 'level')} ({', '.join(study.steps)})"
    return Section(
        "question", "What was asked", (Paragraph(study.question), Paragraph(f"{done} {reference}."))
    )


def verdicts(stored: Stored, warning: str = "") -> Section:
    """The table of verdicts, critical case of each gate, and every case of every gate.

    `warning` is said beside the headline: where all models leave their assumptions.
    """
    rows, cases = stored.rows["verdicts"], stored.rows["gates"]
    blocks: list[Block] = [headline(rows)]
    if rows:
        blocks.extend(Callout("doubt", text) for text in (warning, _doubt(stored)) if text)
        blocks.append(summary_table(rows))
        if len(cases) > len(rows):
            blocks.append(_every_case(cases))
        blocks.append(Paragraph(_RULE))
    return Section("verdicts", "Verdicts", tuple(blocks))


def _doubt(stored: Stored) -> str:
    """What a reader must know before the table: how well the reference itself is known."""
    reference = stored.study.reference
    peaks, coarse = stored.values("peak_displacement"), []
    for row in stored.rows["ladder"]:
        known = row["quantity"] == "peak_displacement" and (row["case"], reference) in peaks
        if known and (row["relative"] is None or row["relative"] > _WELL_KNOWN):
            width = "unknown" if row["relative"] is None else f"{100.0 * row['relative']:.1f} %"
            coarse.append(f"{row['case']}: {width}")
    if not coarse:
        return ""
    shown = "; ".join(coarse[:_LISTED]) + ("; …" if len(coarse) > _LISTED else "")
    return (
        "The reference itself is known only to (numerical uncertainty of its peak "
        f"displacement): {shown}. The intervals below contain this."
    )


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


def summary_table(rows: list[dict[str, Any]], *, reasons: bool = True) -> Table:
    """Verdict, critical value and bound of every gate; `reasons`, also why this bound."""
    columns = (
        _VERDICT,
        Column("what is judged", width=2.6, of=question_of),
        Column("critical value ± uncertainty", True, 2.0, _critical),
        Column("bound", True, 1.0, _bound),
        Column("cases passed", True, 0.85, _passed),
        Column("why this bound", width=3.0, of=_why),
    )
    caption = "Verdicts of the acceptance gates."
    return Table.of("verdict-table", caption, columns if reasons else columns[:-1], rows)


def _critical(row: dict[str, Any]) -> Cell:
    if row["value"] is None and not row["collapsed"]:
        return Cell("not judged")
    text = _interval(row)
    reach = inf if row["value"] is None else abs(row["value"])
    return Cell(f"{text}\n({row['case']})" if row["asked"] > 1 else text, reach)


def _ended(row: dict[str, Any]) -> str:
    """Which side collapses in the case of a row, in words."""
    return "both collapse" if len(row["collapsed"]) == 2 else f"{row['collapsed'][0]} collapses"


def _interval(row: dict[str, Any]) -> str:
    if row["collapsed"]:
        return _ended(row)
    return interval(row["metric"], row["quantity"], row["value"], row["uncertainty"])


def _bound(row: dict[str, Any]) -> Cell:
    bound = metric_value(row["metric"], row["quantity"], row["bound"], bound=True)
    return Cell(f"±{bound}", row["bound"])


def _passed(row: dict[str, Any]) -> Cell:
    return Cell(f"{row['pass']} of {row['asked']}", row["pass"] / max(row["asked"], 1))


def _note(row: dict[str, Any]) -> Cell:
    return Cell(row["note"], tone="muted")


def _why(row: dict[str, Any]) -> str:
    why = f"{row['rationale']} {cited(row['source'])}".strip()
    return "\n".join([why, *row["reasons"]])


def _every_case(rows: list[dict[str, Any]]) -> Table:
    if len(rows) > _PRINTED:
        # paper shows the first rows only: what did not pass comes first, then the largest values
        order = [verdict.value for verdict in Verdict]
        rows = sorted(rows, key=lambda r: (order.index(r["verdict"]), -abs(r["value"] or 0.0)))
    columns = (
        _VERDICT,
        Column("what is judged", width=2.8, of=question_of),
        Column("case", width=1.6, of="case"),
        Column("value ± uncertainty", True, 1.8, lambda row: Cell(_interval(row), row["value"])),
        Column("where the uncertainty comes from", width=3.0, of=_note),
    )
    return Table.of("gate-cases", "Every case of every gate.", columns, rows, _PRINTED)
