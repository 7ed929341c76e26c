"""A regression with campaign effects: what is fitted, and what was found."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Flags
from workbench.base.arrays import Indices as Indices
from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.studs.quantities import Array

Prediction = Callable[[Array], Array]

DIFFERENCE = 1e-6
ROUND_OFF = 1e-7  # a sum of squares is known to 1e-16 of the observations, its root to 1e-8
LEAST_CAMPAIGNS = 3  # that tell how much campaigns differ
NEW, OWN = "new campaigns", "this laboratory alone"


@dataclass(frozen=True)
class Problem:
    """What is fitted: `y` (n,), campaigns (n,), the prediction f(theta) -> (n,), and bounds.

    `names` of the parameters, `start`, `lower`, `upper` (p,); `weights` (n,); `design` (n, p) for
    a linear prediction (then `predict` is design @ theta); `tangent` (n, p), slopes of any other
    near its best parameters, set by `fit`; `shares` (n,) of a test that each row counts for (None:
    one); `between`, scatter between campaigns if it is known; `level` (n,), along which the scatter
    may grow (None: it is one).
    """

    y: Array
    groups: Indices
    predict: Prediction
    names: tuple[str, ...]
    start: Array
    lower: Array
    upper: Array
    weights: Array
    labels: tuple[str, ...]
    design: Array | None = None
    tangent: Array | None = None
    shares: Array | None = None
    between: float | None = None
    level: Array | None = None

    @cached_property
    def moments(self) -> tuple[Array, Array, Array] | None:
        """Of a linear problem without bounds: cross products of (X, y), sums and weights.

        The sums and weights are those of each campaign; None for any other problem.
        """
        if self.design is None or np.any(np.isfinite([self.lower, self.upper])):
            return None
        joined = np.column_stack([self.design, self.y])
        weighted = self.weights[:, None] * joined
        sums = np.zeros((self.campaigns, joined.shape[1]))
        np.add.at(sums, self.groups, weighted)
        return joined.T @ weighted, sums, self.totals

    @cached_property
    def totals(self) -> Array:
        """Sum of the weights of each campaign (campaigns,)."""
        return np.asarray(
            np.bincount(self.groups, self.weights, minlength=self.campaigns), dtype=float
        )

    @cached_property
    def campaign_directions(self) -> tuple[Array, Array]:
        """Roots of the weights (n,), and their unit vector of each campaign (campaigns, n)."""
        root = np.sqrt(self.weights)
        member = self.groups == np.arange(self.campaigns)[:, None]
        return root, np.where(member, root, 0.0) / np.sqrt(self.totals)[:, None]

    @property
    def count(self) -> int:
        """Number of observations."""
        return len(self.y)

    def freedom(self, parameters: int) -> float:
        """Degrees of freedom that tell the scatter: what a robust loss bounds does not."""
        telling = float(self.count if self.shares is None else np.sum(self.shares))
        return max(telling - parameters, 1.0)

    @property
    def campaigns(self) -> int:
        """Number of campaigns."""
        return len(self.labels)

    @property
    def tells_campaigns(self) -> bool:
        """Whether scatter within and between campaigns can be told apart: some have two rows."""
        return self.between is not None or 1 < self.campaigns < self.count

    @property
    def foretold(self) -> str:
        """The campaigns whose new tests can be foretold, in words; empty for none."""
        if self.between is not None or self.campaigns >= LEAST_CAMPAIGNS:
            return NEW
        return OWN if self.campaigns == 1 else ""

    def index(self, name: str) -> int:
        """Place of a parameter. Raises `InputError` for an unknown one."""
        Choice(self.names).check("parameter", name)
        return self.names.index(name)


@dataclass(frozen=True)
class Estimate:
    """A fitted `Problem`.

    `theta` (p,); `sigma` within and `tau` between campaigns; `covariance` (p, p) of theta;
    `at_bound` (p,); `residuals` (n,), without the predicted effects of the campaigns.
    """

    problem: Problem
    theta: Array
    sigma: float
    tau: float
    covariance: Array
    at_bound: Flags
    residuals: Array

    @property
    def is_exact(self) -> bool:
        """Whether the prediction meets the observations to round-off: nothing scatters."""
        scale = max(1.0, float(np.max(np.abs(self.problem.y))))
        return float(np.hypot(self.sigma, self.tau)) <= ROUND_OFF * scale

    @property
    def ratio(self) -> float:
        """Ratio of variances, lambda = tau^2 / sigma^2."""
        return (self.tau / self.sigma) ** 2 if self.sigma > 0.0 else 0.0

    def parameter(self, name: str) -> float:
        """Estimate of a parameter."""
        return float(self.theta[self.problem.index(name)])


def problem(
    y: ArrayLike,
    campaigns: ArrayLike,
    predict: Prediction | None,
    names: tuple[str, ...],
    start: ArrayLike,
    *,
    lower: ArrayLike | float = -np.inf,
    upper: ArrayLike | float = np.inf,
    design: ArrayLike | None = None,
) -> Problem:
    """Make a checked problem; see `Problem` for the arguments. `design` replaces `predict`.

    Raises `InputError` for observations that are no numbers, or without a campaign each.
    """
    observed = np.atleast_1d(np.asarray(y, float))
    keys = np.asarray(campaigns).astype(str)
    labels, groups = np.unique(keys, return_inverse=True)
    matrix = None if design is None else np.asarray(design, float).reshape(len(observed), -1)
    p = len(names)
    if len(keys) != len(observed) or not np.all(np.isfinite(observed)):
        raise InputError("observations", observed.shape, "must be finite, each with a campaign")
    if predict is None:
        if matrix is None:
            raise InputError("predict", None, "must be given when there is no design matrix")
        predict = _linear(matrix)
    return Problem(
        observed,
        groups.astype(np.int64),
        predict,
        names,
        np.clip(np.asarray(start, float), lower, upper),
        np.broadcast_to(np.asarray(lower, float), p).copy(),
        np.broadcast_to(np.asarray(upper, float), p).copy(),
        np.ones(len(observed)),
        tuple(str(label) for label in labels),
        matrix,
    )


def location(values: Array, campaigns: ArrayLike) -> Problem:
    """The problem of a ``median`` of values (n,), each with its campaign."""
    start, design = [float(np.median(values))], np.ones((len(values), 1))
    return problem(values, campaigns, None, ("median",), start, design=design)


def _linear(matrix: Array) -> Prediction:
    return lambda theta: np.asarray(matrix @ theta)


def subset(given: Problem, rows: Indices) -> Problem:
    """The same problem on some `rows`; a prediction without design matrix is evaluated and cut."""
    labels, groups = np.unique(given.groups[rows], return_inverse=True)
    design = None if given.design is None else given.design[rows]
    whole = given.predict
    return replace(
        given,
        y=given.y[rows],
        groups=groups.astype(np.int64),
        predict=(lambda theta: whole(theta)[rows]) if design is None else _linear(design),
        weights=given.weights[rows],
        shares=None if given.shares is None else given.shares[rows],
        level=None if given.level is None else given.level[rows],
        labels=tuple(given.labels[k] for k in labels),
        design=design,
        tangent=None,
    )


def jacobian(given: Problem, theta: Array, free: Indices) -> Array:
    """Derivatives (n, free) of the prediction with respect to the `free` parameters."""
    if given.design is not None:
        return given.design[:, free]
    base = given.predict(theta)
    columns = np.empty((given.count, len(free)))
    for column, k in enumerate(free):
        step = DIFFERENCE * max(abs(theta[k]), 1e-2)
        if theta[k] + step > given.upper[k]:
            step = -step
        moved = theta.copy()
        moved[k] += step
        columns[:, column] = (given.predict(moved) - base) / step
    return columns


def whiten(given: Problem, x: Array, ratio: float) -> Array:
    """V^(-1/2) sigma applied to the columns of x (n, k) or (n,) for a value of lambda."""
    root, directions = given.campaign_directions
    phi = 1.0 - 1.0 / np.sqrt(1.0 + ratio * given.totals)
    scaled = (root * x.T).T
    along = (directions @ scaled).T * phi
    return np.asarray(scaled - directions.T @ along.T)


def log_determinant(normal: Array) -> Array:
    """Logarithms of the determinants of normal matrices (k, p, p), bounded where singular."""
    sign, value = np.linalg.slogdet(normal)
    if np.all(sign > 0.0):
        return np.asarray(value)
    # singular to round-off: bounded, so that the search goes on until `fit` refuses it
    values = np.linalg.eigvalsh(normal)
    least = 1e-14 * np.maximum(values.max(axis=1, keepdims=True), 1e-300)
    return np.asarray(np.sum(np.log(np.maximum(values, least)), axis=1))
