"""What is left of a stud after pre-damage: relations fitted to tests, with their evidence grade.

No shipped table holds a strength measured after pre-damage. Until one is given, the only answer is
the prediction of the mechanical model, and its grade says that nothing has validated it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.studs.identity import RowIdentity, identity_of
from workbench.studs.quantities import Array
from workbench.studs.relations import RELATIONS, MechanicalCurve, Relation
from workbench.studs.schema import NO_PREDAMAGE
from workbench.studs.statistics.choice import Score, choose, score_relations
from workbench.studs.statistics.intervals import (
    Interval,
    bootstrap_by_campaign,
    profile_interval,
)
from workbench.studs.statistics.mixed import Estimate, fit_robust
from workbench.studs.statistics.prediction import LEAST_CAMPAIGNS, predictive_quantile
from workbench.studs.statistics.problem import Problem, problem

QUANTITIES = {
    "strength": ("shear_kN", "undamaged_shear_kN"),
    "stiffness": ("stiffness_10_40_kN_per_mm", "undamaged_stiffness_kN_per_mm"),
}
ONSET_OF_FATIGUE_LOSS = 0.15  # share of life; Hanswille, Porsch and Ustundag 2007, abstract


class Grade(StrEnum):
    """How well a residual capacity is supported, from weakest to strongest."""

    MECHANICAL = "mechanical prediction, not validated by tests after pre-damage"
    SYNTHETIC = "exercise on synthetic rows: shows the method, is no evidence"
    ONE_CAMPAIGN = "fitted to tests after pre-damage of one campaign, not validated on others"
    CROSS_VALIDATED = "fitted to tests after pre-damage, cross-validated over campaigns"


@dataclass(frozen=True)
class ResidualFit:
    """What is left of `quantity` after a kind of `predamage` with levels of one `measure`.

    `relation` chosen; `parameters` with profile intervals (and bootstrap ones from three campaigns
    on); scatters `sigma`, `tau` of the ratio; `scores` of all candidates; `grade`; `levels`
    covered; `rows` behind it; `warnings`. Without tests `estimate` is None.
    """

    quantity: str
    predamage: str
    measure: str
    relation: Relation
    parameters: dict[str, float]
    profile: dict[str, Interval]
    bootstrap: dict[str, Interval]
    sigma: float | None
    tau: float | None
    scores: tuple[Score, ...]
    grade: Grade
    levels: tuple[float, float]
    rows: pd.DataFrame
    warnings: tuple[str, ...]
    identity: RowIdentity
    estimate: Estimate | None
    mechanical: MechanicalCurve | None

    def left(self, level: ArrayLike) -> Array:
        """Median ratio (n,) that is left at damage levels (n,)."""
        return self.relation(level, list(self.parameters.values()))

    def band(self, level: ArrayLike, share: float = 0.9) -> tuple[Array, Array] | None:
        """Bounds (n,) of the ratio: of a new test in a new campaign, or of the mechanical model.

        None where tests of fewer than three campaigns do not allow a prediction.
        """
        d = np.asarray(level, float)
        if self.estimate is None:
            assert self.mechanical is not None
            low, high = (
                np.interp(d, self.mechanical.level, side, right=np.nan)
                for side in (self.mechanical.low, self.mechanical.high)
            )
            return low, high
        if self.estimate.problem.campaigns < LEAST_CAMPAIGNS or self.estimate.at_bound.any():
            return None
        held = _problem(
            np.zeros(len(d)), d, np.array(["new"] * len(d)), self.relation, fitted=False
        )
        low, high = (
            predictive_quantile(self.estimate, held, 0.5 + sign * 0.5 * share)
            for sign in (-1.0, 1.0)
        )
        return np.maximum(low, 0.0), high

    def refuse_seen(self, table: pd.DataFrame) -> None:
        """Refuse tests that the fit has used. Raises `InputError`."""
        self.identity.refuse_overlap(table)

    def validate(self, table: pd.DataFrame) -> ResidualValidation:
        """Hold the relation against unseen tests after the same pre-damage.

        Raises `InputError` when a row was used for the fit, also under another name.
        """
        rows = damaged_rows(table, self.quantity, self.predamage, self.measure)
        if rows.empty:
            raise InputError("table", len(table), f"holds no test after {self.predamage}")
        self.refuse_seen(rows)
        error = rows["ratio"].to_numpy(float) - self.left(rows["level"].to_numpy(float))
        return ResidualValidation(
            len(rows), float(np.mean(error)), float(np.sqrt(np.mean(error**2)))
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything but the rows, ready for JSON."""
        return {
            "quantity": self.quantity,
            "predamage": self.predamage,
            "measure": self.measure,
            "relation": self.relation.name,
            "formula": self.relation.formula,
            "parameters": self.parameters,
            "profile": {name: each.to_dict() for name, each in self.profile.items()},
            "bootstrap": {name: each.to_dict() for name, each in self.bootstrap.items()},
            "sigma": self.sigma,
            "tau": self.tau,
            "scores": [each.to_dict() for each in self.scores],
            "grade": str(self.grade),
            "levels": list(self.levels),
            "tests": len(self.rows),
            "campaigns": sorted(self.identity.campaigns),
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, slots=True)
class ResidualValidation:
    """A relation on unseen tests: `count`, mean error and root mean square of the ratio."""

    count: int
    bias: float
    rms: float

    def to_dict(self) -> dict[str, object]:
        """All values by name."""
        return asdict(self)


