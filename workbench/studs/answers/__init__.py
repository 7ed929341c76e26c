"""Fits and mechanical predictions as models: they answer what is asked of tests on studs."""

from workbench.studs.answers.evidence import StudInteraction as StudInteraction
from workbench.studs.answers.evidence import StudMeasured as StudMeasured
from workbench.studs.answers.evidence import StudMechanical as StudMechanical
from workbench.studs.answers.evidence import StudSeries as StudSeries
from workbench.studs.answers.fits import StudLoadSlip as StudLoadSlip
from workbench.studs.answers.fits import StudResidual as StudResidual
from workbench.studs.answers.fits import StudStrength as StudStrength
