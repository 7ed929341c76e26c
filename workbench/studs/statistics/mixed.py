"""Regression with a random effect per campaign.

y_ij = f_ij(theta) + u_j + e_ij, u_j ~ N(0, tau^2) for campaign j, e_ij ~ N(0, sigma^2 / w_ij).
Restricted maximum likelihood, profiled over theta and sigma, so that one variable is left: the
ratio lambda = tau^2 / sigma^2. Rows of a campaign are whitened by Z = I - phi z z' / z'z with
z = sqrt(w) and phi = 1 - (1 + lambda sum w)^(-1/2). Source: Pinheiro and Bates 2000, chapters 2
and 7; degrees of freedom after Satterthwaite (see `satterthwaite`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array

Indices = NDArray[np.int64]
Prediction = Callable[[Array], Array]

GRID = (0.0, 0.01, 0.05, 0.2, 0.6, 2.0, 6.0, 20.0, 100.0, 1000.0)  # lambda, to find the valley
ITERATIONS = 60
STEP_TOLERANCE = 1e-9
DIFFERENCE = 1e-6
SEARCHES = 30
SIMPLEX = 2000  # evaluations per parameter where two terms of a formula are equal: a kink


@dataclass(frozen=True)
class Problem:
    """What is fitted: `y` (n,), campaigns (n,), the prediction f(theta) -> (n,), and bounds.

    `names` of the parameters, `start`, `lower`, `upper` (p,); `weights` (n,); `design` (n, p) for
    a linear prediction (then `predict` is design @ theta).
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

    @cached_property
    def moments(self) -> tuple[Array, Array, Array] | None:
        """Of a linear problem: cross products of (X, y), their sums and weights per campaign."""
        if self.design is None:
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
    def is_free(self) -> bool:
        """Whether no parameter has a bound."""
        return not np.any(np.isfinite([self.lower, self.upper]))

    @property
    def count(self) -> int:
        """Number of observations."""
        return len(self.y)

    @property
    def campaigns(self) -> int:
        """Number of campaigns."""
        return len(self.labels)

    @property
    def tells_campaigns(self) -> bool:
        """Whether scatter within and between campaigns can be told apart: some have two rows."""
        return 1 < self.campaigns < self.count

    def without(self, label: str) -> tuple[Indices, Indices]:
        """Rows outside and inside the campaign `label`."""
        inside = self.groups == self.labels.index(label)
        return np.flatnonzero(~inside), np.flatnonzero(inside)


def problem(
    y: ArrayLike,
    campaigns: ArrayLike,
    predict: Prediction | None,
    names: tuple[str, ...],
    start: ArrayLike,
    *,
    lower: ArrayLike | float = -np.inf,
    upper: ArrayLike | float = np.inf,
    weights: ArrayLike | None = None,
    design: ArrayLike | None = None,
    fitted: bool = True,
) -> Problem:
    """Make a checked problem; see `Problem` for the arguments. `design` replaces `predict`.

    With `fitted` False the rows only describe tests to be predicted. Raises `InputError` when
    there are no more observations than parameters to fit.
    """
    observed = np.atleast_1d(np.asarray(y, float))
    keys = np.asarray(campaigns).astype(str)
    labels, groups = np.unique(keys, return_inverse=True)
    matrix = None if design is None else np.asarray(design, float).reshape(len(observed), -1)
    p = len(names)
    if len(keys) != len(observed) or not np.all(np.isfinite(observed)):
        raise InputError("observations", observed.shape, "must be finite, each with a campaign")
    if fitted and len(observed) <= p:
        raise InputError(
            "observations", len(observed), f"must be more than the {p} parameters",
            "hold parameters fixed, or bring more tests",
        )  # fmt: skip
    if predict is None:
        if matrix is None:
            raise InputError("predict", None, "must be given when there is no design matrix")
        predict = _linear(matrix)
    return Problem(
        observed, groups.astype(np.int64), predict, names,
        np.clip(np.asarray(start, float), lower, upper),
        np.broadcast_to(np.asarray(lower, float), p).copy(),
        np.broadcast_to(np.asarray(upper, float), p).copy(),
        np.ones(len(observed)) if weights is None else np.asarray(weights, float),
        tuple(str(label) for label in labels), matrix,
    )  # fmt: skip


