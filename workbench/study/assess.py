"""Assessing a stored study: tables of cells, comparisons, ladders and verdicts. Never simulates.

The verdict of a gate counts all cases that are asked; the rule itself stands in `assessment/gates`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from workbench.assessment import METRICS
from workbench.assessment.budget import COLUMNS as TERM_COLUMNS
from workbench.assessment.gates import CaseVerdict, Gate, GateVerdict, Verdict, judge
from workbench.errors import Collapse, InputError
from workbench.responses import (
    Outcome,
    Response,
    collapse_of,
    energy_error,
    findings_of,
    outcome_of,
    scalars_of,
    survives,
)
from workbench.responses.outcome import COLUMNS as FINDING_COLUMNS
from workbench.responses.variables import SCALARS, TIMES
from workbench.study.cells import Cell, cells_of
from workbench.study.comparisons import (
    LADDER_COLUMNS,
    Answers,
    compare,
    comparison_rows,
    ladder_row,
    of_side,
)
from workbench.study.definition import Study, varied_case
from workbench.study.manifest import as_answered
from workbench.study.matrix import COST_COLUMNS, MATRIX_COLUMNS, cost_rows, matrix_rows, pooled
from workbench.study.standing import STANDING_COLUMNS, doubted, outside, standing_row
from workbench.study.store import NOT_RUN, Record, Row, Store, csv_bytes, write_atomically
from workbench.study.validation import VALIDATION_COLUMNS, validation_rows
from workbench.study.validity import ADVICE_COLUMNS, RANKING_COLUMNS, advice_rows, ranking_rows

_CELL = ("case", "label", "model", "model_version", "outcome", "message", "wall_time")
_COMPARISON = (
    *("model", "against", "quantity", "metric", "value", "against_value", "error"),
    *("uncertainty", "note", "low", "high"),
)
_BIAS = (
    *("model", "against", "quantity", "count", "bias", "low", "high", "uncertainty"),
    *("model_scatter", "note"),
)
_GATE = ("number", "gate", "model", "against", "quantity", "metric")
_JUDGED = ("case", "value", "uncertainty", "low", "high", "collapsed", "bound")
CASE_COLUMNS = (*_GATE, *_JUDGED, "verdict", "note", "doubt")
VERDICT_COLUMNS = (
    *(*_GATE, "verdict", "asked", *(verdict.value for verdict in Verdict), "collapses"),
    *(*_JUDGED, "reasons", "rationale", "source"),
)
COLLAPSE = tuple(f"collapse_{name}" for name in Collapse._fields)
# of a cell: `outside`, how many warnings place it outside the domain; `cold`, whether its times may
# hold compilation
_DERIVED = ("shear_utilisation", "energy_error", "outside", "cold")
BUDGET_COLUMNS = ("case", "label", "quantity", "value", *TERM_COLUMNS)
_FEWEST_FOR_BIAS = 3  # cases


@dataclass(frozen=True)
class Assessment:
    """The rows of all `tables` by name, as stored under `directory`, and the `verdicts`.

    `responses`, what was read of the store, by keys of cells: a report need not read it again.
    """

    directory: Path
    tables: Mapping[str, Sequence[Row]]
    verdicts: tuple[GateVerdict, ...]
    responses: dict[str, Response] = field(default_factory=dict, repr=False)

    @property
    def failed(self) -> bool:
        """Whether a gate failed."""
        return any(found.verdict is Verdict.FAIL for found in self.verdicts)


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
    names = list(dict.fromkeys(name for case in study.cases for name in case.parameters))
    for name in names:
        if name in {*_CELL, *TIMES, *_COMPARISON, *SCALARS, "key"}:
            raise InputError("case.parameters", name, "is the name of a column", "rename it")
    rows: dict[str, list[Row]] = {"cells": [], "findings": []}
    records: dict[str, Record] = {}
    read: dict[str, Response] = {}
    given = []
    by_case: dict[str, list[Cell]] = {}
    for cell in cells:
        by_case.setdefault(cell.case, []).append(cell)
        answer = None if cell.key in read else store.answer(cell.key, cell.ingredients)
        if answer is not None:
            records[cell.key], read[cell.key] = answer
    for case in study.cases:
        responses: dict[str, Response] = {}
        of_case: list[Row] = []
        asked = by_case.get(case.name, [])
        for cell in asked:
            who = {"case": cell.case, "label": cell.label, "model": cell.model.name}
            row = {**who, "model_version": cell.version, "outcome": NOT_RUN, "key": cell.key}
            if (response := read.get(cell.key)) is not None:
                responses[cell.label] = response
                row |= _numbers(response, records[cell.key])
                rows["findings"] += [{**who, **f.as_dict()} for f in findings_of(response)]
            of_case.append({**row, **case.parameters})
        given.append(Answers(study, case, tuple(cell.label for cell in asked), responses))
        rows["cells"] += [{**row, **_widths(given[-1], str(row["label"]))} for row in of_case]
    verdicts = verdicts_of(study, given)
    rows["references"] = [standing_row(answers) for answers in given]
    rows["comparisons"] = [
        row
        for answers, standing in zip(given, rows["references"], strict=True)
        for row in comparison_rows(answers, standing.get("label"))
    ]
    ladders = (ladder_row(answers, q) for answers in given for q in study.quantities)
    rows["ladder"] = [row for row in ladders if row]
    rows["gates"] = [{**_columns(v), **asdict(case)} for v in verdicts for case in v.cases]
    rows["verdicts"] = [verdict_row(found) for found in verdicts]
    rows["bias"] = list(_bias_rows(rows["comparisons"], study.reference))
    rows["validation"] = list(validation_rows(study, given))
    rows["matrix"] = list(matrix_rows(study, rows))
    rows["cost"] = list(cost_rows(study, rows))
    rows["ranking"] = list(ranking_rows(study, rows))
    rows["advice"] = list(advice_rows(study, rows))
    rows["budget"] = list(_budget_rows(study, cells, read))
    columns = {
        "cells": (
            *(*_CELL, "solve_time", *names, *SCALARS, *map(width_of, study.quantities)),
            *(*_DERIVED, *COLLAPSE, "key"),
        ),
        "findings": ("case", "label", "model", *FINDING_COLUMNS),
        "comparisons": ("case", *names, *_COMPARISON),
        "ladder": ("case", "quantity", *study.steps, *LADDER_COLUMNS),
        "gates": CASE_COLUMNS,
        "verdicts": VERDICT_COLUMNS,
        "bias": _BIAS,
        "references": STANDING_COLUMNS,
        "validation": VALIDATION_COLUMNS,
        "matrix": MATRIX_COLUMNS,
        "cost": COST_COLUMNS,
        "ranking": RANKING_COLUMNS,
        "advice": ADVICE_COLUMNS,
        "budget": BUDGET_COLUMNS,
    }
    store.prepare()
    for name, table in rows.items():
        write_atomically(store.tables / f"{name}.csv", csv_bytes(table, columns[name]))
    return Assessment(store.directory, rows, verdicts, read)


def _numbers(response: Response, record: Record) -> Row:
    """What the table of cells says of an answer."""
    row: dict[str, object] = {
        "outcome": response.attrs["outcome"],
        "message": response.attrs["message"],
        **{name: record.get(name) for name in TIMES},
        **scalars_of(response),
        "energy_error": energy_error(response),
        "outside": len(outside(response)),
        "cold": int(record.get("cold", False)),
    }
    if "shear_utilisation" in response:
        row["shear_utilisation"] = float(response["shear_utilisation"].max())
    collapse = collapse_of(response)
    if collapse is not None:
        row |= zip(COLLAPSE, collapse, strict=True)
    return row


def width_of(quantity: str) -> str:
    """Column of the table of cells that holds the half-width of a scalar."""
    return f"{quantity}_uncertainty"


def _widths(answers: Answers, label: str) -> Row:
    """How well the scalars of an answer are known, where refinement or its data say so."""
    response = answers.ok(label)
    known = [q for q in answers.study.quantities if response is not None and q in response]
    return {width_of(q): width for q in known if (width := of_side(answers, label, q)[0])}


def _bias_rows(comparisons: Sequence[Row], reference: str) -> Iterator[Row]:
    """Bias and scatter of every model against the reference over the cases, per quantity."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in comparisons:
        asked = row["against"] == reference and row["metric"] == "relative_error"
        if asked and row["value"] > 0.0 and row["against_value"] > 0.0:
            groups.setdefault((row["model"], row["quantity"]), []).append(row)
    for (model, quantity), rows in groups.items():
        if len(rows) < _FEWEST_FOR_BIAS:
            continue
        yield {"model": model, "against": reference, "quantity": quantity, **pooled(rows)}


