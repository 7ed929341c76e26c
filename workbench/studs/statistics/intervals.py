"""Intervals of a fitted mixed model: profile likelihood; and of the ratio of two scatters.

Profile: a parameter is held, all others and the ratio of variances are fitted anew, and the
interval is where the restricted criterion rises by (nu + 1) ln(1 + t^2 / nu), t the Student
quantile with nu degrees of freedom after Satterthwaite. For balanced data this is the exact
interval; with many campaigns it becomes the usual chi-squared one. With two campaigns it covers
less than it says, as nothing then tells how much campaigns differ.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from workbench.errors import SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import Estimate, best_ratio, criteria_at
from workbench.studs.statistics.problem import jacobian, whiten

LEAST_FREEDOM = 1.0
BRACKETINGS = 40
LARGEST_RATIO, RATIOS, RATIO_SHIFT = 1000.0, 80, 0.05  # of r = tau / sigma and its spline
DENSE = 1500  # points over which the smooth criterion is searched
PROFILE = "profile likelihood"


class Interval(NamedTuple):
    """An interval: `low` to `high` at `confidence`, by `method`; None where it is open."""

    low: float | None
    high: float | None
    confidence: float
    method: str

    def exponential(self) -> Interval:
        """The interval of a quantity whose logarithm was fitted."""
        low, high = (None if end is None else float(np.exp(end)) for end in self[:2])
        return self._replace(low=low, high=high)


def tails_of(share: float) -> tuple[float, float]:
    """The shares below and above which equal parts of the rest lie."""
    return 0.5 - 0.5 * share, 0.5 + 0.5 * share


def freedom_of(estimate: Estimate, name: str) -> float:
    """Satterthwaite's degrees of freedom behind the variance g(sigma^2, tau^2) of a parameter.

    nu = 2 g^2 / (grad g' C grad g) with C the inverse expected information of (sigma^2, tau^2) in
    the restricted likelihood. With tau at zero, of sigma^2 alone; with one test per campaign of
    their sum. Source: Giesbrecht and Burns 1985, as in lmerTest.
    """
    given, column = estimate.problem, estimate.problem.index(name)
    if estimate.at_bound[column]:
        return LEAST_FREEDOM
    s2, t2 = estimate.sigma**2, estimate.tau**2
    free = np.flatnonzero(~estimate.at_bound)
    if not given.tells_campaigns or t2 <= 1e-8 * s2:
        return float(max(given.count - len(free), LEAST_FREEDOM))
    k = int(np.searchsorted(free, column))
    x = jacobian(given, estimate.theta, free)

    def variance(s2: float, t2: float) -> float:
        """That of the parameter for other variances, at the same parameters."""
        j = whiten(given, x, t2 / s2)
        return float(s2 * np.linalg.pinv(j.T @ j)[k, k])

    indicator = (given.groups[:, None] == np.arange(given.campaigns)).astype(float)
    between, within = indicator @ indicator.T, np.diag(1.0 / given.weights)
    inverse = np.linalg.inv(s2 * within + t2 * between)
    ix = inverse @ x
    p = inverse - ix @ np.linalg.pinv(x.T @ ix) @ ix.T
    pw, pb = p @ within, p @ between
    information = 0.5 * np.array([[np.sum(a * b.T) for b in (pw, pb)] for a in (pw, pb)])
    rises = [
        (variance(s2 * 1.001, t2) - variance(s2 * 0.999, t2)) / (0.002 * s2),
        (variance(s2, t2 * 1.001) - variance(s2, t2 * 0.999)) / (0.002 * t2),
    ]
    spread = float(rises @ np.linalg.solve(information, rises))
    return max(2.0 * variance(s2, t2) ** 2 / spread, LEAST_FREEDOM)


def profile_interval(estimate: Estimate, name: str, confidence: float = 0.9) -> Interval:
    """Profile-likelihood interval of a parameter; a bound that stops the search is left open.

    Raises `InputError` for an unknown parameter, `SolverError` if the profile cannot be followed.
    """
    from scipy.special import stdtrit

    given = estimate.problem
    k = given.index(name)
    centre = float(estimate.theta[k])
    if estimate.is_exact:
        return Interval(centre, centre, confidence, PROFILE)
    nu = freedom_of(estimate, name)
    t = float(stdtrit(nu, 0.5 + 0.5 * confidence))
    rise = (nu + 1.0) * np.log1p(t * t / nu)
    others = np.delete(np.arange(len(given.names)), k)
    error = np.sqrt(estimate.covariance[k, k])
    if not (np.isfinite(error) and error > 0.0):
        return Interval(None, None, confidence, PROFILE)
    near = estimate.ratio

    @cache
    def held_at(value: float) -> float:
        nonlocal near
        theta = estimate.theta.copy()
        theta[k] = value
        near, criterion, _ = best_ratio(given, theta, others, near)
        return criterion

    # the restricted criterion has its minimum near, not exactly at, the estimate
    least = min(held_at(centre + step * error) for step in (-0.1, 0.0, 0.1))

    def excess(value: float) -> float:
        # the root of a nearly quadratic rise is nearly linear: few steps to its crossing
        return float(np.sqrt(max(held_at(value) - least, 0.0)) - np.sqrt(rise))

    sides = ((-1.0, given.lower[k]), (1.0, given.upper[k]))
    low, high = (_crossing(excess, centre, sign * t * error, float(end)) for sign, end in sides)
    return Interval(low, high, confidence, PROFILE)


def _crossing(
    excess: Callable[[float], float], centre: float, step: float, bound: float
) -> float | None:
    """Where a function that is negative at the centre crosses zero on one side; None if nowhere."""
    from scipy.optimize import brentq

    near, far = centre, centre + step
    for _ in range(BRACKETINGS):
        beyond = far <= bound if step < 0.0 else far >= bound
        if beyond:
            far = bound
        try:
            value = excess(far)
        except SolverError:
            far = 0.5 * (near + far)
            step *= 0.5
            continue
        if value > 0.0:
            inner = centre if near == centre else near
            return float(brentq(excess, inner, far, xtol=1e-4 * abs(step), rtol=1e-8))
        if beyond:
            return None
        near, far = far, far + step
        step *= 1.6
    return None


def scatter_intervals(estimate: Estimate, confidence: float = 0.9) -> dict[str, Interval]:
    """Profile intervals of ``sigma`` and ``tau`` from the restricted likelihood.

    tau may reach zero (low = 0); its upper end is open with one campaign.
    """
    from scipy.interpolate import CubicSpline
    from scipy.special import chdtri

    if estimate.is_exact:
        return dict.fromkeys(("sigma", "tau"), Interval(0.0, 0.0, confidence, PROFILE))
    given, s, rise = estimate.problem, estimate.sigma, float(chdtri(1.0, 1.0 - confidence))
    free = np.flatnonzero(~estimate.at_bound)
    m, several = given.count - len(free), given.campaigns > 1
    # at the best parameters, with r = tau / sigma: rest(r) + m ln(sigma^2) + size(r) / sigma^2
    r = np.concatenate([[0.0], np.geomspace(0.02, LARGEST_RATIO, RATIOS)])[: None if several else 1]
    values, variance = criteria_at(given, r * r, estimate.theta, free)
    parts = np.column_stack([values - m - m * np.log(variance), np.log(variance * m)])
    x = np.log(r + RATIO_SHIFT)
    spline = CubicSpline(x, parts) if several else None
    dense = parts.T if spline is None else spline(np.linspace(x[0], x[-1], DENSE)).T

    def least(log_s2: Array | float, parts: Array) -> float:
        rest, log_size = parts
        return float(np.min(rest + m * log_s2 + np.exp(log_size - log_s2)))

    def of_sigma(sigma: float) -> float:
        return least(2.0 * np.log(sigma), dense)

    lowest = of_sigma(s)
    if several:
        lowest = min(of_sigma(float(v)) for v in np.exp(np.linspace(-1.0, 1.0, 81)) * s)
    low, high = (
        _crossing(lambda v: of_sigma(np.exp(v)) - lowest - rise, np.log(s), step, bound)
        for step, bound in ((-0.3, -np.inf), (0.3, np.inf))
    )
    sigma = Interval(low, high, confidence, PROFILE).exponential()
    if spline is None:
        return {"sigma": sigma, "tau": Interval(0.0, None, confidence, PROFILE)}
    log_s2 = 2.0 * np.log(s) + np.linspace(-4.0, 4.0, DENSE)

    def of_tau(tau: float) -> float:
        ratio = np.minimum(tau / np.exp(0.5 * log_s2), LARGEST_RATIO)
        return least(log_s2, spline(np.log(ratio + RATIO_SHIFT)).T)

    step = max(estimate.tau, 0.2 * s)
    lowest_tau, highest = (
        _crossing(lambda v: of_tau(v) - lowest - rise, estimate.tau, sign * step, bound)
        for sign, bound in ((-1.0, 0.0), (1.0, np.inf))
    )
    return {"sigma": sigma, "tau": Interval(lowest_tau or 0.0, highest, confidence, PROFILE)}


LIKE = 1.01  # ratio of scatters that is no difference: an interval must lie above it
_EQUAL = 1e-12  # of squares of logarithms


def rank_scatters(tests: Mapping[str, Any], confidence: float) -> tuple[str, list[dict[str, Any]]]:
    """The formula of least scatter within campaigns, among equals the first, and its rivals.

    `tests`: rows with campaign, specimen and ratio, test over prediction, by formula; those count
    that every formula has a value for. A rival: `name`, `ratio` of its scatter to the least one
    with its interval `low`, `high` (None with too few tests), and `apart`, whether that lies above
    `LIKE`. Source: Pitman 1939, standard deviations of correlated normal variables.
    """
    from scipy.special import stdtrit

    key = ["campaign", "specimen"]
    ratios = {name: pd.DataFrame(rows).set_index(key)["ratio"] for name, rows in tests.items()}
    logs = pd.DataFrame(ratios).dropna().apply(np.log)
    campaigns = logs.groupby(level="campaign")
    left, nu = logs - campaigns.transform("mean"), len(logs) - campaigns.ngroups - 1
    products = left.T.to_numpy() @ left.to_numpy()
    squares = np.diag(products)
    best = int(np.flatnonzero(squares <= squares.min() + _EQUAL)[0])
    rivals: list[dict[str, Any]] = []
    for k in (k for k in range(len(squares)) if k != best):
        ends: tuple[float | None, ...] = (None, None, None)
        apart = False
        if nu > 0 and squares[best] > _EQUAL:
            ratio = float(np.sqrt(squares[k] / squares[best]))
            open_ = max(1.0 - products[k, best] ** 2 / (squares[k] * squares[best]), 0.0)
            wide = 1.0 + 2.0 * open_ * float(stdtrit(nu, 0.5 + 0.5 * confidence)) ** 2 / nu
            factor = float(np.sqrt(wide + np.sqrt(wide**2 - 1.0)))
            ends, apart = (ratio, ratio / factor, ratio * factor), ratio / factor > LIKE
        told = dict(zip(("ratio", "low", "high"), ends, strict=True))
        rivals.append({"name": str(left.columns[k]), **told, "apart": apart})
    return str(left.columns[best]), rivals
