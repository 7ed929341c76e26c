"""A fragility curve with its band, from critical velocities corrected by few references.

The curve is the distribution function of the critical velocity: F(u) = P(y + e <= u), `y` of the
reduced model at every sample, `e` the log ratio to the reference (`critical_ratio`).
See docs/theory/fragility.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from workbench.base.arrays import Array, Indices
from workbench.extras.uncertainty.critical_ratio import Columns, Posterior, columns_of, learn
from workbench.responses import COVERAGE
from workbench.studs.statistics.intervals import tails_of

AFTER_LOOKS = 0.95  # coverage of a band that was looked at before: reported as COVERAGE
NORMAL = float(ndtri(tails_of(COVERAGE)[1]))  # half-width of an interval, in deviations
DRAWS, NODES = 300, 21
BIN, MOVING_MEAN = 20, 15
GRID, FARTHEST = 161, 3.1  # points, and the normal score of the first and the last
LARGEST_RATIO = 0.15  # ln velocity; a bound of the ratio where a reference failed
PROBABILITIES = (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class Population:
    """Samples of the inputs, with what the reduced model says of them.

    `log_velocity` (samples,): ln of the critical velocity, infinite where the limit is never
    reached; `inputs` (samples, inputs) in standard normal space; `classes` (samples,), number of
    the class of each sample; `scrambles` (samples,), number of the scramble it comes from.
    """

    log_velocity: Array
    inputs: Array
    classes: Array
    scrambles: Array


@dataclass(frozen=True)
class Curve:
    """Probability of exceedance over velocity.

    `log_velocity` (points,); `median`; bands of `COVERAGE`: `low` and `high` at each point,
    `low_all` and `high_all` of the whole curve; `correction` and `sampling`, half-widths in
    probability by the references and by the samples; `references`, how many.
    """

    log_velocity: Array
    median: Array
    low: Array
    high: Array
    low_all: Array
    high_all: Array
    correction: Array
    sampling: Array
    references: int

    @property
    def half_width(self) -> float:
        """Largest half-width of the pointwise band, in probability."""
        return float(np.max(self.high - self.low)) / 2.0

    def velocity(self, probability: float) -> tuple[float, float, float]:
        """Low, median and high ln velocity at which a probability is reached; NaN: not reached."""
        edges = (self.high, self.median, self.low)
        low, middle, high = (_inverse(edge, self.log_velocity, probability) for edge in edges)
        return low, middle, high

    @property
    def velocity_half_width(self) -> float:
        """Largest half-width in ln velocity at the probabilities 0.1, 0.5 and 0.9."""
        ends = [self.velocity(p) for p in PROBABILITIES]
        return max(0.5 * (high - low) for low, _, high in ends)

    def widened(self, half_width: float) -> "Curve":
        """The curve whose band is widened by a half-width in ln velocity, added to both edges.

        For an error that all references share: it does not average out, so it is not a scatter.
        """
        u, h = self.log_velocity, half_width

        def shifted(edge: Array, by: float) -> Array:
            return np.interp(u + by, u, edge)

        return Curve(
            u,
            self.median,
            shifted(self.low, -h),
            shifted(self.high, h),
            shifted(self.low_all, -h),
            shifted(self.high_all, h),
            self.correction,
            self.sampling,
            self.references,
        )


def _inverse(edge: Array, u: Array, probability: float) -> float:
    """Where an increasing edge reaches a probability."""
    if edge[-1] < probability or edge[0] > probability:
        return float("nan")
    at = int(np.searchsorted(edge, probability))
    if at == 0:
        return float(u[0])
    rise = edge[at] - edge[at - 1]
    share = (probability - edge[at - 1]) / rise if rise > 0.0 else 1.0
    return float(u[at - 1] + share * (u[at] - u[at - 1]))


def place_references(population: Population, count: int, offset: float) -> Indices:
    """Samples to run the reference at: random given the critical velocity, and nested.

    Each class takes its turn by its share; within a class reference k stands at the probability
    {vdc(k) + offset} of the sorted critical velocities (van der Corput, base 2). Samples without a
    critical velocity are left out. Shape (count,), in order: fewer references are the first ones.
    """
    finite = np.isfinite(population.log_velocity)
    members = []
    for k in range(int(population.classes.max(initial=0)) + 1):
        of_class = np.flatnonzero(finite & (population.classes == k))
        members.append(of_class[np.argsort(population.log_velocity[of_class], kind="stable")])
    sizes = np.array([len(each) for each in members], dtype=float)
    shares = np.maximum(sizes / sizes.sum(), np.where(sizes > 0.0, 3.0 / max(count, 8), 0.0))
    shares /= shares.sum()
    taken = np.zeros(len(members), dtype=int)
    places: list[int] = []
    while len(places) < count:
        k = int(np.argmax(shares * (len(places) + 1) - taken))
        at = (_van_der_corput(int(taken[k])) + offset) % 1.0
        place = int(members[k][min(int(at * sizes[k]), int(sizes[k]) - 1)])
        taken[k] += 1
        if place not in places:
            places.append(place)
        elif taken[k] > 4 * sizes[k]:
            break
    return np.array(places, dtype=int)


def _van_der_corput(number: int) -> float:
    value, share = 0.0, 0.5
    while number:
        value += share * (number & 1)
        number, share = number >> 1, share / 2.0
    return value


def fragility_curve(
    population: Population,
    places: Indices,
    ratios: Array,
    random: np.random.Generator,
    *,
    looked: bool = False,
    sampling: bool = True,
    failed: int = 0,
) -> Curve:
    """The corrected curve and its bands.

    `places` (references,), samples that were run by the reference; `ratios` (references,), ln of
    its critical velocity over that of the reduced model; `looked`, whether the number of references
    was chosen by looking at the band (then it is drawn at 95 %); `sampling`, whether the error of a
    finite number of samples is part of the band. Raises `InputError` for too few references.
    """
    finite = np.isfinite(population.log_velocity)
    number = np.cumsum(finite) - 1
    y, classes = population.log_velocity[finite].copy(), population.classes[finite]
    given = number[places]
    for k in range(1, int(classes.max(initial=0)) + 1):  # classes stand on one scale of scores
        of_class, others = classes[given] == k, classes[given] == 0
        if of_class.any() and others.any():
            y[classes == k] += ratios[of_class].mean() - ratios[others].mean()
    columns = columns_of(y, population.inputs[finite], classes)
    y = population.log_velocity[finite]
    posterior = learn(columns, given, ratios)
    corrected = y + columns.values @ posterior.mean
    share = finite.mean()
    grid = _grid(corrected)
    local = _local_columns(columns, corrected, grid)
    coefficients, scatter = posterior.draw(DRAWS, random)
    moved = (coefficients - posterior.mean) @ local.T
    moved *= _guard(posterior, local, moved)
    ordered = np.sort(corrected)
    nodes, weights = np.polynomial.hermite_e.hermegauss(NODES)
    weights = weights / weights.sum()
    at = grid - moved
    draws = np.zeros_like(at)
    for node, weight in zip(nodes, weights, strict=True):
        draws += weight * _distribution(ordered, at - scatter[:, None] * node)
    draws *= share
    by_scramble = _by_scramble(population, finite, corrected, grid)
    deviation = _deviation(by_scramble, random)
    parts = NORMAL * draws.std(axis=0), NORMAL * deviation.std(axis=0)
    if sampling:
        draws = draws + deviation
    silent = float(np.isnan(population.log_velocity).mean())
    lower, upper = draws, draws + silent
    if failed:
        beta = random.beta(failed + 0.5, len(ratios) + 0.5, DRAWS)[:, None]
        reduced = np.sort(y)
        least = share * _distribution(reduced, grid - LARGEST_RATIO)
        most = share * _distribution(reduced, grid + LARGEST_RATIO)
        lower = (1.0 - beta) * lower + beta * least
        upper = (1.0 - beta) * upper + beta * most
    level = AFTER_LOOKS if looked else COVERAGE
    return _bands(grid, draws, lower, upper, level, parts, len(ratios))


def reduced_curve(population: Population, random: np.random.Generator) -> Curve:
    """The curve of the reduced model alone: its band holds the error of the samples only."""
    finite = np.isfinite(population.log_velocity)
    y = population.log_velocity[finite]
    grid = _grid(y)
    exact = finite.mean() * _distribution(np.sort(y), grid)
    deviation = _deviation(_by_scramble(population, finite, y, grid), random)
    draws = exact + deviation
    silent = float(np.isnan(population.log_velocity).mean())
    parts = np.zeros_like(grid), NORMAL * deviation.std(axis=0)
    return _bands(grid, draws, draws, draws + silent, COVERAGE, parts, 0)


def _grid(corrected: Array) -> Array:
    """Points of ln velocity at equal steps of the normal score, with some room beyond."""
    scores = ndtr(np.linspace(-FARTHEST, FARTHEST, GRID))
    u = np.quantile(corrected, scores)
    room = 0.15 * (u[-1] - u[0]) + 1e-6
    u = np.concatenate([[u[0] - room], u, [u[-1] + room]])
    return np.maximum.accumulate(u + 1e-12 * np.arange(len(u)))


def _local_columns(columns: Columns, corrected: Array, grid: Array) -> Array:
    """Mean of the columns among samples whose corrected critical velocity is u: (points, columns).

    By bins of equal count with a moving mean.
    """
    order = np.argsort(corrected)
    bins = max(1, len(order) // BIN)
    edges = np.linspace(0, len(order), bins + 1).astype(int)[:-1]
    count = np.diff(np.append(edges, len(order)))[:, None]
    means = np.add.reduceat(columns.values[order], edges, axis=0) / count
    centres = np.add.reduceat(corrected[order], edges) / count[:, 0]
    reach = min(MOVING_MEAN, 2 * ((bins - 1) // 2) + 1)
    weights = np.ones(reach)
    norms = np.convolve(np.ones(bins), weights, "same")
    smooth = [np.convolve(each, weights, "same") / norms for each in means.T]
    return np.column_stack([np.interp(grid, centres, each) for each in smooth])


def _guard(posterior: Posterior, local: Array, moved: Array) -> Array:
    """Factor (points,) by which the spread of the draws must grow to that of the jackknife."""
    changes = local @ posterior.jackknife  # (points, references)
    n = changes.shape[1]
    spread = changes - changes.mean(axis=1, keepdims=True)
    jackknife = np.sqrt((n - 1) / posterior.freedom * (spread**2).sum(axis=1))
    drawn = moved.std(axis=0)
    if not drawn.any():
        return np.ones_like(drawn)
    tiny = np.finfo(float).tiny
    overall = np.sqrt((jackknife**2).mean() / max((drawn**2).mean(), tiny))
    return np.asarray(np.maximum(np.maximum(1.0, overall), jackknife / np.maximum(drawn, tiny)))


def _distribution(ordered: Array, u: Array) -> Array:
    """Empirical distribution function."""
    return np.searchsorted(ordered, u, side="right") / len(ordered)


def _by_scramble(population: Population, finite: Array, corrected: Array, grid: Array) -> Array:
    """The corrected curve of every scramble: (scrambles, points)."""
    scrambles = population.scrambles[finite]
    rows = []
    for k in range(int(population.scrambles.max()) + 1):
        size = int((population.scrambles == k).sum())
        ordered = np.sort(corrected[scrambles == k])
        rows.append(np.searchsorted(ordered, grid, side="right") / size)
    return np.array(rows)


def _deviation(curves: Array, random: np.random.Generator) -> Array:
    """Draws (draws, points) of the error of the mean of the scrambles' curves, Student."""
    count = len(curves)
    centred = (curves - curves.mean(axis=0)) / np.sqrt(count * (count - 1))
    normal = random.standard_normal((DRAWS, count)) @ centred
    freedom = count - 1
    return np.asarray(normal * np.sqrt(freedom / random.chisquare(freedom, DRAWS))[:, None])


