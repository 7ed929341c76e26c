"""The pressure-impulse curve of a structure: the pulses that take it to one displacement."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

from workbench.models.base import Model, on_one_mesh
from workbench.responses import Outcome, outcome_of
from workbench.scenarios.column import DURATION

_GROWTH = 4.0  # of the peak, until it is between two values
_MOST = 16  # such steps
_TOLERANCE = 0.003  # of the peak


@dataclass(frozen=True)
class Point:
    """A pulse that takes the structure to the displacement.

    Its `length` in s, `peak` in N or N/m and `impulse` in N s or N s/m; None, with the `reason`, if
    there is none.
    """

    length: float
    peak: float | None
    impulse: float | None
    reason: str = ""


def pressure_impulse_curve(
    model: Model, scenario: Any, displacement: float, lengths: Sequence[float]
) -> list[Point]:
    """Pulses of these lengths (s) and the shape of the scenario that reach a displacement (m).

    Peaks are bracketed to 0.3 %, a reference on one mesh. A collapse has gone further. Records last
    that of the scenario beyond the pulse.
    """
    alone = on_one_mesh(model)
    points = []
    for length in lengths:
        pulse = replace(scenario.pulse, length=length)
        duration = min(DURATION.high, pulse.end + scenario.duration)
        asked = replace(scenario, pulse=pulse, duration=duration)
        found = _peak(alone, asked, displacement)
        if isinstance(found, str):
            points.append(Point(length, None, None, found))
        else:
            reached = replace(pulse, peak=found)
            points.append(Point(length, found, reached.whole))
    return points


def _peak(model: Model, scenario: Any, displacement: float) -> float | str:
    """Peak of the pulse that reaches the displacement, or why there is none."""

    def reaches(peak: float) -> bool | str:
        response = model.simulate(replace(scenario, pulse=replace(scenario.pulse, peak=peak)))
        outcome = outcome_of(response)
        if not outcome.is_answer:
            return str(response.attrs["message"])
        if outcome is Outcome.COLLAPSE:
            return True
        return float(response["displacement"].max()) >= displacement

    low = high = scenario.pulse.peak
    first = found = reaches(high)
    for _ in range(_MOST):
        if isinstance(found, str):
            return found
        if found != first:
            break
        low, high = (low, high * _GROWTH) if not first else (low / _GROWTH, high)
        found = reaches(high if not first else low)
    else:
        return "no peak between the largest and the least that were tried reaches it"
    low = high / _GROWTH if not first else low
    high = high if not first else low * _GROWTH
    while high > low * (1.0 + _TOLERANCE):
        middle = sqrt(low * high)
        found = reaches(middle)
        if isinstance(found, str):
            return found
        low, high = (low, middle) if found else (middle, high)
    return sqrt(low * high)
