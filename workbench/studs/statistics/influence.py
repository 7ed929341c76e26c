"""Tests that the others do not expect, and how every test moves the answer of a fit."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import ROUND_OFF, Estimate, fit, solve_theta
from workbench.studs.statistics.problem import jacobian, subset, whiten

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
    open_ = 1.0 - np.einsum("ni,ij,nj->n", j, np.linalg.pinv(j.T @ j), j)
    told = open_ > 1e-9  # others say something of it
    own = np.where(told, z**2 / np.where(told, open_, 1.0), 0.0)
    floor = (ROUND_OFF * max(1.0, float(np.max(np.abs(given.y))))) ** 2
    others = np.maximum((z @ z - own) / nu, floor)
    return np.asarray(np.sign(z) * np.sqrt(own / others))


def usual_distance(estimate: Estimate) -> float:
    """Deleted residual that none of as many tests exceeds but by chance (Bonferroni)."""
    from scipy.special import stdtrit

    given = estimate.problem
    nu = max(given.count - int((~estimate.at_bound).sum()) - 1, 1)
    return float(stdtrit(nu, 1.0 - 0.5 * CHANCE / given.count))


def outliers(estimate: Estimate) -> list[Outlier]:
    """Tests farther off than chance lets any be (`usual_distance`), farthest first."""
    given, distance = estimate.problem, deleted_residuals(estimate)
    limit, found = usual_distance(estimate), []
    for k in np.argsort(-np.abs(distance)):
        if abs(distance[k]) <= limit:
            break
        try:
            theta = fit(subset(given, np.flatnonzero(np.arange(given.count) != k))).theta
        except (InputError, SolverError):
            theta = estimate.theta
        found.append(Outlier(int(k), float(distance[k]), float(given.predict(theta)[k])))
    return found


def without_each(estimate: Estimate) -> Array:
    """Parameters (n, p) that the other tests give where each test is left out.

    The ratio of variances stays that of the fit; NaN where the others do not tell them.
    """
    given, every = estimate.problem, np.arange(estimate.problem.count)
    free, found = np.arange(len(given.names)), np.full((given.count, len(given.names)), np.nan)
    for k in every if given.count > len(free) + 1 else ():
        try:
            others = subset(given, np.flatnonzero(every != k))
            found[k] = solve_theta(others, estimate.ratio, estimate.theta, free).theta
        except (InputError, SolverError):
            continue
    return found


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
    told = rows[["campaign", "specimen"]].assign(answer=answer, value=value, without=without)
    return told.assign(distance=distance, outlier=far)
