"""Fits and mechanical predictions as models: they answer what is asked of tests on studs."""

from workbench.studs.answers.interaction import StudInteraction
from workbench.studs.answers.load_slip import StudLoadSlip
from workbench.studs.answers.measured import StudMeasured
from workbench.studs.answers.mechanical import StudMechanical
from workbench.studs.answers.residual import StudResidual
from workbench.studs.answers.series import StudSeries
from workbench.studs.answers.strength import StudStrength

__all__ = [
    "StudInteraction",
    "StudLoadSlip",
    "StudMeasured",
    "StudMechanical",
    "StudResidual",
    "StudSeries",
    "StudStrength",
]
