"""The mass that shares the velocity of the striker at once, in all lumped models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from workbench.models.domain import shear_demand
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.hit_mass import (
    THESIS,
    WAVES,
    elastic_energy,
    front_velocity,
    late_work,
    supported_mass,
    wave_mass,
    with_hit_mass,
)
from workbench.models.single_dof import SingleDof
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find

HEB = find("HEB 220")


def impact(below: float, mass: float, velocity: float) -> ColumnImpact:
    return ColumnImpact("hit", Column(HEB, below, 4.0), Striker(mass, velocity), 0.05)


def pinned(below: float, mass: float, velocity: float) -> ColumnImpact:
    """Both ends turn freely: no hinge is behind, so that only webs that slide count."""
    column = Column(HEB, below, 4.0, base="pinned", head="pinned")
    return ColumnImpact("hit", column, Striker(mass, velocity), 0.05)


def test_elastic_hits_share_the_mass_of_the_thesis() -> None:
    scenario = impact(0.8, 500.0, 1.0)
    thesis = scenario.column.properties.impact_mass
    light = replace(scenario, striker=Striker(20.0, 3.0))
    assert light.input_energy < elastic_energy(light.column)
    assert wave_mass(light) == pytest.approx(thesis, rel=1e-12)


def test_webs_slide_from_the_velocity_on_at_which_a_shear_wave_carries_their_resistance() -> None:
    scenario = pinned(0.8, 500.0, 1.0)
    front = front_velocity(scenario)
    # V_pl / (rho A G A_w)^1/2 of an HEB 220: some 4 m/s
    assert front == pytest.approx(3.7, rel=0.05)  # measured 0.02
    thesis = scenario.column.properties.impact_mass
    for velocity in (0.1 * front, front):
        assert wave_mass(scenario.at_velocity(velocity)) == pytest.approx(thesis, rel=1e-12)
    faster = [wave_mass(scenario.at_velocity(v)) for v in (2 * front, 4 * front, 40 * front)]
    assert thesis > faster[0] > faster[1] > faster[2]


def test_far_hinges_are_late_by_a_quarter_of_the_first_period() -> None:
    scenario = impact(2.0, 1e5, 12.0)  # plastic by far
    properties, steel = scenario.column.properties, scenario.column.steel
    bending, length = steel.elastic_modulus * properties.second_moment, 4.0
    # first root of tan(x) = tanh(x), a beam hinged at one end and clamped at the other
    root = brentq(lambda x: np.tan(x) - np.tanh(x), 3.5, 4.5)
    omega = root**2 * np.sqrt(bending / properties.mass_per_length) / length**2
    missing = 12.0 * (0.5 * np.pi / omega) * properties.plastic_moment / length
    lost = 0.5 * properties.mass_per_length * length / 3.0 * 12.0**2
    bar = bending, properties.plastic_moment
    assert late_work(scenario, length, *bar) == pytest.approx(missing / lost, rel=1e-5)
    # with the bar: delay as l^2, mass as l, hinge force as 1 / l
    assert late_work(scenario, 2.0, *bar) == pytest.approx(
        late_work(scenario, 4.0, *bar), rel=1e-12
    )
    assert late_work(scenario.at_velocity(0.1), length, *bar) == 1.0


def test_supports_feel_hits_from_all_sides_late() -> None:
    scenario = impact(2.0, 1e3, 12.0)
    lumped = scenario.column.properties.impact_mass
    masses = {
        angle: supported_mass(scenario.changed(striker=Striker(1e3, 12.0, angle=np.radians(angle))))
        for angle in (0.0, 1e-9, 45.0, 90.0)
    }
    assert masses[1e-9] == pytest.approx(masses[0.0], rel=1e-9)  # nothing jumps
    weak = scenario.changed(column=scenario.column.changed(axis="weak"))
    assert supported_mass(weak) == pytest.approx(masses[90.0], rel=1e-12)
    assert all(0.2 * lumped < mass < 0.9 * lumped for mass in masses.values())
    column = scenario.column  # in its plane: the rule "waves" where webs neither slide nor shear
    properties = column.properties
    bending = column.steel.elastic_modulus * properties.second_moment
    lengths = np.array([column.length_below, column.length_above])
    resistance, stiffness = (
        sum(2.0 * properties.plastic_moment / lengths),
        sum(12.0 * bending / lengths**3),
    )
    elastic = 0.5 * resistance**2 / stiffness * (1.0 + lumped / scenario.striker.mass)
    late = [late_work(scenario, each, bending, properties.plastic_moment) for each in lengths]
    share = 1.0 - (1.0 - elastic / scenario.input_energy) * np.dot(late, lengths / column.length)
    assert masses[0.0] == pytest.approx(lumped * share, rel=2e-3)  # fillets as squares


def test_supports_that_are_pinned_are_not_late() -> None:
    column = Column(HEB, 1.0, 3.0, base_weak="pinned", head="pinned")
    thesis = column.properties.impact_mass
    masses = [
        supported_mass(ColumnImpact("hit", column, Striker(1e3, 12.0, angle=angle)))
        for angle in (0.0, 0.3)
    ]
    assert masses[0] < thesis  # the base is clamped in the plane of the web
    assert masses[1] == pytest.approx(thesis, rel=1e-12)


def test_elastic_energy_is_that_of_clamped_and_pinned_bars_side_by_side() -> None:
    column = Column(HEB, 3.0, 3.0)  # demand below V_pl, shear flexible
    scenario = ColumnImpact("hit", column, Striker(1.0, 1.0))
    properties, steel = column.properties, column.steel
    bending = 3.0**3 / (12.0 * steel.elastic_modulus * properties.second_moment)
    shear = 3.0 / (
        steel.shear_modulus * np.sqrt(3) * properties.shear_resistance / steel.yield_stress
    )
    force = 4.0 * properties.plastic_moment / 3.0
    assert elastic_energy(scenario.column) == pytest.approx(
        0.25 * force**2 * (bending + shear), rel=1e-12
    )


def test_loss_of_a_bar_whose_hit_point_slides_across_it() -> None:
    """One bar as two masses with friction V_pl between them, against the closed form."""
    striker, bar, friction, share, velocity = 3.0, 2.0, 10.0, 0.4, 5.0

    def motion(_: float, y: list[float]) -> list[float]:
        slides = y[0] > y[1]
        return (
            [-friction / striker, (1 - share) * friction / bar, y[0] - y[1]] if slides else [0] * 3
        )

    slip = solve_ivp(motion, (0.0, 10.0), [velocity, 0.0, 0.0], rtol=1e-9, max_step=1e-3).y[2, -1]
    lost = (1.0 - share) * friction * slip
    ratio, left = bar / striker, 1.0 - share
    thesis = 0.5 * bar * velocity**2 / (1.0 + ratio)
    # the ODE stops within a step of the end of sliding: measured 1e-6
    assert lost / thesis == pytest.approx(left * (1.0 + ratio) / (left + ratio), rel=1e-4)


def test_a_heavy_striker_loses_as_in_the_thesis_unless_the_bar_slides_anyway() -> None:
    long = pinned(2.5, 1e7, 1e2)  # every demand below V_pl
    assert max(shear_demand(long).values()) < 1.0
    thesis = long.column.properties.impact_mass
    assert wave_mass(long) == pytest.approx(thesis, rel=1e-4)
    short = pinned(0.3, 1e7, 1e2)
    assert shear_demand(short)["below"] > 1.0
    sliding = (1.0 - front_velocity(short) / 1e2) * 0.3 / 4.3
    assert wave_mass(short) == pytest.approx((1.0 - sliding) * thesis * 4.3 / 6.5, rel=1e-4)


@examples(60)
@given(st.floats(0.3, 4.0), st.floats(1.0, 1e5), st.floats(0.1, 200.0))
def test_it_lies_between_a_piece_of_the_column_and_the_mass_of_the_thesis(
    below: float, mass: float, velocity: float
) -> None:
    scenario = impact(below, mass, velocity)
    properties = scenario.column.properties
    piece = properties.mass_per_length * HEB.height
    assert piece <= wave_mass(scenario) <= properties.impact_mass


def test_a_given_mass_counts_as_it_is() -> None:
    scenario = impact(0.8, 500.0, 15.0)
    given_one = replace(scenario, column=replace(scenario.column, impact_mass=12.0))
    assert with_hit_mass(given_one, WAVES) is given_one
    assert with_hit_mass(scenario, THESIS) is scenario


@pytest.mark.parametrize("model", [FourDof, FourDofShear, SingleDof, EnergyEstimate])
def test_every_lumped_model_goes_farther_with_it(model) -> None:
    scenario = impact(0.8, 300.0, 15.0)
    peaks = {}
    for rule in (THESIS, WAVES):
        response = model(hit_mass=rule).simulate(scenario)
        peaks[rule] = float(response["peak_displacement"])
    changed = replace(scenario.column, impact_mass=wave_mass(scenario))
    response = model(hit_mass=THESIS).simulate(replace(scenario, column=changed))
    assert peaks[WAVES] == float(response["peak_displacement"])
    assert peaks[WAVES] > 1.01 * peaks[THESIS]
