"""Springs of lumped columns against closed forms of the elastic beam and against fibers."""

from __future__ import annotations

from dataclasses import replace
from math import inf, pi, sin, sinh, sqrt, tan, tanh

import numpy as np
import pytest
from builders import THESIS_SPRINGS

from workbench.base.errors import OutOfDomainError
from workbench.mechanics.frames.members import shear_stiffness
from workbench.models.elastic_springs import bar_functions, beam_springs
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberShear
from workbench.models.resistance import mechanism_of
from workbench.models.single_dof import SingleDof
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker
from workbench.steel.sections import find

IPE = find("IPE 300").without_fillets()
RIGID = 1e20  # N, shear stiffness


def bending(column: Column) -> float:
    return column.steel.elastic_modulus * column.properties.second_moment


@pytest.mark.parametrize("load", [-9e-4, -1e-4, 1e-4, 9e-4, 0.5, -0.5])
def test_stability_functions_go_over_into_their_series(load: float) -> None:
    u = sqrt(abs(load))
    one, two = 1.0 - u / tan(u), u / sin(u) - 1.0
    if load < 0.0:
        one, two = 1.0 - u / tanh(u), u / sinh(u) - 1.0
    assert bar_functions(load) == pytest.approx((one / load, two / load), rel=1e-7)


def stiffness(column: Column, shear: float) -> float:
    """Of the rigid bars on their springs at the impact point, the axial load included."""
    a, b, c = beam_springs(column, shear), column.length_below, column.length_above
    kappa = 1.0 / b + 1.0 / c
    hinges = 1.0 / a.base / b**2 + kappa**2 / (a.below + a.above) + 1.0 / a.head / c**2
    return hinges - kappa * column.axial_load


def moments(column: Column) -> np.ndarray:
    """Of base, impact point and head under a unit force, without axial load."""
    springs, below, above = beam_springs(column, RIGID), column.length_below, column.length_above
    v = 1.0 / stiffness(column, RIGID)
    turned = np.array([1.0 / below, 1.0 / below + 1.0 / above, 1.0 / above])
    return v * turned / [springs.base, springs.below + springs.above, springs.head]


def test_eccentric_hit_has_the_deflection_and_moments_of_the_clamped_beam() -> None:
    column = Column(IPE, 0.8, 3.2)
    a, b, length = 0.8, 3.2, 4.0
    exact = 3.0 * bending(column) * length**3 / (a * b) ** 3
    assert stiffness(column, RIGID) == pytest.approx(exact, rel=1e-9)
    beam = [a * b**2 / length**2, 2 * a**2 * b**2 / length**3, a**2 * b / length**2]
    np.testing.assert_allclose(moments(column), beam, rtol=1e-9)


def test_propped_and_simple_beams() -> None:
    a, b, length = 1.2, 2.8, 4.0
    propped = Column(IPE, a, b, head="pinned")
    # F = 1 at a from the clamped end: reaction at the prop a^2 (3 L - a) / 2 L^3
    prop = a**2 * (3 * length - a) / (2 * length**3)
    np.testing.assert_allclose(moments(propped), [a - prop * length, prop * b, 0.0], atol=1e-9)
    deflection = a**3 * b**2 * (4 * length - a) / (12 * bending(propped) * length**3)
    assert stiffness(propped, RIGID) == pytest.approx(1.0 / deflection, rel=1e-9)
    simple = Column(IPE, a, b, base="pinned", head="pinned")
    assert beam_springs(simple, RIGID).base == beam_springs(simple, RIGID).head == inf
    exact = 3.0 * bending(simple) * length / (a * b) ** 2
    assert stiffness(simple, RIGID) == pytest.approx(exact, rel=1e-9)


