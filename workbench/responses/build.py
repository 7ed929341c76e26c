"""Building, checking and reducing responses (`xarray.Dataset` with the standard variables)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from workbench.errors import WorkbenchError
from workbench.responses.outcome import Finding, Outcome
from workbench.responses.variables import COORDINATES, HISTORY, SCALARS, VARIABLES

Response = xr.Dataset
FORCE_WINDOW = 1e-3  # s; contact forces of nonsmooth models are means over this window


def build_response(
    values: Mapping[str, ArrayLike | None],
    *,
    time: ArrayLike | None = None,
    steps: int | None = None,
    hinges: Sequence[str] = (),
    segments: Sequence[str] = (),
    members: Sequence[str] = (),
    warnings: Sequence[Finding] = (),
) -> Response:
    """Make a response from plain arrays, with dimensions, units and names from the table.

    Arguments: `values`, variable name to array in the order of its dimensions (entries that
    are None are left out: a quantity that a model cannot know is absent); `time` in s for
    histories in time, or `steps`, the number of load steps; names of `hinges`, `segments` and
    `members`; `warnings` met while solving. Points along members are evenly spaced, snapshots
    numbered. Raises KeyError for a variable that is not in the table.
    """
    history = "time" if time is not None else "step"
    along: dict[str, Any] = {
        "hinge": list(hinges) or None,
        "segment": list(segments) or None,
        "member": list(members) or None,
    }
    if time is not None:
        along["time"] = np.asarray(time, dtype=float)
    elif steps is not None:
        along["step"] = np.arange(steps)
    data = {}
    for name, value in values.items():
        if value is None:
            continue
        variable = VARIABLES[name]
        dims = tuple(history if dim == HISTORY else dim for dim in variable.dims)
        attributes = {"units": variable.units, "long_name": variable.long_name}
        data[name] = xr.Variable(dims, np.asarray(value, dtype=float), attributes)
    sizes = {
        dim: size
        for variable in data.values()
        for dim, size in zip(variable.dims, variable.shape, strict=True)
    }
    if "point" in sizes:
        along["point"] = np.linspace(0.0, 1.0, sizes["point"])
    if "snapshot" in sizes:
        along["snapshot"] = np.arange(sizes["snapshot"])
    coordinates = {
        name: (name, along[name], {"units": meaning.units, "long_name": meaning.long_name})
        for name, meaning in COORDINATES.items()
        if along.get(name) is not None
    }
    response = xr.Dataset(data, coordinates)
    response.attrs["outcome"] = Outcome.OK.value
    response.attrs["message"] = ""
    response.attrs["warnings"] = json.dumps([[f.subject, f.text] for f in warnings])
    return response


def failed_response(outcome: Outcome, message: str) -> Response:
    """A response without variables that says how the attempt ended and what to do."""
    response = xr.Dataset()
    response.attrs["outcome"] = outcome.value
    response.attrs["message"] = f"{message}. {outcome.advice}" if message else outcome.advice
    response.attrs["warnings"] = "[]"
    return response


def outcome_of(response: Response) -> Outcome:
    """How the attempt ended."""
    return Outcome(response.attrs["outcome"])


def warnings_of(response: Response) -> list[Finding]:
    """The warnings that a response carries."""
    return [Finding(subject, text) for subject, text in json.loads(response.attrs["warnings"])]


def add_warnings(response: Response, findings: Sequence[Finding]) -> None:
    """Put further warnings in front of those that a response carries."""
    pairs = [[f.subject, f.text] for f in findings] + json.loads(response.attrs["warnings"])
    response.attrs["warnings"] = json.dumps(pairs)


def check_response(response: Response) -> None:
    """Hold a response to the contract: known names, units, shapes, finite numbers.

    Raises `WorkbenchError` naming the variable.
    """
    for name, array in response.variables.items():  # plain variables: no index is built
        if name in response.coords:
            continue
        if name not in VARIABLES:
            raise WorkbenchError(f"response variable {name!r} is not a standard one")
        if not {"units", "long_name"} <= set(array.attrs):
            raise WorkbenchError(f"response variable {name!r} lacks units or long_name")
        if not np.isfinite(array.values).all():
            raise WorkbenchError(f"response variable {name!r} holds numbers that are not finite")
    if "time" in response.coords and np.any(np.diff(response["time"].values) <= 0.0):
        raise WorkbenchError("response time does not increase")


def peak_of(time: NDArray[np.float64], displacement: NDArray[np.float64]) -> dict[str, float]:
    """Peak and its time from a history by the parabola through its three highest points.

    Empty if the displacement still grows at the end of the record: then there is no peak.
    """
    top = int(np.argmax(displacement))
    if top == len(displacement) - 1:
        return {}
    if top == 0:
        return {"peak_displacement": float(displacement[0]), "time_of_peak": float(time[0])}
    before, after = float(time[top - 1] - time[top]), float(time[top + 1] - time[top])
    fall_before = float(displacement[top - 1] - displacement[top]) / before
    fall_after = float(displacement[top + 1] - displacement[top]) / after
    curvature = (fall_after - fall_before) / (after - before)
    slope = fall_after - curvature * after
    shift = 0.0 if curvature >= 0.0 else min(max(-0.5 * slope / curvature, before), after)
    return {
        "peak_displacement": float(displacement[top]) + (slope + curvature * shift) * shift,
        "time_of_peak": float(time[top]) + shift,
    }


def residual_of(time: NDArray[np.float64], displacement: NDArray[np.float64]) -> float | None:
    """Permanent displacement: mean over the whole cycles of free vibration after the peak.

    A cycle runs between two upward crossings of the mid-level of the record after its first
    minimum behind the peak. None if the record holds no whole cycle: run longer.
    """
    top = int(np.argmax(displacement))
    after = displacement[top:]
    rising = np.flatnonzero(np.diff(after) > 0.0)
    if len(rising) == 0:
        return None
    start = top + int(rising[0])
    t, d = time[start:], displacement[start:]
    level = 0.5 * (d.max() + d.min())
    crossings = np.flatnonzero((d[:-1] < level) & (d[1:] >= level))
    if len(crossings) < 2:
        return None
    whole = slice(int(crossings[0]), int(crossings[-1]) + 1)
    span = t[whole][-1] - t[whole][0]
    return float(np.trapezoid(d[whole], t[whole]) / span)


def peak_contact_force(time: NDArray[np.float64], percussion: NDArray[np.float64]) -> float:
    """Largest contact force in N: percussions summed over a sliding window of 1 ms.

    Arguments: `time` at the end of each step, and the `percussion` of that step in N s.
    """
    impulse = np.concatenate([[0.0], np.cumsum(percussion)])
    first = 2.0 * time[0] - time[1] if len(time) > 1 else time[0] - FORCE_WINDOW
    at = np.concatenate([[first], time])
    # the impulse rises linearly within a step: the best window starts or ends on a step
    ending = impulse - np.interp(at - FORCE_WINDOW, at, impulse)
    starting = np.interp(at + FORCE_WINDOW, at, impulse) - impulse
    return float(max(ending.max(), starting.max()) / FORCE_WINDOW)


def scalars_of(response: Response) -> dict[str, float]:
    """The scalar quantities that a response has."""
    return {name: float(response[name]) for name in SCALARS if name in response}
