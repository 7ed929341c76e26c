"""Numbers that describe columns and hits before a run, and the variants of models.

Cells and ranges of the error model are bounded by these.
"""

import dataclasses
from collections.abc import Mapping
from functools import lru_cache
from math import inf, sqrt
from typing import Any

import pandas as pd

from workbench.datafiles import data_directory
from workbench.models.domain import euler_load, shear_demand
from workbench.models.hit_mass import elastic_energy, front_velocity
from workbench.scenarios import ColumnImpact

DEMAND, YIELDING, STRIKER = "shear_demand", "energy_over_elastic", "striker_over_lumped"
WORDS = {  # of the descriptors
    DEMAND: "V/Vpl of the mechanism",
    YIELDING: "energy of the hit over the elastic one",
    "below_over_height": "segment below over the height of the section",
    "above_over_height": "segment above over the height of the section",
    "axial_over_squash": "axial load over the squash load",
    "axial_over_euler": "axial load over the Euler load",
    "velocity_over_plastic": "velocity over (fy / rho)^½",
    STRIKER: "striker over lumped mass",
    "restraint_over_axial": "restraint over axial stiffness of the column",
    "shape_factor": "shape factor",
    "restitution": "restitution",
    "head_mass_over_striker": "mass at the head over the striker",
    "fixed_head": "fixed head (1: yes)",
}
_NO_NUMBERS = ("levels",)  # options that leave the answer as it is


def descriptors(scenario: ColumnImpact) -> dict[str, float]:
    """Numbers that describe a column and its hit, without units, by names of `WORDS`."""
    column, striker = scenario.column, scenario.striker
    properties, section, steel = column.properties, column.section, column.steel
    lumped = properties.impact_mass / striker.mass
    axial = steel.elastic_modulus * properties.area / column.length
    return {
        DEMAND: max(shear_demand(scenario).values()),
        YIELDING: scenario.input_energy / (1.0 + lumped) / elastic_energy(column),
        "below_over_height": column.length_below / section.height,
        "above_over_height": column.length_above / section.height,
        "axial_over_squash": column.axial_load / properties.squash_load,
        "axial_over_euler": column.axial_load / euler_load(scenario),
        "velocity_over_plastic": striker.velocity / sqrt(steel.yield_stress / steel.density),
        STRIKER: 1.0 / lumped,
        "restraint_over_axial": column.restraint_stiffness / axial,
        "shape_factor": section.plastic_section_modulus / section.elastic_section_modulus,
        "restitution": striker.restitution,
        "head_mass_over_striker": column.head_mass / striker.mass,
        "fixed_head": float(column.head == "fixed"),
    }


@lru_cache(maxsize=8)
def measured_rows(table: str) -> list[dict[str, Any]]:
    """Rows of a `table` of what studies measured of models; NaN where there is no number."""
    path = data_directory() / "validation" / f"{table.replace('-', '_')}.csv"
    return pd.read_csv(path).fillna({"options": ""}).to_dict("records")  # type: ignore[return-value]


def beyond(values: Mapping[str, float], table: str) -> dict[str, str]:
    """Descriptors of a column, by their `values`, that the columns of a study did not span."""
    texts = {}
    for row in measured_rows(table):
        name, low, high = row["descriptor"], row["low"], row["high"]
        if not low <= values[name] <= high:
            span = f"{low:g} only" if low == high else f"{low:g} to {high:g}"
            texts[name] = f"{WORDS[name]} {values[name]:.3g}: columns were measured at {span}"
    return texts


FEATURES = {  # of the error model, and their words
    **{name: WORDS[name] for name in (DEMAND, YIELDING, STRIKER)},
    "turned": "energy of the hit over the work of the mechanism per length of the shorter segment",
    "axial_over_squash": WORDS["axial_over_squash"],
    "stiffening": "pull of the restraint less the axial load, over the mechanism",
    "front": "velocity over the one from which shear waves yield the webs",
    "shorter_over_length": "shorter segment over the length",
}


def features(
    scenario: ColumnImpact, described: Mapping[str, float] | None = None
) -> dict[str, float]:
    """The numbers that the error of a column may hang on, by the names of `FEATURES`.

    Of a scenario whose `descriptors` are known, or not yet.

    The pull acts at the displacement that the mechanism alone would need, elastic up to the squash
    load, and across the column by the turn of both segments.
    """
    values, column = dict(described or descriptors(scenario)), scenario.column
    properties, below, above = column.properties, column.length_below, column.length_above
    resistance = sum(min(each, 1.0) for each in shear_demand(scenario).values())
    resistance *= properties.shear_resistance
    way = scenario.input_energy / (1.0 + 1.0 / values[STRIKER]) / resistance
    turn = way / below + way / above
    stiffness = column.steel.elastic_modulus * properties.area / column.length
    if column.head != "fixed":
        ratio = values["restraint_over_axial"]
        stiffness *= ratio / (1.0 + ratio)
    pull = min(0.5 * stiffness * way * turn, properties.squash_load)
    values["turned"] = way / min(below, above)
    values["stiffening"] = (pull - column.axial_load) * turn / resistance
    values["front"] = scenario.striker.velocity / front_velocity(scenario)
    values["shorter_over_length"] = min(below, above) / column.length
    return {name: values[name] for name in FEATURES}


def region_of(
    bounds: Mapping[str, tuple[float, float]], values: Mapping[str, float] | None = None
) -> str:
    """A region in words, from its `bounds` by feature; with the `values` of a column."""
    parts = (
        f"{FEATURES[name]} {f'{values[name]:.3g}, ' if values else ''}{_between(*ends)}"
        for name, ends in bounds.items()
    )
    return "; ".join(parts)


def _between(low: float, high: float) -> str:
    if low == -inf:
        return f"below {high:g}"
    return f"above {low:g}" if high == inf else f"{low:g} to {high:g}"


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
