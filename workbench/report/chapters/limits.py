"""What is missing, and where models answered outside their own assumptions."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from workbench.content.formatting import several, valued
from workbench.content.page import Page
from workbench.content.tree import Cell, Column, Section, Table
from workbench.report.stored import CellState, Stored
from workbench.responses import Finding, Outcome
from workbench.study.definition import Study
from workbench.study.store import NOT_RUN

_PRINTED = 40
PAGE = Page(__file__, printed=_PRINTED, mild=(NOT_RUN, Outcome.OUT_OF_DOMAIN))
_SIMILAR = 3  # sentences of one kind that are all shown


class _Group(NamedTuple):
    """What several cells say alike: `kind` is what the sentences have in common."""

    kind: tuple[str, ...]
    cells: list[CellState]
    finding: Finding

    @property
    def cases(self) -> Cell:
        """The cases of the cells."""
        return _names(cell.case for cell in self.cells)

    @property
    def labels(self) -> Cell:
        """The labels of the cells."""
        return _names(cell.label for cell in self.cells)


def _names(names: Iterable[str]) -> Cell:
    distinct = list(dict.fromkeys(names))
    return Cell(several(distinct), len(distinct))


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
    return PAGE.section(
        "missing",
        cells=len(stored.cells),
        silent=[
            (label, study.models[label].name, kind, names)
            for (label, kind), names in study.unsupported().items()
        ],
        refusals=refusals,
        failures=len(problems) - refusals,
        groups=list(_groups(((c.label, c.outcome), c, _reason(c)) for c in problems)),
    )


def _reason(cell: CellState) -> Finding:
    """Why a cell holds no answer."""
    return Finding(cell.outcome, cell.message or PAGE.words("not_run"))


def collapses(stored: Stored) -> Section | None:
    """Where structures do not survive: an answer, with its mechanism, time and place."""
    collapsed = [cell for cell in stored.cells.values() if cell.collapse is not None]
    return PAGE.section("collapses", collapsed=collapsed, cells=len(stored.cells))


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
        warnings=list(
            _groups(
                ((finding.subject, finding.remedy), cell, finding)
                for cell in stored.cells.values()
                for finding in cell.warnings
            )
        ),
    )


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