def damaged_rows(
    table: pd.DataFrame, quantity: str, predamage: str | None = None, measure: str | None = None
) -> pd.DataFrame:
    """Tests after pre-damage with `level` and `ratio` of what is left; empty when there are none.

    The undamaged reference is the row's own, or the mean of the undamaged tests with the same
    campaign and diameter. Raises `InputError` for an unknown quantity, or kinds or measures of
    damage that must not be mixed.
    """
    if quantity not in QUANTITIES:
        raise InputError("quantity", quantity, "must be one of " + ", ".join(QUANTITIES))
    column, reference = QUANTITIES[quantity]
    damaged = (table["predamage"] != NO_PREDAMAGE) & (table["use_for_fit"] == 1.0)
    if predamage is not None:
        damaged &= table["predamage"] == predamage
    if measure is not None:
        damaged &= table["predamage_measure"] == measure
    value = table[column].astype(float)
    own = table[reference].astype(float)
    undamaged = table[table["predamage"] == NO_PREDAMAGE]
    means = undamaged.groupby(["campaign", "diameter_mm"])[column].mean()
    keys = pd.MultiIndex.from_frame(table[["campaign", "diameter_mm"]])
    companion = pd.Series(means.reindex(keys).to_numpy(float), index=table.index)
    ratio = value / own.fillna(companion)
    rows = table.assign(level=table["predamage_level"].astype(float), ratio=ratio)
    rows = rows[damaged & np.isfinite(ratio)]
    for name, advice in (("predamage", "predamage="), ("predamage_measure", "measure=")):
        words = sorted(set(rows[name]))
        if len(words) > 1:
            raise InputError(
                name, ", ".join(words), "different kinds of damage do not share one relation",
                f"choose one with {advice}",
            )  # fmt: skip
    return rows.reset_index(drop=True)


def fit_residual(
    table: pd.DataFrame,
    quantity: str = "strength",
    *,
    predamage: str | None = None,
    measure: str | None = None,
    mechanical: MechanicalCurve | None = None,
    candidates: Sequence[str] = tuple(RELATIONS),
    loss: str = "linear",
    confidence: float = 0.9,
    resamples: int = 300,
    seed: int = 0,
) -> ResidualFit:
    """Fit and choose a relation between damage and what is left, and grade its evidence.

    Arguments: `table` (schema `TESTS`); `quantity`, ``strength`` or ``stiffness``; `predamage` and
    `measure`, which tests (None: all, if they are of one kind); `mechanical`, prediction of the
    mechanical model, one more candidate and the answer if the table holds no test after
    pre-damage; `candidates`, names in `RELATIONS`; the rest as in `fit_strength`. The relation is
    chosen by leaving out whole campaigns. Raises `InputError` without tests and prediction.
    """
    rows = damaged_rows(table, quantity, predamage, measure)
    if rows.empty:
        return _predicted(table, quantity, mechanical, predamage, measure)
    relations = _candidates(candidates, mechanical, rows, quantity)
    y, level = rows["ratio"].to_numpy(float), rows["level"].to_numpy(float)
    campaigns = rows["campaign"].to_numpy(str)
    problems = {r.name: _problem(y, level, campaigns, r) for r in relations}
    scores = score_relations(problems)
    chosen = next(r for r in relations if r.name == choose(scores).name)
    estimate = fit_robust(problems[chosen.name], loss)
    names = chosen.parameters
    many = estimate.problem.campaigns >= LEAST_CAMPAIGNS and names
    return ResidualFit(
        quantity=quantity,
        predamage=str(rows["predamage"].iloc[0]),
        measure=str(rows["predamage_measure"].iloc[0]),
        relation=chosen,
        parameters={name: estimate.parameter(name) for name in names},
        profile={name: profile_interval(estimate, name, confidence) for name in names},
        bootstrap=bootstrap_by_campaign(
            estimate, confidence=confidence, resamples=resamples, seed=seed
        )
        if many
        else {},
        sigma=estimate.sigma,
        tau=estimate.tau,
        scores=tuple(scores),
        grade=_grade(rows),
        levels=(float(level.min()), float(level.max())),
        rows=rows,
        warnings=tuple(_warnings(rows, estimate, chosen)),
        identity=identity_of(rows),
        estimate=estimate,
        mechanical=mechanical,
    )


