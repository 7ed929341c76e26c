"""Frames as value objects: geometry, properties, supports, splits, and what is refused."""

from __future__ import annotations

import pickle
from dataclasses import replace
from itertools import pairwise
from math import hypot

import numpy as np
import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.scenarios import (
    Column,
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameStatic,
    FrameStriker,
    Joint,
    Load,
    Member,
    Node,
    cyclic_path,
    regular_frame,
)
from workbench.scenarios.parts import HELD
from workbench.steel.materials import Steel
from workbench.steel.sections import find, square

SECTION = find("HEB 220")


def portal(*supports: str, **keys) -> Frame:
    """Three nodes of an upside-down L, 4 m high and 3 m wide; supports at foot and tip."""
    foot, tip = supports or ("clamped", "free")
    nodes = (Node("foot", 0.0, 0.0, foot), Node("corner", 0.0, 4.0), Node("tip", 3.0, 4.0, tip))
    members = (
        Member("leg", "foot", "corner", SECTION),
        Member("arm", "corner", "tip", SECTION, joint_start="pinned" if tip != "free" else "rigid"),
    )
    return Frame(nodes, members, **keys)


def stiffness(frame: Frame) -> np.ndarray:
    """Elastic stiffness (free dofs, free dofs) of a frame of rigid joints, EA = EI = 1."""
    number = {node.name: i for i, node in enumerate(frame.nodes)}
    matrix = np.zeros((3 * len(number), 3 * len(number)))
    for member in frame.members:
        start, end = frame.node(member.start), frame.node(member.end)
        length = frame.length(member)
        c, s = (end.x - start.x) / length, (end.y - start.y) / length
        modes = np.array(
            [
                [-c, -s, 0.0, c, s, 0.0],
                [-s / length, c / length, 1.0, s / length, -c / length, 0.0],
                [-s / length, c / length, 0.0, s / length, -c / length, 1.0],
            ]
        )
        law = np.array([[1.0, 0.0, 0.0], [0.0, 4.0, 2.0], [0.0, 2.0, 4.0]]) / length
        dofs = [3 * number[n] + i for n in (member.start, member.end) for i in range(3)]
        matrix[np.ix_(dofs, dofs)] += modes.T @ law @ modes
    names = ("u", "v", "rotation")
    free = [
        3 * number[node.name] + i
        for node in frame.nodes
        for i in range(3)
        if names[i] not in node.held
    ]
    return matrix[np.ix_(free, free)]


def test_a_regular_frame_has_axes_and_levels() -> None:
    frame = regular_frame((3.0, 5.0), (4.0, 3.5), SECTION, square(0.2), base="pinned")
    assert [n.name for n in frame.nodes] == ["A0", "B0", "C0", "A1", "B1", "C1", "A2", "B2", "C2"]
    assert [m.name for m in frame.members] == [
        *("A0-A1", "A1-A2", "B0-B1", "B1-B2", "C0-C1", "C1-C2"),
        *("A1-B1", "B1-C1", "A2-B2", "B2-C2"),
    ]
    assert (frame.node("C2").x, frame.node("C2").y) == (8.0, 7.5)
    assert {n.support for n in frame.nodes if n.y == 0.0} == {"pinned"}
    assert {n.support for n in frame.nodes if n.y > 0.0} == {"free"}
    assert frame.member("B1-C1").section == square(0.2)
    assert frame.length("A1-A2") == 3.5
    many = regular_frame([3.0] * 27, [3.0], SECTION, SECTION)
    assert [n.name for n in many.nodes[24:28]] == ["Y0", "Z0", "AA0", "AB0"]


def test_the_thesis_frame_has_64_m_of_members() -> None:
    frame = regular_frame([3.0] * 4, [4.0, 4.0], square(0.2), square(0.2))
    assert sum(frame.length(m) for m in frame.members) == 64.0
    assert len(frame.members) == 18


