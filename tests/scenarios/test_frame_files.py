"""Frame scenario files: round trips, both forms, overrides, and messages that name the key."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st

from workbench.base.datafiles import data_directory
from workbench.base.errors import InputError
from workbench.cli import run
from workbench.models.base import make_model, model_names
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import (
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameStatic,
    FrameStriker,
    Joint,
    Load,
    cyclic_path,
    load_scenario,
    regular_frame,
    scenario_from,
    scenario_hash,
    to_toml,
)
from workbench.steel.sections import find, square

REGULAR = """
kind = "frame-impact"
name = "portal"
[frame]
bays = [6.0]
storeys = [4.0]
column = "HEB 220"
beam = { side = 0.2 }
base = "pinned"
beam_joint = "soft"
fillets = false
[[split]]
member = "A0-A1"
at = 0.8
node = "hit"
[[joint]]
name = "soft"
rotational_stiffness = 2e6
[[load]]
node = "A1"
y = -1e5
[striker]
mass = 1500
velocity = 15
node = "hit"
"""
EXPLICIT = """
kind = "frame-impact"
name = "portal"
node = [
    { name = "A0", x = 0, y = 0, support = "pinned" },
    { name = "B0", x = 6, y = 0, support = "pinned" },
    { name = "A1", x = 0, y = 4 },
    { name = "B1", x = 6, y = 4 },
    { name = "hit", x = 0, y = 0.8 },
]
member = [
    { name = "A0-A1/1", start = "A0", end = "hit", section = "HEB 220" },
    { name = "A0-A1/2", start = "hit", end = "A1", section = "HEB 220" },
    { name = "B0-B1", start = "B0", end = "B1", section = "HEB 220" },
    { name = "A1-B1", start = "A1", end = "B1", section = { height = 0.2, width = 0.2 }, JOINTS },
]
joint = [{ name = "soft", rotational_stiffness = 2e6 }]
load = [{ node = "A1", y = -1e5 }]
[frame]
fillets = false
[striker]
mass = 1500
velocity = 15
node = "hit"
""".replace("JOINTS", 'joint_start = "soft", joint_end = "soft"')
STATIC = (
    EXPLICIT.partition("[striker]")[0].replace("frame-impact", "frame-static")
    + """
[[pattern]]
node = "A1"
x = 1e3
[push]
node = "A1"
direction = "x"
path = 0.2
"""
)
GROUND = (
    EXPLICIT.partition("[striker]")[0].replace("frame-impact", "frame-ground-motion")
    + """
