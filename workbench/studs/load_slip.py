"""Load-slip laws of a stud under first loading, their fit to one measured curve, stiffness.

A law gives the load over its largest value, q = Q / Q_max, as a function of the slip (`ratio`), and
the slip of its ascending branch at a load (`slip_at`). All that is to be known of a law stands in
its class; a new law is one more class and its place in `LAWS`. Stiffness is that of the chord from
10 to 40 % of the largest load (EN 1994-1-1 and AISC 360 speak of stiffness at such levels). In SI.

**Second part.** Fit of a load-slip law to a table of curves: curves are the observations, not
points.

Each curve gives its own parameters; their logarithms are then regressed on a constant with a
random effect per campaign. So many points of one digitised curve count once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.errors import InputError, OutOfDomainError, SolverError
from workbench.base.fields import Choice, Declared, Number, checked
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
from workbench.studs.plausibility import suspicions_of_points
from workbench.studs.statistics.intervals import influence_of, without_each
from workbench.studs.statistics.mixed import fit, location
from workbench.studs.tables import Array, curves_of, recorded


class Bound(NamedTuple):
    """Of a parameter that is fitted: bounds and start; the unit in tables, and its factor to SI."""

    low: float
    high: float
    start: float
    unit: str = ""
    factor: float = 1.0


class Law(Declared, table="law"):
    """A load-slip law: its `name`, `formula`, sources (`keys`) and the `bounds` of its parameters.

    `held`, parameters that a fit does not free; `falling`, whether it knows points beyond the
    largest load. A law defines its `curve` over positive slips and the `inverse` of its rise.
    """

    name: ClassVar[str]
    formula: ClassVar[str]
    keys: ClassVar[tuple[str, ...]]
    bounds: ClassVar[Mapping[str, Bound]]
    held: ClassVar[Mapping[str, float]] = {}
    falling: ClassVar[bool] = False

    def curve(self, slip: Array) -> Array:
        """Load over the largest load at slips (m) from 0 on."""
        raise NotImplementedError

    def inverse(self, ratio: float) -> float:
        """Slip (m) of the ascending branch at a load ratio from 0 to below 1."""
        raise NotImplementedError

    def ratio(self, slip: ArrayLike) -> Array:
        """Load over the largest load at slips (m). Raises `OutOfDomainError` for negative slips."""
        s = np.asarray(slip, float)
        if np.any(s < 0.0):
            raise OutOfDomainError(
                f"a load-slip law of first loading has no load for the slip {float(np.min(s)):g} "
                "m: reversed loading is outside its assumptions"
            )
        return np.asarray(self.curve(s))

    def slip_at(self, ratio: float) -> float:
        """Slip (m) of the ascending branch at a load ratio below 1. Raises `InputError`."""
        if not 0.0 <= ratio < 1.0:
            raise InputError("ratio", ratio, "must lie from 0 to below 1")
        return float(self.inverse(ratio))

    @classmethod
    def fitted(cls, parameters: Mapping[str, float], end: float) -> Self:
        """The law with fitted parameters (SI) for curves that end at a slip (m)."""
        return cls(**parameters)


@dataclass(frozen=True)
class OllgaardLaw(Law):
    """q = (1 - exp(-`rate` s))^`exponent`, `rate` in 1/m.

    The published parameters are 18 per inch (708.7 per m) and 0.4 (Ollgaard, Slutter and Fisher
    1971, recalled, not read again). With an exponent below 1 the tangent at zero is infinite:
    use a chord stiffness.
    """

    rate: float = checked(Number(1.0, 1e6, "1/m"), 18.0 / 0.0254)
    exponent: float = checked(Number(0.01, 20.0), 0.4)
    name: ClassVar[str] = "ollgaard"
    formula: ClassVar[str] = "q = (1 − exp(−rate s))^exponent"
    keys: ClassVar[tuple[str, ...]] = ("ollgaard1971",)
    bounds: ClassVar[Mapping[str, Bound]] = {
        "rate": Bound(10.0, 1e5, 1000.0, "1/mm", 1e3),
        "exponent": Bound(0.05, 10.0, 0.6),
    }

    def curve(self, slip: Array) -> Array:  # noqa: D102
        return np.asarray((-np.expm1(-self.rate * slip)) ** self.exponent)

    def inverse(self, ratio: float) -> float:  # noqa: D102
        return float(-np.log1p(-(ratio ** (1.0 / self.exponent))) / self.rate)


@dataclass(frozen=True)
class BilinearLaw(Law):
    """Linear to `yield_slip`, constant to `slip_capacity` (m), no load beyond.

    The defaults, 0.5 and 6 mm, are those in use with the mean values of Roik.
    """

    yield_slip: float = checked(Number(0.0, 0.1, "m", low_included=False), 0.5e-3)
    slip_capacity: float = checked(Number(0.0, 0.5, "m", low_included=False), 6.0e-3)
    name: ClassVar[str] = "bilinear"
    formula: ClassVar[str] = "q = s / yield slip, at most 1"
    keys: ClassVar[tuple[str, ...]] = ("roik1989",)
    bounds: ClassVar[Mapping[str, Bound]] = {"yield_slip": Bound(1e-5, 0.02, 5e-4, "mm", 1e-3)}

    def check(self) -> None:
        """Refuse what the fields cannot be together."""
        if self.slip_capacity < self.yield_slip:
            raise self.refusal("slip_capacity", f"must reach {self.yield_slip:g} m")

    def curve(self, slip: Array) -> Array:  # noqa: D102
        rising = np.minimum(slip / self.yield_slip, 1.0)
        return np.where(slip <= self.slip_capacity, rising, 0.0)

    def inverse(self, ratio: float) -> float:  # noqa: D102
        return ratio * self.yield_slip

    @classmethod
    def fitted(cls, parameters: Mapping[str, float], end: float) -> Self:  # noqa: D102
        return cls(min(parameters["yield_slip"], end), end)


@dataclass(frozen=True)
class RationalLaw(Law):
    """q = (k x + (D - 1) x^2) / (1 + (k - 2) x + D x^2), x = slip over `peak_slip` (m).

    `stiffness_ratio` k is the initial tangent over the secant to the peak; `softening` D in 0..1
    shapes the falling branch (1: slowest fall, 0: a parabola at k = 2). Sargin's form, which has
    its only maximum, 1, at the peak, and is never below zero. Source: Sargin 1971. Few curves go
    beyond their maximum: fits hold the softening.
    """

    peak_slip: float = checked(Number(1e-5, 0.1, "m"), 6.0e-3)
    stiffness_ratio: float = checked(Number(1.0, 1e3), 5.0)
    softening: float = checked(Number(0.0, 1.0), 0.5)
    name: ClassVar[str] = "rational"
    formula: ClassVar[str] = (
        "q = (k x − x²) / (1 + (k − 2) x), x = s / peak slip, k the stiffness ratio"
    )
    keys: ClassVar[tuple[str, ...]] = ("sargin1971",)
    bounds: ClassVar[Mapping[str, Bound]] = {
        "peak_slip": Bound(1e-4, 0.05, 6e-3, "mm", 1e-3),
        "stiffness_ratio": Bound(1.01, 500.0, 6.0),
        "softening": Bound(1e-4, 1.0, 0.5),
    }
    held: ClassVar[Mapping[str, float]] = {"softening": 0.0}
    falling: ClassVar[bool] = True

    def curve(self, slip: Array) -> Array:  # noqa: D102
        x, k, d = slip / self.peak_slip, self.stiffness_ratio, self.softening
        numerator = k * x + (d - 1.0) * x * x
        return np.asarray(np.maximum(numerator, 0.0) / (1.0 + (k - 2.0) * x + d * x * x))

    def inverse(self, ratio: float) -> float:  # noqa: D102
        q, k, d = ratio, self.stiffness_ratio, self.softening
        # (d - 1 - q d) x^2 + (k - q (k - 2)) x - q = 0: the smaller positive root
        a, b = d - 1.0 - q * d, k - q * (k - 2.0)
        return float(2.0 * q / (b + np.sqrt(b * b + 4.0 * a * q)) * self.peak_slip)


LAWS: dict[str, type[Law]] = {law.name: law for law in (OllgaardLaw, BilinearLaw, RationalLaw)}


def law_kind(name: str) -> type[Law]:
    """The law of this name. Raises `InputError`."""
    Choice(tuple(LAWS)).check("law", name)
    return LAWS[name]


LOSSES = ("linear", "huber", "soft_l1")
LOSS_SCALE = 0.03  # of the largest load: deviations beyond it count less in a robust loss
SCANNED = {0: 1, 1: 200, 2: 20, 3: 12}  # values of each of so many parameters, to find the valleys
VALLEYS = 5  # that are followed down


@dataclass(frozen=True)
class CurveFit:
    """A law fitted to one curve.

    `parameters` by name (SI); `points` fitted; `rms` and `bias` (mean of law less test)
    of the load over the largest load; `at_bound`, names of parameters on a bound;
    `near_interpolation`, fewer than three points more than parameters, so that `rms` says little.
    """

    parameters: dict[str, float]
    points: int
    rms: float
    bias: float
    at_bound: tuple[str, ...]
    near_interpolation: bool


def misfit(law: Law, slip: ArrayLike, ratio: ArrayLike) -> tuple[float, float]:
    """Root mean square and mean of law less test, both as load over the largest load.

    Arguments: slips (n,) in m, readings below zero count as zero; load `ratio` (n,).
    """
    error = law.ratio(np.maximum(np.asarray(slip, float), 0.0)) - np.asarray(ratio, float)
    return float(np.sqrt(np.mean(error**2))), float(np.mean(error))


def fit_curve(
    slip: ArrayLike,
    load: ArrayLike,
    law: str = "ollgaard",
    *,
    loss: str = "linear",
    held: Mapping[str, float] | None = None,
) -> CurveFit:
    """Fit a law to the shape of one curve, load over its largest load, by bounded least squares.

    Arguments: slips (n,) in m and loads (n,) in N; `law`, a name in `LAWS`; `loss` ``linear``,
    ``huber`` or ``soft_l1``; `held`, parameters with given values (SI). Raises `InputError` for
    fewer points than parameters, `SolverError`.
    """
    from scipy.optimize import least_squares

    Choice(LOSSES).check("loss", loss)
    kind, fixed = law_kind(law), dict(held or {})
    for name in fixed:
        Choice(tuple(kind.bounds)).check("held", name)
    bounds = {name: each[:3] for name, each in kind.bounds.items() if name not in fixed}
    names = list(bounds)
    s, q = np.maximum(np.asarray(slip, float), 0.0), np.asarray(load, float)
    least = max(len(bounds), 2)
    if s.shape != q.shape or s.ndim != 1 or len(s) < least:
        raise InputError("curve", s.shape, f"must have {least} points or more for the {law} law")
    top = float(np.max(q))
    if not top > 0.0:
        raise InputError("curve", top, "must hold a positive load")
    y = q / top
    low, high, start = np.log(list(bounds.values())).reshape(-1, 3).T

    def at(theta: Array) -> Law:
        # exponentials of the bounds may leave them by round-off
        values = np.clip(np.exp(theta), np.exp(low), np.exp(high))
        free = dict(zip(names, values.tolist(), strict=True))
        return kind.fitted({**free, **fixed}, float(np.max(s)))

    def error(theta: Array) -> Array:
        return at(theta).ratio(s) - y

    how: dict[str, Any] = {"loss": loss, "f_scale": LOSS_SCALE}
    how |= {"xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
    tried = [
        least_squares(error, begin, bounds=(low, high), **how)
        for begin in (start, *_valleys(error, low, high, loss))
    ]
    solved = [each for each in tried if each.success]
    if not solved:
        raise SolverError("least squares of a load-slip curve", float("nan"), "several starts")
    theta = min(solved, key=lambda each: float(each.cost)).x
    best = at(theta)
    parameters = {name: float(getattr(best, name)) for name in (*names, *fixed)}
    rms, bias = misfit(best, s, y)
    stuck = np.isclose(theta, low, atol=1e-4) | np.isclose(theta, high, atol=1e-4)
    at_bound = tuple(name for name, on in zip(names, stuck, strict=True) if on)
    return CurveFit(parameters, len(s), rms, bias, at_bound, len(s) < len(names) + 3)


def _valleys(error: Callable[[Array], Array], low: Array, high: Array, loss: str) -> list[Array]:
    """Points of a scan between bounds (p,) that no neighbour is better than, the best first."""
    from scipy.ndimage import minimum_filter

    count = SCANNED[len(low)]
    axes = [np.linspace(a, b, count + 2)[1:-1] for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    z = np.array([error(theta) for theta in grid.reshape(-1, len(low))]) ** 2 / LOSS_SCALE**2
    if loss != "linear":
        far = 2.0 * np.sqrt(z) - 1.0
        z = 2.0 * np.sqrt(1.0 + z) - 2.0 if loss == "soft_l1" else np.where(z > 1.0, far, z)
    cost = z.sum(axis=1).reshape(grid.shape[:-1])
    lowest = cost <= minimum_filter(cost, 3, mode="nearest")
    return list(grid[lowest][np.argsort(cost[lowest])][:VALLEYS])


CHORD = (0.1, 0.4)  # of the largest load


def ascending(slip: ArrayLike, load: ArrayLike) -> tuple[Array, Array]:
    """The ascending branch of a measured curve from the origin: slips (n,) m and loads (n,) N.

    The branch starts at the origin, ends at the largest load, and keeps only points that exceed
    all loads before, so that unloading loops and noise below the envelope drop out. Raises
    `InputError` for fewer than two points or no positive load.
    """
    s, q = np.atleast_1d(np.asarray(slip, float)), np.atleast_1d(np.asarray(load, float))
    if s.shape != q.shape or s.ndim != 1 or len(s) < 2 or not np.all(np.isfinite([s, q])):
        raise InputError("curve", (s.shape, q.shape), "must be two or more points (slip, load)")
    order = np.argsort(s, kind="stable")
    s, q = s[order], q[order]
    end = int(np.argmax(q))
    if q[end] <= 0.0:
        raise InputError("curve", float(q[end]), "must hold a positive load")
    s, q = s[: end + 1], q[: end + 1]
    keep = (q > np.concatenate([[0.0], np.maximum.accumulate(q)[:-1]])) & (s >= 0.0)
    return np.concatenate([[0.0], s[keep]]), np.concatenate([[0.0], q[keep]])


def chord_stiffness(slip: ArrayLike, load: ArrayLike) -> float:
    """Chord stiffness of a measured curve in N/m; NaN where both levels are reached at one slip.

    Between points the curve is linear, and a level counts where it is first reached.
    """
    s, q = ascending(slip, load)
    start, end = np.interp(np.array(CHORD) * q[-1], q, s)
    low, high = CHORD
    return float((high - low) * q[-1] / (end - start)) if end > start else float("nan")


def law_stiffness(law: Law, load: float) -> float:
    """Chord stiffness in N/m of a law with the largest `load` in N."""
    low, high = CHORD
    return (high - low) * load / (law.slip_at(high) - law.slip_at(low))


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
