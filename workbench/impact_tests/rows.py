"""The impact tests of the data catalogue, each with its scenario and what was measured."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import nan
from pathlib import Path

import pandas as pd

from workbench.errors import Collapse, InputError, Mechanism
from workbench.evidence import Dataset, dataset, datasets
from workbench.evidence.catalogue import IMPACT_TESTS, SYNTHETIC
from workbench.impact_tests.schema import IMPACTS, MEASURED, STANDS, scenario_of
from workbench.scenarios import ColumnImpact, scenario_hash
from workbench.studs.reading import examine
from workbench.studs.schema import Row, known


@dataclass(frozen=True)
class ImpactTest:
    """One test, or several of one scenario: their `names`, `scenario`, `campaign` and `entries`.

    `measured` gives the mean of each quantity with its half-width (95 %): that of single tests, as
    equal tests share their systematic errors, or the farthest of them if that is wider. It is empty
    where the member collapsed, in `collapsed` of the tests: `collapse` says how.
    """

    names: tuple[str, ...]
    campaign: str
    scenario: ColumnImpact
    measured: dict[str, tuple[float, float]]
    entries: tuple[Dataset, ...]
    collapse: Collapse | None = None
    collapsed: int = 0

    @property
    def name(self) -> str:
        """What a case of this test is called."""
        more = len(self.names) - 1
        return f"{self.names[0]} and {more} equal" if more else self.names[0]

    @property
    def synthetic(self) -> bool:
        """Whether its numbers are made, not measured."""
        return any(entry.role == SYNTHETIC for entry in self.entries)


def tables(name: str | None = None) -> tuple[Dataset, ...]:
    """The tables of impact tests in the catalogue, or the one of this name.

    Raises `InputError` for a name that is none of them.
    """
    found = tuple(entry for entry in datasets() if entry.kind == IMPACT_TESTS)
    if name is None:
        return found
    if dataset(name) not in found:
        known_names = ", ".join(entry.name for entry in found)
        raise InputError("dataset", name, f"holds no impact tests; there are {known_names}")
    return (dataset(name),)


def impact_tests(name: str | None = None) -> tuple[ImpactTest, ...]:
    """All impact tests of the catalogue, or those of one table; equal scenarios are one test.

    A scenario that has been tested is not shown by synthetic rows. Raises `InputError`.
    """
    groups: dict[str, list[tuple[Dataset, Row, ColumnImpact]]] = {}
    for entry in tables(name):
        digest = hashlib.sha256(entry.path.read_bytes()).hexdigest()
        for row, scenario in _rows(entry.path, digest):
            groups.setdefault(scenario_hash(scenario), []).append((entry, row, scenario))
    return tuple(_test(group) for group in groups.values())


@lru_cache(maxsize=16)
def _rows(path: Path, digest: str) -> tuple[tuple[Row, ColumnImpact], ...]:
    """The rows of a table with their scenarios; `digest` of the file renews them."""
    rows = examine(path, IMPACTS).accept()
    return tuple((row, scenario_of(row)) for row in records(rows))


def records(rows: pd.DataFrame) -> Iterator[Row]:
    """Rows of a table of the schema, one by one."""
    for row in rows.to_dict("records"):
        yield {str(name): value for name, value in row.items()}


def _test(group: list[tuple[Dataset, Row, ColumnImpact]]) -> ImpactTest:
    real = [part for part in group if part[0].role != SYNTHETIC] or group
    measured = {}
    fallen = [row for _, row, _ in real if row["collapse"] != STANDS]
    for quantity, columns in MEASURED.items():
        pairs = [[known(row, column) or nan for column in columns] for _, row, _ in real]
        told = [(value, width) for value, width in pairs if value == value]
        if told and not fallen:
            mean = sum(value for value, _ in told) / len(told)
            single = sum(width for _, width in told) / len(told)
            farthest = max(abs(value - mean) for value, _ in told)
            measured[quantity] = (mean, max(single, farthest))
    entries = {entry.name: entry for entry, _, _ in real}
    names = tuple(scenario.name for _, _, scenario in real)
    collapse = None
    for row in fallen[:1]:
        reached = max(known(each, "peak_m") or 0.0 for each in fallen)
        collapse = Collapse(Mechanism(str(row["collapse"])), ("member",), reached)
    _, row, scenario = real[0]
    tested = names, str(row["campaign"]), scenario, measured, tuple(entries.values())
    return ImpactTest(*tested, collapse, len(fallen))
