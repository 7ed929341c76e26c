"""What is left of a stud after pre-damage: relations fitted to tests, with their evidence grade.

No shipped table holds a strength measured after pre-damage. Until one is given, the only answer is
the prediction of the mechanical model, and its grade says that nothing has validated it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.fields import Choice
from workbench.responses import Finding
from workbench.studs.fit_protocol import Content, Fit, Fitted, Judgement, fitted, judge
from workbench.studs.quantities import Array
from workbench.studs.relations import RELATIONS, MechanicalCurve, Relation
from workbench.studs.schema import NO_PREDAMAGE
from workbench.studs.statistics.mixed import fit_robust
from workbench.studs.statistics.prediction import (
    LEAST_CAMPAIGNS,
    Score,
    choose,
    predictive_quantile,
    score_relations,
)
from workbench.studs.statistics.problem import Problem, problem
from workbench.studs.tables import identity_of

QUANTITIES = {
    "strength": ("shear_kN", "undamaged_shear_kN"),
    "stiffness": ("stiffness_10_40_kN_per_mm", "undamaged_stiffness_kN_per_mm"),
}
ONSET_OF_FATIGUE_LOSS = 0.15  # share of life; Hanswille, Porsch and Ustundag 2007, abstract
LEVELS = np.linspace(0.0, 1.0, 41)  # of damage, at which the curve is given


class Grade(StrEnum):
    """How well a residual capacity is supported, from weakest to strongest."""

    MECHANICAL = "mechanical prediction, not validated by tests after pre-damage"
    SYNTHETIC = "exercise on synthetic rows: shows the method, is no evidence"
    ONE_CAMPAIGN = "fitted to tests after pre-damage of one campaign, not validated on others"
    CROSS_VALIDATED = "fitted to tests after pre-damage, cross-validated over campaigns"


@dataclass(frozen=True)
class ResidualFit(Fit):
    """What is left of `quantity` after a kind of `predamage` with levels of one `measure`.

    `relation` chosen; `fitted`, its parameters and the scatters of the ratio (None without tests:
    a prediction); `scores` of all candidates; `grade`; `levels` covered; `mechanical`, the
    prediction that is a candidate or the answer.
    """

    quantity: str
    predamage: str
    measure: str
    relation: Relation
    fitted: Fitted | None
    scores: tuple[Score, ...]
    grade: Grade
    levels: tuple[float, float]
    mechanical: MechanicalCurve | None

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the relation."""
        return {} if self.fitted is None else self.fitted.estimates

    def left(self, level: ArrayLike) -> Array:
        """Median ratio (n,) that is left at damage levels (n,)."""
        return self.relation(level, list(self.parameters.values()))

    def band(self, level: ArrayLike, share: float = 0.9) -> tuple[Array, Array] | None:
        """Bounds (n,) of the ratio: of a new test in a new campaign, or of the mechanical model.

        None where tests of fewer than three campaigns do not allow a prediction.
        """
        d = np.asarray(level, float)
        if self.fitted is None:
            assert self.mechanical is not None
            sides = (self.mechanical.low, self.mechanical.high)
            low, high = (np.interp(d, self.mechanical.level, s, right=np.nan) for s in sides)
            return low, high
        estimate = self.fitted.estimate
        if estimate.problem.campaigns < LEAST_CAMPAIGNS or self.fitted.at_bound:
            return None
        held = _problem(np.zeros(len(d)), d, ["new"] * len(d), self.relation, fitted=False)
        parts = (0.5 - 0.5 * share, 0.5 + 0.5 * share)
        low, high = (predictive_quantile(estimate, held, part) for part in parts)
        return np.maximum(low, 0.0), high

    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> Judgement:
        """Hold what is predicted to be left against tests that the fit has not used.

        Raises `InputError` when there are none, or a row was used for the fit.
        """
        rows = damaged_rows(table, self.quantity, self.predamage, self.measure)
        if rows.empty:
            raise InputError("validation", 0, f"holds no test after {self.predamage}")
        self.identity.refuse_overlap(rows)
        predicted = self.left(rows["level"].to_numpy(float))
        return judge(rows, rows["ratio"], predicted, confidence, "level")

    def to_dict(self) -> Content:
        """Everything but the rows."""
        own, told = self.fitted, ("quantity", "predamage", "measure", "scores", "levels")
        scatter = ("sigma", "tau")
        return {
            **{name: getattr(self, name) for name in told},
            "relation": self.relation.name,
            "formula": self.relation.formula,
            "parameters": self.parameters,
            **({"profile": {}, "bootstrap": {}} if own is None else own.intervals()),
            **{name: None if own is None else getattr(own.estimate, name) for name in scatter},
            "grade": str(self.grade),
            **self.used(),
        }

    def parts(self, confidence: float) -> Content:
        """Its tests, and what is left over the damage."""
        low, high = self.band(LEVELS, confidence) or (None, None)
        curve = self.mechanical
        names = ("level", "ratio", "low", "high", "basis")
        columns = ["campaign", "specimen", "level", "ratio", "origin"]
        return {
            "validated": self.fitted is not None and self.grade is Grade.CROSS_VALIDATED,
            "curve": {"level": LEVELS, "left": self.left(LEVELS), "low": low, "high": high},
            "tests": self.rows.reindex(columns=columns),
            "mechanical": None if curve is None else {n: getattr(curve, n) for n in names},
        }


