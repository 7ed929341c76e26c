"""Resistance of the column at its hit point: analytic curve and its two simplifications."""

from workbench.models.resistance.curve import Event, ResistanceCurve
from workbench.models.resistance.mechanism import Mechanism, mechanism_of
from workbench.models.resistance.shapes import RESISTANCES, resistance_curve

__all__ = [
    "RESISTANCES",
    "Event",
    "Mechanism",
    "ResistanceCurve",
    "mechanism_of",
    "resistance_curve",
]
