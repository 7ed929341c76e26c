"""Relations between damage and what is left, R(D), fitted, weighed by cross-validation, averaged.

Damage D from 0 on, R = 1 undamaged, R >= 0. D = 1 is what an undamaged stud bears; a stud that was
driven beyond has more. A fatigue life ends when what is left has fallen to the peak of the load,
R(1) = P_max / P_u: relations that keep to it are anchored.

**Second part.** What is left of a stud after pre-damage: relations fitted to tests, with their
evidence grade.

No shipped table holds a strength measured after pre-damage. Until one is given, the only answer is
the prediction of the mechanical model, and its grade says that nothing has validated it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.arrays import Flags
from workbench.base.errors import InputError, SolverError
from workbench.responses import Finding, finding
from workbench.studs.damaged import (
    ONSET_OF_FATIGUE_LOSS,
    REFERENCE,
    Grade,
    damage_findings,
    damaged_rows,
    grade_of,
    peaks_of,
    reference_findings,
    residual_findings,
    studs_in_words,
)
from workbench.studs.fit_protocol import (
    Fit,
    Fitted,
    Judgement,
    Summary,
    Tables,
    counted,
    fitted,
    judge,
    outlier_findings,
)
from workbench.studs.plausibility import suspicions
from workbench.studs.schema import FATIGUE, LIFE, NO_PREDAMAGE, QUANTITIES
from workbench.studs.series import CHARACTERISTIC, TABLE_DESIGN
from workbench.studs.statistics.intervals import (
    Part,
    Score,
    influence_of,
    mixture_of,
    predictive_quantiles,
    score_relations,
    tails_of,
    without_each,
)
from workbench.studs.statistics.mixed import Estimate, Problem, fit, fit_robust, problem, weighed
from workbench.studs.tables import Array

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
    """A relation fitted to the tests, and its `weight` in the average."""

    weight: float
    relation: Relation
    estimate: Estimate


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
    averaged = (
        Candidate(score.weight / total, named[score.name], estimates[score.name]) for score in kept
    )
    return scores, tuple(averaged)


STEP = 0.025  # of damage, at which the curve is given
DESIGN_LEVELS = (0.25, 0.5, 0.75)  # of damage, besides the largest tested one
BELOW = 1.0 - CHARACTERISTIC, 1.0 - TABLE_DESIGN  # shares of new tests, for design
CHANCE = 0.05  # that a scatter that does not grow is said to
_TESTS = ["campaign", "specimen", "level", "ratio", "origin", *REFERENCE]


@dataclass(frozen=True)
class ResidualFit(Fit):
    """Residual `quantity` after a kind of `predamage` with levels of one `measure`.

    `stud`, which one it is for; `relation`, that of most weight; `fitted`, its parameters and the
    scatters of the ratio (None without tests: a prediction); `scores` of all candidates;
    `averaged`, those that count; `grade`, which holds for the `levels` covered only; `mechanical`,
    the prediction that is a candidate or the answer.
    """

    quantity: str
    predamage: str
    measure: str
    stud: str
    relation: Relation
    grade: Grade
    levels: tuple[float, float]
    mechanical: MechanicalCurve | None
    fitted: Fitted | None = None
    scores: tuple[Score, ...] = ()
    averaged: tuple[Candidate, ...] = ()
    figures: ClassVar[tuple[str, ...]] = ("stud-guideline",)

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the relation."""
        return {} if self.fitted is None else self.fitted.estimates

    @property
    def holds(self) -> str:
        """Where the grade holds, in words."""
        kind = "computed" if self.fitted is None else "tested"
        studs = f" of studs {self.stud}" if self.stud else ""
        return f"for damage up to {self.levels[1]:.3g}{studs}, as {kind}"

    @property
    def foretold(self) -> str:
        """The campaigns whose new tests bands and values are for, in words; empty for none."""
        return "" if self.fitted is None else self.fitted.estimate.problem.foretold

    def extrapolates(self, level: ArrayLike) -> Flags:
        """Whether damage levels (n,) lie beyond the tested ones. Undamaged, all is left."""
        return np.asarray(level, float) > self.levels[1] + 1e-9

    def left(self, level: ArrayLike, peak: ArrayLike | None = None) -> Array:
        """Median ratio (n,) that is left at damage levels (n,): the average of the candidates.

        `peak` of load cycles over P_u, (n,), at which lives end (None: the mean of the tests).
        """
        if self.fitted is None:
            return self.relation(level)
        values = [c.weight * c.relation.at(peak)(level, c.estimate.theta) for c in self.averaged]
        return np.asarray(np.sum(values, axis=0))

    def quantiles(
        self, level: ArrayLike, shares: Sequence[float], median: Sequence[float] = ()
    ) -> Array | None:
        """Ratios (shares + median, n) that shares of a distribution lie below, at levels (n,).

        `shares`, of new tests of the campaigns `foretold`; `median`, of what is known of the median
        there. NaN beyond the tested levels: what a relation does there no test tells. None for a
        prediction, and with two campaigns.
        """
        d = np.asarray(level, float)
        inside, left = ~self.extrapolates(d), np.full((len(shares) + len(median), len(d)), np.nan)
        if not self.foretold:
            return None
        level, new = d[inside], ["new"] * int(inside.sum())
        parts = [
            Part(weight, estimate, problem_of(0.0 * level, level, new, relation))
            for weight, relation, estimate in self.averaged
        ]
        left[:, inside] = np.maximum(predictive_quantiles(parts, shares, median), 0.0)
        return left

    def band(self, level: ArrayLike, share: float = 0.9) -> tuple[Array, Array] | None:
        """Bounds (n,) of the ratio: of a new test (`foretold`), or of the mechanical model.

        NaN and None as in `quantiles`.
        """
        if self.fitted is None:
            assert self.mechanical is not None
            sides = (self.mechanical.low, self.mechanical.high)
            d, known = np.asarray(level, float), self.mechanical.level
            low, high = (np.interp(d, known, side, right=np.nan) for side in sides)
            return low, high
        ends = self.quantiles(level, tails_of(share))
        return None if ends is None else (ends[0], ends[1])

    def design_rows(self, share: float = 0.9) -> pd.DataFrame:
        """Values for a designer at usual levels in the tested range and at its end; may be empty.

        Columns: `level`, `median` with its confidence bounds `low`, `high`, and what 5 % and 0.1 %
        of new tests (`foretold`) lie below, `characteristic` and `design`. NaN where the tests
        do not tell, as in `quantiles`, and for a `design` value of nothing.
        """
        end, usual = self.levels[1], np.array(DESIGN_LEVELS)
        level = np.append(usual[usual < end - 1e-9], end) if self.fitted else np.zeros(0)
        known = self.quantiles(level, BELOW, tails_of(share)) if len(level) else None
        names = ("characteristic", "design", "low", "high")
        rows = np.full((len(names), len(level)), np.nan) if known is None else known
        values = dict(zip(names, rows, strict=True))
        values["design"] = np.where(values["design"] > 0.0, values["design"], np.nan)
        return pd.DataFrame({"level": level, "median": self.left(level), **values})

    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> Judgement:
        """Hold what is predicted to be left against tests that the fit has not used.

        Raises `InputError` when there are none, or a row was used for the fit.
        """
        rows = damaged_rows(table, self.quantity, self.predamage, self.measure)
        if rows.empty:
            raise InputError("validation", 0, f"holds no test after {self.predamage}")
        self.identity.refuse_overlap(rows)
        peaks = peaks_of(rows)  # those of the tests where all tell them
        known = peaks.to_numpy() if peaks.notna().all() else None
        predicted = self.left(rows["level"].to_numpy(float), known)
        return judge(rows, rows["ratio"], predicted, confidence, "level")

    def summary(self) -> Summary:
        """The relation of most weight, its scatters, grade, and where it holds."""
        names = ("quantity", "predamage", "measure", "stud", "holds", "foretold")
        return {
            **{name: getattr(self, name) for name in names},
            **counted(self.rows),
            **{"relation": self.relation.name, "formula": self.relation.formula},
            **{"grade": str(self.grade), "lowest_level": self.levels[0], "level": self.levels[1]},
            "validated": self.fitted is not None and self.grade is Grade.CROSS_VALIDATED,
            **({} if self.fitted is None else self.fitted.scatters),
        }

    def tables(self, confidence: float = 0.9) -> Tables:
        """Residual quantity over the damage, design, parameters, weights, tests, the prediction."""
        levels = np.arange(0.0, max(self.levels[1], 1.0) + 0.5 * STEP, STEP)
        low, high = self.band(levels, confidence) or (np.nan, np.nan)
        curve = {"level": levels, "left": self.left(levels), "low": low, "high": high}
        tables = {
            "curve": pd.DataFrame({**curve, "extrapolated": self.extrapolates(levels)}),
            "design": self.design_rows(confidence),
            "scores": pd.DataFrame(self.scores, columns=Score._fields),
            "tests": self.rows.reindex(columns=_TESTS),
        }
        if self.fitted is not None:
            tables["parameters"] = self.fitted.table
        if self.mechanical is not None:
            names = ("level", "ratio", "low", "high", "basis")
            tables["mechanical"] = pd.DataFrame({n: getattr(self.mechanical, n) for n in names})
        return tables

    def influence(self) -> pd.DataFrame:
        """How every test moves what is left at the largest tested damage, weights held."""
        if self.fitted is None:
            return pd.DataFrame()
        level = np.array([self.levels[1]])
        answer, value = f"left at damage {self.levels[1]:.3g}", float(self.left(level)[0])
        moved = np.full(len(self.rows), value)
        for weight, relation, estimate in self.averaged:
            whole, others = relation(level, estimate.theta)[0], without_each(estimate)
            moved += [weight * float(relation(level, theta)[0] - whole) for theta in others]
        flexible = max(self.averaged, key=lambda each: len(each.estimate.theta)).estimate
        return influence_of(self.rows, flexible, answer, value, moved)


