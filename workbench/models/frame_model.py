"""Model of frames: bars, runs, steps, drivers; a column is a frame of two members.

A model says in `group` of which bars its members are, a few each, with hinges at their ends.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from math import pi, sqrt
from time import perf_counter
from typing import ClassVar, TypeVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import SolverError
from workbench.base.fields import Choice, Declared, Number, checked
from workbench.mechanics.frames import out_of_domain
from workbench.mechanics.frames.elastic import (
    Spans,
    linear_algebra,
    spans_to,
    time_to_peak,
    wave_times,
)
from workbench.mechanics.frames.members import spread_findings
from workbench.mechanics.frames.runs import OPEN_LEDGER, Record, run_driven, run_impact, run_static
from workbench.mechanics.frames.structure import (
    FEWEST_LOADED,
    MOST_PARTS,
    Cut,
    FrameStructure,
    SuperelementMembers,
    apply_dead_loads,
    cut_members,
    joint_inertias,
    struck_parts,
)
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.elements import HingedElements
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
from workbench.models.domain import MUCH_SHARED, hit_mass_findings, member_findings
from workbench.models.hit_mass import light_impact_mass
from workbench.models.strain_rate import with_rate
from workbench.responses import Finding, Response, finding, findings_of, set_findings
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    Frame,
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
PEAK_STEPS = 150.0  # time steps up to the expected peak
LEAST_STEPS = 100.0  # of a record
NO_MOMENT_LOST = 0.25  # of the squash load, tension of a run; EN 1993-1-1, 6.2.9.1 (4)

# options of all models of bars, each declared by a model in a line
ELEMENTS = partial(
    checked,
    Number(1, 100, integer=True),
    optional=True,
    help="per member (None: one, of loaded more)",
)
TIME_STEP = partial(
    checked,
    Number(1e-8, 1.0, "s"),
    optional=True,
    help="None: 1/150 of the expected time to the peak, four times as long after six such "
    "times, at most the time of a wave along an element and back, half of that with "
    "restitution; of superelements by the error",
)
REGULARISATION = partial(
    checked,
    Number(0.0, 0.1, advice="a share of the elastic stiffness, 1e-6 by default"),
    1e-6,
    help="share of the elastic stiffness beside perfectly plastic hinges",
)
GEOMETRY = partial(
    checked,
    Choice(("co-rotational", "linear")),
    "co-rotational",
    help="linear: equilibrium of the undeformed frame, first-order theory for comparison",
)


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
    `largest_error` of the energy ledger over the input energy that an impact may have. Of its bars
    `least_parts` of a struck member, and what their number is a multiple of, `most_parts` of one
    hit by a striker, and how much of its energy their mass may share, `much_shared`; `far_parts` of
    members far from it (of one, mass is at the ends); `euler_share` of a pin-ended bar, below which
    bars keep its squash load (0: any); whether yielding is `concentrated` in hinges, with none
    between them. A model of another mesh has its own `structure`, `limits`, `time_spans`.
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
    least_parts: ClassVar[int] = 1
    far_parts: ClassVar[int] = 2
    most_parts: ClassVar[int] = MOST_PARTS
    much_shared: ClassVar[float] = MUCH_SHARED
    euler_share: ClassVar[float] = 0.0
    concentrated: ClassVar[bool] = True

    weight: float = 0.5
    elements: int | None
    time_step: float | None
    regularisation: float
    geometry: str
    shear_flexible: bool = True
    residual_stress: str = "none"

    @property
    @abstractmethod
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model and of the options that are on."""

    @property
    def halvings(self) -> int:
        """How often the steps are halved."""
        return 0

    @property
    def first_order(self) -> bool:
        """Whether equilibrium is that of the undeformed structure."""
        return self.geometry == "linear"

    def group(self, cut: Cut) -> HingedElements:
        """The bars of the pieces into which the members of a frame are cut."""
        raise NotImplementedError

    def structure(self, scenario: FrameScenario | ColumnScenario) -> FrameStructure:
        """The frame, or the column as one, under its dead loads. Raises `SolverError`."""
        return self.standing(scenario).fresh()

    def standing(self, scenario: FrameScenario | ColumnScenario) -> FrameStructure:
        """Structure under its dead loads, kept for many runs; statics know no rate."""
        event = as_frame(scenario)
        if event.STATIC:
            event = with_rate(event, None)
        return _standing(self, event.frame, tuple(self.parts(event)), isinstance(scenario, COLUMNS))

    def parts(self, scenario: FrameScenario) -> list[int]:
        """Bars of every member: `elements`, and more where the squash load nears the Euler load."""
        frame, counts = scenario.frame, [self.elements or 1] * len(scenario.frame.members)
        if self.elements is None:
            counts = list(struck_parts(scenario, self.least_parts, self.far_parts, self.most_parts))
        if not self.euler_share:
            return counts
        euler = self.euler_share * pi**2 * frame.steel.elastic_modulus  # times I / L^2
        slenderness = frame.each("squash_load") / (euler * frame.each("second_moment"))
        fewest = np.ceil(frame.lengths * np.sqrt(slenderness)).astype(int)
        return [max(pair) for pair in zip(counts, fewest.tolist(), strict=True)]

    def lengths(self, scenario: FrameScenario | ColumnScenario) -> list[Array]:
        """Lengths of equal bars (m) of every member."""
        event = as_frame(scenario)
        pairs = zip(event.frame.lengths.tolist(), self.parts(event), strict=True)
        return [np.full(count, length / count) for length, count in pairs]

    def time_spans(self, scenario: FrameImpact) -> Spans:
        """End times and time steps (s) of the parts of the record of an impact.

        Steps longer than a wave takes along an element and back make its hinges ring, which
        softens them artificially. Rebounds need half the step.
        """
        duration = scenario.duration
        if self.time_step is not None:
            return [(duration, self.time_step)]
        waves = wave_times(scenario.frame) / self.parts(scenario)
        peak = time_to_peak(scenario)
        coarsest = min(duration / LEAST_STEPS, 2.0 * float(waves.min()))
        share = 0.5 if scenario.striker.rebounds else 1.0
        return spans_to(peak, duration, peak / PEAK_STEPS, coarsest, share)

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings common to all member models, then `limits`; of a frame kept for every hit."""
        kept, key = {}, ""
        if isinstance(scenario, FrameImpact):
            kept, key = scenario.frame.kept, f"findings at {scenario.striker.node}"
        if key not in kept:
            with linear_algebra().limit(limits=1):
                kept[key] = member_findings(scenario)
        light = light_impact_mass(scenario) if isinstance(scenario, COLUMNS) else []
        return [*kept[key], *light, *self.limits(as_frame(scenario))]

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Findings of the model alone: too few bars under a striker or a line load."""
        parts = self.parts(event)
        findings = hit_mass_findings(event, parts, self.much_shared)
        if isinstance(event, FramePulse) and event.members:
            pairs = zip(event.frame.members, parts, strict=True)
            fewest = min(count for member, count in pairs if member.name in event.members)
            if fewest < FEWEST_LOADED:
                findings.append(finding("line-load", fewest, fewest=fewest, wanted=FEWEST_LOADED))
        return findings

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a static loading, an impact or a motion of the ground, of a frame or a column.

        Findings of the domain that the run of an impact has measured are left out: shear, and
        catenary action, which joints that give way may have kept from any member.
        """
        response = respond(self, scenario, self.solve)
        if isinstance(scenario, FrameImpact) and "shear_utilisation" in response:
            squash = np.repeat(scenario.frame.each("squash_load"), 2)
            tension = response["axial_force"].values / squash[:, None]
            pulled = float(np.max(tension)) > NO_MOMENT_LOST
            settled = {"shear"} if pulled else {"shear", "catenary"}
            left = [each for each in findings_of(response) if each.subject not in settled]
            set_findings(response, left)
        return response

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
        """Answer a scenario on a structure that the run may change.

        A push of concentrated hinges also finds the yielding that they leave out.
        """
        clock = Clock()
        if isinstance(scenario, FrameStatic):
            path = clock.timed(self._push(scenario, structure))
            response = run_static(scenario, structure, path)
            if self.concentrated:
                spread = spread_findings(scenario, response)
                set_findings(response, [*findings_of(response), *spread])
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


@lru_cache(maxsize=16)
def _standing(
    model: FrameModel, frame: Frame, parts: tuple[int, ...], column: bool
) -> FrameStructure:
    """The frame of so many bars of every member, or `column`, under its dead loads."""
    cut = cut_members(frame, parts)
    group = model.group(cut)
    members = SuperelementMembers(group, cut.coordinates, parts)
    assembly = PlanarAssembly(cut.coordinates, [group])
    structure = apply_dead_loads(frame, assembly, members, rotary_inertia=joint_inertias(cut))
    if frame.steel.rate is not None and (share := group.envelope_share()) >= 1.0:
        raise out_of_domain("bars-at-rest", share=share)
    return as_column(structure) if column else structure


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
