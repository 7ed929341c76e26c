"""Metrics of scalar quantities."""

from __future__ import annotations

import numpy as np

from workbench.assessment.metric import Metric, Scope, Swap, present
from workbench.errors import InputError
from workbench.responses import Response


def _pair(response: Response, reference: Response, quantity: str) -> tuple[float, float]:
    values = []
    for side, given in (("response", response), ("reference", reference)):
        array = present(given, quantity, side)
        if array.ndim:
            raise InputError(
                quantity, array.shape, "must be a scalar quantity", "use a history metric"
            )
        values.append(float(array))
    return values[0], values[1]


def difference(response: Response, reference: Response, quantity: str) -> float:
    """Comparison error E = S - D in the unit of the quantity (ASME V&V 20-2009, eq. 1-5-1)."""
    value, held_against = _pair(response, reference, quantity)
    return value - held_against


def relative_error(response: Response, reference: Response, quantity: str) -> float:
    """Comparison error over the magnitude of the reference, (S - D)/|D|.

    Raises `InputError` if the reference is zero.
    """
    value, held_against = _pair(response, reference, quantity)
    if held_against == 0.0:
        raise InputError(quantity, 0.0, "of the reference must not be zero", "use difference")
    return (value - held_against) / abs(held_against)


def log_ratio(response: Response, reference: Response, quantity: str) -> float:
    """Natural logarithm of response over reference, symmetric between too high and too low.

    Raises `InputError` unless both are positive.
    """
    value, held_against = _pair(response, reference, quantity)
    if value <= 0.0 or held_against <= 0.0:
        raise InputError(quantity, (value, held_against), "must be positive on both sides")
    return float(np.log(value / held_against))


SCALAR_METRICS = (
    Metric(
        "relative_error",
        "relative error",
        "(value - reference) / |reference|",
        Scope.SCALAR,
        "asme-vv20",
        relative_error,
        spread=lambda interval, ratio: interval.relative_uncertainty,
    ),
    Metric(
        "difference",
        "difference",
        "value - reference, in the unit of the quantity",
        Scope.SCALAR,
        "asme-vv20",
        difference,
        unit_power=1,
        swap=Swap.OPPOSITE,
        spread=lambda interval, ratio: interval.uncertainty,
    ),
    Metric(
        "log_ratio",
        "logarithm of the ratio",
        "ln(value / reference)",
        Scope.SCALAR,
        "fds-validation",
        log_ratio,
        swap=Swap.OPPOSITE,
        spread=lambda interval, ratio: (interval.relative_uncertainty or 0.0) / ratio,
    ),
)
