"""Model of frames, common parts: runs, steps, drivers; a column is a frame of two members."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import pi, sqrt
from time import perf_counter
from typing import ClassVar, TypeVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import SolverError
from workbench.base.fields import Declared
from workbench.mechanics.frames.elastic import Spans, linear_algebra
from workbench.mechanics.frames.runs import OPEN_LEDGER, Record, run_driven, run_impact, run_static
from workbench.mechanics.frames.structure import FrameStructure
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.impact import (
    PointMass,
    TimeStep,
    follow_force,
    impact,
    rigid_displacement,
)
from workbench.mechanics.structures.paths import (
    PathStep,
    follow_arc,
    follow_displacement,
    follow_load,
)
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.models.hit_mass import light_impact_mass
from workbench.responses import Finding, Response, findings_of, set_findings
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameScenario,
    FrameStatic,
    MemberPulse,
    Scenario,
    frame_scenario,
)
from workbench.scenarios.pulse import line_integral

Taken = TypeVar("Taken")

PUSH_STEPS = 1000  # load steps over the range of a static path, before refinement
PERIOD_STEPS = 100.0  # time steps of a fundamental period, at least
PULSE_STEPS = 20.0  # of the length of a pulse, at least
COLUMNS = (ColumnImpact, ColumnPushover, MemberPulse)
COLUMN_HINGES = ("base", "hit-below", "hit-above", "head")


as_frame = frame_scenario  # a column becomes its two-member frame


def as_column(structure: FrameStructure) -> FrameStructure:
    """The frame of a column, with the histories and hinges that columns report."""
    watched = {"shortening": structure.dof("head", "-y")}
    return replace(structure, watched=watched, hinges=COLUMN_HINGES)


class Clock:
    """Counts the `seconds` in which steps are solved, without those in which they are read."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def timed(self, steps: Iterator[Taken]) -> Iterator[Taken]:
        """Steps unchanged, timed by the clock."""
        while True:
            started = perf_counter()
            taken = next(steps, None)
            self.seconds += perf_counter() - started
            if taken is None:
                return
            yield taken


