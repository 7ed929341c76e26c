"""The impact velocity at which one structure reaches a limit, by one model.

If the peak grows with the velocity, every sample of the inputs has one critical velocity, and the
probability of exceedance over velocity is its distribution function.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from math import exp, inf, isfinite, isnan, log, nan
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.errors import InputError, WorkbenchError
from workbench.base.fields import Number
from workbench.base.units import in_si
from workbench.models.base import Model, ask
from workbench.responses import PEAK, Outcome, outcome_of, survives

REACHED, BY_COLLAPSE, NEVER, ALREADY, NO_ANSWER = (
    *("reached", "by collapse", "never reached", "reached already", "no answer"),
)
LONGEST_STEP, SLOPES = 0.25, (0.5, 8.0)  # of ln velocity; d ln peak / d ln velocity
STRIDE = 0.04  # of ln velocity, the first towards a collapse
CLOSE = 2e-4  # ln peak, at the critical velocity of a reduced model
COARSE = 2e-3  # the same of a reference, and its bracket of a collapse
MOST_RUNS, MOST_SECANTS = 40, 12  # after so many secants brackets are halved
BEYOND = 3.0  # the range of velocities is searched so many times wider on both sides
ASIDE = 0.03  # ln velocity, of the two runs that give a slope
FAR = 0.05  # ln velocity; a correction above it is followed by a second run
LEAST_LIMIT, MOST_LIMIT = 1e-6, 100.0  # m
VELOCITIES = Number(0.01, 500.0, "m/s")  # ends of a range


class DisplacementLimit(NamedTuple):
    """Limit that must not be exceeded: a peak displacement (m), or collapse (infinite)."""

    displacement: float

    def __str__(self) -> str:
        return f"{self.displacement:g} m" if isfinite(self.displacement) else "collapse"


class Root(NamedTuple):
    """A critical velocity: its logarithm (NaN: none), how it was found, in how many runs."""

    log_velocity: float
    kind: str
    runs: int


@dataclass(frozen=True)
class Asked:
    """A model at a sample; `peak_at(ln velocity)` is inf for collapse, NaN without an answer."""

    model: Model
    scenario: Any

    def peak_at(self, log_velocity: float) -> float:
        """Magnitude of the peak displacement (m) at a velocity."""
        try:
            response = ask(self.model, self.scenario.at_velocity(exp(log_velocity)))[1]
        except WorkbenchError:
            return nan
        outcome = outcome_of(response)
        if outcome is Outcome.COLLAPSE:
            return inf
        if outcome is not Outcome.OK or PEAK not in response:
            return nan
        peak = abs(float(response[PEAK]))
        return peak if survives(response) is not None else nan


def limit_of(text: str) -> DisplacementLimit:
    """Read a limit: ``collapse`` or ``displacement=0.1`` (m, or with a unit)."""
    name, equals, value = text.partition("=")
    if text.strip() == "collapse":
        return DisplacementLimit(inf)
    if name.strip() != "displacement" or not equals:
        text_ = "must be collapse or displacement=METRES"
        raise InputError("--limit", text, text_, "such as displacement=0.1 or displacement=100mm")
    try:
        number: float | None = float(value)
    except ValueError:
        number = in_si(value, "m")
    if number is None:
        raise InputError("--limit", text, "must give a displacement in m", "such as 0.1 or 100 mm")
    Number(LEAST_LIMIT, MOST_LIMIT).check("--limit", number)
    return DisplacementLimit(number)


Search = Generator[float, float, Root]
PeaksAt = Callable[[Indices, Array], Array]  # peaks (rows,) of some rows, each at a ln velocity


def critical_velocity(
    peak_at: Callable[[float], float],
    limit: DisplacementLimit,
    start: float,
    ends: tuple[float, float],
    close: float = CLOSE,
) -> Root:
    """Find the velocity at which the peak of one structure reaches the limit, as `search` does.

    `peak_at` as `Asked.peak_at`.
    """

    def peaks_at(rows: Indices, log_velocity: Array) -> Array:
        return np.array([peak_at(float(log_velocity[0]))])

    return in_step([search(limit, start, ends, close)], peaks_at)[0]


def in_step(searches: Sequence[Search], peaks_at: PeaksAt) -> list[Root]:
    """Follow searches together: in each step all that are still open are asked at once."""
    points = np.array([next(each) for each in searches])
    roots: dict[int, Root] = {}
    while len(roots) < len(searches):
        rows = np.array([row for row in range(len(searches)) if row not in roots])
        for row, peak in zip(rows.tolist(), peaks_at(rows, points[rows]).tolist(), strict=True):
            try:
                points[row] = searches[row].send(peak)
            except StopIteration as end:
                roots[row] = end.value
    return [roots[row] for row in range(len(searches))]


def search(
    limit: DisplacementLimit,
    start: float,
    ends: tuple[float, float],
    close: float = CLOSE,
    stride: float = STRIDE,
) -> Search:
    """Search the velocity at which a peak reaches the limit: asks ln velocities, is sent peaks.

    Secant in ln velocity and ln peak, halved between brackets where a collapse is in the way.
    A peak (m) is infinite for collapse, NaN without an answer. `start`, `ends`: ln velocity to
    start from and range to search; `close`, tolerance of ln peak, and of ln velocity at a collapse;
    `stride`, first step in ln velocity where there is no slope to follow.
    """
    d, x = limit.displacement, min(max(start, ends[0]), ends[1])
    below, above, collapsed = nan, nan, False
    last: tuple[float, float] | None = None  # ln velocity, ln peak
    slope = 1.8
    for run in range(1, MOST_RUNS + 1):
        peak = yield x
        if isnan(peak) or peak <= 0.0:
            return Root(nan, NO_ANSWER, run)
        if isfinite(peak) and isfinite(d) and abs(log(peak / d)) <= close:
            return Root(x, REACHED, run)
        if peak > d or not isfinite(peak):
            above, collapsed = x, not isfinite(peak)
        else:
            below = x
        if below >= ends[1]:
            return Root(inf, NEVER, run)
        if above <= ends[0]:
            return Root(ends[0], ALREADY, run)
        bracketed = not isnan(below) and not isnan(above)
        if bracketed and collapsed and above - below <= close:
            return Root(0.5 * (above + below), BY_COLLAPSE, run)
        if isfinite(peak) and isfinite(d):
            if last is not None and x != last[0]:
                steepest = inf if bracketed else SLOPES[1]  # between a bracket it cannot run away
                slope = min(max((log(peak) - last[1]) / (x - last[0]), SLOPES[0]), steepest)
            last = x, log(peak)
            step = min(max(log(d / peak) / slope, -LONGEST_STEP), LONGEST_STEP)
            target = x + step
        elif bracketed:
            target = 0.5 * (below + above)
        else:
            target = x + (stride if isfinite(peak) else -stride)
            stride = min(2.0 * stride, LONGEST_STEP)
        if bracketed and (run > MOST_SECANTS or not below < target < above):
            target = 0.5 * (below + above)
        if bracketed and above - below <= 0.1 * close:
            return Root(0.5 * (above + below), BY_COLLAPSE if collapsed else REACHED, run)
        x = min(max(target, ends[0]), ends[1])
    return Root(nan, NO_ANSWER, MOST_RUNS)


def slopes_at(
    peaks_at: PeaksAt, rows: Indices, log_velocity: Array, limit: DisplacementLimit
) -> Array:
    """Slopes d ln peak / d ln velocity at critical velocities, from two runs beside each.

    NaN where there is none, as at a collapse.
    """
    if not isfinite(limit.displacement):
        return np.full(len(rows), nan)
    low, high = (peaks_at(rows, log_velocity + offset) for offset in (-ASIDE, ASIDE))
    low = np.where(np.isfinite(low), low, nan)
    both = np.log(high / low) / (2.0 * ASIDE)
    slopes = np.where(np.isfinite(high), both, np.log(limit.displacement / low) / ASIDE)
    return np.asarray(np.clip(slopes, *SLOPES))


def grows(peaks_at: PeaksAt, rows: Indices, log_velocity: Array, limit: DisplacementLimit) -> Flags:
    """Whether the limit is still passed 5 % above the critical velocities, as far as is known."""
    peaks = peaks_at(rows, log_velocity + log(1.05))
    return np.asarray(np.isnan(peaks) | (peaks >= limit.displacement))


class Ratio(NamedTuple):
    """ln of a reference's critical velocity over that of the reduced model (NaN: it failed).

    `slope` of the reduced model there; `runs` of the reference; `reason` of a failure.
    """

    value: float
    slope: float
    runs: int
    reason: str = ""


def ratio_to_reference(
    reference: Asked,
    slope: float,
    limit: DisplacementLimit,
    log_velocity: float,
    ends: tuple[float, float],
) -> Ratio:
    """The log ratio of critical velocities at one sample, mostly by one run of the reference.

    e = -ln(peak / limit) / slope, critical velocity and slope (NaN: none) those of the reduced
    model. Where the reference collapses, or the limit is collapse, its own critical velocity is
    searched. A reference without an answer is asked a little aside, then on a coarser mesh.
    """
    d, runs = limit.displacement, 0
    offsets = (0.0, -ASIDE, ASIDE) if isfinite(slope) else ()
    for variant in (reference, _coarser(reference)) if isfinite(slope) else ():
        for offset in offsets:
            x = log_velocity + offset
            peak, runs = variant.peak_at(x), runs + 1
            if peak == inf:
                break
            if isfinite(peak) and peak > 0.0:
                x -= log(peak / d) / slope
                if abs(x - log_velocity) > FAR:
                    again, runs = variant.peak_at(x), runs + 1
                    if not isfinite(again):
                        break
                    x -= log(again / d) / slope
                return Ratio(x - log_velocity, slope, runs)
        else:
            continue
        break
    root = critical_velocity(reference.peak_at, limit, log_velocity, ends, COARSE)
    runs += root.runs
    if root.kind in (REACHED, BY_COLLAPSE):
        return Ratio(root.log_velocity - log_velocity, slope, runs)
    return Ratio(nan, slope, runs, root.kind)


def _coarser(reference: Asked) -> Asked:
    """The reference on the next coarser mesh, where it has one."""
    model: Any = reference.model
    if not hasattr(model, "refinement"):
        return reference
    return replace(reference, model=replace(model, refinement=model.refinement - 1))
