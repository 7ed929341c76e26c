"""Intervals of a fitted mixed model by profile likelihood, and fractiles of new tests by a mixture.

Profile: a parameter is held, all others and the ratio of variances are fitted anew, and the
interval is where the restricted criterion rises by (nu + 1) ln(1 + t^2 / nu), t the Student
quantile with nu degrees of freedom after Satterthwaite. For balanced data this is the exact
interval; with many campaigns it becomes the usual chi-squared one. With two campaigns it covers
less than it says, as nothing then tells how much campaigns differ.

Mixture: given the ratio of variances lambda, parameters and new tests are Student-distributed. As
few campaigns hardly tell lambda, its restricted likelihood is integrated over sqrt(lambda) with the
weakly informative half-Cauchy density that Gelman 2006 recommends for few groups. With fewer than
three campaigns the assumed density would decide, so nothing is said of new campaigns then.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import (
    ROUND_OFF,
    Estimate,
    best_ratio,
    criteria_at,
    criterion_at,
)
from workbench.studs.statistics.problem import Indices, Problem, jacobian, whiten

LEAST_FREEDOM = 1.0
BRACKETINGS = 40
LARGEST_RATIO, RATIOS, RATIO_SHIFT = 1000.0, 80, 0.05  # of r = tau / sigma and its spline
DENSE = 1500  # points over which the smooth criterion is searched
LEAST_CAMPAIGNS = 3  # that tell how much campaigns differ
MIXED, POINTS = 100.0, 80  # largest tau / sigma of a mixture, beyond which no likelihood is left
# scale of the half-Cauchy density of tau over sigma: 3 to 6.5 % of new tests lie below the 5 %
# fractile of three campaigns or more where the ratio is 0.4 to 2
USUAL_RATIO = 1.0


class Interval(NamedTuple):
    """An interval from `low` to `high`; None where it is open."""

    low: float | None
    high: float | None

    def exponential(self) -> Interval:
        """The interval of a quantity whose logarithm was fitted."""
        return Interval(*(None if end is None else float(np.exp(end)) for end in self))


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
        return Interval(centre, centre)
    nu = freedom_of(estimate, name)
    t = float(stdtrit(nu, 0.5 + 0.5 * confidence))
    rise = (nu + 1.0) * np.log1p(t * t / nu)
    others = np.delete(np.arange(len(given.names)), k)
    error = np.sqrt(estimate.covariance[k, k])
    if not (np.isfinite(error) and error > 0.0):
        return Interval(None, None)
    near = estimate.ratio

    @cache
    def held_at(value: float) -> float:
        nonlocal near
        theta = estimate.theta.copy()
        theta[k] = value
        near, criterion, _ = best_ratio(given, theta, others, near)
        return criterion

    # the restricted criterion has its minimum near, not exactly at, the estimate
    lowest = min((centre + step * error for step in (-0.1, 0.0, 0.1)), key=held_at)
    least = held_at(lowest)

    def excess(value: float) -> float:
        # the root of a nearly quadratic rise is nearly linear: few steps to its crossing
        return float(np.sqrt(max(held_at(value) - least, 0.0)) - np.sqrt(rise))

    # with kinks the criterion may be as high at the estimate, which then ends the interval
    inner = centre if excess(centre) < 0.0 else lowest
    sides = ((-1.0, given.lower[k]), (1.0, given.upper[k]))
    low, high = (_crossing(excess, inner, sign * t * error, float(end)) for sign, end in sides)
    low = None if low is None else min(low, centre)
    high = None if high is None else max(high, centre)
    return Interval(low, high)


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
        return dict.fromkeys(("sigma", "tau"), Interval(0.0, 0.0))
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

    # with kinks the least criterion need not be that of the estimate
    around = np.exp(np.linspace(-1.0, 1.0, 81)) if several else np.ones(1)
    middle = min(map(float, s * around), key=of_sigma)
    lowest = of_sigma(middle)
    low, high = (
        _crossing(lambda v: of_sigma(np.exp(v)) - lowest - rise, np.log(middle), step, bound)
        for step, bound in ((-0.3, -np.inf), (0.3, np.inf))
    )
    sigma = Interval(low, high).exponential()
    if spline is None:
        return {"sigma": sigma, "tau": Interval(0.0, None)}
    log_s2 = 2.0 * np.log(s) + np.linspace(-4.0, 4.0, DENSE)

    def of_tau(tau: float) -> float:
        ratio = np.minimum(tau / np.exp(0.5 * log_s2), LARGEST_RATIO)
        return least(log_s2, spline(np.log(ratio + RATIO_SHIFT)).T)

    step = max(estimate.tau, 0.2 * s)
    middle = min((estimate.tau, *map(float, step * around)), key=of_tau)
    lowest_tau, highest = (
        _crossing(lambda v: of_tau(v) - lowest - rise, middle, sign * step, bound)
        for sign, bound in ((-1.0, 0.0), (1.0, np.inf))
    )
    return {"sigma": sigma, "tau": Interval(lowest_tau or 0.0, highest)}


class Mixture(NamedTuple):
    """Distributions (points,) of the free parameters, Student with `nu` degrees of freedom."""

    weight: Array
    theta: Array  # (points, p)
    ratio: Array  # tau / sigma
    variance: Array  # sigma^2
    inverse: Array  # (points, free, free), covariance over sigma^2
    nu: float


def mixture_of(estimate: Estimate) -> Mixture:
    """One distribution per ratio tau / sigma, weighing by its restricted likelihood."""
    free = np.flatnonzero(~estimate.at_bound)
    given, every = _linear(estimate, free), np.arange(len(free))
    # fine near zero, where the likelihood changes; its tail falls like a power
    r = np.concatenate([[0.0], np.geomspace(0.02, MIXED, POINTS)])
    theta, parts = np.tile(estimate.theta, (len(r), 1)), []
    for k, each in enumerate(r):
        value, variance, solved = criterion_at(given, float(each) ** 2, given.start, every)
        theta[k, free] = solved.theta
        parts.append((value, variance, np.linalg.pinv(solved.normal)))
    values, variances, inverses = (np.array(each) for each in zip(*parts, strict=True))
    weight = np.exp(-0.5 * (values - values.min())) * np.gradient(r)
    weight = weight / (1.0 + (r / USUAL_RATIO) ** 2)
    nu = given.count - len(free)
    return Mixture(weight / weight.sum(), theta, r, variances, inverses, nu)


def _linear(estimate: Estimate, free: Indices) -> Problem:
    """The problem of the `free` parameters, its prediction linear around the best ones."""
    given, theta = estimate.problem, estimate.theta
    x, none = jacobian(given, theta, free), np.full(len(free), np.inf)
    y, names = given.y - given.predict(theta) + x @ theta[free], tuple(given.names[k] for k in free)
    known = replace(given, y=y, design=x, predict=lambda each: x @ each, tangent=None)
    return replace(known, names=names, start=theta[free], lower=-none, upper=none)


class Part(NamedTuple):
    """One of several candidates: its `weight`, its fit, and the new tests as it describes them."""

    weight: float
    estimate: Estimate
    mixture: Mixture
    held: Problem


def _quantile(weight: Array, nu: Array, centre: Array, scale: Array, share: float) -> float:
    """Value which a `share` of a mixture of Student distributions (points,) lies below."""
    from scipy.optimize import brentq
    from scipy.special import stdtr

    def below(y: float) -> float:
        return float(weight @ stdtr(nu, (y - centre) / scale)) - share

    low = high = float(weight @ centre)
    width = 10.0 * float(np.max(scale[weight > 1e-12]))
    while below(low) > 0.0:
        low -= width
    while below(high) < 0.0:
        high += width
    return float(brentq(below, low, high, xtol=1e-9 * width))


def averaged_quantile(
    parts: Sequence[Part], shares: Sequence[float], median: Sequence[float] = ()
) -> Array:
    """Values (shares + median, n) that shares of a distribution lie below, in the unit of y.

    `shares`, of new tests in a new campaign; `median`, of what the tests tell of the median over
    campaigns. The distributions of the candidates are averaged with their weights.
    """
    weights, centres, scales, freedoms = [], [], [], []
    for weight, estimate, mixture, held in parts:
        free = np.flatnonzero(~estimate.at_bound)
        middle, x = held.predict(estimate.theta), jacobian(held, estimate.theta, free)
        spread = np.maximum(np.einsum("nj,kjl,nl->kn", x, mixture.inverse, x), 0.0)
        shares_of_sigma = np.array([spread + 1.0 + mixture.ratio[:, None] ** 2, spread])
        scales.append(np.sqrt(mixture.variance[:, None] * shares_of_sigma))
        centres.append(middle + (mixture.theta[:, free] - estimate.theta[free]) @ x.T)
        weights.append(weight * mixture.weight)
        freedoms.append(np.full(len(mixture.weight), float(mixture.nu)))
    centre, share_of, nu = (np.concatenate(each) for each in (centres, weights, freedoms))
    least = ROUND_OFF * max(1.0, float(np.max(np.abs(centre))))
    both = np.maximum(np.concatenate(scales, axis=1), least)
    values = []
    for scale, wanted in zip(both, (shares, median), strict=True):
        columns, index = np.unique(np.vstack([centre, scale]), axis=1, return_inverse=True)
        for share in wanted:
            each = [
                _quantile(share_of, nu, column[: len(nu)], column[len(nu) :], share)
                for column in columns.T
            ]
            values.append(np.array(each)[np.ravel(index)])
    return np.array(values)


def predictive_quantile(estimate: Estimate, held: Problem, share: float) -> Array:
    """Value (n,) below which a `share` of new tests in a new campaign lies, in the unit of y.

    `held`: a problem whose rows describe the new tests (its y is not used). Raises `InputError` for
    fewer than three campaigns behind the estimate.
    """
    count = estimate.problem.campaigns
    if count < LEAST_CAMPAIGNS:
        reason = f"must be {LEAST_CAMPAIGNS} or more to say anything of a new campaign"
        raise InputError("campaigns", count, reason, "fewer do not tell how much campaigns differ")
    if estimate.is_exact:
        return held.predict(estimate.theta)
    part = Part(1.0, estimate, mixture_of(estimate), held)
    return np.asarray(averaged_quantile([part], [share])[0])
