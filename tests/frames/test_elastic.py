"""The elastic frame against beam theory: stiffness, end forces, buckling, vibrations."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from workbench.mechanics.frames.elastic import ElasticFrame
from workbench.scenarios import Frame, Load, Member, Node
from workbench.steel.sections import square

LENGTH, SECTION = 4.0, square(0.1)


def upright(base: str, head: str = "free", lean: tuple[float, float] = (0.0, 1.0)) -> Frame:
    """One member from a base to its head, along the direction `lean`."""
    x, y = (LENGTH * share for share in lean)
    nodes = (Node("base", 0.0, 0.0, base), Node("head", x, y, head))
    return Frame(nodes, (Member("m", "base", "head", SECTION),))


def stiffness(frame: Frame) -> tuple[float, float]:
    """EI and EA."""
    properties = frame.properties(frame.members[0])
    modulus = frame.steel.elastic_modulus
    return modulus * properties.second_moment, modulus * properties.area


@pytest.mark.parametrize("lean", [(0.0, 1.0), (0.6, 0.8)])
def test_a_cantilever_bends_and_stretches_as_a_beam_does(lean) -> None:
    frame = upright("clamped", lean=lean)
    EI, EA = stiffness(frame)
    across, along = np.array([lean[1], -lean[0]]), np.array(lean)
    elastic = ElasticFrame(frame, parts=3)
    for direction, softness in ((across, LENGTH**3 / (3.0 * EI)), (along, LENGTH / EA)):
        moved = elastic.displacement(elastic.load([Load("head", *(1e3 * direction))]))
        assert moved is not None
        assert moved[3:5] == pytest.approx(1e3 * softness * direction, rel=1e-9)
    moved = elastic.displacement(elastic.load([Load("head", *(1e3 * across + 2e3 * along))]))
    axial, moment = elastic.end_forces(moved)
    assert axial == pytest.approx([2e3, 2e3])
    # pushed to the right of somebody who looks along it: stretched on the left
    assert moment == pytest.approx([-1e3 * LENGTH, 0.0], abs=1e-6)


@pytest.mark.parametrize(
    ("base", "head", "factor"), [("clamped", "free", 2.0), ("pinned", "roller-y", 1.0)]
)
def test_it_buckles_at_the_euler_load_in_compression_alone(base, head, factor) -> None:
    frame = upright(base, head)
    euler = pi**2 * stiffness(frame)[0] / (factor * LENGTH) ** 2
    elastic = ElasticFrame(frame, parts=8)
    assert elastic.buckling_factor(np.full(2, -1.0)) == pytest.approx(euler, rel=1e-3)
    assert elastic.buckling_factor(np.full(2, 1.0)) == np.inf


def test_the_period_of_a_cantilever() -> None:
    frame = upright("clamped")
    mass = frame.properties(frame.members[0]).mass_per_length
    elastic = ElasticFrame(frame, parts=6)
    periods, swings = elastic.vibrations(elastic.load([Load("head", 1.0)]))
    first = 2.0 * pi / (1.875104**2 * sqrt(stiffness(frame)[0] / (mass * LENGTH**4)))
    assert periods[np.argmax(swings)] == pytest.approx(first, rel=1e-3)
    assert periods.max() == pytest.approx(first, rel=1e-3)
