"""What is left of a stud after pre-damage, with the grade of its evidence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.fields import Choice, Number, check_fields, checked
from workbench.responses import Finding, Response
from workbench.scenarios import Scenario
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, about, answer, shipped_digest
from workbench.studs.answers.measured import RESIDUAL
from workbench.studs.answers.mechanical import calibrated
from workbench.studs.judging import Judgement, judge
from workbench.studs.mechanical import MechanicalFit, Stud, residual_curve
from workbench.studs.mechanical.calibration import stud_of
from workbench.studs.quantities import concrete_modulus
from workbench.studs.relations import MechanicalCurve
from workbench.studs.residual import Grade, ResidualFit, damaged_rows, fit_residual
from workbench.studs.schema import PREDAMAGE_MEASURES, PREDAMAGES

MEASURES = ("displacement ratio", "load ratio")
ANY = "any"
LEVELS = np.linspace(0.0, 1.0, 41)
_LENGTH = Number(1e-3, 1.0, "m", advice="lengths are in metres")
_STRESS = Number(1e6, 3e9, "Pa", advice="stresses are in Pa: 30 MPa is 30e6")


@dataclass(frozen=True)
class StudResidual:
    """Strength or stiffness after pre-damage over that of an undamaged stud.

    Without tests after pre-damage the prediction of the mechanical model for a pull-out, graded as
    not validated; with such tests the relation that cross-validation over campaigns chooses.
    Options: `predamage` and `measure` of the tests to fit (``any``: all, if they are of one kind);
    the stud that the mechanical model computes: `diameter`, `height` in m, `concrete_strength`,
    `ultimate_strength` in Pa (where the damaged tests tell their stud, theirs counts).
    """

    predamage: str = checked(Choice((ANY, *PREDAMAGES[1:])), ANY)
    measure: str = checked(Choice((ANY, *PREDAMAGE_MEASURES)), ANY)
    diameter: float = checked(_LENGTH, 0.019)
    height: float = checked(_LENGTH, 0.1)
    concrete_strength: float = checked(_STRESS, 30e6)
    ultimate_strength: float = checked(_STRESS, 450e6)

    name: ClassVar[str] = "stud-residual"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Damage is a share: 0 none, 1 the load, displacement or life at which an undamaged stud "
        "fails; kinds and measures of damage are never mixed.",
        "Mechanical prediction: pull-out to a level, unloading, push-out; its band runs over what "
        "no test at hand tells (share of the bearing that a cone takes, end of the cone, friction) "
        "and is no confidence interval.",
    )

    def __post_init__(self) -> None:
        check_fields(self, "option")

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the relations and of what they are checked by."""
        return ("oehlers1990", "hanswille2007", "oehlers-foley1985", "hastie2009")

    @property
    def data_digest(self) -> str:
        """Hash of the shipped tables."""
        return shipped_digest()

    def domain(self, scenario: Scenario) -> list[Finding]:
        """It answers questions of residual capacity."""
        return about(scenario, self.name, *RESIDUAL) if isinstance(scenario, StudTests) else []

    def simulate(self, scenario: Scenario) -> Response:
        """The curve of what is left, its grade, and how it meets the validating tests."""
        return answer(self, scenario, self._find)

    def _find(self, scenario: StudTests, split: Split) -> Found:
        quantity = RESIDUAL[scenario.asked]
        predamage, measure = (None if w == ANY else w for w in (self.predamage, self.measure))
        stud = Stud(
            self.diameter, self.height, self.concrete_strength,
            float(concrete_modulus(self.concrete_strength)), self.ultimate_strength,
        )  # fmt: skip
        fit = answer_residual(
            split.calibration, quantity, stud, lambda: calibrated(scenario),
            predamage=predamage, measure=measure, confidence=scenario.confidence,
        )  # fmt: skip
        judged = None
        if not damaged_rows(split.validation, quantity, fit.predamage, fit.measure).empty:
            judged = judge_residual(fit, split.validation, scenario.confidence)
        scalars: dict[str, float | None] = {"tests_fitted": float(len(fit.rows))}
        widths: dict[str, float | None] = {}
        if judged is not None:
            scalars |= {
                "test_over_prediction": judged.bias,
                "least_test_over_prediction": judged.least,
            }
            widths["test_over_prediction"] = judged.half_width
        content = residual_content(fit, judged, scenario.confidence)
        return Found(scalars, content, widths, (f"{quantity}: {fit.grade}", *fit.warnings))