[ground]
acceleration = [0, 3, -3, 0]
time_step = 0.02
node = "A1"
damping = 0.1
[time]
duration = 1.5
"""
)


def read(text: str, *overrides: str, folder: Path) -> object:
    path = folder / "scenario.toml"
    path.write_text(text)
    return load_scenario(path, overrides)


def test_both_forms_say_the_same(tmp_path: Path) -> None:
    regular, explicit = read(REGULAR, folder=tmp_path), read(EXPLICIT, folder=tmp_path)
    assert regular == explicit
    assert to_toml(regular) == to_toml(explicit)
    soft = Joint("soft", rotational_stiffness=2e6)
    sections = find("HEB 220"), square(0.2)
    frame = regular_frame((6.0,), (4.0,), *sections, "pinned", fillets=False, beam_joint=soft)
    frame = frame.split("A0-A1", 0.8, "hit")
    frame = replace(frame, loads=(Load("A1", y=-1e5),))
    assert regular == FrameImpact("portal", frame, FrameStriker(1500.0, 15.0, node="hit"))


def test_other_kinds_are_read(tmp_path: Path) -> None:
    push, shake = read(STATIC, folder=tmp_path), read(GROUND, folder=tmp_path)
    assert isinstance(push, FrameStatic)
    assert (push.loads, push.path, push.control) == ((Load("A1", x=1e3),), (0.2,), "displacement")
    assert isinstance(shake, FrameGroundMotion)
    assert shake.acceleration == (0.0, 3.0, -3.0, 0.0)
    assert (shake.direction, shake.damping, shake.duration) == ("x", 0.1, 1.5)


def test_the_thesis_frame_is_that_of_the_figure() -> None:
    impact = load_scenario(data_directory() / "published" / "heng2017_frame.toml")
    assert isinstance(impact, FrameImpact)
    frame = impact.frame
    assert (len(frame.nodes), len(frame.members)) == (16, 19)
    assert sum(frame.length(member) for member in frame.members) == pytest.approx(64.0)
    hit = frame.node(impact.striker.node)
    assert (hit.x, hit.y) == (6.0, pytest.approx(0.8))
    assert impact.input_energy == 0.5 * 1500.0 * 50.0**2
    assert frame.properties("A0-A1").plastic_moment == pytest.approx(710e3)
    assert frame.properties("A0-A1").squash_load == pytest.approx(14.2e6)


def test_the_example_of_the_user_guide_can_be_read() -> None:
    guide = Path(__file__).resolve().parents[2] / "docs" / "guide" / "frames.md"
    example = guide.read_text(encoding="utf-8").partition("scenario files](../reference")[2]
    lines = example.partition("The regular form names")[0].splitlines()
    text = "\n".join(line[4:] for line in lines if line.startswith("    ") or not line)
    scenario = scenario_from(tomllib.loads(text))
    assert isinstance(scenario, FrameImpact)
    assert scenario.frame.node(scenario.striker.node).y == pytest.approx(0.8)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    length = st.floats(2.0, 9.0)
    sections = st.sampled_from([find("IPE 300"), find("HEM 200"), square(0.15)])
    frame = regular_frame(
        draw(st.lists(length, min_size=1, max_size=4)),
        draw(st.lists(length, min_size=1, max_size=4)),
        draw(sections),
        draw(sections),
        draw(st.sampled_from(["clamped", "pinned"])),
        fillets=draw(st.booleans()),
    )
    strength = st.one_of(st.none(), st.floats(1.0, 1e6))
    joint = Joint(
        "end plate", draw(st.floats(1.0, 1e9)), None, draw(strength), draw(strength), None, 1e6
    )
    kinds = st.sampled_from(["rigid", "pinned", "end plate"])
    beam = frame.member("A1-B1")
    jointed = replace(
        beam,
        joint_start=draw(kinds),
        joint_end=draw(kinds),
        area=draw(st.sampled_from([None, 0.01])),
    )
    members = tuple(jointed if m is beam else m for m in frame.members)
    frame = replace(frame, members=members, joints=(joint,))
    for number in range(draw(st.integers(0, 3))):
        member = draw(st.sampled_from(frame.members))
        share = draw(st.floats(0.3, 0.7))
        frame = frame.split(member, share * frame.length(member), f"split {number}")
    nodes = list(frame.nodes)
    chosen = draw(st.integers(0, len(nodes) - 1))
    if not nodes[chosen].held:
        nodes[chosen] = replace(
            nodes[chosen],
            mass=draw(st.floats(0.0, 1e4)),
            spring_x=draw(st.floats(0.0, 1e6)),
            locked=draw(st.sampled_from(["none", "y"])),
        )
    force = st.floats(-1e5, 1e5)
    names = st.sampled_from([node.name for node in nodes])
    loads = draw(st.lists(st.builds(Load, names, force, force, force), max_size=3))
    return replace(frame, nodes=tuple(nodes), loads=tuple(loads))


@st.composite
def scenarios(draw: st.DrawFn) -> FrameStatic | FrameImpact | FrameGroundMotion:
    frame = draw(frames())
    node = draw(st.sampled_from([n.name for n in frame.nodes if not n.held and n.locked == "none"]))
    kind = draw(st.integers(0, 2))
    if kind == 0:
        direction = draw(st.sampled_from(["+x", "-x", "+y", "-y"]))
        striker = FrameStriker(
            draw(st.floats(1.0, 1e4)), draw(st.floats(0.1, 50.0)), node=node, direction=direction
        )
        return FrameImpact("hit", frame, striker, draw(st.floats(1e-3, 1.0)))
    if kind == 1:
        path = draw(st.sampled_from([(0.1,), cyclic_path([0.01, 0.02], 2), (0.3, 0.1)]))
        control = draw(st.sampled_from(["displacement", "load"]))
        direction = draw(st.sampled_from(["x", "-y", "rotation"]))
        loads = (Load(node, draw(st.floats(1.0, 1e5)), 0.0, draw(st.floats(-1.0, 1.0))),)
        return FrameStatic("push", frame, loads, node, direction, path, control)
    record = draw(st.lists(st.floats(0.1, 10.0), min_size=2, max_size=20))
    damping = draw(st.floats(0.0, 1.0))
    return FrameGroundMotion("shake", frame, tuple(record), 0.01, node, "y", damping=damping)


@examples(80)
@given(scenarios())
def test_canonical_toml_reads_back_as_an_equal_scenario(scenario) -> None:
    again = scenario_from(tomllib.loads(to_toml(scenario)))
    assert again == scenario
    assert to_toml(again) == to_toml(scenario)
    assert scenario_hash(again) == scenario_hash(scenario)
    assert all(
        again.frame.properties(m) == scenario.frame.properties(m) for m in scenario.frame.members
    )


def test_hash_ignores_the_name_and_sees_everything_else(tmp_path: Path) -> None:
    impact = read(REGULAR, folder=tmp_path)
    frame = impact.frame
    same = replace(impact, name="other")
    assert scenario_hash(same) == scenario_hash(impact)
    others = [
        impact.at_velocity(15.000001),
        replace(impact, striker=replace(impact.striker, direction="-x")),
        replace(impact, frame=replace(frame, fillets=True)),
        replace(impact, frame=replace(frame, loads=())),
        replace(impact, frame=replace(frame, members=frame.members[::-1])),
        replace(impact, frame=replace(frame, nodes=frame.nodes[::-1])),
        replace(impact, duration=0.2),
    ]
    assert len({scenario_hash(s) for s in (impact, *others)}) == 1 + len(others)


def test_overrides_reach_tables_and_entries(tmp_path: Path) -> None:
    overrides = [
        *("striker.velocity=40", "steel.yield_stress=235e6", "frame.base=clamped"),
        *("split.hit.at=1.2", "joint.soft.rotational_stiffness=3e6", "load.0.y=-2e5"),
        *("load.A1.x=5", "frame.storeys=[5]"),
    ]
    impact = read(REGULAR, *overrides, folder=tmp_path)
    assert impact.striker.velocity == 40.0
    assert impact.frame.steel.yield_stress == 235e6
    assert impact.frame.node("B0").support == "clamped"
    assert impact.frame.node("hit").y == pytest.approx(1.2)
    assert impact.frame.joint("soft").rotational_stiffness == 3e6
    assert impact.frame.loads == (Load("A1", 5.0, -2e5),)
    assert impact.frame.node("A1").y == 5.0
    explicit = read(EXPLICIT, "member.B0-B1.section=IPE 300", "node.B1.mass=100", folder=tmp_path)
    assert explicit.frame.member("B0-B1").section == find("IPE 300")
    assert explicit.frame.node("B1").mass == 100.0


BAD = [
    (REGULAR, "frame.bays=[]", "frame.bays", "1 to 100"),
    (REGULAR, "frame.bays=[6000]", "frame.bays.0", "metres, not millimetres"),
    (REGULAR, "frame.bay=[6]", "frame.bay", "did you mean bays"),
    (REGULAR, "frame.column='HEB 225'", "frame.column", "HEB 220"),
    (REGULAR, "frame.fillets=1", "frame.fillets", "true or false"),
    (REGULAR, "split.hit.at=5", "split.at", "0.02 to 3.98 m"),
    (REGULAR, "split.hit.member=A0-B1", "split.member", "did you mean"),
    (REGULAR, "split.hit.to=1", "split.hit.to", "known are member, at, node"),
    (REGULAR, "striker.node=A0", "striker.direction", "its support pinned holds it"),
    (REGULAR, "striker.node=C1", "striker.node", "no node of this name"),
    (REGULAR, "striker.mass=-1", "striker.mass", "from 0.001"),
    (REGULAR, "load.A1.z=1", "load.A1.z", "unknown key"),
    (REGULAR, "load.A1.y=heavy", "load.A1.y", "must be a number"),
    (REGULAR, "column.section=HEB 220", "column", "unknown key"),
    (REGULAR, "time.duration=100", "time.duration", "in seconds"),
    (REGULAR, "node=3", "node", "cannot stand beside bays"),
    (EXPLICIT, "node.A1.x=wide", "node.A1.x", "must be a number"),
    (EXPLICIT, "node.A1.colour=red", "node.A1.colour", "unknown key"),
    (EXPLICIT, "node.A0.support=glued", "node.A0.support", "clamped, pinned"),
    (EXPLICIT, "member.A1-B1.section='HEB 225'", "member.A1-B1.section", "HEB 220"),
    (EXPLICIT, "member.A1-B1.end=Z9", "member.A1-B1.end", "no node of this name"),
    (EXPLICIT, "member.A1-B1.joint_end=welded", "member.A1-B1.joint_end", "rigid, pinned, soft"),
    (EXPLICIT, "member=3", "member", "must be tables [[member]]"),
    (EXPLICIT, "frame=3", "frame", "must be a table [frame]"),
    (EXPLICIT, "frame.base=pinned", "node", "cannot stand beside base"),
    (EXPLICIT, "frame.steel=1", "frame.steel", "unknown key"),
    (STATIC, "push.path=[]", "push.path", "list of 1"),
    (STATIC, "push.path=20", "push.path.0", "twice the frame"),
    (STATIC, "push.path=[0.1, 0.1]", "push.path.1", "differ"),
    (STATIC, "push.node=A0", "push.direction", "cannot move"),
    (STATIC, "push.speed=1", "push.speed", "unknown key"),
    (STATIC, "pattern.A1.x=0", "pattern", "no load acts"),
    (STATIC, "pattern.A1.x=1e12", "pattern.A1.x", "1e+09 N"),
    (STATIC, "striker.mass=1", "striker", "unknown key"),
    (GROUND, "ground.acceleration=9.81", "ground.acceleration", "list of 2"),
    (GROUND, "ground.acceleration=[0, 1e6]", "ground.acceleration.1", "0.3 g is 2.94"),
    (GROUND, "ground.mass=1", "ground.mass", "unknown key"),
]


@pytest.mark.parametrize(("text", "override", "field", "words"), BAD, ids=lambda v: str(v)[:30])
def test_bad_values_name_field_and_remedy(tmp_path, text, override, field, words) -> None:
    with pytest.raises(InputError) as caught:
        read(text, override, folder=tmp_path)
    assert caught.value.field == field
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("node.Z9.x=1", "no entry is called Z9"),
        ("node.9.x=1", "no entry is called 9"),
        ("node.A1=1", "node.A1 is an entry"),
        ("node.A1.x.y=1", "x is a value"),
        ("striker.mass.unit=kg", "mass is a value"),
    ],
)
def test_overrides_that_lead_nowhere_are_refused(tmp_path: Path, override, words) -> None:
    with pytest.raises(InputError, match=words) as caught:
        read(EXPLICIT, override, folder=tmp_path)
    assert caught.value.field == "--set"


def test_an_ambiguous_entry_is_refused(tmp_path: Path) -> None:
    twice = EXPLICIT.replace("load = [", 'load = [{ node = "A1", x = 2 }, ')
    with pytest.raises(InputError, match="several entries are called A1"):
        read(twice, "load.A1.x=1", folder=tmp_path)
    assert read(twice, "load.1.x=1", folder=tmp_path).frame.loads[1] == Load("A1", 1.0, -1e5)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (EXPLICIT.replace("node = [", "knot = ["), "knot"),
        (REGULAR.replace("bays = [6.0]\n", ""), "frame.bays: is missing"),
        (REGULAR.replace("at = 0.8\n", ""), "split.hit.at: is missing"),
        (REGULAR.replace('15\nnode = "hit"', "15"), "striker.node: is missing"),
        (REGULAR.partition("[striker]")[0], "[striker] is missing"),
        (EXPLICIT.replace("x = 6, y = 4", "x = 6"), "node.B1.y: is missing"),
        (EXPLICIT.replace('name = "A1", x', "x"), "node.2.name: is missing"),
        (EXPLICIT.replace('start = "A1", ', ""), "member.A1-B1.start: is missing"),
        (STATIC.partition("[push]")[0], "[push] is missing"),
        (STATIC.partition("[[pattern]]")[0], "[[pattern]] are missing"),
        (STATIC.replace('[[pattern]]\nnode = "A1"\nx = 1e3', ""), "[[pattern]] are missing"),
        (EXPLICIT.partition("member = [")[0], "[[member]] are missing"),
        (STATIC.replace("path = 0.2\n", ""), "push.path: is missing"),
        (STATIC.replace("[[pattern]]", "[pattern]"), "must be tables [[pattern]]"),
        (GROUND.replace("time_step = 0.02\n", ""), "ground.time_step: is missing"),
        ('kind = "frame-impact"\n', "the tables [[node]] are missing"),
        ('kind = "frame-crash"\n', "frame-static, frame-impact, frame-ground-motion"),
    ],
    ids=lambda v: str(v)[-30:],
)
def test_broken_files_are_refused(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        read(text, folder=tmp_path)
    assert words in str(caught.value)


def test_canonical_tables_are_explicit_and_leave_out_defaults(tmp_path: Path) -> None:
    tables = tomllib.loads(to_toml(read(REGULAR, folder=tmp_path)))
    assert set(tables) == {
        *("kind", "name", "frame", "steel", "node", "joint", "member", "load", "striker", "time")
    }
    assert tables["frame"] == {"fillets": False}
    assert tables["node"][0] == {"name": "A0", "x": 0.0, "y": 0.0, "support": "pinned"}
    assert tables["member"][0] == {
        **{"name": "A0-A1/1", "start": "A0", "end": "hit", "section": "HEB 220"}
    }
    assert tables["time"] == {"duration": 0.1}


def test_column_models_decline_frames_at_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "frame.toml"
    path.write_text(REGULAR)
    command = ["simulate", str(path), "--model", "four-dof"]
    assert run(command) == 1
    captured = capsys.readouterr()
    assert captured.err == ""
    assert "four-dof answers column-impact, column-pushover, not frame-impact" in captured.out
    assert run([*command, "--set", "striker.node=Z9"]) == 2
    errors = capsys.readouterr().err
    assert errors.startswith("workbench: striker.node = 'Z9': there is no node of this name")
    assert "Traceback" not in errors


def test_every_model_of_columns_alone_declines_every_kind_of_frame(tmp_path: Path) -> None:
    given = [read(text, folder=tmp_path) for text in (REGULAR, STATIC, GROUND)]
    declined = 0
    for name in model_names():
        if name == "published":
            continue  # answers what its series was published for, and has no default one
        model = make_model(name, {})
        for scenario in given:
            if scenario.KIND in model.answers:
                continue
            response = model.simulate(scenario)
            assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
            assert f"not {scenario.KIND}" in response.attrs["message"]
            assert response.attrs["scenario_hash"] == scenario_hash(scenario)
            assert scenario_from(tomllib.loads(response.attrs["scenario"])) == scenario
            declined += 1
    assert declined >= 9
