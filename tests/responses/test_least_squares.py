"""The fit to four levels or more: exact laws, an independent fit, scatter, and its coverage."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import curve_fit

from workbench.responses.convergence import best_law, ladder

SIZES = 2.0 ** np.arange(3.0, -1.0, -1.0)


@given(
    limit=st.floats(-10.0, 10.0),
    slope=st.floats(0.01, 5.0),
    share=st.floats(0.55, 1.05),
    expected=st.sampled_from([1.0, 2.0]),
    levels=st.integers(4, 6),
)
def test_a_power_law_is_met_exactly(limit, slope, share, expected, levels) -> None:
    order = share * expected
    values = [limit + slope * 2.0 ** (-order * k) for k in range(levels)]
    estimate = ladder(values, 2.0, expected)
    error = values[-1] - limit
    assert estimate.order == pytest.approx(order, rel=1e-3)
    assert estimate.extrapolated == pytest.approx(limit, abs=1e-3 * abs(error))
    assert estimate.uncertainty == pytest.approx(1.25 * abs(error), rel=5e-3)
    assert estimate.factor == 1.25
    assert estimate.accepted


def test_scattered_values_agree_with_an_independent_fit() -> None:
    values = 2.0 + 0.3 * SIZES**0.9 + np.array([0.004, -0.006, 0.003, 0.002])

    def law(h, limit, slope, order):
        return limit + slope * h**order

    estimate, fit_found = ladder(list(values)), best_law(list(values), 2.0, 1.0)[0]
    best = np.inf
    for weight in (np.ones(4), 4.0 / SIZES / np.sum(1.0 / SIZES)):
        fit = curve_fit(law, SIZES, values, p0=(2.0, 0.3, 1.0), sigma=weight**-0.5, xtol=1e-14)[0]
        missed = values - law(SIZES, *fit)
        deviation = float(np.sqrt(np.sum(weight * missed**2)))  # one degree of freedom is left
        if deviation < best:
            best, (limit, slope, order), last = deviation, fit, abs(missed[-1])
    assert estimate.order == pytest.approx(order, rel=1e-8)  # measured 3.5e-10
    assert estimate.extrapolated == pytest.approx(limit, rel=1e-8)  # measured 1.3e-10
    assert fit_found.deviation == pytest.approx(best, rel=1e-8)  # measured: round-off
    # measured 6.7e-10
    assert estimate.uncertainty == pytest.approx(1.25 * slope + best + last, rel=1e-8)


@pytest.mark.parametrize("order", [1.6, 2.0, 3.0])
def test_faster_than_expected_counts_as_expected(order) -> None:
    values = [1.0 + 2.0 ** (-order * k) for k in range(4)]
    estimate = ladder(values)
    assert estimate.order == pytest.approx(order, rel=1e-8)  # measured 2.8e-9
    assert estimate.factor == 3.0
    assert not estimate.accepted
    assert estimate.converging
    # a h fitted instead: far more than the true error
    assert estimate.uncertainty > 3.0 * abs(values[-1] - 1.0)


def test_slower_than_expected_is_not_relied_on() -> None:
    values = [1.0 + 2.0 ** (-0.2 * k) for k in range(4)]
    estimate = ladder(values)
    assert estimate.order == pytest.approx(0.2, rel=1.5e-8)  # measured 7.2e-9
    assert estimate.factor == 3.0
    assert "outside 0.5 to 1.1 of the expected" in estimate.note
    assert estimate.uncertainty > 3.0 * abs(values[-1] - values[-2])


def test_values_that_swing_or_run_away_do_not_converge() -> None:
    for values in ([1.0, 1.2, 1.05, 1.15], [1.0, 1.1, 1.3, 1.7]):
        estimate = ladder(values)
        assert not estimate.converging
        assert not estimate.accepted
        assert estimate.uncertainty > abs(values[-1] - values[-2])
    assert "power law" in ladder([1.0, 1.1, 1.3, 1.7]).note


def test_levels_that_agree() -> None:
    assert ladder([2.0, 2.0, 2.0, 2.0]).uncertainty == 0.0
    assert ladder([2.0, 2.0, 2.0, 2.1]).uncertainty > 0.1


@pytest.mark.thorough
def test_the_interval_holds_the_limit_in_19_of_20_sequences() -> None:
    """Two powers and 5 % of scatter: what four meshes of a method of first order look like."""
    rng = np.random.default_rng(2014)
    held = []
    for _ in range(400):
        first, second = 1.0, rng.uniform(-0.05, 0.05)
        scatter = 0.05 * rng.uniform(-1.0, 1.0, 4)
        values = first * SIZES + second * SIZES**2 + scatter * SIZES
        estimate = ladder(list(values))
        held.append(abs(values[-1]) <= estimate.uncertainty)
    assert np.mean(held) >= 0.95