def _linear(matrix: Array) -> Prediction:
    return lambda theta: np.asarray(matrix @ theta)


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
    root = np.sqrt(given.weights)
    phi = 1.0 - 1.0 / np.sqrt(1.0 + ratio * given.totals)
    columns = x if x.ndim == 2 else x[:, None]
    scaled = root[:, None] * columns
    result = np.empty_like(scaled)
    for k in range(scaled.shape[1]):
        sums = np.bincount(given.groups, root * scaled[:, k], minlength=given.campaigns)
        result[:, k] = scaled[:, k] - root * (phi * sums / given.totals)[given.groups]
    return result if x.ndim == 2 else result[:, 0]


@dataclass(frozen=True)
class Estimate:
    """A fitted `Problem`.

    `theta` (p,); `sigma` within and `tau` between campaigns; `criterion`, twice the negative
    restricted log-likelihood (without constants); `covariance` (p, p) of theta; `at_bound` (p,);
    `effects` (campaigns,), predicted campaign effects; `residuals` (n,) without them.
    """

    problem: Problem
    theta: Array
    sigma: float
    tau: float
    criterion: float
    covariance: Array
    at_bound: NDArray[np.bool_]
    effects: Array
    residuals: Array

    @property
    def ratio(self) -> float:
        """Ratio of variances, lambda = tau^2 / sigma^2."""
        return (self.tau / self.sigma) ** 2 if self.sigma > 0.0 else 0.0

    def parameter(self, name: str) -> float:
        """Estimate of a parameter."""
        return float(self.theta[self.problem.names.index(name)])


@dataclass(frozen=True)
class Solved:
    """Best free parameters for a lambda.

    `theta` (p,); whitened sum of squares `size`; normal matrix `normal` (own, own) of the free
    parameters off their bounds; `stuck` (free,) on them.
    """

    theta: Array
    size: float
    normal: Array
    stuck: NDArray[np.bool_]


def solve_theta(given: Problem, ratio: float, start: Array, free: Indices) -> Solved:
    """Best free parameters for a given lambda; others stay as in `start`.

    Linear problems without bounds in closed form, others by damped Gauss-Newton within bounds, and
    without slopes where that does not converge at a kink.
    Raises `InputError` for a parameter without influence, `SolverError`.
    """
    if given.moments is not None and given.is_free:
        return _solve_linear(given, ratio, start, free)
    return _solve_damped(given, ratio, start, free)


def _solve_linear(given: Problem, ratio: float, start: Array, free: Indices) -> Solved:
    assert given.moments is not None
    cross, sums, totals = given.moments
    matrix = cross - (sums.T * (ratio / (1.0 + ratio * totals))) @ sums
    # held parameters move to the right side: r = y - X_held theta_held
    residual = -start.copy()
    residual[free] = 0.0
    combination = np.append(residual, 1.0)
    right = matrix[free] @ combination
    normal = matrix[np.ix_(free, free)]
    theta = start.copy()
    if len(free):
        _check_influence(given, np.diag(normal), free, start)
        theta[free] = _solved(normal, right)
    combination[free] = -theta[free]
    size = float(combination @ matrix @ combination)
    return Solved(theta, max(size, 0.0), normal, np.zeros(len(free), bool))


def _solved(normal: Array, right: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(normal, right))
    except np.linalg.LinAlgError:  # parameters that cannot be told apart: refused by `fit`
        return np.asarray(np.linalg.lstsq(normal, right, rcond=None)[0])


def _log_determinant(normal: Array) -> float:
    sign, value = np.linalg.slogdet(normal)
    if sign > 0.0:
        return float(value)
    # singular to round-off: bounded, so that the search goes on until `fit` refuses it
    values = np.linalg.eigvalsh(normal)
    return float(np.sum(np.log(np.maximum(values, 1e-14 * max(values.max(), 1e-300)))))


def _check_influence(given: Problem, scale: Array, free: Indices, theta: Array) -> None:
    if len(scale) and np.any(scale <= 0.0):
        k = free[int(np.argmin(scale))]
        raise InputError(
            given.names[k], float(theta[k]), "has no influence on any observation",
            "hold it fixed, or bring tests that tell",
        )  # fmt: skip


