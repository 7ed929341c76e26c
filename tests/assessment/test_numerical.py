"""Ladders with known limits, and comparison errors of ASME V&V 20."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.responses.convergence import best_law
from workbench.responses.uncertainty import (
    FIBERS,
    SPACE,
    SPACE_AND_STEPS,
    STEPS,
    combined,
    estimate,
    fiber_direction,
    step_direction,
)
from workbench.study.assessment import METRICS, ladder


@given(
    limit=st.floats(0.1, 10.0),
    slope=st.floats(-5.0, 5.0).filter(lambda x: abs(x) > 1e-3),
    order=st.sampled_from([1.0, 2.0]),
    ratio=st.sampled_from([1.5, 2.0, 3.0]),
)
def test_a_power_law_is_extrapolated_to_its_limit(limit, slope, order, ratio):
    values = [limit + slope * ratio ** (-order * k) for k in range(4)]
    result = ladder(values, ratio, order)
    assert result.order == pytest.approx(order, rel=1e-6)
    assert result.extrapolated == pytest.approx(limit, rel=1e-6)
    assert result.uncertainty == pytest.approx(1.25 * abs(values[-1] - limit), rel=1e-5)
    assert result.relative == pytest.approx(result.uncertainty / abs(values[-1]))
    assert result.accepted


def test_a_ladder_worked_by_hand():
    result = ladder([5.863, 5.972, 6.0265], 2.0, 1.0)
    assert result.order == pytest.approx(1.0, rel=1e-9)
    assert result.extrapolated == pytest.approx(6.0265 + 0.0545, rel=1e-9)
    assert result.uncertainty == pytest.approx(1.25 * 0.0545, rel=1e-9)


def test_orders_inside_the_accepted_range_are_clipped():
    values = [0.0, 1.0, 1.0 + 2.0**-0.75]
    result = ladder(values)
    assert result.order == pytest.approx(0.75)
    assert result.factor == 1.25
    assert result.extrapolated == pytest.approx(values[-1] + 2.0**-0.75 / (2.0**0.8 - 1.0))


@pytest.mark.parametrize("order", [0.2, 0.5, 1.6, 3.0])
def test_orders_outside_the_accepted_range_get_the_cautious_factor(order):
    limit, values = 5.0, [5.0 + 2.0 ** (-order * k) for k in range(3)]
    result = ladder(values)
    assert result.factor == 3.0
    assert result.converging
    assert not result.accepted
    assert result.uncertainty >= abs(values[-1] - limit)  # measured 1.08 times at order 0.2
    assert "safety factor 3" in result.note


def test_oscillating_and_diverging_ladders_say_so():
    swinging = ladder([1.0, 1.2, 1.1])
    assert swinging.order is None
    assert not swinging.converging
    assert swinging.uncertainty == pytest.approx(0.6)
    assert "oscillate" in swinging.note
    growing = ladder([1.0, 1.1, 1.3])
    assert not growing.converging
    assert growing.uncertainty == pytest.approx(0.9)
    assert "do not converge" in growing.note


def test_two_levels_assume_the_expected_order():
    result = ladder([1.2, 1.1])
    assert result.extrapolated == pytest.approx(1.0)
    assert result.uncertainty == pytest.approx(0.3)
    assert result.order is None
    assert "two levels" in result.note


def test_levels_that_agree():
    assert ladder([2.0, 2.0, 2.0]).uncertainty == 0.0
    by_chance = ladder([1.0, 2.0, 2.0])
    assert by_chance.uncertainty == pytest.approx(0.5)
    assert not by_chance.accepted


@pytest.mark.parametrize("ratio", [0.25, 0.5, 2.0, 3.0])
def test_more_or_fewer_layers_tell_the_same_error_of_first_order(ratio):
    runs = {"answer": 1.0 + 0.2, "other": 1.0 + 0.2 / ratio}
    result = estimate([fiber_direction("answer", "other", ratio)], runs)
    assert result.width == pytest.approx(1.25 * 0.2)


def test_half_the_steps_tell_the_error_of_the_answer():
    # the answer has a quarter of the steps of the coarsest run: an error of 0.1 there
    runs = {"coarsest": 1.4, "halved": 1.2}
    result = estimate([step_direction("coarsest", "halved", 4.0, 1.25)], runs)
    assert result.width == pytest.approx(1.25 * 0.1)


def test_widths_of_all_directions_add_up_and_steps_do_not_count_twice():
    assert combined({SPACE: 0.1, FIBERS: 0.2, STEPS: 0.3}) == pytest.approx(0.6)
    assert combined({SPACE_AND_STEPS: 0.1, STEPS: 0.3, FIBERS: 0.2}) == pytest.approx(0.5)
    assert combined({SPACE_AND_STEPS: 0.3, STEPS: 0.1, FIBERS: 0.2}) == pytest.approx(0.5)
    assert combined({SPACE: 0.1, FIBERS: None}) is None
    assert combined({}) is None


def test_what_levels_scatter_widens_the_interval():
    """Eca and Hoekstra: beside the extrapolation, the scatter and what the fit misses."""
    scattered = [1.8001, 1.3995, 1.2004, 1.1006, 1.0490]
    fit, _ = best_law(scattered, 2.0, 1.0)
    result, missed = ladder(scattered), abs(scattered[-1] - fit.finest)
    assert min(fit.deviation, missed) > 1e-4
    width = 1.25 * abs(fit.finest - fit.limit) + fit.deviation + missed
    assert result.uncertainty == pytest.approx(width, rel=1e-9)


@pytest.mark.parametrize(
    ("values", "ratio"), [([1.0], 2.0), ([1.0, float("nan")], 2.0), ([1.0, 2.0], 1.0)]
)
def test_unusable_ladders_are_refused(values, ratio):
    with pytest.raises(InputError, match="ladder"):
        ladder(values, ratio)


def test_uncertainties_combine_by_the_root_of_squares():
    given = 1.1, 1.0, 0.03, 0.04
    assert METRICS["difference"].half_width(*given) == pytest.approx(0.05)
    relative = METRICS["relative_error"].half_width(*given)
    assert relative == pytest.approx(np.hypot(0.03, 1.1 * 0.04))
    logarithm = METRICS["log_ratio"].half_width(2.0, 0.5, 0.06, 0.02)
    assert logarithm == pytest.approx(np.hypot(0.03, 0.04))


def test_unknown_errors():
    assert METRICS["difference"].half_width(1.0, 2.0, 0.0, None) is None
    assert METRICS["relative_error"].half_width(1.0, 0.0, 0.0, 0.0) is None
    with pytest.raises(InputError, match="negative"):
        METRICS["difference"].half_width(1.0, 1.0, 0.0, -1.0)