def answer_residual(
    table: pd.DataFrame,
    quantity: str,
    stud: Stud,
    model: Callable[[], MechanicalFit] | None,
    *,
    predamage: str | None = None,
    measure: str | None = None,
    confidence: float = 0.9,
    resamples: int = 300,
) -> ResidualFit:
    """Fit what is left to the tests after pre-damage, or predict it if the table has none.

    Arguments: `table` (schema `TESTS`); `quantity` ``strength`` or ``stiffness``; the `stud` that
    the mechanical `model` computes, called where it is needed: without tests, or as a candidate for
    tests that a pull-out damaged, if it can be calibrated (None: never); the rest as in
    `fit_residual`. Raises `InputError`, `SolverError`.
    """
    rows = damaged_rows(table, quantity, predamage, measure)
    mechanical: MechanicalCurve | None = None
    absent: tuple[str, ...] = ()
    kind = predamage if rows.empty else str(rows["predamage"].iloc[0])
    level = measure if rows.empty else str(rows["predamage_measure"].iloc[0])
    if model is not None and kind in (None, "pull-out") and level in (None, *MEASURES):
        try:
            calibration = model()
            mechanical = residual_curve(
                _stud_of_tests(rows) or stud, calibration.around, quantity,
                measure=level or MEASURES[0], basis=calibration.basis,
            )  # fmt: skip
        except InputError as error:
            if rows.empty:
                raise
            absent = (f"the mechanical model is no candidate: {error}",)
    fit = fit_residual(
        table, quantity, predamage=predamage, measure=measure, mechanical=mechanical,
        confidence=confidence, resamples=resamples,
    )  # fmt: skip
    return replace(fit, warnings=(*fit.warnings, *absent))


def _stud_of_tests(rows: pd.DataFrame) -> Stud | None:
    """The stud that all damaged tests share, with mean material values (None: not one stud)."""
    if rows.empty or rows[["diameter_mm", "height_mm"]].drop_duplicates().shape[0] != 1:
        return None
    first = rows.iloc[0].copy()
    for column in ("fcm_MPa", "fu_MPa", "Ecm_MPa", "density_kg_per_m3"):
        first[column] = rows[column].astype(float).mean()
    known = first[["diameter_mm", "height_mm", "fcm_MPa", "fu_MPa"]].to_numpy(float)
    return stud_of(first) if np.all(np.isfinite(known)) else None


def judge_residual(fit: ResidualFit, table: pd.DataFrame, confidence: float = 0.9) -> Judgement:
    """Hold what is predicted to be left against tests that the fit has not used.

    Raises `InputError` when there are none, or a row was used for the fit.
    """
    rows = damaged_rows(table, fit.quantity, fit.predamage, fit.measure)
    if rows.empty:
        raise InputError("validation", 0, f"holds no test after {fit.predamage}")
    fit.refuse_seen(rows)
    predicted = fit.left(rows["level"].to_numpy(float))
    frame = pd.DataFrame(
        {
            "campaign": rows["campaign"], "specimen": rows["specimen"], "level": rows["level"],
            "test": rows["ratio"].astype(float), "prediction": predicted,
        }
    )  # fmt: skip
    known = np.isfinite(predicted) & (predicted > 0.0)
    return judge(frame[known], confidence)


def residual_content(
    fit: ResidualFit, judged: Judgement | None, confidence: float
) -> dict[str, Any]:
    """Everything that is known of what is left, for JSON and figures."""
    band = fit.band(LEVELS, confidence)
    low, high = (None, None) if band is None else band
    columns = ["campaign", "specimen", "level", "ratio", "origin"]
    tests = fit.rows[columns] if len(fit.rows) else pd.DataFrame(columns=columns)
    mechanical = None
    if fit.mechanical is not None:
        curve = fit.mechanical
        mechanical = {"level": curve.level, "ratio": curve.ratio, "low": curve.low,
                      "high": curve.high, "basis": curve.basis}  # fmt: skip
    return {
        "fit": fit.to_dict(),
        "validated": fit.estimate is not None and fit.grade is Grade.CROSS_VALIDATED,
        "curve": {"level": LEVELS, "left": fit.left(LEVELS), "low": low, "high": high},
        "tests": tests,
        "mechanical": mechanical,
        "judgement": None if judged is None else judged.to_dict(),
        "judged": None if judged is None else judged.rows,
    }
