"""Gravity along a strike, held against closed forms: every model, columns and frames.

A mass m that falls from h onto a spring k without mass goes down by d + (d^2 + 2 h d)^1/2 with
d = m g / k (Gere and Goodno, Mechanics of materials, 9.10). Problem 9.10-4, 20 kN that fall by 1 mm
on a wooden beam: 4.46 mm by bending alone. A mass that is thrown back is away for 2 v / g.
"""

import json
from dataclasses import replace
from functools import cache
from math import sqrt

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.mechanics.frames.structure import dead_loads
from workbench.models.base import make_model
from workbench.models.batch import simulate_many
from workbench.responses import Outcome, Response, outcome_of, warnings_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    Frame,
    FrameImpact,
    FramePulse,
    FrameStatic,
    FrameStriker,
    Load,
    Member,
    MemberPulse,
    Node,
    Pulse,
    Striker,
    frame_scenario,
    scenario_hash,
    to_toml,
)
from workbench.scenarios.parts import GRAVITY
from workbench.steel.materials import Steel
from workbench.steel.sections import find, square
from workbench.study.error_model.error_model import expected_error

SIDE, LENGTH, MASS = 0.2804, 3.0, 2038.7
WOOD = Steel(elastic_modulus=12e9, yield_stress=100e6)
BEAM = Column(square(SIDE), 1.5, 1.5, WOOD, base="pinned", head="pinned", mass_per_length=5.0)
STIFFNESS = 48.0 * 12e9 * SIDE**4 / 12.0 / LENGTH**3  # of bending, N/m
LOW = sqrt(2.0 * GRAVITY * 1e-3)
RECORD = 0.06  # s, past the first peak: half of a period of the mass on the beam is 0.043 s
BARS = (
    *("flexible-superelement", "rigid-superelement", "giberson", "plastic-hinge"),
    "force-based-beam",
)
COARSE = {"levels": 1, "smallest_element": 0.375, "largest_element": 0.375}  # elastic: enough
OPTIONS: dict[str, dict[str, float]] = {
    "fiber-corotational": {**COARSE, "refinement": -1},
    "fiber-reissner": COARSE,
    **{name: {"elements": 4} for name in BARS},  # as many without weight
    "soft-impact": {"striker_stiffness": 1e10},
}
CURVES = ("single-dof", "biggs", "trilinear-catenary", "yin-wang", "izzuddin", "energy-estimate")
FRAMES = (*BARS, "fiber-corotational", "fiber-reissner")
MODELS = (*CURVES, "soft-impact", "four-dof", "four-dof-shear", *FRAMES)


def mostly_quick(names: tuple[str, ...]) -> list[object]:
    """Names of models, the one that takes half of all the time among the slow ones."""
    marks = {"fiber-corotational": [pytest.mark.slow]}
    return [pytest.param(name, marks=marks.get(name, [])) for name in names]


def fall(velocity: float, **changes: object) -> ColumnImpact:
    striker = Striker(MASS, velocity)
    return replace(ColumnImpact("fall", BEAM, striker, RECORD, "down"), **changes)


@cache
def answer(name: str, scenario: object) -> Response:
    response = make_model(name, OPTIONS.get(name, {})).simulate(scenario)  # type: ignore[arg-type]
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    return response


def peak(name: str, scenario: object) -> float:
    return float(answer(name, scenario)["peak_displacement"])


def fallen(mass: float, stiffness: float, velocity: float, gravity: float = GRAVITY) -> float:
    """Way of a mass on a spring that it meets with a velocity."""
    rest = mass * gravity / stiffness
    return rest + sqrt(rest**2 + mass * velocity**2 / stiffness)


