"""Regression with campaign effects: closed forms, coverage of its intervals, refusals."""

from __future__ import annotations

from dataclasses import replace
from math import erf, sqrt

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.studs.statistics.intervals import (
    Interval,
    Part,
    freedom_of,
    leave_one_campaign_out,
    predictive_quantiles,
    profile_interval,
    scatter_intervals,
    score_relations,
)
from workbench.studs.statistics.mixed import Estimate, Problem, fit, fit_robust, problem

CONFIDENCE = 0.9
MARGIN = 0.03  # of the nominal coverage


def mean_problem(y: np.ndarray, groups: np.ndarray) -> Problem:
    return problem(y, groups, None, ("mean",), [0.0], design=np.ones((len(y), 1)))


def line_problem(y: np.ndarray, x: np.ndarray, groups: np.ndarray) -> Problem:
    design = np.column_stack([np.ones_like(x), x])
    return problem(y, groups, None, ("mean", "slope"), [0.0, 0.0], design=design)


def synthetic(
    generator: np.random.Generator, campaigns: int, tests: int, tau: float, sigma: float
) -> tuple[np.ndarray, np.ndarray]:
    groups = np.repeat(np.arange(campaigns), tests)
    effect = tau * generator.normal(size=campaigns)
    return effect[groups] + sigma * generator.normal(size=len(groups)), groups


def lowest_of(estimate: Estimate) -> float:
    """What 5 % of new tests lie below."""
    part = Part(1.0, estimate, estimate.problem)
    return float(predictive_quantiles([part], [0.05])[0, 0])


def covers(interval: Interval, truth: float) -> bool:
    low = -np.inf if interval.low is None else interval.low
    high = np.inf if interval.high is None else interval.high
    return low <= truth <= high


def test_balanced_one_way_layout_has_the_closed_form() -> None:
    y, groups = synthetic(np.random.default_rng(3), 6, 5, 0.3, 0.1)
    estimate = fit(mean_problem(y, groups))
    means = np.array([y[groups == j].mean() for j in range(6)])
    within = sum(((y[groups == j] - means[j]) ** 2).sum() for j in range(6)) / 24
    between = 5 * np.var(means, ddof=1)
    assert estimate.theta[0] == pytest.approx(y.mean())
    assert estimate.sigma**2 == pytest.approx(within, rel=1.8e-5)  # measured 8.6e-6
    assert estimate.tau**2 == pytest.approx((between - within) / 5, rel=9e-5)  # measured 4.2e-5
    assert estimate.covariance[0, 0] == pytest.approx(between / 30, rel=9e-5)  # measured 4.1e-5
    assert freedom_of(estimate, "mean") == pytest.approx(5.0, rel=1e-8)  # measured: round-off
    interval = profile_interval(estimate, "mean", 0.9)
    half = 2.015048 * sqrt(between / 30)  # t_5(0.95)
    assert (interval.low, interval.high) == pytest.approx(
        (y.mean() - half, y.mean() + half),
        rel=4.8e-5,  # measured 2.4e-5
    )


def test_one_campaign_is_ordinary_least_squares() -> None:
    generator = np.random.default_rng(5)
    x = generator.normal(size=20)
    y = 1.0 + 2.0 * x + 0.3 * generator.normal(size=20)
    estimate = fit(line_problem(y, x, np.zeros(20)))
    slope, intercept = np.polyfit(x, y, 1)
    assert estimate.theta == pytest.approx([intercept, slope])
    assert estimate.tau == 0.0
    residual = y - intercept - slope * x
    assert estimate.sigma == pytest.approx(sqrt((residual**2).sum() / 18))
    interval = profile_interval(estimate, "slope", 0.9)
    half = 1.734064 * estimate.sigma / sqrt(((x - x.mean()) ** 2).sum())  # t_18(0.95)
    assert interval.high - interval.low == pytest.approx(2 * half, rel=5e-7)  # measured 2.3e-7
    assert scatter_intervals(estimate)["tau"].high is None