@examples(40)
@given(
    st.sampled_from([find("IPE 300"), find("HEM 200"), square(0.15)]),
    st.booleans(),
    st.lists(st.one_of(st.none(), st.floats(1e-3, 1.0)), min_size=2, max_size=2),
    st.lists(st.one_of(st.none(), st.floats(10.0, 1e4)), min_size=3, max_size=3),
    st.floats(200e6, 700e6),
)
def test_properties_are_those_of_a_column(section, fillets, geometry, strengths, stress) -> None:
    names = ("area", "second_moment", "plastic_moment", "squash_load", "mass_per_length")
    given_values = dict(zip(names, (*geometry, *strengths), strict=True))
    steel = Steel(yield_stress=stress)
    column = Column(section, 1.2, 2.8, steel=steel, fillets=fillets, **given_values)
    nodes = (Node("a", 1.0, 2.0, "clamped"), Node("b", 1.0, 6.0))
    frame = Frame(
        nodes, (Member("m", "a", "b", section, **given_values),), steel=steel, fillets=fillets
    )
    assert frame.properties("m") == column.properties
    assert frame.properties(frame.member("m")) == column.properties
    assert frame.strength_section("m") == column.strength_section


@examples(60)
@given(st.data())
def test_supports_are_refused_exactly_where_the_stiffness_is_singular(data) -> None:
    supports = [data.draw(st.sampled_from(list(HELD))) for _ in range(3)]
    places = data.draw(
        st.sampled_from(
            [((0, 0), (0, 4), (3, 4)), ((0, 0), (2, 0), (5, 0)), ((0, 0), (2, 2), (4, 0))]
        )
    )
    turned = data.draw(st.floats(0.0, 6.28))
    if data.draw(st.booleans()):
        turned = 0.0
    c, s = np.cos(turned), np.sin(turned)
    free = [Node(f"n{i}", c * x - s * y, s * x + c * y) for i, (x, y) in enumerate(places)]
    members = (Member("m0", "n0", "n1", SECTION), Member("m1", "n1", "n2", SECTION))
    clamped = Frame((replace(free[0], support="clamped"), *free[1:]), members)
    nodes = tuple(replace(n, support=s) for n, s in zip(free, supports, strict=True))
    bare = object.__new__(Frame)  # the same frame without the checks
    bare.__dict__.update({**clamped.__dict__, "nodes": nodes})
    bare.__dict__.pop("_parts", None)
    matrix = stiffness(bare)
    least = np.linalg.eigvalsh(matrix).min() if len(matrix) else 1.0
    if least > 1e-9:
        assert Frame(nodes, members).nodes == nodes
    else:
        with pytest.raises(InputError, match="the frame is not supported"):
            Frame(nodes, members)


@pytest.mark.parametrize(
    ("supports", "words"),
    [
        (("free", "free"), "nothing holds it"),
        (("pinned", "free"), "turn about x = 0 m, y = 0 m"),
        (("roller-x", "roller-x"), "slide along x"),
        (("guide-y", "free"), "slide along y"),
        (("roller-x", "roller-y"), "turn about x = 0 m, y = 4 m"),
    ],
)
def test_a_free_motion_is_named(supports, words) -> None:
    with pytest.raises(InputError, match=words) as caught:
        portal(*supports)
    assert caught.value.field == "node.support"


def test_springs_and_locks_support_only_without_dead_loads() -> None:
    for key, value in (("spring_rotation", 1e5), ("locked", "x")):
        nodes = portal("clamped", "free").nodes
        if key == "locked":
            nodes = (replace(nodes[0], support="pinned"), nodes[1], replace(nodes[2], locked="x"))
        else:
            nodes = (replace(nodes[0], support="pinned", spring_rotation=value), *nodes[1:])
        members = portal("clamped", "free").members
        assert Frame(nodes, members)
        with pytest.raises(InputError, match="under its dead loads, before springs and locks act"):
            Frame(nodes, members, (Load("tip", y=-1e3),))


def test_a_clamp_holds_nothing_through_a_pin() -> None:
    nodes = (Node("a", 0.0, 0.0, "clamped"), Node("b", 0.0, 3.0))
    pinned = Member("m", "a", "b", SECTION, joint_start="pinned")
    with pytest.raises(InputError, match="turn about x = 0 m, y = 0 m"):
        Frame(nodes, (pinned,))


