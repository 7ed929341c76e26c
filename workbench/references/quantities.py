"""What of a response a numerical uncertainty is stated for: scalars, and points of its curve."""

import re
from collections.abc import Sequence

import numpy as np

from workbench.errors import InputError
from workbench.responses import Response
from workbench.responses.variables import SCALARS
from workbench.scenarios import Scenario

IN_TIME = ("peak_displacement", "time_of_peak", "residual_displacement")
SHARES = (0.25, 0.5, 0.75, 1.0)  # of the largest displacement (or load factor) of a static path
_POINT = re.compile(r"(force|load factor|displacement) at (load factor )?(\S+?)( m| rad)?")


def default_quantities(scenario: Scenario, response: Response) -> tuple[str, ...]:
    """Quantities that a response is asked for.

    In time: peak displacement, its time, residual displacement. Static: input energy, resistance
    (of a frame), and forces at quarters of the displacement, or displacements at quarters of the
    load factor where the scenario imposes that.
    """
    if "time" in response.coords:
        return tuple(name for name in IN_TIME if name in response)
    energy = tuple(name for name in ("input_energy", "resistance") if name in response)
    if getattr(scenario, "control", "") == "load":
        top = _largest(response, "load_factor")
        return (*energy, *(f"displacement at load factor {share * top:.12g}" for share in SHARES))
    if "force" not in response:
        return energy
    unit = "rad" if str(getattr(scenario, "direction", "")).endswith("rotation") else "m"
    top = _largest(response, "displacement")
    return (*energy, *(f"force at {share * top:.12g} {unit}" for share in SHARES))


def check_quantities(quantities: Sequence[str]) -> tuple[str, ...]:
    """The quantities, if each is a scalar or a point of a curve. Raises `InputError`."""
    for quantity in quantities:
        if quantity not in SCALARS and _point(quantity) is None:
            allowed = (
                f"must be one of {', '.join(SCALARS)}, or a point of a static curve such as "
                "'force at 0.05 m' or 'displacement at load factor 0.5'"
            )
            raise InputError("quantities", quantity, allowed)
    return tuple(quantities)


def read(response: Response, quantities: Sequence[str]) -> dict[str, float]:
    """Values of scalars and of points of the curve; those that are absent are left out."""
    values = {}
    for quantity in quantities:
        point = _point(quantity)
        if point is None:
            found = float(response[quantity]) if quantity in response else None
        else:
            found = _first_at(response, *point)
        if found is not None:
            values[quantity] = found
    return values


def _point(quantity: str) -> tuple[str, str, float] | None:
    """Variable, abscissa and its value for a text like ``force at 0.05 m``."""
    match = _POINT.fullmatch(quantity)
    try:
        at = float(match[3]) if match else np.nan
    except ValueError:
        return None
    if match is None or not np.isfinite(at) or bool(match[2]) == bool(match[4]):
        return None
    return match[1].replace(" ", "_"), "load_factor" if match[2] else "displacement", at


def _first_at(response: Response, variable: str, abscissa: str, at: float) -> float | None:
    """Value where the abscissa reaches `at` for the first time, linear between the steps."""
    if variable not in response or abscissa not in response or "time" in response.coords:
        return None
    way = response[abscissa].values if at >= 0.0 else -response[abscissa].values
    reached = np.flatnonzero(way >= abs(at) * (1.0 - 1e-9))
    if reached.size == 0:
        return None
    last = int(reached[0])
    first = max(last - 1, 0)
    values = response[variable].values
    return float(np.interp(abs(at), way[[first, last]], values[[first, last]]))


def _largest(response: Response, variable: str) -> float:
    values = response[variable].values
    return float(values[np.argmax(np.abs(values))])
