"""Fits as models: a strength formula, a load-slip law, what is left after pre-damage.

Each is fitted to the calibrating tests and judged by the validating ones.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pandas as pd

from workbench.errors import InputError
from workbench.fields import Choice, Flag, checked
from workbench.responses import Finding
from workbench.scenarios.laboratory import StudTests
from workbench.studs.answers.common import Found, Split, StudModel
from workbench.studs.answers.evidence import RESIDUAL, calibrated
from workbench.studs.damaged import damaged_rows
from workbench.studs.fit_protocol import judgement_of
from workbench.studs.formulas import FORMULAS, SHEAR_MODELS, usual_stud
from workbench.studs.load_slip import LAWS, OllgaardLaw
from workbench.studs.load_slip_fit import GRID, fit_load_slip, judge_curves
from workbench.studs.mechanical import MechanicalFit, residual_curve
from workbench.studs.mechanical.calibration import USUAL, TableStud, studs_of
from workbench.studs.mechanical.parameters import LENGTH, STRESS
from workbench.studs.mechanical.residual import MEASURES
from workbench.studs.relations import SOURCES, MechanicalCurve
from workbench.studs.residual_fit import ResidualFit, fit_residual
from workbench.studs.schema import TESTS
from workbench.studs.statistics.mixed import LOSSES
from workbench.studs.statistics.mixture import NOTHING, Priors
from workbench.studs.strength_fit import fit_strength
from workbench.studs.tables import own_rows

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
    loss: str = checked(Choice(tuple(LOSSES)), "linear")

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
        return (*FORMULAS[self.formula].keys, *STATISTICS)

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The fit, and how the prediction meets the validating tests."""
        level = scenario.confidence
        fit = fit_strength(split.calibration, self.formula, loss=self.loss, confidence=level)
        judged = None
        if not split.validation.empty:
            judged = fit.judge(split.validation, level, corrected=self.corrected)
        scalars = {"tests_fitted": float(len(fit.rows)), "fitted_test_over_prediction": fit.bias}
        units = {"test": "N", "prediction": "N"}
        content = {**fit.content(judged), "usual": usual_stud(fit.model)}
        return Found(content, fit.findings, judged, scalars, units)


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
        """Only Ollgaard's law has published parameters."""
        if self.published and self.law != "ollgaard":
            raise self.refusal("published", "is known for the law ollgaard only")

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the law and of the statistics."""
        return LAWS[self.law].keys + (() if self.published else ("pinheiro-bates2000",))

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The fitted law with its band, and how it meets the validating curves."""
        level, unseen = scenario.confidence, split.validation_points
        if not self.published:
            fit = fit_load_slip(split.calibration_points, self.law, confidence=level)
            judged = None if unseen.empty else fit.judge(unseen, level)
            fitted = {"tests_fitted": float(len(fit.rows))}
            units = {"strength": "N"}
            return Found(fit.content(judged, level), fit.findings, judged, fitted, units)
        law = OllgaardLaw()
        judged = None if unseen.empty else judge_curves(unseen, law, confidence=level)
        grid = {"slip": GRID, "median": law.ratio(GRID)}
        content = {"fit": None, "curves": None, "grid": grid, **judgement_of(judged)}
        return Found(content, (), judged, {"tests_fitted": 0.0})


ANY = "any"


