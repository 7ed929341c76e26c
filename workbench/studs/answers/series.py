"""EN 1994-1-1 Annex B.2 on every series of nominally equal tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from workbench.fields import Number, checked
from workbench.responses import Finding
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, StudModel
from workbench.studs.series import evaluate_groups


@dataclass(frozen=True)
class StudSeries(StudModel):
    """Characteristic and design resistance, slip capacity and ductility of series of push tests.

    Options: `specified_strength`, minimum tensile strength of the stud material in Pa;
    `partial_factor` gamma_V.
    """

    specified_strength: float = checked(Number(2e8, 1.5e9, "Pa"), 450e6)
    partial_factor: float = checked(Number(1.0, 3.0), 1.25)

    name: ClassVar[str] = "stud-series"
    asks: ClassVar[tuple[str, ...]] = ("strength",)
    assumptions: ClassVar[tuple[str, ...]] = (
        "EN 1994-1-1, B.2: three or more nominally equal tests within 10 % of their mean.",
        "Equal means: campaign, diameter, height, slab, arrangement, concrete and stud strength.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography key of the rule."""
        return ("en1994-1-1",)

    def find(self, scenario: StudTests, split: Split) -> Found:
        """Every series of the calibrating tests, evaluated or refused with the reason."""
        series = evaluate_groups(
            split.calibration,
            None if split.calibration_points.empty else split.calibration_points,
            specified_strength=self.specified_strength,
            partial_factor=self.partial_factor,
        )
        evaluated = sum(each.tests for each in series if each.result is not None)
        findings = []
        if not evaluated:
            text = (
                "no series of three nominally equal tests within 10 % of their mean: the largest "
                f"of {len(series)} groups has {max(each.tests for each in series)}"
            )
            findings.append(Finding("series", text))
        content = {"series": [each.to_dict() for each in series]}
        scalars = {"tests_fitted": float(evaluated)}
        return Found(content, findings, None, scalars, {"mean": "N", "lowest": "N", "slips": "m"})
