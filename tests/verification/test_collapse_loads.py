"""Collapse loads of limit analysis, met at first order: plasticity is sampled inside elements."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from verification_cases import (
    FORMULATIONS,
    FY,
    SIDE,
    hold,
    orders,
    steel_chain,
)

from workbench.mechanics.structures.paths import push

YIELD = 0.1 * FY  # a weak steel: hinges are complete while the geometry has hardly changed
PLASTIC_MOMENT = YIELD * SIDE**3 / 4.0
SAMPLED = {"reissner": 0.5, "corotational": 0.5 - 0.5 / np.sqrt(3.0)}  # of an element


def beam(kind: str, elements: int, propped: bool) -> float:
    """Collapse load of a beam of 8 m with a central load, free to slide."""
    x = np.linspace(0.0, 8.0, elements + 1)
    chain = steel_chain(kind, np.stack([x, 0.0 * x], axis=1), YIELD)
    hold(chain, 0)
    hold(chain, elements, "v", *(() if propped else ("rotation",)))
    path = np.linspace(0.0, 0.1, 21)[1:]
    return [s.factor for s in push(chain, chain.dof(elements // 2, "v"), path)][-1]


@pytest.mark.claim("model:fiber-{kind}", "collapse load over 8 M_p / L", "closed form", 1, 7e-4)
@pytest.mark.parametrize("kind", FORMULATIONS)
def test_clamped_beam(kind, claim) -> None:
    """8 Mp / L; hinges a share of an element inside shorten the arms on both sides."""
    exact = PLASTIC_MOMENT
    errors = []
    for elements in (8, 16, 32, 64):
        force = beam(kind, elements, propped=False)
        # an arm is shorter by what lies inside: its length, not the force, is linear in the mesh
        errors.append(exact / force - 1.0)
        inside = SAMPLED[kind] * 8.0 / elements
        claim(force * (4.0 - 2.0 * inside) / (4.0 * PLASTIC_MOMENT))
    assert orders(errors) == pytest.approx(1.0, abs=0.036)  # measured 0.018


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_propped_beam(kind) -> None:
    """6 Mp / L."""
    errors = [0.75 * PLASTIC_MOMENT / beam(kind, n, propped=True) - 1.0 for n in (8, 16, 32, 64)]
    assert orders(errors) == pytest.approx(1.0, abs=0.057)  # measured 0.029
    assert abs(errors[-1]) <= 0.03  # measured 0.021


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_sway_of_a_portal(kind) -> None:
    """4 Mp / h: hinges at both bases and both heads of columns of 4 m."""
    height, part = 4.0, 20
    ticks = np.linspace(0.0, 1.0, part + 1)
    left = np.stack([0.0 * ticks, height * ticks], axis=1)
    top = np.stack([4.0 * ticks[1:], height + 0.0 * ticks[1:]], axis=1)
    right = np.stack([4.0 + 0.0 * ticks[1:], height * (1.0 - ticks[1:])], axis=1)
    points = np.concatenate([left, top, right])
    assert all(np.hypot(*(b - a)) == pytest.approx(height / part) for a, b in pairwise(points))
    frame = steel_chain(kind, points, YIELD)
    hold(frame, 0)
    hold(frame, len(points) - 1)
    steps = push(frame, frame.dof(part, "u"), np.linspace(0.0, 0.08, 31)[1:])
    forces = [s.factor for s in steps]
    inside = SAMPLED[kind] * height / part
    # measured 0.0026
    assert forces[-1] == pytest.approx(4.0 * PLASTIC_MOMENT / (height - 2.0 * inside), rel=5.2e-3)
    assert forces[-1] == pytest.approx(forces[-6], rel=1.2e-4)  # the plateau; measured 5.8e-5
