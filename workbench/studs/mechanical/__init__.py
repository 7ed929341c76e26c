"""Mechanical model of a stud: fiber beam on bearing concrete, with anchorage."""

from workbench.studs.mechanical.calibration import MechanicalFit, calibrate, predict_rows
from workbench.studs.mechanical.driving import (
    PullCurve,
    ShearCurve,
    pull_out,
    pull_then_push,
    push_out,
)
from workbench.studs.mechanical.parameters import Stud, Surroundings
from workbench.studs.mechanical.residual import interaction_points, residual_curve

__all__ = [
    "MechanicalFit",
    "PullCurve",
    "ShearCurve",
    "Stud",
    "Surroundings",
    "calibrate",
    "interaction_points",
    "predict_rows",
    "pull_out",
    "pull_then_push",
    "push_out",
    "residual_curve",
]