def _solve_damped(given: Problem, ratio: float, start: Array, free: Indices) -> Solved:
    theta = start.copy()
    residual = whiten(given, given.y - given.predict(theta), ratio)
    size = float(residual @ residual)
    damping, moved = 1e-6, np.inf
    for _ in range(ITERATIONS):
        j = whiten(given, jacobian(given, theta, free), ratio)
        gradient = j.T @ residual
        stuck = ((theta[free] <= given.lower[free]) & (gradient < 0.0)) | (
            (theta[free] >= given.upper[free]) & (gradient > 0.0)
        )
        own = np.flatnonzero(~stuck)
        normal = j[:, own].T @ j[:, own]
        if len(own) == 0 or moved < STEP_TOLERANCE:
            return Solved(theta, size, normal, stuck)
        scale = np.diag(normal)
        if not np.any(scale > 0.0):
            return Solved(theta, size, normal, stuck)
        for _ in range(SEARCHES):
            # a parameter without influence here (a kink of the prediction) stays where it is
            matrix = normal + damping * np.diag(scale)
            trial = theta.copy()
            trial[free[own]] += np.linalg.lstsq(matrix, gradient[own], rcond=None)[0]
            trial = np.clip(trial, given.lower, given.upper)
            new = whiten(given, given.y - given.predict(trial), ratio)
            new_size = float(new @ new)
            if np.isfinite(new_size) and new_size <= size:
                break
            damping = max(10.0 * damping, 1e-6)
        else:
            return Solved(theta, size, normal, stuck)  # at the minimum to round-off
        moved = float(np.max(np.abs(trial - theta) / (np.abs(theta) + 1e-3)))
        theta, residual, size = trial, new, new_size
        damping *= 0.1
    return _solve_without_slopes(given, ratio, theta, free)


def _solve_without_slopes(given: Problem, ratio: float, start: Array, free: Indices) -> Solved:
    """Best free parameters at a kink, along which Gauss-Newton only zigzags: simplex search."""
    from scipy.optimize import minimize

    def at(values: Array) -> Array:
        theta = start.copy()
        theta[free] = values
        return theta

    def size_at(values: Array) -> float:
        rest = whiten(given, given.y - given.predict(at(values)), ratio)
        return float(rest @ rest)

    first = size_at(start[free])
    found = minimize(
        size_at, start[free], method="Nelder-Mead",
        bounds=list(zip(given.lower[free], given.upper[free], strict=True)),
        options={"xatol": 1e-9, "fatol": 1e-12 * first, "maxfev": SIMPLEX * len(free)},
    )  # fmt: skip
    if not found.success:
        raise SolverError(
            "the regression", float(first - found.fun), f"{ITERATIONS} damped Gauss-Newton steps "
            f"and {SIMPLEX * len(free)} simplex evaluations",
        )  # fmt: skip
    theta = at(np.asarray(found.x))
    residual = whiten(given, given.y - given.predict(theta), ratio)
    j = whiten(given, jacobian(given, theta, free), ratio)
    gradient = j.T @ residual
    stuck = ((theta[free] <= given.lower[free]) & (gradient < 0.0)) | (
        (theta[free] >= given.upper[free]) & (gradient > 0.0)
    )
    own = np.flatnonzero(~stuck)
    return Solved(theta, float(found.fun), j[:, own].T @ j[:, own], stuck)


def criterion_at(
    given: Problem, ratio: float, start: Array, free: Indices
) -> tuple[float, float, Solved]:
    """Twice the negative restricted log-likelihood for a lambda, sigma^2, and the parameters."""
    solved = solve_theta(given, ratio, start, free)
    m = given.count - len(solved.normal)
    told = np.diag(solved.normal) > 0.0  # without influence: refused by `fit`, once it is final
    normal = solved.normal if told.all() else solved.normal[np.ix_(told, told)]
    information = _log_determinant(normal) if len(normal) else 0.0
    variance = max(solved.size / m, np.finfo(float).tiny)
    determinant = float(np.sum(np.log1p(ratio * given.totals)))
    return m * float(np.log(variance)) + information + determinant + m, variance, solved


