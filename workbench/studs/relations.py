"""Relations between damage and what is left, R(D), fitted, weighed by cross-validation, averaged.

Damage D from 0 on, R = 1 undamaged, R >= 0. D = 1 is what an undamaged stud bears; a stud that was
driven beyond has more. A fatigue life ends when what is left has fallen to the peak of the load,
R(1) = P_max / P_u: relations that keep to it are anchored.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.errors import InputError, SolverError
from workbench.studs.damaged import peaks_of
from workbench.studs.quantities import Array
from workbench.studs.schema import FATIGUE, LIFE
from workbench.studs.statistics.intervals import Mixture, mixture_of
from workbench.studs.statistics.mixed import fit, fit_robust, weighed
from workbench.studs.statistics.prediction import Part, Score, averaged_quantile, score_relations
from workbench.studs.statistics.problem import Estimate, Problem, problem

SOURCES = ("oehlers1990", "hanswille2007", "oehlers-foley1985", "yao2018")  # bibliography keys


@dataclass(frozen=True)
class Relation:
    """A form of R(D): `parameters` with `lower`, `upper` bounds and `starts`; `formula` in words.

    A fit begins at the start that is nearest: with a kink it would stop at the first valley. `peak`
    of an anchored relation: P_max / P_u, one number or that of every test (None: not anchored).
    """

    name: str
    formula: str
    parameters: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    starts: tuple[tuple[float, ...], ...]
    value: Callable[..., Array]
    source: str
    peak: ArrayLike | None = None

    def at(self, peak: ArrayLike | None) -> Relation:
        """An anchored relation at peaks, in its formula if they are one; any other as it is."""
        if self.peak is None or peak is None:
            return self
        value = f", P_max/P_u = {np.mean(np.asarray(peak, float)):.3g}" * (np.ndim(peak) == 0)
        return replace(self, peak=peak, formula=self.formula + value)

    def __call__(self, level: ArrayLike, theta: ArrayLike = ()) -> Array:
        """Ratio that is left (n,) at damage levels (n,) for parameters (p,)."""
        d = np.asarray(level, float)
        if np.any(d < 0.0):
            raise InputError("level", float(np.min(d)), "damage is 0 or more")
        known = () if self.peak is None else (np.asarray(self.peak, float),)
        return np.maximum(self.value(d, np.asarray(theta, float), *known), 0.0)


MEASURES = ("displacement ratio", "load ratio")  # of damage, that the mechanical model knows


@dataclass(frozen=True)
class MechanicalCurve:
    """Curve predicted by a mechanical model: `level` (n,), `ratio` (n,) left, with a band.

    `low` and `high` (n,) bound the prediction over its unknown parameters; `predamage`,
    `measure` and `quantity` as in `fit_residual`; `basis` says what it was calibrated on; `stud`,
    which one it is computed for. Levels rise from 0, where the ratio is 1.
    """

    level: Array
    ratio: Array
    low: Array
    high: Array
    predamage: str
    measure: str
    quantity: str
    basis: str
    stud: str = ""

    def __post_init__(self) -> None:
        shapes = {np.shape(v) for v in (self.level, self.ratio, self.low, self.high)}
        if len(shapes) > 1 or len(self.level) < 2 or np.any(np.diff(self.level) <= 0.0):
            raise InputError("mechanical", shapes, "must be curves over rising levels")

    def relation(self) -> Relation:
        """The prediction as a relation without parameters: linear, NaN beyond the last level."""
        none, words = ((), (), (), ((),)), "prediction of the mechanical model"
        left = partial(np.interp, xp=self.level, fp=self.ratio, right=np.nan)
        return Relation("mechanical", words, *none, lambda d, p: np.asarray(left(d)), self.basis)


LATEST = 0.9  # damage up to which nothing need be lost
_THRESHOLDS = tuple((c, t) for c in (0.1, 0.3, 0.6, 0.9) for t in (0.05, 0.2, 0.35, 0.5, 0.65, 0.8))
RELATIONS: dict[str, Relation] = {
    relation.name: relation
    for relation in (
        Relation("none", "R = 1: no loss", (), (), (), ((),),
                 lambda d, p: np.ones_like(d), "the null hypothesis"),
        Relation("linear", "R = 1 - c D", ("c",), (0.0,), (1.0,), ((0.3,),),
                 lambda d, p: 1.0 - p[0] * d, "after Oehlers 1990 (abstract only)"),
        Relation("power", "R = 1 - c D^p", ("c", "p"), (0.0, 0.1), (1.0, 10.0), ((0.4, 1.2),),
                 lambda d, p: 1.0 - p[0] * d ** p[1], "empirical"),
        Relation("exponential", "R = exp(-c D)", ("c",), (0.0,), (20.0,), ((0.4,),),
                 lambda d, p: np.exp(-p[0] * d), "empirical"),
        Relation("threshold", "R = 1 - c (D - t) / (1 - t) from D = t on, 1 before", ("c", "t"),
                 (0.0, 0.0), (1.0, LATEST), _THRESHOLDS,
                 lambda d, p: 1.0 - p[0] * np.maximum(d - p[1], 0.0) / (1.0 - p[1]), "empirical"),
    )
}  # fmt: skip


def _inverted_s(d: Array, p: Array, peak: Array) -> Array:
    inside = np.clip(d, 1e-12, 1.0 - 1e-12)
    left = np.clip(p[0] - p[1] * np.log(inside / (1.0 - inside)), peak, 1.0)
    return np.asarray(np.where(d <= 0.0, 1.0, np.where(d >= 1.0, peak, left)))


_LEVELS = tuple((a, b) for a in (0.5, 0.65, 0.8, 0.95) for b in (0.02, 0.05, 0.1, 0.2))
ANCHORED: dict[str, Relation] = {
    relation.name: relation
    for relation in (
        Relation("oehlers", "R = 1 - (1 - P_max/P_u) D", (), (), (), ((),),
                 lambda d, p, peak: 1.0 - (1.0 - peak) * d,
                 "after Oehlers 1990 (abstract only); the end of life is a definition", 1.0),
        Relation("anchored-power", "R = 1 - (1 - P_max/P_u) D^q", ("q",), (0.1,), (10.0,),
                 ((0.3,), (1.0,), (3.0,)), lambda d, p, peak: 1.0 - (1.0 - peak) * d ** p[0],
                 "empirical", 1.0),
        Relation("inverted-s", "R = a - b ln(D / (1 - D)), from 1 down to P_max/P_u", ("a", "b"),
                 (0.0, 0.0), (1.5, 0.5), _LEVELS, _inverted_s, "inverted S, as recalled of "
                 "Hanswille, Porsch and Ustundag 2007, whose printed formula was not read", 1.0),
    )
}  # fmt: skip


LEAST_WEIGHT = 0.02  # of a candidate in the average


class Candidate(NamedTuple):
    """A relation fitted to the tests, its `weight` in the average, what it tells of new campaigns.

    `mixture`: None with two campaigns, which say nothing of new tests.
    """

    weight: float
    relation: Relation
    estimate: Estimate
    mixture: Mixture | None


def candidates(
    mechanical: MechanicalCurve | None, rows: pd.DataFrame, quantity: str
) -> list[Relation]:
    """All relations, and the mechanical prediction where it is one of the same damage.

    Those anchored at the end of a fatigue life where every test tells the peak of its cycles, at
    the mean of these.
    """
    damage = (quantity, *rows[["predamage", "predamage_measure"]].iloc[0])
    comparable = (
        mechanical is not None
        and (mechanical.quantity, mechanical.predamage, mechanical.measure) == damage
        and float(rows["level"].max()) <= mechanical.level[-1]
    )
    every = [*RELATIONS.values(), *([mechanical.relation()] if mechanical and comparable else [])]
    if damage == ("strength", FATIGUE, LIFE) and peaks_of(rows).notna().all():
        every += [each.at(float(peaks_of(rows).mean())) for each in ANCHORED.values()]
    return every


def problem_of(y: Array, level: Array, campaigns: ArrayLike, relation: Relation) -> Problem:
    """The regression of ratios (n,) at damage levels (n,) on a relation."""
    predict, bounds = partial(relation, level), {"lower": relation.lower, "upper": relation.upper}
    start = min(relation.starts, key=lambda theta: float(np.sum((predict(theta) - y) ** 2)))
    given = problem(y, campaigns, predict, relation.parameters, start, **bounds)
    return replace(given, level=level)


def fit_candidates(
    relations: list[Relation], rows: pd.DataFrame, loss: str, between: float | None = None
) -> dict[str, Estimate]:
    """Fits of all candidates that leave a test to judge them by; those that fail are no candidates.

    `rows`, tests after pre-damage; every test has its own end of an anchored relation. `between`,
    scatter between campaigns if it is known.
    With a robust loss all weigh a test alike, as the one does that it suits best: a test is an
    outlier where it is one for every candidate.
    """
    y, level = rows["ratio"].to_numpy(float), rows["level"].to_numpy(float)
    campaigns, peaks = rows["campaign"].to_numpy(), peaks_of(rows).to_numpy()
    estimates: dict[str, Estimate] = {}
    failed: Exception = InputError(
        "tests after pre-damage", len(y), "must be two or more", "one to three: fit few-tests"
    )
    for relation in relations:
        if len(y) < len(relation.parameters) + 2:
            continue
        try:
            given = problem_of(y, level, campaigns, relation.at(peaks))
            estimates[relation.name] = fit_robust(replace(given, between=between), loss)
        except (InputError, SolverError) as error:
            failed = error
    if not estimates:
        raise failed
    if loss != "linear":
        weights = np.max([each.problem.weights for each in estimates.values()], axis=0)
        for name, each in estimates.items():
            estimates[name] = fit(weighed(each.problem, weights, loss))
    return estimates


def average(
    relations: Sequence[Relation], estimates: dict[str, Estimate]
) -> tuple[tuple[Score, ...], tuple[Candidate, ...]]:
    """Scores of all candidates, and those that count in the average, that of most weight first."""
    scores = tuple(score_relations(estimates))
    kept = [score for score in scores if score.weight >= LEAST_WEIGHT]
    total, named = sum(score.weight for score in kept), {each.name: each for each in relations}
    averaged = []
    for score in kept:
        estimate = estimates[score.name]
        mixture = mixture_of(estimate) if estimate.problem.foretold else None
        averaged.append(Candidate(score.weight / total, named[score.name], estimate, mixture))
    return scores, tuple(averaged)


def quantiles(
    averaged: Sequence[Candidate],
    level: Array,
    shares: Sequence[float],
    median: Sequence[float] = (),
) -> Array | None:
    """Ratios (shares + median, n) at levels (n,), see `averaged_quantile`.

    None with two campaigns.
    """
    new, parts = ["new"] * len(level), []
    for weight, relation, estimate, mixture in averaged:
        if mixture is None:
            return None
        held = problem_of(0.0 * level, level, new, relation)
        parts.append(Part(weight, estimate, mixture, held))
    return averaged_quantile(parts, shares, median)
