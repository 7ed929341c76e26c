"""Regression with a random effect per campaign: what is fitted, and what was found.

y_ij = f_ij(theta) + u_j + e_ij, u_j ~ N(0, tau^2) for campaign j, e_ij ~ N(0, sigma^2 / w_ij).
Restricted maximum likelihood, profiled over theta and sigma, so that one variable is left: the
ratio lambda = tau^2 / sigma^2. Rows of a campaign are whitened by Z = I - phi z z' / z'z with
z = sqrt(w) and phi = 1 - (1 + lambda sum w)^(-1/2). Source: Pinheiro and Bates 2000, 2 and 7.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Flags
from workbench.base.arrays import Indices as Indices
from workbench.base.errors import InputError, SolverError
from workbench.base.fields import Choice
from workbench.studs.tables import Array

Prediction = Callable[[Array], Array]

DIFFERENCE = 1e-6
ROUND_OFF = 1e-7  # a sum of squares is known to 1e-16 of the observations, its root to 1e-8
LEAST_CAMPAIGNS = 3  # that tell how much campaigns differ
NEW, OWN = "new campaigns", "this laboratory alone"


@dataclass(frozen=True)
class Problem:
    """Problem to fit: `y` (n,), campaigns (n,), the prediction f(theta) -> (n,), and bounds.

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
    """Problem on some `rows`; a prediction without design matrix is evaluated and cut."""
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


GRID = (0.0, 0.01, 0.05, 0.2, 0.6, 2.0, 6.0, 20.0, 1e2, 1e3, 1e4, 1e6)  # lambda, to find the valley
TOLERANCES: dict[str, float | None] = {"xtol": 1e-10, "ftol": 1e-13, "gtol": None}
EVALUATIONS = 100
LEAST_RATIO = 1e-12  # lambda where tau is known
SIMPLEX = 2000  # evaluations per parameter
NEAR, BEYOND = (0.625, 1.0, 1.6), 100.0  # times a lambda known to be near
LOSSES = {"linear": 0.0, "huber": 1.345, "bisquare": 4.685}
REWEIGHTINGS = 30
ROUNDS, CUTS = 3, 41  # of the valley of a linear problem: 1/8000 of it is left
RESOLUTION, ROUGH = 1e-6, 1e-3  # of ln(1 + lambda), of a fit and of a profile around it


@dataclass(frozen=True)
class Solved:
    """Best free parameters for a lambda.

    `theta` (p,); whitened sum of squares `size`; normal matrix `normal` (inner, inner) of the free
    parameters off their bounds; `stuck` (free,) on them.
    """

    theta: Array
    size: float
    normal: Array
    stuck: Flags


def solve_theta(given: Problem, ratio: float, start: Array, free: Indices) -> Solved:
    """Best free parameters for a given lambda; others stay as in `start`.

    Linear problems without bounds in closed form, others by bounded least squares (dogleg steps in
    rectangular trust regions, Voglis and Lagaris 2004), or a simplex where steps zigzag. Raises
    `InputError` for a parameter without influence, `SolverError`.
    """
    if given.moments is None:
        return _solve_bounded(given, ratio, start, free)
    theta, (best, size, normal) = start.copy(), line_at(given, np.full(1, ratio), start, free)
    theta[free] = best[0]
    return Solved(theta, max(float(size[0]), 0.0), normal[0], np.zeros(len(free), bool))


def line_at(
    given: Problem, ratios: Array, start: Array, free: Indices
) -> tuple[Array, Array, Array]:
    """Best parameters (k, free), sums of squares and normal matrices of a line for lambda (k,)."""
    assert given.moments is not None
    cross, sums, totals = given.moments
    shrink = ratios[:, None] / (1.0 + ratios[:, None] * totals)
    matrices = cross - np.einsum("kc,ci,cj->kij", shrink, sums, sums)
    # held parameters move to the right side: r = y - X_held theta_held
    combination = np.append(-start, 1.0)
    combination[free] = 0.0
    right = matrices[:, free] @ combination
    normal = matrices[np.ix_(np.arange(len(ratios)), free, free)]
    _check_influence(given, np.diag(normal[0]), free, start)
    try:
        best = np.linalg.solve(normal, right[..., None])[..., 0]
    except np.linalg.LinAlgError:  # parameters that cannot be told apart: refused by `fit`
        best = (np.linalg.pinv(normal) @ right[..., None])[..., 0]
    size = combination @ matrices @ combination - np.sum(best * right, axis=1)
    return best, size, normal


def _check_influence(given: Problem, scale: Array, free: Indices, theta: Array) -> None:
    if len(scale) and np.any(scale <= 0.0):
        k = free[int(np.argmin(scale))]
        reason = "has no influence on any observation"
        advice = "hold it fixed, or bring tests that tell"
        raise InputError(given.names[k], float(theta[k]), reason, advice)


