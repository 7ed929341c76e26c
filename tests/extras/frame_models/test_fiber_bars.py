"""Force-based elements: quadrature, elastic stiffness, tangent, equilibrium at every point."""

from __future__ import annotations

import numpy as np
import pytest
from assembly_cases import alone
from superelement_cases import NP

from workbench.extras.frame_models.bars import (
    Bar,
    BarElements,
    PlasticEnd,
    Quadrature,
    fiber_bars,
    hinge_rule,
    lobatto_rule,
)
from workbench.extras.frame_models.bars import fiber_kernels as kernels
from workbench.extras.frame_models.bars.kinds import FiberBarState
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import LinearHardening
from workbench.steel.hinges.interaction import polyline
from workbench.steel.sections import square

LENGTH, SHEAR, JOINT = 3.0, 2e8, 5e7
E, FY = 210e9, 355e6


def section(hardening: float = 1e-5) -> BeamSection:
    """A square of 0.2 m in 20 layers."""
    y, area = square(0.2).fibers(20)
    return BeamSection(y, area, LinearHardening(E, FY, hardening * E), 314.0)


def group(rule: Quadrature, fibers: BeamSection, joint: float = np.inf) -> BarElements:
    """One element along x, its start with a joint."""
    curve = polyline("exact", square(0.2))
    axial = E * fibers.area.sum()
    ends = [PlasticEnd((NP, NP), (1e6, 1e6), curve, stiffness) for stiffness in (joint, np.inf)]
    bar = Bar(*ends, axial, axial * fibers.radius_squared, 314.0, SHEAR, second_order=False)
    made = fiber_bars([[0, 1]], [bar], [rule], [fibers])
    return alone(made, LENGTH)


def law(bars: BarElements, q, state=None):
    """State and tangent at deformations `q` from a committed state; at rest without one."""
    old, k = state or bars.copy()._old, np.empty((3, 3))
    new = FiberBarState(*(values.copy() for values in old))
    new.deformation[0] = q
    kernels.force_law(*bars.tables, 0, np.inf, old, new, k)
    return new, k


@pytest.mark.parametrize("points", [3, 5, 8])
def test_lobatto_integrates_polynomials(points: int) -> None:
    rule = lobatto_rule(points)
    for power in range(2 * points - 2):
        assert rule.weights @ rule.xi**power == pytest.approx(1.0 / (power + 1.0), rel=1e-12)
    assert rule.xi[0] == 0.0 and rule.xi[-1] == 1.0  # noqa: PT018


@pytest.mark.parametrize("share", [0.03, 0.125, 0.6])
def test_hinge_rule_is_exact_for_elastic_flexibility(share: float) -> None:
    rule = hinge_rule(share)
    for power in range(3):
        assert rule.weights @ rule.xi**power == pytest.approx(1.0 / (power + 1.0), rel=1e-12)
    assert rule.weights[0] == min(share, 0.125)
    assert list(rule.elastic) == [False, True, True, True, True, False]


@pytest.mark.parametrize("rule", [lobatto_rule(5), hinge_rule(0.07)])
def test_elastic_stiffness_with_shear_and_joint(rule: Quadrature) -> None:
    fibers = section()
    bending = E * fibers.area.sum() * fibers.radius_squared
    f = np.array([[2.0, -1.0], [-1.0, 2.0]]) * LENGTH / (6.0 * bending) + 1.0 / (LENGTH * SHEAR)
    f[0, 0] += 1.0 / JOINT
    _, k = law(group(rule, fibers, JOINT), [1e-6, 1e-6, -2e-6])
    assert k[1:, 1:] == pytest.approx(np.linalg.inv(f), rel=1e-9)
    assert k[0, 0] == pytest.approx(E * fibers.area.sum() / LENGTH, rel=1e-9)
    _, k = law(group(rule, fibers, 0.0), [1e-6, 3e-6, -2e-6])
    assert np.all(k[1] == 0.0)
    assert k[2, 2] == pytest.approx(1.0 / (f[1, 1]), rel=1e-9)


@pytest.mark.parametrize("rule", [lobatto_rule(5), hinge_rule(0.07)])
def test_equilibrium_compatibility_and_tangent_far_in_the_plastic_range(rule: Quadrature) -> None:
    bars, rng = group(rule, section()), np.random.default_rng(4)
    (record,) = bars.tables
    size = np.sqrt([2.8e9, 3.7e7, 3.7e7])
    off = 0
    for _ in range(40):
        first = rng.standard_normal(3) * np.array([0.01, 0.05, 0.05])
        state, _ = law(bars, first)
        q = first + 10.0 ** rng.uniform(-4, 0) * rng.standard_normal(3) * [0.02, 0.1, 0.1]
        new, k = law(bars, q, state)
        forces, strains, before = new.local[0], new.strains[0], state.fibers[0]
        total = record.rest[0] @ forces
        for p, (x, w) in enumerate(zip(rule.xi, rule.weights, strict=True)):
            n, m, *_ = kernels.respond(
                record, 0, p, np.inf, strains[p], before, np.zeros_like(before)
            )
            assert n == pytest.approx(forces[0], abs=5.0)
            assert m == pytest.approx((x - 1.0) * forces[1] + x * forces[2], abs=1.0)
            total += w * LENGTH * np.array([1.0, x - 1.0, x]) * strains[p, [0, 1, 1]]
        assert total == pytest.approx(q, abs=1e-9)
        differences = np.empty((3, 3))
        for j, step in enumerate(np.diag([1e-8, 1e-7, 1e-7])):
            plus, minus = (law(bars, q + s * step, state)[0].local[0] for s in (1.0, -1.0))
            differences[:, j] = (plus - minus) / (2.0 * step[j])
        off += np.abs((k - differences) / np.outer(size, size)).max() > 1e-3
    assert off <= 3  # differences across the yield point of a fiber
