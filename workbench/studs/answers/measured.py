"""The tests themselves as a model: what every other one is held against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import pandas as pd

from workbench.errors import InputError, OutOfDomainError
from workbench.evidence import dataset
from workbench.responses import Finding, Response
from workbench.scenarios import Scenario
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, answer, shipped_digest
from workbench.studs.combined_tests import combined_tests
from workbench.studs.load_slip_fit import first_loading
from workbench.studs.quantities import undamaged_headed_studs
from workbench.studs.residual import damaged_rows
from workbench.studs.split import campaigns_of

_MEANING = {
    "strength": "the strength of undamaged studs",
    "load-slip": "load and slip",
    "interaction": "tension and shear together",
    "residual-strength": "strength after pre-damage",
    "residual-stiffness": "stiffness after pre-damage",
}
RESIDUAL = {"residual-strength": "strength", "residual-stiffness": "stiffness"}


@dataclass(frozen=True)
class StudMeasured:
    """Tests on studs: test over prediction is one for them, and bands hold what they claim.

    It refuses what the validating campaigns do not hold, so that nothing is judged by it.
    """

    name: ClassVar[str] = "stud-measured"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Tests as published transcriptions give them; the uncertainty of single loads and slips "
        "is not reported, so that it stays in the scatter.",
        "Rows that their authors or the catalogue flag as unfit do not count.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the shipped tests."""
        tables = ("stud-push-out", "stud-load-slip")
        return tuple(dict.fromkeys(key for name in tables for key in dataset(name).keys))

    @property
    def data_digest(self) -> str:
        """Hash of the shipped tables."""
        return shipped_digest()

    def domain(self, scenario: Scenario) -> list[Finding]:
        """Whatever is asked is looked for in the tables."""
        return []

    def simulate(self, scenario: Scenario) -> Response:
        """The tests that validate, with the values that a perfect prediction would have."""
        return answer(self, scenario, _find)


def _find(scenario: StudTests, split: Split) -> Found:
    fitted = _rows(scenario, split.calibration, split.calibration_points)
    if split.validation.empty and split.validation_points.empty:
        content = {"calibration": fitted, "validation": None}
        counted = fitted.drop_duplicates(["campaign", "specimen"]) if len(fitted) else fitted
        return Found({"tests_fitted": float(len(counted))}, content, {}, exact=True)
    rows = _rows(scenario, split.validation, split.validation_points)
    if rows.empty:
        raise OutOfDomainError(
            f"no test of {_MEANING[scenario.asked]} in the validating campaigns "
            f"({', '.join(campaigns_of(split.validation, split.validation_points))})"
        )
    scalars: dict[str, float | None] = {"coverage": scenario.confidence}
    if scenario.asked == "load-slip":
        scalars["stiffness_test_over_prediction"] = 1.0
    else:
        scalars |= {"test_over_prediction": 1.0, "least_test_over_prediction": 1.0}
    return Found(scalars, {"calibration": fitted, "validation": rows}, {}, exact=True)


def _rows(scenario: StudTests, tests: pd.DataFrame, points: pd.DataFrame) -> pd.DataFrame:
    """What the tests say to the question, one row per test or point; may be empty."""
    if scenario.asked == "load-slip":
        return pd.DataFrame() if points.empty else first_loading(points, falling=True)
    if scenario.asked == "interaction":
        return combined_tests(tests)
    if scenario.asked in RESIDUAL:
        rows = damaged_rows(tests, RESIDUAL[scenario.asked])
        return rows[["campaign", "specimen", "predamage", "level", "ratio", "origin"]]
    try:
        rows = undamaged_headed_studs(tests)
    except InputError:
        return pd.DataFrame()
    return rows[["campaign", "specimen", "diameter_mm", "fcm_MPa", "fu_MPa", "shear_kN"]]
