"""Metrics of a response alone: how far the run itself can be relied on."""

from __future__ import annotations

from workbench.assessment.metric import Metric, Scope
from workbench.errors import InputError
from workbench.responses import Response
from workbench.responses.uncertainty import uncertainty_of


def shortfall(response: Response, _: Response, quantity: str) -> float:
    """One less a scalar, or a number about the run that the response carries as attribute.

    Raises `InputError` if it carries neither.
    """
    if quantity in response and not response[quantity].ndim:
        return 1.0 - float(response[quantity])
    if not isinstance(response.attrs.get(quantity), (int, float)):
        raise InputError(f"response.{quantity}", None, "the response does not know this quantity")
    return 1.0 - float(response.attrs[quantity])


def relative_uncertainty(response: Response, _: Response, quantity: str) -> float:
    """Numerical uncertainty of a scalar over its magnitude.

    Raises `InputError` if it is unknown, or if the scalar is absent or zero.
    """
    if quantity not in response or response[quantity].ndim:
        raise InputError(f"response.{quantity}", None, "the response does not know this quantity")
    width, value = uncertainty_of(response, quantity), abs(float(response[quantity]))
    if width is None or value == 0.0:
        said = "has no numerical uncertainty" if width is None else "is zero"
        raise InputError(f"response.{quantity}", value, said, "see its attribute refinement")
    return width / value


RUN_METRICS = (
    Metric(
        "shortfall",
        "shortfall",
        "1 - value, of a number about the run such as the yield ratio",
        Scope.RUN,
        "oberkampf-roy2010",
        shortfall,
    ),
    Metric(
        "relative_uncertainty",
        "numerical uncertainty",
        "half-width of the numerical uncertainty / |value|",
        Scope.RUN,
        "roache1994",
        relative_uncertainty,
        low=0.0,
    ),
)