def _solve_bounded(given: Problem, ratio: float, start: Array, free: Indices) -> Solved:
    from scipy.optimize import least_squares, minimize

    def at(values: Array) -> Array:
        theta = start.copy()
        theta[free] = values
        return theta

    def residual(values: Array) -> Array:
        return whiten(given, given.predict(at(values)) - given.y, ratio)

    def slopes(values: Array) -> Array:
        return whiten(given, jacobian(given, at(values), free), ratio)

    low, high, x = given.lower[free], given.upper[free], start[free]
    if not len(free):
        rest = residual(x)
        return Solved(start.copy(), float(rest @ rest), np.zeros((0, 0)), np.zeros(0, bool))
    result = least_squares(
        residual, x, slopes, (low, high), "dogbox", **TOLERANCES, max_nfev=EVALUATIONS
    )
    x, rest, j = np.asarray(result.x), result.fun, result.jac
    if result.status <= 0:  # steps zigzag where two terms of a formula are equal: without slopes
        sides, enough = list(zip(low, high, strict=True)), SIMPLEX * len(free)
        options = {"xatol": 1e-9, "fatol": 2e-12 * float(result.cost), "maxfev": enough}
        result = minimize(
            lambda v: float(np.sum(residual(v) ** 2)), x, method="Nelder-Mead",
            bounds=sides, options=options,
        )  # fmt: skip
        if not result.success:
            raise SolverError("the regression", float(result.fun), f"{enough} simplex evaluations")
        x = np.asarray(result.x)
        rest, j = residual(x), slopes(x)
    downhill = -(j.T @ rest)
    stuck = ((x <= low) & (downhill < 0.0)) | ((x >= high) & (downhill > 0.0))
    inner = np.flatnonzero(~stuck)
    return Solved(at(x), float(rest @ rest), j[:, inner].T @ j[:, inner], stuck)


def criterion_at(
    given: Problem, ratio: float, start: Array, free: Indices
) -> tuple[float, float, Solved]:
    """Twice the negative restricted log-likelihood for a lambda, sigma^2, and the parameters.

    What a non-linear prediction counts for parameters is that of its `tangent`.
    """
    solved = solve_theta(given, ratio, start, free)
    normal = solved.normal
    if given.tangent is not None:
        x = given.tangent[:, free]
        x = whiten(given, x[:, np.any(x != 0.0, axis=0)], ratio)
        normal = x.T @ x
    ratios, size = np.full(1, ratio), np.full(1, solved.size)
    value, variance = criterion_of(given, ratios, size, normal[None])
    return float(value[0]), float(variance[0]), solved


def criterion_of(given: Problem, ratios: Array, size: Array, normal: Array) -> tuple[Array, Array]:
    """Criterion and sigma^2 (k,) for lambda (k,): the best sigma, or that of a known tau."""
    m = given.freedom(normal.shape[-1])
    size = np.maximum(size, m * np.finfo(float).tiny)
    variance = size / m
    if given.between is not None:
        variance = given.between**2 / np.maximum(ratios, LEAST_RATIO)
    determinant = np.log1p(ratios[:, None] * given.totals).sum(axis=1)
    information = log_determinant(normal) + determinant
    return m * np.log(variance) + size / variance + information, variance


def criteria_at(given: Problem, ratios: Array, start: Array, free: Indices) -> tuple[Array, Array]:
    """Criterion and sigma^2 of `criterion_at` (k,) for many lambda (k,), of a line all at once."""
    if given.moments is not None:
        return criterion_of(given, ratios, *line_at(given, ratios, start, free)[1:])
    values, last = np.empty((2, len(ratios))), start
    for i, ratio in enumerate(ratios):
        # with kinks the best parameters may lie in another valley than those of the last ratio
        tried = [criterion_at(given, float(ratio), begin, free) for begin in (last, start)[: i + 1]]
        *values[:, i], solved = min(tried, key=lambda each: each[0])
        last = solved.theta
    return values[0], values[1]


