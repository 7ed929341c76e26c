"""What a fitted mixed model says of a new test in a new campaign.

Given the ratio of variances lambda, a new test is Student-distributed. As few campaigns hardly
tell lambda, its restricted likelihood is integrated over sqrt(lambda) with the weakly informative
half-Cauchy density that Gelman 2006 recommends for few groups. Three campaigns are asked for: with
fewer the assumed density would decide, and no prediction for a new campaign is made.
Relations are weighed by cross-validation over campaigns, and averaged.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import (
    ROUND_OFF,
    Estimate,
    criterion_at,
    fit,
    solve_theta,
)
from workbench.studs.statistics.problem import Indices, Problem, jacobian, subset

LEAST_CAMPAIGNS = 3
LARGEST_RATIO = 100.0  # tau over sigma; beyond it the likelihood has vanished for 3 campaigns
POINTS = 80
USUAL_RATIO = 2.0  # scale of the half-Cauchy density of tau over sigma
DRAWS = 2000  # of the weights of the left-out parts


class _Mixture(NamedTuple):
    """Student distributions (points,) of the parameters with `nu` degrees of freedom."""

    weight: Array
    theta: Array  # (points, p)
    ratio: Array  # tau / sigma
    variance: Array  # sigma^2
    inverse: Array  # (points, p, p), of the normal matrix
    nu: int


def _mixture(estimate: Estimate) -> _Mixture:
    """One distribution per ratio tau / sigma, weighing by its restricted likelihood."""
    given = estimate.problem
    free = np.flatnonzero(~estimate.at_bound)
    # fine near zero, where the likelihood changes; its tail falls like a power
    r = np.concatenate([[0.0], np.geomspace(0.02, LARGEST_RATIO, POINTS)])
    theta, found = estimate.theta, []
    for each in r:
        value, variance, solved = criterion_at(given, float(each) ** 2, theta, free)
        theta, own = solved.theta, np.flatnonzero(~solved.stuck)
        inverse = np.zeros((len(free), len(free)))  # a parameter on its bound counts as known there
        inverse[np.ix_(own, own)] = np.linalg.pinv(solved.normal)
        found.append((value, theta, variance, inverse))
    values, thetas, variances, inverses = (np.array(each) for each in zip(*found, strict=True))
    weight = (
        np.exp(-0.5 * (values - values.min())) * np.gradient(r) / (1.0 + (r / USUAL_RATIO) ** 2)
    )
    nu = given.count - len(free)
    return _Mixture(weight / weight.sum(), thetas, r, variances, inverses, nu)


class Part(NamedTuple):
    """One of several candidates: its `weight`, its fit, and the new tests as it describes them."""

    weight: float
    estimate: Estimate
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


def averaged_quantile(parts: Sequence[Part], shares: Sequence[float]) -> Array:
    """Values (shares, n) that shares of new tests in a new campaign lie below, in the unit of y.

    The distributions of the candidates are averaged with their weights. Raises `InputError` for
    fewer than three campaigns behind the estimates.
    """
    count = parts[0].estimate.problem.campaigns
    if count < LEAST_CAMPAIGNS:
        reason = f"must be {LEAST_CAMPAIGNS} or more to say anything of a new campaign"
        advice = "fewer do not tell how much campaigns differ"
        raise InputError("campaigns", count, reason, advice)
    weights, centres, scales, freedoms = [], [], [], []
    for weight, estimate, held in parts:
        free = np.flatnonzero(~estimate.at_bound)
        middle, x = held.predict(estimate.theta), jacobian(held, estimate.theta, free)
        mixture = _mixture(estimate)
        spread = np.einsum("nj,kjl,nl->kn", x, mixture.inverse, x)
        between = 1.0 + mixture.ratio[:, None] ** 2
        scales.append(np.sqrt(mixture.variance[:, None] * (between + spread)))
        centres.append(middle + (mixture.theta[:, free] - estimate.theta[free]) @ x.T)
        weights.append(weight * mixture.weight)
        freedoms.append(np.full(len(mixture.weight), float(mixture.nu)))
    centre, scale = np.concatenate(centres), np.concatenate(scales)
    share_of, nu = np.concatenate(weights), np.concatenate(freedoms)
    scale = np.maximum(scale, ROUND_OFF * max(1.0, float(np.max(np.abs(centre)))))
    columns, index = np.unique(np.vstack([centre, scale]), axis=1, return_inverse=True)
    found = [
        [
            _quantile(share_of, nu, column[: len(nu)], column[len(nu) :], share)
            for column in columns.T
        ]
        for share in shares
    ]
    return np.array(found)[:, np.ravel(index)]


def predictive_quantile(estimate: Estimate, held: Problem, share: float) -> Array:
    """Value (n,) below which a `share` of new tests in a new campaign lies, in the unit of y.

    Arguments: `held`, a problem whose rows describe the new tests (its y is not used). Raises
    `InputError` for fewer than three campaigns behind the estimate.
    """
    if estimate.is_exact and estimate.problem.campaigns >= LEAST_CAMPAIGNS:
        return held.predict(estimate.theta)
    return np.asarray(averaged_quantile([Part(1.0, estimate, held)], [share])[0])


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
    """Predict every campaign from the others.

    Raises `InputError` for fewer than two campaigns, or where the others cannot be fitted.
    """
    if given.campaigns < 2:
        raise InputError("campaigns", given.campaigns, "must be two or more to leave one out")
    result = []
    for label, (held, others) in zip(given.labels, _left_out(given, given.groups), strict=True):
        estimate = fit(others)
        error = held.y - held.predict(estimate.theta)
        rms = float(np.sqrt(np.mean(error**2)))
        covered = coverage(estimate, held, confidence)
        result.append(LeftOut(label, held.count, float(np.mean(error)), rms, covered))
    return result


def _left_out(given: Problem, parts: Indices) -> Iterator[tuple[Problem, Problem]]:
    """The tests of each part (n,), and all others."""
    for part in np.unique(parts):
        inside, outside = np.flatnonzero(parts == part), np.flatnonzero(parts != part)
        yield subset(given, inside), subset(given, outside)


def coverage(estimate: Estimate, held: Problem, confidence: float) -> float | None:
    """Share of the tests of `held` inside their prediction interval (None: too few campaigns)."""
    if estimate.problem.campaigns < LEAST_CAMPAIGNS:
        return None
    shares = (0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence)
    low, high = (predictive_quantile(estimate, held, share) for share in shares)
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
    own, nu, n = free[~solved.stuck], others.count - len(solved.normal), held.count
    if nu < 1:
        return -np.inf, np.inf
    x, error = jacobian(held, solved.theta, own), held.y - held.predict(solved.theta)
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
    found = {
        name: np.array([_log_density(each, *both) for both in _left_out(each.problem, parts)])
        for name, each in estimates.items()
    }
    known = {name: each for name, each in found.items() if np.all(np.isfinite(each))}
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
