"""Collapse loads of textbook frames against limit analysis by linear programming.

Stiff members keep the geometry as it was until the last hinge forms; from then on the vertical
loads tilt with the frame, so that the largest load factor is the one that limit analysis gives.
"""

from __future__ import annotations

import pytest
from limit_analysis import collapse_factor

from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import Frame, FrameStatic, Load, Member, Node, regular_frame
from workbench.steel.materials import Steel
from workbench.steel.sections import section_from

STIFF = Steel(elastic_modulus=1e12, yield_stress=1e7)
SECTION = section_from({"width": 0.2, "height": 0.2}, "section")
LARGE = 1e10  # N, squash load without interaction
SECOND_MOMENT = 10.0 * SECTION.second_moment  # m4


def member(start: str, end: str, strength: float = 1.0, squash: float | None = LARGE) -> Member:
    """A member with a multiple of the section's plastic moment."""
    moment = strength * SECTION.plastic_moment(STIFF)
    return strong(f"{start}-{end}", start, end, moment, squash)


def strong(name: str, start: str, end: str, moment: float, squash: float | None = LARGE) -> Member:
    """A stiff member with its own plastic moment (N m) and squash load (N)."""
    return Member(
        *(name, start, end, SECTION),
        second_moment=SECOND_MOMENT,
        plastic_moment=moment,
        squash_load=squash,
    )


def beam(right: str) -> FrameStatic:
    """Beam mechanism: 8 m, clamped on the left, point load at mid-span, free to slide."""
    nodes = (
        Node("left", 0.0, 0.0, support="clamped"),
        Node("middle", 4.0, 0.0),
        Node("right", 8.0, 0.0, support=right),
    )
    frame = Frame(nodes, (member("left", "middle"), member("middle", "right")), steel=STIFF)
    return FrameStatic("beam", frame, (Load("middle", y=-1e3),), "middle", "-y", (0.01,))


def portal(
    sideways: float, down: float, base: str = "clamped", squash: float | None = LARGE
) -> FrameStatic:
    """Portal of 4 m by 8 m with a strong beam and loads (N) at its left corner and mid-span."""
    nodes = (
        Node("a", 0.0, 0.0, support=base),
        Node("b", 0.0, 4.0),
        Node("c", 4.0, 4.0),
        Node("d", 8.0, 4.0),
        Node("e", 8.0, 0.0, support=base),
    )
    members = (
        member("a", "b", squash=squash),
        member("b", "c", 1.5, squash),
        member("c", "d", 1.5, squash),
        member("d", "e", squash=squash),
    )
    loads = tuple(load for load in (Load("b", x=sideways), Load("c", y=-down)) if load.x or load.y)
    node, direction = ("b", "x") if sideways else ("c", "-y")
    frame = Frame(nodes, members, steel=STIFF)
    return FrameStatic("portal", frame, loads, node, direction, (0.02,))


def two_storey() -> FrameStatic:
    """Two storeys and one bay under wind and floor loads at mid-span."""
    frame = regular_frame((6.0,), (4.0, 3.5), SECTION, SECTION, steel=STIFF)
    for level in (1, 2):
        frame = frame.split(f"A{level}-B{level}", 3.0, f"floor {level}")
    moment = SECTION.plastic_moment(STIFF)
    members = tuple(strong(m.name, m.start, m.end, moment) for m in frame.members)
    frame = Frame(frame.nodes, members, steel=STIFF)
    loads = (
        Load("A1", x=1e3),
        Load("A2", x=0.5e3),
        Load("floor 1", y=-1.5e3),
        Load("floor 2", y=-1e3),
    )
    return FrameStatic("two storeys", frame, loads, "A2", "x", (0.03,))


FRAMES = {
    "beam mechanism": beam("guide-x"),
    "propped beam": beam("roller-x"),
    "sway mechanism": portal(1e3, 0.0),
    "combined mechanism": portal(1e3, 1.5e3),
    "two storeys": two_storey(),
}


@pytest.mark.claim("model:{model.name}", "collapse load, ratio", "independent code", 1, 1e-3)
@pytest.mark.thorough
@pytest.mark.parametrize("model", [RigidSuperelement, FlexibleSuperelement])
@pytest.mark.parametrize("name", FRAMES)
def test_collapse_load(name, model, claim) -> None:
    """The plateau of the load factor is that of limit analysis."""
    scenario = FRAMES[name]
    response = model().simulate(scenario)
    assert response.attrs["outcome"] == "ok", response.attrs["message"]
    plateau = float(response["load_factor"].max())
    claim(plateau / collapse_factor(scenario))


@pytest.mark.thorough
@pytest.mark.parametrize("model", [RigidSuperelement, FlexibleSuperelement])
def test_portal_with_interaction(model) -> None:
    """Linear N-M interaction lowers the combined mechanism of a portal as limit analysis says."""
    squash = 40.0 * SECTION.plastic_moment(STIFF)  # N, so that axial forces matter
    scenario = portal(1e3, 1.5e3, squash=squash)
    expected = collapse_factor(scenario, interaction=True)
    assert expected < 0.99 * collapse_factor(scenario)
    response = model(alpha=1.0, beta=1.0).simulate(scenario)
    # measured 2.9e-5
    assert float(response["load_factor"].max()) == pytest.approx(expected, rel=6e-5)


def test_limit_analysis_of_known_mechanisms() -> None:
    """The linear programme itself: 8 Mp / L, 6 Mp / L and 4 Mp / h."""
    moment = SECTION.plastic_moment(STIFF)
    assert collapse_factor(FRAMES["beam mechanism"]) == pytest.approx(moment / 1e3)
    assert collapse_factor(FRAMES["propped beam"]) == pytest.approx(0.75 * moment / 1e3)
    assert collapse_factor(FRAMES["sway mechanism"]) == pytest.approx(moment / 1e3)
