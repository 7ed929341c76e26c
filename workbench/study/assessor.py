"""Assessing a stored study: tables of cells, comparisons, ladders and verdicts. Never simulates."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from math import nan
from numbers import Real
from pathlib import Path
from typing import Any

from workbench.base.errors import InputError
from workbench.responses import (
    Response,
    collapse_of,
    energy_error,
    findings_of,
    scalars_of,
)
from workbench.responses.histories import SCALARS, TIMES
from workbench.study.assessment.gates import GateVerdict, Verdict
from workbench.study.cells import StudyCell, as_answered, cells_of
from workbench.study.chooser import (
    BIAS_COLUMNS,
    COST_COLUMNS,
    MATRIX_COLUMNS,
    RANKING_COLUMNS,
    bias_rows,
    cost_rows,
    error_tables,
    matrix_rows,
    ranking_rows,
)
from workbench.study.comparisons import (
    LADDER_COLUMNS,
    CaseAnswers,
    comparison_rows,
    ladder_row,
    of_side,
)
from workbench.study.definition import Study, varied_case
from workbench.study.store import NOT_RUN, Record, Store
from workbench.study.tables import (
    Columns,
    Row,
    Tables,
    counts,
    lists,
    numbers,
    table,
    texts,
    write_table,
)
from workbench.study.validation import VALIDATION_COLUMNS, validation_rows
from workbench.study.verdicts import (
    GATE_COLUMNS,
    REFERENCE_COLUMNS,
    VERDICT_COLUMNS,
    gate_rows,
    outside,
    reference_row,
    verdict_row,
    verdicts_of,
)

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
_BUDGET = (
    texts("case", "label", "form", "quantity")
    | numbers("value")
    | texts("term")
    | numbers("shift", "low", "high", "least", "most")
    | texts("reason", "source")
)


@dataclass(frozen=True)
class Assessment:
    """All `tables` by name, as stored under `directory`, and the `verdicts`.

    `responses`, what was read of the store, by keys of cells: a report need not read it again.
    """

    directory: Path
    tables: Tables
    verdicts: tuple[GateVerdict, ...]
    responses: dict[str, Response] = field(default_factory=dict, repr=False)

    @property
    def failed(self) -> bool:
        """Whether a gate failed."""
        return any(judged.verdict is Verdict.FAIL for judged in self.verdicts)


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
    records: dict[str, Record] = {}
    responses: dict[str, Response] = {}
    by_case: dict[str, list[StudyCell]] = {}
    for cell in cells:
        by_case.setdefault(cell.case, []).append(cell)
        answer = None if cell.key in responses else store.answer(cell.key, cell.ingredients)
        if answer is not None:
            records[cell.key], responses[cell.key] = answer
    given = []
    for case in study.cases:
        cells_by_label = {cell.label: cell for cell in by_case.get(case.name, [])}
        answered = {
            label: responses[cell.key]
            for label, cell in cells_by_label.items()
            if cell.key in responses
        }
        given.append(CaseAnswers(study, case, tuple(cells_by_label), answered))
    tables = {
        "cells": table(
            (
                _cell_row(answers, cell, records.get(cell.key))
                for answers in given
                for cell in by_case.get(answers.case.name, [])
            ),
            {
                **{**_CELL, **parameters, **numbers(*SCALARS, *map(width_of, study.quantities))},
                **_DERIVED,
            },
        ),
        "findings": table((row for answers in given for row in _finding_rows(answers)), _FINDING),
        "references": table(map(reference_row, given), REFERENCE_COLUMNS),
    }
    verdicts = verdicts_of(study, given)
    best = tables["references"]["label"]
    comparisons = map(comparison_rows, given, best)
    ladders = (ladder_row(answers, q) for answers in given for q in study.quantities)
    tables |= {
        "comparisons": table(chain(*comparisons), {**texts("case"), **parameters, **_COMPARISON}),
        "ladder": table(
            filter(None, ladders),
            {**texts("case", "quantity"), **numbers(*study.steps), **LADDER_COLUMNS},
        ),
        "gates": table(gate_rows(verdicts), GATE_COLUMNS),
        "verdicts": table(map(verdict_row, verdicts), VERDICT_COLUMNS),
        "validation": table(validation_rows(study, given), VALIDATION_COLUMNS),
        "budget": table(_budget_rows(study, cells, responses), _BUDGET),
    }
    derived: dict[str, tuple[Callable[[Study, Tables], Iterable[Row]], Columns]] = {
        "bias": (bias_rows, BIAS_COLUMNS),
        "matrix": (matrix_rows, MATRIX_COLUMNS),
        "cost": (cost_rows, COST_COLUMNS),
        "ranking": (ranking_rows, RANKING_COLUMNS),
    }
    for name, (rows, columns) in derived.items():
        tables[name] = table(rows(study, tables), columns)
    tables |= error_tables(study, tables)
    store.prepare()
    for name, each in tables.items():
        write_table(store.tables / name, each)
    return Assessment(store.directory, tables, verdicts, responses)


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
    for label, response in answers.responses.items():
        who = {"case": answers.case.name, "label": label}
        model = answers.study.models[label].name
        yield from ({**who, "model": model, **f.as_dict()} for f in findings_of(response))


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
    error = json.loads(response.attrs.get("error", "{}"))
    row |= {f"error_{name}": error.get(name) for name in ERROR}
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


def _budget_rows(
    study: Study, cells: Sequence[StudyCell], read: Mapping[str, Response]
) -> Iterator[Row]:
    """A row for every term and sum of every budget, per label, form and quantity."""
    runs = {(cell.case, cell.label): read[cell.key] for cell in cells if cell.key in read}
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
