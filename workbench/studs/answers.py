"""Fits, series, the mechanical stud and laws of the books as models of a study.

Each answers from the calibrating tests and is judged by the validating ones.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from workbench.base.fields import Choice, Flag, Number, checked
from workbench.responses import finding
from workbench.scenarios.stud_tests import StudTests
from workbench.studs.damaged import damaged_rows
from workbench.studs.fit_protocol import StudAnswer, answer_of, answer_tables, judge
from workbench.studs.formulas import FORMULAS, SHEAR_MODELS, usual_stud
from workbench.studs.interaction import INTERACTIONS, borne, combined_tests
from workbench.studs.laboratory import CALIBRATION as CALIBRATION
from workbench.studs.laboratory import answer_residual
from workbench.studs.load_slip import GRID, LAWS, OllgaardLaw, fit_load_slip, judge_curves
from workbench.studs.mechanical import MechanicalFit, Stud, calibrate, interaction_points
from workbench.studs.mechanical.calibration import complete_rows, predicted_curves
from workbench.studs.mechanical.structure import LENGTH, STRESS
from workbench.studs.model import RESIDUAL, DataSplit, StudModel, load_split
from workbench.studs.model import StudMeasured as StudMeasured
from workbench.studs.relations import SOURCES
from workbench.studs.schema import TESTS, USUAL
from workbench.studs.series import evaluate_groups
from workbench.studs.statistics.mixed import LOSSES
from workbench.studs.strength_fit import fit_strength
from workbench.studs.tables import points_of

_NEWTONS = {"test": "N", "prediction": "N"}


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
    units: ClassVar[Mapping[str, str]] = _NEWTONS
    assumptions: ClassVar[tuple[str, ...]] = (
        "Smaller of a steel and a concrete term with the mean values of the tests, headed studs in "
        "solid slabs, undamaged.",
        "The logarithm of test over prediction has a bias, a normal effect per campaign and a "
        "normal scatter within campaigns; EN 1990 D.8 takes all tests as independent.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the formula and of the statistics."""
        return (*FORMULAS[self.formula].keys, "en1990", "pinheiro-bates2000")

    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """The fit, and how the prediction meets the validating tests."""
        level, how = scenario.confidence, "as fitted" if self.corrected else "as it is"
        fit = fit_strength(split.calibration, self.formula, loss=self.loss, confidence=level)
        answer = answer_of(fit, split.validation, level, how, corrected=self.corrected)
        if usual := usual_stud(fit.model):
            answer.tables["usual"] = pd.DataFrame([usual])
        return replace(answer, scalars={**answer.scalars, "fitted_test_over_prediction": fit.bias})


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
    units: ClassVar[Mapping[str, str]] = {"strength": "N"}
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

    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """The law with its band, the points, and how it meets the validating curves."""
        level, unseen = scenario.confidence, split.validation_points
        points = points_of(split.calibration_points, unseen)
        if self.published:
            law = OllgaardLaw()
            judged = None if unseen.empty else judge_curves(unseen, law, confidence=level)
            grid = pd.DataFrame({"slip": GRID, "median": law.ratio(GRID)})
            summary = {"law": law.name, "published": True}
            tables = answer_tables(summary, {"points": points, "grid": grid}, judged)
            return StudAnswer(tables, (), judged, {"tests_fitted": 0.0})
        fit = fit_load_slip(split.calibration_points, self.law, confidence=level)
        answer = answer_of(fit, unseen, level, "fitted")
        answer.tables["points"] = points
        return answer


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

    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """The curve of what is left, its grade, and how it meets the validating tests."""
        quantity, level = RESIDUAL[scenario.asked], scenario.confidence
        predamage, measure = (None if w == ANY else w for w in (self.predamage, self.measure))
        sizes = (self.diameter, self.height, self.concrete_strength, self.ultimate_strength)
        units = zip(USUAL, sizes, (1e-3, 1e-3, 1e6, 1e6), strict=True)
        given = {name: None if size is None else size / unit for name, size, unit in units}
        which: dict[str, Any] = {"predamage": predamage, "measure": measure, "confidence": level}
        fit, *others = answer_residual(
            split.calibration, quantity, given, lambda: calibrated(scenario), **which
        )
        held = damaged_rows(split.validation, quantity, fit.predamage, fit.measure)
        findings = [finding("stud-grade", quantity=quantity, grade=fit.grade), *fit.findings]
        if others:
            titles = "; ".join(each.stud for each in others)
            findings.append(finding("stud-other-answers", stud=fit.stud, others=titles))
        held = held if held.empty else split.validation  # with the companions of damaged tests
        return replace(answer_of(fit, held, level, "fitted"), findings=findings)


@dataclass(frozen=True)
class StudSeries(StudModel):
    """Characteristic and design resistance, slip capacity and ductility of series of push tests.

    Options: `specified_strength`, minimum tensile strength of the stud material in Pa;
    `partial_factor` gamma_V.
    """

    specified_strength: float = checked(Number(2e8, 1.5e9, "Pa"), 450e6)
    partial_factor: float = checked(Number(1.0, 3.0), 1.25)

    name: ClassVar[str] = "stud-series"
    sources: ClassVar[tuple[str, ...]] = ("en1994-1-1",)
    asks: ClassVar[tuple[str, ...]] = ("strength",)
    assumptions: ClassVar[tuple[str, ...]] = (
        "EN 1994-1-1, B.2: three or more nominally equal tests within 10 % of their mean.",
        "Equal means: campaign, diameter, height, slab, arrangement and stud strength, and "
        "cylinder strengths within 10 %.",
    )

    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """Every series of the calibrating tests, evaluated or refused with the reason."""
        series = evaluate_groups(
            split.calibration,
            None if split.calibration_points.empty else split.calibration_points,
            specified_strength=self.specified_strength,
            partial_factor=self.partial_factor,
        )
        evaluated = sum(each.tests for each in series if each.result is not None)
        largest = max(each.tests for each in series)
        none = [] if evaluated else [finding("stud-no-series", groups=len(series), largest=largest)]
        tables = {"series": pd.DataFrame([each.summary() for each in series])}
        return StudAnswer(tables, none, None, {"tests_fitted": float(evaluated)})


