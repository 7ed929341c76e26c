"""Choice between relations by cross-validation over campaigns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import fit
from workbench.studs.statistics.problem import Problem, subset


class Score(NamedTuple):
    """A candidate: `parameters` counted; `rms` of the left-out tests, campaigns weighing alike.

    `behind`, mean square behind the best candidate with its standard error over the left-out
    parts (None with fewer than two); `parts` left out, `by` campaign or specimen.
    """

    name: str
    parameters: int
    rms: float
    behind: float
    standard_error: float | None
    parts: int
    by: str


def _squares(given: Problem, by_campaign: bool) -> Array:
    """Mean square of the left-out tests of each part; infinite where the rest cannot be fitted."""
    parts = given.groups if by_campaign else np.arange(given.count)
    result = []
    for part in np.unique(parts):
        inside, outside = np.flatnonzero(parts == part), np.flatnonzero(parts != part)
        held = subset(given, inside)
        try:
            theta = fit(subset(given, outside)).theta if given.names else np.zeros(0)
        except (InputError, SolverError):
            result.append(np.inf)
            continue
        result.append(float(np.mean((held.y - held.predict(theta)) ** 2)))
    return np.array(result)


def score_relations(problems: Mapping[str, Problem]) -> list[Score]:
    """Scores of the candidates, best first; campaigns are left out, or specimens if there is one.

    Arguments: the same observations with the prediction of each candidate. Raises `InputError`
    when no candidate can be scored.
    """
    by_campaign = next(iter(problems.values())).campaigns > 1
    squares = {name: _squares(given, by_campaign) for name, given in problems.items()}
    means = {name: float(np.mean(each)) for name, each in squares.items()}
    best = min(means, key=lambda name: means[name])
    if not np.isfinite(means[best]):
        raise InputError("candidates", ", ".join(problems), "cannot be cross-validated here")
    scores = []
    for name, each in squares.items():
        error = None
        if np.isfinite(means[name]) and len(each) > 1:
            error = float(np.std(each - squares[best], ddof=1) / np.sqrt(len(each)))
        rms, behind = float(np.sqrt(means[name])), means[name] - means[best]
        by = "campaign" if by_campaign else "specimen"
        count = len(problems[name].names)
        scores.append(Score(name, count, rms, behind, error, len(each), by))
    return sorted(scores, key=lambda score: score.rms)


def choose(scores: list[Score]) -> Score:
    """The simplest candidate within one standard error of the best (Hastie et al. 2009, 7.10)."""
    near = [
        score
        for score in scores
        if score.behind <= (score.standard_error or 0.0) and np.isfinite(score.rms)
    ]
    return min(near, key=lambda score: (score.parameters, score.rms))