def _budget_rows(
    study: Study, cells: Sequence[Cell], read: Mapping[str, Response]
) -> Iterator[Row]:
    """A row for every term and sum of every budget, per label and quantity."""
    runs = {(cell.case, cell.label): read[cell.key] for cell in cells if cell.key in read}
    for budget in study.budgets:
        scenario: Any = next(case.scenario for case in study.cases if case.name == budget.case)
        names = {key: varied_case(budget.case, key) for key in budget.variations(scenario)}
        for label in budget.models:
            if (budget.case, label) not in runs:
                continue
            response = runs[budget.case, label]
            varied = {k: runs[name, label] for k, name in names.items() if (name, label) in runs}
            by_quantity = budget.terms(study.models[label], scenario, response, varied)
            for quantity, terms in by_quantity.items():
                who = {"case": budget.case, "label": label, "quantity": quantity}
                value = float(response[quantity])
                yield from ({**who, "value": value, **term.as_dict(value)} for term in terms)


def verdicts_of(study: Study, answers: Sequence[Answers]) -> tuple[GateVerdict, ...]:
    """The verdict of every gate, from the answers of all cases of the study."""
    verdicts = []
    for number, gate in enumerate(study.gates, 1):
        both = {gate.model, gate.against}
        named = {*gate.cases} or {each.case.name for each in answers if both <= {*each.asked}}
        judged = (_judged(gate, each) for each in answers if each.case.name in named)
        verdicts.append(GateVerdict(number, gate, tuple(judged)))
    return tuple(verdicts)


