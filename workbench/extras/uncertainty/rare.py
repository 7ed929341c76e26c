"""Probability of a rare failure: design points, then importance sampling about them.

In standard normal space a failure of probability 1e-6 begins some 4.8 from the origin. The point of
the limit nearest to it (Hasofer and Lind 1974; FORM) is found by few steps on the margin
ln(critical velocity / velocity). Wide samples look for further such points, and stay a part of the
mixture that is sampled, so that no weight is without a bound. See docs/theory/fragility.md.
"""

from dataclasses import dataclass
from math import exp, inf, log, nan
from typing import Any, NamedTuple

import numpy as np
from scipy.special import logsumexp, ndtr, ndtri

from workbench.base.arrays import Array, Flags
from workbench.base.errors import InputError, WorkbenchError
from workbench.extras.uncertainty.critical_velocity import COARSE, DisplacementLimit
from workbench.extras.uncertainty.fragility_curve import NORMAL
from workbench.extras.uncertainty.inputs import UncertainScenario
from workbench.extras.uncertainty.sample_runs import VELOCITY, Sampled, Setup, numbers_at
from workbench.scenarios import column
from workbench.study.batches import Run

RANGE = (0.1, 10.0)  # velocities that are searched, over that of the scenario
ASIDE, CLOSE, LONGEST = 0.5, 0.2, 3.0  # scores: of differences, of a point that stays, of a step
MOST_STEPS, MOST_POINTS = 8, 8
SCOUTS, WIDE = 512, 0.5  # wide samples; their deviation over the distance of the first point
FARTHEST, WAY = 5.0, 16  # that distance where none is known; places on the way to a wide sample
BESIDE, LEAST_PART = 1.0, 0.2  # score before a plane that is not near it; least share of a point
DEFENSIVE = 0.1  # share of wide samples in the mixture
BATCH, FEWEST = 500, 1000  # samples at a time, and before their scatter is looked at
ROUNDS, EACH, ENOUGH = 5, 100, 10.0  # means of failures; samples of each, and that must count
POWERS = (1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.1)  # of their weights
LARGEST_SHARE = 0.2  # of the probability far from all points, or without an answer


class Struck:
    """An uncertain impact at its own velocity that must not exceed a limit, by one model.

    Asked at standard normal scores (samples, inputs) of independent inputs.
    """

    def __init__(
        self,
        uncertain: UncertainScenario,
        model: object,
        limit: DisplacementLimit,
        run: Run,
        jobs: int,
    ) -> None:
        struck: Any = uncertain.base
        self.velocity: float = struck.striker.velocity
        low, high = (factor * self.velocity for factor in RANGE)
        self.setup = Setup(uncertain, model, None, limit, (low, high), jobs=jobs)
        self.run, self.near = run, log(self.velocity)

    def margins(self, scores: Array) -> tuple[Array, int]:
        """Margins (samples,) ln(critical velocity / velocity), and runs of the model.

        Above 0 where it holds, NaN without an answer; within the range that is searched.
        """
        sampled = Sampled.of(self.setup, scores, self.run)
        roots = sampled.roots(self.setup, np.full(len(scores), self.near), close=COARSE)
        critical = np.clip([root.log_velocity for root in roots], *self.setup.search)
        if np.isfinite(critical[0]):
            self.near = float(critical[0])
        given = sampled.varied.by_key.get(VELOCITY, [self.velocity] * len(scores))
        velocities = numbers_at(VELOCITY, column.VELOCITY, given)
        least = exp(self.setup.search[0])  # below it no distribution is asked
        return critical - np.log(np.maximum(velocities, least)), sum(root.runs for root in roots)

    def failures(self, scores: Array) -> Array:
        """1 where the limit is exceeded, 0 where it is not, NaN without an answer (samples,)."""
        peaks = Sampled.of(self.setup, scores, self.run).peaks()
        exceeded = (peaks > self.setup.limit.displacement) | np.isinf(peaks)
        return np.where(np.isnan(peaks), nan, exceeded)


