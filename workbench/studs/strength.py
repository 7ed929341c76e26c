"""Fit of a strength formula to tests: bias, trends, scatter within and between campaigns.

The logarithm of test over prediction is regressed: ln(P / P_model) = ln b + sum c_k ln(x_k / x_k0)
+ u_campaign + e. So b is the median ratio, c_k an exponent that the formula misses in variable x_k.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.identity import RowIdentity, identity_of
from workbench.studs.quantities import Array, Specimens, specimens, undamaged_headed_studs
from workbench.studs.shear import Level, ShearModel, characteristic_strength, shear_model
from workbench.studs.statistics.annex_d import D8, evaluate_d8, sensitivities_of
from workbench.studs.statistics.intervals import (
    Interval,
    bootstrap_by_campaign,
    profile_interval,
    scatter_intervals,
)
from workbench.studs.statistics.mixed import Estimate, fit_robust
from workbench.studs.statistics.prediction import (
    LEAST_CAMPAIGNS,
    LeftOut,
    coverage,
    leave_one_campaign_out,
    predictive_quantile,
)
from workbench.studs.statistics.problem import Problem, problem

TRENDS = ("diameter", "concrete_strength", "concrete_modulus", "ultimate_strength", "slenderness")
# coefficients of variation of structures to come: assumptions, to be replaced by one's own
VARIATIONS = {
    "diameter": 0.01,
    "concrete_strength": 0.15,
    "concrete_modulus": 0.10,
    "ultimate_strength": 0.05,
}
ABOVE_STEEL = 1.0
FEW_CAMPAIGNS = 5
LEAST_FOR_DESIGN = 4  # tests, EN 1990 table D.2 for an unknown coefficient of variation


@dataclass(frozen=True, slots=True)
class Parameter:
    """A fitted parameter: its value and intervals; `bootstrap` is None with too few campaigns."""

    value: float
    profile: Interval
    bootstrap: Interval | None

    def to_dict(self) -> dict[str, object]:
        """Value and intervals."""
        return {
            "value": self.value,
            "profile": self.profile.to_dict(),
            "bootstrap": None if self.bootstrap is None else self.bootstrap.to_dict(),
        }


@dataclass(frozen=True)
class StrengthFit:
    """A strength formula judged by tests.

    `model`; `parameters`: ``bias`` (median of test over prediction) and the exponents of the
    trends asked for; scatters of the log ratio `sigma` within and `tau` between campaigns with
    intervals; `left_out`, campaigns predicted from the others; `d8`, EN 1990 D.8 on the same rows
    (which takes all tests as independent) at the `reference` stud; `new_campaign_factor`, 5 %
    fractile of test over the formula for a new test of a new campaign (None with fewer than three);
    `measurement`, relative standard uncertainty of the measured loads (None if not reported);
    `rows`, test, prediction and ratio of every row with its variables; `warnings`.
    """

    model: ShearModel
    parameters: dict[str, Parameter]
    sigma: float
    tau: float
    sigma_interval: Interval
    tau_interval: Interval
    left_out: tuple[LeftOut, ...]
    d8: D8
    reference: dict[str, float]
    new_campaign_factor: float | None
    measurement: float | None
    rows: pd.DataFrame
    warnings: tuple[str, ...]
    identity: RowIdentity
    estimate: Estimate

    @property
    def bias(self) -> float:
        """Median of test over prediction at the middle of the variables."""
        return self.parameters["bias"].value

    @property
    def model_scatter(self) -> float | None:
        """Scatter of the formula itself, with that of the measurement taken out of it."""
        if self.measurement is None:
            return None
        return float(np.sqrt(max(self.sigma**2 + self.tau**2 - self.measurement**2, 0.0)))

    def predict(self, tests: Specimens) -> Array:
        """Median resistance (n,) in N of studs in a new campaign, with the fitted correction."""
        design = _design(tests, tuple(self.parameters)[1:], self.reference)
        return np.asarray(self.model.of(tests) * np.exp(design @ self.estimate.theta))

    def validate(self, table: pd.DataFrame, confidence: float = 0.9) -> Validation:
        """Hold the fit against tests that it has not seen.

        Raises `InputError` when a row was used for the fit, also under another name.
        """
        chosen = undamaged_headed_studs(table)
        self.identity.refuse_overlap(chosen)
        kept, tests = _complete(chosen, self.model)
        log_ratio = np.log(tests.shear / self.predict(tests))
        trends = tuple(self.parameters)[1:]
        held = _problem(tests, self.model, trends, self.reference, fitted=False)
        known = {str(c).strip().casefold() for c in kept["campaign"]} & self.identity.campaigns
        return Validation(
            len(tests), float(np.exp(np.mean(log_ratio))), float(np.sqrt(np.mean(log_ratio**2))),
            coverage(self.estimate, held, confidence), confidence, tuple(sorted(known)),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Everything but the rows, ready for JSON; loads in N."""
        return {
            "model": self.model.name,
            "title": self.model.title,
            "source": self.model.source,
            "tests": len(self.rows),
            "campaigns": sorted(self.identity.campaigns),
            "parameters": {name: p.to_dict() for name, p in self.parameters.items()},
            "sigma": {"value": self.sigma, **self.sigma_interval.to_dict()},
            "tau": {"value": self.tau, **self.tau_interval.to_dict()},
            "left_out": [asdict(each) for each in self.left_out],
            "d8": self.d8.to_dict(),
            "reference": self.reference,
            "new_campaign_factor": self.new_campaign_factor,
            "measurement": self.measurement,
            "model_scatter": self.model_scatter,
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, slots=True)
class Validation:
    """A fit on unseen tests: `count`, median ratio `bias`, root mean square of the log ratio.

    `covered`, share inside the prediction interval of `confidence` (None if the fit has too few
    campaigns for one); `known_campaigns`, campaigns that the fit has seen other specimens of, so
    that the tests are not independent of it.
    """

    count: int
    bias: float
    rms: float
    covered: float | None
    confidence: float
    known_campaigns: tuple[str, ...]

    def to_dict(self) -> dict[str, object]:
        """All values by name."""
        return asdict(self)


