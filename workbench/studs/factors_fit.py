"""Fit of the factors of a strength formula itself, c_s and c_c, within bounds.

The formula is the smaller of two terms, so a factor is only seen by tests that its term governs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.fields import Choice
from workbench.responses import Finding
from workbench.studs.fit_protocol import Content, Fit, Fitted, Judgement, fitted, judge
from workbench.studs.formulas import Formula, strength_formula
from workbench.studs.quantities import Array, Specimens, specimens, undamaged_headed_studs
from workbench.studs.statistics.mixed import fit_robust
from workbench.studs.statistics.problem import Prediction, problem
from workbench.studs.tables import identity_of

FACTORS = {"steel": (0.1, 5.0), "concrete": (0.02, 200.0)}  # bounds that no sensible fit reaches


@dataclass(frozen=True)
class FactorFit(Fit):
    """Fitted factors of a formula.

    `model` with the fitted factors; `fitted`, the factors and the scatters of the log ratio;
    `governed_by_steel`, share of the tests, all in one kind of `slab`.
    """

    model: Formula
    fitted: Fitted
    governed_by_steel: float
    slab: str

    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> Judgement:
        """Judge the fitted formula by tests that the fit has not used. Raises `InputError`."""
        self.identity.refuse_overlap(table)
        rows = undamaged_headed_studs(table, self.slab, self.model.load)
        tests = specimens(rows)
        return judge(rows, tests.quantity(self.model.load), self.model.of(tests), confidence)

    def to_dict(self) -> Content:
        """Everything but the rows."""
        return {
            "model": self.model.name,
            "factors": self.fitted.estimates,
            "profile": self.fitted.intervals,
            "sigma": self.fitted.sigma,
            "tau": self.fitted.tau,
            "at_bound": self.fitted.at_bound,
            "governed_by_steel": self.governed_by_steel,
        }


def fit_factors(
    table: pd.DataFrame,
    model: str | Formula = "roik-mean",
    factors: Sequence[str] = ("concrete",),
    *,
    loss: str = "linear",
    confidence: float = 0.9,
    slab: str = "solid",
) -> FactorFit:
    """Fit factors of a formula to the undamaged headed studs of a table.

    Arguments: `model`, name or `Formula`, gives the start and the factors that are held;
    `factors` out of ``steel`` and ``concrete``; the rest as in `fit_strength`. Raises `InputError`
    for a factor whose term governs no test.
    """
    chosen = strength_formula(model) if isinstance(model, str) else model
    for name in factors:
        Choice(tuple(FACTORS)).check("factors", name)
        if name == "steel" and np.isinf(chosen.steel_factor):
            raise InputError("factors", name, f"{chosen.title} has no steel term")
    if np.isinf(chosen.concrete_factor) or np.isfinite(chosen.head_factor):
        raise InputError("factors", chosen.name, "must have one term of concrete to fit factors")
    rows = undamaged_headed_studs(table, slab, chosen.load)
    rows = rows[np.isfinite(chosen.of(specimens(rows)))].reset_index(drop=True)
    tests = specimens(rows)
    names, predict = tuple(factors), prediction(tests, chosen, tuple(factors))
    start = np.log([getattr(chosen, f"{name}_factor") for name in names])
    low, high = np.log([FACTORS[name] for name in names]).T
    load = np.log(tests.quantity(chosen.load))
    given = problem(load, tests.campaign, predict, names, start, lower=low, upper=high)
    try:
        estimate = fit_robust(given, loss)
    except InputError as error:
        if error.field not in factors or not isinstance(error.value, float):
            raise
        value = float(np.exp(error.value))  # what is fitted is the logarithm
        raise InputError(error.field, value, error.allowed, error.advice) from error
    found = fitted(estimate, factors, confidence=confidence)
    best = chosen.scaled(**found.estimates)
    steel, concrete = best.terms(tests)
    texts = (f"the {name} factor rests on a bound" for name in found.at_bound)
    findings = tuple(Finding("bounds", text) for text in texts)
    own = (best, found, float(np.mean(steel < concrete)), slab)
    return FactorFit(*own, rows=rows, findings=findings, identity=identity_of(rows))


def prediction(tests: Specimens, model: Formula, factors: tuple[str, ...]) -> Prediction:
    """Logarithm of the resistance as a function of the logarithms of `factors`."""
    # terms for a factor of 1, so that a prediction costs a minimum of two arrays
    steel, concrete = (np.log(term) for term in model.scaled(steel=1.0, concrete=1.0).terms(tests))
    fixed = {"steel": np.log(model.steel_factor), "concrete": np.log(model.concrete_factor)}

    def predict(theta: Array) -> Array:
        now = {**fixed, **dict(zip(factors, theta, strict=True))}
        return np.asarray(np.minimum(now["steel"] + steel, now["concrete"] + concrete))

    return predict
