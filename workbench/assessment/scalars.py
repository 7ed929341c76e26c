"""Metrics of scalar quantities, and of a response alone: how far the run can be relied on."""

from math import hypot

import numpy as np

from workbench.assessment.metric import Pair, Run, Scope, Swap, metric
from workbench.errors import InputError
from workbench.responses.uncertainty import uncertainty_of


@metric(
    "difference",
    Scope.SCALAR,
    "asme-vv20",
    unit_power=1,
    swap=Swap.OPPOSITE,
    spread=lambda value, reference, own, other: hypot(own, other),
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
    spread=lambda value, reference, own, other: (
        hypot(own / reference, value / reference * other / reference) if reference else None
    ),
)
def relative_error(pair: Pair) -> float:
    """(value - reference) / |reference|.

    Raises `InputError` if the reference is zero.
    """
    if pair.reference == 0.0:
        raise InputError(pair.quantity, 0.0, "of the reference must not be zero", "use difference")
    return (pair.value - pair.reference) / abs(pair.reference)


@metric(
    "logarithm of the ratio",
    Scope.SCALAR,
    "fds-validation",
    swap=Swap.OPPOSITE,
    spread=lambda value, reference, own, other: hypot(own / value, other / reference),
)
def log_ratio(pair: Pair) -> float:
    """ln(value / reference).

    Symmetric between too high and too low. Raises `InputError` unless both are positive.
    """
    if pair.value <= 0.0 or pair.reference <= 0.0:
        raise InputError(pair.quantity, pair[:2], "must be positive on both sides")
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
        said = "has no numerical uncertainty" if width is None else "is zero"
        raise InputError(f"response.{quantity}", value, said, "see its attribute refinement")
    return width / value
