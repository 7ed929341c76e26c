"""Members under pulses: closed forms of one mass, tables, beams by modes, frames and members."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sin, sqrt

import numpy as np
import pytest
from builders import portal

from workbench.extras.practice.biggs import Biggs, dynamic_reactions
from workbench.extras.practice.catenary import Izzuddin, TrilinearCatenary, YinWang
from workbench.mechanics.frames.members import shear_stiffness
from workbench.mechanics.impact.integrator import follow
from workbench.mechanics.impact.pace import Pace
from workbench.models.base import Model
from workbench.models.references.fiber_beams import FiberCorotational, FiberShear
from workbench.models.resistance import ResistanceCurve, mechanism_of
from workbench.models.resistance.kernels import PIECE
from workbench.models.resistance.shapes import DeflectedBeam
from workbench.models.single_dof import SingleDof, march
from workbench.models.single_dof.model import Pushed, no_striker, push, under_pulse
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Finding, Outcome, energy_error, outcome_of, warnings_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    FramePulse,
    MemberPulse,
    Pulse,
    Striker,
    frame_scenario,
)
from workbench.scenarios.pulse import UNIFORM
from workbench.steel.sections import find
from workbench.study.error_model.error_model import advise
from workbench.study.limit import pressure_impulse_curve

MASS, STIFFNESS, STRENGTH = 200.0, 5e7, 5e5
OMEGA = sqrt(STIFFNESS / MASS)


@pytest.fixture(scope="module")
def column() -> Column:
    return Column(find("HEB 220"), 2.0, 2.0, fillets=False)


def bilinear(column: Column) -> Pushed:
    """An elastic-perfectly plastic mass."""
    pieces = np.zeros(2, PIECE)
    pieces["start"][1] = STRENGTH / STIFFNESS
    pieces["c"][0, 1], pieces["c"][1, 0] = STIFFNESS, STRENGTH
    curve = ResistanceCurve("bilinear", mechanism_of(column), pieces, STRENGTH / STIFFNESS)
    return Pushed(curve, ((0.0, MASS, 1.0),), 1.0, True)


def peak(column: Column, pulse: Pulse, duration: float) -> float:
    return float(push(bilinear(column), column, pulse, duration)[1]["displacement"].max())


# dynamic load factors of textbooks at omega t_d = 0.1, 0.4, 1, 2, pi, 10, 40, 100
FACTORS = {
    "triangular": (0.0500, 0.199, 0.486, 0.894, 1.196, 1.706, 1.923, 1.969),
    "rectangular": (0.0999, 0.397, 0.959, 1.683, 2.0, 2.0, 2.0, 2.0),
}


@pytest.mark.parametrize("shape", FACTORS)
def test_elastic_peaks_are_those_of_the_table(column, shape) -> None:
    for length, factor in zip((0.1, 0.4, 1, 2, pi, 10, 40, 100), FACTORS[shape], strict=True):
        pulse = Pulse(shape, 0.2 * STRENGTH, length / OMEGA)
        result = peak(column, pulse, (length + 7.0) / OMEGA) * STIFFNESS / pulse.peak
        assert result == pytest.approx(factor, rel=2.5e-3)


def test_a_ramp_in_closed_form(column) -> None:
    for length in (1.0, 2.5, 7.0):
        pulse = Pulse("ramp", 0.2 * STRENGTH, length / OMEGA)
        exact = 1.0 + abs(sin(0.5 * length)) / (0.5 * length)
        result = peak(column, pulse, (length + 7.0) / OMEGA) * STIFFNESS / pulse.peak
        assert result == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("ratio", [0.02, 0.2, 0.7])
def test_radiation_damping_in_closed_form(column, ratio) -> None:
    """An elastic mass on a dashpot under a load that stays; the ledger holds what is radiated."""
    damping, load = 2.0 * ratio * MASS * OMEGA, 0.3 * STRENGTH
    pulse = Pulse("rectangular", load, 1.0)
    damped = bilinear(column)._replace(damping=damping)
    time, values = push(damped, column, pulse, 12.0 / OMEGA)
    root = sqrt(1.0 - ratio**2)
    turn = root * OMEGA * time
    left = np.exp(-ratio * OMEGA * time) * (np.cos(turn) + ratio / root * np.sin(turn))
    off = values["displacement"] * STIFFNESS / load - (1.0 - left)
    assert np.abs(off).max() < 3e-3  # measured 2e-3: 64 steps a period
    sum_ = values["kinetic"] + values["elastic"] + values["dissipated"]
    np.testing.assert_allclose(sum_, values["external_work"], atol=1e-12 * values["input_energy"])


def test_a_dashpot_is_what_an_endless_bar_is_to_a_mass(column) -> None:
    """Waves leave along a bar of impedance Z = rho c A: leapfrog at its limit is exact on it."""
    impedance, load = 0.5 * MASS * OMEGA, 0.9 * STRENGTH
    damped = bilinear(column)._replace(damping=impedance)
    pulse, until = Pulse("triangular", load, 3.0 / OMEGA), 12.0 / OMEGA
    values = push(damped, column, pulse, until)[1]
    parts = 2400
    h = until / parts  # of time, in which a wave passes one piece of the bar: stiffness Z / h
    mass = np.full(parts, impedance * h)
    mass[0] = MASS + 0.5 * impedance * h
    u, before = np.zeros((2, parts))
    highest = 0.0
    for n in range(parts):
        stretch = np.diff(u, append=0.0) * impedance / h
        force = stretch - np.append(0.0, stretch[:-1])
        force[0] += float(pulse.force(n * h)) - STIFFNESS * u[0]
        u, before = 2.0 * u - before + h * h / mass * force * (0.5 if n == 0 else 1.0), u
        highest = max(highest, float(u[0]))
    assert highest * STIFFNESS < STRENGTH
    assert values["displacement"].max() == pytest.approx(highest, rel=2e-3)
    assert peak(column, pulse, until) > 1.3 * highest


def test_radiation_damping_is_of_pulses_and_slows_every_one_mass_model(column) -> None:
    pulse = MemberPulse("pulse", column, Pulse("triangular", 2e5, 0.02), "uniform", 0.06)
    for kind in (SingleDof, Biggs, YinWang):
        free, damped = (kind(radiation_damping=c).simulate(pulse) for c in (0.0, 1e4))
        assert outcome_of(damped) is Outcome.OK
        assert damped["displacement"].max() < 0.95 * free["displacement"].max()
    hit = ColumnImpact("hit", column, Striker(500.0, 5.0))
    refused = SingleDof(radiation_damping=1e4).simulate(hit)
    assert outcome_of(refused) is Outcome.OUT_OF_DOMAIN
    assert "acts under pulses alone" in refused.attrs["message"]


@pytest.mark.parametrize("share", [0.55, 0.75, 0.9])
def test_ductility_under_a_step(column, share) -> None:
    result = peak(column, Pulse("ramp", share * STRENGTH, 1e-6), 0.2) * STIFFNESS / STRENGTH
    assert result == pytest.approx(1.0 / (2.0 * (1.0 - share)), rel=2e-3)


@pytest.mark.parametrize("ductility", [1.5, 5.0, 20.0])
def test_ductility_under_an_impulse(column, ductility) -> None:
    impulse = STRENGTH / OMEGA * sqrt(2.0 * ductility - 1.0)
    length = 0.01 / OMEGA
    result = peak(column, Pulse("rectangular", impulse / length, length), 0.05)
    assert result * STIFFNESS / STRENGTH == pytest.approx(ductility, rel=5e-3)


# (R, F) of the reactions, UFC 3-340-02
REACTIONS = {
    "simple, uniform": ((False, False), 0.0, [(0.39, 0.11), (0.38, 0.12)]),
    "simple, point": ((False, False), 1.0, [(0.78, -0.28), (0.75, -0.25)]),
    "fixed, uniform": ((True, True), 0.0, [(0.36, 0.14), (0.39, 0.11), (0.38, 0.12)]),
    "fixed, point": ((True, True), 1.0, [(0.71, -0.21), (0.75, -0.25)]),
}


@pytest.mark.parametrize("case", REACTIONS)
def test_dynamic_reactions_are_those_of_the_tables(case) -> None:
    clamped, force, rows = REACTIONS[case]
    stages = DeflectedBeam((0.0, 0.5, 1.0), clamped, (force,), 1.0).stages(np.ones(3))
    for stage, (of_resistance, of_load) in zip(stages, rows, strict=True):
        moved = np.full(2, stage.start + 1e-9)
        resisted = stage.load + 1e-9 * stage.stiffness
        load = np.array([0.0, 1.0])
        result = dynamic_reactions(stages, force == 0.0, moved, np.full(2, resisted), load)
        np.testing.assert_allclose(result[0], result[1])
        if resisted > 1e-6:  # the tables round 0.375 and 0.125 to 0.38 and 0.12
            assert result[0, 0] / resisted == pytest.approx(of_resistance, abs=0.0051)
        assert result[0, 1] - result[0, 0] == pytest.approx(of_load, abs=0.0051)


@pytest.mark.parametrize("case", REACTIONS)
def test_reactions_after_the_peak_go_with_what_is_left_of_the_resistance(case) -> None:
    """The member springs back elastically, its inertia keeps the shape of the mechanism."""
    clamped, force, rows = REACTIONS[case]
    stages = DeflectedBeam((0.0, 0.5, 1.0), clamped, (force,), 1.0).stages(np.ones(3))
    top, (first, *_, last) = 2.0 * stages[-1].start, stages
    for left in (0.5, -0.2):
        back = top - (1.0 - left) * last.load / first.stiffness
        moved, resisted = np.array([top, back]), last.load * np.array([1.0, left])
        result = dynamic_reactions(stages, force == 0.0, moved, resisted, np.zeros(2))
        np.testing.assert_allclose(result[0], result[1])
        assert result[0, 1] / resisted[1] == pytest.approx(rows[-1][0], abs=0.0051)


def test_masses_of_stages_change_on_either_swing(column) -> None:
    """What a push does to one side, its opposite does to the other."""
    curve = bilinear(column).curve
    stages = np.array([[0.0, MASS, 1.0], [0.7 * STRENGTH / STIFFNESS, 0.8 * MASS, 1.0]])
    means, step, swings = np.full(300, 1.5 * STRENGTH), 2e-4 / OMEGA**0.5, []
    drive = no_striker(curve.elastic_limit, np.inf, MASS)
    for sign in (1.0, -1.0):
        tables, pace = (curve.pieces, stages, sign * means, 0.0), Pace.equal(300 * step, step, 300)
        run = follow(under_pulse, tables, pace, drive, march.RECORD)
        swings.append(sign * run.records["velocity"])
    assert np.abs(swings[0]).max() > 1.0
    np.testing.assert_allclose(swings[1], swings[0], rtol=1e-9)


def test_reactions_of_an_eccentric_member_at_rest_are_static(thesis_impact) -> None:
    column = replace(thesis_impact.column, axial_load=0.0)
    a, b, length = column.length_below, column.length_above, column.length
    stages = Biggs().stages(column)
    load = 0.5 * stages[1].load
    moved, force = np.array([load / stages[0].stiffness]), np.array([load])
    result = dynamic_reactions(stages, False, moved, force, force)[:, 0]
    np.testing.assert_allclose(result.sum(), load)  # fixed beam: P b^2 (3 a + b) / L^3 at the base
    assert result[0] == pytest.approx(load * b**2 * (3.0 * a + b) / length**3)


def simple(load: str, peak: float, pulse_length: float = 10.0) -> MemberPulse:
    """A simply supported beam, free along its axis."""
    beam = Column(find("HEB 220"), 2.0, 2.0, base="pinned", head="pinned")
    return MemberPulse("step", beam, Pulse("rectangular", peak, pulse_length), load, 0.04)


@pytest.mark.claim("model:biggs", "peak under a step over its modes", "closed form", 1, 0.02)
def test_a_step_on_an_elastic_beam_is_the_sum_of_its_modes(claim) -> None:
    scenario = simple("uniform", 1e4)
    properties, steel = scenario.column.properties, scenario.column.steel
    EI, mass, length = (
        steel.elastic_modulus * properties.second_moment,
        properties.mass_per_length,
        4.0,
    )
    time = np.linspace(0.0, 0.04, 2001)
    exact = np.zeros_like(time)
    for n in range(1, 20, 2):
        omega = (n * pi / length) ** 2 * sqrt(EI / mass)
        part = 4.0 * 1e4 / (n * pi * mass * omega**2) * sin(0.5 * n * pi)
        exact += part * (1.0 - np.cos(omega * time))
    shear = shear_stiffness(scenario.column.section, steel)
    softer = 1.0 + 9.6 * EI / (shear * length**2)  # of the static deflection, by shear strain
    for model, factor in (
        (
            FlexibleSuperelement(elements=6, hinge_stiffness=1e3, shear="none"),
            1.0,
        ),
        (FiberCorotational(levels=1, smallest_element=0.25, largest_element=0.25), softer),
    ):
        response = model.simulate(scenario)
        expected = factor * exact.max()
        assert float(response["peak_displacement"]) == pytest.approx(expected, rel=0.01)
        assert float(response["load"].max()) == pytest.approx(1e4 * length)
        assert energy_error(response) < 1e-8
    claim(Biggs().simulate(scenario)["peak_displacement"] / exact.max())


def beam_under(share: float, lasts: float, load: str) -> MemberPulse:
    """A simple beam under a rectangular pulse of a share of its mechanism, `lasts` periods long."""
    beam = Column(find("HEB 220"), 3.0, 3.0, base="pinned", head="pinned")
    first, *_, last = Biggs().stages(beam, load == "uniform")
    mass = first.load_mass_factor * beam.properties.mass_per_length * beam.length
    period = 2.0 * pi * sqrt(mass / first.stiffness)
    peak = share * last.load / (beam.length if load == "uniform" else 1.0)
    pulse = Pulse("rectangular", peak, lasts * period)
    return MemberPulse("beam", beam, pulse, load, (lasts + 3.0) * period)


@pytest.mark.thorough
@pytest.mark.parametrize("load", ["point", "uniform"])
@pytest.mark.parametrize(("share", "lasts"), [(1.0, 1.0), (0.3, 0.4), (0.4, 3.0)])
def test_single_degrees_of_freedom_go_as_far_as_fibers_or_warn(load, share, lasts) -> None:
    scenario = beam_under(share, lasts, load)
    exact = float(FiberShear(levels=1).simulate(scenario)["peak_displacement"])
    for model in (SingleDof(), TrilinearCatenary(), YinWang(), Izzuddin(), Biggs()):
        response = model.simulate(scenario)
        off = abs(float(response["peak_displacement"]) / exact - 1.0)
        assert off < (0.2 if advise(model, scenario, response) else 0.1)
        assert off < 0.06 or not isinstance(model, SingleDof) or model.name != "single-dof"


def test_a_line_load_deflects_the_member_as_in_the_table() -> None:
    for base, head, flexibility in (
        ("pinned", "pinned", 5 / 384),
        ("clamped", "guided", 1 / 384),
        ("clamped", "pinned", 1 / 192),
    ):
        beam = Column(find("IPE 100"), 3.0, 3.0, base=base, head=head)
        properties = beam.properties
        stiffness = beam.steel.elastic_modulus * properties.second_moment / 6.0**3 / flexibility
        curve = SingleDof().curve(beam, uniform=True)
        assert 2.0 * curve.initial_stiffness == pytest.approx(stiffness, rel=0.02)  # shear
        loaded = SingleDof().curve(replace(beam, axial_load=2e4), uniform=True)
        euler = (2.0 if head == "pinned" else 4.0) ** (base != "pinned") * pi**2
        euler *= beam.steel.elastic_modulus * properties.second_moment / 36.0
        ratio = loaded.initial_stiffness / curve.initial_stiffness
        assert ratio == pytest.approx(1.0 - 2e4 / euler, abs=0.01)


def advice(model: Model, scenario: MemberPulse) -> list[Finding]:
    return advise(model, scenario, model.simulate(scenario))


def test_an_answer_under_a_pulse_is_told_its_error() -> None:
    scenario = beam_under(0.8, 2.0, "uniform")
    (finding,) = [f for f in advice(Biggs(), scenario) if f.subject == "error"]
    assert finding.text.startswith("expect -")
    elastic = replace(scenario, pulse=replace(scenario.pulse, peak=0.2 * scenario.pulse.peak))
    assert not [f for f in advice(FlexibleSuperelement(), elastic) if f.subject == "error"]
    assert not [f for f in warnings_of(SingleDof().simulate(scenario)) if f.subject == "error"]


def test_time_of_peak_is_that_of_the_first_of_equal_cycles() -> None:
    scenario = beam_under(0.4, 0.4, "point")
    for model in (SingleDof(), Biggs(), FlexibleSuperelement(elements=1)):  # more bars, more modes
        times = {
            round(float(model.simulate(replace(scenario, duration=end))["time_of_peak"]), 4)
            for end in (0.061, 0.14, 0.2)
        }
        assert len(times) == 1


COARSE = FiberCorotational(levels=1, smallest_element=0.5, largest_element=0.5, refinement=-1)
ONE_MEANING = [Biggs(), SingleDof(), RigidSuperelement(), COARSE]


@pytest.mark.thorough
@pytest.mark.parametrize("model", ONE_MEANING, ids=lambda model: model.name)
def test_what_remains_is_known_once_the_load_is_gone(model: Model) -> None:
    """An elastic member comes back to where it was, and says nothing of that under its load."""
    simple = Column(find("HEB 220"), 2.0, 2.0, base="pinned", head="pinned")
    step = Pulse("rectangular", 3e4, 1.0)
    stays = MemberPulse("stays", simple, step, UNIFORM, 0.2)
    gone = replace(stays, pulse=replace(step, length=0.05))
    for pulse in (step, Pulse("ramp", 3e4, 0.01), Pulse("exponential", 3e4, 0.1)):
        response = model.simulate(replace(stays, pulse=pulse))
        assert outcome_of(response) is Outcome.OK
        assert "residual_displacement" not in response
        assert "peak_displacement" in response
    response = model.simulate(gone)
    peak = abs(float(response["peak_displacement"]))
    assert float(response["residual_displacement"]) == pytest.approx(0.0, abs=0.01 * peak)


@pytest.mark.thorough
def test_frames_know_what_remains_once_the_load_is_gone() -> None:
    frame = portal().split("A0-A1", 2.0, "hit")
    step = Pulse("rectangular", 1e4, 3.0)
    stays = FramePulse("stays", frame, step, "hit", members=("A0-A1/1",), duration=1.0)
    assert "residual_displacement" not in RigidSuperelement().simulate(stays)
    response = RigidSuperelement().simulate(replace(stays, pulse=replace(step, length=0.2)))
    peak = abs(float(response["peak_displacement"]))
    assert float(response["residual_displacement"]) == pytest.approx(0.0, abs=0.03 * peak)


def test_suction_reaches_a_displacement_as_pressure_does(column) -> None:
    """A limit asks for the magnitude: a pulse and its mirror image have the same peak."""
    peaks = []
    for sign in (1.0, -1.0):
        table = Pulse("table", 1e5, times=(0.0, 0.01, 0.02), factors=(0.0, sign, 0.0))
        scenario = MemberPulse("pulse", column, table, duration=0.05)
        peaks += [point.peak for point in pressure_impulse_curve(Biggs(), scenario, 0.05, (0.02,))]
    assert peaks[0] > 1e5
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-9)


def test_a_member_is_a_frame_of_two() -> None:
    model = FlexibleSuperelement()
    for load, size in (("point", 1e6), ("uniform", 3e5)):
        scenario = simple(load, size, 0.004)
        alone, framed = model.simulate(scenario), model.simulate(frame_scenario(scenario))
        np.testing.assert_array_equal(alone["displacement"], framed["displacement"])
        assert float(alone["dissipated"][-1]) > 1e3
        findings = {finding.subject for finding in warnings_of(alone)}
        assert "line-load" not in findings  # cut by itself
        coarse = {finding.subject for finding in FlexibleSuperelement(elements=1).domain(scenario)}
        assert ("line-load" in coarse) == (load == "uniform")


# profile, lengths below and above (m), base, force (N), length of the pulse (s)
OFF_MIDSPAN = (
    ("HEA 220", 1.1, 4.4, "pinned", 2.4e5, 0.022),
    ("IPE 240", 4.2, 1.0, "clamped", 2e5, 0.006),
    ("HEB 160", 1.2, 2.4, "clamped", 4e4, 0.012),  # elastic
)


@pytest.mark.thorough
@pytest.mark.parametrize("case", OFF_MIDSPAN, ids=lambda case: case[0])
def test_a_force_off_midspan_moves_superelements_as_far_as_fiber_beams(case) -> None:
    """One bar on either side went up to twice as far: its mass swings with its impact point."""
    profile, below, above, base, force, length = case
    member = Column(find(profile), below, above, base=base, head="pinned")
    scenario = MemberPulse("off midspan", member, Pulse("triangular", force, length), "point", 0.06)
    expected = float(FiberShear(levels=1).simulate(scenario)["peak_displacement"])
    for model, most in ((FlexibleSuperelement(), 0.08), (RigidSuperelement(), 0.05)):
        response = model.simulate(scenario)
        assert float(response["peak_displacement"]) == pytest.approx(expected, rel=most)


def test_no_advice_leads_to_fiber_shear_where_a_pulse_shears_webs_off(column) -> None:
    """The finer its mesh, the further it goes: nothing keeps the slide from a single section."""
    pulse = Pulse("triangular", 2.6 * column.properties.shear_resistance, 0.004)
    punched = MemberPulse("punched", column, pulse, "point", 0.02)
    models = FiberShear(levels=1), FiberShear(levels=1, refinement=1)
    coarse, fine = (float(m.simulate(punched)["peak_displacement"]) for m in models)
    assert fine > 1.3 * coarse
    weaker = MemberPulse("weaker", column, replace(pulse, peak=0.7 * pulse.peak), "point")
    line = MemberPulse("line", column, replace(pulse, peak=pulse.peak / 4.0), "uniform")
    for model in (FiberShear(), FlexibleSuperelement(), Biggs()):
        findings = [
            "direct-shear" in {finding.subject for finding in model.domain(scenario)}
            for scenario in (punched, weaker, line)
        ]
        assert findings == [True, False, isinstance(model, Biggs)]
    short = Column(find("HEB 260"), 1.1, 4.7)
    for model, expected in ((FiberShear(), True), (FlexibleSuperelement(), False)):
        long = MemberPulse("long", short, Pulse("triangular", 6e5, 0.06))
        assert ("clear-web" in {f.subject for f in model.domain(long)}) == expected
    for name in ("fiber-shear", "fiber-reissner"):
        assert name not in warned(Biggs(), punched) + warned(Biggs(), line)
    assert "no model" in warned(Biggs(), line)  # fiber beams judge nobody there, see clear-web


def warned(model: Biggs, scenario: MemberPulse) -> str:
    """What a model says of direct shear, as it answers."""
    (finding,) = (f for f in advice(model, scenario) if f.subject == "direct-shear")
    return finding.remedy


def test_hinges_under_a_line_load_carry_that_of_limit_analysis(column) -> None:
    model, strength = SingleDof(resistance="analytic"), column.properties.plastic_moment
    limit = 16.0 * strength / 4.0**2  # q L = 16 M / L
    for share, stays in ((0.95, False), (1.05, True)):
        pulse = Pulse("ramp", share * limit, 0.3)
        response = model.simulate(MemberPulse("slow", column, pulse, "uniform", 0.5))
        gone = outcome_of(response) is Outcome.COLLAPSE
        assert gone == stays


@pytest.mark.thorough
def test_energies_and_warnings(column) -> None:
    short = MemberPulse("short", column, Pulse("triangular", 2e7, 2e-4), "point", 0.05)
    for model in (SingleDof(), Biggs(), Izzuddin()):
        response = model.simulate(short)
        assert energy_error(response) < 1e-9
    near = MemberPulse("near", column, Pulse("rectangular", 5.4e5, 0.05), "point", 0.1)
    for scenario in (short, near):  # a short pulse, a load near the resistance
        subjects = {finding.subject for finding in advice(SingleDof(), scenario)}
        assert {"error", "error-not-measured"} & subjects
    soft = MemberPulse("soft", column, Pulse("rectangular", 3.5e5, 0.01), "point", 0.1)
    findings = [finding.text for finding in SingleDof().domain(short)]
    assert any("direct shear" in text for text in findings)
    assert not any("direct shear" in f.text for f in SingleDof().domain(soft))
    response = Biggs().simulate(replace(short, load="uniform"))
    assert "elastic" not in response  # not those of the member
    assert response["reaction"].shape == (2, response.sizes["time"])
