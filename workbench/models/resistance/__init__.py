"""Resistance of the column at its impact point: analytic, two simplifications, panels, given."""

from workbench.models.resistance.columns import PANEL as PANEL
from workbench.models.resistance.columns import OnCurve as OnCurve
from workbench.models.resistance.columns import Resistance as Resistance
from workbench.models.resistance.columns import column_curve as column_curve
from workbench.models.resistance.curve import SECTION as SECTION
from workbench.models.resistance.curve import PlasticMechanism as PlasticMechanism
from workbench.models.resistance.curve import ResistanceCurve as ResistanceCurve
from workbench.models.resistance.curve import axial_flexibility as axial_flexibility
from workbench.models.resistance.curve import mechanism_of as mechanism_of
from workbench.models.resistance.shapes import RESISTANCES as RESISTANCES
from workbench.models.resistance.shapes import resistance_curve as resistance_curve
