"""What was asked, and what the gates say."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pandas as pd

from workbench.assessment import Verdict
from workbench.content.bibliography import cited
from workbench.content.formatting import (
    count,
    interval,
    metric_title,
    metric_value,
    title_of,
)
from workbench.content.tree import (
    Block,
    Callout,
    Cell,
    Column,
    Paragraph,
    Section,
    Table,
)
from workbench.report.stored import Stored
from workbench.study.definition import Study

TONES = {verdict.value: "doubt" for verdict in Verdict} | {"pass": "good", "fail": "bad"}
_PRINTED = 30
_WELL_KNOWN = 0.015  # relative uncertainty below which a reference counts as fine
_LISTED = 6
_NOTES = 2  # reasons shown in the summary; the table of cases has all


def asked(study: Study, stored: Stored) -> Section:
    """The question and what was done to answer it."""
    cells = stored.cells.values()
    answered = sum(cell.ok for cell in cells)
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
    rows = stored.rows["verdicts"]
    if not rows:
        text = "The study sets no acceptance gates: it reports, it does not judge."
        return Section("verdicts", "Verdicts", (Callout("note", text),))
    blocks: list[Block] = [headline(rows)]
    blocks.extend(Callout("doubt", text) for text in (warning, *_doubts(stored)) if text)
    blocks.append(summary_table(rows))
    if len(stored.tables["gates"]) > len(rows):
        blocks.append(_every_case(stored.tables["gates"]))
    blocks.append(
        Paragraph(
            "A case passes if the whole interval, value ± numerical uncertainty, lies within the "
            "bound, fails if none of it does, and is inconclusive otherwise, as the validation "
            "comparison of [@asme-vv20] asks. A gate fails if one of its cases fails, and passes "
            "only if every case that was asked passes: one without an answer may be the worst."
        )
    )
    return Section("verdicts", "Verdicts", tuple(blocks))


def _doubts(stored: Stored) -> Iterator[str]:
    """What a reader must know before the table: how well the reference itself is known."""
    ladder = stored.tables["ladder"]
    if ladder.empty or "relative" not in ladder:
        return
    peaks = ladder[ladder["quantity"] == "peak_displacement"]
    reference = stored.study.reference
    present = peaks["case"].map(
        lambda case: stored.number(case, reference, "peak_displacement") is not None
    )
    coarse = peaks[(peaks["relative"] > _WELL_KNOWN) | (peaks["relative"].isna() & present)]
    if not coarse.empty:
        listed = [f"{r['case']}: {_share(r['relative'])}" for _, r in coarse.iterrows()]
        shown = "; ".join(listed[:_LISTED]) + ("; …" if len(listed) > _LISTED else "")
        yield (
            "The reference itself is known only to (numerical uncertainty of its peak "
            f"displacement): {shown}. The intervals below contain this."
        )


def _share(relative: float) -> str:
    return "unknown" if pd.isna(relative) else f"{100.0 * relative:.1f} %"


def headline(rows: list[dict[str, Any]]) -> Callout:
    """How the gates ended, and how many cases that were asked have no answer, and why."""
    found = [row["verdict"] for row in rows]
    numbers = {name: found.count(name) for name in ("pass", "fail", "inconclusive")}
    tone = "bad" if numbers["fail"] else "doubt" if numbers["inconclusive"] else "good"
    parts = [f"{numbers['pass']} passed", f"{numbers['fail']} failed"]
    parts.append(f"{numbers['inconclusive']} inconclusive")
    text = f"Of {count(len(rows), 'gate')}, {', '.join(parts)}."
    missing = [row for row in rows if row["refused"] + row["unanswered"]]
    if missing:
        lost = {reason: None for row in missing for reason in row["reasons"].splitlines()[:1]}
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
    body = []
    for row in rows:
        value = interval(row["metric"], row["quantity"], row["value"], row["uncertainty"])
        if row["case"] and row["asked"] > 1:
            value += f"\n({row['case']})"
        if row["value"] is None:
            value = "not judged"
        passed = f"{row['pass']} of {row['asked']}"
        why = f"{row['rationale']} {cited(row['source'])}".strip()
        why = "\n".join([why, *row["reasons"].splitlines()])
        body.append(
            (
                Cell(row["verdict"], tone=TONES[row["verdict"]]),
                Cell(question_of(row)),
                Cell(value, None if row["value"] is None else abs(row["value"])),
                Cell(
                    "±" + metric_value(row["metric"], row["quantity"], row["bound"], bound=True),
                    row["bound"],
                ),
                Cell(passed, row["pass"] / max(row["asked"], 1)),
                Cell(why),
            )
        )
    columns = (
        Column("verdict", width=1.25),
        Column("what is judged", width=2.6),
        Column("critical value ± uncertainty", True, 2.0),
        Column("bound", True, 1.0),
        Column("cases passed", True, 0.85),
        Column("why this bound", width=3.0),
    )
    return Table("verdict-table", "Verdicts of the acceptance gates.", columns, tuple(body))


def _every_case(table: pd.DataFrame) -> Table:
    if len(table) > _PRINTED:
        # paper shows the first rows only: what did not pass comes first, then the largest values
        order = table["verdict"].map(lambda verdict: list(Verdict).index(Verdict(verdict)))
        ranked = table.assign(order=order, size=table["value"].abs())
        table = ranked.sort_values(["order", "size"], ascending=[True, False], kind="stable")
    body = []
    for row in table.to_dict("records"):
        body.append(
            (
                Cell(row["verdict"], tone=TONES[row["verdict"]]),
                Cell(question_of({str(k): v for k, v in row.items()})),
                Cell(row["case"]),
                Cell(
                    interval(row["metric"], row["quantity"], row["value"], row["uncertainty"]),
                    row["value"],
                ),
                Cell(row["note"], tone="muted"),
            )
        )
    columns = (
        Column("verdict", width=1.25),
        Column("what is judged", width=2.8),
        Column("case", width=1.6),
        Column("value ± uncertainty", True, 1.8),
        Column("where the uncertainty comes from", width=3.0),
    )
    return Table("gate-cases", "Every case of every gate.", columns, tuple(body), _PRINTED)
