"""The critical value of a scenario, and the pulses that reach a displacement.

A limit is where the answer of a model turns from survival to collapse.

Values are tried in equal parts from one end of a range, up to the first collapse; the bracket is
then bisected. What lies behind the first collapse is not looked at. A value without an answer is
taken for neither: the bracket closes on it from both sides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

from workbench.base.errors import Collapse
from workbench.models.base import Model, ask, on_one_mesh
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    collapse_of,
    outcome_of,
    survives,
    warnings_of,
)
from workbench.responses.histories import NO_PEAK, largest_of
from workbench.scenarios import Scenario
from workbench.scenarios.column import DURATION
from workbench.scenarios.pulse import PEAK
from workbench.study.error_model.error_model import CLOSE, advise

PARTS = 8  # of the range, until a collapse is found
SMALL = 1e-3  # of the range; values below it do not make the bracket narrower


@dataclass(frozen=True)
class SurvivalTrial:
    """Trial at one `value`: whether the structure `survives`, None where that is not known.

    With `outcome` and `message`, its `collapse`, and `duration` of the record (s;
    None: the scenario has none).
    """

    value: float
    survives: bool | None
    outcome: str
    message: str
    collapse: Collapse | None
    duration: float | None


@dataclass(frozen=True)
class CriticalValue:
    """The bracket in which a `model` turns from survival to collapse, and every value tried.

    `warnings` at both ends of it, as `simulate` prints them: where it survives, and of what else
    it collapses.
    `survives_at` and `collapses_at` are None where no value tried does so; `settled`, whether
    nothing is left open: the bracket is as narrow as was asked, or the ends of the range decide.
    """

    model: str
    survives_at: float | None
    collapses_at: float | None
    settled: bool
    trials: tuple[SurvivalTrial, ...]
    warnings: tuple[Finding, ...] = ()

    @property
    def undecided(self) -> tuple[SurvivalTrial, ...]:
        """Values without an answer: those inside the bracket, or all if there is none."""
        silent = tuple(trial for trial in self.trials if trial.survives is None)
        if self.survives_at is None or self.collapses_at is None:
            return silent
        low, high = sorted((self.survives_at, self.collapses_at))
        return tuple(trial for trial in silent if low < trial.value < high)

    def as_dict(self) -> dict[str, Any]:
        """The limit as JSON holds it, with trials in the order of their values."""
        trials = [
            {**vars(each), "collapse": each.collapse and each.collapse._asdict()}
            for each in sorted(self.trials, key=lambda trial: trial.value)
        ]
        return {**vars(self), "trials": trials, "warnings": [f.as_dict() for f in self.warnings]}


def find_limit(
    model: Model,
    scenario_at: Callable[[float], Scenario],
    ends: tuple[float, float],
    tolerance: float,
    follow: Callable[[SurvivalTrial], None] = lambda trial: None,
) -> CriticalValue:
    """Bracket the value at which a structure collapses that survives below (or above) it.

    Arguments: the `model`, asked without the coarser meshes of a reference; `scenario_at` a value;
    `ends` of the range, the one that survives first; `tolerance`, width of the bracket over its
    larger value; `follow` gets each trial when it is known.
    """
    alone = on_one_mesh(model)
    trials: dict[float, SurvivalTrial] = {}
    ended: dict[bool | None, tuple[Scenario, Response]] = {}  # the last answers of each kind

    def tried(value: float) -> bool | None:
        scenario, response = ask(alone, scenario_at(value))
        trials[value] = _trial(value, scenario, response)
        survived = trials[value].survives
        ended[survived] = scenario, response
        follow(trials[value])
        return survived

    first, last = ends
    survived_at = collapsed_at = None
    for part in range(PARTS + 1):
        value = last if part == PARTS else first + (last - first) * part / PARTS
        survived = tried(value)
        if survived:
            survived_at = value
        elif survived is False:
            collapsed_at = value
            break
    all_survive = all(trial.survives for trial in trials.values())
    settled = collapsed_at == first or (collapsed_at is None and all_survive)
    least = tolerance * SMALL * abs(last - first)
    while survived_at is not None and collapsed_at is not None:
        silent = [t.value for t in trials.values() if t.survives is None]
        inside, start, end = _gap(survived_at, collapsed_at, silent)
        if abs(end - start) <= max(least, tolerance * max(abs(survived_at), abs(collapsed_at))):
            settled = not inside
            break
        middle = 0.5 * (start + end)
        survived = tried(middle)
        survived_at = middle if survived else survived_at
        collapsed_at = middle if survived is False else collapsed_at
    at_ends = [ended[way] for way in (True, False) if way in ended]
    findings = {f.subject: f for each in reversed(at_ends) for f in advise(alone, *each)}
    warnings = tuple(f for f in findings.values() if not f.refusal and f.subject != CLOSE)
    return CriticalValue(
        model.name, survived_at, collapsed_at, settled, tuple(trials.values()), warnings
    )


def _gap(survived_at: float, collapsed_at: float, silent: list[float]) -> tuple[bool, float, float]:
    """Whether values without an answer lie in the bracket, and what to halve next.

    That is the bracket, or the wider gap between an end of it and the nearest such value.
    """
    low, high = sorted((survived_at, collapsed_at))
    inside = sorted((v for v in silent if low < v < high), reverse=collapsed_at < survived_at)
    ends = [survived_at, *inside, collapsed_at]
    start, end = max((ends[:2], ends[-2:]), key=lambda gap: abs(gap[1] - gap[0]))
    return bool(inside), start, end


def _trial(value: float, scenario: Any, response: Response) -> SurvivalTrial:
    open_end = [str(finding) for finding in warnings_of(response) if finding.subject == NO_PEAK]
    return SurvivalTrial(
        value,
        survives(response),
        outcome_of(response).value,
        response.attrs["message"] or "; ".join(open_end),
        collapse_of(response),
        getattr(scenario, "duration", None),
    )


_GROWTH = 4.0  # of the peak, until it is between two values
_MOST = 16  # such steps
UNREACHED = "no peak between the largest and the least that were tried reaches it"
_TOLERANCE = 0.003  # of the peak


@dataclass(frozen=True)
class PulseAtLimit:
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
) -> list[PulseAtLimit]:
    """Pulses of these lengths (s) and the shape of the scenario that reach a displacement (m).

    Peaks are bracketed to 0.3 %, a reference on one mesh. A collapse has gone further. Records last
    that of the scenario beyond the pulse.
    """
    alone = on_one_mesh(model)
    points = []
    for length in lengths:
        pulse = replace(scenario.pulse, length=length)
        duration = min(DURATION.high, pulse.end + scenario.duration)
        lengthened = replace(scenario, pulse=pulse, duration=duration)
        peak = _peak(alone, lengthened, displacement)
        if isinstance(peak, str):
            points.append(PulseAtLimit(length, None, None, peak))
        else:
            reached = replace(pulse, peak=peak)
            points.append(PulseAtLimit(length, peak, reached.whole))
    return points


def _peak(model: Model, scenario: Any, displacement: float) -> float | str:
    """Peak of the pulse that reaches the displacement, or why there is none."""

    def reaches(peak: float) -> bool | str:
        if not PEAK.holds(peak):
            return UNREACHED
        response = model.simulate(replace(scenario, pulse=replace(scenario.pulse, peak=peak)))
        outcome = outcome_of(response)
        if not outcome.is_answer:
            return str(response.attrs["message"])
        if outcome is Outcome.COLLAPSE:
            return True
        return abs(largest_of(response["displacement"].values)) >= displacement

    low = high = scenario.pulse.peak
    first = reached = reaches(high)
    for _ in range(_MOST):
        if isinstance(reached, str):
            return reached
        if reached != first:
            break
        low, high = (low, high * _GROWTH) if not first else (low / _GROWTH, high)
        reached = reaches(high if not first else low)
    else:
        return UNREACHED
    low = high / _GROWTH if not first else low
    high = high if not first else low * _GROWTH
    while high > low * (1.0 + _TOLERANCE):
        middle = sqrt(low * high)
        reached = reaches(middle)
        if isinstance(reached, str):
            return reached
        low, high = (low, middle) if reached else (middle, high)
    return sqrt(low * high)
