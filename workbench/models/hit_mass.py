"""How much of a column's mass shares the velocity of its striker at once.

Rule "thesis" (Heng 2017, section 5.2): m, a third of the mass of two straight bars; an inelastic
hit costs ½ m v0² / (1 + mu), mu its ratio to the mass of the striker. Rule "waves": each bar, of
the share l_i / L of the column, gives

  [1 - (1 - v_s / v0) (1 - f) - (1 - E_el (1 + mu) / E) g] m l_i / L,   g at most 1,

f = (1 - r) (1 + mu) / (1 - r + mu) what is lost of that where webs yield in shear, from the
velocity v_s on, r V_pl the shear force of the mechanism; g = 2 t M / (m l v0) the work that the far
hinge, of moment M, does not do before it feels the hit, after t = pi / (2 omega) of the first mode
of the bar, hinged where it is hit and clamped behind; E_el the elastic energy at the mechanism. The
column gives never less than a piece as long as its section is high. Rule "supports" is that of
models in space: late supports alone, along the hit from any side, without webs that slide.
Derivation, what the rules do to bias and scatter, where the argument is weak:
docs/theory/hit-mass.md.
"""

from math import pi, sqrt
from typing import Any

import numpy as np

from workbench.base.codec import set_inputs
from workbench.base.fields import Choice
from workbench.models.domain import mechanism_demand
from workbench.responses import Finding, finding
from workbench.scenarios import Column, ColumnImpact
from workbench.steel.hinges.interaction import surface_in_space
from workbench.steel.sections import AXES

THESIS, WAVES, SUPPORTS = "thesis", "waves", "supports"
HIT_MASS, HIT_MASS_IN_SPACE = Choice((THESIS, WAVES)), Choice((THESIS, SUPPORTS))
_ALONG = 1e-12  # cosine of a hit that is one along the flanges or the web
_TURNS, _NEAR = 100, 1e-2  # of a search for a moment, to 1e-3 of it: the share at which it ends
_FIRST_MODE = 3.926602  # beta l of a bar hinged at one end and clamped at the other


def with_hit_mass(scenario: ColumnImpact, rule: str) -> ColumnImpact:
    """The impact with the impact mass (kg) of a rule; one that is given counts as it is."""
    if rule == THESIS or scenario.column.impact_mass is not None:
        return scenario
    mass = wave_mass(scenario) if rule == WAVES else supported_mass(scenario)
    return scenario.changed(column=scenario.column.changed(impact_mass=mass))


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
    bending = column.steel.elastic_modulus * properties.second_moment
    yielding = np.maximum(0.0, 1.0 - front_velocity(scenario) / scenario.striker.velocity)
    plastic = 1.0 - elastic_energy(column) * (1.0 + ratio) / scenario.input_energy
    shared = 0.0
    for bar, (length, clamped) in column.bars.items():
        left = np.maximum(0.0, 1.0 - demand[bar])  # of V_pl, to bring the bar to speed
        lost = left * (1.0 + ratio) / (left + ratio)
        share = 1.0 - yielding * (1.0 - lost)
        if clamped:
            most = np.minimum(properties.plastic_moment, 0.5 * properties.shear_resistance * length)
            share = share - np.maximum(0.0, plastic) * late_work(scenario, length, bending, most)
        shared = shared + np.maximum(0.0, share) * length / column.length
    return _at_least_a_piece(column, shared)


def _at_least_a_piece(column: Column, shared: float) -> float:
    properties = column.properties
    piece, lumped = properties.mass_per_length * column.section.height, properties.impact_mass
    mass: float = np.minimum(np.maximum(shared * lumped, piece), lumped)
    return mass


def direction_of(scenario: ColumnImpact) -> list[Any]:
    """Cosine and sine of the angle of a hit from the height of the section."""
    both = np.cos(scenario.angle_from_height), np.sin(scenario.angle_from_height)
    return [np.where(np.abs(each) < _ALONG, 0.0, each) for each in both]


def supported_mass(scenario: ColumnImpact) -> float:
    """Mass (kg) that shares the velocity of the striker at once, by the rule "supports".

    The impact point moves sideways as it likes, as without friction: its flexibility along the hit
    is that of both planes, the moment the largest one along it on the domain of the section under
    the axial load. An end that is pinned about either axis of the hit gives way.
    """
    column = scenario.column
    both = [column.bent_about(axis) for axis in AXES]
    planes = list(zip(direction_of(scenario), both, strict=True))
    modulus, surface = column.steel.elastic_modulus, surface_in_space(both[0].strength_section)
    bending = modulus / sum(c**2 / each.properties.second_moment for c, each in planes)
    axial = column.axial_load / column.properties.squash_load
    along = (c / each.properties.plastic_moment for c, each in planes)
    forces = np.stack(np.broadcast_arrays(0.0 * axial, *along), axis=-1)
    moment: Any = np.ones(forces.shape[:-1])
    found = np.zeros(moment.shape, bool)
    for _ in range(_TURNS):  # a contraction: the axial force takes its share of the gauge
        share = np.where(found, 1.0, surface.gauge(forces))
        moment, forces[..., 1:] = moment / share, forces[..., 1:] / share[..., None]
        forces[..., 0] = axial
        found |= np.abs(share - 1.0) < _NEAR
        if found.all():
            break
    stiffness, resistance, late = np.zeros((3, *moment.shape))
    for bar, (length, _) in column.bars.items():
        held = ~np.any([(c != 0.0) & (not each.bars[bar][1]) for c, each in planes], axis=0)
        stiffness += np.where(held, 12.0, 3.0) * bending / length**3
        resistance += np.where(held, 2.0, 1.0) * moment / length
        late += held * late_work(scenario, length, bending, moment) * length / column.length
    ratio = column.properties.impact_mass / scenario.striker.mass
    elastic = 0.5 * resistance**2 / stiffness * (1.0 + ratio) / scenario.input_energy
    return _at_least_a_piece(column, 1.0 - np.maximum(0.0, 1.0 - elastic) * late)


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


def late_work(scenario: ColumnImpact, length: float, bending: Any, moment: Any) -> float:
    """Work that the far hinge of a bar does not do, over the loss of the thesis; at most all of it.

    Arguments: `length` (m) and `bending` stiffness (N m2) of the bar, `moment` (N m) of the hinge.
    """
    mass = scenario.column.properties.mass_per_length
    late = 0.5 * pi * (length / _FIRST_MODE) ** 2 * np.sqrt(mass / bending)
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
