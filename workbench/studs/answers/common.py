"""What the models of studs share: their tables, the split of the campaigns, their responses."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from workbench.errors import InputError, OutOfDomainError
from workbench.evidence import dataset
from workbench.models.base import Model, respond
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import Scenario
from workbench.scenarios.stud import CSV, StudTests
from workbench.studs.plain import plain
from workbench.studs.reading import read_points, read_tests
from workbench.studs.schema import POINTS, TESTS, Table
from workbench.studs.split import check_campaigns, joined, split_table
from workbench.studs.tables import SHIPPED, shipped

ANSWER = "answer"  # attribute of a response that holds everything but its scalars, as JSON
SAMPLING = "sampling_uncertainty"  # attribute: half-widths of intervals over tests, as JSON


@dataclass(frozen=True)
class Split:
    """Tests and load-slip points, those that `calibrate` and those that `validate`.

    Frames of the schemas `TESTS` and `POINTS`; without rows where the scenario names no table.
    """

    calibration: pd.DataFrame
    validation: pd.DataFrame
    calibration_points: pd.DataFrame
    validation_points: pd.DataFrame


def load_split(scenario: StudTests) -> Split:
    """The tables of a scenario, split by campaign.

    Raises `InputError` for a name that is no table of the schema, a bad row, a campaign that no
    table has, or a specimen that stands in two tables.
    """
    tests = _joined(scenario.tables, TESTS)
    points = _joined(scenario.curves, POINTS)
    check_campaigns((*scenario.calibrate, *scenario.validate), tests, points)
    parts = (split_table(each, scenario.calibrate, scenario.validate) for each in (tests, points))
    (calibration, validation), (calibration_points, validation_points) = parts
    return Split(calibration, validation, calibration_points, validation_points)


def _joined(names: Sequence[str], schema: Table) -> pd.DataFrame:
    tables = []
    for name in names:
        if name.endswith(CSV):
            tables.append((read_tests if schema is TESTS else read_points)(name))
            continue
        if SHIPPED.get(name) is not schema:
            known = [known for known, each in SHIPPED.items() if each is schema]
            raise InputError("tests.tables", name, "must be a CSV file or " + ", ".join(known))
        tables.append(shipped(name))
    if not tables:
        return pd.DataFrame(columns=list(schema.names))
    return joined(tables, unique=schema is TESTS)


def shipped_digest() -> str:
    """Hash of the shipped tables, so that stored answers are renewed when they change."""
    digest = hashlib.sha256()
    for name in SHIPPED:
        digest.update(dataset(name).path.read_bytes())
    return digest.hexdigest()[:16]


def about(scenario: StudTests, name: str, *asked: str) -> list[Finding]:
    """A refusal if a model does not answer what is asked of the tests."""
    if scenario.asked in asked:
        return []
    text = f"{name} answers {', '.join(asked)}, not {scenario.asked}"
    return [Finding("question", text, refusal=True)]


@dataclass(frozen=True)
class Found:
    """What a model found: `scalars`, the whole `content`, `widths` of intervals, `warnings`.

    `widths` are half-widths of the scalars' intervals over tests; one that is missing or None is
    not known. `exact`: the scalars are definitions, without uncertainty.
    """

    scalars: Mapping[str, float | None]
    content: Mapping[str, Any]
    widths: Mapping[str, float | None]
    warnings: Sequence[str] = ()
    exact: bool = False


def answer(model: Model, scenario: Scenario, find: Callable[[StudTests, Split], Found]) -> Response:
    """The response of a model of studs: scalars, and the content as JSON.

    What the tests do not support (`InputError` of `find`) becomes a refusal, out-of-domain. Raises
    `InputError` for tables that cannot be read.
    """

    def solve(given: StudTests) -> Response:
        split = load_split(given)
        try:
            found = find(given, split)
        except InputError as error:
            raise OutOfDomainError(str(error)) from error
        warnings = [Finding(_subject(text), text) for text in found.warnings]
        response = build_response(dict(found.scalars), warnings=warnings)
        response.attrs[ANSWER] = json.dumps(plain(found.content), sort_keys=True, allow_nan=False)
        if found.exact:
            widths: dict[str, Any] = {str(name): 0.0 for name in response.data_vars}
            response.attrs["data_uncertainty"] = json.dumps(widths, sort_keys=True)
        else:
            widths = {name: width for name, width in found.widths.items() if width is not None}
            response.attrs[SAMPLING] = json.dumps(plain(widths), sort_keys=True)
        return response

    return respond(model, scenario, solve)


# words of a warning: what it is about
_SUBJECTS = (
    ("not validated", "grade"),
    ("tensile strength of their shank", "shank"),
    ("measured loads", "measurement"),
    ("modulus", "modulus"),
    ("rest on a bound", "bounds"),
    ("more points than", "points"),
    ("outside", "range"),
    ("campaign", "campaigns"),
)


def _subject(text: str) -> str:
    return next((subject for words, subject in _SUBJECTS if words in text), "evidence")


def content_of(response: Response) -> dict[str, Any]:
    """The content that a model of studs has put into a response; empty for other responses."""
    content: dict[str, Any] = json.loads(response.attrs.get(ANSWER, "{}"))
    return content
