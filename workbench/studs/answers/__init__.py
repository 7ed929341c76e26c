"""Fits and mechanical predictions as models: they answer what is asked of tests on studs."""

from workbench.studs.answers.evidence import (
    StudInteraction,
    StudMeasured,
    StudMechanical,
    StudSeries,
)
from workbench.studs.answers.fits import StudLoadSlip, StudResidual, StudStrength

__all__ = [
    "StudInteraction",
    "StudLoadSlip",
    "StudMeasured",
    "StudMechanical",
    "StudResidual",
    "StudSeries",
    "StudStrength",
]
