"""Numerical uncertainty of a response from the coarser and finer runs that stand behind it.

A reference answers with its finest mesh and carries what its other runs said: their scalars and
their main curve, and the directions in which they differ. Whatever is derived from the response,
a scalar or a metric of a history, gets its half-width from the same rule over the same runs.
`check_stored` says whether a stored response is what its readers take it for.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import WorkbenchError
from workbench.responses.build import (
    Response,
    attribute,
    check_response,
    collapse_of,
    findings_of,
)
from workbench.responses.convergence import SAFE, Ladder, ladder
from workbench.responses.histories import COORDINATES, VARIABLES

FINEST = "h"  # the run that is the answer
FIBERS, STEPS = "fibers", "steps"
SPACE, SPACE_AND_STEPS = "space", "space and steps"
CURVES = {"displacement": "run_displacement", "force": "run_force"}
# attributes of a response: half-widths by quantity computed, of data, samples, open inputs
WIDTHS, DATA_WIDTHS = "numerical_uncertainty", "data_uncertainty"
SAMPLE_WIDTHS, INPUT_WIDTHS = "sampling_uncertainty", "input_uncertainty"
BASIS = "refinement"  # attribute: runs behind the numerical uncertainty, and what they said
SAMPLED = "sampling_interval"  # attribute: ends of intervals over tests by quantity


def sampled_interval(response: Response, quantity: str) -> tuple[float, float] | None:
    """The interval of a scalar over the tests behind it, which may be skewed; None without one."""
    ends = attribute(response, SAMPLED).get(quantity)
    return None if ends is None else (ends[0], ends[1])


def level_names(levels: int) -> tuple[str, ...]:
    """Names of so many meshes from coarse to fine: ``4 h``, ``2 h``, ``h``."""
    return tuple(f"{2**k} h" if k else FINEST for k in reversed(range(levels)))


@dataclass(frozen=True, slots=True)
class Direction:
    """One kind of step, and the runs that differ in it alone, from coarse to fine.

    `factor` times the difference of two runs is the half-width that this direction leaves in the
    answer (None: the runs are a ladder that ends with the answer).
    """

    name: str
    runs: tuple[str, ...]
    factor: float | None = None


@dataclass(frozen=True, slots=True)
class NumericalEstimate:
    """Estimate by several runs of the numerical uncertainty of one number of the answer.

    `width`, the half-width (None: unknown) in the unit of the number; `parts`, that of each
    direction; `ladder`, that of the meshes (None: a value is missing); `note`, one sentence.
    """

    width: float | None
    parts: Mapping[str, float | None]
    ladder: Ladder | None
    note: str


def estimate(directions: Sequence[Direction], values: Mapping[str, float]) -> NumericalEstimate:
    """Half-width of a number from its `values` by run; a run without a value leaves it unknown."""
    parts: dict[str, float | None] = {}
    levels, missing = None, []
    for direction in directions:
        known = [values[run] for run in direction.runs if run in values]
        if len(known) < len(direction.runs):
            missing += [run for run in direction.runs if run not in values]
            parts[direction.name] = None
        elif direction.factor is None:
            levels = ladder(known)
            parts[direction.name] = levels.uncertainty
        else:
            parts[direction.name] = direction.factor * abs(known[1] - known[0])
    if missing:
        note = f"no value of {', '.join(dict.fromkeys(missing))}: unknown"
    else:
        note = levels.note if levels is not None else "one mesh only: unknown"
    return NumericalEstimate(combined(parts), parts, levels, note)


def combined(parts: Mapping[str, float | None]) -> float | None:
    """Half-width from those of the directions; None (unknown) in any of them, or none at all.

    Discretisation errors are not random and may have one sign, so that they add up (ASME V&V 20
    adds them likewise). Where steps are refined with space they count alone only if that says
    more than both together, as errors of space and time may cancel.
    """
    if not parts or any(width is None for width in parts.values()):
        return None
    known = {name: width or 0.0 for name, width in parts.items()}
    if SPACE_AND_STEPS in known:
        known[SPACE_AND_STEPS] = max(known[SPACE_AND_STEPS], known.pop(STEPS, 0.0))
    return sum(known.values())


def fiber_direction(coarsest: str, other: str, ratio: float) -> Direction:
    """Layers of the section, `ratio` times as many in `other` as in the answer.

    Convergence is of second order, but not smooth; even at first order the limit is ratio over
    (ratio - 1) changes away. With fewer layers (ratio below one) it is the finer of the two.
    """
    if ratio > 1.0:
        return Direction(FIBERS, (coarsest, other), SAFE * ratio / (ratio - 1.0))
    return Direction(FIBERS, (other, coarsest), SAFE * ratio / (1.0 - ratio))


def step_direction(coarsest: str, halved: str, coarsening: float, cautious: float) -> Direction:
    """Steps alone: half as long in `halved`, at first order.

    The steps of the coarsest run are `coarsening` times those of the answer; `cautious`, the
    safety factor of two levels.
    """
    return Direction(STEPS, (coarsest, halved), cautious * 2.0 / coarsening)


def attach_curves(response: Response, runs: Mapping[str, Response]) -> None:
    """Keep the main curve of every other run, on the abscissa of the answer.

    Histories in time stand over its instants; static curves over the displacement travelled so
    far, which grows on cyclic and unloading paths too.
    """
    if not runs or "displacement" not in response:
        return
    history = response["displacement"].dims[0]
    names = list(runs)
    response.coords["run"] = ("run", names, COORDINATES["run"].attributes)
    at = _abscissa(response)
    for name, kept in CURVES.items():
        if name not in response:
            continue
        table = np.stack([np.interp(at, _abscissa(run), run[name].values) for run in runs.values()])
        response[kept] = (("run", history), table, VARIABLES[kept].attributes)


def variants(response: Response) -> Iterator[tuple[str, Response]]:
    """The answer with the main curve of each of its runs in turn, itself last."""
    for name in [] if "run" not in response.coords else response["run"].values:
        curves = {}
        for variable, kept in CURVES.items():
            if kept in response:
                curve = response[variable]
                curves[variable] = (curve.dims, response[kept].sel(run=name).values, curve.attrs)
        yield str(name), response.assign(curves)
    yield FINEST, response


def directions_of(response: Response) -> tuple[Direction, ...]:
    """The directions of the runs that stand behind a response (empty: one mesh only)."""
    directions = attribute(response, BASIS).get("directions", ())
    return tuple(Direction(d["name"], tuple(d["runs"]), d["factor"]) for d in directions)


def uncertainty_of(response: Response, quantity: str, kind: str = WIDTHS) -> float | None:
    """Half-width of a scalar of a response, None if it is unknown or was never asked for.

    `kind`, the attribute that holds it: numerical by default, of data or of samples.
    """
    width = attribute(response, kind).get(quantity)
    return None if width is None else float(width)


def _abscissa(response: Response) -> Array:
    displacement = response["displacement"]
    if displacement.dims == ("time",):
        return np.asarray(response["time"].values, dtype=float)
    travelled = np.cumsum(np.abs(np.diff(displacement.values)))
    return np.concatenate([[0.0], travelled])


_WIDTHS = (WIDTHS, DATA_WIDTHS, SAMPLE_WIDTHS, INPUT_WIDTHS)
_TABLES = (*_WIDTHS, SAMPLED, BASIS, "data", "answer")
_LADDER = ("order", "extrapolated", "uncertainty")


def check_stored(response: Response) -> None:
    """Hold a response to the contract, and its attributes to what is read of them.

    Raises `WorkbenchError`, or what reading others raises: ValueError, KeyError, TypeError,
    AttributeError.
    """
    check_response(response)
    attributes = response.attrs
    texts: list[Any] = [attributes["message"], attributes["scenario"]]
    numbers: list[Any] = []
    for finding in findings_of(response):
        texts += (finding.subject, finding.text, finding.remedy)
        numbers += (finding.number, finding.limit)
    collapse = collapse_of(response)
    if collapse is not None:
        texts += collapse.parts
        numbers += (collapse.displacement, collapse.time)
    tables = {name: attribute(response, name) for name in _TABLES if name in attributes}
    for name in _WIDTHS:
        numbers += tables.get(name, {}).values()
    for low, high in tables.get(SAMPLED, {}).values():
        numbers += (low, high)
    if BASIS in tables:
        basis = tables[BASIS]
        texts += basis["statements"]
        numbers += basis["levels"]
        for direction in directions_of(response):
            texts += (direction.name, *direction.runs)
            numbers.append(direction.factor)
        for table in basis["quantities"].values():
            texts.append(table["note"])
            numbers += (*table["values"].values(), *map(table.get, _LADDER))
    good = all(isinstance(text, str) for text in texts)
    good &= all(isinstance(table, dict) for table in tables.values())
    if not (good and all(number is None or isfinite(number) for number in numbers)):
        raise WorkbenchError("an attribute of the response is not what is read of it")
