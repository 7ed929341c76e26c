"""Intervals of a fitted mixed model by profile likelihood, and fractiles of new tests by a mixture.

Profile: a parameter is held, all others and the ratio of variances are fitted anew, and the
interval is where the restricted criterion rises by (nu + 1) ln(1 + t^2 / nu), t the Student
quantile with nu degrees of freedom after Satterthwaite. For balanced data this is the exact
interval; with many campaigns it becomes the usual chi-squared one. What two campaigns move has
Student's interval with one degree of freedom over the values of each.

Mixture: given the ratio of variances lambda, parameters and new tests are Student-distributed. As
few campaigns hardly tell lambda, its restricted likelihood is integrated over sqrt(lambda) with the
weakly informative half-Cauchy density that Gelman 2006 recommends for few groups, and over the
growth of the scatter with the level of the damage. With two campaigns the assumed density would
decide: nothing is foretold. With one campaign new tests are those of this laboratory alone.

**Second part.** New tests foretold; what is left out, predicted from the others: campaigns, and
single tests.

Relations are weighed by it, outliers found, and the influence of every test on the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pandas as pd

from workbench.base.arrays import Flags
from workbench.base.errors import InputError, SolverError
from workbench.studs.statistics.mixed import (
    LEAST_CAMPAIGNS,
    NEW,
    ROUND_OFF,
    Estimate,
    Indices,
    Problem,
    best_ratio,
    criteria_at,
    criterion_of,
    fit,
    fit_robust,
    jacobian,
    line_at,
    solve_theta,
    subset,
    whiten,
)
from workbench.studs.tables import Array

LEAST_FREEDOM = 1.0
MOVED = 1.5  # times the variance of a parameter, from where on campaigns that differ move it
BRACKETINGS = 40
LARGEST_RATIO, RATIOS, RATIO_SHIFT = 1000.0, 80, 0.05  # of r = tau / sigma and its spline
DENSE = 1500  # points over which the smooth criterion is searched
NEGLIGIBLE = 1e-6  # weight of a point of a mixture, over the largest
MIXED, POINTS = 100.0, 80  # largest tau / sigma of a mixture, beyond which no likelihood is left
# scale of the half-Cauchy density of tau over sigma: 3 to 6.5 % of new tests lie below the 5 %
# fractile of three campaigns or more where the ratio is 0.4 to 2
USUAL_RATIO = 1.0
# logarithm of the scatter at the largest level over that at none: normal, with this deviation
GROWTHS, USUAL_GROWTH = np.linspace(-2.0, 2.5, 10), 1.0


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
        return given.freedom(len(free))
    k = int(np.searchsorted(free, column))
    x = jacobian(given, estimate.theta, free)

    def variance(s2: float, t2: float) -> float:
        """Interval of the parameter for other variances, at the same parameters."""
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
    error = np.sqrt(estimate.covariance[k, k])
    if not (np.isfinite(error) and error > 0.0):
        return Interval(None, None)
    if given.between is not None:
        parameter = replace(_alone(given), predict=lambda theta: theta[[k]])
        ends = predictive_quantiles([Part(1.0, estimate, parameter)], (), tails_of(confidence))
        return Interval(*map(float, ends[:, 0]))
    nu = freedom_of(estimate, name)
    t = float(stdtrit(nu, 0.5 + 0.5 * confidence))
    rise = (nu + 1.0) * np.log1p(t * t / nu)
    others = np.delete(np.arange(len(given.names)), k)
    if given.campaigns == 2 and (both := _over_two(estimate, k, confidence)):
        return both
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


def _over_two(estimate: Estimate, k: int, confidence: float) -> Interval | None:
    """Student's interval over two campaigns, each by itself; None where they do not move it."""
    from scipy.special import stdtrit

    given, free = estimate.problem, np.flatnonzero(~estimate.at_bound)
    x, column = jacobian(given, estimate.theta, free), int(np.searchsorted(free, k))
    white = (whiten(given, x, ratio) for ratio in (0.0, 1.0))
    alike, apart = (np.linalg.pinv(w.T @ w)[column, column] for w in white)
    if apart < MOVED * alike:
        return None
    parts = [subset(given, np.flatnonzero(given.groups == group)) for group in (0, 1)]
    if min(part.count for part in parts) < len(free):
        return Interval(None, None)  # one of them does not tell it
    ends = [float(solve_theta(part, 0.0, estimate.theta, free).theta[k]) for part in parts]
    half = 0.5 * abs(ends[0] - ends[1]) * float(stdtrit(1.0, 0.5 + 0.5 * confidence))
    return Interval(0.5 * sum(ends) - half, 0.5 * sum(ends) + half)