def fit_strength(
    table: pd.DataFrame,
    model: str | ShearModel = "roik-mean",
    *,
    trends: Sequence[str] = (),
    loss: str = "linear",
    confidence: float = 0.9,
    resamples: int = 500,
    seed: int = 0,
    variations: Mapping[str, float] | None = None,
) -> StrengthFit:
    """Fit a strength formula to the undamaged headed studs of a table (schema `TESTS`).

    Arguments: `model`, a name in `SHEAR_MODELS` or a `ShearModel`; `trends`, variables out of
    `TRENDS` whose missing exponents are fitted; `loss`, ``linear``, ``huber`` or ``bisquare``;
    `confidence` of the intervals; `resamples` and `seed` of the bootstrap; `variations`, see
    `evaluate_d8` (default `VARIATIONS`). Raises `InputError`, `SolverError`.
    """
    chosen = shear_model(model) if isinstance(model, str) else model
    for trend in trends:
        if trend not in TRENDS:
            raise InputError("trends", trend, "must be one of " + ", ".join(TRENDS))
    kept, tests = _complete(undamaged_headed_studs(table), chosen)
    reference = _reference(tests)
    given = _problem(tests, chosen, tuple(trends), reference)
    estimate = fit_robust(given, loss)
    many = given.campaigns >= 3
    bootstrap = (
        bootstrap_by_campaign(estimate, confidence=confidence, resamples=resamples, seed=seed)
        if many
        else {}
    )
    parameters = {
        name: _parameter(estimate, name, confidence, bootstrap.get(name)) for name in given.names
    }
    scatter = scatter_intervals(estimate, confidence)
    prediction = chosen.of(tests)
    return StrengthFit(
        model=chosen,
        parameters=parameters,
        sigma=estimate.sigma,
        tau=estimate.tau,
        sigma_interval=scatter["sigma"],
        tau_interval=scatter["tau"],
        left_out=tuple(_left_out(given)),
        d8=_d8(tests, chosen, reference, dict(VARIATIONS if variations is None else variations)),
        reference=reference,
        new_campaign_factor=_new_campaign(estimate),
        measurement=_measurement(kept),
        rows=_rows(kept, tests, prediction),
        warnings=tuple(_warnings(kept, tests, chosen, given)),
        identity=identity_of(kept),
        estimate=estimate,
    )