def best_ratio(
    given: Problem, start: Array, free: Indices, hint: float | None = None
) -> tuple[float, float, Array]:
    """The lambda of the smallest criterion: lambda, the criterion, theta (p,).

    `hint`, a lambda known to be near (then only its neighbourhood and zero are searched).
    """
    from scipy.optimize import minimize_scalar

    if not given.tells_campaigns:
        value, _, solved = criterion_at(given, 0.0, start, free)
        return 0.0, value, solved.theta
    best_theta = start.copy()

    def at(ratio: float) -> float:
        nonlocal best_theta
        value, _, solved = criterion_at(given, ratio, best_theta, free)
        best_theta = solved.theta
        return value

    grid = GRID if hint is None else (0.0, *(hint * f for f in (0.3, 1.0, 3.0) if hint > 0.0))
    values = [at(ratio) for ratio in grid]
    k = int(np.argmin(values))
    low = grid[max(k - 1, 0)]
    high = grid[min(k + 1, len(grid) - 1)]
    if hint is not None and k == len(grid) - 1:
        high = GRID[-1]
    if high <= low:
        high = GRID[1]
    found = minimize_scalar(
        lambda t: at(float(np.expm1(t))), bounds=(np.log1p(low), np.log1p(high)),
        method="bounded", options={"xatol": 1e-4 if hint is None else 5e-3},
    )  # fmt: skip
    ratio, value = float(np.expm1(found.x)), float(found.fun)
    if values[k] <= value:
        ratio, value = grid[k], values[k]
    return ratio, value, solve_theta(given, ratio, best_theta, free).theta


def fit(given: Problem, *, start: Array | None = None) -> Estimate:
    """Fit a problem by restricted maximum likelihood. Raises `SolverError` or `InputError`.

    With one campaign its effect cannot be told from the rest: tau is 0 and the result says
    nothing about other campaigns. With one row per campaign tau is 0 and sigma holds both scatters.
    """
    free = np.arange(len(given.names))
    ratio, _, theta = best_ratio(given, given.start if start is None else start, free)
    value, variance, solved = criterion_at(given, ratio, theta, free)
    theta = solved.theta
    own = np.flatnonzero(~solved.stuck)
    _check_influence(given, np.diag(solved.normal), own, theta)
    if np.linalg.matrix_rank(solved.normal, hermitian=True) < len(own):
        names = ", ".join(given.names[k] for k in own)
        raise InputError(
            "parameters", names, "cannot be told apart by these observations",
            "hold one of them fixed, or bring tests that differ in it",
        )  # fmt: skip
    covariance = np.full((len(free), len(free)), np.nan)
    covariance[np.ix_(own, own)] = variance * np.linalg.pinv(solved.normal)
    residual = given.y - given.predict(theta)
    sums = np.bincount(given.groups, given.weights * residual, minlength=given.campaigns)
    total = given.totals
    effects = ratio * sums / (1.0 + ratio * total)
    return Estimate(
        given, theta, float(np.sqrt(variance)), float(np.sqrt(ratio * variance)), value,
        covariance, solved.stuck, effects, residual - effects[given.groups],
    )  # fmt: skip


def fit_robust(given: Problem, loss: str = "huber", *, rounds: int = 30) -> Estimate:
    """Fit with a robust loss by iterated reweighting of the observations.

    Arguments: `loss`, ``linear`` (none), ``huber`` (1.345) or ``bisquare`` (4.685); the scale is
    the median absolute residual / 0.6745. The scatter found is that of the body of the tests;
    outliers are down-weighted, not removed. Source: Huber and Ronchetti 2009. Raises
    `InputError`.
    """
    losses = {"linear": None, "huber": 1.345, "bisquare": 4.685}
    if loss not in losses:
        raise InputError("loss", loss, "must be one of " + ", ".join(losses))
    result = fit(given)
    tuning = losses[loss]
    if tuning is None:
        return result
    for _ in range(rounds):
        scale = float(np.median(np.abs(result.residuals))) / 0.6745
        if scale <= 0.0:
            return result
        z = np.abs(result.residuals) / (tuning * scale)
        if loss == "huber":
            weights = 1.0 / np.maximum(z, 1.0)
        else:
            weights = np.square(np.maximum(1.0 - z * z, 1e-4))
        if np.max(np.abs(weights - result.problem.weights)) < 1e-4:
            return result
        result = fit(replace(given, weights=weights), start=result.theta)
    return result


def subset(given: Problem, rows: Indices, predict: Prediction | None = None) -> Problem:
    """The same problem on some `rows`, with each drawn campaign kept apart by its label.

    `predict` on those rows is needed for predictions that are no design matrix; by default the
    whole prediction is evaluated and cut.
    """
    labels, groups = np.unique(given.groups[rows], return_inverse=True)
    design = None if given.design is None else given.design[rows]
    whole = given.predict
    own = predict or (_linear(design) if design is not None else lambda theta: whole(theta)[rows])
    return replace(
        given, y=given.y[rows], groups=groups.astype(np.int64), predict=own,
        weights=given.weights[rows], labels=tuple(given.labels[k] for k in labels),
        design=design,
    )  # fmt: skip