@pytest.mark.thorough
@pytest.mark.parametrize("name", mostly_quick(MODELS))
def test_a_falling_mass_goes_as_far_as_the_closed_form(name: str) -> None:
    for velocity in (LOW,) if name in (*BARS[1:], "fiber-reissner") else (LOW, 10.0 * LOW):
        weightless = peak(name, fall(velocity, gravity=False))
        stiffness = MASS * (velocity / weightless) ** 2  # of the model: shear, hinges, some mass
        assert stiffness == pytest.approx(STIFFNESS, rel=0.07)
        went = peak(name, fall(velocity))
        assert went == pytest.approx(fallen(MASS, stiffness, velocity), rel=6e-3)
    assert peak(name, fall(LOW)) == pytest.approx(4.46e-3, rel=0.04)  # bending alone
    up = peak(name, fall(LOW, direction="up", gravity=True))
    stiffness = MASS * (LOW / peak(name, fall(LOW, gravity=False))) ** 2
    rings = 4e-2 if name == "soft-impact" else 1.2e-2  # its beam rings on an elastic front
    assert up == pytest.approx(fallen(MASS, stiffness, LOW, -GRAVITY), rel=rings)


def beam_frame(**changes: object) -> Frame:
    nodes = (
        Node("L", 0.0, 0.0, "pinned"),
        Node("M", 1.5, 0.0),
        Node("R", 3.0, 0.0, "roller-x"),
    )
    own = {"mass_per_length": 5.0, **changes}
    members = tuple(
        Member(a + b, a, b, square(SIDE), **own)  # type: ignore[arg-type]
        for a, b in ("LM", "MR")
    )
    return Frame(nodes, members, steel=WOOD)


@pytest.mark.thorough
@pytest.mark.parametrize("name", mostly_quick(FRAMES))
def test_a_frame_that_lies_answers_as_the_column(name: str) -> None:
    striker = FrameStriker(MASS, LOW, node="M", direction="-y")
    frame = FrameImpact("fall", beam_frame(), striker, RECORD)
    assert peak(name, frame) == pytest.approx(peak(name, fall(LOW)), rel=2e-3)
    without = replace(frame, gravity=False)
    assert peak(name, without) == pytest.approx(peak(name, fall(LOW, gravity=False)), rel=2e-3)


HEAVY = replace(BEAM, mass_per_length=2000.0)
SAG = 5.0 / 384.0 * 2000.0 * GRAVITY * LENGTH**4 / (STIFFNESS * LENGTH**3 / 48.0)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        # two rigid bars bring half of the weight to the impact point: 4/5 of the deflection
        *((name, 0.79, 0.83) for name in ("single-dof", "soft-impact", "four-dof")),
        *((name, 0.97, 1.04) for name in FRAMES),
    ],
)
def test_a_member_that_lies_is_hit_where_its_weight_has_taken_it(
    name: str, least: float, most: float
) -> None:
    """5 q L^4 / 384 EI, from which displacements count; an elastic hit does not see it."""
    lying = fall(2.0, column=HEAVY, duration=0.1)
    response = answer(name, lying)
    assert least * SAG < response.attrs["dead_displacement"] < most * SAG
    assert float(response["displacement"][0]) == 0.0
    weightless = peak(name, replace(lying, gravity=False))
    heavier = float(response["peak_displacement"]) - weightless
    assert 0.0 < heavier < 1.3 * MASS * GRAVITY / STIFFNESS  # the striker alone, if it stays


@pytest.mark.parametrize("name", ["single-dof", "four-dof", "flexible-superelement"])
@pytest.mark.parametrize("direction", ["down", "up"])
def test_energy_and_momentum_of_a_fall_are_kept(name: str, direction: str) -> None:
    column = Column(find("HEB 200"), 1.2, 2.8, base="clamped", axial_load=2e5)
    for front in (None, 4e6):
        striker = Striker(800.0, 7.0, stiffness=front)
        scenario = ColumnImpact("drop", column, striker, 0.15, direction, True)
        response = answer(name, scenario)
        given = scenario.input_energy + float(np.abs(response["external_work"]).max())
        assert float(np.abs(response["balance_error"]).max()) < 1e-6 * given
        lost = 800.0 * (7.0 - float(response["striker_velocity"][-1]))
        fell = 800.0 * scenario.acceleration * 0.15
        assert float(response["percussion"].sum()) == pytest.approx(lost + fell, rel=1e-6)


