"""Plastic strength of a column as hand calculations take it: full moments in a mechanism."""

import numpy as np

from workbench.fields import Choice
from workbench.scenarios import Column

NONE, LINEAR, SECTION = "none", "linear", "section"
AXIAL = Choice((NONE, LINEAR, SECTION))  # how the axial load lowers the plastic moment


def plastic_moment(column: Column, axial: str) -> float:
    """Plastic moment (N m) of the column beside its axial load, held as it is before the hit.

    `axial`: none, M_p; linear, M_p (1 - n); section, of the exact plastic envelope.
    """
    properties = column.properties
    share = abs(column.axial_load) / properties.squash_load
    if axial == SECTION:
        left = float(np.interp(share, *column.strength_section.interaction_envelope()))
    else:
        left = 1.0 - share if axial == LINEAR else 1.0
    return properties.plastic_moment * left


def turning(column: Column) -> float:
    """Rotations of all hinges of the mechanism per displacement of the hit point, per m."""
    return sum((2.0 if clamped else 1.0) / length for length, clamped in column.bars.values())


def mechanism_load(column: Column, axial: str) -> float:
    """Force (N) at the hit point of the mechanism with hinges there and at clamped ends."""
    return plastic_moment(column, axial) * turning(column)


def slope_sum(column: Column) -> float:
    """Turning kappa of both bars of the mechanism against each other per displacement, per m."""
    return 1.0 / column.length_below + 1.0 / column.length_above


def catenary_start(column: Column) -> float:
    """Displacement (m) from which on the chords stretch more than the hinges, r turning / kappa.

    r = M_p / N_p of the linear yield surface.
    """
    arm = column.properties.plastic_moment / column.properties.squash_load
    return arm * turning(column) / slope_sum(column)
