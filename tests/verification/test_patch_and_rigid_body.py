"""Patch tests on irregular meshes, and that rigid motions leave the forces alone."""

from __future__ import annotations

import numpy as np
import pytest
from verification_cases import (
    AREA,
    FORMULATIONS,
    FY,
    SECOND,
    SIDE,
    E,
    hold,
    steel_chain,
)

from workbench.mechanics.structures.paths import apply_loads, push

X = np.array([0.0, 0.13, 0.5, 0.61, 1.4, 2.0])
POINTS = np.stack([X, 0.0 * X], axis=1)


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_uniform_tension_and_curvature_are_met_exactly(kind) -> None:
    """A cantilever under an end moment is an arc of a circle, under tension a longer bar."""
    moment, last = 1e5, len(X) - 1
    bent = steel_chain(kind, POINTS, yield_stress=1e30)
    hold(bent, 0)
    bent.load[bent.dof(last, "rotation")] = moment
    apply_loads(bent, steps=2, tolerance=1e-13)
    turns = bent.displacement[bent.dofs(range(last + 1), "rotation")]
    np.testing.assert_allclose(turns, moment / (E * SECOND) * X, rtol=1e-9)
    pulled = steel_chain(kind, POINTS, yield_stress=1e30)
    hold(pulled, 0)
    pulled.load[pulled.dof(last, "u")] = 1e6
    apply_loads(pulled, steps=2, tolerance=1e-13)
    stretch = pulled.displacement[pulled.dofs(range(last + 1), "u")]
    np.testing.assert_allclose(stretch, 1e6 / (E * AREA.sum()) * X, rtol=1e-9)


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_uniform_plastic_tension(kind) -> None:
    """With hardening every element stretches by the same plastic strain."""
    bar = steel_chain(kind, POINTS, hardening=0.01)
    last = len(X) - 1
    hold(bar, 0)
    strain = 0.005
    *_, step = push(bar, bar.dof(last, "u"), np.linspace(0.0, strain * X[-1], 21)[1:])
    slope = E * 0.01 / 1.01
    assert step.factor == pytest.approx((FY + slope * (strain - FY / E)) * SIDE**2, rel=1e-9)
    np.testing.assert_allclose(
        # measured: round-off
        bar.displacement[bar.dofs(range(last + 1), "u")],
        strain * X,
        rtol=1e-8,
        atol=1e-12,
    )


@pytest.mark.parametrize("kind", FORMULATIONS)
@pytest.mark.parametrize("angle", [0.3, 2.0, 3.1])
def test_forces_turn_with_the_structure(kind, angle) -> None:
    """The strained chain, moved and turned as a whole: the same forces, turned."""
    rng = np.random.default_rng(3)
    shape = 1e-3 * rng.normal(size=(len(X), 3))
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = np.empty_like(shape)
    turned[:, :2] = (POINTS + shape[:, :2]) @ rotation.T - POINTS + [3.0, -1.0]
    turned[:, 2] = shape[:, 2] + angle
    first = steel_chain(kind, POINTS).assemble(shape.ravel(), None).reshape(-1, 3)
    second = steel_chain(kind, POINTS).assemble(turned.ravel(), None).reshape(-1, 3)
    scale = np.abs(first).max()
    np.testing.assert_allclose(second[:, :2], first[:, :2] @ rotation.T, atol=1e-8 * scale)
    np.testing.assert_allclose(second[:, 2], first[:, 2], atol=1e-8 * scale)
    np.testing.assert_allclose(first[:, :2].sum(axis=0), 0.0, atol=1e-10 * scale)