@pytest.mark.parametrize("name", ["single-dof", "four-dof", "flexible-superelement"])
def test_a_mass_that_is_thrown_back_returns_under_gravity(name: str) -> None:
    """Off a heavy beam with half of its velocity, and down again 2 v / g later."""
    column = replace(BEAM, mass_per_length=5e4, section=square(0.6), steel=Steel())
    scenario = ColumnImpact("ball", column, Striker(1.0, 1.0, 0.5), 0.18, "down")
    response = answer(name, scenario)
    hits = response["time"].values[response["percussion"].values > 0.0]
    speed = response["striker_velocity"].values
    again = hits[hits > 0.05][0]
    assert again == pytest.approx(2.0 * -speed.min() / GRAVITY, rel=0.02)
    still = answer(name, replace(scenario, gravity=False))["percussion"].values
    assert not (still[response["time"].size // 2 :] > 0.0).any()


def test_hand_estimate_takes_the_weights_off_the_resistance() -> None:
    column = Column(find("HEB 200"), 2.0, 2.0, base="pinned", head="pinned")
    scenario = ColumnImpact("drop", column, Striker(5000.0, 4.0), 0.2, "down")
    p, own = column.properties, column.properties.mass_per_length * 4.0
    shared = scenario.input_energy * 5000.0 / (5000.0 + own / 3.0)
    left = p.plastic_moment - (5000.0 + own / 2.0) * GRAVITY
    assert peak("hand-estimate", scenario) == pytest.approx(shared / left, rel=1e-9)
    plastic = peak("energy-estimate", scenario) / peak(
        "energy-estimate", replace(scenario, gravity=False)
    )
    assert 1.2 < plastic < 1.4
    heavy = replace(scenario, striker=Striker(30_000.0, 1.0))
    response = make_model("hand-estimate").simulate(heavy)
    assert outcome_of(response) is Outcome.COLLAPSE


def test_a_pulse_on_a_member_that_lies_meets_less_strength() -> None:
    column = Column(find("HEB 200"), 2.0, 2.0, base="pinned", head="pinned", mass_per_length=3000.0)
    pulse = Pulse("rectangular", 90e3, 0.05)
    standing = MemberPulse("pulse", column, pulse, "uniform", 0.5)
    for name in ("single-dof", "biggs", "flexible-superelement"):
        lying = answer(name, replace(standing, direction="down"))
        lifted = answer(name, replace(standing, direction="up", gravity=True))
        still = float(answer(name, standing)["peak_displacement"])
        assert float(lifted["peak_displacement"]) < still < float(lying["peak_displacement"])
        sag = 5.0 / 384.0 * 3000.0 * GRAVITY * 4.0**4 / (210e9 * column.properties.second_moment)
        assert sag < 1.02 * lying.attrs["dead_displacement"] < 1.12 * sag  # shear of the web on top


def test_own_weight_is_a_dead_load_of_every_frame() -> None:
    frame = beam_frame(mass_per_length=400.0)
    push = FrameStatic("push", frame, (Load("M", y=-1.0),), "M", "-y", (1e-3,), gravity=True)
    model = make_model("flexible-superelement")
    assembly = model.structure(push).assembly
    total = float(assembly.load[assembly.dofs(range(len(assembly.coordinates)), "v")].sum())
    assert total == pytest.approx(-400.0 * LENGTH * GRAVITY, rel=1e-9)
    assert sum(load.y for load in dead_loads(push.frame)) == pytest.approx(total, rel=1e-9)
    # a dead load that stands for the mass of a node is not counted twice
    nodes = tuple(replace(n, mass=100.0 if n.name == "M" else 0.0) for n in frame.nodes)
    stood = replace(frame, nodes=nodes, loads=(Load("M", y=-60.0 * GRAVITY),))
    twice = replace(push, frame=stood)
    load = model.structure(twice).assembly.load
    assert float(load.sum()) == pytest.approx(total - 100.0 * GRAVITY, rel=1e-9)
    pulse = Pulse("rectangular", 1e3, 0.01)
    pressed = FramePulse("pulse", frame, pulse, "M", "-y", members=("LM", "MR"), gravity=True)
    assert any(pressed.frame.gravity)
    assert not any(replace(pressed, gravity=False).frame.gravity)


def test_gravity_is_on_where_a_striker_comes_down() -> None:
    striker = FrameStriker(MASS, LOW, node="M", direction="-y")
    frame = FrameImpact("fall", beam_frame(), striker, 0.2)
    assert frame.gravity is True
    assert frame.acceleration == GRAVITY
    upwards = replace(striker, direction="+y")
    up = FrameImpact("up", beam_frame(), upwards, 0.2)
    assert up.acceleration == 0.0
    assert replace(up, gravity=True).acceleration == -GRAVITY
    assert fall(LOW).acceleration == GRAVITY
    assert fall(LOW, gravity=False).acceleration == 0.0
    assert fall(LOW, direction=None).acceleration == 0.0
    assert "gravity" not in to_toml(fall(LOW, direction=None))  # answers that are stored stay
    assert scenario_hash(fall(LOW)) != scenario_hash(fall(LOW, direction=None))
    with pytest.raises(InputError, match=r"striker\.direction.*down or up"):
        fall(LOW, direction="horizontal", gravity=True)
    with pytest.raises(InputError, match=r"pulse\.direction"):
        MemberPulse("pulse", BEAM, Pulse("rectangular", 1.0, 1.0), gravity=True)
    event = frame_scenario(fall(LOW))
    assert isinstance(event, FrameImpact)
    assert event.acceleration == GRAVITY


@pytest.mark.parametrize("name", ["single-dof", "energy-estimate", "soft-impact", "four-dof"])
def test_many_falls_are_answered_as_one(name: str) -> None:
    falls = [fall(velocity) for velocity in (LOW, 2.0 * LOW)]
    table = simulate_many(make_model(name, OPTIONS.get(name, {})), falls)
    wanted = [peak(name, each) for each in falls]
    assert table["peak_displacement"].tolist() == pytest.approx(wanted, rel=1e-12)


def test_the_error_of_a_fall_is_not_told_by_hits_without_gravity() -> None:
    column = Column(find("HEB 200"), 1.2, 2.8, axial_load=2e5)
    drop = ColumnImpact("drop", column, Striker(1500.0, 6.0), 0.1, "down")
    error = expected_error(drop, answer("single-dof", drop))
    assert error.low is None
    assert "without gravity" in error.reason
    striker = FrameStriker(300.0, 5.0, node="M", direction="-y")
    lying = FrameImpact("fall", beam_frame(mass_per_length=50.0), striker, 0.2)
    error = expected_error(lying, answer("flexible-superelement", lying))
    assert error.low is None
    assert "without gravity" in error.reason


def test_a_rule_that_knows_no_weight_says_so() -> None:
    texts = [each.text for each in warnings_of(answer("en-1991-hard-impact", fall(LOW)))]
    assert any(text.startswith("gravity is not used by this model") for text in texts)


def test_the_column_of_a_frame_falls_as_the_frame() -> None:
    striker = FrameStriker(MASS, LOW, node="M", direction="-y")
    frame = FrameImpact("fall", beam_frame(), striker, RECORD)
    assert peak("column-of-frame", frame) == pytest.approx(peak("four-dof", fall(LOW)), rel=2e-3)


def test_what_rests_on_a_structure_has_no_residual_displacement() -> None:
    response = answer("four-dof", fall(LOW, duration=0.2))
    assert "residual_displacement" not in response
    assert any("comes to rest" in each.text for each in warnings_of(response))
    assert json.loads(response.attrs["findings"])
    assert float(answer("single-dof", fall(LOW, duration=0.2))["residual_displacement"]) == 0.0
