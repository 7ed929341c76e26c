"""Numbers that describe hits and pulses before a run, and the variants of models."""

import dataclasses
from functools import lru_cache
from math import pi, sqrt
from typing import Any

from workbench.base.errors import OutOfDomainError
from workbench.mechanics.frames.column_estimate import column_like
from workbench.models.domain import shear_demand
from workbench.models.hit_mass import elastic_energy, front_velocity
from workbench.models.resistance.deflected_shape import stages_of
from workbench.models.strain_rate import rate_factor, stronger
from workbench.scenarios import ColumnImpact, FrameImpact, MemberPulse
from workbench.scenarios.pulse import UNIFORM

DEMAND, YIELDING, STRIKER = "shear_demand", "energy_over_elastic", "striker_over_lumped"
FEATURES = {  # of the error model, and their words
    DEMAND: "V/Vpl of the mechanism",
    YIELDING: "energy of the hit over the elastic one",
    STRIKER: "striker over lumped mass",
    "turned": "energy of the hit over the work of the mechanism per length of the shorter segment",
    "axial_over_squash": "axial load over the squash load",
    "stiffening": "pull of the restraint less the axial load, over the mechanism",
    "front": "velocity over the one from which shear waves yield the webs",
    "shorter_over_length": "shorter segment over the length",
}
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
FRAME_FEATURES = FEATURES | {"members": "members of the frame"}
FACTOR = "rate_factor"
RATE_FEATURES = {
    DEMAND: FEATURES[DEMAND],
    STRIKER: FEATURES[STRIKER],
    FACTOR: "factor on the yield stress for the strain rate",
}
_NO_NUMBERS = ("levels",)  # options that leave the answer as it is


def features(scenario: ColumnImpact) -> dict[str, float]:
    """The numbers that the error of a column may hang on, by the names of `FEATURES`.

    The pull acts at the displacement that the mechanism alone would need, elastic up to the squash
    load, and across the column by the turn of both segments.
    """
    column, striker, demand = scenario.column, scenario.striker, shear_demand(scenario)
    properties, below, above = column.properties, column.length_below, column.length_above
    lumped = properties.impact_mass / striker.mass
    resistance = sum(min(each, 1.0) for each in demand.values()) * properties.shear_resistance
    values = {
        DEMAND: max(demand.values()),
        YIELDING: scenario.input_energy / (1.0 + lumped) / elastic_energy(column),
        STRIKER: 1.0 / lumped,
    }
    way = scenario.input_energy / (1.0 + 1.0 / values[STRIKER]) / resistance
    turn = way / below + way / above
    stiffness = column.steel.elastic_modulus * properties.area / column.length
    if column.head != "fixed":
        ratio = column.restraint_stiffness / stiffness
        stiffness *= ratio / (1.0 + ratio)
    pull = min(0.5 * stiffness * way * turn, properties.squash_load)
    return {
        **values,
        "turned": way / min(below, above),
        "axial_over_squash": column.axial_load / properties.squash_load,
        "stiffening": (pull - column.axial_load) * turn / resistance,
        "front": striker.velocity / front_velocity(scenario),
        "shorter_over_length": min(below, above) / column.length,
    }


def rate_features(scenario: ColumnImpact) -> dict[str, float]:
    """Features of the column with one factor on the yield stress, and the factor, of a rate law."""
    factor = rate_factor(scenario, shear_yields=True)
    return {**features(stronger(scenario, factor)), FACTOR: factor}


def pulse_features(scenario: MemberPulse) -> dict[str, float]:
    """Numbers of a member under a pulse, without units, by the names of `PULSE_FEATURES`.

    Period and resistance are those of its elastic and its last stage by Biggs. Raises
    `OutOfDomainError` for shapes that were not drawn.
    """
    column, pulse, uniform = scenario.column, scenario.pulse, scenario.load == UNIFORM
    if pulse.shape not in DRAWN_SHAPES:
        raise OutOfDomainError(f"pulses of the shape {pulse.shape} were not drawn")
    elastic, *_, mechanism = stages_of(column, uniform=uniform)
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


def frame_features(scenario: FrameImpact) -> dict[str, float]:
    """Features of the struck column as its frame holds it, and the `members`, by `FRAME_FEATURES`.

    Raises `OutOfDomainError` for what was not drawn: hits on no column, joints that turn, springs.
    """
    column, frame = column_like(scenario), scenario.frame
    if frame.joints or any(n.spring_x or n.spring_y or n.spring_rotation for n in frame.nodes):
        raise OutOfDomainError("frames with springs or joints that turn were not drawn")
    if column is None:
        raise OutOfDomainError("hits on columns between their ends were drawn")
    return {**features(column), "members": float(len(frame.members))}


@lru_cache(maxsize=256)
def _options(model: Any) -> tuple[str, ...]:
    """The options of a model that differ from the default and change its numbers: ``a=1``."""
    values = ((f.name, f.default, getattr(model, f.name)) for f in dataclasses.fields(model))
    return tuple(
        f"{name}={value}"
        for name, default, value in values
        if value != default and name not in _NO_NUMBERS
    )


def variant_of(model: Any) -> str:
    """The options of a model that differ from the default and change its numbers: ``a=1 b=x``."""
    return " ".join(_options(model))


def command_of(model: Any) -> str:
    """A model with these options as the command line names it."""
    return " --option ".join((model.name, *_options(model)))