def damaged_rows(
    table: pd.DataFrame, quantity: str, predamage: str | None = None, measure: str | None = None
) -> pd.DataFrame:
    """Tests after pre-damage with `level` and `ratio` of what is left; empty when there are none.

    The undamaged reference is the row's own, or the mean of the undamaged tests with the same
    campaign and diameter. Raises `InputError` for an unknown quantity, or kinds or measures of
    damage that must not be mixed.
    """
    Choice(tuple(QUANTITIES)).check("quantity", quantity)
    column, reference = QUANTITIES[quantity]
    damaged = (table["predamage"] != NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)
    for name, wanted in (("predamage", predamage), ("predamage_measure", measure)):
        if wanted is not None:
            damaged &= table[name] == wanted
    undamaged = table[table["predamage"] == NO_PREDAMAGE]
    means = undamaged.groupby(["campaign", "diameter_mm"])[column].mean()
    keys = pd.MultiIndex.from_frame(table[["campaign", "diameter_mm"]])
    companion = pd.Series(means.reindex(keys).to_numpy(float), index=table.index)
    ratio = table[column].astype(float) / table[reference].astype(float).fillna(companion)
    rows = table.assign(level=table["predamage_level"].astype(float), ratio=ratio)
    rows = rows[damaged & np.isfinite(ratio)]
    for name, advice in (("predamage", "predamage="), ("predamage_measure", "measure=")):
        words = sorted(set(rows[name]))
        if len(words) > 1:
            reason = "different kinds of damage do not share one relation"
            raise InputError(name, ", ".join(words), reason, f"choose one with {advice}")
    return rows.reset_index(drop=True)


def fit_residual(
    table: pd.DataFrame,
    quantity: str = "strength",
    *,
    predamage: str | None = None,
    measure: str | None = None,
    mechanical: MechanicalCurve | None = None,
    loss: str = "linear",
    confidence: float = 0.9,
    resamples: int = 300,
) -> ResidualFit:
    """Fit and choose a relation between damage and what is left, and grade its evidence.

    Arguments: `table` (schema `TESTS`); `quantity`, ``strength`` or ``stiffness``; `predamage` and
    `measure`, which tests (None: all, if they are of one kind); `mechanical`, prediction of the
    mechanical model, one more candidate and the answer if the table holds no test after
    pre-damage; the rest as in `fit_strength`. The relation is chosen out of `RELATIONS` by leaving
    out whole campaigns. Raises `InputError` without tests and prediction.
    """
    rows = damaged_rows(table, quantity, predamage, measure)
    if rows.empty:
        return _predicted(table, quantity, mechanical, predamage, measure)
    relations = _candidates(mechanical, rows, quantity)
    y, level = rows["ratio"].to_numpy(float), rows["level"].to_numpy(float)
    problems = {r.name: _problem(y, level, rows["campaign"], r) for r in relations}
    scores = score_relations(problems)
    chosen = next(r for r in relations if r.name == choose(scores).name)
    estimate = fit_robust(problems[chosen.name], loss)
    found = fitted(estimate, confidence=confidence, resamples=resamples)
    return ResidualFit(
        quantity=quantity,
        predamage=str(rows["predamage"].iloc[0]),
        measure=str(rows["predamage_measure"].iloc[0]),
        relation=chosen,
        fitted=found,
        scores=tuple(scores),
        grade=_grade(rows),
        levels=(float(level.min()), float(level.max())),
        rows=rows,
        findings=tuple(_findings(rows, found, chosen)),
        identity=identity_of(rows),
        mechanical=mechanical,
    )


