"""Tri-linear, Yin-Wang and Izzuddin: closed forms of symmetric beams, limits, our own curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from workbench.extras.practice.catenary import (
    Izzuddin,
    TrilinearCatenary,
    YinWang,
    profile,
    rigid_plastic,
)
from workbench.mechanics.frames.members import shear_stiffness
from workbench.models.energy_estimate import energy_to_absorb
from workbench.models.resistance import axial_flexibility, mechanism_of, resistance_curve
from workbench.models.resistance.curve import LINEAR
from workbench.models.resistance.shapes import beam_of
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find

MODELS = (TrilinearCatenary(), YinWang(), Izzuddin())
SPAN, SPRING = 4.0, 1e8


@pytest.fixture(scope="module")
def beam() -> Column:
    """Simply supported and symmetric, restrained along its axis, without axial force."""
    half = SPAN / 2.0
    return Column(
        find("HEB 220"), half, half, base="pinned", head="pinned", restraint_stiffness=SPRING
    )


def stiffness(column: Column) -> float:
    """Force in the middle per displacement: bending, and the shear of the web."""
    EI = column.steel.elastic_modulus * column.properties.second_moment
    shear = shear_stiffness(column.strength_section, column.steel)
    return 1.0 / (SPAN**3 / (48.0 * EI) + SPAN / (4.0 * shear))


def strengths(column: Column) -> tuple[float, float, float]:
    properties = column.properties
    return properties.plastic_moment, properties.squash_load, axial_flexibility(column)


@pytest.mark.claim("model:izzuddin", "force of a pinned beam, ratio", "izzuddin2005", 1, 1e-9)
def test_izzuddin_in_closed_form(beam, claim) -> None:
    Mp, Np, c = strengths(beam)
    curve, r = Izzuddin().curve(beam), Mp / Np
    assert curve.initial_stiffness == pytest.approx(stiffness(beam))
    assert float(curve.force(0.9 * r)) == pytest.approx(4.0 * Mp / SPAN, rel=1e-9)  # bending
    ends = r + np.sqrt(0.5 * SPAN * c * Np)
    for v in np.linspace(1.05 * r, 0.999 * ends, 5):  # transient: N = (2/L) (v - r)^2 / c
        N = 2.0 / SPAN * (v - r) ** 2 / c
        expected = 4.0 / SPAN * (Mp * (1.0 - N / Np) + N * v)
        claim(curve.force(v) / expected)
        assert float(curve.axial_force(v)) == pytest.approx(N, rel=1e-9)
    assert float(curve.force(1.2 * ends)) == pytest.approx(4.0 * Np * 1.2 * ends / SPAN)  # rope


@pytest.mark.claim("model:yin-wang", "force of a pinned beam, ratio", "yin-wang2005", 1, 1e-9)
def test_yin_wang_in_closed_form(beam, claim) -> None:
    Mp, Np, c = strengths(beam)
    stretching = beam_of(beam).stages(np.full(3, Mp))[0].shape.stretching
    assert stretching == pytest.approx(2.4 / SPAN)  # of 3 z - 4 z^3, z = x / L
    curve = YinWang().curve(beam)
    yields, taut = curve.starts[1:]
    assert taut == pytest.approx(np.sqrt(Np * c * SPAN / 2.4))
    for v in (0.5 * yields, 1.5 * yields, 0.7 * taut, 1.3 * taut):
        N = min(2.4 * v**2 / (SPAN * c), Np)
        M = min(0.25 * SPAN * stiffness(beam) * v, Mp * (1.0 - N / Np))
        claim(curve.force(v) / (4.0 / SPAN * (M + N * v)))


@pytest.mark.claim("model:trilinear-catenary", "start of rope, ratio", "independent code", 1, 1e-9)
def test_trilinear_meets_the_analytic_curve_where_lines_meet(thesis_impact, claim) -> None:
    for column in (thesis_impact.column, replace(thesis_impact.column, axial_load=0.0)):
        curve = TrilinearCatenary().curve(column)
        exact = resistance_curve(mechanism_of(column, interaction=LINEAR), "analytic")
        places = {event.name: event.displacement for event in exact.events}
        assert curve.starts[2] == pytest.approx(places["tension grows"], rel=0.03)
        claim(curve.starts[3] / places["catenary"])
        rope = curve.mechanism.slope_sum * column.properties.squash_load
        for v in (curve.starts[3], 1.0):
            assert float(curve.force(v)) == pytest.approx(rope * v, rel=1e-12)


def test_hinges_that_turn_with_the_mechanism_are_the_rigid_limit(thesis_impact) -> None:
    mechanism = mechanism_of(thesis_impact.column, interaction=LINEAR)
    stiff = mechanism._replace(flexibilities=1e-6 * mechanism.flexibilities)
    v = np.linspace(0.01, 0.7, 50)
    exact, ours = resistance_curve(stiff, "analytic").force(v), rigid_plastic(stiff).force(v)
    np.testing.assert_allclose(ours, exact, rtol=1e-5)
    drawn = np.linspace(0.3, 0.7, 5)  # tension grows: (c + r^2 sum phi) / c as fast
    r = mechanism.plastic_moment / mechanism.squash_load
    faster = 1.0 + r**2 * mechanism.flexibilities.sum() / mechanism.axial_flexibility
    rates = [
        np.diff(curve.axial_force(drawn))
        for curve in (rigid_plastic(mechanism), resistance_curve(mechanism, "analytic"))
    ]
    np.testing.assert_allclose(rates[0] / rates[1], faster, rtol=1e-9)
    assert faster == pytest.approx(1.009, abs=1e-3)


def test_a_profile_without_moments_is_the_rope_of_the_analytic_curve(beam) -> None:
    mechanism = mechanism_of(beam, interaction=LINEAR)
    slack = mechanism._replace(plastic_moment=1e-6 * mechanism.plastic_moment)
    v = np.linspace(0.01, 0.4, 40)
    ours = profile(slack, 0.5 * mechanism.slope_sum).force(v)
    np.testing.assert_allclose(ours, resistance_curve(slack, "analytic").force(v), rtol=1e-4)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_curves_of_drawn_columns_are_continuous_and_end_in_the_rope(model) -> None:
    random = np.random.default_rng(7)
    for _ in range(40):
        low = float(random.uniform(0.15, 0.85))
        spring = float(10.0 ** random.uniform(6.0, 9.0)) * float(random.random() < 0.8)
        column = Column(
            find("HEB 220"),
            4.0 * low,
            4.0 * (1.0 - low),
            base=str(random.choice(["clamped", "pinned"])),
            head=str(random.choice(["guided", "pinned", "fixed"])),
            restraint_stiffness=spring,
            axial_load=float(random.uniform(-5e5, 1e6) * (random.random() < 0.7)),
        )
        curve = model.curve(column)
        starts = curve.starts[1:]
        assert np.all(np.diff(curve.starts) > 0.0)
        assert np.all(np.isfinite(curve.pieces["c"]))
        before, after = curve.force(starts * (1.0 - 1e-12)), curve.force(starts)
        np.testing.assert_allclose(before, after, rtol=1e-8)
        if spring > 0.0 or column.head == "fixed":
            far = 2.0 * starts[-1]
            rope = curve.mechanism.slope_sum * column.properties.squash_load * far
            assert float(curve.force(far)) == pytest.approx(rope, rel=1e-9)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_impacts_go_as_far_as_their_energy(model, beam) -> None:
    impact = ColumnImpact("hit", beam, Striker(1500.0, 12.0), 0.15)
    expected = model.curve(beam).displacement_at(energy_to_absorb(impact))
    peak = float(model.simulate(impact)["peak_displacement"])
    assert peak == pytest.approx(expected, rel=1e-4)
