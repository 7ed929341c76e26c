"""What is missing, and where models answered outside their own assumptions."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from workbench.content.formatting import several, valued
from workbench.content.page import Page
from workbench.content.tree import Cell, Column, Section, Table
from workbench.errors import Collapse
from workbench.report.stored import CellState, Stored
from workbench.responses import Finding, Outcome
from workbench.study.definition import Study
from workbench.study.store import NOT_RUN

PAGE = Page(__file__)
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


def _groups(findings: Iterable[tuple[tuple[str, ...], CellState, Finding]]) -> Iterator[_Group]:
    """Cells by what they say; many sentences that differ in their numbers become one example."""
    kinds: dict[tuple[str, ...], dict[str, _Group]] = {}
    for kind, cell, finding in findings:
        alike = kinds.setdefault(kind, {})
        alike.setdefault(finding.text, _Group(kind, [], finding)).cells.append(cell)
    for kind, alike in kinds.items():
        groups = list(alike.values())
        if len(groups) <= _SIMILAR:
            yield from groups
            continue
        worst = max(groups, key=lambda group: abs(group.finding.number or 0.0)).finding
        text = PAGE.words("alike", text=worst.text, others=len(groups) - 1)
        cells = [cell for group in groups for cell in group.cells]
        yield _Group(kind, cells, replace(worst, text=text))


def missing(study: Study, stored: Stored) -> Section | None:
    """Cells without an answer, grouped by what happened, and what was not asked."""
    problems = [cell for cell in stored.cells.values() if not (cell.ok or cell.collapse)]
    refusals = sum(cell.outcome == Outcome.OUT_OF_DOMAIN for cell in problems)
    columns = (
        Column("model", width=1.5, of=lambda group: group.kind[0]),
        Column("outcome", width=1.1, of=_outcome),
        Column("cases", width=2.0, of=lambda group: group.names(lambda cell: cell.case)),
        Column("what happened and what to do", width=4.0, of=lambda group: group.finding.text),
    )
    groups = _groups(((cell.label, cell.outcome), cell, _reason(cell)) for cell in problems)
    return PAGE.section(
        "missing",
        cells=len(stored.cells),
        silent=[
            (label, study.models[label].name, kind, names)
            for (label, kind), names in study.unsupported().items()
        ],
        refusals=refusals,
        failures=len(problems) - refusals,
        table=Table.of("missing-table", "", columns, groups, _PRINTED),
    )


def _reason(cell: CellState) -> Finding:
    """Why a cell holds no answer."""
    return Finding(cell.outcome, cell.message or PAGE.words("not_run"))


def _outcome(group: _Group) -> Cell:
    _, outcome = group.kind
    return Cell(outcome, tone="doubt" if outcome in (NOT_RUN, Outcome.OUT_OF_DOMAIN) else "bad")


def collapses(stored: Stored) -> Section | None:
    """Where structures do not survive: an answer, with its mechanism, time and place."""
    collapsed = [cell for cell in stored.cells.values() if cell.collapse is not None]
    if not collapsed:
        return None

    def of_collapse(read: Callable[[Collapse], Any]) -> Callable[[CellState], Any]:
        return lambda cell: cell.collapse and read(cell.collapse)

    columns = (
        Column("case", width=2.0, of="case"),
        Column("model", width=1.5, of="label"),
        Column("mechanism", width=1.1, of=of_collapse(lambda c: c.mechanism)),
        Column("of", width=1.5, of=of_collapse(lambda c: several(c.parts))),
        Column("time in s", True, 0.8, of_collapse(lambda c: valued(c.time, 3))),
        Column("displacement in m", True, 0.9, of_collapse(lambda c: valued(c.displacement, 3))),
    )
    table = Table.of("collapses", "", columns, collapsed, _PRINTED)
    return PAGE.section("collapses", number=len(collapsed), cells=len(stored.cells), table=table)


def domain(study: Study, stored: Stored) -> Section | None:
    """Warnings of the models, and the shear demand of every case."""
    shear: dict[str, dict[str, float]] = {}
    for (case, label), value in stored.values("shear_utilisation").items():
        shear.setdefault(case, {})[label] = value
    over = {name: top for name, values in shear.items() if (top := max(values.values())) > 1.0}
    worst = max(over, key=over.__getitem__, default="")
    return PAGE.section(
        "domain",
        over=len(over),
        cases=len(shear),
        worst=worst,
        ratio=over.get(worst),
        reference_too=any(values.get(study.reference, 0.0) > 1.0 for values in shear.values()),
        shear=_shear_table(study, shear),
        warnings=_warnings(stored),
    )


def _warnings(stored: Stored) -> Table | None:
    """The warnings that came with answers, each with its remedy and the number behind it."""
    groups = list(
        _groups(
            ((finding.subject, finding.remedy), cell, finding)
            for cell in stored.cells.values()
            for finding in cell.warnings
        )
    )
    columns = (
        Column("subject", width=1.0, of=lambda group: group.finding.subject),
        Column("models", width=1.8, of=lambda group: group.names(lambda cell: cell.label)),
        Column("cases", width=1.7, of=lambda group: group.names(lambda cell: cell.case)),
        Column("warning", width=3.8, of=lambda group: group.finding.text),
        Column("its number", True, 0.7, lambda group: valued(group.finding.number, 3)),
        Column("what to do", width=1.5, of=lambda group: group.finding.remedy),
    )
    return Table.of("warnings", "", columns, groups, 30) if groups else None


def _shear_table(study: Study, shear: dict[str, dict[str, float]]) -> Table | None:
    """V/Vpl by case and label, where models state it."""
    entries = list(shear.items())
    labels = [label for label in study.models if any(values.get(label) for _, values in entries)]
    if len(entries) > _PRINTED:
        entries.sort(key=lambda entry: -max(entry[1].values()))
    columns = (
        Column("case", width=2.5, of=lambda entry: entry[0]),
        *(Column(label, True, 1.2, partial(_ratio, label)) for label in labels),
    )
    return Table.of("shear", "", columns, entries, _PRINTED) if labels else None


def _ratio(label: str, entry: tuple[str, dict[str, float]]) -> Cell:
    value = entry[1].get(label)
    return valued(value, 3, "bad" if value is not None and value > 1.0 else "")


def notes(study: Study) -> Section | None:
    """What is reconstructed, inferred or assumed, in the words of the study."""
    return PAGE.section("notes", notes=list(study.notes)) if study.notes else None