@examples(40)
@given(st.floats(0.02, 4.98), st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
def test_a_split_keeps_the_member(at, x, y) -> None:
    nodes = (Node("a", x, y, "clamped"), Node("b", x + 3.0, y + 4.0))
    soft = Joint("soft", rotational_stiffness=1e6)
    whole = Member("m", "a", "b", SECTION, "soft", "pinned", plastic_moment=1e5)
    frame = Frame(nodes, (whole,), joints=(soft,)).split("m", at, "new")
    first, second = frame.members
    assert (first.name, first.start, first.end) == ("m/1", "a", "new")
    assert (second.name, second.start, second.end) == ("m/2", "new", "b")
    assert (first.joint_start, first.joint_end) == ("soft", "rigid")
    assert (second.joint_start, second.joint_end) == ("rigid", "pinned")
    assert first.plastic_moment == second.plastic_moment == 1e5
    assert frame.length("m/1") == pytest.approx(at, rel=1e-9)
    assert frame.length("m/1") + frame.length("m/2") == pytest.approx(5.0, rel=1e-12)
    new = frame.node("new")
    assert 3.0 * (new.y - y) == pytest.approx(4.0 * (new.x - x), abs=1e-11)


def test_splits_follow_each_other_and_keep_the_order() -> None:
    frame = portal().split("leg", 1.0, "p").split("leg/2", 1.0, "q")
    assert [m.name for m in frame.members] == ["leg/1", "leg/2/1", "leg/2/2", "arm"]
    assert [n.name for n in frame.nodes] == ["foot", "corner", "tip", "p", "q"]
    assert frame.node("q").y == 2.0


@pytest.mark.parametrize(
    ("arguments", "field", "words"),
    [
        (("leg", 4.0, "p"), "split.at", "from 0.02 to 3.98 m"),
        (("leg", 3.99, "p"), "split.at", "lie on member leg"),
        (("leg", 0.0, "p"), "split.at", "0.02"),
        (("leg", -1.0, "p"), "split.at", "0.02"),
        (("leg", 2000.0, "p"), "split.at", "metres, not millimetres"),
        (("leg", "1", "p"), "split.at", "must be a number"),
        (("log", 1.0, "p"), "split.member", "did you mean leg"),
        (("leg", 1.0, "tip"), "split.node", "name of a node already"),
    ],
)
def test_splits_off_the_member_are_refused(arguments, field, words) -> None:
    with pytest.raises(InputError, match=words) as caught:
        portal().split(*arguments)
    assert caught.value.field == field


def _static(**keys) -> FrameStatic:
    given_values = {
        **{"loads": (Load("tip", y=-1e3),), "node": "tip", "direction": "-y", "path": (0.1,)},
        **keys,
    }
    return FrameStatic("push", given_values.pop("frame", portal()), **given_values)


def _impact(frame: Frame | None = None, **keys) -> FrameImpact:
    striker = FrameStriker(100.0, 5.0, **{"node": "tip", "direction": "-y", **keys})
    return FrameImpact("hit", frame or portal(), striker)


def _shake(**keys) -> FrameGroundMotion:
    given_values = {"acceleration": (0.0, 1.0, 0.0), "time_step": 0.01, "node": "tip", **keys}
    return FrameGroundMotion("shake", given_values.pop("frame", portal()), **given_values)


def _with(node: int = 0, member: int = 0, **keys) -> Frame:
    frame = portal()
    nodes, members = list(frame.nodes), list(frame.members)
    names = {"name", "x", "y", "support", "locked", "mass", "spring_x"}
    if set(keys) <= names and member == 0:
        nodes[node] = replace(nodes[node], **keys)
    else:
        members[member - 1] = replace(members[member - 1], **keys)
    return Frame(tuple(nodes), tuple(members))


REFUSED = [
    (lambda: _with(node=1, name="foot"), "node.name", "given twice"),
    (lambda: _with(member=2, name="leg"), "member.name", "given twice"),
    (lambda: portal(joints=(Joint("j"), Joint("j"))), "joint.name", "given twice"),
    (lambda: portal(joints=(Joint("pinned"),)), "joint.name", "predefined"),
    (lambda: _with(node=0, name=" a"), "node.name", "space"),
    (lambda: _with(member=1, name="a:b"), "member.name", "colon"),
    (lambda: _with(member=2, end="top"), "member.arm.end", "no node of this name"),
    (lambda: _with(member=2, end="corner"), "member.arm.end", "another node than the start"),
    (lambda: _with(member=2, joint_end="weld"), "member.arm.joint_end", "known are rigid, pinned"),
    (lambda: _with(node=2, x=0.001), "member.arm", "0.001 m long"),
    (lambda: _with(node=2, x=3000.0), "member.arm", "metres, not millimetres"),
    (lambda: _with(node=2, x=1e6), "node.tip.x", "metres, not millimetres"),
    (lambda: _with(node=2, x=0.0, y=0.0), "node.tip", "lies where node foot lies"),
    (lambda: _with(member=2, start="foot", end="corner"), "member.arm", "same nodes as member leg"),
    (lambda: _with(node=0, support="fixed"), "node.foot.support", "clamped"),
    (lambda: _with(node=0, spring_x=1e3), "node.foot.spring_x", "already holds"),
    (lambda: _with(node=0, locked="x"), "node.foot.locked", "already holds"),
    (lambda: _with(node=0, mass=-1.0), "node.foot.mass", "from 0"),
    (
        lambda: Frame((*portal().nodes, Node("far", 9.0, 9.0)), portal().members),
        "node.far",
        "no member ends there",
    ),
    (
        lambda: Frame(
            (*portal().nodes, Node("p", 8.0, 0.0, "clamped"), Node("q", 8.0, 3.0)),
            (*portal().members, Member("post", "p", "q", SECTION)),
        ),
        "frame.members",
        "joins node p to node foot",
    ),
    (lambda: Frame(portal().nodes, ()), "frame.members", "1 or more"),
    (lambda: Frame(portal().nodes, (1,)), "frame.members.0", "must be a Member"),
    (lambda: Frame(portal().nodes, portal().members[0]), "frame.members", "must be a list"),
    (lambda: portal(loads=(Load("tap", y=1.0),)), "load.tap.node", "did you mean tip"),
    (lambda: Load("tip", y=5e9), "load.tip.y", "1e+09 N"),
    (
        lambda: Joint("j", rotational_stiffness=0.0, plastic_moment=1e3),
        "joint.j.plastic_moment",
        "a pin carries no moment",
    ),
    (lambda: _impact(node="tap"), "striker.node", "did you mean tip"),
    (lambda: _impact(node="foot"), "striker.direction", "its support clamped holds it"),
    (lambda: _impact(direction="y"), "striker.direction", "+x, -x, +y, -y"),
    (lambda: _impact(_with(node=2, locked="y")), "striker.direction", "its lock holds it"),
    (lambda: _static(node="foot"), "push.direction", "node foot cannot move there"),
    (lambda: _static(node="nowhere"), "push.node", "known are foot, corner, tip"),
    (lambda: _static(direction="up"), "push.direction", "-rotation"),
    (lambda: _static(loads=()), "pattern", "1 or more"),
    (lambda: _static(loads=(Load("foot", y=1.0),)), "pattern", "no load acts"),
    (lambda: _static(loads=(Load("tip"),)), "pattern", "no load acts"),
    (lambda: _static(loads=(Load("tap", y=1.0),)), "pattern.tap.node", "did you mean tip"),
    (lambda: _static(path=()), "push.path", "list of 1"),
    (lambda: _static(path=0.1), "push.path", "list of 1"),
    (lambda: _static(path=(0.0,)), "push.path.0", "differ from the one before"),
    (lambda: _static(path=(0.1, 0.1)), "push.path.1", "differ from the one before"),
    (lambda: _static(path=(0.1, np.nan)), "push.path.1", "finite"),
    (lambda: _static(path=(100.0,)), "push.path.0", "twice the frame, 10 m"),
    (
        lambda: _static(path=(30.0,), direction="rotation"),
        "push.path.0",
        "rotations up to 20 rad",
    ),
    (lambda: _static(path=(0.1, -0.1), control="arc-length"), "push.path", "one displacement"),
    (lambda: _static(control="force"), "push.control", "displacement, load, arc-length"),
    (lambda: _shake(acceleration=(0.0, 0.0)), "ground.acceleration", "must reach 1e-06 m/s2"),
    (lambda: _shake(acceleration=(1.0,)), "ground.acceleration", "2 to 200000"),
    (lambda: _shake(acceleration=(1.0, 1e4)), "ground.acceleration.1", "0.3 g is 2.94"),
    (lambda: _shake(time_step=20.0), "ground.time_step", "in seconds"),
    (lambda: _shake(node="foot"), "ground.direction", "cannot move"),
    (lambda: _shake(damping=-1.0), "ground.damping", "from 0"),
    (lambda: _shake(duration=0.0), "time.duration", "from 1e-09"),
    (lambda: regular_frame((), (4.0,), SECTION, SECTION), "frame.bays", "1 to 100"),
    (lambda: regular_frame((3000.0,), (4.0,), SECTION, SECTION), "frame.bays.0", "millimetres"),
    (lambda: regular_frame((3.0,), (4.0,), 220, SECTION), "frame.column", "find(name)"),
    (lambda: regular_frame((3.0,), (4.0,), SECTION, SECTION, base="x"), "frame.base", "pinned"),
]


NAMES = [f"{field}: {words}"[:60] for _, field, words in REFUSED]


@pytest.mark.parametrize(("make", "field", "words"), REFUSED, ids=NAMES)
def test_what_does_not_fit_is_refused_with_one_message(make, field, words) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.field == field
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_lists_become_tuples_and_scenarios_can_be_hashed_and_pickled() -> None:
    frame = Frame(list(portal().nodes), list(portal().members))
    assert frame == portal()
    assert hash(frame) == hash(portal())
    shake = _shake(acceleration=np.array([0.0, 1.0, -1.0]))
    assert shake.acceleration == (0.0, 1.0, -1.0)
    for scenario in (_static(), _impact(), shake):
        assert pickle.loads(pickle.dumps(scenario)) == scenario
        assert {scenario: 1}[scenario] == 1


def test_ground_motion_lasts_to_the_end_of_its_acceleration_unless_told() -> None:
    assert _shake().duration == pytest.approx(0.02)
    assert _shake(duration=3.0).duration == 3.0


def test_impact_energy_and_velocity() -> None:
    assert _impact().input_energy == pytest.approx(0.5 * 100.0 * 25.0)
    assert _impact().at_velocity(10.0).input_energy == pytest.approx(5000.0)
    assert _impact().at_velocity(5.0) == _impact()


def test_size_of_a_pattern() -> None:
    both = (Load("tip", x=3e3, moment=9e8), Load("corner", y=4e3))
    assert _static(loads=both).magnitude == hypot(3e3, 4e3)
    assert _static(loads=(Load("tip", moment=-5.0), Load("corner", moment=2.0))).magnitude == 5.0
    assert _static(loads=(Load("tip", x=7.0), Load("corner", x=-7.0))).magnitude == 7.0


@given(st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=5), st.integers(1, 4))
def test_cyclic_paths_swing_between_both_signs(amplitudes, cycles) -> None:
    path = cyclic_path(amplitudes, cycles)
    assert len(path) == 2 * cycles * len(amplitudes) + 1
    assert path[-1] == 0.0
    assert all(a * b < 0.0 for a, b in pairwise(path[:-1]))
    assert sorted({abs(p) for p in path[:-1]}) == sorted(set(amplitudes))
    assert _static(path=path).path == path
    with pytest.raises(InputError, match="amplitudes"):
        cyclic_path([-0.1])
    with pytest.raises(InputError, match="cycles"):
        cyclic_path([0.1], 0)


def test_frames_share_what_strength_does_not_change() -> None:
    weak, strong = (portal(steel=Steel(yield_stress=stress)) for stress in (235e6, 460e6))
    assert weak.elastic is strong.elastic is weak.elastic.elastic
    assert weak.lengths is strong.lengths
    assert weak.member("leg") is weak.members[0]  # own parts under their names all the same
    assert strong.member("leg") is strong.members[0]
    assert weak.properties("leg").plastic_moment < strong.properties("leg").plastic_moment
    soft = portal(steel=Steel(elastic_modulus=200e9))
    assert soft.elastic is not weak.elastic
    assert weak != strong


def test_what_does_not_fit_is_refused_again() -> None:
    for stress in (235e6, 460e6, 235e6):
        with pytest.raises(InputError, match="not supported"):
            portal("roller-x", "free", steel=Steel(yield_stress=stress))