@dataclass(frozen=True)
class Rare:
    """Probability of failure with its coefficient of variation `cov`.

    `points` (points, inputs), scores of the design points, the nearest first; `silent`, what
    samples without an answer would add at most, over the probability; `runs` of the model by part.
    """

    probability: float
    cov: float
    points: Array
    silent: float
    runs: dict[str, int]

    @property
    def band(self) -> tuple[float, float]:
        """Ends of the band of `COVERAGE`, lognormal; no error of the model is in it."""
        half = NORMAL * self.cov
        return self.probability * exp(-half), min(1.0, self.probability * exp(half))

    @property
    def index(self) -> float:
        """Reliability index, the normal score of the probability that it holds."""
        return float(-ndtri(self.probability))

    @property
    def shares(self) -> Array:
        """Share of each input (inputs,) in the variance of the margin at the first point."""
        return np.asarray(self.points[0] ** 2 / (self.points[0] ** 2).sum())


def rare_probability(
    structure: Struck,
    inputs: int,
    random: np.random.Generator,
    cov: float = 0.1,
    most: int = 5000,
) -> Rare:
    """Probability that a structure with so many independent normal inputs fails.

    Sampling ends at the coefficient of variation `cov`, or after `most` runs of the model. Raises
    `InputError` where the median fails, `WorkbenchError` where there is no design point, or where
    much of the probability lies elsewhere or has no answer.
    """
    mixture, before = _mixture(structure, inputs, random)
    if before + FEWEST > most:
        text = f"leaves no room for samples: the search for design points took {before} runs"
        raise InputError("--runs", most, text, f"allow {before + FEWEST} or more")
    weights, failing, far = np.empty(0), np.empty(0), np.empty(0, bool)
    scatter = inf
    while len(weights) < FEWEST or (scatter > cov and before + len(weights) + BATCH <= most):
        scores = mixture.draw(BATCH, random)
        ratios, apart = mixture.ratios(scores)
        weights, far = np.append(weights, ratios), np.append(far, apart)
        failing = np.append(failing, structure.failures(scores))
        shares = weights * (failing == 1.0)
        if shares.any():
            scatter = float(shares.std(ddof=1) / shares.mean()) / len(shares) ** 0.5
    silent = _silent_share(weights, failing, far)
    points = mixture.points[np.argsort(np.linalg.norm(mixture.points, axis=1))]
    counts = {"design points": before, "samples": len(weights)}
    return Rare(float(shares.mean()), scatter, points, silent, counts)


class SamplingMixture(NamedTuple):
    """Normal samples about points (points, inputs), by their shares, and wide ones.

    `wide`, deviation of those; their share is `DEFENSIVE`.
    """

    points: Array
    shares: Array
    wide: float

    def draw(self, count: int, random: np.random.Generator) -> Array:
        """Samples (count, inputs)."""
        normal = random.standard_normal((count, self.points.shape[1]))
        chosen = random.choice(len(self.points), count, p=self.shares)
        defensive = random.random(count) < DEFENSIVE
        return np.where(defensive[:, None], self.wide * normal, self.points[chosen] + normal)

    def ratios(self, scores: Array) -> tuple[Array, Flags]:
        """Density of the inputs over that of the mixture; whether a sample is far from all points.

        Far are those that are rather wide ones. Both (samples,).
        """
        parts = np.log((1.0 - DEFENSIVE) * self.shares) - 0.5 * (self.points**2).sum(axis=1)
        about = logsumexp(scores @ self.points.T + parts, axis=1)
        spread = DEFENSIVE / self.wide ** scores.shape[1]
        beside = np.log(spread) + 0.5 * (scores**2).sum(axis=1) * (1.0 - self.wide**-2)
        return np.asarray(np.exp(-np.logaddexp(about, beside))), np.asarray(beside > about)


