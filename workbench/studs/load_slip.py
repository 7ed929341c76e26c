"""Load-slip laws of a stud under first loading, their fit to one measured curve, stiffness.

A law gives the load over its largest value, q = Q / Q_max, as a function of the slip (`ratio`), and
the slip of its ascending branch at a load (`slip_at`). All that is to be known of a law stands in
its class; a new law is one more class and its place in `LAWS`. Stiffness is that of the chord from
10 to 40 % of the largest load (EN 1994-1-1 and AISC 360 speak of stiffness at such levels). In SI.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.errors import InputError, OutOfDomainError, SolverError
from workbench.base.fields import Choice, Declared, Number, checked
from workbench.studs.quantities import Array


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
