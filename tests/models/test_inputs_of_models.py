"""Inputs that a scenario sets: each model uses them, or says that it does not."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import fields, replace
from math import sqrt
from typing import Any

import pytest

from workbench.base.codec import inputs_of, set_inputs
from workbench.models import frame_model
from workbench.models.base import Model, make_model, model_kind, model_names
from workbench.models.frame_model import FrameModel
from workbench.responses import findings_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameStatic,
    FrameStriker,
    Joint,
    Load,
    Member,
    MemberPulse,
    Node,
    Pulse,
    Scenario,
    Striker,
    frame_scenario,
)
from workbench.scenarios.varied import with_other_inputs
from workbench.steel.sections import find
from workbench.study.error_model.error_model import advised, doubts, truth_ratio
from workbench.testing import ignored_inputs

SECTION = find("HEB 220")
COLUMN = Column(SECTION, 1.5, 2.5, axial_load=4e5, restraint_stiffness=2e7, head_mass=300.0)
SEMI = Joint("semi", 2e7, 2e9, 1.2e5, 1.1e5, 3e5, 2.8e5)
FRAME = Frame(
    (
        Node("A0", 0.0, 0.0, "clamped"),
        Node("A", 0.0, 1.5, mass=100.0, rotary_inertia=5.0),
        Node("A1", 0.0, 4.0, mass=500.0),
        Node("B1", 5.0, 4.0, spring_x=1e5, spring_y=1e5, spring_rotation=1e4),
        Node("B0", 5.0, 0.0, "pinned"),
    ),
    (
        Member("A0-A", "A0", "A", SECTION),
        Member("A-A1", "A", "A1", SECTION),
        Member("A1-B1", "A1", "B1", find("IPE 270"), "semi", "semi"),
        Member("B0-B1", "B0", "B1", SECTION),
    ),
    (Load("A1", y=-2e5, x=1e3, moment=1e3), Load("B1", y=-2e5)),
    (SEMI,),
)
PATTERN = (Load("A1", x=1.0, y=-0.1, moment=0.1),)
SCENARIOS: tuple[Scenario, ...] = (
    ColumnImpact("impact", COLUMN, Striker(1500.0, 12.0), 0.012),
    ColumnPushover("push", COLUMN, 0.4),
    MemberPulse("pulse", COLUMN, Pulse("friedlander", 1.5e6, 0.01), duration=0.008),
    FrameStatic("static", FRAME, PATTERN, "A1", "x", (0.15, -0.2)),
    FrameImpact("hit", FRAME, FrameStriker(1500.0, 15.0, node="A", direction="+x"), 0.006),
    FrameGroundMotion("shaken", FRAME, (0.0, -900.0, -900.0, -900.0, 300.0), 0.004, "A1", "x"),
    FramePulse(
        "blast", FRAME, Pulse("friedlander", 1e6, 0.01), "A", "+x", PATTERN, ("A0-A",), 0.006
    ),
)
VALUES = {
    "column.section": ["HEB 200"],
    "column.axial_load": [8e5],
    "column.squash_load": [2.6e6],
    "member.squash_load": [2.6e6],
    "member.section": ["HEB 200"],
    "steel.rate": ["S355"],
    "steel.hardening_modulus": [5e9],
    "striker.stiffness": [5e6],
    "striker.crush": [[[0.0, 0.0], [0.05, 5e5], [0.5, 2e6]]],
    "pattern.x": [2.0],
    "push.path": [[0.2], [0.3, -0.1]],
    "member.start": ["B0", "A"],
    "member.joint_start": ["pinned", "semi"],
    "member.joint_end": ["pinned", "semi"],
    "striker.node": ["A1"],
    "push.node": ["A"],
    "ground.node": ["A"],
    "pulse.node": ["A1"],
    "ground.acceleration": [[0.0, 200.0, 300.0]],
    "pulse.members": [["A-A1"], ["B0-B1"]],
    "ground.load_as_mass": [True],
}
# what no answer can depend on, or only through other inputs
WITHOUT_EFFECT = {
    "name": "a name",
    "steel.grade": "stands for the yield stress and the rate law beside it",
    "steel.thickness": "lowers the yield stress of a grade as it is read",
    "pulse.times": "of tables alone, which the force of a pulse reads for all models",
    "pulse.factors": "likewise",
    "node.name": "a name, by which other inputs call the node",
    "member.name": "a name",
    "joint.name": "a name, by which members call the joint",
    "load.node": "a name of a node",
    "pattern.node": "a name of a node",
    "gravity": "refused across a horizontal load; tested where members lie",
    "frame.gravity": "follows gravity of the scenario",
    "member.start": "a name of a node",
    "member.end": "a name of a node",
}
KNOWN = {  # of one model and kind
    ("seven-dof", "column-impact"): {"column.unbraced_length"},  # of heavier loads
    ("biggs", "column-pushover"): {"column.area"},  # gives its mass, and statics have none
    # matters through gravity alone, of which a finding says that it is not used
    ("en-1991-hard-impact", "column-impact"): {"striker.direction"},
}
OPTIONS = {
    "solid-plane-stress": {"refinement": -1, "levels": 1},
    "shell": {"refinement": -1, "levels": 1},
    "soft-impact": {"striker_stiffness": 1e7},  # so that the column yields
}
FIBERS = {"smallest_element": 0.4, "largest_element": 0.8, "levels": 1, "layers": 6}
BARE = replace(FRAME.nodes[1], mass=0.0, rotary_inertia=0.0)
SPECIAL = {  # scenarios of models that refuse the usual one, or are not moved enough by it
    # a column has masses at its head only
    ("column-of-frame", "frame-impact"): replace(
        SCENARIOS[4], frame=replace(FRAME, nodes=(FRAME.nodes[0], BARE, *FRAME.nodes[2:]))
    ),
    # supports about the other axis and friction count between both
    ("seven-dof", "column-impact"): replace(
        SCENARIOS[0], striker=Striker(1500.0, 12.0, angle=0.6, friction=0.1)
    ),
    # the restraint counts beyond the plateau
    ("trilinear-catenary", "member-pulse"): replace(
        SCENARIOS[2], pulse=Pulse("friedlander", 3e6, 0.01)
    ),
}
SLOW = ("solid-plane-stress", "shell", "modified-tangent-modulus")
NO_STRUCTURE = ("stud-", "impact-", *("published", "measured", "imported", "remote", "opensees"))

MODELS = [name for name in model_names() if not name.startswith(NO_STRUCTURE)]


def coarse(name: str) -> Model:
    kind, options = model_kind(name), dict(OPTIONS.get(name, {}))
    if name.startswith("fiber-") and "levels" in {field.name for field in fields(kind)}:
        options |= FIBERS
    if issubclass(kind, FrameModel):
        options["time_step"] = 2e-4
    return make_model(name, options)


@pytest.fixture
def few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frame_model, "PUSH_STEPS", 20)
    monkeypatch.setattr(frame_model, "PERIOD_STEPS", 10.0)


def pairs() -> Iterator[Any]:
    """All models with the scenarios that they answer.

    Models of frames answer a column as the frame of its members: one of them, the anchor, shows
    all kinds at once, the others a push, and the rest on demand, as all of the solid.
    """
    for name in MODELS:
        of_frames = issubclass(model_kind(name), FrameModel) and name != "flexible-superelement"
        for usual in SCENARIOS:
            if usual.KIND in coarse(name).answers:
                scenario = SPECIAL.get((name, usual.KIND), usual)
                is_long = of_frames and usual.KIND != ColumnPushover.KIND
                marks = [pytest.mark.slow] if is_long or name in SLOW else []
                yield pytest.param(name, scenario, id=f"{name}-{usual.KIND}", marks=marks)


@pytest.mark.thorough
@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize(("name", "scenario"), list(pairs()))
def test_all_inputs_are_used_or_said_not_to_be(name: str, scenario: Scenario) -> None:
    model = coarse(name)
    assert model.simulate(scenario).data_vars, f"{name} refuses {scenario.KIND}"
    known = {*WITHOUT_EFFECT, *KNOWN.get((name, scenario.KIND), ())}
    assert not set(ignored_inputs(model, scenario, VALUES)) - known


@pytest.mark.thorough
@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda scenario: scenario.KIND)
def test_all_inputs_of_a_scenario_are_varied(scenario: Scenario) -> None:
    varied = {each.path for each, _ in with_other_inputs(scenario, VALUES)}
    assert {each.path for each in inputs_of(scenario)} <= varied | set(WITHOUT_EFFECT)


def unused(response) -> list[str]:
    return [f.text for f in findings_of(response) if f.subject == "unused-input"]


def test_inputs_that_are_set_are_known_by_their_paths(thesis_impact) -> None:
    frame = frame_scenario(thesis_impact)
    first, *others = frame.frame.nodes
    nodes = (replace(first, rotary_inertia=3.0), *others)
    frame = replace(frame, frame=replace(frame.frame, nodes=nodes))
    inputs = set_inputs(frame)
    assert str(inputs["node.rotary_inertia"]) == "node.base.rotary_inertia = 3 kg m2"
    assert "node.mass" not in inputs
    assert "node.x" not in inputs  # it has no default
    assert "steel.yield_stress" not in inputs or frame.frame.steel.yield_stress != 355e6


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("name", ["energy-estimate", "hand-estimate"])
def test_energies_say_that_they_do_not_know_a_restitution(
    thesis_impact, name: str, restitution: float
) -> None:
    striker = replace(thesis_impact.striker, restitution=restitution, velocity=5.0)
    scenario = replace(thesis_impact, striker=striker)
    texts = unused(make_model(name).simulate(scenario))
    says = any("striker.restitution = 0.5 is not used" in text for text in texts)
    assert says == (restitution == 0.5)


def test_a_model_that_uses_the_input_is_named(thesis_impact) -> None:
    column = replace(thesis_impact.column, head_mass=500.0)
    scenario = replace(thesis_impact.at_velocity(5.0), column=column)
    model = make_model("single-dof")
    response = advised(model, scenario, model.simulate(scenario))
    (finding,) = [f for f in findings_of(response) if f.subject == "unused-input"]
    assert finding.text.startswith("column.head_mass = 500 kg is not used by this model")
    assert finding.remedy == "take flexible-superelement"
    assert any("column.head_mass" in doubt for doubt in doubts("single-dof", scenario))


# -- a mass at the impact point
# --------------------------------------------------------------------- one mass on 48 EI / L^3:
# under an impulse I the peak is I / (k m)^1/2, after a hit that of the joined masses; the member
# adds 17/35 of its mass, and its webs deform by some percent

SPREAD = ("flexible-superelement", "rigid-superelement", "giberson")
BEAM = Column(find("HEB 180"), 2.5, 2.5, base="pinned", head="pinned", impact_mass=3000.0)


def stiffness_and_mass(column: Column) -> tuple[float, float]:
    p = column.properties
    own = p.mass_per_length * column.length
    stiffness = 48.0 * column.steel.elastic_modulus * p.second_moment / column.length**3
    return stiffness, column.attached_mass + 17.0 / 35.0 * own


def without_interval(scenario: Scenario, name: str) -> float:
    """The peak of a model, of which no interval is told."""
    model = make_model(name)
    response = advised(model, scenario, model.simulate(scenario))
    error = json.loads(response.attrs["error"])
    assert error["low"] is None
    assert error["reason"] == "errors were measured without a mass attached at the impact point"
    assert not any(f.subject in ("error", "unused-input") for f in findings_of(response))
    return float(response["peak_displacement"])


@pytest.mark.parametrize("name", [*SPREAD, "biggs", "single-dof"])
def test_an_impact_mass_moves_under_a_pulse(name: str) -> None:
    pulse = Pulse("rectangular", 2e5, 0.004)
    stiffness, mass = stiffness_and_mass(BEAM)
    scenario = MemberPulse("heavy", BEAM, pulse, duration=0.1)  # a quarter of a period is 0.05 s
    peak = pulse.whole / sqrt(stiffness * mass)
    assert without_interval(scenario, name) == pytest.approx(peak, rel=0.07)


@pytest.mark.parametrize("name", [*SPREAD, "biggs", "single-dof", "four-dof"])
def test_an_impact_mass_is_joined_by_a_striker(name: str) -> None:
    striker = Striker(300.0, 1.0)
    stiffness, mass = stiffness_and_mass(BEAM)
    scenario = ColumnImpact("joined", BEAM, striker, 0.1)
    peak = striker.mass * striker.velocity / sqrt(stiffness * (striker.mass + mass))
    assert without_interval(scenario, name) == pytest.approx(peak, rel=0.07)


def test_dynamic_reactions_carry_no_force_of_the_attached_mass() -> None:
    # a heavy mass moves slowly: the reactions are half of the spring's force each, not of the load
    pulse = Pulse("rectangular", 2e5, 0.004)
    scenario = MemberPulse("heavy", replace(BEAM, impact_mass=3e4), pulse, duration=0.15)
    response = make_model("biggs").simulate(scenario)
    reactions, force = response["reaction"].values, response["force"].values
    assert abs(reactions.sum(axis=0) - force).max() < 0.02 * pulse.peak


@pytest.mark.parametrize("name", ["flexible-superelement", "biggs"])
def test_an_impact_mass_lighter_than_the_column_is_not_used_where_mass_is_spread(name) -> None:
    own = BEAM.properties.mass_per_length * BEAM.length / 3.0
    pulse = Pulse("rectangular", 2e5, 0.004)
    light, plain = (
        MemberPulse("light", replace(BEAM, impact_mass=mass), pulse, duration=0.05)
        for mass in (0.5 * own, None)
    )
    answers = [make_model(name).simulate(each) for each in (light, plain)]
    assert float(answers[0]["peak_displacement"]) == float(answers[1]["peak_displacement"])
    assert any("column.impact_mass" in text for text in unused(answers[0]))
    assert not unused(answers[1])


def test_a_frame_is_not_told_an_interval_with_a_mass_at_the_hit_point(thesis_impact) -> None:
    column = replace(thesis_impact.column, impact_mass=500.0)
    frame = frame_scenario(replace(thesis_impact, column=column))
    (hit,) = [node for node in frame.frame.nodes if node.name == "hit"]
    assert hit.mass == pytest.approx(column.attached_mass)
    assert truth_ratio(frame).reason.startswith("errors were measured without a mass")
