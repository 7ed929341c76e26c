"""Fit of a load-slip law to a table of curves: curves are the observations, not points.

Each curve gives its own parameters; their logarithms are then regressed on a constant with a
random effect per campaign. So many points of one digitised curve count once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.responses import Finding
from workbench.studs.fit_protocol import (
    Content,
    Fit,
    Fitted,
    Judgement,
    Told,
    fitted,
    grade_of,
    judge,
)
from workbench.studs.load_slip import (
    CurveFit,
    Law,
    OllgaardLaw,
    chord_stiffness,
    fit_curve,
    law_stiffness,
    make_law,
    misfit,
    parameter_names,
)
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import fit
from workbench.studs.statistics.prediction import influence_of, without_each
from workbench.studs.statistics.problem import location
from workbench.studs.suspicion import suspicions_of_points
from workbench.studs.tables import curves_of, identity_of

HELD = {"rational": {"softening": 0.0}}  # not fitted: few curves go beyond their maximum
ENDLESS = 0.5  # m: beyond the slip of any test
GRID = np.linspace(0.0, 10e-3, 101)  # m, slips at which median and band are given
FEW_CAMPAIGNS = 5
# middles of 20 equal shares of the standard normal distribution
_NORMAL = np.array([NormalDist().inv_cdf((k + 0.5) / 20.0) for k in range(20)])


Band = Callable[[Array, float], tuple[Array, Array]]  # bounds at slips (m) for a share of points


@dataclass(frozen=True)
class CurveJudgement:
    """A law on curves that no fit has used.

    `rows`, one per curve: campaign, specimen, points, rms and bias of the load over the largest
    load, share of its points inside the band (`inside`, NaN without a band); `stiffness`, test over
    prediction of the chord stiffness at the measured strength (None where no curve tells it);
    `coverage`, mean of `inside` over the curves (None without a band).
    """

    rows: pd.DataFrame
    stiffness: Judgement | None
    coverage: float | None
    confidence: float

    @property
    def coverage_half_width(self) -> float | None:
        """Half-width of the interval of the coverage over curves; None with a single one.

        At least one curve more or less.
        """
        from scipy.special import stdtrit

        count = len(self.rows)
        if self.coverage is None or count < 2:
            return None
        error = float(self.rows["inside"].std(ddof=1)) / np.sqrt(count)
        width = float(stdtrit(count - 1.0, 0.5 + 0.5 * self.confidence) * error)
        return max(width, 1.0 / count)

    @property
    def told(self) -> dict[str, Told]:
        """What a model is compared by; a coverage stays between none and all."""
        coverage, width, stiffness = Told(self.coverage), self.coverage_half_width, Told(None)
        if self.coverage is not None and width is not None:
            ends = max(self.coverage - width, 0.0), min(self.coverage + width, 1.0)
            coverage = Told(self.coverage, width, ends)
        if self.stiffness is not None:
            stiffness = self.stiffness.told["test_over_prediction"]
        return {"coverage": coverage, "stiffness_test_over_prediction": stiffness}

    def to_dict(self) -> Content:
        """Everything but the rows."""
        return {
            "curves": len(self.rows),
            "campaigns": sorted(set(self.rows["campaign"])),
            "median_rms": float(self.rows["rms"].median()),
            "coverage": self.coverage,
            "stiffness": None if self.stiffness is None else self.stiffness.to_dict(),
        }


def judge_curves(
    points: pd.DataFrame, law: Law, band: Band | None = None, confidence: float = 0.9
) -> CurveJudgement:
    """Judge a law by the first loading of every curve of a table (schema `POINTS`).

    Arguments: `law`; the `band` of the fit that it is the median of (None: a law as published,
    without a band). Raises `InputError`.
    """
    rows: list[dict[str, Any]] = []
    stiffness: list[dict[str, Any]] = []
    for name, slip, load in curves_of(points, falling=law.name == "rational"):
        top = float(load.max())
        if len(slip) < 2 or top <= 0.0:
            continue
        ratio = load / top
        rms, bias = misfit(law, slip, ratio)
        inside = float("nan")
        if band is not None:
            low, high = band(np.maximum(slip, 0.0), confidence)
            inside = float(np.mean((ratio >= low) & (ratio <= high)))
        rows.append({**name, "points": len(slip), "rms": rms, "bias": bias, "inside": inside})
        measured = chord_stiffness(slip, load)
        if np.isfinite(measured):
            stiffness.append({**name, "test": measured, "prediction": law_stiffness(law, top)})
    if not rows:
        raise InputError("validation", 0, "holds no curve of two points or more")
    frame, stiff, told = pd.DataFrame(rows), pd.DataFrame(stiffness), None
    if stiffness:
        told = judge(stiff, stiff["test"], stiff["prediction"], confidence)
    coverage = None if band is None else float(frame["inside"].mean())
    return CurveJudgement(frame, told, coverage, confidence)


@dataclass(frozen=True)
class LoadSlipFit(Fit):
    """A load-slip law over a table of curves.

    `law_name`; `rows`, one per curve: campaign, specimen, points, parameters (SI), rms and
    bias of the fit and of the published Ollgaard law, strength (N), chord stiffness (N/m);
    `population`, the median of each parameter over the curves and the scatters of its logarithm;
    `coverage`, share of the points of left-out ``curves`` and ``campaigns`` inside the band (of
    `confidence`) that the others make, None where they are too few; parameters `held`;
    `logarithms` (curves, p) behind it; `skipped`, curves that could not be
    fitted, each with the reason.
    """

    law_name: str
    population: dict[str, Fitted]
    coverage: dict[str, float | None]
    held: dict[str, float]
    logarithms: Array
    skipped: tuple[str, ...]

    @property
    def medians(self) -> dict[str, float]:
        """Median of every parameter, and those that are held."""
        return {**{name: p.estimates["median"] for name, p in self.population.items()}, **self.held}

    @property
    def shape(self) -> Law:
        """The law with the median parameters and without the end of the bilinear law.

        A slip capacity is no matter of the shape: EN 1994-1-1 B.2 evaluates it (`evaluate_series`).
        """
        return make_law(self.law_name, self.medians, ENDLESS)

    def band(self, slip: ArrayLike, share: float = 0.9) -> tuple[Array, Array]:
        """Load ratios (n,) that hold a `share` of the points of a further curve, at slips (m).

        Of the fitted campaigns; of a new one fewer points lie inside. At each slip the laws of the
        curves, each with the misfit of its points, make one distribution, so that the parameters
        keep their correlation. Its quantiles are those of the order statistics of n curves, which
        hold a further one with the wanted probability (below 20 curves: at most the extremes).
        """
        laws = _laws(self.law_name, tuple(self.population), self.logarithms, self.held)
        ratios = np.array([law.ratio(np.asarray(slip, float)) for law in laws])
        return _bounds(ratios, _spread(self.rows, len(self.population)), share)

    def to_dict(self) -> Content:
        """Everything but the curves' rows (SI)."""
        population = {
            name: {"median": p.estimates["median"], "profile": p.parameters["median"].profile,
                   "sigma": p.sigma, "tau": p.tau}
            for name, p in self.population.items()
        }  # fmt: skip
        return {
            "law": self.law_name,
            **self.used("curves"),
            "held": self.held,
            "population": population,
            "coverage": self.coverage,
            "median_rms": float(self.rows["rms"].median()),
            "median_rms_of_published_ollgaard": float(self.rows["published_rms"].median()),
            "median_bias_of_published_ollgaard": float(self.rows["published_bias"].median()),
            "skipped": self.skipped,
            "grade": grade_of(self.rows, "curves"),
            "holds": "for the shape of the curve, load over its largest value",
        }

    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> CurveJudgement:
        """Judge the law and its band by unseen curves (see `judge_curves`)."""
        self.identity.refuse_overlap(table)
        return judge_curves(table, self.shape, self.band, confidence)

    def influence(self) -> pd.DataFrame:
        """How every curve moves the median of every parameter."""
        parts = (
            influence_of(self.rows, p.estimate, name, p.estimates["median"],
                         np.exp(without_each(p.estimate)[:, 0]))
            for name, p in self.population.items()
        )  # fmt: skip
        return pd.concat(parts, ignore_index=True)

    def parts(self, confidence: float) -> Content:
        """Its curves, median and band over the slip."""
        low, high = self.band(GRID, confidence)
        grid = {"slip": GRID, "median": self.shape.ratio(GRID), "low": low, "high": high}
        return {"curves": self.rows, "grid": grid}