def test_nonlinear_and_linear_solvers_agree() -> None:
    generator = np.random.default_rng(8)
    y, groups = synthetic(generator, 5, 6, 0.2, 0.1)
    x = generator.normal(size=30)
    y = y + 0.4 * x
    linear = fit(line_problem(y, x, groups))
    general = fit(
        problem(y, groups, lambda p: p[0] + p[1] * x, ("mean", "slope"), [1.0, -1.0],
                lower=-5.0, upper=5.0)
    )  # fmt: skip
    assert general.theta == pytest.approx(linear.theta, abs=2.3e-8)  # measured 1.2e-8
    # measured 4.4e-6
    assert (general.sigma, general.tau) == pytest.approx((linear.sigma, linear.tau), rel=8.7e-6)
    given, other = (profile_interval(e, "slope", 0.9) for e in (general, linear))
    # measured 1.0e-8
    assert (given.low, given.high) == pytest.approx((other.low, other.high), abs=2e-8)


def test_weights_act_like_repeated_rows() -> None:
    y = np.array([1.0, 2.0, 4.0])
    single = replace(mean_problem(y, np.zeros(3)), weights=np.array([2.0, 1.0, 1.0]))
    assert fit(single).theta[0] == pytest.approx((2 * 1.0 + 2.0 + 4.0) / 4.0)


def test_bounds_are_kept_and_told() -> None:
    y = -0.3 + 0.01 * np.arange(6.0)
    estimate = fit(
        problem(y, [0] * 6, lambda p: p[0] * np.ones(6), ("mean",), [0.5], lower=0.0, upper=1.0)
    )
    assert estimate.theta[0] == 0.0
    assert estimate.at_bound.tolist() == [True]
    assert profile_interval(estimate, "mean") == Interval(None, None)


def test_observations_without_scatter_are_no_crash() -> None:
    """Equal loads of every test: the fit is exact, and so are its intervals and predictions."""
    groups = np.repeat(np.arange(4), 3)
    estimate = fit(mean_problem(np.full(12, 0.3), groups))
    assert profile_interval(estimate, "mean") == pytest.approx((0.3, 0.3))
    assert scatter_intervals(estimate)["tau"].high == 0.0
    assert lowest_of(estimate) == pytest.approx(0.3)


def test_campaigns_that_differ_far_beyond_their_scatter_are_followed() -> None:
    """tau / sigma = 10 000: the interval is Student's over the means of the campaigns."""
    groups = np.repeat(np.arange(4), 3)
    means = np.array([0.0, 0.3, -0.2, 0.5])
    y = means[groups] + 3e-5 * np.tile([-1.0, 0.0, 1.0], 4)
    interval = profile_interval(fit(mean_problem(y, groups)), "mean", 0.9)
    half = 2.353363 * np.std(means, ddof=1) / 2.0  # t_3(0.95)
    # measured 1.1e-6
    assert (interval.low, interval.high) == pytest.approx((0.15 - half, 0.15 + half), rel=2.2e-6)


def test_a_known_scatter_of_one_campaign_has_the_closed_interval() -> None:
    """The spread of one campaign says nothing of others: there are no degrees of freedom to ask."""
    y = np.array([0.1, 0.3, 0.2, 0.4, 0.0])
    given = replace(mean_problem(y, np.zeros(5)), between=0.5)
    interval = profile_interval(fit(given), "mean", 0.9)
    assert 0.5 * (interval.low + interval.high) == pytest.approx(0.2)
    assert interval.high - interval.low > 2 * 1.645 * 0.5  # that of the campaign alone


def test_parameters_that_cannot_be_told_are_refused() -> None:
    y, groups = synthetic(np.random.default_rng(1), 3, 4, 0.1, 0.1)
    twin = np.ones((12, 2))
    with pytest.raises(InputError, match="cannot be told apart"):
        fit(problem(y, groups, None, ("a", "b"), [0.0, 0.0], design=twin))
    with pytest.raises(InputError, match="has no influence"):
        fit(problem(y, groups, None, ("a",), [0.0], design=np.zeros((12, 1))))
    with pytest.raises(InputError, match="more than the 2 parameters"):
        fit(problem(y[:2], groups[:2], None, ("a", "b"), [0.0, 0.0], design=twin[:2]))
    with pytest.raises(InputError, match="must be one of mean"):
        profile_interval(fit(mean_problem(y, groups)), "slope")


