"""A formula of shear resistance: fitted to the calibrating tests, judged by the validating ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pandas as pd

from workbench.fields import Choice, Flag, check_fields, checked
from workbench.responses import Finding, Response
from workbench.scenarios import Scenario
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, about, answer, shipped_digest
from workbench.studs.judging import Judgement, judge_formula
from workbench.studs.shear import SHEAR_MODELS
from workbench.studs.strength import StrengthFit, fit_strength

SOURCES = {
    "en1994": ("en1994-1-1",),
    "roik-mean": ("roik1989", "en1994-1-1"),
    "aisc360": ("aisc360-22",),
    "ollgaard": ("ollgaard1971",),
}
STATISTICS = ("en1990", "pinheiro-bates2000")


@dataclass(frozen=True)
class StudStrength:
    """Shear resistance of a headed stud in a solid slab by a formula.

    Options: `formula`, a name in `workbench.studs.SHEAR_MODELS`; `corrected`, predict with the
    median ratio that the calibrating tests give, instead of the formula as it is; `loss` of the
    fit (linear, huber, bisquare).
    """

    formula: str = checked(Choice(tuple(SHEAR_MODELS)), "roik-mean")
    corrected: bool = checked(Flag(), False)
    loss: str = checked(Choice(("linear", "huber", "bisquare")), "linear")

    name: ClassVar[str] = "stud-strength"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Smaller of a steel and a concrete term with the mean values of the tests, headed studs in "
        "solid slabs, undamaged.",
        "The logarithm of test over prediction has a bias, a normal effect per campaign and a "
        "normal scatter within campaigns; EN 1990 D.8 takes all tests as independent.",
    )

    def __post_init__(self) -> None:
        check_fields(self, "option")

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the formula and of the statistics."""
        return (*SOURCES[self.formula], *STATISTICS)

    @property
    def data_digest(self) -> str:
        """Hash of the shipped tables."""
        return shipped_digest()

    def domain(self, scenario: Scenario) -> list[Finding]:
        """It answers questions of strength."""
        return about(scenario, self.name, "strength") if isinstance(scenario, StudTests) else []

    def simulate(self, scenario: Scenario) -> Response:
        """The fit, and how the prediction meets the validating tests."""
        return answer(self, scenario, self._find)

    def _find(self, scenario: StudTests, split: Split) -> Found:
        fit = fit_strength(
            split.calibration, self.formula, loss=self.loss, confidence=scenario.confidence
        )
        judged = None
        if not split.validation.empty:
            judged = judge_strength(
                fit, split.validation, scenario.confidence, corrected=self.corrected
            )
        scalars, widths = strength_scalars(fit, judged)
        return Found(scalars, strength_content(fit, judged), widths, fit.warnings)


def judge_strength(
    fit: StrengthFit, table: pd.DataFrame, confidence: float = 0.9, *, corrected: bool = False
) -> Judgement:
    """Judge the formula of a fit by tests that the fit has not used (refused otherwise).

    Arguments: `corrected`, predict with the fitted bias and trends. Raises `InputError`.
    """
    fit.identity.refuse_overlap(table)
    return judge_formula(table, fit.predict if corrected else fit.model.of, confidence)


def strength_content(fit: StrengthFit, judged: Judgement | None) -> dict[str, Any]:
    """Everything that is known of a fit and its judgement, for JSON and figures."""
    return {
        "fit": fit.to_dict(),
        "tests": fit.rows,
        "judgement": None if judged is None else judged.to_dict(),
        "judged": None if judged is None else judged.rows,
    }


def strength_scalars(
    fit: StrengthFit, judged: Judgement | None
) -> tuple[dict[str, float | None], dict[str, float | None]]:
    """Scalars of a fit with the half-widths of their intervals."""
    scalars: dict[str, float | None] = {
        "tests_fitted": float(len(fit.rows)),
        "fitted_test_over_prediction": fit.bias,
    }
    if judged is None:
        return scalars, {}
    scalars |= {
        "test_over_prediction": judged.bias,
        "least_test_over_prediction": judged.least,
    }
    return scalars, {"test_over_prediction": judged.half_width}
