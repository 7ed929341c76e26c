"""A formula of shear resistance: fitted to the calibrating tests, judged by the validating ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from workbench.fields import Choice, Flag, checked
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, StudModel
from workbench.studs.shear import SHEAR_MODELS
from workbench.studs.strength import fit_strength

SOURCES = {
    "en1994": ("en1994-1-1",),
    "roik-mean": ("roik1989", "en1994-1-1"),
    "aisc360": ("aisc360-22",),
    "ollgaard": ("ollgaard1971",),
}
STATISTICS = ("en1990", "pinheiro-bates2000")


@dataclass(frozen=True)
class StudStrength(StudModel):
    """Shear resistance of a headed stud in a solid slab by a formula.

    Options: `formula`, a name in `workbench.studs.SHEAR_MODELS`; `corrected`, predict with the
    median ratio that the calibrating tests give, instead of the formula as it is; `loss` of the
    fit (linear, huber, bisquare).
    """

    formula: str = checked(Choice(tuple(SHEAR_MODELS)), "roik-mean")
    corrected: bool = checked(Flag(), False)
    loss: str = checked(Choice(("linear", "huber", "bisquare")), "linear")

    name: ClassVar[str] = "stud-strength"
    asks: ClassVar[tuple[str, ...]] = ("strength",)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Smaller of a steel and a concrete term with the mean values of the tests, headed studs in "
        "solid slabs, undamaged.",
        "The logarithm of test over prediction has a bias, a normal effect per campaign and a "
        "normal scatter within campaigns; EN 1990 D.8 takes all tests as independent.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the formula and of the statistics."""
        return (*SOURCES[self.formula], *STATISTICS)

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The fit, and how the prediction meets the validating tests."""
        level = scenario.confidence
        fit = fit_strength(split.calibration, self.formula, loss=self.loss, confidence=level)
        judged = None
        if not split.validation.empty:
            judged = fit.judge(split.validation, level, corrected=self.corrected)
        scalars = {"tests_fitted": float(len(fit.rows)), "fitted_test_over_prediction": fit.bias}
        units = {"test": "N", "prediction": "N"}
        return Found(fit.content(judged), fit.findings, judged, scalars, units)
