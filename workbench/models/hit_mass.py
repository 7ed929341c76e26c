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
V_pl nothing slides and f = 1, beyond it the part 1 - v_s / v0 of the approach does.

Supports feel the hit late, by about a quarter of the period of the bar's first mode (hinged where
it is hit, clamped behind), t = pi / (2 omega). Until then the far hinge, of moment M, does no work,
which lumped models count at once: v0 t M / l, of the loss of the thesis the share 2 t M / (m l v0).
That is of the work of hinges only, so that of a hit which takes the column through its elastic
energy E_el the part 1 - E_el (1 + mu) / E counts.

Rule "waves" gives each bar what both leave of m, but the column never less than a piece as long as
its section is high. See docs/theory/hit-mass.md, with what it does to bias and scatter, and where
the argument is weak.
"""

from dataclasses import replace
from functools import lru_cache
from math import pi, sqrt

from workbench.fields import Choice
from workbench.models.domain import mechanism_demand
from workbench.scenarios import Column, ColumnImpact

THESIS, WAVES = "thesis", "waves"
HIT_MASS = Choice((THESIS, WAVES))
_FIRST_MODE = 3.926602  # beta l of a bar hinged at one end and clamped at the other


def with_hit_mass(scenario: ColumnImpact, rule: str) -> ColumnImpact:
    """The impact with the impact mass (kg) of a rule; one that is given counts as it is."""
    if rule == THESIS or scenario.column.impact_mass is not None:
        return scenario
    column = replace(scenario.column, impact_mass=wave_mass(scenario))
    return replace(scenario, column=column)


def wave_mass(scenario: ColumnImpact) -> float:
    """Mass (kg) that shares the velocity of the striker at once, by the rule "waves"."""
    column, properties = scenario.column, scenario.column.properties
    lumped, demand = properties.impact_mass, mechanism_demand(column)
    ratio = lumped / scenario.striker.mass
    sliding = max(0.0, 1.0 - front_velocity(scenario) / scenario.striker.velocity)
    plastic = 1.0 - elastic_energy(column) * (1.0 + ratio) / scenario.input_energy
    shared = 0.0
    for bar, (length, clamped) in bars_of(column).items():
        left = max(0.0, 1.0 - demand[bar])  # of V_pl, to bring the bar to speed
        lost = left * (1.0 + ratio) / (left + ratio)
        share = 1.0 - sliding * (1.0 - lost)
        if clamped:
            share -= max(0.0, plastic) * late_work(scenario, length)
        shared += max(0.0, share) * length / column.length
    piece = properties.mass_per_length * column.section.height
    return min(max(shared * lumped, piece), lumped)


def bars_of(column: Column) -> dict[str, tuple[float, bool]]:
    """Length (m) of both bars, by their place, and whether the far end of each is clamped."""
    return {
        "below": (column.length_below, column.base != "pinned"),
        "above": (column.length_above, column.head != "pinned"),
    }


def front_velocity(scenario: ColumnImpact) -> float:
    """Velocity (m/s) of a hit whose elastic shear wave carries the plastic shear resistance."""
    properties = scenario.column.properties
    rigidity = shear_rigidity(scenario.column)
    return properties.shear_resistance / sqrt(rigidity * properties.mass_per_length)


def shear_rigidity(column: Column) -> float:
    """G A_w (N) of what carries the plastic shear resistance."""
    area = sqrt(3.0) * column.properties.shear_resistance / column.steel.yield_stress
    return float(column.steel.shear_modulus * area)


def late_work(scenario: ColumnImpact, length: float) -> float:
    """Work that the far hinge of a bar of a `length` (m) does not do, over the loss of the thesis.

    At most all of it.
    """
    column, properties = scenario.column, scenario.column.properties
    bending = column.steel.elastic_modulus * properties.second_moment
    mass = properties.mass_per_length
    late = 0.5 * pi * (length / _FIRST_MODE) ** 2 * sqrt(mass / bending)
    moment = min(properties.plastic_moment, 0.5 * properties.shear_resistance * length)
    share = 6.0 * moment * late / (mass * length**2 * scenario.striker.velocity)
    return min(1.0, share)


@lru_cache(maxsize=256)
def elastic_energy(column: Column) -> float:
    """Energy (J) of the column at its plastic mechanism if it were elastic until then."""
    properties = column.properties
    bending = column.steel.elastic_modulus * properties.second_moment
    stiffness = resistance = 0.0
    demand = mechanism_demand(column)
    for bar, (length, clamped) in bars_of(column).items():
        flexible = length**3 / ((12.0 if clamped else 3.0) * bending)
        stiffness += 1.0 / (flexible + length / shear_rigidity(column))
        resistance += min(demand[bar], 1.0) * properties.shear_resistance
    return 0.5 * resistance**2 / stiffness