def _crossing(
    excess: Callable[[float], float],
    centre: float,
    step: float,
    bound: float,
    within: float = 1e-4,
) -> float | None:
    """Where a function that is negative at the centre crosses zero on one side; None if nowhere.

    `within` a share of the last step.
    """
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
            return float(brentq(excess, inner, far, xtol=within * abs(step), rtol=1e-8))
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
    if given.between is not None:
        known = mixture_of(estimate)
        rising = np.argsort(known.variance)
        below, scatter = np.cumsum(known.weight[rising]), np.sqrt(known.variance[rising])
        ends = np.interp(tails_of(confidence), below, scatter)
        return {"sigma": Interval(*map(float, ends)), "tau": Interval(*(given.between,) * 2)}
    free = np.flatnonzero(~estimate.at_bound)
    m, several = given.freedom(len(free)), given.campaigns > 1
    # at the best parameters, with r = tau / sigma: rest(r) + m ln(sigma^2) + size(r) / sigma^2
    r = np.concatenate([[0.0], np.geomspace(0.02, LARGEST_RATIO, RATIOS)])[: None if several else 1]
    values, variance = criteria_at(given, r * r, estimate.theta, free)
    parts = np.column_stack([values - m - m * np.log(variance), np.log(variance * m)])
    x = np.log(r + RATIO_SHIFT)
    spline = CubicSpline(x, parts) if several else None
    dense = parts if spline is None else spline(np.linspace(x[0], x[-1], DENSE))
    log_s2 = 2.0 * np.log(s) + np.linspace(-4.0, 4.0, DENSE)

    def least(log_s2: Array | float, parts: Array) -> float:
        rest, log_size = parts.T
        return float(np.min(rest + m * log_s2 + np.exp(log_size - log_s2)))

    def of_tau(tau: float) -> float:
        assert spline is not None
        ratio = np.minimum(tau / np.exp(0.5 * log_s2), LARGEST_RATIO)
        return least(log_s2, spline(np.log(ratio + RATIO_SHIFT)))

    def ends_of(
        profile: Callable[[float], float], values: Array, step: float, bound: float
    ) -> Interval:
        """Profile of a scatter, whose least value need not be that of the estimate with kinks."""
        middle = min(map(float, values), key=profile)
        limit = profile(middle) + rise
        sides = ((-step, bound, 1e-9), (step, np.inf, 1e-9))
        return Interval(*(_crossing(lambda v: profile(v) - limit, middle, *each) for each in sides))

    around = np.exp(np.linspace(-1.0, 1.0, 81)) if several else np.ones(1)
    sigma = ends_of(lambda v: least(2.0 * v, dense), np.log(s * around), 0.3, -np.inf).exponential()
    if spline is None:
        return {"sigma": sigma, "tau": Interval(0.0, None)}
    step = max(estimate.tau, 0.2 * s)
    low, high = ends_of(of_tau, np.append(estimate.tau, step * around), step, 0.0)
    return {"sigma": sigma, "tau": Interval(low or 0.0, high)}


class Mixture(NamedTuple):
    """Distributions (points,) of the free parameters, Student with `nu` degrees of freedom.

    The scatter of a test at a `level` is sigma exp(`growth` (level / top - 1/2)), `top` the largest
    one; the most likely growth, and the `likelihood_ratio` to none (twice the logarithm).
    """

    weight: Array
    theta: Array  # (points, p)
    ratio: Array  # tau / sigma
    variance: Array  # sigma^2
    inverse: Array  # (points, free, free), covariance over sigma^2
    nu: Array
    growth: Array
    top: float
    likely: float
    likelihood_ratio: float

    def spread(self, level: Array | None, count: int) -> Array:
        """Scatter within a campaign (points, count) at levels, over sigma, squared."""
        x = np.zeros(count) if level is None else level / self.top - 0.5
        return np.asarray(np.exp(2.0 * self.growth[:, None] * x))


