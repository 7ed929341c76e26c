"""Stored study for a report: its tables and, on demand, the responses of its cells."""

import json
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.base.errors import Collapse, InputError, Mechanism
from workbench.responses import Finding, Outcome, Response
from workbench.responses.outcome import SYNTHETIC
from workbench.study.definition import Study
from workbench.study.store import NOT_RUN, UNREADABLE, Store
from workbench.study.tables import read_table, rows_of

BEST = "the best reference"  # stands for the governing one of a case
_UNKNOWN = {"outcome": NOT_RUN, "message": "", "key": ""}  # a cell that the tables do not have
_TABLES = (
    *("cells", "findings", "comparisons", "ladder", "gates", "verdicts", "bias"),
    *("references", "validation", "matrix", "cost", "budget", "ranking"),
    *("error-cells", "coverage", "chooser"),
)


@dataclass(frozen=True)
class CellState:
    """How one cell ended: `outcome` (or `NOT_RUN`), its `message`, its `findings`, its numbers.

    `numbers` holds the scalar quantities in SI, `wall_time` (s), `shear_utilisation` and
    `energy_error`, as far as the model knows them; `collapse`, how the structure collapses, if it
    does.
    """

    case: str
    label: str
    outcome: str
    message: str
    findings: tuple[Finding, ...]
    numbers: dict[str, float]
    key: str
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
class Stored:
    """A stored study, read only.

    Arguments: `directory` of the store and the `study` that it belongs to; `read`, responses by
    keys of cells as far as they have been read already. Others are read when asked for and kept.
    """

    directory: Path
    study: Study
    read: dict[str, Response] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def tables(self) -> dict[str, pd.DataFrame]:
        """The tables of the assessment by name.

        Raises `InputError` if the study has not been run and assessed.
        """
        try:
            return {name: read_table(self.directory / "tables" / name) for name in _TABLES}
        except UNREADABLE as error:
            text = f"has no readable table in its store: {error}"
            raise InputError("study", self.study.name, text, "run it first") from error

    @cached_property
    def rows(self) -> dict[str, list[dict[str, Any]]]:
        """Rows of the tables; numbers that are absent are None."""
        return {name: rows_of(table) for name, table in self.tables.items()}

    @cached_property
    def cells(self) -> dict[tuple[str, str], CellState]:
        """Every cell of the study by (case, label), in the order of the study."""
        known = {(row["case"], row["label"]): row for row in self.rows["cells"]}
        findings: dict[tuple[str, str], list[Finding]] = {}
        for row in self.rows["findings"]:
            findings.setdefault((row["case"], row["label"]), []).append(Finding.from_dict(row))
        return {
            key: CellState(
                *key,
                *(row["outcome"], row["message"]),
                tuple(findings.get(key, ())),
                {name: float(v) for name, v in row.items() if isinstance(v, (int, float))},
                row["key"],
                _collapse(row),
            )
            for key in ((case.name, label) for case, label in self.study.cells())
            for row in [known.get(key, _UNKNOWN)]
        }

    @cached_property
    def costs(self) -> dict[str, float]:
        """Time of each label over that of the reference, as far as it is known."""
        return {row["label"]: row["ratio"] for row in self.rows["cost"]}

    @cached_property
    def synthetic(self) -> bool:
        """Whether a cell holds made numbers, which validate nothing."""
        return any(row["subject"] == SYNTHETIC for row in self.rows["findings"])

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
        response = self.read.pop(key, None)
        if response is None:
            response = Store(self.directory).response(key)
        if keep:
            self.read[key] = response
        return response

    def answer_tables(self, case: str, label: str) -> dict[str, pd.DataFrame]:
        """The tables of a stored answer to a question on studs; empty for others."""
        from workbench.studs.model import tables_of

        response = self.response(case, label)
        return {} if response is None else tables_of(response)

    def data_uncertainty(self, case: str, label: str, quantity: str) -> float | None:
        """Half-width within which published or measured data are known, None if not stated."""
        response = self.response(case, label)
        if response is None or "data_uncertainty" not in response.attrs:
            return None
        stated: float | None = json.loads(response.attrs["data_uncertainty"]).get(quantity)
        return stated

    def errors(self, quantity: str, metric: str, against: str) -> dict[tuple[str, str], Any]:
        """Comparisons of one quantity by one metric, by (case, label).

        `against`: one label, or `BEST`: the governing reference of each case.
        """
        return {
            (row["case"], row["model"]): row
            for row in self.rows["comparisons"]
            if (row["quantity"], row["metric"]) == (quantity, metric)
            and row["against"] == self.held_against(row["case"], against)
        }

    def held_against(self, case: str, against: str) -> str:
        """The label that others are held against in a case; empty if no reference answered."""
        return self._governing.get(case, "") if against == BEST else against

    @cached_property
    def _governing(self) -> dict[str, str]:
        """The governing reference of each case."""
        return {row["case"]: row["label"] for row in self.rows["references"]}

    def ladder(self, case: str, quantity: str) -> dict[str, Any] | None:
        """The row of the ladder table for a case and quantity."""
        wanted = (case, quantity)
        rows = (row for row in self.rows["ladder"] if (row["case"], row["quantity"]) == wanted)
        return next(rows, None)

    @cached_property
    def provenance(self) -> list[dict[str, str]]:
        """The different provenance records of the stored cells, in a fixed order."""
        store = Store(self.directory)
        entries: dict[str, dict[str, str]] = {}
        for cell in self.cells.values():
            if cell.outcome != NOT_RUN:
                record = store.record(cell.key).get("provenance", {})
                entries[json.dumps(record, sort_keys=True)] = record
        return [entries[key] for key in sorted(entries)]


def _collapse(row: dict[str, Any]) -> Collapse | None:
    """The collapse in a row of the table of cells."""
    if row["outcome"] != Outcome.COLLAPSE:
        return None
    mechanism, parts, *numbers = (row[f"collapse_{name}"] for name in Collapse._fields)
    return Collapse(Mechanism(mechanism), tuple(parts), *numbers)
