"""The kinds of tables that can be added, each with its schema and what looks absurd in it."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from workbench.base.catalogue import (
    ANSWERS,
    IMPACT_TESTS,
    STUD_POINTS,
    STUD_TESTS,
    Dataset,
    datasets,
)
from workbench.base.errors import InputError
from workbench.base.fields import Choice, did_you_mean
from workbench.base.tables import FOUND_OUT, Reading, read_cells
from workbench.extras.intake.answers import NOT_KNOWN, SERIES, held
from workbench.extras.intake.conversion import convert, examined_from, find
from workbench.extras.intake.impact_tests import IMPACTS
from workbench.extras.intake.impact_tests import plausibility as of_impacts
from workbench.extras.intake.mapping import Mapping
from workbench.responses import Finding
from workbench.studs import plausibility as of_studs
from workbench.studs.schema import POINTS, TESTS, TableSchema, examine, examined
from workbench.studs.tables import SHIPPED, same_contents


class Kind(NamedTuple):
    """A kind of table: its `table` of columns, the column of its `source`, what looks wrong.

    `copies` gives names of rows that hold the same; `uncertainty`, what the catalogue says of it
    unless the mapping does; `then`, what to do next, and `fit`, what else with rows to fit.
    """

    table: TableSchema
    source: str
    suspicions: Callable[[pd.DataFrame], list[Finding]]
    copies: Callable[[pd.DataFrame], list[tuple[str, str]]]
    uncertainty: str
    then: str
    fit: str = ""


_RUN = "workbench run STUDY && workbench report STUDY"
KINDS = {
    IMPACT_TESTS: Kind(
        IMPACTS,
        "source",
        of_impacts.suspicions,
        of_impacts.same_contents,
        "per test, half-widths of 95 % intervals in the columns peak_uncertainty_m and "
        "residual_uncertainty_m",
        "workbench run impact_tests",
    ),
    STUD_TESTS: Kind(
        TESTS,
        "reference",
        of_studs.suspicions,
        same_contents,
        "as tabulated; the source states none",
        "workbench run studs",
        "workbench fit stud-strength {path}",
    ),
    STUD_POINTS: Kind(
        POINTS,
        "reference",
        of_studs.suspicions_of_points,
        lambda rows: [],
        "as tabulated; the source states none",
        "",
        "workbench fit load-slip {path}",
    ),
    ANSWERS: Kind(SERIES, "source", lambda rows: [], lambda rows: [], NOT_KNOWN, _RUN),
}


def kind_of(columns: list[str], given: str | None) -> str:
    """The kind of a table: the `given` one, or that whose columns it has. Raises `InputError`."""
    if given is not None:
        return str(Choice(tuple(KINDS), did_you_mean(given, KINDS)).check("--kind", given))
    counts = {
        name: sum(find(column, kind.table) is not None for column in columns)
        for name, kind in KINDS.items()
    }
    best = max(counts, key=lambda name: counts[name])
    if list(counts.values()).count(counts[best]) > 1:
        text = "cannot be told from the columns"
        raise InputError("--kind", None, text, "say one of " + ", ".join(KINDS))
    return best


def names_column(text: str) -> bool:
    """Whether a text names a column of any kind of table, whatever its unit."""
    return any(find(text, kind.table) for kind in KINDS.values())


def check_file(path: Path, how: Reading = FOUND_OUT) -> tuple[list[str], list[str], list[str]]:
    """Problems, suspicions and notes of a table of your own, read as `how` says; sentences.

    Its columns tell whether it holds impact tests, points of load-slip curves or tests on studs.
    Raises `InputError` for a file that cannot be read at all.
    """
    cells = read_cells(path, names_column, how)
    names = set(cells.header)
    columns = {each.column.name for n in names if (each := find(n, IMPACTS)) and each.column}
    if {"span_m", "velocity_m_per_s"} <= columns:
        kind = KINDS[IMPACT_TESTS]
        found = examined_from(convert(cells, IMPACTS, Mapping(), {}), IMPACTS)
    else:
        kind = KINDS[STUD_POINTS if {"slip_mm", "load_kN"} <= names else STUD_TESTS]
        found = examined(cells, kind.table)
    problems = [str(problem.error()) for problem in found.problems]
    doubts = [each.text for each in kind.suspicions(found.rows)]
    return problems, doubts, list(found.notes)


def rows_of(entry: Dataset) -> pd.DataFrame:
    """The rows of a table of the catalogue that has a schema. Raises `InputError`."""
    return examine(entry.path, KINDS[entry.kind].table).accept()


def problems_of_own() -> list[str]:
    """Problems of tables that were added, and of shipped impact tests, one sentence each."""
    problems = []
    for entry in datasets():
        if entry.kind not in KINDS or entry.name in SHIPPED:
            continue
        try:
            rows = rows_of(entry)
            if entry.kind == ANSWERS:
                held(entry, rows)
        except InputError as error:
            problems.append(f"dataset {entry.name}: {error}")
    return problems