# The short runs fail what is outside 90 % +- 3 % by more than twice their own error; the long ones
# (--run-slow) allow nothing. What they measured stands in docs/theory/studs-statistics.md.


def allowance(runs: int) -> float:
    """Distance from the nominal coverage that a short run may show."""
    return MARGIN + 2.0 * sqrt(CONFIDENCE * (1.0 - CONFIDENCE) / runs)


def line_coverage(runs: int) -> dict[str, float]:
    """Coverage in ten campaigns of six tests with known parameters and campaign effects."""
    generator = np.random.default_rng(11)
    truth = {"mean": 0.1, "slope": 0.3, "sigma": 0.08, "tau": 0.1}
    hits: dict[str, int] = {}
    for _ in range(runs):
        y, groups = synthetic(generator, 10, 6, truth["tau"], truth["sigma"])
        x = generator.normal(size=len(y))
        estimate = fit(line_problem(y + truth["mean"] + truth["slope"] * x, x, groups))
        for name, interval in profiles(estimate).items():
            hits[name] = hits.get(name, 0) + covers(interval, truth[name])
    return {name: count / runs for name, count in hits.items()}


def profiles(estimate: Estimate) -> dict[str, Interval]:
    named = {name: profile_interval(estimate, name, CONFIDENCE) for name in ("mean", "slope")}
    return {**named, **scatter_intervals(estimate, CONFIDENCE)}


def few_coverage(runs: int, campaigns: int) -> float:
    """Coverage of a median in few campaigns of five tests."""
    generator, hits = np.random.default_rng(14), 0
    for _ in range(runs):
        y, groups = synthetic(generator, campaigns, 5, 0.1, 0.08)
        interval = profile_interval(fit(mean_problem(y, groups)), "mean", CONFIDENCE)
        hits += covers(interval, 0.0)
    return hits / runs


@pytest.mark.thorough
def test_coverage_of_a_line_is_not_off() -> None:
    for name, share in line_coverage(60).items():
        assert abs(share - CONFIDENCE) <= allowance(60), (name, share)


def test_coverage_in_few_campaigns_is_not_off() -> None:
    assert abs(few_coverage(100, 3) - CONFIDENCE) <= allowance(100)


@pytest.mark.slow
def test_nominal_coverage_of_a_line() -> None:
    for name, share in line_coverage(3000).items():
        assert abs(share - CONFIDENCE) <= MARGIN, (name, share)


@pytest.mark.slow
@pytest.mark.parametrize("campaigns", [3, 4, 6])
def test_nominal_coverage_in_few_campaigns(campaigns: int) -> None:
    share = few_coverage(3000, campaigns)
    assert abs(share - CONFIDENCE) <= MARGIN, (campaigns, share)


def nonlinear_coverage(runs: int) -> float:
    generator, truth, hits = np.random.default_rng(12), 0.7, 0
    for _ in range(runs):
        y, groups = synthetic(generator, 6, 6, 0.04, 0.04)
        x = generator.uniform(0.0, 1.0, len(y))
        y = y + np.exp(-truth * x)
        estimate = fit(
            problem(y, groups, lambda p, x=x: np.exp(-p[0] * x), ("rate",), [0.4], lower=0.0,
                    upper=20.0)
        )  # fmt: skip
        hits += covers(profile_interval(estimate, "rate", CONFIDENCE), truth)
    return hits / runs


@pytest.mark.thorough
def test_coverage_of_a_nonlinear_parameter_is_not_off() -> None:
    assert abs(nonlinear_coverage(50) - CONFIDENCE) <= allowance(50)


@pytest.mark.slow
def test_nominal_coverage_of_a_nonlinear_parameter() -> None:
    assert abs(nonlinear_coverage(3000) - CONFIDENCE) <= MARGIN


