"""Fit of a load-slip law to a table of curves: curves are the observations, not points.

Each curve gives its own parameters; their logarithms are then regressed on a constant with a
random effect per campaign. So many points of one digitised curve count once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.errors import InputError
from workbench.responses import Finding, finding
from workbench.studs.fit_protocol import (
    Fit,
    Fitted,
    Judgement,
    Scalar,
    Summary,
    Tables,
    counted,
    fitted,
    grade_of,
    judge,
)
from workbench.studs.load_slip import (
    LAWS,
    Law,
    OllgaardLaw,
    chord_stiffness,
    fit_curve,
    law_kind,
    law_stiffness,
    misfit,
)
from workbench.studs.quantities import Array
from workbench.studs.statistics.mixed import fit
from workbench.studs.statistics.prediction import influence_of, without_each
from workbench.studs.statistics.problem import location
from workbench.studs.suspicion import suspicions_of_points
from workbench.studs.tables import curves_of, recorded

ENDLESS = 0.5  # m: beyond the slip of any test
GRID = np.linspace(0.0, 10e-3, 101)  # m, slips at which median and band are given
FEW_CAMPAIGNS = 5
# middles of 20 equal shares of the standard normal distribution
_NORMAL = np.array([NormalDist().inv_cdf((k + 0.5) / 20.0) for k in range(20)])


Band = Callable[[Array, float], tuple[Array, Array]]  # bounds at slips (m) for a share of points


def judge_curves(
    points: pd.DataFrame, law: Law, band: Band | None = None, confidence: float = 0.9
) -> Judgement:
    """Judge a law by the first loading of every curve of a table (schema `POINTS`).

    Arguments: `law`; the `band` of the fit that it is the median of (None: a law as published,
    without a band). Rows, one per curve: points, rms and bias of the load over the largest load,
    share of the points `inside` the band (NaN without one). Scalars: the mean of these shares
    (`coverage`), and test over prediction of the chord stiffness at the measured strength, whose
    interval, least ratio and scatter the summary gives. Raises `InputError`.
    """
    rows: list[dict[str, Any]] = []
    stiffness: list[dict[str, Any]] = []
    for name, slip, load in curves_of(points, falling=law.falling):
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
    curves, over, more = pd.DataFrame(rows), Scalar(None), {}
    if stiffness:
        frame = pd.DataFrame(stiffness)
        judged = judge(frame, frame["test"], frame["prediction"], confidence)
        names = ("low", "high", "least_test_over_prediction", "scatter")
        over, more = judged.scalars["test_over_prediction"], {n: judged.summary[n] for n in names}
    scalars = {
        "coverage": _mean_share(curves["inside"], confidence),
        "stiffness_test_over_prediction": over,
    }
    summary = {
        **counted(curves, "curves"),
        **{name: each.value for name, each in scalars.items()},
        "median_rms": float(curves["rms"].median()),
        **more,
    }
    return Judgement(curves, scalars, summary)


def _mean_share(inside: pd.Series, confidence: float) -> Scalar:
    """Mean share of points in the band; its half-width over curves is at least one curve."""
    from scipy.special import stdtrit

    if inside.isna().all():
        return Scalar(None)
    mean, count = float(inside.mean()), len(inside)
    if count < 2:
        return Scalar(mean)
    error = float(inside.std(ddof=1)) / np.sqrt(count)
    width = float(stdtrit(count - 1.0, 0.5 + 0.5 * confidence) * error)
    width = max(width, 1.0 / count)
    return Scalar(mean, width, (max(mean - width, 0.0), min(mean + width, 1.0)))


@dataclass(frozen=True)
class LoadSlipFit(Fit):
    """A load-slip law over a table of curves.

    `rows`, one per curve: parameters (SI), rms and bias of the fit and of the published Ollgaard
    law, strength (N), chord stiffness (N/m); `population`, the median of each parameter over the
    curves and the scatters of its logarithm; `coverage`, share of the points of left-out ``curves``
    and ``campaigns`` inside the band of the others, None where they are too few; parameters `held`;
    `laws` of the curves, the bilinear one without its end; `skipped`, curves that were not fitted,
    and why.
    """

    law: str
    population: dict[str, Fitted]
    coverage: dict[str, float | None]
    held: dict[str, float]
    laws: tuple[Law, ...]
    skipped: tuple[str, ...]
    figures: ClassVar[tuple[str, ...]] = ("stud-curves",)

    @property
    def medians(self) -> dict[str, float]:
        """Median of every parameter, and those that are held."""
        return {**{name: p.estimates["median"] for name, p in self.population.items()}, **self.held}

    @property
    def shape(self) -> Law:
        """The law with the median parameters and without the end of the bilinear law.

        A slip capacity is no matter of the shape: EN 1994-1-1 B.2 evaluates it (`evaluate_series`).
        """
        return LAWS[self.law].fitted(self.medians, ENDLESS)

    def band(self, slip: ArrayLike, share: float = 0.9) -> tuple[Array, Array]:
        """Load ratios (n,) that hold a `share` of the points of a further curve, at slips (m).

        Of the fitted campaigns; of a new one fewer points lie inside. At each slip the laws of the
        curves, with the misfit of their points, make one distribution; its quantiles are those of
        the order statistics of n curves (below 20 curves: at most the extremes).
        """
        ratios = np.array([law.ratio(np.asarray(slip, float)) for law in self.laws])
        return _bounds(ratios, _spread(self.rows, len(self.population)), share)

    def summary(self) -> Summary:
        """The law, how well it fits, and what its band holds of left-out curves and campaigns."""
        return {
            "law": self.law,
            **counted(self.rows, "curves"),
            **{f"coverage_of_{kind}": share for kind, share in self.coverage.items()},
            "median_rms": float(self.rows["rms"].median()),
            "median_rms_of_published_ollgaard": float(self.rows["published_rms"].median()),
            "median_bias_of_published_ollgaard": float(self.rows["published_bias"].median()),
            "grade": grade_of(self.rows, "curves"),
            "holds": "for the shape of the curve, load over its largest value",
        }

    def tables(self, confidence: float = 0.9) -> Tables:
        """Parameters with scatters of their logarithms, curves, median and band over the slip."""
        free = {
            n: p.parameters["median"]._asdict() | p.scatters for n, p in self.population.items()
        }
        held = {name: {"value": value} for name, value in self.held.items()}
        bounds = LAWS[self.law].bounds
        parameters = [
            {"parameter": n, **row, "unit": bounds[n].unit, "factor": bounds[n].factor}
            for n, row in (free | held).items()
        ]
        low, high = self.band(GRID, confidence)
        grid = {"slip": GRID, "median": self.shape.ratio(GRID), "low": low, "high": high}
        return {
            "parameters": pd.DataFrame(parameters),
            "curves": self.rows,
            "grid": pd.DataFrame(grid),
            "skipped": pd.DataFrame({"why": list(self.skipped)}, dtype=object),
        }

    def judge(self, table: pd.DataFrame, confidence: float = 0.9) -> Judgement:
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
    `least_points` of a curve; `confidence` of the intervals. Loads are over the largest load, so
    curves that were stopped before their maximum do not belong here. Raises `InputError`.
    """
    kind, fixed = law_kind(law), dict(law_kind(law).held)
    names = tuple(name for name in kind.bounds if name not in fixed)
    rows: list[dict[str, object]] = []
    skipped: list[str] = []
    measured: list[tuple[Array, Array]] = []
    for name, slip, load in curves_of(points, falling=kind.falling):
        if len(slip) < max(least_points, len(names)):
            words = "one point" if len(slip) == 1 else f"{len(slip)} points"
            skipped.append(f"{name['campaign']} {name['specimen']}: {words}")
            continue
        rows.append({**name, **_row(slip, load, law, loss)})
        measured.append((np.maximum(slip, 0.0), load / load.max()))
    if len(rows) < 2:
        raise InputError("points", len(rows), "must hold two curves or more that can be fitted")
    curves = pd.DataFrame(rows)
    logarithms = np.log(curves[list(names)].to_numpy(float))
    population = {}
    for parameter, values in zip(names, logarithms.T, strict=True):
        estimate = fit(location(values, curves["campaign"].to_numpy(str)))
        population[parameter] = fitted(estimate, ("median",), confidence=confidence)
    free = (dict(zip(names, row, strict=True)) for row in np.exp(logarithms).tolist())
    laws = tuple(kind.fitted({**each, **fixed}, ENDLESS) for each in free)
    return LoadSlipFit(
        law=law,
        population=population,
        coverage=_coverage(laws, measured, curves, len(names), confidence),
        held=fixed,
        laws=laws,
        skipped=tuple(skipped),
        rows=curves,
        findings=(*suspicions_of_points(points), *_findings(points, curves)),
    )


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
    laws: tuple[Law, ...],
    measured: list[tuple[Array, Array]],
    curves: pd.DataFrame,
    parameters: int,
    share: float,
) -> dict[str, float | None]:
    """Share of the points of left-out curves and campaigns inside the band of the others.

    None where fewer than two curves would be left.
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


def _row(slip: Array, load: Array, law: str, loss: str) -> dict[str, object]:
    """A curve with the law that fits it, and with the published one."""
    best, top = fit_curve(slip, load, law, loss=loss, held=LAWS[law].held), float(np.max(load))
    published_rms, published_bias = misfit(OllgaardLaw(), slip, load / top)
    return {
        "points": best.points, **best.parameters, "rms": best.rms, "bias": best.bias,
        "published_rms": published_rms, "published_bias": published_bias,
        "strength": top, "slip_at_max": float(slip[int(np.argmax(load))]),
        "chord_stiffness": chord_stiffness(slip, load),
        "near_interpolation": best.near_interpolation, "at_bound": ", ".join(best.at_bound),
    }  # fmt: skip


def _findings(points: pd.DataFrame, curves: pd.DataFrame) -> Iterator[Finding]:
    rows = recorded(points)
    rows = rows[rows["branch"] != points["branch"][rows.index]]
    for branch, key in (("later loading", "stud-load-cycles"), ("post-peak", "stud-falls")):
        changed = rows[rows["branch"] == branch]
        if len(changed):
            named = changed[["campaign", "specimen"]].drop_duplicates()
            yield finding(key, count=len(changed), curves=len(named))
    near, stuck = curves["near_interpolation"].sum(), (curves["at_bound"] != "").sum()
    for key, count in (("stud-curve-points", near), ("stud-curve-bounds", stuck)):
        if count:
            yield finding(key, count=count, curves=len(curves))
    campaigns = curves["campaign"].nunique()
    if campaigns < FEW_CAMPAIGNS:
        yield finding("stud-few-campaigns", campaigns=campaigns)
