"""Assessing a stored study: tables of cells, comparisons, ladders and verdicts. Never simulates."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import nan
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from workbench.base.errors import Collapse, InputError, Mechanism
from workbench.base.tables import plain_rows
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    collapse_of,
    energy_error,
    error_of,
    findings_of,
    scalars_of,
)
from workbench.responses.histories import SCALARS, TIMES
from workbench.responses.outcome import SYNTHETIC
from workbench.study.assessment.gates import GateVerdict, Verdict
from workbench.study.cells import StudyCell, as_answered, cells_of
from workbench.study.chooser import derived_tables
from workbench.study.comparisons import (
    LADDER_COLUMNS,
    CaseAnswers,
    comparison_rows,
    ladder_row,
    of_side,
)
from workbench.study.definition import Study, varied_case
from workbench.study.store import NOT_RUN, UNREADABLE, Record, Store
from workbench.study.tables import (
    Columns,
    GrowingTable,
    Row,
    Tables,
    counts,
    lists,
    numbers,
    read_table,
    table,
    tabled,
    texts,
    write_table,
)
from workbench.study.validation import validation
from workbench.study.verdicts import (
    REFERENCE_COLUMNS,
    gates,
    outside,
    reference_row,
    verdict_table,
    verdicts_of,
)

K = TypeVar("K")
ERROR = ("expected", "low", "high", "chance")  # of the error to expect, what cells hold
_CELL = (
    texts("case", "label", "model")
    | counts("model_version")
    | texts("outcome", "message")
    | numbers("wall_time", "solve_time")
)
# of a cell: `outside`, how many warnings of physics place it outside the domain; `warned`, how many
# warn of the error to expect; `cold`, whether its times may hold compilation
_DERIVED = (
    numbers("shear_utilisation", "energy_error")
    | counts("outside", "warned", "cold")
    | texts("collapse_mechanism")
    | lists("collapse_parts")
    | numbers(*(f"error_{name}" for name in ERROR))
    | numbers("collapse_displacement", "collapse_time")
    | texts("key")
)
_FINDING = (
    texts("case", "label", "model", "subject", "severity", "sentence", "remedy")
    | numbers("number", "limit")
    | lists("instead")
)
_COMPARISON = (
    texts("model", "against", "quantity", "metric")
    | numbers("value", "against_value", "error", "uncertainty")
    | texts("note")
    | numbers("low", "high")
)
_LADDER = texts("case", "quantity")
_BUDGET = (
    texts("case", "label", "form", "quantity")
    | numbers("value")
    | texts("term")
    | numbers("shift", "low", "high", "least", "most")
    | texts("reason", "source")
)


_TABLES = (
    *("cells", "findings", "comparisons", "ladder", "gates", "verdicts", "bias"),
    *("references", "validation", "matrix", "cost", "budget", "ranking"),
    *("error-cells", "coverage", "chooser"),
)
MOST = 3 * 10**7  # bytes of responses that an assessment keeps
BEST = "the best reference"  # stands for the governing one of a case


class Read(dict[str, Response]):
    """Responses by key: as many as `MOST` bytes hold; others are read again when asked for."""

    def __init__(self, store: Store) -> None:
        super().__init__()
        self.room, self.again = MOST, lru_cache(64)(store.response)

    def kept(self, key: str, response: Response) -> str:
        """The key of a response, which is kept as long as there is room."""
        if self.room > 0 and key not in self:
            self[key] = response
            self.room -= response.nbytes
        return key

    def __missing__(self, key: str) -> Response:
        return self.again(key)


@dataclass(frozen=True)
class Recalled(Mapping[K, Response]):
    """Responses by what they answer, of which only the keys are held."""

    key_of: Mapping[K, str]
    read: Read

    def __getitem__(self, what: K) -> Response:
        return self.read[self.key_of[what]]

    def __iter__(self) -> Iterator[K]:
        return iter(self.key_of)

    def __len__(self) -> int:
        return len(self.key_of)


@dataclass(frozen=True)
class CellState:
    """How one cell ended: `outcome` (or `NOT_RUN`), its `message`, its `findings`, its numbers.

    `numbers` holds the scalar quantities in SI, `wall_time` (s), `shear_utilisation` and
    `energy_error`, as far as the model knows them; `collapse`, how the structure collapses, if it
    does.
    """

    case: str
    label: str
    outcome: str = NOT_RUN
    message: str = ""
    findings: tuple[Finding, ...] = ()
    numbers: dict[str, float] = field(default_factory=dict)
    key: str = ""
    collapse: Collapse | None = None

    @property
    def ok(self) -> bool:
        """Whether the model answered with numbers."""
        return self.outcome == Outcome.OK

    @property
    def outside(self) -> tuple[Finding, ...]:
        """The warnings of physics, which place the case outside the domain of the model."""
        return tuple(f for f in self.findings if f.outside and not f.expects_error)


@dataclass(frozen=True)
class Assessment:
    """An assessed study: its `tables`, data frames by name, and the answers of its cells.

    Arguments: `directory` of the store, where the tables stand too; the `study`; the `verdicts`;
    `responses` by keys of cells, as far as they have been read. Others are read when asked for.
    """

    directory: Path
    study: Study
    tables: Tables
    verdicts: tuple[GateVerdict, ...] = ()
    responses: dict[str, Response] = field(default_factory=dict, repr=False, compare=False)

    @property
    def failed(self) -> bool:
        """Whether a gate failed."""
        return any(judged.verdict is Verdict.FAIL for judged in self.verdicts)

    @cached_property
    def cells(self) -> dict[tuple[str, str], CellState]:
        """Every cell of the study by (case, label), in the order of the study."""
        known = {(row["case"], row["label"]): row for row in plain_rows(self.tables["cells"])}
        findings: dict[tuple[str, str], list[Finding]] = {}
        for row in plain_rows(self.tables["findings"]):
            findings.setdefault((row["case"], row["label"]), []).append(Finding.from_dict(row))
        cells = {}
        for key in ((case.name, label) for case, label in self.study.cells()):
            cells[key] = CellState(*key)
            if key in known:
                row = known[key]
                values = {n: float(v) for n, v in row.items() if isinstance(v, (int, float))}
                outcome = row["outcome"], row["message"]
                of_cell = tuple(findings.get(key, ()))
                cells[key] = CellState(*key, *outcome, of_cell, values, row["key"], _collapse(row))
        return cells

    @cached_property
    def costs(self) -> dict[str, float]:
        """Time of each label over that of the reference, as far as it is known."""
        return dict(self.tables["cost"].set_index("label")["ratio"])

    @cached_property
    def synthetic(self) -> bool:
        """Whether a cell holds made numbers, which validate nothing."""
        return bool((self.tables["findings"]["subject"] == SYNTHETIC).any())

    def expects(self, case: str, label: str) -> bool:
        """Whether a label is to answer a case."""
        return (case, label) in self.cells

    def ok(self, case: str, label: str) -> bool:
        """Whether a label answered a case with numbers."""
        return self.expects(case, label) and self.cells[case, label].ok

    def collapses(self, case: str, label: str) -> bool:
        """Whether the structure of a label collapses in a case."""
        return self.expects(case, label) and self.cells[case, label].collapse is not None

    def number(self, case: str, label: str, name: str) -> float | None:
        """A scalar of a cell, None if the model did not answer or cannot know it."""
        cell = self.cells.get((case, label))
        return None if cell is None else cell.numbers.get(name)

    def values(self, name: str) -> dict[tuple[str, str], float]:
        """A scalar by (case, label), of all cells that know it, in the order of the study."""
        return {key: cell.numbers[name] for key, cell in self.cells.items() if name in cell.numbers}

    def response(self, case: str, label: str, *, keep: bool = True) -> Response | None:
        """The response of a cell that answered, else None; `keep`, for those who ask again."""
        if not self.ok(case, label):
            return None
        key = self.cells[case, label].key
        response = self.responses.pop(key, None)
        if response is None:
            response = Store(self.directory).response(key)
        if keep:
            self.responses[key] = response
        return response

    def answer_tables(self, case: str, label: str) -> dict[str, pd.DataFrame]:
        """The tables of a stored answer to a question on studs; empty for others."""
        from workbench.studs.model import tables_of

        response = self.response(case, label)
        return {} if response is None else tables_of(response)

    def records(self, name: str, **values: Any) -> list[dict[str, Any]]:
        """Rows of a table whose columns have these values; numbers that are absent are None."""
        table = self.tables[name]
        for column, value in values.items():
            table = table[table[column] == value]
        return plain_rows(table)

    def errors(self, quantity: str, metric: str, against: str) -> dict[tuple[str, str], Row]:
        """Comparisons of one quantity by one metric, by (case, label).

        `against`: one label, or `BEST`: the governing reference of each case.
        """
        rows = self.records("comparisons", quantity=quantity, metric=metric)
        return {
            (row["case"], row["model"]): row
            for row in rows
            if row["against"] == self.held_against(row["case"], against)
        }

    def held_against(self, case: str, against: str) -> str:
        """The label that others are held against in a case; empty if no reference answered."""
        return self._governing.get(case, "") if against == BEST else against

    @cached_property
    def _governing(self) -> dict[str, str]:
        """The governing reference of each case."""
        return dict(self.tables["references"].set_index("case")["label"])

    def ladder(self, case: str, quantity: str) -> dict[str, Any] | None:
        """The row of the ladder table for a case and quantity."""
        return next(iter(self.records("ladder", case=case, quantity=quantity)), None)

    @cached_property
    def provenance(self) -> list[dict[str, str]]:
        """The different provenance records of the stored cells, in a fixed order."""
        store = Store(self.directory)
        run = (cell.key for cell in self.cells.values() if cell.outcome != NOT_RUN)
        records = {tuple(sorted(store.record(key).get("provenance", {}).items())) for key in run}
        return [dict(record) for record in sorted(records)]


def _collapse(row: Row) -> Collapse | None:
    """The collapse in a row of the table of cells."""
    if row["outcome"] != Outcome.COLLAPSE:
        return None
    mechanism, parts, *numbers = (row[f"collapse_{name}"] for name in Collapse._fields)
    return Collapse(Mechanism(mechanism), tuple(parts), *numbers)


def read_assessment(directory: Path, study: Study) -> Assessment:
    """The assessment of a study as it is stored in a directory.

    Raises `InputError` if the study has not been run and assessed.
    """
    try:
        tables = {name: read_table(directory / "tables" / name) for name in _TABLES}
    except UNREADABLE as error:
        text = f"has no readable table in its store: {error}"
        raise InputError("study", study.name, text, "run it first") from error
    return Assessment(directory, study, tables)


def assessment_of(study: Study, responses: Mapping[str, Response]) -> Assessment:
    """The answers at hand to the only case of a study, by label: their numbers and findings."""
    (case,) = study.cases
    answers = CaseAnswers(study, case, tuple(responses), responses)
    cells = (
        {"case": case.name, "label": label, "key": label, **numbers_of(response, {})}
        for label, response in responses.items()
    )
    tables = {
        "cells": table(cells, {**_CELL, **numbers(*SCALARS), **_DERIVED}),
        "findings": table(_finding_rows(answers), _FINDING),
        "comparisons": table((), {**texts("case"), **_COMPARISON}),
        "ladder": table((), {**_LADDER, **LADDER_COLUMNS}),
    }
    return Assessment(Path(), study, tables, responses=dict(responses))


def assess(study: Study, root: Path, *, earlier: bool = False) -> Assessment:
    """Compare what is stored under ``root/<study name>`` and write the tables there.

    Cells that are not stored count as not run. Arguments: `study` (in its quick form, if that is
    what was run); `root`, the directory of all stores; `earlier`: answers of other versions of a
    model count where there is none of this one. Raises `InputError` if nothing has been
    stored yet or a parameter of the study has the name of a column.
    """
    store = Store(Path(root) / study.name)
    cells = cells_of(study)
    if not store.keys():
        advice = f"run it first: workbench run {study.name}"
        raise InputError("study", study.name, "has no stored cells yet", advice)
    cells = as_answered(cells, store) if earlier else cells
    parameters = _parameters(study)
    for name in parameters:
        if name in {**_CELL, **_COMPARISON, **dict.fromkeys(SCALARS), "key": ""}:
            raise InputError("case.parameters", name, "is the name of a column", "rename it")
    by_case: dict[str, dict[str, StudyCell]] = {case.name: {} for case in study.cases}
    for cell in cells:
        by_case.setdefault(cell.case, {})[cell.label] = cell
    scalars = numbers(*SCALARS, *map(width_of, study.quantities))
    rows = GrowingTable({**_CELL, **parameters, **scalars, **_DERIVED})
    found, governing = GrowingTable(_FINDING), GrowingTable(REFERENCE_COLUMNS)
    comparisons = GrowingTable({**texts("case"), **parameters, **_COMPARISON})
    ladders = GrowingTable({**_LADDER, **numbers(*study.steps), **LADDER_COLUMNS})
    answers, read, runs = [], Read(store), dict[tuple[str, str], str]()
    for case in study.cases:  # all that histories tell while they are at hand
        of_case = by_case[case.name]
        stored = {n: store.answer(c.key, c.ingredients) for n, c in of_case.items()}
        both = {label: answer for label, answer in stored.items() if answer is not None}
        records = {label: record for label, (record, _) in both.items()}
        at_hand = {label: response for label, (_, response) in both.items()}
        each = CaseAnswers(study, case, tuple(of_case), at_hand)
        rows += (_cell_row(each, cell, records.get(n)) for n, cell in of_case.items())
        found += _finding_rows(each)
        governing += [best := reference_row(each)]
        comparisons += comparison_rows(each, best.get("label"))
        ladders += filter(None, (ladder_row(each, quantity) for quantity in study.quantities))
        keys = {label: read.kept(of_case[label].key, r) for label, r in at_hand.items()}
        answers.append(replace(each, responses=Recalled(keys, read)))
        runs |= {(case.name, label): key for label, key in keys.items()}
    for cell in cells:  # variations of budgets, of cases that the study does not name
        what = (cell.case, cell.label)
        if what not in runs and (answer := store.answer(cell.key, cell.ingredients)):
            runs[what] = read.kept(cell.key, answer[1])
    verdicts = verdicts_of(study, answers)
    tables = {
        "cells": rows.table,
        "findings": found.table,
        "references": governing.table,
        "comparisons": comparisons.table,
        "ladder": ladders.table,
        "gates": gates(verdicts),
        "verdicts": verdict_table(verdicts),
        "validation": validation(study, answers),
        "budget": _budget(study, Recalled(runs, read)),
    }
    tables |= derived_tables(study, tables)
    store.prepare()
    for name, content in tables.items():
        write_table(store.tables / name, content)
    return Assessment(store.directory, study, tables, verdicts, read)


def _parameters(study: Study) -> Columns:
    """Columns of the parameters of cases: numbers, or texts where one is none."""
    values: dict[str, list[Any]] = {}
    for case in study.cases:
        for name, value in case.parameters.items():
            values.setdefault(name, []).append(value)
    return {
        name: nan if all(isinstance(value, Real) for value in of) else ""
        for name, of in values.items()
    }


def _cell_row(answers: CaseAnswers, cell: StudyCell, record: Record | None) -> Row:
    """Row of a cell in the table of cells; `record`, where it is stored."""
    row: dict[str, Any] = {"case": cell.case, "label": cell.label, "model": cell.model.name}
    row |= {"model_version": cell.version, "outcome": NOT_RUN, "key": cell.key}
    if record is not None:
        row |= numbers_of(answers.responses[cell.label], record)
    return {**row, **answers.case.parameters, **_widths(answers, cell.label)}


def _finding_rows(answers: CaseAnswers) -> Iterator[Row]:
    """A row for every finding of an answer."""
    for label, response in answers.responses.items():
        who = {"case": answers.case.name, "label": label, "model": answers.study.models[label].name}
        yield from ({**who, **finding.as_dict()} for finding in findings_of(response))


def numbers_of(response: Response, record: Record) -> Row:
    """Numbers of an answer in the table of cells."""
    warnings = outside(response)
    warned = sum(each.expects_error for each in warnings)
    row: dict[str, object] = {
        "outcome": response.attrs["outcome"],
        "message": response.attrs["message"],
        **{name: record.get(name) for name in TIMES},
        **scalars_of(response),
        "energy_error": energy_error(response),
        "outside": len(warnings) - warned,
        "warned": warned,
        "cold": int(record.get("cold", False)),
    }
    if "shear_utilisation" in response:
        row["shear_utilisation"] = float(response["shear_utilisation"].max())
    error = error_of(response)
    row |= {f"error_{name}": getattr(error, name) for name in ERROR}
    collapse = collapse_of(response)
    if collapse is not None:
        row |= {f"collapse_{name}": value for name, value in collapse._asdict().items()}
    return row


def width_of(quantity: str) -> str:
    """Column of the table of cells that holds the half-width of a scalar."""
    return f"{quantity}_uncertainty"


def _widths(answers: CaseAnswers, label: str) -> Row:
    """How well the scalars of an answer are known, where refinement or its data say so."""
    response = answers.ok(label)
    known = [q for q in answers.study.quantities if response is not None and q in response]
    return {width_of(q): width for q in known if (width := of_side(answers, label, q)[0])}


@tabled(_BUDGET)
def _budget(study: Study, runs: Mapping[tuple[str, str], Response]) -> Iterator[Row]:
    """A row for every term and sum of every budget, per label, form and quantity.

    Arguments: `runs`, answers by case and label.
    """
    for budget in study.budgets:
        scenario: Any = next(case.scenario for case in study.cases if case.name == budget.case)
        names = {key: varied_case(budget.case, key) for key in budget.variations(scenario)}
        for label in budget.models:
            if (budget.case, label) not in runs:
                continue
            response = runs[budget.case, label]
            varied = {k: runs[name, label] for k, name in names.items() if (name, label) in runs}
            who = {"case": budget.case, "label": label}
            yield from ({**who, **row} for row in budget.rows(scenario, response, varied))