def _complete(rows: pd.DataFrame, model: ShearModel) -> tuple[pd.DataFrame, Specimens]:
    """Rows for which the formula has a value."""
    known = np.isfinite(model.of(specimens(rows)))
    if not known.any():
        raise InputError(
            "table", f"{len(rows)} rows", f"holds no test with all values that {model.title} needs",
            "fill diameter_mm, height_mm, fcm_MPa and fu_MPa",
        )  # fmt: skip
    kept = rows[known].reset_index(drop=True)
    return kept, specimens(kept)


def _reference(tests: Specimens) -> dict[str, float]:
    """Geometric means of the variables: the stud that bias and D.8 speak of."""
    values = {name: _variable(tests, name) for name in (*TRENDS, "height")}
    return {name: float(np.exp(np.mean(np.log(v)))) for name, v in values.items()}


def _variable(tests: Specimens, name: str) -> Array:
    if name == "slenderness":
        return np.asarray(tests.height / tests.diameter)
    return np.asarray(getattr(tests, name))


def _design(tests: Specimens, trends: tuple[str, ...], reference: Mapping[str, float]) -> Array:
    columns = [np.log(_variable(tests, name) / reference[name]) for name in trends]
    return np.column_stack([np.ones(len(tests)), *columns])


def _problem(
    tests: Specimens,
    model: ShearModel,
    trends: tuple[str, ...],
    reference: Mapping[str, float],
    *,
    fitted: bool = True,
) -> Problem:
    return problem(
        np.log(tests.shear / model.of(tests)),
        tests.campaign,
        None,
        ("bias", *trends),
        np.zeros(1 + len(trends)),
        design=_design(tests, trends, reference),
        fitted=fitted,
    )


def _parameter(
    estimate: Estimate, name: str, confidence: float, bootstrap: Interval | None
) -> Parameter:
    profile = profile_interval(estimate, name, confidence)
    value = estimate.parameter(name)
    if name != "bias":
        return Parameter(value, profile, bootstrap)
    return Parameter(
        float(np.exp(value)), _exponential(profile),
        None if bootstrap is None else _exponential(bootstrap),
    )  # fmt: skip


def _exponential(interval: Interval) -> Interval:
    low, high = (None if v is None else float(np.exp(v)) for v in (interval.low, interval.high))
    return Interval(low, high, interval.confidence, interval.method)


def _left_out(given: Problem) -> list[LeftOut]:
    if given.campaigns < 2:
        return []
    smallest = given.count - max(np.bincount(given.groups))
    return leave_one_campaign_out(given) if smallest > len(given.names) else []


def _new_campaign(estimate: Estimate) -> float | None:
    if estimate.problem.campaigns < LEAST_CAMPAIGNS:
        return None
    quantile = predictive_quantile(estimate, estimate.problem, 0.05)
    return float(np.exp(np.mean(quantile)))


def _d8(
    tests: Specimens,
    model: ShearModel,
    reference: Mapping[str, float],
    variations: dict[str, float],
) -> D8:
    height = reference["height"]

    def resistance(x: Mapping[str, float]) -> float:
        return float(
            model.resistance(
                x["diameter"], height, x["concrete_strength"], x["concrete_modulus"],
                x["ultimate_strength"],
            )
        )  # fmt: skip

    means = {name: reference[name] for name in VARIATIONS if np.isfinite(reference[name])}
    used = {name: v for name, v in variations.items() if name in means}
    full = {name: means.get(name, np.nan) for name in VARIATIONS}
    sensitivities = sensitivities_of(lambda x: resistance({**full, **x}), means)
    nominal = None
    if model.level is not Level.CHARACTERISTIC and np.isfinite(reference["ultimate_strength"]):
        code = shear_model("en1994")
    else:
        code = model
    if np.isfinite(reference["ultimate_strength"]) or np.isinf(code.steel_factor):
        nominal = float(
            code.resistance(
                means["diameter"], height, characteristic_strength(means["concrete_strength"]),
                means["concrete_modulus"], reference["ultimate_strength"],
            )
        )  # fmt: skip
    return evaluate_d8(
        tests.shear, model.of(tests), variations=used,
        sensitivities={name: s for name, s in sensitivities.items() if name in used},
        resistance=resistance(full), nominal=nominal,
    )  # fmt: skip


