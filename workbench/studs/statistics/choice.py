"""Choice between relations by cross-validation over campaigns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

from workbench.errors import InputError, SolverError
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import fit
from workbench.studs.statistics.problem import Problem, subset


@dataclass(frozen=True, slots=True)
class Score:
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

    def to_dict(self) -> dict[str, object]:
        """All values by name."""
        return asdict(self)


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
    any_problem = next(iter(problems.values()))
    by_campaign = any_problem.campaigns > 1
    squares = {name: _squares(given, by_campaign) for name, given in problems.items()}
    means = {name: float(np.mean(each)) for name, each in squares.items()}
    best = min(means, key=lambda name: means[name])
    if not np.isfinite(means[best]):
        raise InputError("candidates", ", ".join(problems), "cannot be cross-validated here")
    scores = []
    for name, each in squares.items():
        if not np.isfinite(means[name]):
            scores.append(Score(name, len(problems[name].names), np.inf, np.inf, None, len(each),
                                "campaign" if by_campaign else "specimen"))  # fmt: skip
            continue
        difference = each - squares[best]
        error = float(np.std(difference, ddof=1) / np.sqrt(len(each))) if len(each) > 1 else None
        scores.append(
            Score(
                name, len(problems[name].names), float(np.sqrt(means[name])),
                means[name] - means[best], error, len(each),
                "campaign" if by_campaign else "specimen",
            )
        )  # fmt: skip
    return sorted(scores, key=lambda score: score.rms)


def choose(scores: list[Score]) -> Score:
    """The simplest candidate within one standard error of the best (Hastie et al. 2009, 7.10)."""
    near = [
        score for score in scores
        if score.behind <= (score.standard_error or 0.0) and np.isfinite(score.rms)
    ]  # fmt: skip
    return min(near, key=lambda score: (score.parameters, score.rms))
