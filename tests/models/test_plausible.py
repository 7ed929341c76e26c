"""Numbers that look like those of another unit: a warning by every model, no refusal."""

from dataclasses import replace

import pytest
from builders import portal

from workbench.models.domain import implausible
from workbench.models.four_dof import FourDof
from workbench.models.single_dof import SingleDof
from workbench.responses import Outcome, outcome_of, warnings_of
from workbench.scenarios import (
    ColumnImpact,
    FrameGroundMotion,
    FrameImpact,
    FrameStriker,
    Load,
    MemberPulse,
    Node,
    Pulse,
)
from workbench.scenarios.parts import GRAVITY


def texts(scenario) -> str:
    return "; ".join(map(str, implausible(scenario)))


@pytest.mark.parametrize(
    ("part", "changes", "message"),
    [
        ("column", {"axial_load": 500.0}, "column.axial_load = 500 N is small"),
        ("column", {"head_mass": 0.6}, "column.head_mass = 0.6 kg is small"),
        ("striker", {"mass": 1.5}, "if it is meant in t"),
        ("striker", {"velocity": 80.0}, "striker.velocity = 80 m/s is 288 km/h"),
    ],
)
def test_another_unit_is_suspected_of_columns(
    thesis_impact: ColumnImpact, part, changes, message
) -> None:
    assert texts(thesis_impact) == ""
    odd = replace(thesis_impact, **{part: replace(getattr(thesis_impact, part), **changes)})
    assert message in texts(odd)
    for model in (FourDof(), SingleDof()):
        response = model.simulate(odd)
        assert outcome_of(response) in (Outcome.OK, Outcome.COLLAPSE)
        assert "plausibility" in {finding.subject for finding in warnings_of(response)}


def test_another_unit_is_suspected_of_pulses_and_frames(thesis_impact: ColumnImpact) -> None:
    pulse = Pulse("triangular", 500.0, 0.01)
    member = MemberPulse("blast", thesis_impact.column, pulse)
    assert "force of the pulse = 500" in texts(member)
    assert texts(replace(member, pulse=replace(pulse, peak=5e5))) == ""
    frame = portal()
    node = next(node.name for node in frame.nodes if node.support == "free")
    hit = FrameImpact("hit", frame, FrameStriker(1500.0, 10.0, node=node))
    assert texts(hit) == ""
    odd = replace(frame, loads=(Load(node, y=-100.0),))
    assert "largest dead load = 100" in texts(replace(hit, frame=odd))


def test_dead_loads_without_mass_are_named_where_the_ground_moves() -> None:
    from workbench.models.superelements import RigidSuperelement

    frame = portal()
    tops = [node.name for node in frame.nodes if node.support == "free"]
    loaded = replace(frame, loads=tuple(Load(name, y=-1e4 * GRAVITY) for name in tops))
    shaken = FrameGroundMotion("quake", loaded, (0.0, 3.0, -3.0, 0.0), 0.05, tops[0])
    model = RigidSuperelement()
    (findings,) = [f for f in model.domain(shaken) if f.subject == "mass"]
    assert f"{1e4 * len(tops):.3g} kg" in findings.text
    assert "load_as_mass = true" in findings.remedy
    given = tuple(
        replace(node, mass=1e4) if isinstance(node, Node) and node.name in tops else node
        for node in frame.nodes
    )
    by_hand = replace(shaken, frame=replace(loaded, nodes=given))
    by_load = replace(shaken, load_as_mass=True)
    for scenario in (by_hand, by_load):
        assert "mass" not in {finding.subject for finding in model.domain(scenario)}
    peaks = [
        float(abs(model.simulate(s)["displacement"]).max()) for s in (by_hand, by_load, shaken)
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-9)
    assert peaks[2] < 0.8 * peaks[0]
