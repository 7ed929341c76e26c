"""How much of a column's mass shares the velocity of its striker at once.

Rule "thesis" (Heng 2017, section 5.2): m, a third of the mass of two straight bars; an inelastic
hit costs ½ m v0² / (1 + mu), mu its ratio to the mass of the striker. Rule "waves": each bar, of
the share l_i / L of the column, gives

  [1 - (1 - v_s / v0) (1 - f) - (1 - E_el (1 + mu) / E) g] m l_i / L,   g at most 1,

f = (1 - r) (1 + mu) / (1 - r + mu) what is lost of that where webs yield in shear, from the
velocity v_s on, r V_pl the shear force of the mechanism; g = 2 t M / (m l v0) the work that the far
hinge, of moment M, does not do before it feels the hit, after t = pi / (2 omega) of the first mode
of the bar, hinged where it is hit and clamped behind; E_el the elastic energy at the mechanism. The
column gives never less than a piece as long as its section is high. Derivation, what the rule does
to bias and scatter, and where the argument is weak: docs/theory/hit-mass.md.
"""

from math import pi, sqrt
from typing import Any

import numpy as np

from workbench.base.codec import set_inputs
from workbench.base.fields import Choice
from workbench.models.domain import mechanism_demand
from workbench.responses import Finding, finding
from workbench.scenarios import Column, ColumnImpact

THESIS, WAVES = "thesis", "waves"
HIT_MASS = Choice((THESIS, WAVES))
_FIRST_MODE = 3.926602  # beta l of a bar hinged at one end and clamped at the other


def with_hit_mass(scenario: ColumnImpact, rule: str) -> ColumnImpact:
    """The impact with the impact mass (kg) of a rule; one that is given counts as it is."""
    if rule == THESIS or scenario.column.impact_mass is not None:
        return scenario
    column = scenario.column.changed(impact_mass=wave_mass(scenario))
    return scenario.changed(column=column)


def light_impact_mass(scenario: Any) -> list[Finding]:
    """Warning of an impact mass that is less than a third of a column whose mass is spread."""
    column, given = scenario.column, set_inputs(scenario).get("column.impact_mass")
    own = column.properties.mass_per_length * column.length / 3.0
    lighter = given is not None and given.value < 0.99 * own
    return [finding("unused-input", input=given)] if lighter else []


def wave_mass(scenario: ColumnImpact) -> float:
    """Mass (kg) that shares the velocity of the striker at once, by the rule "waves"."""
    column, properties = scenario.column, scenario.column.properties
    lumped, demand = properties.impact_mass, mechanism_demand(column)
    ratio = lumped / scenario.striker.mass
    yielding = np.maximum(0.0, 1.0 - front_velocity(scenario) / scenario.striker.velocity)
    plastic = 1.0 - elastic_energy(column) * (1.0 + ratio) / scenario.input_energy
    shared = 0.0
    for bar, (length, clamped) in column.bars.items():
        left = np.maximum(0.0, 1.0 - demand[bar])  # of V_pl, to bring the bar to speed
        lost = left * (1.0 + ratio) / (left + ratio)
        share = 1.0 - yielding * (1.0 - lost)
        if clamped:
            share = share - np.maximum(0.0, plastic) * late_work(scenario, length)
        shared = shared + np.maximum(0.0, share) * length / column.length
    piece = properties.mass_per_length * column.section.height
    mass: float = np.minimum(np.maximum(shared * lumped, piece), lumped)
    return mass


def front_velocity(scenario: ColumnImpact) -> float:
    """Velocity (m/s) of a hit whose elastic shear wave carries the plastic shear resistance."""
    properties = scenario.column.properties
    rigidity = shear_rigidity(scenario.column)
    velocity: float = properties.shear_resistance / np.sqrt(rigidity * properties.mass_per_length)
    return velocity


def shear_rigidity(column: Column) -> float:
    """G A_w (N) of what carries the plastic shear resistance."""
    area = sqrt(3.0) * column.properties.shear_resistance / column.steel.yield_stress
    return column.steel.shear_modulus * area


def late_work(scenario: ColumnImpact, length: float) -> float:
    """Work that the far hinge of a bar of a `length` (m) does not do, over the loss of the thesis.

    At most all of it.
    """
    column, properties = scenario.column, scenario.column.properties
    bending = column.steel.elastic_modulus * properties.second_moment
    mass = properties.mass_per_length
    late = 0.5 * pi * (length / _FIRST_MODE) ** 2 * np.sqrt(mass / bending)
    moment = np.minimum(properties.plastic_moment, 0.5 * properties.shear_resistance * length)
    share = 6.0 * moment * late / (mass * length**2 * scenario.striker.velocity)
    most: float = np.minimum(1.0, share)
    return most


def elastic_energy(column: Column) -> float:
    """Energy (J) of the column at its plastic mechanism if it were elastic until then."""
    properties = column.properties
    bending = column.steel.elastic_modulus * properties.second_moment
    stiffness = resistance = 0.0
    demand = mechanism_demand(column)
    for bar, (length, clamped) in column.bars.items():
        flexible = length**3 / ((12.0 if clamped else 3.0) * bending)
        stiffness = stiffness + 1.0 / (flexible + length / shear_rigidity(column))
        resistance = resistance + np.minimum(demand[bar], 1.0) * properties.shear_resistance
    return 0.5 * resistance**2 / stiffness
