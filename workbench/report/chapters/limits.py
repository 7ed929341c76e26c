"""What is missing, and where models answered outside their own assumptions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from workbench.content.formatting import count, number
from workbench.content.tree import (
    Block,
    Bullets,
    Callout,
    Cell,
    Column,
    Paragraph,
    Section,
    Table,
)
from workbench.report.stored import NOT_RUN, CellState, Stored
from workbench.responses import Outcome
from workbench.study.definition import Study

_PRINTED = 40
_LISTED = 6  # names in a cell
_SIMILAR = 3  # sentences of one kind that are all shown


def missing(study: Study, stored: Stored) -> Section:
    """Cells without an answer, grouped by what happened, and what was not asked."""
    problems = list(stored.problems())
    unasked = _unasked(study)
    if not problems:
        text = f"All {count(len(stored.cells), 'cell')} hold an answer"
        text += "." if unasked else "; nothing is missing."
        return Section("missing", "What is missing", (Callout("good", text), *unasked))
    groups: dict[tuple[str, str], dict[str, list[CellState]]] = {}
    for cell in problems:
        sentence = cell.message or "This cell has not been run, or its inputs have changed since."
        # messages begin with the name of the case, which has a column of its own
        sentence = sentence.removeprefix(f"{cell.case}: ")
        said = groups.setdefault((cell.label, cell.outcome), {})
        said.setdefault(sentence, []).append(cell)
    refusals = sum(cell.outcome == Outcome.OUT_OF_DOMAIN for cell in problems)
    failures = len(problems) - refusals
    blocks: list[Block] = []
    text = f"{count(len(problems), 'cell')} of {len(stored.cells)} hold no answer: "
    text += f"{refusals} because the model does not apply, {failures} for another reason."
    blocks.append(Callout("bad" if failures else "note", text))
    rows = tuple(
        (
            Cell(label),
            Cell(outcome, tone=_tone(outcome)),
            Cell(_names(cell.case for cell in cells), len(cells)),
            Cell(sentence),
        )
        for (label, outcome), said in groups.items()
        for cells, sentence in _merged(said)
    )
    columns = (
        Column("model", width=1.5),
        Column("outcome", width=1.1),
        Column("cases", width=2.0),
        Column("what happened and what to do", width=4.0),
    )
    blocks.append(Table("missing-table", "Cells without an answer.", columns, rows, _PRINTED))
    return Section("missing", "What is missing", (*blocks, *unasked))


def _unasked(study: Study) -> tuple[Block, ...]:
    """Models that were not asked, as they do not answer this kind of scenario."""
    left = study.unasked()
    if not left:
        return ()
    sentences = tuple(
        f"{label} (model {study.models[label].name}) does not answer {kind}: {_names(names)}."
        for (label, kind), names in left.items()
    )
    return (Paragraph("Not asked, and no cells:"), Bullets(sentences))


def _merged(said: dict[str, list[CellState]]) -> Iterator[tuple[list[CellState], str]]:
    """Cells by sentence; many sentences that differ in their numbers become one example."""
    if len(said) <= _SIMILAR:
        yield from ((cells, text) for text, cells in said.items())
        return
    first, *others = said
    cells = [cell for group in said.values() for cell in group]
    yield cells, f"{first} ({len(others)} more with other numbers)"


def _tone(outcome: str) -> str:
    if outcome in (NOT_RUN, Outcome.OUT_OF_DOMAIN):
        return "doubt"
    return "bad"


def _names(cases: Iterable[str]) -> str:
    names = list(dict.fromkeys(cases))
    if len(names) <= _LISTED:
        return ", ".join(names)
    return f"{', '.join(names[: _LISTED - 2])} and {len(names) - _LISTED + 2} more"


@dataclass(frozen=True)
class ShearDemand:
    """What the cells say about shear.

    A `table` of V/Vpl (None: no model states it), and the `headline` on demand above the plastic
    resistance (empty: there is none).
    """

    table: Table | None
    headline: str


def domain(stored: Stored, shear: ShearDemand) -> Section:
    """Warnings of the models, and the shear demand of every case."""
    blocks: list[Block] = []
    if shear.headline:
        blocks.append(Callout("doubt", shear.headline))
    blocks.extend(_warnings(stored))
    if shear.table is not None:
        blocks.append(shear.table)
    if not blocks:
        text = "No model reports that a case lies outside its assumptions."
        blocks.append(Callout("good", text))
    return Section("domain", "Where models leave their assumptions", tuple(blocks))


def _warnings(stored: Stored) -> list[Block]:
    exact: dict[tuple[str, str], list[CellState]] = {}
    for cell in stored.cells.values():
        for finding in cell.warnings:
            exact.setdefault((finding.subject, str(finding)), []).append(cell)
    if not exact:
        return []
    texts: dict[str, dict[str, list[CellState]]] = {}
    for (subject, text), cells in exact.items():
        texts.setdefault(subject, {})[text] = cells
    entries = [
        (subject, cells, text) for subject, said in texts.items() for cells, text in _merged(said)
    ]
    rows = tuple(
        (
            Cell(subject),
            Cell(_names(cell.label for cell in cells)),
            Cell(
                _names(cell.case for cell in cells),
                len({cell.case for cell in cells}),
            ),
            Cell(text),
        )
        for subject, cells, text in entries
    )
    columns = (
        Column("subject", width=1.0),
        Column("models", width=2.2),
        Column("cases", width=2.0),
        Column("warning", width=3.6),
    )
    table = Table("warnings", "Warnings: the models answered all the same.", columns, rows, 30)
    return [table]


def shear_demand(study: Study, stored: Stored) -> ShearDemand:
    """Largest shear force over the plastic resistance, by case and label."""
    labels = [
        label
        for label in study.models
        if any(stored.number(case.name, label, "shear_utilisation") for case in study.cases)
    ]
    if not labels:
        return ShearDemand(None, "")
    entries = []
    for case in study.cases:
        values = {
            label: value
            for label in labels
            if (value := stored.number(case.name, label, "shear_utilisation")) is not None
        }
        if values:
            entries.append((case.name, values))
    over = [(name, max(values.values())) for name, values in entries if max(values.values()) > 1.0]
    if len(entries) > _PRINTED:
        entries.sort(key=lambda entry: -max(entry[1].values()))
    headline = ""
    if over:
        worst = max(over, key=lambda entry: entry[1])
        outside = [
            label for label in labels if any(values.get(label, 0.0) > 1.0 for _, values in entries)
        ]
        also = ", the reference included," if study.reference in outside else ""
        headline = (
            f"In {len(over)} of {count(len(entries), 'case')} the shear force exceeds the plastic "
            f"shear resistance, up to V/Vpl = {number(worst[1], 3)} ({worst[0]}). There every "
            f"model without shear yielding{also} is outside its domain: agreement between such "
            "models says nothing about a real structure."
        )
    rows = tuple(
        (Cell(name), *(_share(values.get(label)) for label in labels)) for name, values in entries
    )
    columns = (Column("case", width=2.5), *(Column(label, True, 1.2) for label in labels))
    caption = (
        "Largest shear force over the plastic shear resistance, V/Vpl, of the most loaded "
        "segment; a dash where a model did not answer."
    )
    return ShearDemand(Table("shear", caption, columns, rows, _PRINTED), headline)


def _share(value: float | None) -> Cell:
    if value is None:
        return Cell("–", tone="muted")
    return Cell(number(value, 3), value, "bad" if value > 1.0 else "")


def notes(study: Study) -> Section | None:
    """What is reconstructed, inferred or assumed, in the words of the study."""
    if not study.notes:
        return None
    if len(study.notes) == 1:
        return Section("notes", "How to read this report", (Paragraph(study.notes[0]),))
    return Section("notes", "How to read this report", (Bullets(tuple(study.notes)),))
