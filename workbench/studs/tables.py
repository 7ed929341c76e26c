"""The tables that come with the workbench, and whether they keep their schema."""

from __future__ import annotations

import pandas as pd

from workbench.errors import InputError
from workbench.evidence import dataset
from workbench.studs.reading import examine, read_points, read_tests
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
    read = read_tests if SHIPPED[name] is TESTS else read_points
    return read(dataset(name).path)


def check_tables() -> list[str]:
    """Problems of the shipped stud tables, one sentence each; empty when all is well."""
    problems = []
    for name, table in SHIPPED.items():
        try:
            found = examine(dataset(name).path, table).problems
        except InputError as error:
            problems.append(f"dataset {name}: {error}")
            continue
        problems.extend(f"dataset {name}: {problem.error()}" for problem in found)
    return problems
