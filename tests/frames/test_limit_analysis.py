"""Collapse loads and shear demands of frames in closed form: one beam, one upright."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.mechanics.frames.collapse import collapse_factor, collapse_mechanism
from workbench.mechanics.frames.members import shear_bound, shear_demand
from workbench.scenarios import Frame, FramePulse, Joint, Load, Member, Node, Pulse
from workbench.steel.sections import find, square

LENGTH, SECTION = 6.0, square(0.2)


def beam(support: str, *joints: Joint) -> Frame:
    """A beam of two members; the first of the joints stands at its right end."""
    at = (("left", 0.0, support), ("mid", 0.5 * LENGTH, "free"), ("right", LENGTH, support))
    nodes = tuple(Node(name, x, 0.0, held) for name, x, held in at)
    far = {"joint_end": joints[0].name} if joints else {}
    members = (
        Member("a", "left", "mid", SECTION),
        Member("b", "mid", "right", SECTION, **far),
    )
    return Frame(nodes, members, joints=joints)


@pytest.mark.parametrize("end", ["start", "end"])
@pytest.mark.parametrize(("sagging", "hogging"), [(0.2, 0.6), (0.6, 0.2)])
def test_the_end_of_a_clamped_beam_hogs(end: str, sagging: float, hogging: float) -> None:
    plastic = beam("clamped").properties("b").plastic_moment
    weak = {"plastic_moment": sagging * plastic, "plastic_moment_negative": hogging * plastic}
    frame = beam("clamped", Joint("weak", **weak))
    if end == "start":  # the same seen from the other side: turned around, hogging is sagging
        turned = Member("b", "right", "mid", SECTION, joint_start="weak")
        weak = {"plastic_moment": hogging * plastic, "plastic_moment_negative": sagging * plastic}
        frame = Frame(frame.nodes, (frame.members[0], turned), joints=(Joint("weak", **weak),))
    factor = collapse_factor(frame, [Load("mid", y=-1.0)])
    assert factor == pytest.approx(2.0 * (3.0 + hogging) * plastic / LENGTH, rel=1e-6)


def test_compression_softens_the_mechanism_of_an_upright() -> None:
    nodes = (Node("base", 0.0, 0.0, "clamped"), Node("head", 0.0, LENGTH))
    frame = Frame(nodes, (Member("m", "base", "head", SECTION),))
    helped = collapse_factor(frame, [Load("head", x=1.0, moment=2.0)])  # turns against the push
    assert helped == pytest.approx(frame.properties("m").plastic_moment / (LENGTH - 2.0), rel=1e-6)
    mechanism = collapse_mechanism(frame, [Load("head", x=1.0)])
    assert mechanism is not None
    assert mechanism.factor == pytest.approx(
        frame.properties("m").plastic_moment / LENGTH, rel=1e-6
    )
    assert np.abs(mechanism.turns(frame)) == pytest.approx([1.0 / LENGTH])
    assert mechanism.softening(frame, [-5e4]) == pytest.approx(5e4 / LENGTH)
    assert mechanism.softening(frame, [5e4]) == pytest.approx(-5e4 / LENGTH)


@pytest.mark.parametrize(("support", "moments"), [("pinned", 4.0), ("clamped", 8.0)])
def test_a_line_load_needs_its_reactions(support: str, moments: float) -> None:
    """q L / 2 of the mechanism q = 8 M / L^2 of a beam, clamped 16 M / L^2."""
    frame = beam(support)
    pulse = FramePulse("line", frame, Pulse("ramp", 1.0, 1.0), "mid", "-y", members=("a", "b"))
    properties = frame.properties("a")
    expected = moments * properties.plastic_moment / LENGTH / properties.shear_resistance
    assert shear_demand(pulse) == pytest.approx({"a": expected, "b": expected})


def test_webs_yield_where_they_carry_a_twentieth_of_the_resistance() -> None:
    """(2 V / V_pl - 1)^2 of the share of the webs in the plastic modulus (EN 1993-1-1, 6.2.8)."""
    section = find("IPE 300").without_fillets()
    shape = section.shape
    share = shape.web * (shape.height / 2.0 - shape.flange) ** 2 / section.plastic_section_modulus
    assert share * (2.0 * shear_bound(section) - 1.0) ** 2 == pytest.approx(0.05)
