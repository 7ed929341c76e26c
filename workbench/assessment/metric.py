"""What a metric is: a number with a meaning, a range, a perfect value and a source."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array as Array
from workbench.errors import InputError
from workbench.responses import Response

Compute = Callable[[Response, Response, str], float]
# (value, reference, half-widths of both) -> half-width of the metric, None where it has none
Spread = Callable[[float, float, float, float], float | None]


class Scope(StrEnum):
    """What a metric compares."""

    SCALAR = "scalar"
    HISTORY = "history"
    CURVE = "curve"
    RUN = "run"  # nothing: the response alone


class Swap(StrEnum):
    """What happens to a metric when response and reference change places."""

    NOTHING = "nothing in particular"
    SAME = "the same value"
    OPPOSITE = "the opposite value"


@dataclass(frozen=True, slots=True)
class Metric:
    """A comparison of one quantity of a response with that of a reference.

    Arguments: `name`, key in `METRICS`; `title` and `meaning` for the reader; `compute`, the
    function ``(response, reference, quantity) -> float``, which raises `InputError` where the
    metric does not exist (quantity absent, reference zero, no common range); `scope`, what it
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
        """Value of the metric. Raises `InputError` where it does not exist."""
        return self.compute(response, reference, quantity)

    def half_width(
        self, value: float, reference: float, own: float | None, other: float | None
    ) -> float | None:
        """Half-width of a metric of scalars from those of both sides (None: unknown).

        Half-widths of the same coverage combine by the root of their squares (ASME V&V 20; a grid
        convergence index stands for about 95 %). Raises `InputError` for negative ones.
        """
        if any(width is not None and not width >= 0.0 for width in (own, other)):
            raise InputError("uncertainty", (own, other), "must not be negative")
        if self.spread is None or own is None or other is None:
            return None
        return self.spread(value, reference, own, other)


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


def present(response: Response, quantity: str, side: str) -> Array:
    """Values of a quantity; `side` is how the message of the `InputError` for none calls it."""
    if quantity not in response:
        raise InputError(f"{side}.{quantity}", None, f"the {side} does not know this quantity")
    return np.asarray(response[quantity].values, dtype=float)


class Common(NamedTuple):
    """Two records on one base: `at` (n,), time in s or displacement in m, and both values (n,)."""

    at: Array
    values: Array
    reference: Array


def on_common_base(own: tuple[Array, Array], other: tuple[Array, Array], quantity: str) -> Common:
    """Two records, each (places, values), on the union of their places where both are known.

    Between its places a record is linear. Raises `InputError` if the records do not overlap.
    """
    (x1, y1), (x2, y2) = own, other
    start, end = max(x1[0], x2[0]), min(x1[-1], x2[-1])
    if not end > start:
        raise InputError(quantity, (start, end), "the records do not overlap")
    x = np.union1d(x1, x2)
    x = x[(x >= start) & (x <= end)]
    return Common(x, np.interp(x, x1, y1), np.interp(x, x2, y2))
