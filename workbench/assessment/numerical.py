"""Comparison errors with their intervals; the refinement ladder, from the floor of responses."""

from dataclasses import dataclass
from math import hypot

from workbench.errors import InputError
from workbench.responses.convergence import Ladder, ladder

__all__ = ["ErrorInterval", "Ladder", "expand", "ladder"]


@dataclass(frozen=True, slots=True)
class ErrorInterval:
    """A comparison error with its uncertainty (ASME V&V 20).

    `error` = S - D and `uncertainty` (None: unknown) in the unit of the quantity; `relative`
    and `relative_uncertainty` are the same of S/D - 1 (None if D is zero).
    """

    error: float
    uncertainty: float | None
    relative: float | None
    relative_uncertainty: float | None

    @property
    def resolved(self) -> bool:
        """Whether the error is larger than its uncertainty, so that it says something."""
        return self.uncertainty is not None and abs(self.error) > self.uncertainty


def expand(
    simulation: float,
    data: float,
    *,
    simulation_uncertainty: float | None = 0.0,
    input_uncertainty: float | None = 0.0,
    data_uncertainty: float | None = 0.0,
) -> ErrorInterval:
    """Comparison error E = S - D with the interval that its ingredients leave (ASME V&V 20).

    Arguments, all in the unit of the quantity: `simulation` S and `data` D (a test, a published
    number or a reference solution); `simulation_uncertainty`, numerical, of S;
    `input_uncertainty`, of S from uncertain inputs; `data_uncertainty`, of D. All three must be
    expanded to the same coverage (a grid convergence index stands for about 95 %); they combine
    by the root of their squares, u_val^2 = u_num^2 + u_input^2 + u_D^2. None means unknown and
    makes the result's uncertainty unknown. Raises `InputError` for negative uncertainties.
    """
    parts = (simulation_uncertainty, input_uncertainty, data_uncertainty)
    if any(part is not None and not part >= 0.0 for part in parts):
        raise InputError("uncertainty", parts, "must not be negative")
    error = simulation - data
    unknown = any(part is None for part in parts)
    own = None if unknown else hypot(simulation_uncertainty or 0.0, input_uncertainty or 0.0)
    total = None if own is None else hypot(own, data_uncertainty or 0.0)
    if data == 0.0:
        return ErrorInterval(error, total, None, None)
    relative = error / abs(data)
    # S/D: a relative change of D acts with the weight S/D
    spread = (
        None
        if own is None
        else hypot(own / data, simulation / data * (data_uncertainty or 0.0) / data)
    )
    return ErrorInterval(error, total, relative, spread)
