"""The tests themselves as a model: what every other one is held against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import pandas as pd

from workbench.errors import InputError, OutOfDomainError
from workbench.evidence import dataset
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, StudModel
from workbench.studs.interaction import combined_tests
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
class StudMeasured(StudModel):
    """Tests on studs: test over prediction is one for them, and bands hold what they claim.

    It refuses what the validating campaigns do not hold, so that nothing is judged by it.
    """

    name: ClassVar[str] = "stud-measured"
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

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The tests that validate, with the values that a perfect prediction would have."""
        asked = scenario.asked
        fitted = _rows(asked, split.calibration, split.calibration_points)
        if split.validation.empty and split.validation_points.empty:
            counted = len(fitted.drop_duplicates(["campaign", "specimen"])) if len(fitted) else 0
            content = {"calibration": fitted, "validation": None}
            return Found(content, scalars={"tests_fitted": float(counted)}, exact=True)
        rows = _rows(asked, split.validation, split.validation_points)
        if rows.empty:
            campaigns = ", ".join(campaigns_of(split.validation, split.validation_points))
            where = f"in the validating campaigns ({campaigns})"
            raise OutOfDomainError(f"no test of {_MEANING[asked]} {where}")
        names = ["test_over_prediction", "least_test_over_prediction"]
        names = ["stiffness_test_over_prediction"] if asked == "load-slip" else names
        scalars = {"coverage": scenario.confidence, **dict.fromkeys(names, 1.0)}
        return Found({"calibration": fitted, "validation": rows}, scalars=scalars, exact=True)


def _rows(asked: str, tests: pd.DataFrame, points: pd.DataFrame) -> pd.DataFrame:
    """What the tests say to the question, one row per test or point; may be empty."""
    nothing = pd.DataFrame(columns=["campaign", "specimen"])
    if asked == "load-slip":
        return nothing if points.empty else first_loading(points, falling=True)
    if asked == "interaction":
        return combined_tests(tests)
    if asked in RESIDUAL:
        rows = damaged_rows(tests, RESIDUAL[asked])
        return rows[["campaign", "specimen", "predamage", "level", "ratio", "origin"]]
    try:
        rows = undamaged_headed_studs(tests)
    except InputError:
        return nothing
    return rows[["campaign", "specimen", "diameter_mm", "fcm_MPa", "fu_MPa", "shear_kN"]]
