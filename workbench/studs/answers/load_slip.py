"""A load-slip law: fitted to the calibrating curves, judged by the validating ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from workbench.errors import InputError
from workbench.fields import Choice, Flag, check_fields, checked
from workbench.responses import Finding, Response
from workbench.scenarios import Scenario
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, about, answer, shipped_digest
from workbench.studs.curve_judging import CurveJudgement, judge_curves
from workbench.studs.load_slip import LAWS, OllgaardLaw
from workbench.studs.load_slip_fit import LoadSlipFit, fit_load_slip

GRID = np.linspace(0.0, 10e-3, 101)  # m, slips at which median and band are given
SOURCES = {
    "ollgaard": ("ollgaard1971",),
    "bilinear": ("roik1989",),
    "rational": ("sargin1971",),
}


@dataclass(frozen=True)
class StudLoadSlip:
    """Load over its largest value as a function of slip, under first loading.

    Options: `law`, a name in `workbench.studs.LAWS`; `published`, Ollgaard's law with its published
    parameters instead of fitted ones.
    """

    law: str = checked(Choice(tuple(LAWS)), "ollgaard")
    published: bool = checked(Flag(), False)

    name: ClassVar[str] = "stud-load-slip"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Shape of the curve only: loads are over the largest load of the test.",
        "Curves are the observations, not points; the logarithms of the parameters have an effect "
        "per campaign. The band holds the stated share of the points of a further curve of the "
        "fitted campaigns, fewer of a new one.",
    )

    def __post_init__(self) -> None:
        check_fields(self, "option")
        if self.published and self.law != "ollgaard":
            raise InputError("option.published", self.law, "is known for the law ollgaard only")

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the law and of the statistics."""
        return SOURCES[self.law] + (() if self.published else ("pinheiro-bates2000",))

    @property
    def data_digest(self) -> str:
        """Hash of the shipped tables."""
        return shipped_digest()

    def domain(self, scenario: Scenario) -> list[Finding]:
        """It answers questions of load and slip."""
        return about(scenario, self.name, "load-slip") if isinstance(scenario, StudTests) else []

    def simulate(self, scenario: Scenario) -> Response:
        """The fitted law with its band, and how it meets the validating curves."""
        return answer(self, scenario, self._find)

    def _find(self, scenario: StudTests, split: Split) -> Found:
        fit = None
        if not self.published:
            fit = fit_load_slip(split.calibration_points, self.law, confidence=scenario.confidence)
        law = OllgaardLaw() if fit is None else fit.shape
        judged = None
        if not split.validation_points.empty:
            judged = judge_curves(split.validation_points, law, fit, scenario.confidence)
        scalars: dict[str, float | None] = {
            "tests_fitted": 0.0 if fit is None else float(len(fit.curves))
        }
        widths: dict[str, float | None] = {}
        if judged is not None:
            scalars["coverage"] = judged.coverage
            widths["coverage"] = judged.coverage_half_width
            if judged.stiffness is not None:
                scalars["stiffness_test_over_prediction"] = judged.stiffness.bias
                widths["stiffness_test_over_prediction"] = judged.stiffness.half_width
        content = load_slip_content(fit, judged, scenario.confidence)
        return Found(scalars, content, widths, () if fit is None else fit.warnings)


def load_slip_content(
    fit: LoadSlipFit | None, judged: CurveJudgement | None, confidence: float
) -> dict[str, Any]:
    """Everything that is known of a law, for JSON and figures; without a fit, as published."""
    law = OllgaardLaw() if fit is None else fit.shape
    grid: dict[str, Any] = {"slip": GRID, "median": law.ratio(GRID)}
    if fit is not None:
        grid["low"], grid["high"] = fit.band(GRID, confidence)
    return {
        "fit": None if fit is None else fit.to_dict(),
        "curves": None if fit is None else fit.curves,
        "grid": grid,
        "judgement": None if judged is None else judged.to_dict(),
        "judged": None if judged is None else judged.curves,
    }
