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

TONES = {"pass": "good", "fail": "bad", "inconclusive": "doubt"}
_PRINTED = 30
_WELL_KNOWN = 0.015  # relative uncertainty below which a reference counts as fine
_LISTED = 6
_NOTES = 2  # reasons shown in the summary; the table of cases has all
_WORST = (Verdict.FAIL, Verdict.INCONCLUSIVE, Verdict.PASS)


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


def verdict_rows(stored: Stored) -> list[dict[str, Any]]:
    """One row per gate: its worst verdict, and the case whose interval reaches farthest."""
    table = stored.tables["gates"]
    found = []
    # gates on other cases may ask the same with other reasons
    numbers: Any = table.groupby(["gate", "bound", "rationale"], sort=False).ngroup()
    for gate in dict.fromkeys(numbers):
        rows = table[numbers == gate]
        verdicts = list(rows["verdict"])
        worst = next(verdict.value for verdict in _WORST if verdict in verdicts)
        valued = rows[rows["value"].notna()]
        same = valued[valued["verdict"] == worst]
        valued = valued if same.empty else same
        reach = valued["value"].abs() + valued["uncertainty"].fillna(0.0)
        top = None if valued.empty else valued.loc[reach.idxmax()]
        found.append(
            {
                **rows.iloc[0].to_dict(),
                "verdict": worst,
                "cases": len(rows),
                "passed": verdicts.count(Verdict.PASS),
                "value": None if top is None else float(top["value"]),
                "uncertainty": None if top is None else float(top["uncertainty"]),
                "case": "" if top is None else str(top["case"]),
                "unjudged": list(dict.fromkeys(rows[rows["value"].isna()]["note"])),
            }
        )
    return found


def verdicts(stored: Stored, warning: str = "") -> Section:
    """The table of verdicts, critical case of each gate, and every case of every gate.

    `warning` is said beside the headline: where all models leave their assumptions.
    """
    rows = verdict_rows(stored)
    if not rows:
        text = "The study sets no acceptance gates: it reports, it does not judge."
        return Section("verdicts", "Verdicts", (Callout("note", text),))
    blocks: list[Block] = [_headline(rows)]
    blocks.extend(Callout("doubt", text) for text in (warning, *_doubts(stored)) if text)
    blocks.append(summary_table(rows))
    if len(stored.tables["gates"]) > len(rows):
        blocks.append(_every_case(stored.tables["gates"]))
    blocks.append(
        Paragraph(
            "A gate passes if the whole interval, value ± numerical uncertainty, lies within the "
            "bound, fails if none of it does, and is inconclusive otherwise, as the validation "
            "comparison of [@asme-vv20] asks. A gate over several cases has its worst verdict."
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


def _headline(rows: list[dict[str, Any]]) -> Callout:
    numbers = {tone: [row["verdict"] for row in rows].count(tone) for tone in TONES}
    tone = "bad" if numbers["fail"] else "doubt" if numbers["inconclusive"] else "good"
    parts = [f"{numbers['pass']} passed", f"{numbers['fail']} failed"]
    parts.append(f"{numbers['inconclusive']} inconclusive")
    return Callout(tone, f"Of {count(len(rows), 'gate')}, {', '.join(parts)}.")


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
        if row["case"] and row["cases"] > 1:
            value += f"\n({row['case']})"
        if row["value"] is None:
            value = "not judged"
        passed = f"{row['passed']} of {row['cases']}"
        why = f"{row['rationale']} {cited(row['source'])}".strip()
        if row["verdict"] == Verdict.INCONCLUSIVE and row["unjudged"]:
            why += "\nNot judged: " + "; ".join(row["unjudged"][:_NOTES])
        body.append(
            (
                Cell(row["verdict"], tone=TONES[row["verdict"]]),
                Cell(question_of(row)),
                Cell(value, None if row["value"] is None else abs(row["value"])),
                Cell(
                    "±" + metric_value(row["metric"], row["quantity"], row["bound"], bound=True),
                    row["bound"],
                ),
                Cell(passed, row["passed"] / row["cases"]),
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
        order = table["verdict"].map(lambda verdict: _WORST.index(Verdict(verdict)))
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
