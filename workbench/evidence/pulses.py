"""What errors under pulses hang on: features of a member and its pulse, before anything is run."""

from math import pi, sqrt

from workbench.errors import OutOfDomainError
from workbench.evidence.descriptors import DEMAND, FEATURES
from workbench.models.domain import shear_demand
from workbench.models.practice.biggs import Biggs
from workbench.scenarios import MemberPulse
from workbench.scenarios.pulse import UNIFORM

LOADED, LASTS = "loaded_over_length", "impulse_over_force_and_period"
DRAWN_SHAPES = ("rectangular", "triangular", "exponential", "friedlander")
PULSE_FEATURES = {
    LOADED: "loaded length over length",
    DEMAND: FEATURES[DEMAND],
    LASTS: "impulse over largest force and period",
    "force_over_resistance": "largest force over the resistance of the mechanism",
    "direct_shear": "half of a force at a point over Vpl",
    "axial_over_squash": FEATURES["axial_over_squash"],
    "shorter_over_length": FEATURES["shorter_over_length"],
}


def pulse_features(scenario: MemberPulse) -> dict[str, float]:
    """Numbers of a member under a pulse, without units, by the names of `PULSE_FEATURES`.

    Period and resistance are those of its elastic and its last stage by Biggs. Raises
    `OutOfDomainError` for shapes that were not drawn.
    """
    column, pulse, uniform = scenario.column, scenario.pulse, scenario.load == UNIFORM
    if pulse.shape not in DRAWN_SHAPES:
        raise OutOfDomainError(f"pulses of the shape {pulse.shape} were not drawn")
    elastic, *_, mechanism = Biggs().stages(column, uniform)
    mass = elastic.load_mass_factor * column.properties.mass_per_length * column.length
    period = 2.0 * pi * sqrt(mass / elastic.stiffness)
    force = pulse.peak * scenario.whole
    return {
        LOADED: float(uniform),
        DEMAND: max(shear_demand(scenario).values()),
        LASTS: pulse.whole / pulse.peak / period,
        "force_over_resistance": force / mechanism.load,
        "direct_shear": 0.0 if uniform else 0.5 * force / column.properties.shear_resistance,
        "axial_over_squash": column.axial_load / column.properties.squash_load,
        "shorter_over_length": min(column.length_below, column.length_above) / column.length,
    }