def _bands(
    grid: Array,
    draws: Array,
    lower: Array,
    upper: Array,
    level: float,
    parts: tuple[Array, Array],
    references: int,
) -> Curve:
    """Median, pointwise band and band of the whole curve, monotone and within 0 and 1.

    `lower` and `upper` are the draws at the worst of what failed runs leave open.
    """
    tails = zip((lower, upper), tails_of(level), strict=True)
    low, high = (np.quantile(values, share, axis=0) for values, share in tails)
    edges = low, high, _together(lower, level, -1.0), _together(upper, level, 1.0)
    low, high, low_all, high_all = (np.clip(edge, 0.0, 1.0) for edge in edges)
    median = np.clip(np.median(draws, axis=0), 0.0, 1.0)

    def fall(edge: Array) -> Array:
        return np.asarray(np.minimum.accumulate(edge[::-1])[::-1])

    rise = np.maximum.accumulate
    bands = rise(median), fall(low), rise(high), fall(low_all), rise(high_all)
    return Curve(grid, *bands, *parts, references)


def _together(draws: Array, level: float, sign: float) -> Array:
    """Lower (sign -1) or upper edge of a band that holds a whole draw at the level."""
    probits = ndtri(np.clip(draws, 1e-9, 1.0 - 1e-9))
    middle, spread = np.median(probits, axis=0), probits.std(axis=0)
    moving = spread > 0.0
    far = np.abs(probits - middle)[:, moving] / spread[moving]
    k = float(np.quantile(far.max(axis=1), level)) if moving.any() else 0.0
    return np.asarray(ndtr(middle + sign * k * spread))
