"""Fit of the factors of a strength formula itself, c_s and c_c, within bounds.

The formula is the smaller of two terms, so a factor is only seen by tests that its term governs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.identity import RowIdentity, identity_of
from workbench.studs.quantities import Array, Specimens, specimens, undamaged_headed_studs
from workbench.studs.shear import ShearModel, shear_model
from workbench.studs.statistics.intervals import (
    Interval,
    bootstrap_by_campaign,
    profile_interval,
    scatter_intervals,
)
from workbench.studs.statistics.mixed import Estimate, fit_robust
from workbench.studs.statistics.problem import problem

FACTORS = {"steel": (0.1, 5.0), "concrete": (0.02, 5.0)}  # bounds that no sensible fit reaches


@dataclass(frozen=True)
class FactorFit:
    """Fitted factors of a formula.

    `model` with the fitted factors; `factors`, `profile` and `bootstrap` intervals (the latter
    empty with fewer than three campaigns) by factor; scatters `sigma`, `tau` of the log ratio with
    intervals; `at_bound`, factors that rest on a bound; `governed_by_steel`, share of the tests.
    """

    model: ShearModel
    factors: dict[str, float]
    profile: dict[str, Interval]
    bootstrap: dict[str, Interval]
    sigma: float
    tau: float
    scatter: dict[str, Interval]
    at_bound: tuple[str, ...]
    governed_by_steel: float
    identity: RowIdentity
    estimate: Estimate

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "model": self.model.name,
            "factors": self.factors,
            "profile": {name: each.to_dict() for name, each in self.profile.items()},
            "bootstrap": {name: each.to_dict() for name, each in self.bootstrap.items()},
            "sigma": {"value": self.sigma, **self.scatter["sigma"].to_dict()},
            "tau": {"value": self.tau, **self.scatter["tau"].to_dict()},
            "at_bound": list(self.at_bound),
            "governed_by_steel": self.governed_by_steel,
        }


def fit_factors(
    table: pd.DataFrame,
    model: str | ShearModel = "roik-mean",
    factors: Sequence[str] = ("concrete",),
    *,
    loss: str = "linear",
    confidence: float = 0.9,
    resamples: int = 200,
    seed: int = 0,
) -> FactorFit:
    """Fit factors of a formula to the undamaged headed studs of a table.

    Arguments: `model`, name or `ShearModel`, gives the start and the factors that are held;
    `factors` out of ``steel`` and ``concrete``; the rest as in `fit_strength`. Raises `InputError`
    for a factor whose term governs no test.
    """
    chosen = shear_model(model) if isinstance(model, str) else model
    for name in factors:
        if name not in FACTORS:
            raise InputError("factors", name, "must be one of " + ", ".join(FACTORS))
        if name == "steel" and np.isinf(chosen.steel_factor):
            raise InputError("factors", name, f"{chosen.title} has no steel term")
    rows = undamaged_headed_studs(table)
    known = np.isfinite(chosen.of(specimens(rows)))
    rows = rows[known].reset_index(drop=True)
    tests = specimens(rows)
    start = {"steel": chosen.steel_factor, "concrete": chosen.concrete_factor}
    given = problem(
        np.log(tests.shear), tests.campaign, _prediction(tests, chosen, tuple(factors)),
        tuple(factors), np.log([start[name] for name in factors]),
        lower=np.log([FACTORS[name][0] for name in factors]),
        upper=np.log([FACTORS[name][1] for name in factors]),
    )  # fmt: skip
    try:
        estimate = fit_robust(given, loss)
    except InputError as error:
        if error.field not in factors or not isinstance(error.value, float):
            raise
        value = float(np.exp(error.value))  # what is fitted is the logarithm
        raise InputError(error.field, value, error.allowed, error.advice) from error
    values = {name: float(np.exp(estimate.parameter(name))) for name in factors}
    bootstrap = (
        bootstrap_by_campaign(estimate, confidence=confidence, resamples=resamples, seed=seed)
        if given.campaigns >= 3
        else {}
    )
    fitted = chosen.scaled(steel=values.get("steel"), concrete=values.get("concrete"))
    return FactorFit(
        model=fitted,
        factors=values,
        profile={n: _exp(profile_interval(estimate, n, confidence)) for n in factors},
        bootstrap={n: _exp(each) for n, each in bootstrap.items()},
        sigma=estimate.sigma,
        tau=estimate.tau,
        scatter=scatter_intervals(estimate, confidence),
        at_bound=tuple(n for n, b in zip(factors, estimate.at_bound, strict=True) if b),
        governed_by_steel=float(np.mean(fitted.governed_by_steel(tests))),
        identity=identity_of(rows),
        estimate=estimate,
    )


def _prediction(tests: Specimens, model: ShearModel, factors: tuple[str, ...]) -> Any:
    # terms for a factor of 1, so that a prediction costs a minimum of two arrays
    unit = model.scaled(steel=1.0, concrete=1.0)
    steel = np.log(unit.steel(tests.diameter, tests.ultimate_strength))
    concrete = np.log(
        unit.concrete(tests.diameter, tests.height, tests.concrete_strength, tests.concrete_modulus)
    )
    fixed = {
        "steel": np.log(model.steel_factor) if np.isfinite(model.steel_factor) else np.inf,
        "concrete": np.log(model.concrete_factor),
    }

    def predict(theta: Array) -> Array:
        now = {**fixed, **dict(zip(factors, theta, strict=True))}
        return np.asarray(np.minimum(now["steel"] + steel, now["concrete"] + concrete))

    return predict


def _exp(interval: Interval) -> Interval:
    low, high = (None if v is None else float(np.exp(v)) for v in (interval.low, interval.high))
    return Interval(low, high, interval.confidence, interval.method)
