"""Mechanical model of a stud: fiber beam on bearing concrete, with anchorage."""

from workbench.studs.mechanical.calibration import MechanicalFit, calibrate
from workbench.studs.mechanical.driving import pull_out, pull_then_push, push_out
from workbench.studs.mechanical.parameters import Stud, Surroundings
from workbench.studs.mechanical.residual import interaction_points, residual_curve

__all__ = [
    "MechanicalFit",
    "Stud",
    "Surroundings",
    "calibrate",
    "interaction_points",
    "pull_out",
    "pull_then_push",
    "push_out",
    "residual_curve",
]
