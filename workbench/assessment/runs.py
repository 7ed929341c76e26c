"""Metrics of a response alone: how far the run itself can be relied on."""

from workbench.assessment.metric import Scope, metric
from workbench.errors import InputError
from workbench.responses import Response
from workbench.responses.uncertainty import uncertainty_of


@metric("shortfall", Scope.RUN, "oberkampf-roy2010")
def shortfall(response: Response, _: Response, quantity: str) -> float:
    """1 - value, of a number about the run such as the yield ratio.

    A scalar, or an attribute of the response. Raises `InputError` if it carries neither.
    """
    if quantity in response and not response[quantity].ndim:
        return 1.0 - float(response[quantity])
    if not isinstance(response.attrs.get(quantity), (int, float)):
        raise InputError(f"response.{quantity}", None, "the response does not know this quantity")
    return 1.0 - float(response.attrs[quantity])


@metric("numerical uncertainty", Scope.RUN, "roache1994", low=0.0)
def relative_uncertainty(response: Response, _: Response, quantity: str) -> float:
    """Half-width of the numerical uncertainty / |value|.

    Raises `InputError` if it is unknown, or if the scalar is absent or zero.
    """
    if quantity not in response or response[quantity].ndim:
        raise InputError(f"response.{quantity}", None, "the response does not know this quantity")
    width, value = uncertainty_of(response, quantity), abs(float(response[quantity]))
    if width is None or value == 0.0:
        said = "has no numerical uncertainty" if width is None else "is zero"
        raise InputError(f"response.{quantity}", value, said, "see its attribute refinement")
    return width / value


RUN_METRICS = (shortfall, relative_uncertainty)