def fit_load_slip(
    points: pd.DataFrame,
    law: str = "ollgaard",
    *,
    loss: str = "linear",
    least_points: int = 3,
    confidence: float = 0.9,
) -> LoadSlipFit:
    """Fit a law to every curve of a table (schema `POINTS`) and to their population.

    Arguments: `law`, a name in `LAWS`; `loss` of the points of a curve (see `fit_curve`);
    `least_points` of a curve; `confidence` of the intervals. Loads are taken
    over the largest load of the curve, so curves that were stopped before their maximum do not
    belong here. Raises `InputError`.
    """
    fixed = HELD.get(law, {})
    names = tuple(name for name in parameter_names(law) if name not in fixed)
    rows: list[dict[str, object]] = []
    skipped: list[str] = []
    measured: list[tuple[Array, Array]] = []
    for name, slip, load in curves_of(points, falling=law == "rational"):
        if len(slip) < max(least_points, len(names)):
            words = "one point" if len(slip) == 1 else f"{len(slip)} points"
            skipped.append(f"{name['campaign']} {name['specimen']}: {words}")
            continue
        rows.append({**name, **_row(fit_curve(slip, load, law, loss=loss, held=fixed), slip, load)})
        measured.append((np.maximum(slip, 0.0), load / load.max()))
    if len(rows) < 2:
        raise InputError("points", len(rows), "must hold two curves or more that can be fitted")
    curves = pd.DataFrame(rows)
    logarithms = np.log(curves[list(names)].to_numpy(float))
    population = {}
    for parameter, own in zip(names, logarithms.T, strict=True):
        estimate = fit(location(own, curves["campaign"].to_numpy(str)))
        population[parameter] = fitted(estimate, ("median",), confidence=confidence)
    laws = _laws(law, names, logarithms, fixed)
    covered = _coverage(laws, measured, curves, len(names), confidence)
    found = (law, population, covered, fixed, logarithms, tuple(skipped))
    findings = (*suspicions_of_points(points), *_findings(curves))
    return LoadSlipFit(*found, rows=curves, findings=findings, identity=identity_of(curves))