def _judged(gate: Gate, answers: Answers) -> CaseVerdict:
    name = answers.case.name
    collapses = {label: answers.collapse(label) for label in (gate.model, gate.against)}
    for label, collapse in collapses.items():
        if answers.ok(label) is None and collapse is None:
            response = answers.responses.get(label)
            refused = response is not None and outcome_of(response) is Outcome.OUT_OF_DOMAIN
            verdict = Verdict.REFUSED if refused else Verdict.UNANSWERED
            return CaseVerdict(name, verdict, None, None, answers.why_not(label))
    fallen = tuple(label for label, collapse in collapses.items() if collapse is not None)
    if fallen:
        return doubted(gate, answers, _fallen(gate, answers, fallen))
    try:
        found = compare(answers, gate.model, gate.against, gate.quantity, METRICS[gate.metric])
    except InputError as error:
        return CaseVerdict(name, Verdict.INCONCLUSIVE, None, None, str(error))
    verdict = judge(found.error, found.uncertainty, gate.bound, found.low, found.high)
    judged = CaseVerdict(name, verdict, found.error, found.uncertainty, found.note)
    return doubted(gate, answers, replace(judged, low=found.low, high=found.high))


def _fallen(gate: Gate, answers: Answers, fallen: tuple[str, ...]) -> CaseVerdict:
    """A case in which the structure of the labels `fallen` collapses."""
    note = "; ".join(answers.why_not(label) for label in fallen)
    verdict = Verdict.PASS
    if gate.model == gate.against:
        verdict, note = Verdict.INCONCLUSIVE, f"{note}: no number of the run"
    elif len(fallen) == 1:
        (other,) = {gate.model, gate.against} - {*fallen}
        stands = survives(answers.responses[other])
        verdict = Verdict.FAIL if stands else Verdict.INCONCLUSIVE
        ending = "survives" if stands else "ends before its peak and may still collapse"
        note += f"; {other} {ending}"
    return CaseVerdict(answers.case.name, verdict, None, None, note, fallen)


def verdict_row(found: GateVerdict) -> Row:
    """The row of a gate in the table of verdicts."""
    top = {} if found.critical is None else asdict(found.critical)
    return {
        **_columns(found),
        "verdict": found.verdict.value,
        **found.counts,
        **{name: top.get(name) for name in ("case", "value", "uncertainty", "low", "high")},
        "collapsed": list(top.get("collapsed", ())),
        "reasons": list(found.reasons),
    }


def _columns(found: GateVerdict) -> dict[str, object]:
    return {"number": found.number, "gate": found.gate.name, **asdict(found.gate)}