@dataclass(frozen=True)
class StudResidual(StudModel):
    """Strength or stiffness after pre-damage over that of an undamaged stud.

    Without tests after pre-damage the prediction of the mechanical model for a pull-out, graded as
    not validated; with such tests the relation that cross-validation over campaigns chooses.
    Options: `predamage` and `measure` of the tests to fit (``any``: all, if they are of one kind);
    the stud that the mechanical model computes: `diameter`, `height` in m, `concrete_strength`,
    `ultimate_strength` in Pa (None: that of most tests of one's own tables, else 19 x 100 mm,
    30 MPa and 450 MPa).
    """

    predamage: str = checked(Choice((ANY, *TESTS.words("predamage")[1:])), ANY)
    measure: str = checked(Choice((ANY, *TESTS.words("predamage_measure"))), ANY)
    diameter: float | None = checked(LENGTH, optional=True)
    height: float | None = checked(LENGTH, optional=True)
    concrete_strength: float | None = checked(STRESS, optional=True)
    ultimate_strength: float | None = checked(STRESS, optional=True)

    name: ClassVar[str] = "stud-residual"
    sources: ClassVar[tuple[str, ...]] = SOURCES
    asks: ClassVar[tuple[str, ...]] = tuple(RESIDUAL)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Damage is a share: 0 none, 1 the load, displacement or life at which an undamaged stud "
        "fails; kinds and measures of damage are never mixed.",
        "Mechanical prediction: pull-out to a level, unloading, push-out; its band runs over what "
        "no test at hand tells (share of the bearing that a cone takes, end of the cone, friction, "
        "rupture strain), all at once, and is no confidence interval.",
    )

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The curve of what is left, its grade, and how it meets the validating tests."""
        quantity, level = RESIDUAL[scenario.asked], scenario.confidence
        predamage, measure = (None if w == ANY else w for w in (self.predamage, self.measure))
        sizes = (self.diameter, self.height, self.concrete_strength, self.ultimate_strength)
        units = zip(USUAL, sizes, (1e-3, 1e-3, 1e6, 1e6), strict=True)
        given = {name: None if size is None else size / unit for name, size, unit in units}
        fit, *others = answer_residual(
            split.calibration,
            quantity,
            given,
            lambda: calibrated(scenario),
            predamage=predamage,
            measure=measure,
            confidence=level,
        )
        judged = None
        if not damaged_rows(split.validation, quantity, fit.predamage, fit.measure).empty:
            judged = fit.judge(split.validation, level)
        findings = (Finding("grade", f"{quantity}: {fit.grade}"), *fit.findings)
        if others:
            text = f"answered for {fit.stud} alone, not for {'; '.join(e.stud for e in others)}"
            findings = (*findings, Finding("stud", text, remedy="ask for each with its options"))
        scalars = {"tests_fitted": float(len(fit.rows))}
        return Found(fit.content(judged, level), findings, judged, scalars)


MOST_STUDS = 4  # of a table, that the mechanical model computes one by one


def answer_residual(
    table: pd.DataFrame,
    quantity: str,
    given: Mapping[str, float | None],
    model: Callable[[], MechanicalFit] | None,
    *,
    predamage: str | None = None,
    measure: str | None = None,
    loss: str = "linear",
    confidence: float = 0.9,
    priors: Priors = NOTHING,
) -> list[ResidualFit]:
    """Fit what is left to the tests after pre-damage, or predict it if the table has none.

    One answer from tests; without them one prediction for each stud of one's own tables, that of
    most tests first. Arguments: `table` (schema `TESTS`); `quantity` ``strength`` or ``stiffness``;
    `given`, the stud if the question tells it (see `studs_of`); the mechanical `model`, called
    where it is needed: without tests, or as a candidate for tests that a pull-out damaged, if it
    can be calibrated (None: never); the rest as in `fit_residual`. Raises `InputError`,
    `SolverError`.
    """
    rows = damaged_rows(table, quantity, predamage, measure)
    kind = predamage if rows.empty else str(rows["predamage"].iloc[0])
    level = measure if rows.empty else str(rows["predamage_measure"].iloc[0])
    said: list[Finding] = []
    curves: list[MechanicalCurve | None] = [None]
    if model is not None and kind in (None, "pull-out") and level in (None, *MEASURES):
        try:
            studs, refused = studs_of(rows if len(rows) else own_rows(table), given)
            chosen = studs[: 1 if len(rows) else MOST_STUDS]
            fit = model()
            how: dict[str, Any] = {"measure": level or MEASURES[0], "basis": fit.basis}
            said += _of_studs(chosen, [] if len(rows) else studs[MOST_STUDS:], refused)
            curves = [residual_curve(e.stud, fit.around, quantity, **how) for e in chosen]
        except InputError as error:
            if rows.empty:
                raise
            said.append(Finding("evidence", f"the mechanical model is no candidate: {error}"))
    which: dict[str, Any] = {"predamage": predamage, "measure": measure, "priors": priors}
    which |= {"loss": loss, "confidence": confidence}
    found = (fit_residual(table, quantity, mechanical=curve, **which) for curve in curves)
    return [replace(each, findings=(*said, *each.findings)) for each in found]


def _of_studs(
    studs: list[TableStud], others: list[TableStud], refused: list[str]
) -> Iterator[Finding]:
    """What was assumed of the studs that the mechanical model computes, and which it leaves out."""
    for text in refused:
        yield Finding("stud", f"a stud of the table is not answered for: {text}")
    if studs[0].assumed:
        text = f"stud of the mechanical model: not told, so assumed: {studs[0].assumed}"
        yield Finding("stud", text, remedy="fill these columns, or give the stud as options")
    if others:
        titles = "; ".join(each.stud.title for each in others)
        text = f"{len(others)} further studs of the table are not answered for: {titles}"
        yield Finding("stud", text, remedy="give one of them as options")