def _mixture(
    structure: Struck, inputs: int, random: np.random.Generator
) -> tuple[SamplingMixture, int]:
    """Points to sample about, and the runs of the model that it took to find them.

    The first by slopes of the margin, others from wide samples that fail before the planes through
    all points. All have like shares, but those much farther from the origin have less.
    """
    first, runs = _design_point(structure, inputs)
    points = np.empty((0, inputs)) if first is None else first[None]
    distance = FARTHEST if first is None else float(np.linalg.norm(first))
    wide = max(WIDE * distance, 1.0)
    scouts = wide * random.standard_normal((SCOUTS, inputs))
    runs += SCOUTS
    left = scouts[structure.failures(scouts) == 1.0]
    left = left[np.argsort(np.linalg.norm(left, axis=1))]
    while len(points) < MOST_POINTS:
        left = left[_beyond(left, points) < -BESIDE]
        if not len(left):
            break
        other, left = _mean_failure(structure, left[0], random), left[1:]
        points = np.vstack([points, other])
        runs += WAY + ROUNDS * EACH
    if (_beyond(left, points) < -BESIDE).any():
        text = (
            f"samples fail apart from {MOST_POINTS} of them, so that a design point was not found"
        )
        raise WorkbenchError(f"{text}; take `workbench sample`")
    if not len(points):
        text = f"fails in none of {SCOUTS} wide samples, nor does an input lead to a failure"
        raise WorkbenchError(f"the structure {text}; take another limit, or wider distributions")
    beyond = ndtr(-np.linalg.norm(points, axis=1))
    shares = np.maximum(beyond / beyond.max(), LEAST_PART)
    return SamplingMixture(points, shares / shares.sum(), wide), runs


def _design_point(structure: Struck, inputs: int) -> tuple[Array | None, int]:
    """The point of the limit nearest to the origin (None: slopes lead to none), and the runs.

    Steps to the nearest point of the plane through the margin and its central differences.
    """
    at, runs = np.zeros(inputs), 0
    steps = ASIDE * np.vstack([at, np.eye(inputs), -np.eye(inputs)])
    for _ in range(MOST_STEPS):
        margins, count = structure.margins(at + steps)
        middle, runs = margins[0], runs + count
        if not at.any() and middle <= 0.0:
            text = "is exceeded at the medians of all inputs: that is not rare"
            raise InputError("--limit", None, text, "ask `workbench sample` or `fragility`")
        margins = np.where(np.isnan(margins), middle, margins)
        slope = (margins[1 : inputs + 1] - margins[inputs + 1 :]) / (2.0 * ASIDE)
        if np.isnan(middle) or not slope.any():
            break
        move = (slope @ at - middle) * slope / (slope @ slope) - at
        length = float(np.linalg.norm(move))
        at = at + move * min(1.0, LONGEST / max(length, CLOSE))
        if length < CLOSE:
            return at, runs
    return None, runs


def _mean_failure(structure: Struck, start: Array, random: np.random.Generator) -> Array:
    """Where failures near one that is known have their mean (inputs,).

    From the first failure on the way to it, by means of failures about the last mean, weighted to
    the density of the inputs as far as `ENOUGH` of them count (cross entropy, Rubinstein 1999).
    """
    way = np.linspace(0.0, 1.0, WAY + 1)[1:, None] * start
    at = way[np.argmax(structure.failures(way) == 1.0)]
    for _ in range(ROUNDS):
        tried = at + random.standard_normal((EACH, len(at)))
        tried = np.vstack([at, tried[structure.failures(tried) == 1.0]])
        for power in POWERS:
            weights = np.exp(power * ((tried @ at).min() - tried @ at))
            if weights.sum() ** 2 > ENOUGH * (weights**2).sum():
                break
        at = weights @ tried / weights.sum()
    return np.asarray(at)


def _beyond(scores: Array, points: Array) -> Array:
    """How far scores (samples,) lie beyond that plane of a point which they pass furthest."""
    lengths = np.linalg.norm(points, axis=1)
    passed = scores @ (points / lengths[:, None]).T - lengths
    return np.asarray(passed.max(axis=1, initial=-inf))


def _silent_share(weights: Array, failing: Array, far: Flags) -> float:
    """Weight of samples without an answer over that of those that fail.

    Refuses an estimate that lacks answers, or rests on what lies far from all points.
    """
    failed = failing == 1.0
    whole, elsewhere = (float(weights[which].sum()) for which in (failed, failed & far))
    if whole == 0.0:
        raise WorkbenchError(f"none of {len(weights)} samples about the design points fails")
    if elsewhere > LARGEST_SHARE * whole:
        text = (
            f"{100.0 * elsewhere / whole:.0f} % of the probability lie far from all that is known"
        )
        raise WorkbenchError(f"{text}: a design point was not found; take `workbench sample`")
    silent = float(weights[np.isnan(failing)].sum()) / whole
    if silent > LARGEST_SHARE:
        text = f"samples without an answer weigh {silent:.2g} times those that fail"
        advice = "truncate distributions with impossible values, or take another model"
        raise WorkbenchError(f"{text}; {advice}")
    return silent