def mixture_of(estimate: Estimate) -> Mixture:
    """One distribution per tau / sigma and growth, weighing by its restricted likelihood."""
    free = np.flatnonzero(~estimate.at_bound)
    given, every = linear(estimate, free), np.arange(len(free))
    if given.between is not None:
        r = np.sqrt(estimate.ratio) * np.geomspace(0.125, 8.0, POINTS)
        density = np.ones(POINTS)  # of the logarithm of sigma
    elif given.campaigns == 1:
        r, density = np.zeros(1), np.ones(1)
    else:  # fine near zero, where the likelihood changes; its tail falls like a power
        r = np.concatenate([[0.0], np.geomspace(0.02, MIXED, POINTS)])
        density = np.gradient(r) / (1.0 + (r / USUAL_RATIO) ** 2)
    top = 1.0 if given.level is None else float(np.max(given.level)) or 1.0
    parts, growths = [], np.zeros(1) if given.level is None else GROWTHS
    for growth in growths:
        falls = 0.0 if given.level is None else -2.0 * growth * (given.level / top - 0.5)
        weighed = replace(given, weights=given.weights * np.exp(falls))
        best, size, normal = line_at(weighed, r * r, given.start, every)
        value, variance = criterion_of(weighed, r * r, size, normal)
        value -= np.sum(falls * np.ones(given.count))
        parts.append((value, variance, best, np.linalg.pinv(normal)))
    values, variance, best, inverse = (np.concatenate(each) for each in zip(*parts, strict=True))
    prior = np.exp(-0.5 * (growths / USUAL_GROWTH) ** 2)[:, None] * density
    weight = np.exp(-0.5 * (values - values.min())) * prior.ravel()
    least = values.reshape(len(growths), -1).min(axis=1)
    kept = weight > NEGLIGIBLE * weight.max()
    theta = np.tile(estimate.theta, (int(kept.sum()), 1))
    theta[:, free] = best[kept]
    nu = given.freedom(len(free)) if given.between is None else np.inf
    return Mixture(
        weight[kept] / weight[kept].sum(), theta, np.tile(r, len(growths))[kept], variance[kept],
        inverse[kept], np.full(int(kept.sum()), nu), np.repeat(growths, len(r))[kept], top,
        float(growths[np.argmin(least)]), float(least[growths == 0.0][0] - least.min()),
    )  # fmt: skip


def linear(estimate: Estimate, free: Indices) -> Problem:
    """The problem of the `free` parameters, its prediction linear around the best ones."""
    given, theta = estimate.problem, estimate.theta
    x, none = jacobian(given, theta, free), np.full(len(free), np.inf)
    y, names = given.y - given.predict(theta) + x @ theta[free], tuple(given.names[k] for k in free)
    known = replace(given, y=y, design=x, predict=lambda each: x @ each, tangent=None)
    return replace(known, names=names, start=theta[free], lower=-none, upper=none)


def _alone(given: Problem) -> Problem:
    """The problem of one new test, its prediction to be replaced."""
    return replace(given, y=np.zeros(1), groups=np.zeros(1, np.int64), weights=np.ones(1),
                   design=None, tangent=None, shares=None, level=None)  # fmt: skip


DRAWS = 2000  # of the weights of the left-out parts
MOST_LEFT_OUT = 50  # campaigns; with more of them, as many evenly through the table tell the same


class Part(NamedTuple):
    """One of several candidates: its `weight`, its fit, and the new tests as it describes them."""

    weight: float
    estimate: Estimate
    held: Problem


