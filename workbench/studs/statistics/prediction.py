"""Prediction of what is left out: campaigns predicted from all others, relations weighed by it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.arrays import Flags
from workbench.errors import InputError, SolverError
from workbench.studs.statistics.intervals import tails_of
from workbench.studs.statistics.mixed import ROUND_OFF, Estimate, fit, solve_theta
from workbench.studs.statistics.mixture import LEAST_CAMPAIGNS, predictive_quantile
from workbench.studs.statistics.problem import Problem, jacobian, subset

DRAWS = 2000  # of the weights of the left-out parts
MOST_LEFT_OUT = 50  # campaigns; with more of them, as many evenly through the table tell the same


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
    if estimate.problem.campaigns < LEAST_CAMPAIGNS:
        return None
    low, high = (predictive_quantile(estimate, held, share) for share in tails_of(confidence))
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
        name: np.array(
            [_log_density(each, *_parted(each.problem, parts == k)) for k in np.unique(parts)]
        )
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