class FrameModel(ABC, Declared, table="option"):
    """A model of frames, which takes a column as a frame and reports it as a column.

    Of a time step `weight`, that of the end stresses (one half conserves energy); `time_step` in s
    (None: by rule); `halvings`, how often steps are halved; `collision_halvings`, see `impact`;
    `largest_error` of the energy ledger over the input energy that an impact may have.
    """

    name: ClassVar[str]
    version: ClassVar[int]
    assumptions: ClassVar[tuple[str, ...]]
    answers: ClassVar[tuple[str, ...]] = tuple(
        kind.KIND for kind in (FrameStatic, FrameImpact, FrameGroundMotion, FramePulse, *COLUMNS)
    )
    collision_halvings: ClassVar[int] = 0
    largest_error: ClassVar[float | None] = OPEN_LEDGER
    crushing: ClassVar[bool] = True

    weight: float = 0.5
    time_step: float | None

    @property
    @abstractmethod
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model and of the options that are on."""

    @property
    def halvings(self) -> int:
        """How often the steps are halved."""
        return 0

    @abstractmethod
    def structure(self, scenario: FrameScenario | ColumnScenario) -> FrameStructure:
        """The frame, or the column as one, under its dead loads. Raises `SolverError`."""

    @abstractmethod
    def time_spans(self, scenario: FrameImpact) -> Spans:
        """End times and time steps (s) of the parts of the record of an impact."""

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings common to all member models; of a frame kept for every hit on a node."""
        kept, key = {}, ""
        if isinstance(scenario, FrameImpact):
            kept, key = scenario.frame.kept, f"findings at {scenario.striker.node}"
        if key not in kept:
            with linear_algebra().limit(limits=1):
                kept[key] = member_findings(scenario)
        light = light_impact_mass(scenario) if isinstance(scenario, COLUMNS) else []
        return [*kept[key], *light]

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a static loading, an impact or a motion of the ground, of a frame or a column.

        Findings of the domain that the run of an impact has measured are left out, see `settled`.
        """
        response = respond(self, scenario, self.solve)
        if isinstance(scenario, FrameImpact) and "shear_utilisation" in response:
            settled = self.settled(scenario, response)
            left = [each for each in findings_of(response) if each.subject not in settled]
            set_findings(response, left)
        return response

    def settled(self, scenario: FrameImpact, response: Response) -> set[str]:
        """Subjects of domain findings that measured ones replace, such as the mechanism's shear."""
        return {"shear"}

    def solve(self, scenario: FrameScenario | ColumnScenario) -> Response:
        """Answer a scenario that is in the domain.

        Raises `SolverError`, `OutOfDomainError`, `CollapseError`.
        """
        if isinstance(scenario, FrameGroundMotion):
            scenario = scenario.with_masses()
        structure = self.structure(scenario)
        if isinstance(scenario, COLUMNS):
            structure = as_column(structure)
        return self.run(as_frame(scenario), structure)

    def run(self, scenario: FrameScenario, structure: FrameStructure) -> Response:
        """Answer a scenario on a structure that the run may change."""
        clock = Clock()
        if isinstance(scenario, FrameStatic):
            path = clock.timed(self._push(scenario, structure))
            response = run_static(scenario, structure, path)
        elif isinstance(scenario, FrameImpact):
            response = self._struck(scenario, structure, clock)
        elif isinstance(scenario, FramePulse):
            pattern = structure.pattern(scenario.loads)
            pattern += structure.line_load(scenario.members, scenario.direction)
            whole = abs(float(np.sum(pattern)))
            steps = clock.timed(self._press(scenario, structure, pattern))
            response = run_driven(scenario, structure, steps, whole)
        else:
            steps = clock.timed(self._shake(scenario, structure))
            response = run_driven(scenario, structure, steps)
        response.attrs["solve_time"] = clock.seconds
        return response

    def _struck(self, scenario: FrameImpact, structure: FrameStructure, clock: Clock) -> Response:
        """The response to an impact, its steps timed by the `clock`."""
        striker, steps = scenario.striker, clock.timed(self._hit(scenario, structure))
        record = Record(structure, striker.node, striker.direction, scenario.duration)
        return run_impact(scenario, record, steps, self.largest_error)

    def _push(self, scenario: FrameStatic, structure: FrameStructure) -> Iterator[PathStep]:
        """Steps of a static path; paths to and fro have longer ones, four times as many in all."""
        pattern = structure.pattern(scenario.loads)
        dof, sign = structure.dof(scenario.node, scenario.direction)
        path = np.array([0.0, *scenario.path])
        travel = float(np.sum(np.abs(np.diff(path))))
        parts = round(PUSH_STEPS * 2.0**self.halvings)
        step = max(float(np.ptp(path)), 0.25 * travel) / parts
        if scenario.control == "displacement":
            return follow_displacement(structure.assembly, pattern, dof, sign, scenario.path, step)
        if scenario.control == "load":
            return follow_load(structure.assembly, pattern, scenario.path, dof, sign, step)
        return follow_arc(structure.assembly, pattern, dof, sign, scenario.path[-1], step)

    def _hit(self, scenario: FrameImpact, structure: FrameStructure) -> Iterator[TimeStep]:
        """Time steps of an impact."""
        striker, assembly, spans = scenario.striker, structure.assembly, self.time_spans(scenario)
        dof, sign = structure.dof(striker.node, striker.direction)
        given = assembly, dof, PointMass.of(scenario), spans, self.weight
        return impact(*given, sign=sign, halvings=self.collision_halvings)

    def _shake(self, scenario: FrameGroundMotion, structure: FrameStructure) -> Iterator[TimeStep]:
        """Time steps of a motion of the ground.

        By rule they are 1/100 of the fundamental period, at most the step of the acceleration.
        """
        assembly, duration = structure.assembly, float(scenario.duration or 0.0)
        driven = assembly.mass_times(rigid_displacement(assembly, scenario.direction))
        step = self.time_step
        if step is None:
            step = min(scenario.time_step, _fundamental_period(assembly, driven) / PERIOD_STEPS)
        times = scenario.time_step * np.arange(len(scenario.acceleration))
        velocity = line_integral(times, scenario.acceleration)  # of the ground
        spans = [(duration, step / 2.0**self.halvings)]
        numbers = self.weight, scenario.damping
        return follow_force(assembly, -driven, _mean_of(velocity), spans, *numbers)

    def _press(
        self, scenario: FramePulse, structure: FrameStructure, pattern: Array
    ) -> Iterator[TimeStep]:
        """Time steps under a pulse times a `pattern` (dofs,).

        By rule they are 1/100 of the period of its shape, and 1/20 of the pulse while it lasts.
        """
        share = 0.5**self.halvings
        later = self.time_step
        if later is None:
            period = _fundamental_period(structure.assembly, pattern)
            later = min(scenario.duration, period) / PERIOD_STEPS
        end = min(scenario.pulse.end, scenario.duration)
        first = later if self.time_step else min(later, end / PULSE_STEPS)
        spans = [(end, share * first), (scenario.duration, share * later)]
        mean = _mean_of(scenario.pulse.impulse)
        return follow_force(structure.assembly, pattern, mean, spans, self.weight)


def _mean_of(integral: Callable[[Array], Array]) -> Callable[[float, float], float]:
    """The mean between two times (s) of what has this `integral`."""

    def mean(begin: float, end: float) -> float:
        before, after = integral(np.array([begin, end]))
        return float(after - before) / (end - begin)

    return mean


def _fundamental_period(assembly: PlanarAssembly, driven: Array) -> float:
    """Rayleigh's estimate (s) from the elastic shape under the forces `driven` (dofs,)."""
    assembly.assemble(assembly.displacement, None)
    shape = assembly.solve(driven)
    if shape is None:
        raise SolverError("fundamental period", np.inf, "the tangent is singular")
    square = float(shape @ driven) / float(shape @ assembly.mass_times(shape))
    return 2.0 * pi / sqrt(square)
