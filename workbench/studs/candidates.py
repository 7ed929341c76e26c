"""Candidates for what is left after damage: fitted, weighed by cross-validation, averaged."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError, SolverError
from workbench.studs.damage import peaks_of
from workbench.studs.quantities import Array
from workbench.studs.relations import ANCHORED, RELATIONS, MechanicalCurve, Relation
from workbench.studs.schema import FATIGUE, LIFE
from workbench.studs.statistics.mixed import Estimate, fit, fit_robust
from workbench.studs.statistics.mixture import (
    NOTHING,
    TAU,
    Mixture,
    Part,
    Priors,
    averaged_quantile,
    mixture_of,
    posterior_mean,
    tells_new_campaigns,
)
from workbench.studs.statistics.prediction import Score, score_relations
from workbench.studs.statistics.problem import Problem, problem

LEAST_WEIGHT = 0.02  # of a candidate in the average


class Candidate(NamedTuple):
    """A relation fitted to the tests, its `weight` in the average; `theta`, under the priors.

    `mixture`, what tests and priors tell together; None where that is nothing of new campaigns.
    """

    weight: float
    relation: Relation
    estimate: Estimate
    theta: Array
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
    found = [*RELATIONS.values(), *([mechanical.relation()] if mechanical and comparable else [])]
    if damage == ("strength", FATIGUE, LIFE) and peaks_of(rows).notna().all():
        found += [each.at(float(peaks_of(rows).mean())) for each in ANCHORED.values()]
    return found


def problem_of(y: Array, level: Array, campaigns: ArrayLike, relation: Relation) -> Problem:
    """The regression of ratios (n,) at damage levels (n,) on a relation."""
    predict, names = partial(relation, level), relation.parameters
    start = relation.start_for(level, y)
    bounds = {"lower": relation.lower, "upper": relation.upper}
    return problem(y, campaigns, predict, names, start, **bounds)


def fit_candidates(relations: list[Relation], rows: pd.DataFrame, loss: str) -> dict[str, Estimate]:
    """Fits of all candidates that leave a test to judge them by; those that fail are no candidates.

    `rows`, tests after pre-damage; every test has its own end of an anchored relation.
    With a robust loss all weigh a test alike, as the one does that it suits best: a test is an
    outlier where it is one for every candidate.
    """
    y, level = rows["ratio"].to_numpy(float), rows["level"].to_numpy(float)
    campaigns, peaks = rows["campaign"].to_numpy(), peaks_of(rows).to_numpy()
    found: dict[str, Estimate] = {}
    failed: Exception = InputError(
        "tests after pre-damage", len(y), "must be two or more", "one to three: fit few-tests"
    )
    for relation in relations:
        if len(y) < len(relation.parameters) + 2:
            continue
        try:
            found[relation.name] = fit_robust(
                problem_of(y, level, campaigns, relation.at(peaks)), loss
            )
        except (InputError, SolverError) as error:
            failed = error
    if not found:
        raise failed
    if loss != "linear":
        weights = np.max([each.problem.weights for each in found.values()], axis=0)
        found = {n: fit(replace(e.problem, weights=weights)) for n, e in found.items()}
    return found


def average(
    relations: Sequence[Relation], estimates: dict[str, Estimate], priors: Priors = NOTHING
) -> tuple[tuple[Score, ...], tuple[Candidate, ...]]:
    """Scores of all candidates, and those that count in the average, that of most weight first."""
    scores = tuple(score_relations(estimates))
    kept = [score for score in scores if score.weight >= LEAST_WEIGHT]
    total = sum(score.weight for score in kept)
    named = {relation.name: relation for relation in relations}
    averaged = []
    for weight, name in ((each.weight / total, each.name) for each in kept):
        relation, estimate = named[name], estimates[name]
        own = priors_of(relation, priors)
        mixture = None
        if own or tells_new_campaigns(estimate, own):
            mixture = mixture_of(estimate, own)
        theta = posterior_mean(estimate, mixture) if mixture and own else estimate.theta
        averaged.append(Candidate(weight, relation, estimate, theta, mixture))
    return scores, tuple(averaged)


def priors_of(relation: Relation, priors: Priors) -> Priors:
    """The priors that concern a relation, by its own parameters; `priors` by relation.parameter."""
    own = {name: priors.get(f"{relation.name}.{name}") for name in relation.parameters}
    own[TAU] = priors.get(TAU)
    return {name: each for name, each in own.items() if each is not None}


def quantiles(
    averaged: Sequence[Candidate],
    level: Array,
    shares: Sequence[float],
    median: Sequence[float] = (),
    reference: float = 0.0,
) -> Array:
    """Ratios (shares + median, n) at levels (n,), see `averaged_quantile`.

    `reference`, a relative standard uncertainty of all ratios, adds to them in quadrature.
    """
    from scipy.special import ndtri

    new = ["new"] * len(level)
    parts = [
        Part(c.weight, c.estimate, c.mixture, problem_of(0.0 * level, level, new, c.relation))
        for c in averaged
        if c.mixture is not None
    ]
    found = averaged_quantile(parts, shares, median)
    middle = np.sum([c.weight * c.relation(level, c.theta) for c in averaged], axis=0)
    more = reference * middle * ndtri(np.array([*shares, *median]))[:, None]
    return np.asarray(middle + np.sign(found - middle) * np.hypot(found - middle, more))
