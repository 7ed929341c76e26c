"""Mechanical model of a stud: fiber beam on bearing concrete, with anchorage."""

from workbench.studs.mechanical.calibration import MechanicalFit as MechanicalFit
from workbench.studs.mechanical.calibration import calibrate as calibrate
from workbench.studs.mechanical.calibration import interaction_points as interaction_points
from workbench.studs.mechanical.calibration import pull_out as pull_out
from workbench.studs.mechanical.calibration import pull_then_push as pull_then_push
from workbench.studs.mechanical.calibration import push_out as push_out
from workbench.studs.mechanical.calibration import residual_curve as residual_curve
from workbench.studs.mechanical.structure import Stud as Stud
from workbench.studs.mechanical.structure import Surroundings as Surroundings
from workbench.studs.mechanical.structure import studs_of as studs_of
