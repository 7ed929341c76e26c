"""Estimates by hand and the rule of EN 1991-1-7: numbers worked out apart, closed forms."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sin, sqrt

import pytest

from workbench.base.errors import InputError
from workbench.extras.practice.hand_estimate import HandEstimate
from workbench.extras.practice.hard_impact import HardImpact
from workbench.models.single_dof import SingleDof
from workbench.responses import Outcome, collapse_of, energy_error, outcome_of, warnings_of
from workbench.scenarios import ColumnImpact
from workbench.scenarios.pulse import FORCES, TRAFFIC, design_striker, velocity_after

# HEB 220 of the thesis, P = 0.5 MN: load (N) of the mechanism by the exact and the linear surface
LOADS = {"none": 889.8e3, "section": 831.8e3, "linear": 747.8e3}


def subjects(response) -> set[str]:
    return {finding.subject for finding in warnings_of(response)}


@pytest.mark.claim("model:hand-estimate", "peak over E / F ({axial})", "closed form", 1, 2e-4)
@pytest.mark.parametrize("axial", LOADS)
def test_momentum_then_energy_against_the_mechanism(thesis_impact, axial, claim) -> None:
    response = HandEstimate(axial=axial).simulate(thesis_impact)
    joined = 0.94029 * 15.0  # m/s of 1500 kg and rho A L / 3 = 95.25 kg
    expected = 0.5 * 1595.25 * joined**2 / LOADS[axial]
    claim(response["peak_displacement"] / expected)
    assert float(response["residual_displacement"]) == float(response["peak_displacement"])
    assert float(response["time_of_peak"]) == pytest.approx(2.0 * expected / joined, rel=2e-4)


def test_a_hand_estimate_of_strikers_that_bounce_and_that_fell_it(
    thesis_impact,
) -> None:
    bouncing = replace(thesis_impact, striker=replace(thesis_impact.striker, restitution=0.5))
    response = HandEstimate().simulate(bouncing)
    assert "time_of_peak" not in response
    gone = HandEstimate().simulate(thesis_impact.at_velocity(40.0))
    assert outcome_of(gone) is Outcome.COLLAPSE
    assert collapse_of(gone).parts == ("below",)


@pytest.mark.claim("model:en-1991-hard-impact", "force of a car, N", "en1991-1-7", 318.2e3, 32)
def test_hard_impact_of_a_car(thesis_impact, claim) -> None:
    response = HardImpact().simulate(thesis_impact)
    claim(response["rule.force"])  # 15 (3e5 1500)^.5
    assert float(response["rule.duration"]) == pytest.approx(0.07071, rel=1e-4)
    momentum = 1500.0 * 15.0
    assert float(response["rule.force"] * response["rule.duration"]) == pytest.approx(momentum)
    assert float(response["rule.soft_deformation"]) == pytest.approx(
        168750.0 / LOADS["section"], 2e-4
    )
    assert energy_error(response) < 1e-12


def elastic_hit(impact: ColumnImpact) -> tuple[ColumnImpact, float, float]:
    """A column whose curve is linear, its stiffness (N/m) and its period (s)."""
    column = replace(impact.column, axial_load=0.0, restraint_stiffness=0.0)
    impact = replace(impact, column=column).at_velocity(1.0)
    stiffness = SingleDof(resistance="analytic").curve(column).initial_stiffness
    return impact, stiffness, 2.0 * pi * sqrt(column.properties.impact_mass / stiffness)


@pytest.mark.claim("model:en-1991-hard-impact", "elastic peak, ratio", "closed form", 1, 1e-3)
@pytest.mark.parametrize("length", [0.1, 0.25, 0.5, 3.3])
def test_its_pulse_moves_an_elastic_column_as_closed_forms_say(
    thesis_impact, length, claim
) -> None:
    impact, stiffness, period = elastic_hit(thesis_impact)
    k = impact.striker.mass / (length * period) ** 2
    model = HardImpact(striker_stiffness=k, resistance="analytic")
    force = sqrt(k * impact.striker.mass)
    if length < 1.0:  # shorter pulses of the same momentum are stronger than the column
        impact = impact.at_velocity(0.1 * length)
    force *= impact.striker.velocity
    impact = replace(impact, duration=4.0 * period + length * period)
    factor = 2.0 * sin(pi * length) if length < 0.5 else 2.0
    peak = float(model.simulate(impact)["peak_displacement"])
    claim(peak / (factor * force / stiffness))
    if length > 1.0:  # phi = 2 of the standard is the step on an elastic structure
        static = replace(model, application="static").simulate(impact)
        assert float(static["peak_displacement"]) == pytest.approx(peak, rel=1e-3)


def test_the_way_of_the_column_is_told_over_the_crush_of_the_striker(thesis_impact) -> None:
    for stiffness, velocity, subject in ((3e5, 15.0, "striker"), (3e6, 10.0, "hard-impact")):
        crush = velocity * sqrt(1500.0 / stiffness)  # m, at that speed for (m / k)^1/2
        model = HardImpact(striker_stiffness=stiffness)
        response = model.simulate(thesis_impact.at_velocity(velocity))
        ratio = float(response["peak_displacement"]) / crush
        (finding,) = (f for f in warnings_of(response) if f.subject == subject)
        expected = 1.0 / ratio if subject == "striker" else ratio
        assert finding.number == pytest.approx(expected, rel=1e-4)
        assert f"by {crush:.3g} m" in finding.text


def test_the_rule_says_when_it_is_none(thesis_impact) -> None:
    stiff = HardImpact(striker_stiffness=3e6).simulate(thesis_impact.at_velocity(10.0))
    assert "hard-impact" in subjects(stiff)
    soft = subjects(HardImpact().simulate(thesis_impact))
    assert "hard-impact" not in soft
    assert "striker" in soft  # no rigid one
    assert "soft-impact" in subjects(HardImpact(deformation_capacity=0.1).simulate(thesis_impact))
    assert "soft-impact" not in subjects(
        HardImpact(deformation_capacity=0.3).simulate(thesis_impact)
    )
    heavy = HardImpact(striker_stiffness=1e7, application="static").simulate(thesis_impact)
    assert outcome_of(heavy) is Outcome.COLLAPSE
    for options in ({"amplification": 2.5}, {"application": "both"}, {"striker_stiffness": 0.0}):
        with pytest.raises(InputError):
            HardImpact(**options)


def test_forces_of_table_4_1_act_statically_whatever_the_striker(thesis_impact) -> None:
    """On the elastic part of the curve force over stiffness; across half as much."""
    curve = SingleDof().curve(thesis_impact.column)
    assert FORCES["yard-lorries"] == 150e3
    for name, each in TRAFFIC.items():
        assert FORCES[f"{name}-across"] == 0.5 * FORCES[name] == each.across
    for traffic in ("yard-lorries", "yard-cars", "yard-lorries-across"):
        response = HardImpact(application=traffic).simulate(thesis_impact)
        expected = FORCES[traffic] / curve.initial_stiffness
        assert float(response["peak_displacement"]) == pytest.approx(expected, rel=1e-6)
        assert float(response["peak_force"]) == FORCES[traffic]
        faster = HardImpact(application=traffic).simulate(thesis_impact.at_velocity(30.0))
        assert float(faster["peak_displacement"]) == float(response["peak_displacement"])
        (finding,) = (f for f in warnings_of(response) if f.subject == "striker")
        assert "318.2 kN on a rigid wall" in finding.text


def test_design_vehicles_make_the_forces_of_table_c_2() -> None:
    """F_0 as recalled, but for lorries in yards (500 kN recalled, 395 by the formula)."""
    recalled = {"motorway": 2400e3, "urban": 1300e3, "yard-cars": 120e3, "garage": 60e3}
    for traffic, force in recalled.items():
        striker = design_striker(traffic)
        assert striker.velocity * sqrt(3e5 * striker.mass) == pytest.approx(force, rel=0.02)


def test_braking_is_that_of_a_motion_in_steps() -> None:
    v, way, dt = 25.0, 0.0, 1e-5
    while way * sin(pi / 18.0) < 12.0:  # 12 m from its lane, at 10 degrees
        v, way = v - 4.0 * dt, way + (v - 2.0 * dt) * dt
    assert velocity_after(25.0, 12.0, 4.0) == pytest.approx(v, rel=1e-4)
    assert velocity_after(25.0, 0.0) == 25.0
    reached = 25.0**2 * sin(pi / 18.0) / 6.0
    assert velocity_after(25.0, 0.75 * reached) == pytest.approx(12.5)
    with pytest.raises(InputError, match=r"distance = 19.0: must be below 18.09 m"):
        design_striker("motorway", 19.0)
    with pytest.raises(InputError, match=r"traffic = 'rural': must be one of motorway, urban"):
        design_striker("rural")
