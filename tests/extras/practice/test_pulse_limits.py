"""What one shape of deflection, stiff hinges and bending alone leave out, against right values."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.extras.practice.biggs import Biggs
from workbench.models.base import make_model
from workbench.responses import Outcome, findings_of, outcome_of
from workbench.scenarios import Column, MemberPulse, Pulse, scenario_from

# mm: OpenSeesPy, 80 co-rotational elements (public benchmark: clamped strip under a step force)
STRIP_PEAK = 19.46


def strip(yields: float = 3e9, **column) -> MemberPulse:
    ends = {"length_below": 0.254, "length_above": 0.254, "base": "clamped", "head": "fixed"}
    return scenario_from(
        {
            "kind": "member-pulse",
            "name": "strip",
            "column": {"section": {"height": 0.003175, "width": 0.0254}, **ends, **column},
            "steel": {"elastic_modulus": 206.8e9, "yield_stress": yields, "density": 2710.42},
            "pulse": {"load": "point", "shape": "rectangular", "peak": 2846.7, "length": 1.0},
            "time": {"duration": 0.005},
        }
    )


def subjects(response) -> list[str]:
    return [each.subject for each in findings_of(response)]


def peak(response) -> float:
    """In mm."""
    return 1e3 * float(response["peak_displacement"])


def test_bending_alone_calls_no_collapse_where_tension_may_hold_the_member() -> None:
    """The strip stands at 19.46 mm; Biggs' last stage, a mechanism, runs out of its geometry."""
    response = make_model("biggs").simulate(strip())
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    (refusal,) = findings_of(response)
    assert (refusal.subject, refusal.refusal, refusal.instead) == ("catenary", True, ())
    assert 0.9 * 0.254 <= refusal.number < 0.25
    free = make_model("biggs").simulate(strip(head="guided"))
    assert outcome_of(free) is Outcome.COLLAPSE  # nothing could hold it


@pytest.mark.parametrize("name", ["biggs", "hand-estimate"])
def test_a_hit_that_catenary_action_stops_is_no_collapse_by_bending(name, thesis_impact) -> None:
    """At 30 m/s the four-DOF column stands at 0.583 m, at 40 m/s it falls."""
    answers = [make_model(name).simulate(thesis_impact.at_velocity(v)) for v in (25.0, 30.0, 40.0)]
    ends = [Outcome.OK, Outcome.OUT_OF_DOMAIN, Outcome.COLLAPSE]
    assert [outcome_of(each) for each in answers] == ends
    assert (
        outcome_of(make_model("four-dof").simulate(thesis_impact.at_velocity(30.0))).value == "ok"
    )


def test_equilibrium_of_the_undeformed_frame_calls_no_collapse() -> None:
    response = make_model("rigid-superelement", {"geometry": "linear"}).simulate(strip())
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    assert subjects(response) == ["geometry"]


@pytest.mark.parametrize("name", ["single-dof", "izzuddin", "yin-wang"])
def test_straight_bars_say_how_much_less_they_stretch_than_an_elastic_member(name) -> None:
    response = make_model(name).simulate(strip())
    (said,) = [each for each in findings_of(response) if each.subject == "catenary"]
    assert said.number == pytest.approx(100.0 * (peak(response) / STRIP_PEAK - 1.0), abs=1.5)


def test_straight_bars_say_nothing_of_free_ends_and_of_members_that_yield() -> None:
    single = make_model("single-dof")
    light = replace(strip(head="guided"), pulse=Pulse("rectangular", 20.0, 1.0), duration=0.02)
    for scenario in (strip(yields=3e8), light):
        assert "catenary" not in subjects(single.simulate(scenario))


