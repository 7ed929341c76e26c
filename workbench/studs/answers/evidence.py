"""What stands beside the fits: tests, series, the mechanical stud, interaction laws."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from workbench.errors import InputError, OutOfDomainError
from workbench.evidence import dataset
from workbench.fields import Choice, Number, checked
from workbench.responses import Finding
from workbench.scenarios.laboratory import StudTests
from workbench.studs.answers.common import Found, Split, StudModel, load_split
from workbench.studs.damaged import damaged_rows
from workbench.studs.fit_protocol import judge
from workbench.studs.interaction import INTERACTIONS, borne, combined_tests, curve_of
from workbench.studs.mechanical import MechanicalFit, Stud, calibrate, interaction_points
from workbench.studs.mechanical.calibration import complete_rows, predicted, stud_of
from workbench.studs.quantities import undamaged_headed_studs
from workbench.studs.series import evaluate_groups
from workbench.studs.tables import campaigns_of, first_loading

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

    def find(self, scenario: StudTests, split: Split) -> Found:
        """Every series of the calibrating tests, evaluated or refused with the reason."""
        series = evaluate_groups(
            split.calibration,
            None if split.calibration_points.empty else split.calibration_points,
            specified_strength=self.specified_strength,
            partial_factor=self.partial_factor,
        )
        evaluated = sum(each.tests for each in series if each.result is not None)
        text = (
            "no series of three nominally equal tests within 10 % of their mean: the largest of "
            f"{len(series)} groups has {max(each.tests for each in series)}"
        )
        findings = [] if evaluated else [Finding("series", text)]
        units = {"mean": "N", "lowest": "N", "slips": "m"}
        return Found({"series": series}, findings, None, {"tests_fitted": float(evaluated)}, units)


CALIBRATION = "provines2019"  # the shipped campaign with strength, stiffness and slip
DRAWN = 60  # steps of the curves that are kept
_STUD = ["campaign", "diameter_mm", "height_mm", "fcm_MPa", "fu_MPa"]
_KEPT: dict[str, MechanicalFit] = {}


@dataclass(frozen=True)
class StudMechanical(StudModel):
    """A stud as a fiber beam in crushing concrete, with anchorage: strength of push-outs.

    Bearing strength, foundation modulus and slide at rupture are calibrated on strength, stiffness
    and slip of the calibrating campaigns; the other parameters are assumed.
    """

    name: ClassVar[str] = "stud-mechanical"
    asks: ClassVar[tuple[str, ...]] = ("strength",)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Co-rotational fiber beam of the shank on two-sided bearing concrete that crushes and "
        "leaves gaps; shear slide at the base that yields; friction under the flange.",
        "No splitting or cracking of the slab: strength is limited by the concrete term of the "
        "mean form of EN 1994-1-1, and by the tensile strength of the shank.",
        "No pry-out: studs of less than four diameters are refused.",
        "Friction, pressure under the head, cone and rupture strain are assumed, not calibrated.",
    )

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The calibration, and how the prediction meets the validating tests."""
        fit = calibrated(scenario)
        scalars = {
            "tests_fitted": float(len(fit.rows)),
            "fitted_test_over_prediction": float(fit.rows["strength_ratio"].median()),
        }
        content: dict[str, Any] = {"fit": fit.to_dict(), "basis": fit.basis, "tests": fit.rows}
        rows, judged = complete_rows(split.calibration), None
        if not split.validation.empty:
            unseen = fit.validate(split.validation)
            pair = unseen["strength_test"], unseen["strength_model"]
            judged = judge(unseen, *pair, scenario.confidence)
            content |= {"judgement": judged.to_dict(), "judged": judged.rows}
            rows = complete_rows(split.validation)
        content["curves"] = [_curve(row, fit) for _, row in rows.drop_duplicates(_STUD).iterrows()]
        words = ", ".join(f"{name} {value:.2f}" for name, value in fit.scatter.items())
        text = f"{fit.basis}; scatter of the logarithms there: {words}"
        units = {"test": "N", "prediction": "N"}
        return Found(content, (Finding("evidence", text),), judged, scalars, units)


def calibrated(scenario: StudTests) -> MechanicalFit:
    """The mechanical model calibrated on the calibrating tests of a scenario.

    Kept in this process, as several answers rest on the same rows. Raises `InputError`,
    `SolverError`.
    """
    rows = complete_rows(load_split(scenario).calibration)
    key = rows.to_csv(index=False)
    if key not in _KEPT:
        _KEPT[key] = calibrate(rows)
    return _KEPT[key]


def _curve(row: pd.Series, fit: MechanicalFit) -> dict[str, Any]:
    """Predicted load-slip curve of the stud of a row (SI)."""
    curve = predicted(stud_of(row), fit.around, DRAWN)
    names = {name: row[name] for name in ("campaign", "specimen")}
    parts = ("slip", "load", "collar", "friction")
    return {**names, **{name: getattr(curve, name) for name in parts}}


MECHANICAL = "mechanical"
SHARES = (0.0, 0.25, 0.5, 0.75, 0.9, 0.95, 0.98)  # of the pull-out strength
SOURCES = {"five-thirds": ("aisc360-22",), "linear": (), "trilinear": ("aci318-19",)}
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
        return SOURCES.get(self.law, ())

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The curve of the law, and how it meets combined tests."""
        content: dict[str, Any] = {}
        findings: tuple[Finding, ...] = ()
        if self.law == MECHANICAL:
            stud = Stud.of_concrete(*STUDS[self.governed])
            fit = calibrated(scenario)
            tension, shear = interaction_points(stud, fit.around, SHARES)
            content["stud"] = stud.title
            findings = (Finding("evidence", fit.basis),)
        else:
            tension, shear = curve_of(self.law, 101)
        held = not split.validation.empty
        tests = combined_tests(split.validation if held else split.calibration)
        content |= {"tension": tension, "shear": shear, "tests": tests}
        judged = None
        if held and not tests.empty:
            reached = np.hypot(tests["shear"], tests["tension"])
            judged = judge(tests, reached, borne(tests, tension, shear), scenario.confidence)
            content["judgement"] = judged.to_dict()
        elif self.law != MECHANICAL:
            # a law of the books is drawn all the same; that nothing validates it is said
            text = "no combined test in the validating campaigns"
            findings = (Finding("evidence", text),)
        return Found(content, findings, judged, {"tests_fitted": 0.0})
