"""Residual capacity of a stud after pre-damage: relations fitted to tests, with their grade.

No shipped table holds a strength measured after pre-damage. Until one is given, the only answer is
the prediction of the mechanical model, and its grade says that nothing has validated it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.arrays import Flags
from workbench.base.errors import InputError
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
from workbench.studs.quantities import Array
from workbench.studs.relations import (
    Candidate,
    MechanicalCurve,
    Relation,
    average,
    candidates,
    fit_candidates,
    quantiles,
)
from workbench.studs.schema import NO_PREDAMAGE, QUANTITIES
from workbench.studs.statistics.annex_d import CHARACTERISTIC, TABLE_DESIGN
from workbench.studs.statistics.intervals import mixture_of, tails_of
from workbench.studs.statistics.prediction import Score, influence_of, without_each
from workbench.studs.statistics.problem import Estimate
from workbench.studs.suspicion import suspicions

STEP = 0.025  # of damage, at which the curve is given
DESIGN_LEVELS = (0.25, 0.5, 0.75)  # of damage, besides the largest tested one
BELOW = 1.0 - CHARACTERISTIC, 1.0 - TABLE_DESIGN  # shares of new tests, for design
CHANCE = 0.05  # that a scatter that does not grow is said to
_TESTS = ["campaign", "specimen", "level", "ratio", "origin", *REFERENCE]


@dataclass(frozen=True)
class ResidualFit(Fit):
    """Fit of the `quantity` left after a kind of `predamage` with levels of one `measure`.

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
        known = quantiles(self.averaged, d[inside], shares, median) if self.averaged else None
        if known is None:
            return None
        left[:, inside] = np.maximum(known, 0.0)
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
        """Design values at usual levels in the tested range and at its end; may be empty.

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
        """Tables of the rest over damage, for design; parameters, weights, tests, prediction."""
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
        for weight, relation, estimate, _ in self.averaged:
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
