"""What is left out, predicted from the others: campaigns, and single tests.

Relations are weighed by it, outliers found, and the influence of every test on the answer. Also
which formulas the scatter of tests tells apart.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from workbench.arrays import Flags
from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.intervals import (
    LEAST_CAMPAIGNS,
    predictive_quantile,
    tails_of,
)
from workbench.studs.statistics.mixed import ROUND_OFF, Estimate, fit, solve_theta
from workbench.studs.statistics.problem import Problem, jacobian, subset, whiten

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


def usual_distance(estimate: Estimate) -> float:
    """Deleted residual that none of as many tests exceeds but by chance (Bonferroni)."""
    from scipy.special import stdtrit

    given = estimate.problem
    nu = max(given.count - int((~estimate.at_bound).sum()) - 1, 1)
    return float(stdtrit(nu, 1.0 - 0.5 * CHANCE / given.count))


def outliers(estimate: Estimate) -> list[Outlier]:
    """Tests farther off than chance lets any be (`usual_distance`), farthest first."""
    given, distance = estimate.problem, deleted_residuals(estimate)
    limit, far = usual_distance(estimate), []
    for k in np.argsort(-np.abs(distance)):
        if abs(distance[k]) <= limit:
            break
        try:
            theta = fit(subset(given, np.flatnonzero(np.arange(given.count) != k))).theta
        except (InputError, SolverError):
            theta = estimate.theta
        far.append(Outlier(int(k), float(distance[k]), float(given.predict(theta)[k])))
    return far


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
    distance = deleted_residuals(estimate)
    far = np.abs(distance) > usual_distance(estimate)
    table = rows[["campaign", "specimen"]].assign(answer=answer, value=value, without=without)
    return table.assign(distance=distance, outlier=far)


LIKE = 1.01  # ratio of scatters that is no difference: an interval must lie above it
_EQUAL = 1e-12  # of squares of logarithms


def rank_scatters(tests: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Formulas by their scatter within campaigns, the least first, among equals the first.

    Arguments: `tests`, rows with `of` (the formula), campaign, specimen and ratio, test over
    prediction; those count that every formula has a value for. Columns of the result: `of`, `ratio`
    of the scatter to the least one with its interval `low`, `high` (NaN with too few tests), and
    `apart`, whether that lies above `LIKE`. Source: Pitman 1939, standard deviations of correlated
    normal variables.
    """
    from scipy.special import stdtrit

    names = list(dict.fromkeys(tests["of"]))
    ratios = tests.pivot_table("ratio", ["campaign", "specimen"], "of")[names]
    logs = ratios.dropna().apply(np.log)
    campaigns = logs.groupby(level="campaign")
    left, nu = logs - campaigns.transform("mean"), len(logs) - campaigns.ngroups - 1
    products = left.T.to_numpy() @ left.to_numpy()
    squares = np.diag(products)
    best = int(np.flatnonzero(squares <= squares.min() + _EQUAL)[0])
    rows: list[dict[str, Any]] = [{"of": names.pop(best), "ratio": 1.0, "apart": False}]
    for k in (k for k in range(len(squares)) if k != best):
        row = {"of": str(left.columns[k]), "apart": False}
        if nu > 0 and squares[best] > _EQUAL:
            ratio = float(np.sqrt(squares[k] / squares[best]))
            unshared = max(1.0 - products[k, best] ** 2 / (squares[k] * squares[best]), 0.0)
            wide = 1.0 + 2.0 * unshared * float(stdtrit(nu, 0.5 + 0.5 * confidence)) ** 2 / nu
            factor = float(np.sqrt(wide + np.sqrt(wide**2 - 1.0)))
            ends = {"low": ratio / factor, "high": ratio * factor}
            row |= {"ratio": ratio, **ends, "apart": ratio / factor > LIKE}
        rows.append(row)
    return pd.DataFrame(rows, columns=["of", "ratio", "low", "high", "apart"])
