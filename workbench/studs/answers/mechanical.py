"""The mechanical stud: calibrated on the calibrating tests, judged by the validating ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pandas as pd

from workbench.responses import Finding
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, StudModel, load_split
from workbench.studs.fitting import judge
from workbench.studs.mechanical import MechanicalFit, calibrate, push_out
from workbench.studs.mechanical.calibration import complete_rows, stud_of

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
        "No splitting or cracking of the slab: studs whose slab cracks are predicted too strong.",
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
    curve = push_out(stud_of(row), fit.around, steps=DRAWN)
    names = {name: row[name] for name in ("campaign", "specimen")}
    parts = ("slip", "load", "collar", "friction")
    return {**names, **{name: getattr(curve, name) for name in parts}}
