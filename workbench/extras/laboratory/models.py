"""Integrators as models: each answers an impact problem over a ladder of steps.

A cell of a study is one integrator on one problem; its response holds the errors, the cost and
the conditions of contact of every step size, and the record of the finest.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import SolverError
from workbench.base.fields import Choice, Number, checked
from workbench.extras.laboratory.impact_systems import PROBLEMS as STRUCTURES
from workbench.extras.laboratory.problems import BenchProblem, problem
from workbench.extras.laboratory.scenario import ImpactProblem
from workbench.extras.laboratory.schemes import SCHEMES
from workbench.extras.laboratory.systems import SystemRecord, run
from workbench.models.base import Answering
from workbench.responses import Finding, Response, build_response, set_attributes

LADDER = {
    "ladder.step": ("s", "time step"),
    "ladder.error": ("1", "largest error of the places over the largest place"),
    "ladder.evaluations": ("1", "evaluations of the forces"),
}
_POINTS = 800
_ROUNDING = 1e-10


def problem_of(name: str) -> BenchProblem:
    """The problem of this name: those of the laboratory, the column and the frame."""
    return STRUCTURES[name]() if name in STRUCTURES else problem(name)


@cache
def _answer(name: str, steps: int) -> Array:
    given = problem_of(name)
    return given.answer(np.linspace(0.0, given.duration, steps + 1))


def _response(
    given: BenchProblem, places: dict[str, Array], ladder: dict[str, Any], **scalars: Any
):
    """A response with the numbers of a ladder, and records of the last unknown."""
    steps = len(next(iter(places.values()))) - 1
    pick = np.unique(np.linspace(0, steps, min(steps, _POINTS) + 1).round().astype(int))
    time = np.linspace(0.0, given.duration, steps + 1)[pick]
    response = build_response(scalars, time=time)
    for name, values in places.items():
        response[name] = ("time", values[pick], {"units": "m", "long_name": "place"})
    for name, (unit, meaning) in LADDER.items() if ladder else ():
        response[name] = ("run", ladder[name], {"units": unit, "long_name": meaning})
    return response


@dataclass(frozen=True)
class ImpactIntegrator(Answering):
    """One integrator of the impact laboratory."""

    scheme: str = checked(Choice(tuple(SCHEMES)), "moreau-jean")
    runs: int = checked(
        Number(2, 10, integer=True), 6, help="step sizes of the ladder, each half the one before"
    )

    name: ClassVar[str] = "impact-integrator"
    version: ClassVar[int] = 3
    answers: ClassVar[tuple[str, ...]] = (ImpactProblem.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Unilateral contact without friction; restitution by the law of the problem, which schemes "
        "with contact at the end of a step do not know: none comes back there by rule, or all.",
        "Plain Python: compare costs by evaluations of the forces, times only among these schemes.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "moreau1988")

    def domain(self, scenario: ImpactProblem) -> list[Finding]:
        """Every scheme takes every problem: failures are what the study is about."""
        return []

    def _solve(self, scenario: ImpactProblem) -> Response:
        given = problem_of(scenario.problem)
        finest = given.steps * 2 ** (self.runs - 1)
        exact = _answer(scenario.problem, finest)
        ladder, finest_run, lost = self._climb(given, exact)
        times = np.linspace(0.0, given.duration, finest + 1)
        others = [self._climb(other, other.answer(times))[0] for other in given.others]
        errors = np.mean([each["ladder.error"] for each in (ladder, *others)], axis=0)
        if finest_run is None:
            raise SolverError(f"the finest of {self.runs} runs", np.inf, lost)
        response: Response = _response(
            given,
            {"record.place": finest_run.q[:, -1], "record.exact": exact[:, -1]},
            ladder,
            relative_error=ladder["ladder.error"][-1],
            observed_order=_order(errors),
            **_scalars(given, finest_run),
        )
        response.attrs["solve_time"] = finest_run.seconds
        return response

    def _climb(
        self, given: BenchProblem, exact: Array
    ) -> tuple[dict[str, Any], SystemRecord | None, str]:
        """The ladder held against the `exact` places at its finest steps; its last run, or why not.

        Errors and evaluations of runs that do not converge are NaN.
        """
        finest, size = len(exact) - 1, float(np.abs(exact).max())
        ladder: dict[str, Any] = {name: np.full(self.runs, np.nan) for name in LADDER}
        finest_run: SystemRecord | None = None
        lost = ""
        for level in range(self.runs):
            steps = given.steps * 2**level
            h = given.duration / steps
            ladder["ladder.step"][level] = h
            system, stepper = given.system(), SCHEMES[self.scheme].stepper
            try:
                finest_run = run(stepper, system, given.law, given.start, given.duration, h)
            except SolverError as error:
                finest_run, lost = None, str(error)
                continue
            off = np.abs(finest_run.q - exact[:: finest // steps]).max()
            ladder["ladder.error"][level] = off / size
            ladder["ladder.evaluations"][level] = finest_run.evaluations
        return ladder, finest_run, lost


def _order(errors: Array) -> float | None:
    """Order over the ladder behind its last run that is off by the largest place, or unstable.

    None where the answer is exact but for round-off, or where a single run is left.
    """
    off = np.flatnonzero(~(errors < 1.0))
    known = np.arange(errors.size) > (off[-1] if off.size else -1)
    if known.sum() < 2 or errors[known].max() < _ROUNDING:
        return None
    level = np.flatnonzero(known)
    slope = np.polyfit(level, np.log2(np.maximum(errors[known], _ROUNDING)), 1)[0]
    return float(-slope)


def _scalars(given: BenchProblem, finest_run: SystemRecord) -> dict[str, float | None]:
    """Conditions of contact in the finest run."""
    counted = given.impacts is not None
    return {
        "energy_drift": finest_run.drift if given.conservative else None,
        "largest_penetration": finest_run.conditions.penetration,
        "missed_impacts": max((given.impacts or 0) - finest_run.impacts, 0) if counted else None,
        "spurious_impacts": max(finest_run.impacts - (given.impacts or 0), 0) if counted else None,
        "chatter": finest_run.chatter,
    }


@dataclass(frozen=True)
class ImpactExact(Answering):
    """The known answer of an impact problem."""

    steps: int = checked(
        Number(1, 1024, integer=True), 32, help="times of the answer over those of the coarsest run"
    )

    name: ClassVar[str] = "impact-exact"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ImpactProblem.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Closed forms; where there is none, event-driven steps of fourth order at half the finest "
        "step, which tests hold to an independent integration from event to event.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def domain(self, scenario: ImpactProblem) -> list[Finding]:
        """Every problem has an answer."""
        return []

    def _solve(self, scenario: ImpactProblem) -> Response:
        given = problem_of(scenario.problem)
        exact = _answer(scenario.problem, given.steps * self.steps)
        nothing = dict.fromkeys(("relative_error", "largest_penetration"), 0.0)
        if given.impacts is not None:
            nothing |= dict.fromkeys(("missed_impacts", "spurious_impacts"), 0.0)
        if given.conservative:
            nothing["energy_drift"] = 0.0
        response: Response = _response(given, {"record.exact": exact[:, -1]}, {}, **nothing)
        width = 0.0 if given.exact is not None else given.certified
        widths = {name: width if name == "relative_error" else 0.0 for name in nothing}
        set_attributes(response, data_uncertainty=widths)
        return response
