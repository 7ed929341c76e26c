"""How much of a column's mass shares the velocity of its striker at once.

A lumped column of two straight bars meets its striker with a third of the mass of each bar. In an
inelastic hit that costs ½ m v0² / (1 + mu), m the lumped mass and mu its ratio to the striker's:
rule "thesis" (Heng 2017, section 5.2).

Webs pass on V_pl at most. A bar whose mechanism needs the shear force r V_pl of them is brought
to speed by the rest, while the hit point slides across it. With G the mass of the striker,

  G v' = -V_pl,   m w' = (1 - r) V_pl,   v - w = v0 at first:
  slip s = ½ v0² / (V_pl / G + (1 - r) V_pl / m).

Friction takes V_pl s, of which r V_pl s is work that the mechanism would have done over the same
way of the hit point. Only (1 - r) V_pl s is lost, of the loss of the thesis the share

  f = (1 - r) (1 + mu) / (1 - r + mu):

none where the bar slides anyway (r = 1), all of it if the striker is heavy and r < 1. The front of
an elastic shear wave passes on v0 (rho A G A_w)^½: up to the velocity v_s at which that reaches
V_pl nothing slides and f = 1, beyond it the part 1 - v_s / v0 of the approach does. Rule "sliding"
gives each bar the mass f m, but the column never less than a piece as long as its section is high.
See docs/theory/hit-mass.md, with what it does to bias and scatter.
"""

from dataclasses import replace
from math import sqrt

from workbench.fields import Choice
from workbench.models.domain import shear_demand
from workbench.scenarios import ColumnImpact

THESIS, SLIDING = "thesis", "sliding"
HIT_MASS = Choice((THESIS, SLIDING))


def with_hit_mass(scenario: ColumnImpact, rule: str) -> ColumnImpact:
    """The impact with the impact mass (kg) of a rule; one that is given counts as it is."""
    if rule == THESIS or scenario.column.impact_mass is not None:
        return scenario
    column = replace(scenario.column, impact_mass=sliding_mass(scenario))
    return replace(scenario, column=column)


def sliding_mass(scenario: ColumnImpact) -> float:
    """Mass (kg) that shares the velocity of the striker at once if webs slide."""
    column, properties = scenario.column, scenario.column.properties
    velocity = scenario.striker.velocity
    sliding = max(0.0, 1.0 - front_velocity(scenario) / velocity)
    ratio = properties.impact_mass / scenario.striker.mass
    shared = 0.0
    lengths = {"below": column.length_below, "above": column.length_above}
    for bar, demand in shear_demand(scenario).items():
        left = max(0.0, 1.0 - demand)  # of V_pl, to bring the bar to speed
        lost = left * (1.0 + ratio) / (left + ratio)
        share = 1.0 - sliding * (1.0 - lost)
        shared += share * lengths[bar] / column.length
    piece = properties.mass_per_length * column.section.height
    return min(max(shared * properties.impact_mass, piece), properties.impact_mass)


def front_velocity(scenario: ColumnImpact) -> float:
    """Velocity (m/s) of a hit whose elastic shear wave carries the plastic shear resistance."""
    properties, steel = scenario.column.properties, scenario.column.steel
    resistance = properties.shear_resistance
    web_area = sqrt(3.0) * resistance / steel.yield_stress
    return resistance / sqrt(steel.shear_modulus * web_area * properties.mass_per_length)
