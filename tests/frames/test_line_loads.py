"""Dead line loads on the members of a frame, against beam theory."""

from __future__ import annotations

from dataclasses import replace

import pytest

from workbench.base.errors import InputError
from workbench.mechanics.frames.structure import dead_loads
from workbench.models.base import make_model
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import Frame, FrameStatic, Load, Member, Node
from workbench.steel.sections import find

SPAN, LOAD = 6.0, 10e3  # m, N/m down
NODES = (
    Node("left", 0.0, 0.0, "pinned"),
    Node("middle", 0.5 * SPAN, 0.0),
    Node("right", SPAN, 0.0, "roller-x"),
)


def beam(load: float) -> Frame:
    halves = (("left", "middle"), ("middle", "right"))
    section = find("IPE 300")
    members = [Member(f"{a}-{b}", a, b, section, load_y=-load) for a, b in halves]
    return Frame(NODES, tuple(members))


def pushed(frame: Frame, down: float) -> FrameStatic:
    load = (Load("middle", y=-1.0),)
    return FrameStatic("beam", frame, load, "middle", "-y", (down,))


@pytest.mark.thorough
@pytest.mark.parametrize(
    "name",
    [
        "flexible-superelement",
        "rigid-superelement",
        "fiber-corotational",
        "fiber-reissner",
        "giberson",
    ],
)
def test_a_beam_sags_and_bears_less_by_its_line_load(name: str) -> None:
    """With the stiffness k of the model under a force at mid-span it sags by 5 q L / 8 k.

    The hinges of flexible superelements soften it the more the nearer they are to the force.
    """
    plastic = beam(LOAD).properties(beam(LOAD).members[0]).plastic_moment
    bare, loaded = (make_model(name).simulate(pushed(beam(q), 0.15)) for q in (0.0, LOAD))
    assert outcome_of(bare) is outcome_of(loaded) is Outcome.OK
    stiffness = float(bare["force"][1] / bare["displacement"][1])
    soft = 0.08 if name == "flexible-superelement" else 0.05
    sag = 5.0 * LOAD * SPAN / (8.0 * stiffness)
    assert loaded.attrs["dead_displacement"] == pytest.approx(sag, rel=0.5 * soft)
    assert stiffness == pytest.approx(48.0 * 210e9 * 8356e-8 / SPAN**3, rel=soft)
    # mechanism with a hinge at mid-span: P L / 4 + q L^2 / 8 = M_p
    for response, moment in ((bare, plastic), (loaded, plastic - LOAD * SPAN**2 / 8.0)):
        assert float(response["force"].max()) == pytest.approx(4.0 / SPAN * moment, rel=0.03)
    assert "dead_displacement" not in bare.attrs


def test_line_loads_are_half_at_either_end_and_weigh() -> None:
    frame = beam(LOAD)
    ends = {load.node: load.y for load in dead_loads(frame)}
    assert ends == pytest.approx({"left": -15e3, "middle": -30e3, "right": -15e3})
    assert frame.load_masses["middle"] == pytest.approx(30e3 / 9.81, rel=1e-3)
    sideways = replace(frame.members[0], load_y=0.0, load_x=5e3)
    turned = Frame(NODES, (sideways, frame.members[1]))
    assert {load.node: load.x for load in dead_loads(turned)}["middle"] == pytest.approx(7.5e3)


def test_line_loads_in_kn_are_named() -> None:
    with pytest.raises(InputError, match=r"member\.a\.load_y = .*line loads are in N/m"):
        Member("a", "left", "right", find("IPE 300"), load_y=-1e10)