def best_ratio(
    given: Problem, start: Array, free: Indices, hint: float | None = None
) -> tuple[float, float, Array]:
    """The lambda of the smallest criterion: lambda, the criterion, theta (p,).

    `hint`, a lambda known to be near (then only its neighbourhood and zero are searched).
    """
    from scipy.optimize import minimize_scalar

    theta, linear = start, given.moments is not None
    tried: dict[float, tuple[float, Array]] = {}

    def at(x: float) -> float:
        """Criterion at lambda = exp(x) - 1, from the parameters of the last one on."""
        nonlocal theta
        value, _, solved = criterion_at(given, float(np.expm1(x)), theta, free)
        theta = solved.theta
        tried[float(x)] = value, theta
        return value

    def valley(cuts: Array) -> tuple[int, float, float]:
        """Place of the lowest criterion, and the cuts on either side of it."""
        values = criteria_at(given, np.expm1(cuts), start, free)[0] if linear else [*map(at, cuts)]
        k = int(np.argmin(values))
        return k, float(cuts[max(k - 1, 0)]), float(cuts[min(k + 1, len(cuts) - 1)])

    if not given.tells_campaigns:
        return 0.0, at(0.0), theta
    cuts = np.log1p(GRID if hint is None else (0.0, *(hint * f for f in NEAR if hint > 0.0)))
    k, low, high = valley(cuts)
    if hint is not None and k == len(cuts) - 1:  # beyond what was thought near
        high = max(high + np.log(BEYOND), float(np.log1p(GRID[-1])))
    if linear:
        at(cuts[k])  # the best of the grid, which finer cuts may miss
        for _ in range(ROUNDS):
            cuts = np.linspace(low, high, CUTS)
            k, low, high = valley(cuts)
        at(cuts[k])
    else:
        options = {"xatol": RESOLUTION if hint is None else ROUGH}
        minimize_scalar(at, bounds=(low, high), options=options)
    x = min(tried, key=lambda x: tried[x][0])
    return float(np.expm1(x)), *tried[x]


def _with_tangent(given: Problem, ratio: float, start: Array, free: Indices) -> Problem:
    """The problem with the slopes of its prediction at the best parameters for a lambda.

    Parameters on a bound have none. The criterion keeps them, so that it does not jump where a
    parameter reaches a bound.
    """
    if given.moments is not None:
        return given
    solved = solve_theta(given, ratio, start, free)
    slopes = np.where(solved.stuck, 0.0, jacobian(given, solved.theta, free))
    return replace(given, tangent=slopes)


def fit(given: Problem, *, start: Array | None = None) -> Estimate:
    """Fit a problem by restricted maximum likelihood. Raises `SolverError` or `InputError`.

    With one campaign its effect cannot be told from the rest: tau is 0 and the result says
    nothing about other campaigns. With one row per campaign tau is 0 and sigma holds both scatters.
    """
    free = np.arange(len(given.names))
    if given.count <= len(free):
        advice = "hold parameters fixed, or bring more tests"
        allowed = f"must be more than the {len(free)} parameters"
        raise InputError("observations", given.count, allowed, advice)
    ratio, theta = 0.0, given.start if start is None else start
    stuck = np.ones(len(free), bool)
    for _ in range(ROUNDS):
        given, stuck_before = _with_tangent(given, ratio, theta, free), stuck
        ratio, _, theta = best_ratio(given, theta, free)
        _, variance, solved = criterion_at(given, ratio, theta, free)
        theta, stuck = solved.theta, solved.stuck
        if given.moments is not None or np.array_equal(stuck, stuck_before):
            break
    inner = np.flatnonzero(~solved.stuck)
    _check_influence(given, np.diag(solved.normal), inner, theta)
    if np.linalg.matrix_rank(solved.normal, hermitian=True) < len(inner):
        names = ", ".join(given.names[k] for k in inner)
        advice = "hold one of them fixed, or bring tests that differ in it"
        raise InputError("parameters", names, "cannot be told apart by these observations", advice)
    covariance = np.full((len(free), len(free)), np.nan)
    covariance[np.ix_(inner, inner)] = variance * np.linalg.pinv(solved.normal)
    residual = given.y - given.predict(theta)
    sums = np.bincount(given.groups, given.weights * residual, minlength=given.campaigns)
    effects = ratio * sums / (1.0 + ratio * given.totals)
    sigma, tau = float(np.sqrt(variance)), float(np.sqrt(ratio * variance))
    rest = residual - effects[given.groups]
    return Estimate(given, theta, sigma, tau, covariance, solved.stuck, rest)


def fit_robust(given: Problem, loss: str = "huber") -> Estimate:
    """Fit with a robust loss by iterated reweighting of the observations.

    Arguments: `loss`, a name in `LOSSES`; the scale is the median absolute residual / 0.6745. The
    scatter found is that of the body of the tests; outliers are down-weighted, not removed. A test
    counts for the slope of its bounded residual, whose mean over normal tests is what bounding
    takes from the sum of squares. Source: Huber and Ronchetti 2009. Raises `InputError`.
    """
    Choice(tuple(LOSSES)).check("loss", loss)
    result, tuning = fit(given), LOSSES[loss]
    for _ in range(REWEIGHTINGS if tuning else 0):
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
        result = fit(weighed(given, weights, loss), start=result.theta)
    return result


def weighed(given: Problem, weights: Array, loss: str) -> Problem:
    """The problem with the weights (n,) of a loss, and what each test then counts for."""
    root = np.sqrt(weights)  # of bisquare: 1 - z^2, and the slope is (1 - z^2) (1 - 5 z^2)
    slope = weights >= 1.0 if loss == "huber" else root * np.maximum(5.0 * root - 4.0, 0.0)
    return replace(given, weights=weights, shares=slope.astype(float))
