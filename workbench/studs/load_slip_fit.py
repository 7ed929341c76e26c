"""Fit of a load-slip law to a table of curves: curves are the observations, not points.

Each curve gives its own parameters; their logarithms are then regressed on a constant with a
random effect per campaign. So many points of one digitised curve count once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError, OutOfDomainError
from workbench.studs.curve_fit import CurveFit, fit_curve, make_law, misfit, parameter_names
from workbench.studs.load_slip import BilinearLaw, OllgaardLaw, RationalLaw
from workbench.studs.quantities import Array
from workbench.studs.statistics.intervals import (
    Interval,
    bootstrap_by_campaign,
    profile_interval,
    scatter_intervals,
)
from workbench.studs.statistics.mixed import Estimate, fit_robust
from workbench.studs.statistics.problem import problem
from workbench.studs.stiffness import chord_stiffness

HELD = {"rational": {"softening": 0.0}}
ENDLESS = 0.5  # m: beyond the slip of any test
# middles of 20 equal shares of the standard normal distribution
_NORMAL = np.array([NormalDist().inv_cdf((k + 0.5) / 20.0) for k in range(20)])


@dataclass(frozen=True)
class Population:
    """One parameter over the curves: `median`, intervals, scatters of its logarithm."""

    median: float
    profile: Interval
    bootstrap: Interval | None
    sigma: float
    tau: float
    scatter: dict[str, Interval]

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "median": self.median,
            "profile": self.profile.to_dict(),
            "bootstrap": None if self.bootstrap is None else self.bootstrap.to_dict(),
            "sigma": {"value": self.sigma, **self.scatter["sigma"].to_dict()},
            "tau": {"value": self.tau, **self.scatter["tau"].to_dict()},
        }


@dataclass(frozen=True)
class LoadSlipFit:
    """A load-slip law over a table of curves.

    `law_name`; `curves`, one row per curve: campaign, specimen, points, parameters (SI), rms and
    bias of the fit and of the published Ollgaard law, strength (N), chord stiffness (N/m);
    `population` by parameter, and parameters `held`; `logarithms` (curves, p) behind it;
    `skipped`, curves that could not be fitted, each with the reason; `warnings`.
    """

    law_name: str
    curves: pd.DataFrame
    population: dict[str, Population]
    held: dict[str, float]
    logarithms: Array
    skipped: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def law(self) -> OllgaardLaw | BilinearLaw | RationalLaw:
        """The law with the median parameters."""
        return make_law(self.law_name, self._medians())

    @property
    def shape(self) -> OllgaardLaw | BilinearLaw | RationalLaw:
        """The law with the median parameters and without the end of the bilinear law.

        A slip capacity is no matter of the shape: EN 1994-1-1 B.2 evaluates it (`evaluate_table`).
        """
        return make_law(self.law_name, self._medians(), ENDLESS)

    def _medians(self) -> dict[str, float]:
        return {**{name: p.median for name, p in self.population.items()}, **self.held}

    def band(self, slip: ArrayLike, share: float = 0.9) -> tuple[Array, Array]:
        """Load ratios (n,) that hold a `share` of the points of a further curve, at slips (m).

        Of the fitted campaigns; of a new one fewer points lie inside. At each slip the laws of the
        curves, each with the misfit of its points, make one distribution, so that the parameters
        keep their correlation. Its quantiles are those of the order statistics of n curves, which
        hold a further one with the wanted probability (below 20 curves: at most the extremes).
        """
        names = list(self.population)
        s = np.asarray(slip, float)
        ratios = np.array(
            [
                make_law(
                    self.law_name,
                    {**dict(zip(names, np.exp(row).tolist(), strict=True)), **self.held},
                    ENDLESS,
                ).ratio(s)
                for row in self.logarithms
            ]
        )
        count = len(ratios)
        points = self.curves["points"].to_numpy(float)
        spread = self.curves["rms"].to_numpy(float)
        spread = spread * np.sqrt(points / np.maximum(points - len(names), 1.0))
        scattered = ratios[:, None, :] + (spread[:, None] * _NORMAL)[:, :, None]
        tail = max((0.5 * (1.0 - share) * (count + 1.0) - 0.5) / count, 0.0)
        low, high = np.quantile(scattered.reshape(-1, len(s)), [tail, 1.0 - tail], axis=0)
        return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the curves' rows, ready for JSON (SI)."""
        return {
            "law": self.law_name,
            "curves": len(self.curves),
            "campaigns": sorted(set(self.curves["campaign"])),
            "held": self.held,
            "population": {name: p.to_dict() for name, p in self.population.items()},
            "median_rms": float(self.curves["rms"].median()),
            "median_rms_of_published_ollgaard": float(self.curves["published_rms"].median()),
            "median_bias_of_published_ollgaard": float(self.curves["published_bias"].median()),
            "skipped": list(self.skipped),
            "warnings": list(self.warnings),
        }


