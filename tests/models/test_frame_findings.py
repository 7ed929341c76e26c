"""Where frames leave the domain: dead loads, buckling, shear demand, chains of members."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from builders import SQUARE, portal

from workbench.mechanics.frames.elastic import dead_load_state, line_wave_times, time_to_peak
from workbench.mechanics.frames.members import chains, shear_demand, shear_stiffness
from workbench.mechanics.frames.structure import free_to_spin
from workbench.models.domain import euler_load, frame_findings
from workbench.models.domain import shear_demand as column_demand
from workbench.models.superelements import RigidSuperelement
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import (
    Frame,
    FrameImpact,
    FrameStatic,
    FrameStriker,
    Joint,
    Load,
    Member,
    Node,
    frame_of,
    frame_scenario,
    regular_frame,
)
from workbench.steel.sections import find

HEB = find("HEB 220")


def hit(frame: Frame, node: str) -> FrameImpact:
    return FrameImpact("hit", frame, FrameStriker(100.0, 1.0, node=node))


def subjects(scenario: FrameImpact | FrameStatic) -> dict[str, bool]:
    """Subjects of the findings, and whether they refuse."""
    return {finding.subject: finding.refusal for finding in frame_findings(scenario)}


# -- dead loads ------------------------------------------------------------------------------


@pytest.mark.parametrize("base", ["clamped", "pinned"])
@pytest.mark.parametrize("head", ["guided", "pinned"])
def test_buckling_of_a_column_is_eulers(thesis_impact, base, head) -> None:
    column = replace(thesis_impact.column, base=base, head=head, length_below=2.0, length_above=2.0)
    state = dead_load_state(frame_of(column))
    expected = euler_load(replace(thesis_impact, column=column)) / column.axial_load
    assert state.factor == pytest.approx(expected, rel=0.014)
    np.testing.assert_allclose(state.axial, -column.axial_load, rtol=1e-9)


def test_sway_buckling_of_a_portal() -> None:
    """Rigid beam, clamped feet: P = pi^2 EI / h^2 for each column."""
    frame = portal()
    beam = replace(frame.member("A1-B1"), second_moment=1.0)
    load = 1e6
    frame = replace(
        frame,
        members=(*frame.members[:2], beam),
        loads=(Load("A1", y=-load), Load("B1", y=-load)),
    )
    critical = pi**2 * frame.steel.elastic_modulus * SQUARE.second_moment / 4.0**2
    assert dead_load_state(frame).factor == pytest.approx(critical / load, rel=0.01)
    # on pins the beam is as if it were not there: two cantilevers
    beam = replace(beam, joint_start="pinned", joint_end="pinned")
    loose = replace(frame, members=(*frame.members[:2], beam))
    # measured 5.1e-4
    assert dead_load_state(loose).factor == pytest.approx(0.25 * critical / load, rel=1.1e-3)
    # on springs it lies between
    semi = Joint("semi", rotational_stiffness=1e7)
    beam = replace(beam, joint_start="semi", joint_end="semi")
    springy = replace(frame, members=(*frame.members[:2], beam), joints=(semi,))
    factor = dead_load_state(springy).factor
    assert factor is not None
    assert 0.3 * critical / load < factor < 0.95 * critical / load


def test_tension_does_not_buckle() -> None:
    nodes = (Node("a", 0.0, 0.0, support="clamped"), Node("b", 0.0, 3.0))
    frame = Frame(nodes, (Member("rod", "a", "b", SQUARE),), loads=(Load("b", y=1e6),))
    state = dead_load_state(frame)
    assert state.factor == np.inf
    np.testing.assert_allclose(state.axial, 1e6)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("share", "expected"), [(0.3, {}), (0.6, {"buckling": False}), (1.1, {"buckling": True})]
)
def test_dead_loads_against_buckling(share, expected) -> None:
    nodes = (Node("a", 0.0, 0.0, support="clamped"), Node("b", 0.0, 12.0))
    critical = 0.25 * pi**2 * 210e9 * SQUARE.second_moment / 12.0**2
    frame = Frame(
        nodes, (Member("mast", "a", "b", SQUARE),), loads=(Load("b", y=-share * critical),)
    )
    assert subjects(hit(frame, "b")) == expected
    refused = outcome_of(RigidSuperelement().simulate(hit(frame, "b"))) is Outcome.OUT_OF_DOMAIN
    assert refused == expected.get("buckling", False)


def test_squash_and_weak_joints_are_refused() -> None:
    squash = 355e6 * SQUARE.area
    nodes = (Node("a", 0.0, 0.0, support="clamped"), Node("b", 0.0, 1.0))
    joint = Joint("weak", tension_resistance=0.2 * squash)
    for load, name, refused in (
        (-1.01, "rigid", True), (-0.9, "rigid", False), (0.3, "rigid", False), (0.3, "weak", True),
    ):  # fmt: skip
        member = Member("post", "a", "b", SQUARE, joint_end=name)
        frame = Frame(nodes, (member,), loads=(Load("b", y=load * squash),), joints=(joint,))
        assert subjects(hit(frame, "b")).get("squash", False) == refused


def test_mechanisms_and_moments_on_pins_are_refused() -> None:
    """A portal on pins whose beam is pinned too falls over; a pin resists no moment."""
    frame = portal(base="pinned")
    beam = replace(frame.member("A1-B1"), joint_start="pinned", joint_end="pinned")
    loose = replace(frame, members=(*frame.members[:2], beam), loads=(Load("A1", x=1e3, y=-1e3),))
    assert subjects(hit(loose, "A1"))["mechanism"]
    nodes = (
        Node("a", 0.0, 0.0, support="pinned"),
        Node("m", 2.0, 1.0),
        Node("b", 4.0, 0.0, support="pinned"),
    )
    ends = {"joint_start": "pinned", "joint_end": "pinned"}
    members = (Member("l", "a", "m", SQUARE, **ends), Member("r", "m", "b", SQUARE, **ends))
    truss = Frame(nodes, members)
    assert free_to_spin(truss) == [0, 1, 2]
    assert subjects(hit(truss, "m")) == {}
    twisted = FrameStatic("twist", truss, (Load("m", y=-1.0, moment=1.0),), "m", "-y", (0.01,))
    assert subjects(twisted)["mechanism"]


def test_a_truss_is_answered_like_its_statics() -> None:
    """Two inclined bars on pins: force 2 N sin, N from the shortening of the bars."""
    nodes = (
        Node("a", 0.0, 0.0, support="pinned"),
        Node("m", 2.0, 1.5),
        Node("b", 4.0, 0.0, support="pinned"),
    )
    ends = {"joint_start": "pinned", "joint_end": "pinned"}
    members = (Member("l", "a", "m", SQUARE, **ends), Member("r", "m", "b", SQUARE, **ends))
    push = FrameStatic("push", Frame(nodes, members), (Load("m", y=-1.0),), "m", "-y", (1e-4,))
    response = RigidSuperelement().simulate(push)
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    shortening = 1e-4 * 0.6
    expected = 2.0 * 0.6 * 210e9 * SQUARE.area * shortening / 2.5
    assert float(response["force"][-1]) == pytest.approx(expected, rel=1.3e-4)  # measured 6.4e-5


# -- shear and chains ------------------------------------------------------------------------


def test_shear_demand_of_a_column_is_that_of_the_column(thesis_impact) -> None:
    for base, head in (("clamped", "guided"), ("pinned", "pinned")):
        column = replace(thesis_impact.column, base=base, head=head, axial_load=0.0)
        impact = replace(thesis_impact, column=column)
        result = shear_demand(frame_scenario(impact))
        expected = column_demand(impact)
        assert result == pytest.approx(expected, rel=1e-9)


def test_unloaded_nodes_do_not_shorten_members() -> None:
    frame = portal(section=HEB)
    whole = shear_demand(hit(frame, "A1"))
    split = frame.split("A0-A1", 0.3, "low").split("A0-A1/2", 0.3, "higher")
    parts = shear_demand(hit(split, "A1"))
    for name in ("A0-A1/1", "A0-A1/2/1", "A0-A1/2/2"):
        assert parts[name] == pytest.approx(whole["A0-A1"])
    assert subjects(hit(split, "A1")) == {}
    struck = shear_demand(hit(split, "low"))
    assert struck["A0-A1/1"] > 1.0
    assert subjects(hit(split, "low")) == {"shear": False}


def members_of(frame: Frame, kept: Collection[str] = ()) -> list[tuple[str, ...]]:
    return [chain.members for chain in chains(frame, kept)]


def test_chains_follow_straight_members_through_free_nodes() -> None:
    frame = regular_frame((6.0,), (4.0, 4.0), SQUARE, SQUARE)
    frame = frame.split("A0-A1", 1.0, "p").split("A0-A1/2", 1.0, "q")
    turned = replace(
        frame,
        members=tuple(
            replace(m, start=m.end, end=m.start) if m.name == "A0-A1/2/1" else m
            for m in frame.members
        ),
    )
    for candidate in (frame, turned):
        result = sorted(members_of(candidate), key=len, reverse=True)
        assert result[0] == ("A0-A1/1", "A0-A1/2/1", "A0-A1/2/2")
        assert all(len(chain) == 1 for chain in result[1:])
    cut = sorted(members_of(frame, {"p"}), key=len, reverse=True)
    assert cut[0] == ("A0-A1/2/1", "A0-A1/2/2")
    # corners, supports, springs and joints end a chain
    corner = portal()
    assert all(len(chain) == 1 for chain in members_of(corner))
    sprung = replace(
        frame, nodes=tuple(replace(n, spring_x=1.0) if n.name == "p" else n for n in frame.nodes)
    )
    assert max(len(chain) for chain in members_of(sprung)) == 2


# -- time ------------------------------------------------------------------------------------


@pytest.mark.parametrize("shear_flexible", [False, True])
def test_time_to_the_peak_of_a_clamped_column(thesis_impact, shear_flexible) -> None:
    """A clamped beam, a b / L in shear beside a^3 b^3 / (3 EI L^3); a mechanism of four hinges."""
    column = replace(thesis_impact.column, axial_load=0.0, length_below=1.6, length_above=1.6)
    section, properties = column.strength_section, column.properties
    moduli = 1.0 / 1.6 + 1.0 / 1.6
    flexibility = 1.0 / (3.0 * column.steel.elastic_modulus * properties.second_moment * moduli**3)
    if shear_flexible:
        flexibility += 1.0 / (shear_stiffness(section, column.steel) * moduli)
    mass = thesis_impact.striker.mass
    for velocity in (0.5, 15.0):
        impact = replace(thesis_impact.at_velocity(velocity), column=column)
        elastic = 0.5 * pi * sqrt((mass + properties.mass_per_length * 3.2 / 3.0) * flexibility)
        plastic = mass * velocity / (2.0 * properties.plastic_moment * moduli)
        result = time_to_peak(frame_scenario(impact), shear_flexible)
        assert result == pytest.approx(max(elastic, plastic), rel=1e-9)
        assert (result == pytest.approx(plastic)) == (velocity > 1.0)


def test_a_wave_passes_all_parts_of_a_member() -> None:
    frame = portal().split("A0-A1", 1.0, "p")
    speed = sqrt(frame.steel.elastic_modulus / frame.steel.density)
    assert sorted(line_wave_times(frame)) == pytest.approx([4.0 / speed, 4.0 / speed, 6.0 / speed])