def _predicted(
    table: pd.DataFrame,
    quantity: str,
    mechanical: MechanicalCurve | None,
    predamage: str | None,
    measure: str | None,
) -> ResidualFit:
    asked = " ".join(word for word in (predamage, measure) if word)
    if mechanical is None:
        raise InputError(
            "table", f"{len(table)} rows", f"holds no test after pre-damage {asked}".rstrip(),
            "give a table with such rows, or the prediction of the mechanical model",
        )  # fmt: skip
    for wanted, predicted in ((predamage, mechanical.predamage), (measure, mechanical.measure)):
        if wanted is not None and wanted != predicted:
            raise InputError(
                "table", f"{len(table)} rows", f"holds no test after pre-damage {asked}",
                f"the mechanical model predicts {mechanical.predamage}, {mechanical.measure} only",
            )  # fmt: skip
    if mechanical.quantity != quantity:
        raise InputError("mechanical", mechanical.quantity, f"must predict the {quantity}")
    return ResidualFit(
        quantity, mechanical.predamage, mechanical.measure, mechanical.relation(), {}, {}, {},
        None, None, (), Grade.MECHANICAL,
        (float(mechanical.level[0]), float(mechanical.level[-1])),
        table.iloc[:0], (_why_none(table, quantity), mechanical.basis),
        identity_of(table.iloc[:0]), None, mechanical,
    )  # fmt: skip


def _why_none(table: pd.DataFrame, quantity: str) -> str:
    """Why a table gives no ratio of what is left."""
    damaged = int((table["predamage"] != NO_PREDAMAGE).sum())
    if not damaged:
        return "the table holds no test after pre-damage"
    return (
        f"{damaged} tests after pre-damage say nothing about the {quantity}: give "
        f"{QUANTITIES[quantity][1]}, or undamaged tests of the same campaign and diameter"
    )


def _candidates(
    names: Sequence[str], mechanical: MechanicalCurve | None, rows: pd.DataFrame, quantity: str
) -> list[Relation]:
    for name in names:
        if name not in RELATIONS:
            raise InputError("candidates", name, "must be one of " + ", ".join(RELATIONS))
    result = [RELATIONS[name] for name in names]
    if mechanical is None or mechanical.quantity != quantity:
        return result
    comparable = (
        mechanical.predamage == rows["predamage"].iloc[0]
        and mechanical.measure == rows["predamage_measure"].iloc[0]
        and float(rows["level"].max()) <= mechanical.level[-1]
    )
    return [*result, mechanical.relation()] if comparable else result


def _problem(
    y: Array, level: Array, campaigns: Any, relation: Relation, *, fitted: bool = True
) -> Problem:
    def predict(theta: Array) -> Array:
        return relation(level, theta)

    return problem(
        y,
        campaigns,
        predict,
        relation.parameters,
        relation.start,
        lower=np.array(relation.lower),
        upper=np.array(relation.upper),
        fitted=fitted,
    )


def _grade(rows: pd.DataFrame) -> Grade:
    if (rows["origin"] == "synthetic").any():
        return Grade.SYNTHETIC
    return Grade.CROSS_VALIDATED if len(set(rows["campaign"])) > 1 else Grade.ONE_CAMPAIGN


def _warnings(rows: pd.DataFrame, estimate: Estimate, relation: Relation) -> list[str]:
    result = []
    synthetic = int((rows["origin"] == "synthetic").sum())
    if synthetic:
        result.append(f"{synthetic} of {len(rows)} rows are synthetic")
    campaigns = rows["campaign"].nunique()
    if campaigns == 1:
        result.append(
            "one campaign: the relation was chosen by leaving out specimens, not campaigns"
        )
    elif campaigns < LEAST_CAMPAIGNS:
        result.append("two campaigns: no band for a new campaign")
    stuck = [n for n, at in zip(relation.parameters, estimate.at_bound, strict=True) if at]
    if stuck:
        result.append(f"parameters on a bound: {', '.join(stuck)}")
    fatigue = rows["predamage"].iloc[0] == "fatigue"
    theta = list(estimate.theta)
    if fatigue and float(relation(ONSET_OF_FATIGUE_LOSS, theta)) >= 1.0:
        result.append(
            "no loss at 15 % of the fatigue life contradicts Hanswille, Porsch and Ustundag (2007)"
        )
    return result