def first_loading(points: pd.DataFrame, *, falling: bool) -> pd.DataFrame:
    """Points that belong to the first loading of single specimens, with loads and slips in SI.

    Unloading readings, mean curves and doubtful points (`use_for_fit` 0) are left out, and the
    `falling` branch unless it is wanted. Raises `InputError` if nothing is left.
    """
    kept = (points["single_specimen"] == 1.0) & (points["on_envelope"] == 1.0)
    kept &= points["use_for_fit"] == 1.0
    kept &= ~points["branch"].isin(["low-load reading", "later loading"])
    if not falling:
        kept &= points["branch"] != "post-peak"
    if not kept.any():
        raise InputError("points", len(points), "hold no point of a first loading to be fitted")
    rows = points[kept]
    return pd.DataFrame(
        {
            "campaign": rows["campaign"],
            "specimen": rows["specimen"],
            "slip": 1e-3 * rows["slip_mm"].astype(float),
            "load": 1e3 * rows["load_kN"].astype(float),
        }
    )


def fit_load_slip(
    points: pd.DataFrame,
    law: str = "ollgaard",
    *,
    loss: str = "linear",
    held: Mapping[str, float] | None = None,
    least_points: int = 3,
    confidence: float = 0.9,
    resamples: int = 500,
    seed: int = 0,
) -> LoadSlipFit:
    """Fit a law to every curve of a table (schema `POINTS`) and to their population.

    Arguments: `law`, a name in `LAWS`; `loss` of the points of a curve (see `fit_curve`); `held`,
    parameters that are not fitted (default: the softening of the rational law, at 0, as few curves
    go beyond their maximum); `least_points` of a curve; `confidence`, `resamples`, `seed` of the
    intervals. Loads are taken over the largest load of the curve, so curves that
    were stopped before their maximum do not belong here. Raises `InputError`.
    """
    fixed = dict(HELD.get(law, {}) if held is None else held)
    names = tuple(name for name in parameter_names(law) if name not in fixed)
    used = first_loading(points, falling=law == "rational")
    fits: list[CurveFit] = []
    rows: list[dict[str, object]] = []
    skipped: list[str] = []
    for key, curve in used.groupby(["campaign", "specimen"], sort=False):
        campaign, specimen = str(key[0]), str(key[1])
        if len(curve) < max(least_points, len(names)):
            skipped.append(f"{campaign} {specimen}: {len(curve)} points")
            continue
        slip, load = curve["slip"].to_numpy(float), curve["load"].to_numpy(float)
        fit = fit_curve(slip, load, law, loss=loss, held=fixed)
        fits.append(fit)
        rows.append({"campaign": campaign, "specimen": specimen, **_row(fit, slip, load)})
    if len(fits) < 2:
        raise InputError("points", len(fits), "must hold two curves or more that can be fitted")
    curves = pd.DataFrame(rows)
    logarithms = np.log([[fit.parameters[name] for name in names] for fit in fits])
    population = {
        name: _population(
            logarithms[:, k], curves["campaign"].to_numpy(str), confidence, resamples, seed
        )
        for k, name in enumerate(names)
    }
    return LoadSlipFit(
        law, curves, population, fixed, logarithms, tuple(skipped), tuple(_warnings(curves, fits))
    )


def _row(fit: CurveFit, slip: Array, load: Array) -> dict[str, object]:
    top = float(np.max(load))
    published_rms, published_bias = misfit(OllgaardLaw(), slip, load / top)
    try:
        stiffness = chord_stiffness(slip, load)
    except OutOfDomainError:
        stiffness = float("nan")  # both levels at one slip: the curve does not tell
    return {
        "points": fit.points, **fit.parameters, "rms": fit.rms, "bias": fit.bias,
        "published_rms": published_rms, "published_bias": published_bias,
        "strength": top, "slip_at_max": float(slip[int(np.argmax(load))]),
        "chord_stiffness": stiffness, "near_interpolation": fit.near_interpolation,
        "at_bound": ", ".join(fit.at_bound),
    }  # fmt: skip


def _population(
    values: Array, campaigns: Any, confidence: float, resamples: int, seed: int
) -> Population:
    given = problem(
        values, campaigns, None, ("median",), [float(np.median(values))],
        design=np.ones((len(values), 1)),
    )  # fmt: skip
    estimate: Estimate = fit_robust(given)
    bootstrap = None
    if given.campaigns >= 3:
        drawn = bootstrap_by_campaign(
            estimate, confidence=confidence, resamples=resamples, seed=seed
        )
        bootstrap = _exp(drawn["median"])
    return Population(
        float(np.exp(estimate.theta[0])),
        _exp(profile_interval(estimate, "median", confidence)),
        bootstrap, estimate.sigma, estimate.tau, scatter_intervals(estimate, confidence),
    )  # fmt: skip


def _exp(interval: Interval) -> Interval:
    low, high = (None if v is None else float(np.exp(v)) for v in (interval.low, interval.high))
    return Interval(low, high, interval.confidence, interval.method)


def _warnings(curves: pd.DataFrame, fits: list[CurveFit]) -> list[str]:
    result = []
    few = int(curves["near_interpolation"].sum())
    if few:
        result.append(f"{few} of {len(fits)} curves have hardly more points than parameters")
    stuck = int((curves["at_bound"] != "").sum())
    if stuck:
        result.append(f"{stuck} of {len(fits)} curves rest on a bound of a parameter")
    campaigns = curves["campaign"].nunique()
    if campaigns < 5:
        result.append(f"{campaigns} campaigns: the scatter between them is hardly known")
    return result