def predictive_quantiles(
    parts: Sequence[Part], shares: Sequence[float], median: Sequence[float] = ()
) -> Array:
    """Values (shares + median, n) that shares of a distribution lie below, in the unit of y.

    `shares`, of new tests of a new campaign, or of the only one (`Problem.foretold`); `median`, of
    what the tests tell of the median over campaigns. The rows of `Part.held` describe them, its y
    is not used. The distributions of the candidates are averaged with their weights. Raises
    `InputError` for two campaigns.
    """
    from scipy.optimize import brentq
    from scipy.special import stdtr, stdtrit

    if not all(each.estimate.problem.foretold for each in parts):
        reason = f"must be {LEAST_CAMPAIGNS} or more to say anything of a new campaign"
        raise InputError("campaigns", 2, reason, "fewer do not tell how much campaigns differ")
    weights, centres, scales, freedoms = [], [], [], []
    for weight, estimate, held in parts:
        free, mixture = np.flatnonzero(~estimate.at_bound), mixture_of(estimate)
        middle, x = held.predict(estimate.theta), jacobian(held, estimate.theta, free)
        spread = np.maximum(np.einsum("nj,kjl,nl->kn", x, mixture.inverse, x), 0.0)
        test = mixture.spread(held.level, held.count) + mixture.ratio[:, None] ** 2
        scales.append(np.sqrt(mixture.variance[:, None] * np.array([spread + test, spread])))
        centres.append(middle + (mixture.theta[:, free] - estimate.theta[free]) @ x.T)
        weights.append(weight * mixture.weight)
        freedoms.append(mixture.nu)
    centre, share_of, nu = (np.concatenate(each) for each in (centres, weights, freedoms))
    least = ROUND_OFF * max(1.0, float(np.max(np.abs(centre))))
    both = np.maximum(np.concatenate(scales, axis=1), least)

    @cache
    def quantile(share: float, column: bytes) -> float:
        middle, scale = np.frombuffer(column).reshape(2, -1)
        ends = middle + scale * stdtrit(nu, share)  # between those of its parts lies the mixture's

        def below(y: float) -> float:
            return float(share_of @ stdtr(nu, (y - middle) / scale)) - share

        return float(brentq(below, ends.min() - least, ends.max() + least, xtol=1e-14))

    return np.array([
        [quantile(share, np.array(each).tobytes()) for each in zip(centre.T, scale.T, strict=True)]
        for scale, wanted in zip(both, (shares, median), strict=True)
        for share in wanted
    ])  # fmt: skip


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A campaign predicted from all others: `campaign`, `count`, mean error and root mean square.

    `bias` and `rms` in the unit of y; `covered`, share of its tests inside the prediction
    interval (None if the other campaigns are too few for one).
    """

    campaign: str
    count: int
    bias: float
    rms: float
    covered: float | None


def leave_one_campaign_out(given: Problem, confidence: float = 0.9) -> list[LeftOut]:
    """Predict every campaign, at most `MOST_LEFT_OUT` evenly through the table, from all others.

    Raises `InputError` for fewer than two campaigns, or where the others cannot be fitted.
    """
    if given.campaigns < 2:
        raise InputError("campaigns", given.campaigns, "must be two or more to leave one out")
    result = []
    count = min(given.campaigns, MOST_LEFT_OUT)
    for part in np.linspace(0, given.campaigns - 1, count).round().astype(int):
        label, (held, others) = given.labels[part], _parted(given, given.groups == part)
        estimate = fit(others)
        error = held.y - held.predict(estimate.theta)
        rms = float(np.sqrt(np.mean(error**2)))
        covered = coverage(estimate, held, confidence)
        result.append(LeftOut(label, held.count, float(np.mean(error)), rms, covered))
    return result


def _parted(given: Problem, inside: Flags) -> tuple[Problem, Problem]:
    """The tests `inside` (n,), and all others."""
    return subset(given, np.flatnonzero(inside)), subset(given, np.flatnonzero(~inside))


def coverage(estimate: Estimate, held: Problem, confidence: float) -> float | None:
    """Share of the tests of `held` inside their prediction interval (None: too few campaigns)."""
    if estimate.problem.foretold != NEW:
        return None
    low, high = predictive_quantiles([Part(1.0, estimate, held)], tails_of(confidence))
    return float(np.mean((held.y >= low) & (held.y <= high)))


class Score(NamedTuple):
    """A candidate: `parameters` counted; `rms` of the left-out tests, campaigns weighing alike.

    `behind`, logarithm of the predictive density of all left-out parts behind that of the best
    candidate, with its standard error over the parts; `weight` in the average; `parts` left out,
    `by` campaign or specimen.
    """

    name: str
    parameters: int
    rms: float
    behind: float
    standard_error: float
    weight: float
    parts: int
    by: str


def _log_density(estimate: Estimate, held: Problem, others: Problem) -> tuple[float, float]:
    """Logarithm of the joint density of left-out tests, predicted from the others, and their error.

    A Student distribution with the ratio of variances of the whole fit: tests of one campaign go
    together, so that its effect, which no candidate can know, tells little between them. The error
    is the mean square. Minus infinity where the others cannot be fitted.
    """
    from scipy.special import gammaln

    ratio, free = estimate.ratio, np.arange(len(held.names))
    try:
        solved = solve_theta(others, ratio, estimate.theta, free)
    except (InputError, SolverError):
        return -np.inf, np.inf
    inner, nu, n = free[~solved.stuck], others.count - len(solved.normal), held.count
    if nu < 1:
        return -np.inf, np.inf
    x, error = jacobian(held, solved.theta, inner), held.y - held.predict(solved.theta)
    floor = (ROUND_OFF * max(1.0, float(np.max(np.abs(others.y))))) ** 2
    spread = np.diag(1.0 / held.weights) + ratio * (held.groups[:, None] == held.groups)
    spread = max(solved.size / nu, floor) * (spread + x @ np.linalg.pinv(solved.normal) @ x.T)
    distance = float(error @ np.linalg.solve(spread, error))
    constant = gammaln(0.5 * (nu + n)) - gammaln(0.5 * nu) - 0.5 * n * np.log(nu * np.pi)
    size = 0.5 * (nu + n) * np.log1p(distance / nu) + 0.5 * np.linalg.slogdet(spread)[1]
    return float(constant - size), float(np.mean(error**2))


def score_relations(estimates: Mapping[str, Estimate]) -> list[Score]:
    """Scores and weights of fitted candidates, the one of most weight first.

    Campaigns are left out; specimens where there is one campaign, or the others would be too few
    for a candidate. A weight is the mean, over draws that weigh the left-out parts at random, of
    the share of the predictive density: what few parts cannot tell apart keeps weight (pseudo-BMA+,
    Yao, Vehtari, Simpson and Gelman 2018). Raises `InputError` when no candidate can be scored.
    """
    given = next(iter(estimates.values())).problem
    most = max(len(each.problem.names) for each in estimates.values())
    rest = given.count - int(np.max(np.bincount(given.groups)))
    by_campaign = given.campaigns > 1 and rest > most + 1
    parts = given.groups if by_campaign else np.arange(given.count)
    parted = {
        name: np.array(
            [_log_density(each, *_parted(each.problem, parts == k)) for k in np.unique(parts)]
        )
        for name, each in estimates.items()
    }
    known = {name: each for name, each in parted.items() if np.all(np.isfinite(each))}
    if not known:
        raise InputError("candidates", ", ".join(estimates), "cannot be cross-validated here")
    densities = np.array([each[:, 0] for each in known.values()])
    count = densities.shape[1]
    drawn = np.random.default_rng(0).dirichlet(np.ones(count), DRAWS) * count @ densities.T
    likely = np.exp(drawn - drawn.max(axis=1, keepdims=True))
    weights = (likely / likely.sum(axis=1, keepdims=True)).mean(axis=0)
    best = densities[int(np.argmax(densities.sum(axis=1)))]
    by = "campaign" if by_campaign else "specimen"
    scores = []
    for (name, each), weight in zip(known.items(), weights, strict=True):
        behind = best - each[:, 0]
        error = float(np.std(behind, ddof=1) * np.sqrt(count)) if count > 1 else 0.0
        rms = float(np.sqrt(np.mean(each[:, 1])))
        number = len(estimates[name].problem.names)
        scores.append(
            Score(name, number, rms, float(behind.sum()), error, float(weight), count, by)
        )
    return sorted(scores, key=lambda score: -score.weight)


CHANCE = 0.05  # that a table without outliers has one found in it
DOUBTED = 2.5  # robust standard deviations, from where on a test is looked at


class Outlier(NamedTuple):
    """An outlier: its `row`, `distance` in standard deviations, and value `expected` by others."""

    row: int
    distance: float
    expected: float


def deleted_residuals(estimate: Estimate) -> Array:
    """Residuals (n,) over the standard deviation that the other tests tell (studentised, deleted).

    Of a normal model they are Student-distributed, with as many degrees of freedom as there are
    tests less parameters less one. The ratio of variances stays that of the fit. Source: Cook and
    Weisberg 1982.
    """
    given, free = estimate.problem, np.flatnonzero(~estimate.at_bound)
    nu = given.count - len(free) - 1
    if nu < 1:
        return np.zeros(given.count)
    z = whiten(given, given.y - given.predict(estimate.theta), estimate.ratio)
    j = whiten(given, jacobian(given, estimate.theta, free), estimate.ratio)
    rest = 1.0 - np.einsum("ni,ij,nj->n", j, np.linalg.pinv(j.T @ j), j)
    known = rest > 1e-9  # others say something of it
    square = np.where(known, z**2 / np.where(known, rest, 1.0), 0.0)
    floor = (ROUND_OFF * max(1.0, float(np.max(np.abs(given.y))))) ** 2
    others = np.maximum((z @ z - square) / nu, floor)
    return np.asarray(np.sign(z) * np.sqrt(square / others))


def outliers(estimate: Estimate) -> list[Outlier]:
    """Tests farther off than chance lets any of as many be (Bonferroni), farthest first.

    The weights of a loss do not count, so that every loss names the same. The order is that of
    the distance from a fit that outliers do not pull, by the median absolute residual; each test is
    judged by those that are nearer, so that outliers do not hide each other. Source: Rosner 1983.
    """
    from scipy.special import stdtrit

    given, free = estimate.problem, np.flatnonzero(~estimate.at_bound)
    alike = replace(linear(estimate, free), weights=np.ones(given.count), shares=None)

    def distance(row: int, others: Indices) -> float:
        return float(deleted_residuals(fit(subset(alike, np.append(others, row))))[-1])

    try:
        off = np.abs(fit_robust(alike, "bisquare").residuals)
        order, doubted = np.argsort(-off), off > DOUBTED / 0.6745 * np.median(off)
        far, most = 0, max(min(int(doubted.sum()), given.count // 3), 1)
        for k in range(min(most, given.count - len(free) - 2)):
            chance = 0.5 * CHANCE / (given.count - k)
            usual = stdtrit(given.count - k - len(free) - 1.0, 1.0 - chance)
            far = k + 1 if abs(distance(order[k], order[k + 1 :])) > usual else far
        rest = order[far:]
        alone = replace(subset(given, rest), weights=np.ones(len(rest)), shares=None)
        expected = given.predict(fit(alone).theta if far else estimate.theta)
        return [Outlier(int(k), distance(k, rest), float(expected[k])) for k in order[:far]]
    except (InputError, SolverError):  # too few others to judge by
        return []


def without_each(estimate: Estimate) -> Array:
    """Parameters (n, p) that the other tests give where each test is left out.

    The ratio of variances stays that of the fit; NaN where the others do not tell them.
    """
    given, every = estimate.problem, np.arange(estimate.problem.count)
    free, left = np.arange(len(given.names)), np.full((given.count, len(given.names)), np.nan)
    for k in every if given.count > len(free) + 1 else ():
        try:
            others = subset(given, np.flatnonzero(every != k))
            left[k] = solve_theta(others, estimate.ratio, estimate.theta, free).theta
        except (InputError, SolverError):
            continue
    return left


def influence_of(
    rows: pd.DataFrame, estimate: Estimate, answer: str, value: float, without: Array
) -> pd.DataFrame:
    """How every test moves an answer, one row each.

    Columns: campaign, specimen; `answer`, its name; `value` with all tests and `without` (n,) this
    one; `distance`, the deleted residual in standard deviations; `outlier`, whether that is more
    than chance explains.
    """
    distance, outlier = deleted_residuals(estimate), np.zeros(len(rows), bool)
    for each in outliers(estimate):
        distance[each.row], outlier[each.row] = each.distance, True
    table = rows[["campaign", "specimen"]].assign(answer=answer, value=value, without=without)
    return table.assign(distance=distance, outlier=outlier)
