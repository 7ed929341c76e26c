"""Metrics: each is a number with a meaning, a range, a perfect value and a source.

A metric is computed of what its scope says (`Pair`, `Common`, `Curves`, `Run`); `sides` makes that
of two responses, once for all metrics of a scope.
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

    SCALAR = "scalar"  # `Pair`
    HISTORY = "history"  # `Common`
    CURVE = "curve"  # `Curves`
    RUN = "run"  # `Run`: nothing is compared


class Pair(NamedTuple):
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


class Run(NamedTuple):
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

    Its module is imported in `assessment/__init__`. Metrics of histories and curves then enter
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
) -> Pair | Common | Curves | Run:
    """Input of the metrics of a scope, made of two responses.

    Raises `InputError` if a side does not know the quantity, as a scalar, history or curve, or if
    two histories do not overlap.
    """
    if scope is Scope.RUN:
        return Run(response, quantity)
    given = (response, quantity, "response"), (reference, quantity, "reference")
    if scope is Scope.SCALAR:
        return Pair(_scalar(*given[0]), _scalar(*given[1]), quantity)
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
def difference(pair: Pair) -> float:
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
def relative_error(pair: Pair) -> float:
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
def log_ratio(pair: Pair) -> float:
    """ln(value / reference).

    Symmetric between too high and too low. Raises `InputError` unless both have one sign.
    """
    if pair.value * pair.reference <= 0.0:
        raise InputError(pair.quantity, pair[:2], "must have one sign on both sides")
    return float(np.log(pair.value / pair.reference))


@metric("shortfall", Scope.RUN, "oberkampf-roy2010")
def shortfall(run: Run) -> float:
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
def relative_uncertainty(run: Run) -> float:
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
