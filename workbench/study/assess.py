"""Assessing a stored study: tables of cells, comparisons, ladders and gates. Never simulates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.assessment import GateVerdict, Verdict, bias_and_scatter
from workbench.errors import InputError
from workbench.responses import SCALARS, TIMES, Response, energy_error, findings_of, scalars_of
from workbench.responses.outcome import COLUMNS
from workbench.study.answers import Answers
from workbench.study.cells import Cell, cells_of
from workbench.study.comparisons import comparison_rows, ladder_row
from workbench.study.definition import Study
from workbench.study.store import Presence, Record, Store
from workbench.study.tables import Row, write_table
from workbench.study.verdicts import CASE_COLUMNS, case_rows, verdict_row, verdicts_of
from workbench.study.verdicts import COLUMNS as VERDICT_COLUMNS

NOT_RUN = "not run"

_CELL = ("case", "label", "model", "model_version", "outcome", "message", "wall_time")
_COMPARISON = (
    *("model", "against", "quantity", "metric", "value", "against_value", "error"),
    *("uncertainty", "note"),
)
_LADDER = ("order", "extrapolated", "uncertainty", "relative", "converging", "accepted", "note")
_BIAS = (
    *("model", "against", "quantity", "count", "bias", "low", "high", "uncertainty"),
    *("model_scatter", "note"),
)
_FEWEST_FOR_BIAS = 3  # cases


@dataclass(frozen=True)
class Assessment:
    """The rows of all `tables` by name, as stored under `directory`, and the `verdicts`."""

    directory: Path
    tables: Mapping[str, Sequence[Row]]
    verdicts: tuple[GateVerdict, ...]

    @property
    def failed(self) -> bool:
        """Whether a gate failed."""
        return any(found.verdict is Verdict.FAIL for found in self.verdicts)


def assess(study: Study, root: Path) -> Assessment:
    """Compare what is stored under ``root/<study name>`` and write the tables there.

    Cells that are not stored count as not run. Arguments: `study` (in its quick form, if that is
    what was run); `root`, the directory of all stores. Raises `InputError` if nothing has been
    stored yet or a parameter of the study has the name of a column.
    """
    store = Store(Path(root) / study.name)
    cells = cells_of(study)
    if not store.keys():
        raise InputError(
            "study",
            study.name,
            "has no stored cells yet",
            f"run it first: workbench run {study.name}",
        )
    names = list(dict.fromkeys(name for case in study.cases for name in case.parameters))
    for name in names:
        if name in {*_CELL, *TIMES, *_COMPARISON, *SCALARS, "key"}:
            raise InputError("case.parameters", name, "is the name of a column", "rename it")
    cell_rows: list[Row] = []
    findings: list[Row] = []
    comparisons: list[Row] = []
    ladders: list[Row] = []
    given: list[Answers] = []
    by_case: dict[str, list[Cell]] = {case.name: [] for case in study.cases}
    for cell in cells:
        by_case[cell.case].append(cell)
    for case in study.cases:
        responses: dict[str, Response] = {}
        for cell in by_case[case.name]:
            record = None
            if store.presence(cell.key) is Presence.FINISHED:
                responses[cell.label] = store.response(cell.key)
                record = store.record(cell.key)
            answer = _cell_row(cell, responses.get(cell.label), record)
            cell_rows.append({**answer, **case.parameters})
            if record is not None:
                who = {"case": cell.case, "label": cell.label, "model": cell.model.name}
                said = findings_of(responses[cell.label])
                findings.extend({**who, **finding.as_dict()} for finding in said)
        asked = tuple(cell.label for cell in by_case[case.name])
        answers = Answers(study, case, asked, responses)
        comparisons.extend(comparison_rows(answers))
        ladders.extend(row for q in study.quantities if (row := ladder_row(answers, q)))
        given.append(answers)
    found = verdicts_of(study, given)
    derived = ("shear_utilisation", "energy_error")
    tables: tuple[tuple[str, list[Row], tuple[str, ...]], ...] = (
        ("cells", cell_rows, (*_CELL, "solve_time", *names, *SCALARS, *derived, "key")),
        ("findings", findings, ("case", "label", "model", *COLUMNS)),
        ("comparisons", comparisons, ("case", *names, *_COMPARISON)),
        ("ladder", ladders, ("case", "quantity", *study.steps, *_LADDER)),
        ("gates", [row for each in found for row in case_rows(each)], CASE_COLUMNS),
        ("verdicts", [verdict_row(each) for each in found], VERDICT_COLUMNS),
        ("bias", list(_bias_rows(comparisons, study.reference)), _BIAS),
    )
    store.prepare()
    for name, table, columns in tables:
        write_table(store.tables / f"{name}.csv", table, columns)
    rows = {name: table for name, table, _ in tables}
    return Assessment(store.directory, rows, found)


def _cell_row(cell: Cell, response: Response | None, record: Record | None) -> dict[str, Any]:
    row: dict[str, Any] = {
        "case": cell.case,
        "label": cell.label,
        "model": cell.model.name,
        "model_version": cell.model.version,
        "outcome": NOT_RUN,
        "key": cell.key,
    }
    if response is None or record is None:
        return row
    row |= {
        "outcome": response.attrs["outcome"],
        "message": response.attrs["message"],
        **{name: record.get(name) for name in TIMES},
        **scalars_of(response),
        "energy_error": energy_error(response),
    }
    if "shear_utilisation" in response:
        row["shear_utilisation"] = float(response["shear_utilisation"].max())
    return row


def _bias_rows(comparisons: list[Row], reference: str) -> Iterator[Row]:
    """Bias and scatter of every model against the reference over the cases, per quantity.

    The interval holds what the cases scatter and the mean `uncertainty` of their comparisons.
    """
    pairs: dict[tuple[str, str, str], list[tuple[float, float]]] = {}
    widths: dict[tuple[str, str, str], list[float | None]] = {}
    for row in comparisons:
        if row["against"] != reference or row["metric"] != "relative_error":
            continue
        if row["value"] > 0.0 and row["against_value"] > 0.0:
            key = row["model"], row["against"], row["quantity"]
            pairs.setdefault(key, []).append((row["value"], row["against_value"]))
            share = row["against_value"] / row["value"]
            width = row["uncertainty"]
            widths.setdefault(key, []).append(None if width is None else share * width)
    for (model, against, quantity), values in pairs.items():
        if len(values) < _FEWEST_FOR_BIAS:
            continue
        found = bias_and_scatter(*zip(*values, strict=True))
        known = [width for width in widths[model, against, quantity] if width is not None]
        unknown = len(values) - len(known)
        # numerical errors have one sign over the cases: they shift the bias, they do not scatter
        common = sum(known) / len(known) if known else 0.0
        notes = [found.note] if found.note else []
        if unknown:
            notes.append(f"numerical uncertainty unknown in {unknown} of {len(values)} cases")
        yield {
            "model": model,
            "against": against,
            "quantity": quantity,
            "count": found.count,
            "bias": found.bias,
            "low": None if found.low is None else found.low * (1.0 - common),
            "high": None if found.high is None else found.high * (1.0 + common),
            "uncertainty": common if known else None,
            "model_scatter": found.model_scatter,
            "note": "; ".join(notes),
        }