def test_hinges_of_the_flexible_superelement_make_elastic_members_soft() -> None:
    """Ten times as stiff as the bars they add a tenth of axial flexibility; 100 times, little."""
    soft, stiff, rigid = (
        make_model(name, options).simulate(strip())
        for name, options in (
            ("flexible-superelement", {}),
            ("flexible-superelement", {"hinge_stiffness": 100.0}),
            ("rigid-superelement", {}),
        )
    )
    assert peak(soft) == pytest.approx(1.044 * STRIP_PEAK, rel=0.005)
    assert peak(stiff) == pytest.approx(STRIP_PEAK, rel=0.015)
    assert peak(rigid) == pytest.approx(STRIP_PEAK, rel=0.005)
    said = [each.number for each in findings_of(soft) if each.subject == "hinge-stiffness"]
    assert said == [pytest.approx(10.0)]
    assert not {"hinge-stiffness"} & {*subjects(stiff), *subjects(rigid)}


def impulsive(ductility: float, length: float, load: str = "uniform") -> MemberPulse:
    """An IPE 300 of 6 m on pins under an impulse that takes Biggs' elastic stage so far.

    Its `length` over the period.
    """
    column = Column("IPE 300", 3.0, 3.0, base="pinned", head="pinned")
    elastic, *_, last = Biggs().stages(column, load == "uniform")
    mass = elastic.load_mass_factor * column.properties.mass_per_length * column.length
    circular = np.sqrt(elastic.stiffness / mass)
    lasts = length * 2.0 * np.pi / circular
    reached = ductility if ductility < 1.0 else np.sqrt(2.0 * ductility - 1.0)
    force = reached * last.load / circular / lasts
    scale = column.length if load == "uniform" else 1.0
    pulse = Pulse("rectangular", force / scale, lasts)
    return MemberPulse("impulse", column, pulse, load, 0.05)


@pytest.mark.parametrize(("load", "low"), [("uniform", (-0.02, 0.02)), ("point", (-0.14, -0.10))])
def test_an_impulse_on_an_elastic_beam_is_the_sum_of_its_modes(load, low) -> None:
    """Odd modes of a simple beam; a force gives all of them momentum, a line load hardly any."""
    hit = impulsive(0.6, 0.01, load)
    column, impulse, lasts = hit.column, hit.pulse.whole * hit.whole, hit.pulse.lasts
    mass = column.properties.mass_per_length * column.length
    bending = column.steel.elastic_modulus * column.properties.second_moment
    odd = np.arange(1, 80, 2)
    modes = odd**2 * np.pi**2 * np.sqrt(bending / mass / column.length**3)
    moved = 2.0 * np.ones(len(odd))
    if load == "uniform":
        moved *= 2.0 / (np.pi * odd) * np.where(odd % 4 == 1, 1.0, -1.0)
    moved *= impulse / (mass * modes) * np.sinc(0.5 * modes * lasts / np.pi)
    time = np.linspace(0.0, np.pi / modes[0], 4001)
    exact = 1e3 * float(np.max(np.sin(np.outer(time, modes)) @ moved))
    for name in ("biggs", "single-dof"):
        response = make_model(name).simulate(hit)
        assert low[0] < peak(response) / exact - 1.0 < low[1]
        assert "short-pulse" in subjects(response)


def test_an_impulse_that_makes_biggs_thirty_percent_low_is_warned_of_with_its_cause() -> None:
    """Fibers: 238.5 mm (fiber-corotational, one mesh) after 0.01 of a period, 145.5 after 0.4."""
    short, long = (make_model("biggs").simulate(impulsive(4.0, x)) for x in (0.01, 0.4))
    assert peak(short) == pytest.approx(0.71 * 238.5, rel=0.02)
    (said,) = [each for each in findings_of(short) if each.subject == "short-pulse"]
    assert (said.number, said.limit) == (pytest.approx(0.01, rel=1e-3), 0.15)
    assert "short-pulse" not in subjects(long)


def test_the_length_of_a_table_counts_suction() -> None:
    sides = (0.5, 0.5, -0.5, -0.5, 0.0)
    pulse = Pulse("table", 2e3, times=(0.0, 1.0, 1.001, 3.0, 4.0), factors=sides)
    assert pulse.lasts == pytest.approx(1.0 + 2.0 + 0.5, rel=1e-2)
    assert Pulse("triangular", 2e3, 4.0).lasts == pytest.approx(2.0)
