"""Metrics: each is a number with a meaning, a range, a perfect value and a source.

A metric is computed of what its scope says (`ResponsePair`, `Common`, `Curves`,
`SingleResponse`); `sides` makes that of two responses, once for all metrics of a scope.

**Second part.** Metrics of two records: histories over time, and curves over displacement.

Between its instants a record is linear. Integrals run over the union of both grids, on which both
are linear from place to place, so that none of them depends on a resampling step.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array as Array
from workbench.base.errors import InputError
from workbench.responses import Response
from workbench.responses.uncertainty import uncertainty_of

Compute = Callable[[Any], float]
# (value, reference, half-widths of both) -> half-width of the metric, None where it has none
Spread = Callable[[float, float, float, float], float | None]


class Scope(StrEnum):
    """Scope of a metric: the part of two responses that it is computed of."""

    SCALAR = "scalar"  # `ResponsePair`
    HISTORY = "history"  # `Common`
    CURVE = "curve"  # `Curves`
    RUN = "run"  # `SingleResponse`: nothing is compared


class ResponsePair(NamedTuple):
    """A scalar `quantity` of both sides, in its unit."""

    value: float
    reference: float
    quantity: str


class Common(NamedTuple):
    """Two records on one base: `at` (n,), time in s or displacement in m, and both values (n,)."""

    at: Array
    values: Array
    reference: Array
    quantity: str


class Curves(NamedTuple):
    """A `quantity` over displacement (m) of both sides, each (displacement, values), both (n,)."""

    response: tuple[Array, Array]
    reference: tuple[Array, Array]
    quantity: str


class SingleResponse(NamedTuple):
    """A response alone."""

    response: Response
    quantity: str


class Swap(StrEnum):
    """Effect on a metric when response and reference change places."""

    NOTHING = "nothing in particular"
    SAME = "the same value"
    OPPOSITE = "the opposite value"


@dataclass(frozen=True, slots=True)
class Metric:
    """A comparison of one quantity of a response with that of a reference.

    Arguments: `name`, key in `METRICS`; `title` and `meaning` for the reader; `compute`, the
    function of what its scope compares, which raises `InputError` where the metric does not exist
    (reference zero, no common range); `scope`, what it
    compares; `citation`, key of the bibliography; `perfect`, its value for equal inputs, nearer
    to which is better; `low` and `high`, its range; `unit_power`, 0 if it is a pure number, 1 if
    it carries the unit of the quantity; `swap`, its symmetry; `spread`, which every
    metric of scalars has: how the uncertainties of both sides become that of the metric. Metrics
    of histories and curves get theirs from the runs behind both sides.
    """

    name: str
    title: str
    meaning: str
    compute: Compute
    scope: Scope
    citation: str
    perfect: float = 0.0
    low: float = -np.inf
    high: float = np.inf
    unit_power: int = 0
    swap: Swap = Swap.NOTHING
    spread: Spread | None = None

    def __post_init__(self) -> None:
        if (self.spread is not None) != (self.scope is Scope.SCALAR):
            raise TypeError(f"metric {self.name}: scalars need a rule for their uncertainty")

    @property
    def signed(self) -> bool:
        """Whether values on both sides of the perfect one occur."""
        return self.low < self.perfect < self.high

    def __call__(self, response: Response, reference: Response, quantity: str) -> float:
        """Value of the metric between two responses. Raises `InputError` where it has none."""
        return self.compute(sides(self.scope, response, reference, quantity))

    def half_width(
        self, value: float, reference: float, width: float | None, reference_width: float | None
    ) -> float | None:
        """Half-width of a metric of scalars from those of both sides (None: unknown).

        Half-widths of the same coverage combine by the root of their squares (ASME V&V 20; a grid
        convergence index stands for about 95 %). Raises `InputError` for negative ones.
        """
        if any(each is not None and not each >= 0.0 for each in (width, reference_width)):
            raise InputError("uncertainty", (width, reference_width), "must not be negative")
        if self.spread is None or width is None or reference_width is None:
            return None
        return self.spread(value, reference, width, reference_width)


METRICS: dict[str, Metric] = {}


def metric(title: str, scope: Scope, citation: str, **more: Any) -> Callable[[Compute], Metric]:
    """Register a metric in `METRICS`, by the name and first sentence of its function.

    Metrics of histories and curves then enter
    every table of comparisons, those of scalars the gates that name them.

    Arguments: those of `Metric`, `more` by name.
    """

    def made(compute: Compute) -> Metric:
        first, _, _ = (compute.__doc__ or "").partition("\n\n")
        meaning = " ".join(first.split()).rstrip(".")
        meaning = meaning[:1].lower() + meaning[1:]
        name = compute.__name__
        METRICS[name] = Metric(name, title, meaning, compute, scope, citation, **more)
        return METRICS[name]

    return made


def sides(
    scope: Scope, response: Response, reference: Response, quantity: str
) -> ResponsePair | Common | Curves | SingleResponse:
    """Input of the metrics of a scope, made of two responses.

    Raises `InputError` if a side does not know the quantity, as a scalar, history or curve, or if
    two histories do not overlap.
    """
    if scope is Scope.RUN:
        return SingleResponse(response, quantity)
    given = (response, quantity, "response"), (reference, quantity, "reference")
    if scope is Scope.SCALAR:
        return ResponsePair(_scalar(*given[0]), _scalar(*given[1]), quantity)
    if scope is Scope.HISTORY:
        return on_common_base(_history(*given[0]), _history(*given[1]), quantity)
    return Curves(_curve(*given[0]), _curve(*given[1]), quantity)


def _present(response: Response, quantity: str, side: str) -> Array:
    if quantity not in response:
        raise InputError(f"{side}.{quantity}", None, f"the {side} does not know this quantity")
    return np.asarray(response.variables[quantity].values, dtype=float)


def _scalar(response: Response, quantity: str, side: str) -> float:
    values = _present(response, quantity, side)
    if values.ndim:
        text, advice = "must be a scalar quantity", "use a history metric"
        raise InputError(quantity, values.shape, text, advice)
    return float(values)


def _history(response: Response, quantity: str, side: str) -> tuple[Array, Array]:
    values, dims = _present(response, quantity, side), response.variables[quantity].dims
    if dims != ("time",):
        text, advice = "must be a history over time alone", "use a scalar or curve metric"
        raise InputError(f"{side}.{quantity}", dims, text, f"choose a hinge first, or {advice}")
    return np.asarray(response.variables["time"].values, dtype=float), values


def _curve(response: Response, quantity: str, side: str) -> tuple[Array, Array]:
    y = _present(response, quantity, side)
    x = _present(response, "displacement", side)
    if y.ndim != 1 or y.shape != x.shape or len(y) < 2:
        text = "must be a curve of 2 points or more over displacement"
        raise InputError(f"{side}.{quantity}", y.shape, text)
    return x, y


def on_common_base(
    response: tuple[Array, Array], reference: tuple[Array, Array], quantity: str
) -> Common:
    """Two records, each (places, values), on the union of their places where both are known.

    Between its places a record is linear. Raises `InputError` if the records do not overlap.
    """
    (x1, y1), (x2, y2) = response, reference
    start, end = max(x1[0], x2[0]), min(x1[-1], x2[-1])
    if not end > start:
        raise InputError(quantity, (start, end), "the records do not overlap")
    x = np.union1d(x1, x2)
    x = x[(x >= start) & (x <= end)]
    return Common(x, np.interp(x, x1, y1), np.interp(x, x2, y2), quantity)


@metric(
    "difference",
    Scope.SCALAR,
    "asme-vv20",
    unit_power=1,
    swap=Swap.OPPOSITE,
    spread=lambda value, reference, width, other: hypot(width, other),
)
def difference(pair: ResponsePair) -> float:
    """Value - reference, in the unit of the quantity.

    E = S - D of ASME V&V 20-2009, eq. 1-5-1.
    """
    return pair.value - pair.reference


@metric(
    "relative error",
    Scope.SCALAR,
    "asme-vv20",
    # a relative change of the reference acts with the weight value/reference
    spread=lambda value, reference, width, other: (
        hypot(width / reference, value / reference * other / reference) if reference else None
    ),
)
def relative_error(pair: ResponsePair) -> float:
    """(value - reference) / reference.

    Positive where the magnitude is too large. Raises `InputError` if the reference is zero.
    """
    if pair.reference == 0.0:
        raise InputError(pair.quantity, 0.0, "of the reference must not be zero", "use difference")
    return (pair.value - pair.reference) / pair.reference


@metric(
    "logarithm of the ratio",
    Scope.SCALAR,
    "fds-validation",
    swap=Swap.OPPOSITE,
    spread=lambda value, reference, width, other: hypot(width / value, other / reference),
)
def log_ratio(pair: ResponsePair) -> float:
    """ln(value / reference).

    Symmetric between too high and too low. Raises `InputError` unless both have one sign.
    """
    if pair.value * pair.reference <= 0.0:
        raise InputError(pair.quantity, pair[:2], "must have one sign on both sides")
    return float(np.log(pair.value / pair.reference))


@metric("shortfall", Scope.RUN, "oberkampf-roy2010")
def shortfall(run: SingleResponse) -> float:
    """1 - value, of a number about the run such as the yield ratio.

    A scalar, or an attribute of the response. Raises `InputError` if it carries neither.
    """
    response, quantity = run
    if quantity in response and not response[quantity].ndim:
        return 1.0 - float(response[quantity])
    if not isinstance(response.attrs.get(quantity), (int, float)):
        raise InputError(f"response.{quantity}", None, "the response does not know this quantity")
    return 1.0 - float(response.attrs[quantity])


@metric("numerical uncertainty", Scope.RUN, "roache1994", low=0.0)
def relative_uncertainty(run: SingleResponse) -> float:
    """Half-width of the numerical uncertainty / |value|.

    Raises `InputError` if it is unknown, or if the scalar is absent or zero.
    """
    response, quantity = run
    if quantity not in response or response[quantity].ndim:
        raise InputError(f"response.{quantity}", None, "the response does not know this quantity")
    width, value = uncertainty_of(response, quantity), abs(float(response[quantity]))
    if width is None or value == 0.0:
        text = "has no numerical uncertainty" if width is None else "is zero"
        raise InputError(f"response.{quantity}", value, text, "see its attribute refinement")
    return width / value


_SAMPLES = 400  # points along each curve; the distance changes by less than 1e-3 of itself beyond


def product_integral(time: Array, first: Array, second: Array) -> float:
    """Integral of the product of two piecewise linear functions (exact, by Simpson's rule)."""
    a, b, step = first, second, np.diff(time)
    ends = 2.0 * (a[:-1] * b[:-1] + a[1:] * b[1:])
    return float(np.sum(step * (ends + a[:-1] * b[1:] + a[1:] * b[:-1])) / 6.0)


def _energies(common: Common) -> tuple[float, float, float]:
    """Integrals of the squares of both histories and of their product, over equal factors."""
    time, values, reference, quantity = common
    # scaled, so that squares neither overflow nor vanish
    top, top_reference = float(np.max(np.abs(values))), float(np.max(np.abs(reference)))
    if top == 0.0 or top_reference == 0.0:
        raise InputError(quantity, 0.0, "is zero throughout the overlap", "use difference")
    a, b = values / top, reference / top_reference
    return (
        product_integral(time, a, a) * (top / top_reference) ** 2,
        product_integral(time, b, b),
        product_integral(time, a, b) * (top / top_reference),
    )


def _magnitude(square: float, reference_square: float) -> float:
    return float(np.sqrt(square / reference_square) - 1.0)


def _phase(square: float, reference_square: float, product: float) -> float:
    cosine = product / np.sqrt(square * reference_square)
    if cosine > 1.0 - 1e-14:  # equal histories: acos would blow rounding up to 1e-8
        return 0.0
    return float(np.arccos(max(cosine, -1.0)) / np.pi)


@metric("Sprague-Geers M", Scope.HISTORY, "sprague-geers", low=-1.0)
def sprague_geers_magnitude(common: Common) -> float:
    """Ratio of root-mean-square levels less one; blind to phase.

    M = sqrt(Scc/Stt) - 1. Raises `InputError` if one history is zero throughout.
    """
    return _magnitude(*_energies(common)[:2])


@metric("Sprague-Geers P", Scope.HISTORY, "sprague-geers", low=0.0, high=1.0, swap=Swap.SAME)
def sprague_geers_phase(common: Common) -> float:
    """Angle between both histories over pi; blind to magnitude.

    P = acos(Sct / sqrt(Scc Stt)) / pi. Raises `InputError` as the magnitude does.
    """
    return _phase(*_energies(common))


@metric("Sprague-Geers C", Scope.HISTORY, "sprague-geers", low=0.0)
def sprague_geers_comprehensive(common: Common) -> float:
    """Root of M squared plus P squared.

    Raises `InputError` as the magnitude does.
    """
    energies = _energies(common)
    return float(np.hypot(_magnitude(*energies[:2]), _phase(*energies)))


def _residuals(common: Common) -> tuple[Array, Array]:
    time, values, reference, quantity = common
    top = float(np.max(np.abs(reference)))
    if top == 0.0:
        raise InputError(quantity, 0.0, "of the reference is zero throughout the overlap")
    return time, (values - reference) / top


@metric("mean residual", Scope.HISTORY, "nchrp179")
def residual_mean(common: Common) -> float:
    """Mean difference over time, over the peak of the reference."""
    time, residual = _residuals(common)
    return float(np.trapezoid(residual, time) / (time[-1] - time[0]))


@metric("standard deviation of the residual", Scope.HISTORY, "nchrp179", low=0.0)
def residual_deviation(common: Common) -> float:
    """Standard deviation of the difference over time, over the peak of the reference."""
    time, residual = _residuals(common)
    span = time[-1] - time[0]
    centred = residual - np.trapezoid(residual, time) / span
    return float(np.sqrt(product_integral(time, centred, centred) / span))


def common_range(curves: Curves) -> Common:
    """Both curves on the union of their displacements, over the range that both cover.

    Raises `InputError` if a curve's displacement does not increase or the ranges do not meet.
    """
    for side in ("response", "reference"):
        x, _ = getattr(curves, side)
        if np.any(np.diff(x) <= 0.0):
            advice = "use arc_length_distance"
            raise InputError(f"{side}.displacement", x.shape, "must increase", advice)
    return on_common_base(*curves)


def absolute_area(x: Array, y: Array) -> float:
    """Integral of |y| of a piecewise linear y(x), exact where it crosses zero."""
    a, b = np.abs(y[:-1]), np.abs(y[1:])
    crossing = y[:-1] * y[1:] < 0.0
    total = np.where(a + b > 0.0, a + b, 1.0)
    area = np.where(crossing, (a * a + b * b) / (2.0 * total), 0.5 * (a + b))
    return float(np.sum(np.diff(x) * area))


@metric("area between the curves", Scope.CURVE, "jekel2019", low=0.0)
def area_difference(curves: Curves) -> float:
    """Area between both curves over the area under the reference.

    Raises `InputError` as `common_range` does, and if the reference is zero throughout.
    """
    common = common_range(curves)
    return absolute_area(common.at, common.values - common.reference) / _area(common)


@metric("difference of work", Scope.CURVE, "jekel2019")
def work_difference(curves: Curves) -> float:
    """Signed area between both curves over the area under the reference.

    The work too much. Raises `InputError` as `area_difference` does.
    """
    common = common_range(curves)
    return float(np.trapezoid(common.values - common.reference, common.at)) / _area(common)


def _area(common: Common) -> float:
    """Area under the reference."""
    area = absolute_area(common.at, common.reference)
    if area == 0.0:
        raise InputError(common.quantity, 0.0, "of the reference is zero over the common range")
    return area


@metric("distance along the curves", Scope.CURVE, "witowski2012", low=0.0)
def arc_length_distance(curves: Curves) -> float:
    """Distance of points at equal shares of arc length, axes scaled by the reference.

    Root of the mean square; curves may turn back (unloading). Both end where the shorter one
    reaches its largest displacement. Raises `InputError` if the reference has no extent along an
    axis.
    """
    (x1, y1), (x2, y2), quantity = curves
    end = min(x1.max(), x2.max())
    x1, y1 = _until(x1, y1, end)
    x2, y2 = _until(x2, y2, end)
    wide, high = np.ptp(x2), np.ptp(y2)
    if wide == 0.0 or high == 0.0:
        raise InputError(f"reference.{quantity}", (wide, high), "must have an extent on both axes")
    first = _resampled(x1 / wide, y1 / high)
    second = _resampled(x2 / wide, y2 / high)
    return float(np.sqrt(np.mean(np.sum((first - second) ** 2, axis=0))))


def _until(x: Array, y: Array, end: float) -> tuple[Array, Array]:
    beyond = np.flatnonzero(x > end)
    if len(beyond) == 0 or beyond[0] == 0:
        return x, y
    i = int(beyond[0])
    share = (end - x[i - 1]) / (x[i] - x[i - 1])
    last = y[i - 1] + share * (y[i] - y[i - 1])
    return np.append(x[:i], end), np.append(y[:i], last)


def _resampled(x: Array, y: Array) -> Array:
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    at = np.linspace(0.0, length[-1], _SAMPLES)
    return np.stack([np.interp(at, length, x), np.interp(at, length, y)])
