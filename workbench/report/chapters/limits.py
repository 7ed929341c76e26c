"""What is missing, and where models answered outside their own assumptions."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from workbench.content.formatting import count, number, several, valued
from workbench.content.tree import Block, Bullets, Callout, Cell, Column, Paragraph, Section, Table
from workbench.errors import Collapse
from workbench.report.stored import CellState, Stored
from workbench.responses import Finding, Outcome
from workbench.study.definition import Study
from workbench.study.store import NOT_RUN

_PRINTED = 40
_SIMILAR = 3  # sentences of one kind that are all shown


class _Group(NamedTuple):
    """What several cells say alike: `kind` is what the sentences have in common."""

    kind: tuple[str, ...]
    cells: list[CellState]
    finding: Finding

    def names(self, of: Callable[[CellState], str]) -> Cell:
        """The cases or labels of the cells."""
        names = list(dict.fromkeys(map(of, self.cells)))
        return Cell(several(names), len(names))


def _groups(told: Iterable[tuple[tuple[str, ...], CellState, Finding]]) -> Iterator[_Group]:
    """Cells by what they say; many sentences that differ in their numbers become one example."""
    kinds: dict[tuple[str, ...], dict[str, _Group]] = {}
    for kind, cell, finding in told:
        said = kinds.setdefault(kind, {})
        said.setdefault(finding.text, _Group(kind, [], finding)).cells.append(cell)
    for kind, said in kinds.items():
        groups = list(said.values())
        if len(groups) <= _SIMILAR:
            yield from groups
            continue
        top = max(groups, key=lambda group: abs(group.finding.number or 0.0)).finding
        text = f"{top.text} ({len(groups) - 1} more with other numbers)"
        cells = [cell for group in groups for cell in group.cells]
        yield _Group(kind, cells, replace(top, text=text))


def missing(study: Study, stored: Stored) -> Section:
    """Cells without an answer, grouped by what happened, and what was not asked."""
    problems = [cell for cell in stored.cells.values() if not (cell.ok or cell.collapse)]
    silent = tuple(
        f"{label} (model {study.models[label].name}) does not answer {kind}: {several(names)}."
        for (label, kind), names in study.unasked().items()
    )
    unasked = (Paragraph("Not asked, and no cells:"), Bullets(silent)) if silent else ()
    if not problems:
        text = f"All {count(len(stored.cells), 'cell')} hold an answer"
        text += "." if unasked else "; nothing is missing."
        return Section("missing", "What is missing", (Callout("good", text), *unasked))
    refusals = sum(cell.outcome == Outcome.OUT_OF_DOMAIN for cell in problems)
    failures = len(problems) - refusals
    text = (
        f"{count(len(problems), 'cell')} of {len(stored.cells)} hold no answer: "
        f"{refusals} because the model does not apply, {failures} for another reason."
    )
    columns = (
        Column("model", width=1.5, of=lambda group: group.kind[0]),
        Column("outcome", width=1.1, of=_outcome),
        Column("cases", width=2.0, of=lambda group: group.names(lambda cell: cell.case)),
        Column("what happened and what to do", width=4.0, of=lambda group: group.finding.text),
    )
    groups = _groups(((cell.label, cell.outcome), cell, _reason(cell)) for cell in problems)
    table = Table.of("missing-table", "Cells without an answer.", columns, groups, _PRINTED)
    told = Callout("bad" if failures else "note", text)
    return Section("missing", "What is missing", (told, table, *unasked))


def collapses(stored: Stored) -> Section | None:
    """Where structures do not survive: an answer, with its mechanism, time and place."""
    fallen = [cell for cell in stored.cells.values() if cell.collapse is not None]
    if not fallen:
        return None

    def told(read: Callable[[Collapse], Any]) -> Callable[[CellState], Any]:
        return lambda cell: cell.collapse and read(cell.collapse)

    columns = (
        Column("case", width=2.0, of="case"),
        Column("model", width=1.5, of="label"),
        Column("mechanism", width=1.1, of=told(lambda found: found.mechanism)),
        Column("of", width=1.5, of=told(lambda found: several(found.parts))),
        Column("time in s", True, 0.8, told(lambda found: valued(found.time, 3))),
        Column("displacement in m", True, 0.9, told(lambda found: valued(found.displacement, 3))),
    )
    text = (
        f"In {count(len(fallen), 'cell')} of {len(stored.cells)} the structure collapses, which is "
        "an answer, and no failure of the model; it has no other number."
    )
    caption = "Collapses: how they come about, and where they are recorded."
    table = Table.of("collapses", caption, columns, fallen, _PRINTED)
    return Section("collapses", "Where the structure collapses", (Callout("note", text), table))


def _reason(cell: CellState) -> Finding:
    """Why a cell holds no answer."""
    text = cell.message or "This cell has not been run, or its inputs have changed since."
    # messages begin with the name of the case, which has a column of its own
    return Finding(cell.outcome, text.removeprefix(f"{cell.case}: "))


def _outcome(group: _Group) -> Cell:
    _, outcome = group.kind
    return Cell(outcome, tone="doubt" if outcome in (NOT_RUN, Outcome.OUT_OF_DOMAIN) else "bad")


def domain(study: Study, stored: Stored) -> Section:
    """Warnings of the models, and the shear demand of every case."""
    headline, table = _shear_demand(study, stored)
    blocks = (*headline, *_warnings(stored), *table)
    if not blocks:
        text = "No model reports that a case lies outside its assumptions."
        blocks = (Callout("good", text),)
    return Section("domain", "Where models leave their assumptions", blocks)


def _warnings(stored: Stored) -> Iterator[Table]:
    """The warnings that came with answers, each with its remedy and the number behind it."""
    told = (
        ((finding.subject, finding.remedy), cell, finding)
        for cell in stored.cells.values()
        for finding in cell.warnings
    )
    groups = list(_groups(told))
    columns = (
        Column("subject", width=1.0, of=lambda group: group.finding.subject),
        Column("models", width=1.8, of=lambda group: group.names(lambda cell: cell.label)),
        Column("cases", width=1.7, of=lambda group: group.names(lambda cell: cell.case)),
        Column("warning", width=3.8, of=lambda group: group.finding.text),
        Column("its number", True, 0.7, lambda group: valued(group.finding.number, 3)),
        Column("what to do", width=1.5, of=lambda group: group.finding.remedy),
    )
    caption = "Warnings: the models answered all the same."
    if groups:
        yield Table.of("warnings", caption, columns, groups, 30)


def _shear_demand(study: Study, stored: Stored) -> tuple[tuple[Block, ...], tuple[Block, ...]]:
    """What to say of V/Vpl above one, and its table by case and label, where models state it."""
    known: dict[str, dict[str, float]] = {}
    for (case, label), value in stored.values("shear_utilisation").items():
        known.setdefault(case, {})[label] = value
    entries = list(known.items())
    labels = [label for label in study.models if any(values.get(label) for _, values in entries)]
    if not labels:
        return (), ()
    if len(entries) > _PRINTED:
        entries.sort(key=lambda entry: -max(entry[1].values()))
    columns = (
        Column("case", width=2.5, of=lambda entry: entry[0]),
        *(Column(label, True, 1.2, partial(_demand, label)) for label in labels),
    )
    caption = (
        "Largest shear force over the plastic shear resistance, V/Vpl, of the most loaded "
        "segment; a dash where a model did not answer."
    )
    table = Table.of("shear", caption, columns, entries, _PRINTED)
    over = {name: top for name, values in entries if (top := max(values.values())) > 1.0}
    if not over:
        return (), (table,)
    worst = max(over, key=over.__getitem__)
    outside = any(values.get(study.reference, 0.0) > 1.0 for _, values in entries)
    also = ", the reference included," if outside else ""
    headline = (
        f"In {len(over)} of {count(len(entries), 'case')} the shear force exceeds the plastic "
        f"shear resistance, up to V/Vpl = {number(over[worst], 3)} ({worst}). There every "
        f"model without shear yielding{also} is outside its domain: agreement between such "
        "models says nothing about a real structure."
    )
    return (Callout("doubt", headline),), (table,)


def _demand(label: str, entry: tuple[str, dict[str, float]]) -> Cell:
    value = entry[1].get(label)
    return valued(value, 3, "bad" if value is not None and value > 1.0 else "")


def notes(study: Study) -> Section | None:
    """What is reconstructed, inferred or assumed, in the words of the study."""
    if not study.notes:
        return None
    texts = tuple(study.notes)
    block = Bullets(texts) if len(texts) > 1 else Paragraph(texts[0])
    return Section("notes", "How to read this report", (block,))
