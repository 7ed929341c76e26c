"""Critical velocities against closed forms, and the ratio by one run of the reference."""

from math import exp, inf, log, nan, sqrt

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.extras.uncertainty.critical_velocity import (
    BY_COLLAPSE,
    NEVER,
    NO_ANSWER,
    REACHED,
    Asked,
    DisplacementLimit,
    critical_velocity,
    grows,
    limit_of,
    ratio_to_reference,
    slopes_at,
)
from workbench.models.base import make_model
from workbench.scenarios import Column, ColumnImpact, Striker

ENDS = log(1.0), log(100.0)


def power(scale, exponent):
    """A structure whose peak is scale v**exponent."""
    return lambda x: scale * exp(exponent * x)


@pytest.mark.parametrize("exponent", [0.8, 1.1, 1.9, 3.0])
@pytest.mark.parametrize("start", [0.0, 2.5, 4.6])
def test_power_laws_are_found_exactly(exponent, start):
    root = critical_velocity(power(1e-3, exponent), DisplacementLimit(0.1), start, ENDS)
    known = log(100.0) / exponent
    if known < ENDS[1]:
        assert root.kind == REACHED
        assert root.log_velocity == pytest.approx(known, abs=3e-4)
    else:
        assert root.kind == NEVER


@pytest.mark.parametrize("exponent", [8.0, 14.5, 15.0, 15.9, 60.0])
def test_steep_peaks_are_found_in_few_runs(exponent):
    root = critical_velocity(
        power(0.1 * 30.0**-exponent, exponent), DisplacementLimit(0.1), log(14.0), ENDS
    )
    assert root.kind == REACHED
    assert root.log_velocity == pytest.approx(log(30.0), abs=3e-4)
    assert root.runs <= 10


def test_collapse_in_the_way_is_the_critical_velocity():
    def peak_at(x):
        return inf if x > 2.345 else 1e-3 * exp(1.5 * x)

    for limit in (DisplacementLimit(0.1), DisplacementLimit(inf)):
        root = critical_velocity(peak_at, limit, 1.0, ENDS)
        assert root.kind == BY_COLLAPSE
        assert root.log_velocity == pytest.approx(2.345, abs=2e-4)
    before = critical_velocity(peak_at, DisplacementLimit(0.01), 1.0, ENDS)
    assert before.kind == REACHED
    assert before.log_velocity == pytest.approx(log(10.0) / 1.5, abs=2e-4)


def test_no_answer_is_no_number():
    assert critical_velocity(lambda x: nan, DisplacementLimit(0.1), 1.0, ENDS).kind == NO_ANSWER
    assert critical_velocity(lambda x: 1e-9, DisplacementLimit(0.1), 1.0, ENDS).kind == NEVER


def test_single_dof_meets_its_energy_balance():
    """v* = sqrt(2 (M + m) W(d)) / M, of the resistance W up to the limit."""
    scenario = ColumnImpact(
        "mid", Column("HEB 220", 2.0, 2.0, axial_load=3e5), Striker(1500.0, 8.0), duration=0.2
    )
    model = make_model("single-dof")
    root = critical_velocity(Asked(model, scenario).peak_at, DisplacementLimit(0.1), 2.0, ENDS)
    curve, mass = model.curve(scenario.column), 1500.0
    whole = mass + scenario.column.properties.impact_mass
    known = sqrt(2.0 * whole * float(curve.work(0.1))) / mass
    assert exp(root.log_velocity) == pytest.approx(known, rel=3e-4)


def together(peak_at):
    """A function of ln velocity as many structures are asked."""
    return lambda rows, x: np.array([peak_at(each) for each in x])


ONE = np.zeros(1, int)


def toy(peak_at):
    asked = Asked.__new__(Asked)
    object.__setattr__(asked, "model", None)
    object.__setattr__(asked, "scenario", None)
    object.__setattr__(asked, "peak_at", peak_at)
    return asked


def test_peaks_that_fall_again_are_noticed():
    at = log(100.0) / 1.8
    for peak_at, limit, known in (
        (power(1e-3, 1.8), DisplacementLimit(0.1), True),
        (lambda x: 0.1 * exp(-(x - at)), DisplacementLimit(0.1), False),
        (lambda x: inf, DisplacementLimit(inf), True),
        (lambda x: 0.3, DisplacementLimit(inf), False),
    ):
        assert grows(together(peak_at), ONE, np.array([at]), limit).tolist() == [known]


def test_one_run_gives_the_ratio_of_equal_slopes():
    reduced, reference = power(1e-3, 1.8), toy(power(1.05e-3, 1.8))
    at = log(100.0) / 1.8
    slope = float(slopes_at(together(reduced), ONE, np.array([at]), DisplacementLimit(0.1))[0])
    assert slope == pytest.approx(1.8)
    ratio = ratio_to_reference(reference, slope, DisplacementLimit(0.1), at, ENDS)
    assert ratio.runs == 1
    assert ratio.value == pytest.approx(-log(1.05) / 1.8, abs=1e-9)


def test_a_far_reference_is_run_twice():
    reference = toy(lambda x: 0.115 * exp(2.0 * (x - at)))
    at = log(100.0) / 1.8
    ratio = ratio_to_reference(reference, 1.8, DisplacementLimit(0.1), at, ENDS)
    assert ratio.runs == 2
    assert ratio.value == pytest.approx(-log(1.15) / 2.0, abs=1e-3)


def test_a_reference_that_collapses_is_followed_to_its_limit():
    at = log(100.0) / 1.8
    reference = toy(lambda x: inf if x > at - 0.07 else 1e-3 * exp(1.8 * x))
    ratio = ratio_to_reference(reference, 1.8, DisplacementLimit(0.1), at, ENDS)
    assert ratio.value == pytest.approx(-0.07, abs=2e-3)


def test_a_reference_that_fails_is_asked_aside_and_else_has_no_ratio():
    at = log(100.0) / 1.8
    once = toy(lambda x: nan if abs(x - at) < 1e-6 else 1.02e-3 * exp(1.8 * x))
    ratio = ratio_to_reference(once, 1.8, DisplacementLimit(0.1), at, ENDS)
    assert ratio.runs == 2
    assert ratio.value == pytest.approx(-log(1.02) / 1.8, abs=1e-6)
    never = ratio_to_reference(toy(lambda x: nan), 1.8, DisplacementLimit(0.1), at, ENDS)
    assert never.value != never.value
    assert never.reason == NO_ANSWER


def test_slopes_are_one_sided_below_a_collapse_and_none_without_an_answer():
    at = log(100.0) / 1.8

    def slope_of(peak_at):
        return slopes_at(together(peak_at), ONE, np.array([at]), DisplacementLimit(0.1))[0]

    assert slope_of(lambda x: inf if x > at else 1e-3 * exp(1.8 * x)) == pytest.approx(1.8)
    assert np.isnan(slope_of(lambda x: nan))
    assert np.isnan(
        slopes_at(together(power(1e-3, 1.8)), ONE, np.array([at]), DisplacementLimit(inf))[0]
    )


@pytest.mark.parametrize("text", ["displacement", "drift=0.1", "displacement=fast", "0.1"])
def test_wrong_limits_are_refused(text):
    with pytest.raises(InputError, match="--limit"):
        limit_of(text)


def test_limits_have_units():
    assert limit_of("displacement=100 mm") == limit_of("displacement=0.1") == DisplacementLimit(0.1)
    assert limit_of("collapse") == DisplacementLimit(inf)