def _laws(law: str, names: tuple[str, ...], logarithms: Array, held: dict[str, float]) -> list[Law]:
    """The law of every curve, without the end of the bilinear law."""
    own = (dict(zip(names, np.exp(row).tolist(), strict=True)) for row in logarithms)
    return [make_law(law, {**each, **held}, ENDLESS) for each in own]


def _spread(curves: pd.DataFrame, parameters: int) -> Array:
    """Standard deviation (curves,) of the points of each curve about its law."""
    points, rms = (curves[name].to_numpy(float) for name in ("points", "rms"))
    return np.asarray(rms * np.sqrt(points / np.maximum(points - parameters, 1.0)))


def _bounds(ratios: Array, spread: Array, share: float) -> tuple[Array, Array]:
    """Band (n,) of the load ratios (curves, n) of laws whose points scatter by `spread`."""
    count, n = ratios.shape
    scattered = ratios[:, None, :] + (spread[:, None] * _NORMAL)[:, :, None]
    tail = max((0.5 * (1.0 - share) * (count + 1.0) - 0.5) / count, 0.0)
    low, high = np.quantile(scattered.reshape(-1, n), [tail, 1.0 - tail], axis=0)
    return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)


def _coverage(
    laws: list[Law],
    measured: list[tuple[Array, Array]],
    curves: pd.DataFrame,
    parameters: int,
    share: float,
) -> dict[str, float | None]:
    """Share of the points of what is left out inside the band of the others, curves alike.

    Curves and campaigns are left out in turn; None where fewer than two curves would be left.
    """
    spread, result = _spread(curves, parameters), {}
    for kind, parts in (("curves", curves.index), ("campaigns", curves["campaign"])):
        inside = []
        for k, (slip, ratio) in enumerate(measured):
            others = np.flatnonzero(np.asarray(parts) != parts[k])
            if len(others) > 1:
                low, high = _bounds(
                    np.array([laws[i].ratio(slip) for i in others]), spread[others], share
                )
                inside.append(np.mean((ratio >= low) & (ratio <= high)))
        result[kind] = float(np.mean(inside)) if len(inside) == len(measured) else None
    return result


def _row(fit: CurveFit, slip: Array, load: Array) -> dict[str, object]:
    top = float(np.max(load))
    published_rms, published_bias = misfit(OllgaardLaw(), slip, load / top)
    return {
        "points": fit.points, **fit.parameters, "rms": fit.rms, "bias": fit.bias,
        "published_rms": published_rms, "published_bias": published_bias,
        "strength": top, "slip_at_max": float(slip[int(np.argmax(load))]),
        "chord_stiffness": chord_stiffness(slip, load),
        "near_interpolation": fit.near_interpolation, "at_bound": ", ".join(fit.at_bound),
    }  # fmt: skip


def _findings(curves: pd.DataFrame) -> Iterator[Finding]:
    for subject, which, words in (
        ("points", curves["near_interpolation"], "have hardly more points than parameters"),
        ("bounds", curves["at_bound"] != "", "rest on a bound of a parameter"),
    ):
        if which.any():
            yield Finding(subject, f"{which.sum()} of {len(curves)} curves {words}")
    campaigns = curves["campaign"].nunique()
    if campaigns < FEW_CAMPAIGNS:
        text = f"{campaigns} campaigns: the scatter between them is hardly known"
        yield Finding("campaigns", text)
