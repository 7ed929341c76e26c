"""Changes of a scenario that must not change the answer, or must change it in one direction only.

Over every registered model of columns and frames, so that a new one is held to them as it comes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from test_registered_models import model_of

from workbench.models.base import Model, model_kind, model_names
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    Frame,
    FrameImpact,
    FrameStriker,
    Load,
    Member,
    Node,
    Striker,
)
from workbench.steel.sections import Section, square

# answer what is printed, or what a server says
READ = ("published", "measured", "imported", "remote", "opensees")
ROUNDING = 1e-6
DURATION = {"soft-impact": 0.4}  # s, of records: a soft striker pushes for long
# a mesh follows the parts of a member, and so do bars and lumped masses of models with few elements
# for each: measured 0.0 to 1.8 %. Their striker is heavy: a light one hits heavy bars again and
# again, and late hits decide which of two equal maxima is the peak (6 to 9 %)
SPLIT_MESH, SPLIT_ELEMENT = 0.01, 0.03


SLOW = ("solid-plane-stress", "shell")
BY_ERROR = ("rigid-superelement", "flexible-superelement")


def meshed(name: str) -> bool:
    return model_kind(name).__module__.startswith("workbench.models.references")


def of(kind: str) -> list[Any]:
    names = [n for n in model_names() if n not in READ and kind in model_kind(n).answers]
    return [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in names]


COLUMNS, FRAMES = of(ColumnImpact.KIND), of(FrameImpact.KIND)


@cache
def model(name: str) -> Model:
    """A model; where contacts open and close often, steps by error follow round-off: equal ones."""
    given = model_of(name)
    return replace(given, time_step=2e-5) if name in BY_ERROR else given  # type: ignore[type-var]


@cache
def peak(name: str, scenario: Any) -> float | None:
    """The peak of a model, None where it refuses or its record ends before."""
    response = model(name).simulate(scenario)
    if outcome_of(response) is Outcome.OUT_OF_DOMAIN:
        return None
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    return float(response["peak_displacement"]) if "peak_displacement" in response else None


def column_hit(
    name: str, mass: float = 800.0, velocity: float = 6.0, below: float = 1.5
) -> ColumnImpact:
    column = Column(square(0.2), below, 4.0 - below, axial_load=2e5)
    return ColumnImpact("hit", column, Striker(mass, velocity), DURATION.get(name, 0.02))


@pytest.mark.thorough
@pytest.mark.parametrize("name", COLUMNS)
def test_columns_move_farther_the_faster_and_the_heavier_the_striker(name: str) -> None:
    base = peak(name, column_hit(name))
    for more in (column_hit(name, velocity=7.0), column_hit(name, mass=1000.0)):
        farther = peak(name, more)
        assert (base is None) == (farther is None)
        assert base is None or farther is None or farther > 1.02 * base


@pytest.mark.thorough
@pytest.mark.parametrize("name", COLUMNS)
def test_a_column_upside_down_is_the_same_column(name: str) -> None:
    """Clamped base and guided head differ in how they shorten only, by inertia of axial motion."""
    up, down = peak(name, column_hit(name)), peak(name, column_hit(name, below=2.5))
    assert (up is None) == (down is None)
    close = up is None or up == pytest.approx(down, rel=5e-3)
    if name in SLOW and not close:
        pytest.xfail("48 solid elements make it 0.6 %")
    assert close


def frame(side: float = 0.2) -> Frame:
    """A portal of two struts and a beam, the left strut split where it is hit."""
    section: Section = square(side)
    nodes = (
        Node("a", 0.0, 0.0, "clamped"),
        Node("hit", 0.0, 1.2),
        Node("b", 0.0, 3.0),
        Node("c", 4.0, 3.0),
        Node("d", 4.0, 0.0, "clamped"),
    )
    members = (
        Member("lower", "a", "hit", section),
        Member("upper", "hit", "b", section),
        Member("beam", "b", "c", section),
        Member("right", "c", "d", section),
    )
    return Frame(nodes, members, loads=(Load("b", y=-1e5), Load("c", y=-1.5e5)))


def hit(
    of: Frame, direction: str = "+x", mass: float = 500.0, velocity: float = 6.0
) -> FrameImpact:
    return FrameImpact(
        "hit", of, FrameStriker(mass, velocity, node="hit", direction=direction), 0.04
    )


def moved(of: Frame, x: Any, y: Any) -> Frame:
    """The frame with another place for every node and another direction for every load."""
    nodes = [replace(n, x=x(n.x, n.y), y=y(n.x, n.y)) for n in of.nodes]
    loads = [replace(load, x=x(load.x, load.y), y=y(load.x, load.y)) for load in of.loads]
    return replace(of, nodes=tuple(nodes), loads=tuple(loads))


def reversed_members(of: Frame) -> Frame:
    return replace(of, members=tuple(replace(m, start=m.end, end=m.start) for m in of.members))


def reordered(of: Frame) -> Frame:
    nodes, members = of.nodes, of.members
    turned = (*nodes[2:], *nodes[:2]), (*members[1:], *members[:1])
    return replace(of, nodes=turned[0], members=turned[1], loads=of.loads[::-1])


def turned(of: Frame) -> Frame:
    """Turned by a right angle: what pointed along +x points along +y."""
    return moved(of, lambda x, y: -y, lambda x, y: x)


# all at once in every run; one by one on demand
SAME = {
    "turned and mirrored, members and lists in another order": hit(
        reversed_members(reordered(moved(turned(frame()), lambda x, y: -x, lambda x, y: y))), "+y"
    ),
}
ONE_BY_ONE = {
    "mirrored": hit(moved(frame(), lambda x, y: -x, lambda x, y: y), "-x"),
    "turned by a right angle": hit(turned(frame()), "+y"),
    "turned and mirrored": hit(moved(turned(frame()), lambda x, y: -x, lambda x, y: y), "+y"),
    "upside down": hit(moved(frame(), lambda x, y: x, lambda x, y: -y)),
    "members from the other end": hit(reversed_members(frame())),
    "in another order": hit(reordered(frame())),
    "members and lists in another order": hit(reversed_members(reordered(frame()))),
}
CHANGES = [*SAME, *(pytest.param(change, marks=pytest.mark.slow) for change in ONE_BY_ONE)]


@pytest.mark.thorough
@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("name", FRAMES)
def test_what_a_frame_does_depends_on_nothing_but_the_frame(name: str, change: str) -> None:
    one, other = peak(name, hit(frame())), peak(name, (SAME | ONE_BY_ONE)[change])
    assert (one is None) == (other is None)
    assert one is None or one == pytest.approx(other, rel=ROUNDING)


@pytest.mark.thorough
@pytest.mark.parametrize("name", FRAMES)
def test_an_unloaded_member_in_two_parts_is_the_same_member(name: str) -> None:
    given, whole, tolerance = model(name), hit(frame()), SPLIT_MESH
    if meshed(name):  # a mesh follows the parts: one that is fine enough not to tell
        given = replace(given, smallest_element=0.1, largest_element=0.2)  # type: ignore[type-var]
        # waves in beams that are rigid in shear feel the mesh: the plane one as well
        tolerance = 2.0 * SPLIT_MESH if name == "fiber-space" else SPLIT_MESH
    else:
        whole = replace(hit(frame(), mass=20000.0, velocity=2.0), duration=0.06)  # peak at 0.04 s
        tolerance = SPLIT_ELEMENT
    parts = replace(whole, frame=frame().split("beam", 1.7, "new"))
    one, other = (given.simulate(each) for each in (whole, parts))
    assert outcome_of(one) is outcome_of(other)
    if outcome_of(one) is Outcome.OK:
        peaks = [float(each["peak_displacement"]) for each in (one, other)]
        assert peaks[0] == pytest.approx(peaks[1], rel=tolerance)


@pytest.mark.thorough
@pytest.mark.parametrize("name", FRAMES)
def test_frames_move_farther_the_faster_and_heavier_the_striker(name: str) -> None:
    """Both at once: columns tell one from the other."""
    base, farther = peak(name, hit(frame())), peak(name, hit(frame(), velocity=7.0, mass=650.0))
    assert (base is None) == (farther is None)
    assert base is None or farther is None or farther > 1.04 * base