def _predicted(
    table: pd.DataFrame,
    quantity: str,
    mechanical: MechanicalCurve | None,
    predamage: str | None,
    measure: str | None,
) -> ResidualFit:
    asked = " ".join(word for word in ("pre-damage", predamage, measure) if word)
    where = ("table", f"{len(table)} rows", f"holds no test after {asked}")
    if mechanical is None:
        advice = "give a table with such rows, or the prediction of the mechanical model"
        raise InputError(*where, advice)
    for wanted, predicted in ((predamage, mechanical.predamage), (measure, mechanical.measure)):
        if wanted not in (None, predicted):
            known = f"{mechanical.predamage}, {mechanical.measure}"
            raise InputError(*where, f"the mechanical model predicts {known} only")
    if mechanical.quantity != quantity:
        raise InputError("mechanical", mechanical.quantity, f"must predict the {quantity}")
    why = "the table holds no test after pre-damage"
    if damaged := int((table["predamage"] != NO_PREDAMAGE).sum()):
        why = (
            f"{damaged} tests after pre-damage say nothing about the {quantity}: give "
            f"{QUANTITIES[quantity][1]}, or undamaged tests of the same campaign and diameter"
        )
    kind = (quantity, mechanical.predamage, mechanical.measure, mechanical.relation())
    levels, none = (float(mechanical.level[0]), float(mechanical.level[-1])), table.iloc[:0]
    findings = tuple(Finding("evidence", text) for text in (why, mechanical.basis))
    answer = (*kind, None, (), Grade.MECHANICAL, levels, mechanical)
    return ResidualFit(*answer, rows=none, findings=findings, identity=identity_of(none))


def _candidates(
    mechanical: MechanicalCurve | None, rows: pd.DataFrame, quantity: str
) -> list[Relation]:
    """All relations, and the mechanical prediction where it is one of the same damage."""
    damage = (quantity, *rows[["predamage", "predamage_measure"]].iloc[0])
    comparable = (
        mechanical is not None
        and (mechanical.quantity, mechanical.predamage, mechanical.measure) == damage
        and float(rows["level"].max()) <= mechanical.level[-1]
    )
    return [*RELATIONS.values(), *([mechanical.relation()] if mechanical and comparable else [])]


def _problem(
    y: Array, level: Array, campaigns: ArrayLike, relation: Relation, *, fitted: bool = True
) -> Problem:
    predict, names, start = partial(relation, level), relation.parameters, relation.start
    bounds = {"lower": relation.lower, "upper": relation.upper}
    return problem(y, campaigns, predict, names, start, **bounds, fitted=fitted)


def _grade(rows: pd.DataFrame) -> Grade:
    if (rows["origin"] == "synthetic").any():
        return Grade.SYNTHETIC
    return Grade.CROSS_VALIDATED if len(set(rows["campaign"])) > 1 else Grade.ONE_CAMPAIGN


def _findings(rows: pd.DataFrame, found: Fitted, relation: Relation) -> Iterator[Finding]:
    synthetic = int((rows["origin"] == "synthetic").sum())
    if synthetic:
        yield Finding("evidence", f"{synthetic} of {len(rows)} rows are synthetic")
    campaigns = rows["campaign"].nunique()
    if campaigns == 1:
        text = "one campaign: the relation was chosen by leaving out specimens, not campaigns"
        yield Finding("campaigns", text)
    elif campaigns < LEAST_CAMPAIGNS:
        yield Finding("campaigns", "two campaigns: no band for a new campaign")
    if found.at_bound:
        yield Finding("bounds", f"parameters on a bound: {', '.join(found.at_bound)}")
    left = float(relation(ONSET_OF_FATIGUE_LOSS, list(found.estimates.values())))
    if rows["predamage"].iloc[0] == "fatigue" and left >= 1.0:
        text = "no loss at 15 % of the fatigue life contradicts Hanswille, Porsch and Ustundag"
        yield Finding("fatigue", f"{text} (2007)")