def _measurement(kept: pd.DataFrame) -> float | None:
    """Root mean square of the relative uncertainty of the loads, if all rows report it."""
    relative = kept["shear_uncertainty_kN"].to_numpy(float) / kept["shear_kN"].to_numpy(float)
    return float(np.sqrt(np.mean(relative**2))) if np.all(np.isfinite(relative)) else None


def _rows(kept: pd.DataFrame, tests: Specimens, prediction: Array) -> pd.DataFrame:
    """Test, prediction and ratio of every row, with all variables (SI)."""
    return pd.DataFrame(
        {
            "campaign": kept["campaign"],
            "specimen": kept["specimen"],
            "flag": kept["flag"],
            "test": tests.shear,
            "prediction": prediction,
            "ratio": tests.shear / prediction,
            **{name: _variable(tests, name) for name in TRENDS},
            "over_steel": tests.shear / (tests.area * tests.ultimate_strength),
        }
    )


def _stiffer(tests: Specimens) -> str:
    """By how much the modulus of EN 1992-1-1 exceeds the computed one, in words."""
    own = ~tests.modulus_measured
    european = 22e9 * (tests.concrete_strength[own] / 10e6) ** 0.3
    more = 100.0 * (european / tests.concrete_modulus[own] - 1.0)
    low, high = float(np.min(more)), float(np.max(more))
    return f"{low:.0f} %" if high - low < 1.0 else f"{low:.0f} to {high:.0f} %"


def _warnings(kept: pd.DataFrame, tests: Specimens, model: ShearModel, given: Problem) -> list[str]:
    result = list(model.findings(tests))
    steel = tests.shear / (tests.area * tests.ultimate_strength)
    above = int(np.sum(steel > ABOVE_STEEL))
    if above:
        result.append(
            f"{above} of {len(tests)} tests exceed the tensile strength of their shank: part of "
            "their load was carried otherwise (bond, friction, weld collar), and a formula "
            "calibrated on them alone would be unsafe"
        )
    if given.count == given.campaigns > 1:
        result.append(
            "one test per campaign: the scatter within and between campaigns cannot be told apart"
        )
    if given.campaigns == 1:
        result.append("one campaign: nothing can be said about the scatter between campaigns")
    elif given.campaigns == 2:
        result.append(
            "two campaigns: nothing tells how much campaigns differ; the interval of the bias is "
            "too narrow and there is no value for a new campaign"
        )
    elif given.campaigns < FEW_CAMPAIGNS:
        result.append(f"{given.campaigns} campaigns: the scatter between campaigns is hardly known")
    if given.count < LEAST_FOR_DESIGN:
        result.append(
            f"{given.count} tests: EN 1990 has no factor of the design value for fewer than "
            f"{LEAST_FOR_DESIGN} with unknown scatter"
        )
    if _measurement(kept) is None:
        result.append("the uncertainty of the measured loads is not reported: it stays in sigma")
    computed = int(np.sum(~tests.modulus_measured))
    if computed:
        result.append(
            f"the modulus of concrete is computed as 4733 sqrt(fc) MPa (ACI 318), not measured, in "
            f"{computed} tests; 22 (fc/10)^0.3 GPa of EN 1992-1-1 is {_stiffer(tests)} more and "
            "would raise predictions that the concrete governs: give Ecm_MPa to use another"
        )
    return result
