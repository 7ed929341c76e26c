"""The tables that come with the workbench, and whether tables keep their schema."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from workbench.errors import InputError
from workbench.evidence import dataset
from workbench.studs.reading import LONGEST_LINE, examine
from workbench.studs.schema import POINTS, TESTS

SHIPPED = {
    "stud-push-out": TESTS,
    "stud-pull-out": TESTS,
    "stud-other-connectors": TESTS,
    "stud-load-slip": POINTS,
    "stud-unload-reload": POINTS,
}


def shipped(name: str) -> pd.DataFrame:
    """A shipped table of the stud schemas by its catalogue name. Raises `InputError`."""
    if name not in SHIPPED:
        raise InputError("dataset", name, "must be one of " + ", ".join(SHIPPED))
    return examine(dataset(name).path, SHIPPED[name]).accept()


def check_tables() -> list[str]:
    """Problems of the shipped stud tables, one sentence each; empty when all is well."""
    problems: list[str] = []
    for name, table in SHIPPED.items():
        try:
            found = examine(dataset(name).path, table).problems
            problems += [f"dataset {name}: {problem.error()}" for problem in found]
        except InputError as error:
            problems.append(f"dataset {name}: {error}")
    return problems


def check_file(path: str | Path) -> list[str]:
    """Problems of a CSV file of your own, one sentence each; empty when all rows are good.

    A file with the columns slip_mm and load_kN holds points of curves, any other one tests. Raises
    `InputError` for a file that cannot be read at all.
    """
    path = Path(path)
    first = b""
    if path.is_file():
        with path.open("rb") as stream:
            first = stream.readline(LONGEST_LINE)
    names = {name.strip() for name in first.decode("utf-8-sig", "replace").split(",")}
    table = POINTS if {"slip_mm", "load_kN"} <= names else TESTS
    return [str(problem.error()) for problem in examine(path, table).problems]
