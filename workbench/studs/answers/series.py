"""EN 1994-1-1 Annex B.2 on every series of nominally equal tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from workbench.fields import Number, check_fields, checked
from workbench.responses import Finding, Response
from workbench.scenarios import Scenario
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, about, answer, shipped_digest
from workbench.studs.series import Series, evaluate_groups


@dataclass(frozen=True)
class StudSeries:
    """Characteristic and design resistance, slip capacity and ductility of series of push tests.

    Options: `specified_strength`, minimum tensile strength of the stud material in Pa;
    `partial_factor` gamma_V.
    """

    specified_strength: float = checked(Number(2e8, 1.5e9, "Pa"), 450e6)
    partial_factor: float = checked(Number(1.0, 3.0), 1.25)

    name: ClassVar[str] = "stud-series"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "EN 1994-1-1, B.2: three or more nominally equal tests within 10 % of their mean.",
        "Equal means: campaign, diameter, height, slab, arrangement, concrete and stud strength.",
    )

    def __post_init__(self) -> None:
        check_fields(self, "option")

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography key of the rule."""
        return ("en1994-1-1",)

    @property
    def data_digest(self) -> str:
        """Hash of the shipped tables."""
        return shipped_digest()

    def domain(self, scenario: Scenario) -> list[Finding]:
        """It answers questions of strength."""
        return about(scenario, self.name, "strength") if isinstance(scenario, StudTests) else []

    def simulate(self, scenario: Scenario) -> Response:
        """Every series of the calibrating tests, evaluated or refused with the reason."""
        return answer(self, scenario, self._find)

    def _find(self, scenario: StudTests, split: Split) -> Found:
        points = split.calibration_points
        series = evaluate_groups(
            split.calibration,
            None if points.empty else points,
            specified_strength=self.specified_strength,
            partial_factor=self.partial_factor,
        )
        evaluated = sum(each.tests for each in series if each.result is not None)
        warnings = []
        if not evaluated:
            largest = max(each.tests for each in series)
            warnings.append(
                f"no series of three nominally equal tests within 10 % of their mean: the largest "
                f"of {len(series)} groups has {largest}"
            )
        content = {"series": [series_content(each) for each in series]}
        return Found({"tests_fitted": float(evaluated)}, content, {}, warnings)


def series_content(series: Series) -> dict[str, Any]:
    """A series for JSON: name, count, and the result or why there is none."""
    return {
        "name": series.name,
        "tests": series.tests,
        "result": None if series.result is None else series.result.to_dict(),
        "refusal": series.refusal,
    }