def fit_residual(
    table: pd.DataFrame,
    quantity: str = "strength",
    *,
    predamage: str | None = None,
    measure: str | None = None,
    mechanical: MechanicalCurve | None = None,
    loss: str = "linear",
    confidence: float = 0.9,
    known_between: float | None = None,
) -> ResidualFit:
    """Fit and choose a relation between damage and what is left, and grade its evidence.

    Arguments: `table` (schema `TESTS`); `quantity`, ``strength`` or ``stiffness``; `predamage` and
    `measure`, which tests (None: all, if they are of one kind); `mechanical`, prediction of the
    mechanical model, one more candidate and the answer if the table holds no test after
    pre-damage; `known_between`, scatter between campaigns of what is left, that earlier tests have
    shown; the rest as in `fit_strength`. The candidates in `RELATIONS` are weighed by
    leaving out whole campaigns, and averaged. Raises `InputError` without tests and prediction.
    """
    rows = damaged_rows(table, quantity, predamage, measure)
    if rows.empty:
        return _predicted(table, quantity, mechanical, predamage, measure)
    relations = candidates(mechanical, rows, quantity)
    estimates = fit_candidates(relations, rows, loss, known_between)
    flexible = max(estimates.values(), key=lambda each: len(each.theta))
    scores, averaged = average(relations, estimates)
    chosen, best = averaged[0].relation, fitted(averaged[0].estimate, confidence=confidence)
    onset = float(chosen(ONSET_OF_FATIGUE_LOSS, list(best.estimates.values())))
    return ResidualFit(
        quantity=quantity,
        predamage=str(rows["predamage"].iloc[0]),
        measure=str(rows["predamage_measure"].iloc[0]),
        stud=studs_in_words(rows),
        relation=chosen,
        fitted=best,
        scores=scores,
        averaged=averaged,
        grade=grade_of(rows, quantity),
        levels=(float(rows["level"].min()), float(rows["level"].max())),
        rows=rows,
        findings=(
            *suspicions(table),
            # an outlier hides from a relation that fits badly: the most flexible one finds it
            *outlier_findings(flexible, rows),
            *_growth(flexible),
            *damage_findings(rows, quantity),
            *reference_findings(table, rows, quantity),
            *residual_findings(rows, best.at_bound, onset, known_between),
        ),
        mechanical=mechanical,
    )