def test_shear_stands_in_series_at_midspan() -> None:
    column = Column(IPE, 1.0, 1.0)
    shear = shear_stiffness(IPE, column.steel)
    series = 2.0**3 / (192.0 * bending(column)) + 2.0 / (4.0 * shear)
    assert stiffness(column, shear) == pytest.approx(1.0 / series, rel=1e-12)
    # panels have the shear in their bars: the springs are then those of bending alone
    sliding, rigid = beam_springs(column, shear, sliding=True), beam_springs(column, RIGID)
    np.testing.assert_allclose(sliding, rigid, rtol=1e-9)
    for model in (FourDof(), FourDofShear(), SingleDof(resistance="analytic")):
        push = model.simulate(ColumnPushover("push", column, 1e-5))
        value = float(push["force"][-1] / push["displacement"][-1])
        assert value == pytest.approx(1.0 / series, rel=0.03)  # the webs of panels are their own


@pytest.mark.parametrize("share", [-0.4, 1e-5, 0.3, 0.9])
def test_axial_load_inside_the_bars(share: float) -> None:
    column = Column(find("IPE 100"), 4.0, 4.0)
    critical = 4.0 * pi**2 * bending(column) / 8.0**2
    load = share * critical
    column = replace(column, axial_load=load)
    # each quarter is a cantilever with half of the force: F / (k P) (tan(kL/4) - kL/4)
    k = sqrt(abs(load) / bending(column))
    tangent = tan(2.0 * k) if load > 0 else np.tanh(2.0 * k)
    exact = k * abs(load) / abs(tangent - 2.0 * k)
    assert stiffness(column, RIGID) == pytest.approx(exact, rel=1e-6 if share > 1e-4 else 3e-4)


def test_near_buckling_a_moment_may_turn_and_the_load_is_left_out() -> None:
    column = Column(find("IPE 100"), 0.5, 5.5, head="pinned")
    none, some, much = (
        beam_springs(replace(column, axial_load=load), RIGID) for load in (0.0, 1e5, 2e5)
    )
    assert much == none != some


@pytest.mark.slow
def test_elastic_hit_is_that_of_the_fiber_beam() -> None:
    column = Column(find("HEB 220").without_fillets(), 0.8, 3.2, restraint_stiffness=1e7)
    impact = ColumnImpact("elastic", column, Striker(1500.0, 0.6), 0.025)
    fiber = float(FiberShear(levels=1).simulate(impact)["peak_displacement"])
    for model, low, high in (
        (FourDof(), 0.97, 1.06),
        (SingleDof(), 0.97, 1.06),
        (FourDofShear(), 0.97, 1.06),
        (FourDof(**THESIS_SPRINGS), 0.0, 0.75),  # no shear, and bars too stiff off the middle
    ):
        peak = float(model.simulate(impact)["peak_displacement"])
        assert low < peak / fiber < high


def test_hinges_yield_on_the_surface_of_the_section() -> None:
    column = Column(find("IPE 330").without_fillets(), 2.0, 2.0, restraint_stiffness=1.6e6)
    column = replace(column, axial_load=0.31 * column.properties.squash_load)
    impact = ColumnImpact("high load", column, Striker(800.0, 8.0), 0.1)
    exact = float(FourDof().simulate(impact)["peak_displacement"])
    section, linear = (
        float(SingleDof(resistance="analytic", interaction=name).simulate(impact)[
            "peak_displacement"
        ])
        for name in ("section", "linear")
    )  # fmt: skip
    assert section == pytest.approx(exact, rel=0.05)
    assert linear > 1.15 * exact  # M_p (1 - N / N_p) throws away a seventh of the moment


def test_elastic_stiffness_that_the_load_has_used_up_is_refused() -> None:
    column = Column(find("IPE 80"), 3.0, 3.0, base="pinned", head="pinned")
    critical = pi**2 * bending(column) / 6.0**2
    assert mechanism_of(replace(column, axial_load=0.98 * critical)).axial_force < 0.0
    with pytest.raises(OutOfDomainError, match="exhausts the lateral stiffness"):
        mechanism_of(replace(column, axial_load=1.02 * critical))