@dataclass(frozen=True)
class StudMechanical(StudModel):
    """A stud as a fiber beam in crushing concrete, with anchorage: strength of push-outs.

    Bearing strength, foundation modulus and slide at rupture are calibrated on strength, stiffness
    and slip of the calibrating campaigns; the other parameters are assumed.
    """

    name: ClassVar[str] = "stud-mechanical"
    asks: ClassVar[tuple[str, ...]] = ("strength",)
    units: ClassVar[Mapping[str, str]] = _NEWTONS
    assumptions: ClassVar[tuple[str, ...]] = (
        "Co-rotational fiber beam of the shank on two-sided bearing concrete that crushes and "
        "leaves gaps; shear slide at the base that yields; friction under the flange.",
        "No splitting or cracking of the slab: strength is limited by the concrete term of the "
        "mean form of EN 1994-1-1, and by the tensile strength of the shank.",
        "No pry-out: studs of less than four diameters are refused.",
        "Friction, pressure under the head, cone and rupture strain are assumed, not calibrated.",
    )

    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """The calibration, and how the prediction meets the validating tests."""
        fit = calibrated(scenario)
        rows, judged = complete_rows(split.calibration), None
        if not split.validation.empty:
            unseen = fit.validate(split.validation)
            pair = unseen["strength_test"], unseen["strength_model"]
            judged = judge(unseen, *pair, scenario.confidence)
            rows = complete_rows(split.validation)
        tables = answer_tables(fit.summary(), fit.tables(), judged)
        tables["curves"] = predicted_curves(rows, fit.around)
        scalars = {
            "tests_fitted": float(len(fit.rows)),
            "fitted_test_over_prediction": float(fit.rows["strength_ratio"].median()),
        }
        words = ", ".join(f"{name} {value:.2f}" for name, value in fit.scatter.items())
        basis = finding(
            "stud-basis", basis=f"{fit.basis}; scatter of the logarithms there: {words}"
        )
        return StudAnswer(tables, (basis,), judged, scalars)


def calibrated(scenario: StudTests) -> MechanicalFit:
    """The mechanical model calibrated on the calibrating tests of a scenario.

    Raises `InputError`, `SolverError`.
    """
    names = ("tables", "calibrate", "validate", "digests")
    return _calibrated(*(getattr(scenario, name) for name in names))


@lru_cache(maxsize=4)  # seven answers of the study rest on the same rows, some 10 s each
def _calibrated(
    tables: tuple[str, ...],
    calibrating: tuple[str, ...],
    validating: tuple[str, ...],
    digests: tuple[str, ...] | None,
) -> MechanicalFit:
    named: dict[str, Any] = {"tables": tables, "calibrate": calibrating, "validate": validating}
    split = load_split(StudTests("calibration", **named, digests=digests))
    return calibrate(complete_rows(split.calibration))


MECHANICAL = "mechanical"
SHARES = (0.0, 0.25, 0.5, 0.75, 0.9, 0.95, 0.98)  # of the pull-out strength
# two ways to fail under tension: the concrete cone of a usual stud, the shank of a deep slim one
STUDS = {"cone": (0.019, 0.1, 30e6, 450e6), "steel": (0.0127, 0.12, 60e6, 450e6)}


@dataclass(frozen=True)
class StudInteraction(StudModel):
    """Shear that is left under tension, both over what the stud bears alone.

    Options: `law`, a name in `workbench.studs.INTERACTIONS` or ``mechanical``; `governed`, for the
    mechanical model, whether cone or steel governs the pull-out of the stud that is computed.
    """

    law: str = checked(Choice((*INTERACTIONS, MECHANICAL)), "five-thirds")
    governed: str = checked(Choice(tuple(STUDS)), "cone")

    name: ClassVar[str] = "stud-interaction"
    asks: ClassVar[tuple[str, ...]] = ("interaction",)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Tension and shear over the resistances of equal studs under one of them alone.",
        "Mechanical model: a constant tension on the flange during the push-out; the slip counts "
        "up to that at which the stud tears without tension.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the law."""
        return () if self.law == MECHANICAL else INTERACTIONS[self.law].keys

    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """The curve of the law, and how it meets combined tests."""
        findings, stud = [], ""
        if self.law == MECHANICAL:
            computed, fit = Stud.of_concrete(*STUDS[self.governed]), calibrated(scenario)
            tension, shear = interaction_points(computed, fit.around, SHARES)
            stud = computed.title
            findings.append(finding("stud-basis", basis=fit.basis))
        else:
            tension, shear = INTERACTIONS[self.law].curve(101)
        held = not split.validation.empty
        tests, judged = combined_tests(split.validation if held else split.calibration), None
        if held and not tests.empty:
            reached = np.hypot(tests["shear"], tests["tension"])
            judged = judge(tests, reached, borne(tests, tension, shear), scenario.confidence)
        elif self.law != MECHANICAL:
            # a law of the books is drawn all the same; that nothing validates it is said
            findings = [finding("stud-no-combined-test")]
        tables = {"curve": pd.DataFrame({"tension": tension, "shear": shear}), "tests": tests}
        tables = answer_tables({"law": self.law, "stud": stud}, tables, judged)
        return StudAnswer(tables, findings, judged, {"tests_fitted": 0.0})
