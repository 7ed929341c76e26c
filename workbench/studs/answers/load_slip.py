"""A load-slip law: fitted to the calibrating curves, judged by the validating ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from workbench.fields import Choice, Flag, checked
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, StudModel
from workbench.studs.fitting import content_of_fit
from workbench.studs.load_slip import LAWS, OllgaardLaw
from workbench.studs.load_slip_fit import GRID, fit_load_slip, judge_curves

SOURCES = {
    "ollgaard": ("ollgaard1971",),
    "bilinear": ("roik1989",),
    "rational": ("sargin1971",),
}


@dataclass(frozen=True)
class StudLoadSlip(StudModel):
    """Load over its largest value as a function of slip, under first loading.

    Options: `law`, a name in `workbench.studs.LAWS`; `published`, Ollgaard's law with its published
    parameters instead of fitted ones.
    """

    law: str = checked(Choice(tuple(LAWS)), "ollgaard")
    published: bool = checked(Flag(), False)

    name: ClassVar[str] = "stud-load-slip"
    asks: ClassVar[tuple[str, ...]] = ("load-slip",)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Shape of the curve only: loads are over the largest load of the test.",
        "Curves are the observations, not points; the logarithms of the parameters have an effect "
        "per campaign. The band holds the stated share of the points of a further curve of the "
        "fitted campaigns, fewer of a new one.",
    )

    def check(self) -> None:
        """Refuse published values for a law that has none."""
        if self.published and self.law != "ollgaard":
            raise self.refusal("published", "is known for the law ollgaard only")

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the law and of the statistics."""
        return SOURCES[self.law] + (() if self.published else ("pinheiro-bates2000",))

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The fitted law with its band, and how it meets the validating curves."""
        level, unseen = scenario.confidence, split.validation_points
        if not self.published:
            fit = fit_load_slip(split.calibration_points, self.law, confidence=level)
            judged = None if unseen.empty else fit.judge(unseen, level)
            fitted = {"tests_fitted": float(len(fit.curves))}
            units = {"strength": "N"}
            return Found(fit.content(judged, level), fit.findings, judged, fitted, units)
        law = OllgaardLaw()
        judged = None if unseen.empty else judge_curves(unseen, law, confidence=level)
        grid = {"slip": GRID, "median": law.ratio(GRID)}
        content = content_of_fit(None, judged, curves=None, grid=grid)
        return Found(content, (), judged, {"tests_fitted": 0.0})
