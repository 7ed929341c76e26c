"""New tests foretold; what is left out, predicted from the others: campaigns, and single tests.

Relations are weighed by it, outliers found, and the influence of every test on the answer.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from workbench.base.arrays import Flags
from workbench.base.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.intervals import (
    Mixture,
    linear,
    mixture_of,
    quantile_of,
    tails_of,
)
from workbench.studs.statistics.mixed import fit, fit_robust, solve_theta
from workbench.studs.statistics.problem import (
    LEAST_CAMPAIGNS,
    NEW,
    ROUND_OFF,
    Estimate,
    Indices,
    Problem,
    jacobian,
    subset,
    whiten,
)

DRAWS = 2000  # of the weights of the left-out parts
MOST_LEFT_OUT = 50  # campaigns; with more of them, as many evenly through the table tell the same


class Part(NamedTuple):
    """One of several candidates: its `weight`, its fit, and the new tests as it describes them."""

    weight: float
    estimate: Estimate
    mixture: Mixture
    held: Problem


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
        test = mixture.spread(held.level, held.count) + mixture.ratio[:, None] ** 2
        shares_of_sigma = np.array([spread + test, spread])
        scales.append(np.sqrt(mixture.variance[:, None] * shares_of_sigma))
        centres.append(middle + (mixture.theta[:, free] - estimate.theta[free]) @ x.T)
        weights.append(weight * mixture.weight)
        freedoms.append(mixture.nu)
    centre, share_of, nu = (np.concatenate(each) for each in (centres, weights, freedoms))
    least = ROUND_OFF * max(1.0, float(np.max(np.abs(centre))))
    both = np.maximum(np.concatenate(scales, axis=1), least)
    values = []
    for scale, wanted in zip(both, (shares, median), strict=True):
        columns, index = np.unique(np.vstack([centre, scale]), axis=1, return_inverse=True)
        for share in wanted:
            each = [
                quantile_of(share_of, nu, column[: len(nu)], column[len(nu) :], share)
                for column in columns.T
            ]
            values.append(np.array(each)[np.ravel(index)])
    return np.array(values)


def predictive_quantile(estimate: Estimate, held: Problem, share: float) -> Array:
    """Value (n,) below which a `share` of new tests lies, in the unit of y.

    New tests are those of a new campaign, or of the only one (`Problem.foretold`). `held`: a
    problem whose rows describe them (its y is not used). Raises `InputError` for two campaigns.
    """
    if not estimate.problem.foretold:
        reason = f"must be {LEAST_CAMPAIGNS} or more to say anything of a new campaign"
        raise InputError("campaigns", 2, reason, "fewer do not tell how much campaigns differ")
    if estimate.is_exact:
        return held.predict(estimate.theta)
    part = Part(1.0, estimate, mixture_of(estimate), held)
    return np.asarray(averaged_quantile([part], [share])[0])


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
