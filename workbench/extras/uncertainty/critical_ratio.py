"""The log ratio of critical velocities, reference over reduced model, learnt from few references.

Model of a ratio `e` at a sample: flat terms (1, score, class columns), and with a prior the inputs
`z` and seven bumps of the score. Both prior variances are averaged over a grid by their evidence.
The equations are those of docs/theory/fragility.md; the estimator follows Chambers and Dunstan
(1986): the distribution function of corrected values, not a difference of indicators.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from workbench.base.arrays import Array
from workbench.base.errors import InputError

INPUT_VARIANCES = (0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1000.0)
BUMP_VARIANCES = (0.0, 0.3, 3.0, 30.0)
BUMPS = np.linspace(-2.2, 2.2, 7)
FEWEST_REFERENCES = 8
LARGEST_LEVERAGE = 0.98
NO_SCATTER = 1e-12  # ln velocity; ratios that agree so well are one number


@dataclass(frozen=True)
class Columns:
    """Columns of the ratio model at all samples of a population.

    `values` (samples, columns); `flat`, how many of them have no prior; `inputs`, how many of the
    others are inputs in standard normal space (the rest: bumps of the score).
    """

    values: Array
    flat: int
    inputs: int

    def prior(self, input_variance: float, bump_variance: float) -> Array:
        """Prior variances of the columns with a prior, over the variance of the scatter."""
        inputs = np.full(self.inputs, input_variance / max(self.inputs, 1))
        bumps = self.values.shape[1] - self.flat - self.inputs
        return np.concatenate([inputs, np.full(bumps, bump_variance / max(bumps, 1))])


def columns_of(log_velocity: Array, inputs: Array, classes: Array) -> Columns:
    """Columns of the ratio model.

    `log_velocity` (samples,), ln of the critical velocities of the reduced model; `inputs`
    (samples, inputs) in standard normal space; `classes` (samples,), the number of the class of
    each sample, 0 the first: each other class has a mean of its own.
    """
    spread = log_velocity.std()
    score = (log_velocity - log_velocity.mean()) / (spread if spread > 0.0 else 1.0)
    members = [(classes == k).astype(float) for k in range(1, int(classes.max(initial=0)) + 1)]
    bumps = np.exp(-0.5 * (score[:, None] - BUMPS) ** 2)
    bumps -= bumps.mean(axis=0)
    size = bumps.std(axis=0)
    bumps /= np.where(size > 0.0, size, 1.0)
    flat = np.column_stack([np.ones_like(score), score, *members])
    return Columns(np.hstack([flat, inputs, bumps]), flat.shape[1], inputs.shape[1])


@dataclass(frozen=True)
class Posterior:
    """Coefficients of the ratio model given the references, per point of the grid of variances.

    `weights` (points,), `coefficients` (points, columns), `factors` (points, columns, columns) with
    factor @ factor.T the covariance over the variance of the scatter, `residuals` (points,) the
    weighted sums of squares, `freedom` their degrees of freedom; `jackknife` (columns, references),
    the change of the mean coefficients as each reference is left out.
    """

    weights: Array
    coefficients: Array
    factors: Array
    residuals: Array
    freedom: int
    jackknife: Array

    @property
    def mean(self) -> Array:
        """Coefficients averaged over the grid."""
        return np.asarray(self.weights @ self.coefficients)

    def draw(self, count: int, random: np.random.Generator) -> tuple[Array, Array]:
        """Draws of the coefficients (count, columns) and of the scatter (count,)."""
        chosen = random.choice(len(self.weights), count, p=self.weights)
        scatter = np.sqrt(self.residuals[chosen] / random.chisquare(self.freedom, count))
        normal = random.standard_normal((count, self.coefficients.shape[1]))
        moved = np.einsum("bij,bj->bi", self.factors[chosen], normal)
        return self.coefficients[chosen] + scatter[:, None] * moved, scatter


def learn(columns: Columns, places: Array, ratios: Array) -> Posterior:
    """Learn the ratio model from references.

    `places` (references,), the samples that were run; `ratios` (references,), ln of the critical
    velocity of the reference over that of the reduced model. Raises `InputError` for fewer than
    eight references, or fewer than the flat columns leave free.
    """
    n, least = len(ratios), max(FEWEST_REFERENCES, columns.flat + 2)
    if n < least:
        raise InputError("references", n, f"must be at least {least}", "ask for more references")
    given = columns.values[places]
    H, U = given[:, : columns.flat], given[:, columns.flat :]
    points = []
    variances = [(i, b) for i in INPUT_VARIANCES for b in BUMP_VARIANCES]
    for pair in variances if columns.inputs else [(0.0, b) for b in BUMP_VARIANCES]:
        points.append(_at(H, U, ratios, columns.prior(*pair)))
    evidence = np.array([point[0] for point in points])
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    coefficients = np.array([point[1] for point in points])
    factors = np.array([point[2] for point in points])
    residuals = np.array([point[3] for point in points])
    jackknife = np.zeros((given.shape[1], n))
    for weight, q, factor in zip(weights, coefficients, factors, strict=True):
        moved = factor @ (factor.T @ given.T)  # C g of every reference
        leverage = np.minimum(np.einsum("ij,ji->i", given, moved), LARGEST_LEVERAGE)
        jackknife += weight * moved * (ratios - given @ q) / (1.0 - leverage)
    return Posterior(weights, coefficients, factors, residuals, n - columns.flat, jackknife)


def _at(H: Array, U: Array, e: Array, prior: Array) -> tuple[float, Array, Array, float]:
    """Log evidence, coefficients, factor of their covariance, sum of squares; one prior.

    V = I + U P U', A = H' V^-1 H, b = A^-1 H' V^-1 e, S = r' V^-1 r with r = e - H b;
    ln L = -ln|V|/2 - ln|A|/2 - (n - p)/2 ln S.
    """
    V = cho_factor(np.eye(len(e)) + (U * prior) @ U.T, lower=True)
    ViH = cho_solve(V, H)
    A = cho_factor(H.T @ ViH, lower=True)
    b = cho_solve(A, ViH.T @ e)
    r = e - H @ b
    Vir = cho_solve(V, r)
    S = max(float(r @ Vir), len(e) * NO_SCATTER**2)
    freedom = len(e) - H.shape[1]
    diagonals = np.log(np.diag(V[0])).sum() + np.log(np.diag(A[0])).sum()
    PU = prior[:, None] * U.T
    J = PU @ ViH
    # covariance of what has a prior, given the flat coefficients; then the flat ones mixed in
    inner = np.diag(prior) - PU @ cho_solve(V, PU.T)
    root = _root(inner)
    flat_root = solve_triangular(A[0], np.eye(H.shape[1]), lower=True).T
    p, m = H.shape[1], len(prior)
    factor = np.zeros((p + m, p + m))
    factor[:p, :p] = flat_root
    factor[p:, :p] = -J @ flat_root
    factor[p:, p:] = root
    return -diagonals - 0.5 * freedom * np.log(S), np.concatenate([b, PU @ Vir]), factor, S


def _root(covariance: Array) -> Array:
    """A factor of a covariance that may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
