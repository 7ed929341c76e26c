"""The mechanical stud: calibrated on the calibrating tests, judged by the validating ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pandas as pd

from workbench.responses import Finding, Response
from workbench.scenarios import Scenario
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import (
    Found,
    Split,
    about,
    answer,
    load_split,
    shipped_digest,
)
from workbench.studs.judging import judge
from workbench.studs.mechanical import MechanicalFit, calibrate, push_out
from workbench.studs.mechanical.calibration import complete_rows, stud_of

CALIBRATION = "provines2019"  # the shipped campaign with strength, stiffness and slip
DRAWN = 60  # steps of the curves that are kept


@dataclass(frozen=True)
class StudMechanical:
    """A stud as a fiber beam in crushing concrete, with anchorage: strength of push-outs.

    Bearing strength, foundation modulus and slide at rupture are calibrated on strength, stiffness
    and slip of the calibrating campaigns; the other parameters are assumed.
    """

    name: ClassVar[str] = "stud-mechanical"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Co-rotational fiber beam of the shank on two-sided bearing concrete that crushes and "
        "leaves gaps; shear slide at the base that yields; friction under the flange.",
        "No splitting or cracking of the slab: studs whose slab cracks are predicted too strong.",
        "Friction, pressure under the head, cone and rupture strain are assumed, not calibrated.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """The model is this workbench's own."""
        return ()

    @property
    def data_digest(self) -> str:
        """Hash of the shipped tables."""
        return shipped_digest()

    def domain(self, scenario: Scenario) -> list[Finding]:
        """It answers questions of strength."""
        return about(scenario, self.name, "strength") if isinstance(scenario, StudTests) else []

    def simulate(self, scenario: Scenario) -> Response:
        """The calibration, and how the prediction meets the validating tests."""
        return answer(self, scenario, self._find)

    def _find(self, scenario: StudTests, split: Split) -> Found:
        fit = calibrated(scenario)
        ratio = fit.rows["strength_ratio"].to_numpy(float)
        scalars: dict[str, float | None] = {
            "tests_fitted": float(len(fit.rows)),
            "fitted_test_over_prediction": float(pd.Series(ratio).median()),
        }
        widths: dict[str, float | None] = {}
        content: dict[str, Any] = {"fit": fit.to_dict(), "basis": fit.basis, "tests": fit.rows}
        rows = complete_rows(split.calibration)
        if not split.validation.empty:
            judged = judge(_strengths(fit.validate(split.validation)), scenario.confidence)
            scalars |= {
                "test_over_prediction": judged.bias,
                "least_test_over_prediction": judged.least,
            }
            widths["test_over_prediction"] = judged.half_width
            content |= {"judgement": judged.to_dict(), "judged": judged.rows}
            rows = complete_rows(split.validation)
        content["curves"] = [_curve(row, fit) for _, row in rows.drop_duplicates(_STUD).iterrows()]
        return Found(scalars, content, widths, (_scatter(fit),))


_STUD = ["campaign", "diameter_mm", "height_mm", "fcm_MPa", "fu_MPa"]


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


_KEPT: dict[str, MechanicalFit] = {}


def _strengths(rows: pd.DataFrame) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "campaign": rows["campaign"], "specimen": rows["specimen"],
            "test": rows["strength_test"], "prediction": rows["strength_model"],
        }
    )  # fmt: skip


def _curve(row: pd.Series, fit: MechanicalFit) -> dict[str, Any]:
    """Predicted load-slip curve of the stud of a row (SI)."""
    curve = push_out(stud_of(row), fit.around, steps=DRAWN)
    return {
        "campaign": row["campaign"], "specimen": row["specimen"],
        "slip": curve.slip, "load": curve.load, "collar": curve.collar, "friction": curve.friction,
    }  # fmt: skip


def _scatter(fit: MechanicalFit) -> str:
    words = ", ".join(f"{name} {value:.2f}" for name, value in fit.scatter.items())
    return f"{fit.basis}; scatter of the logarithms there: {words}"