def test_five_percent_of_new_tests_of_a_new_campaign_lie_below_their_quantile() -> None:
    """Give or take 2, also where campaigns do not differ."""
    for campaigns, tau in ((4, 0.1), (10, 0.1), (10, 0.0)):
        generator = np.random.default_rng(13)
        below = []
        for _ in range(80):
            y, groups = synthetic(generator, campaigns, 6, tau, 0.08)
            estimate = fit(mean_problem(y, groups))
            q = lowest_of(estimate)
            below.append(0.5 * (1.0 + erf(q / sqrt(tau**2 + 0.08**2) / sqrt(2.0))))
        assert 0.03 < np.mean(below) < 0.07, (campaigns, tau)


def test_few_campaigns_are_refused_where_they_do_not_suffice() -> None:
    y, groups = synthetic(np.random.default_rng(4), 2, 6, 0.1, 0.1)
    estimate = fit(mean_problem(y, groups))
    with pytest.raises(InputError, match="3 or more to say anything of a new campaign"):
        lowest_of(estimate)
    assert [each.covered for each in leave_one_campaign_out(estimate.problem)] == [None, None]
    with pytest.raises(InputError, match="two or more to leave one out"):
        leave_one_campaign_out(mean_problem(y[groups == 0], groups[groups == 0]))


def test_leaving_a_campaign_out_finds_the_odd_one() -> None:
    y, groups = synthetic(np.random.default_rng(6), 6, 5, 0.02, 0.05)
    y[groups == 2] += 1.0
    left = {each.campaign: each for each in leave_one_campaign_out(mean_problem(y, groups))}
    assert left["2"].bias == pytest.approx(1.0, abs=0.08)  # measured 0.039
    assert left["2"].covered == 0.0
    assert max(abs(each.bias) for name, each in left.items() if name != "2") < 0.35  # measured 0.27


def test_of_many_campaigns_as_many_as_tell_enough_are_left_out() -> None:
    y, groups = synthetic(np.random.default_rng(6), 120, 1, 0.05, 0.05)
    left = leave_one_campaign_out(mean_problem(y, groups))
    numbers = sorted(int(each.campaign) for each in left)
    assert len(numbers) == 50
    assert max(np.diff(numbers)) <= 8  # evenly through the table, in the order of their names
    covered = np.mean([each.covered for each in left])
    assert 0.8 <= covered <= 1.0


def test_robust_losses_are_not_led_by_outliers() -> None:
    y, groups = synthetic(np.random.default_rng(9), 5, 8, 0.05, 0.05)
    bad = y.copy()
    bad[[3, 17]] += 3.0
    clean: Estimate = fit(mean_problem(y, groups))
    plain = fit_robust(mean_problem(bad, groups), "linear")
    # measured: round-off
    assert plain.theta[0] - clean.theta[0] == pytest.approx(6.0 / 40, abs=1.5e-9)
    for loss in ("huber", "bisquare"):
        robust = fit_robust(mean_problem(bad, groups), loss)
        assert abs(robust.theta[0] - clean.theta[0]) < 0.02  # measured 0.012
        assert robust.sigma < 0.3 * plain.sigma  # measured 0.21
    with pytest.raises(InputError, match="must be one of linear, huber, bisquare"):
        fit_robust(mean_problem(y, groups), "cauchy")


def test_cross_validation_prefers_the_truth_and_then_the_simple() -> None:
    generator = np.random.default_rng(10)
    y, groups = synthetic(generator, 6, 8, 0.05, 0.05)
    x = generator.uniform(0.0, 1.0, len(y))

    def candidates(values: np.ndarray) -> dict[str, Problem]:
        square = np.column_stack([np.ones_like(x), x, x**2])
        return {
            "constant": mean_problem(values, groups),
            "line": line_problem(values, x, groups),
            "parabola": problem(values, groups, None, ("a", "b", "c"), [0.0] * 3, design=square),
        }

    def best(values: np.ndarray) -> str:
        fits = {name: fit(each) for name, each in candidates(values).items()}
        return score_relations(fits)[0].name

    assert best(y) == "constant"
    assert best(y + 0.8 * x) == "line"
    assert best(y + 3.0 * x**2) == "parabola"