def _growth(estimate: Estimate) -> Iterator[Finding]:
    """Scatter that grows with the damage, where chance alone would hardly make it so."""
    from scipy.special import chdtrc

    if estimate.is_exact:
        return
    mixture = mixture_of(estimate)
    chance = float(chdtrc(1.0, max(mixture.likelihood_ratio, 0.0)))
    if mixture.likely > 0.0 and chance < CHANCE:
        times = float(np.exp(mixture.likely))
        yield finding("stud-growing-scatter", times, level=mixture.top, times=times, chance=chance)


def _predicted(
    table: pd.DataFrame,
    quantity: str,
    mechanical: MechanicalCurve | None,
    predamage: str | None,
    measure: str | None,
) -> ResidualFit:
    kind = " ".join(word for word in ("pre-damage", predamage, measure) if word)
    where = ("table", f"{len(table)} rows", f"holds no test after {kind}")
    if mechanical is None:
        advice = "give a table with such rows, or the prediction of the mechanical model"
        raise InputError(*where, advice)
    known = (mechanical.predamage, mechanical.measure)
    if predamage not in (None, known[0]) or measure not in (None, known[1]):
        raise InputError(*where, f"the mechanical model predicts {', '.join(known)} only")
    if mechanical.quantity != quantity:
        raise InputError("mechanical", mechanical.quantity, f"must predict the {quantity}")
    why = finding("stud-no-damaged-test")
    if damaged := int((table["predamage"] != NO_PREDAMAGE).sum()):
        more = ", or --predicted-reference" if quantity == "strength" else ""
        which: dict[str, Any] = {"column": QUANTITIES[quantity][1], "more": more}
        why = finding("stud-useless-damaged-tests", count=damaged, quantity=quantity, **which)
    return ResidualFit(
        quantity=quantity,
        predamage=mechanical.predamage,
        measure=mechanical.measure,
        stud=mechanical.stud,
        relation=mechanical.relation(),
        grade=Grade.MECHANICAL,
        levels=(float(mechanical.level[0]), float(mechanical.level[-1])),
        rows=table.iloc[:0],
        findings=(*suspicions(table), why, finding("stud-basis", basis=mechanical.basis)),
        mechanical=mechanical,
    )
