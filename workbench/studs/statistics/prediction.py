"""What a fitted mixed model says of a new test in a new campaign.

Given the ratio of variances lambda, a new test is Student-distributed. As few campaigns hardly
tell lambda, its restricted likelihood is integrated over sqrt(lambda) with equal weights (Gelman
2006 recommends the uniform density on the standard deviation); this needs three campaigns, with
fewer the integral does not exist and no prediction for a new campaign is made.
Relations are chosen by cross-validation over campaigns.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import Estimate, criterion_at, fit
from workbench.studs.statistics.problem import Indices, Problem, jacobian, subset

LEAST_CAMPAIGNS = 3
LARGEST_RATIO = 100.0  # tau over sigma; beyond it the likelihood has vanished for 3 campaigns
POINTS = 80


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
        if solved.stuck.any():
            raise InputError("prediction", given.names, "is not defined at a bound of a parameter")
        theta = solved.theta
        found.append((value, theta, variance, np.linalg.pinv(solved.normal)))
    values, thetas, variances, inverses = (np.array(each) for each in zip(*found, strict=True))
    weight = np.exp(-0.5 * (values - values.min())) * np.gradient(r)
    nu = given.count - len(free)
    return _Mixture(weight / weight.sum(), thetas, r, variances, inverses, nu)


def _quantile(mixture: _Mixture, share: float, near: float, centre: Array, scale: Array) -> float:
    """Value `near` which a `share` of the mixture lies below; `centre` and `scale` (points,)."""
    from scipy.optimize import brentq
    from scipy.special import stdtr

    def below(y: float) -> float:
        return float(mixture.weight @ stdtr(mixture.nu, (y - centre) / scale)) - share

    low = high = near
    width = 10.0 * float(np.max(scale[mixture.weight > 1e-12]))
    while below(low) > 0.0:
        low -= width
    while below(high) < 0.0:
        high += width
    return float(brentq(below, low, high, xtol=1e-9 * width))


def predictive_quantile(estimate: Estimate, held: Problem, share: float) -> Array:
    """Value (n,) below which a `share` of new tests in a new campaign lies, in the unit of y.

    Arguments: `held`, a problem whose rows describe the new tests (its y is not used). Raises
    `InputError` for fewer than three campaigns behind the estimate.
    """
    count = estimate.problem.campaigns
    if count < LEAST_CAMPAIGNS:
        reason = f"must be {LEAST_CAMPAIGNS} or more to say anything of a new campaign"
        advice = "fewer do not tell how much campaigns differ"
        raise InputError("campaigns", count, reason, advice)
    if estimate.is_exact:
        return held.predict(estimate.theta)
    mixture = _mixture(estimate)
    free = np.flatnonzero(~estimate.at_bound)
    x = jacobian(held, estimate.theta, free)
    middle = held.predict(estimate.theta)
    rows, index = np.unique(np.column_stack([x, middle]), axis=0, return_inverse=True)
    result = []
    for *slope, own in rows:
        spread = np.einsum("j,kjl,l->k", slope, mixture.inverse, slope)
        scale = np.sqrt(mixture.variance * (1.0 + mixture.ratio**2 + spread))
        centre = own + (mixture.theta[:, free] - estimate.theta[free]) @ slope
        result.append(_quantile(mixture, share, float(own), centre, scale))
    return np.array(result)[index.ravel()]


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

    `behind`, mean square behind the best candidate with its standard error over the left-out
    parts (None with fewer than two); `parts` left out, `by` campaign or specimen.
    """

    name: str
    parameters: int
    rms: float
    behind: float
    standard_error: float | None
    parts: int
    by: str


def _squares(given: Problem, by_campaign: bool) -> Array:
    """Mean square of the left-out tests of each part; infinite where the rest cannot be fitted."""
    result = []
    for held, others in _left_out(given, given.groups if by_campaign else np.arange(given.count)):
        try:
            theta = fit(others).theta if given.names else np.zeros(0)
            result.append(float(np.mean((held.y - held.predict(theta)) ** 2)))
        except (InputError, SolverError):
            result.append(np.inf)
    return np.array(result)


def score_relations(problems: Mapping[str, Problem]) -> list[Score]:
    """Scores of the candidates, best first; campaigns are left out, or specimens if there is one.

    Arguments: the same observations with the prediction of each candidate. Raises `InputError`
    when no candidate can be scored.
    """
    by_campaign = next(iter(problems.values())).campaigns > 1
    by = "campaign" if by_campaign else "specimen"
    squares = {name: _squares(given, by_campaign) for name, given in problems.items()}
    means = {name: float(np.mean(each)) for name, each in squares.items()}
    best = min(means, key=lambda name: means[name])
    if not np.isfinite(means[best]):
        raise InputError("candidates", ", ".join(problems), "cannot be cross-validated here")
    scores = []
    for name, each in squares.items():
        error = None
        if np.isfinite(means[name]) and len(each) > 1:
            error = float(np.std(each - squares[best], ddof=1) / np.sqrt(len(each)))
        rms, behind = float(np.sqrt(means[name])), means[name] - means[best]
        count = len(problems[name].names)
        scores.append(Score(name, count, rms, behind, error, len(each), by))
    return sorted(scores, key=lambda score: score.rms)


def choose(scores: list[Score]) -> Score:
    """The simplest candidate within one standard error of the best (Hastie et al. 2009, 7.10)."""
    known = (score for score in scores if np.isfinite(score.rms))
    near = (score for score in known if score.behind <= (score.standard_error or 0.0))
    return min(near, key=lambda score: (score.parameters, score.rms))
