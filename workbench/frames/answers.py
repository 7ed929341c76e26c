"""How models of frames answer a scenario: steps, drivers, and a column told as a frame."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from workbench.arrays import Array
from workbench.errors import OutOfDomainError, SolverError
from workbench.frames.runs import OPEN_LEDGER, run_ground_motion, run_impact, run_static
from workbench.frames.structure import FrameStructure
from workbench.frames.timing import Spans
from workbench.responses import Response
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    FrameGroundMotion,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    frame_scenario,
)
from workbench.structures.arc_length import follow_arc
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.explicit import explicit_impact, lumped_mass
from workbench.structures.ground_motion import ground_motion, rigid_displacement
from workbench.structures.impact import MIDPOINT, impact
from workbench.structures.paths import PathStep, follow_displacement, follow_load
from workbench.structures.time_steps import PointMass, TimeStep

PERIOD_STEPS = 100.0  # time steps of a fundamental period, at least
COLUMNS = (ColumnImpact, ColumnPushover)
COLUMN_HINGES = ("base", "hit-below", "hit-above", "head")


@dataclass(frozen=True)
class Stepping:
    """How a model steps through what happens to a frame.

    `parts` of the range of a static path; `spans` of an impact; `weight` of the end stresses in a
    time step (None: explicit) and the `integrator`; `time_step` (s) of a motion of the ground
    (None: by rule) with its `halvings`; `largest_error` and `least_yield_ratio`, see `run_impact`.
    """

    parts: int
    spans: Callable[[FrameImpact], Spans]
    weight: float | None
    integrator: str = MIDPOINT
    time_step: float | None = None
    halvings: int = 0
    largest_error: float | None = OPEN_LEDGER
    least_yield_ratio: float = 0.99


def as_frame(scenario: FrameScenario | ColumnScenario) -> FrameScenario:
    """A scenario of a frame; that of a column as what happens to the frame of its two members."""
    return frame_scenario(scenario) if isinstance(scenario, COLUMNS) else scenario


def answer(
    scenario: FrameScenario | ColumnScenario,
    build: Callable[[FrameScenario], FrameStructure],
    stepping: Stepping,
) -> Response:
    """Answer a scenario of a frame, or of a column seen as one and told in its own words.

    Argument: `build` stands the frame of a scenario up under its dead loads. The strike on a
    column flies along +x and the column goes up, so that moments are those of a frame with the
    opposite sign: positive at the base. Raises `SolverError`, `OutOfDomainError`.
    """
    told = as_frame(scenario)
    with threadpool_limits(1, user_api="blas"):  # band solves are far too small for threads
        structure = build(told)
        if not isinstance(scenario, COLUMNS):
            return _run(told, structure, stepping)
        watched = {"shortening": structure.dof("head", "-y")}
        response = _run(told, replace(structure, watched=watched), stepping)
    for name in ("moment", "plastic_rotation"):
        response[name].values *= -1.0
    return response.assign_coords(hinge=response["hinge"].copy(data=list(COLUMN_HINGES)))


def _run(scenario: FrameScenario, structure: FrameStructure, stepping: Stepping) -> Response:
    started = perf_counter()
    least, weight = stepping.least_yield_ratio, stepping.weight
    if isinstance(scenario, FrameStatic):
        pushed = static_steps(scenario, structure, stepping.parts)
        response = run_static(scenario, structure, pushed)
    elif isinstance(scenario, FrameImpact):
        spans = stepping.spans(scenario)
        steps = impact_steps(scenario, structure, spans, weight, stepping.integrator)
        response = run_impact(scenario, structure, steps, stepping.largest_error, least)
    elif weight is None:
        raise OutOfDomainError("explicit steps are known for impacts only: take implicit ones")
    else:
        shaken = ground_steps(scenario, structure, stepping.time_step, weight, stepping.halvings)
        response = run_ground_motion(scenario, structure, shaken, least)
    response.attrs["solve_time"] = perf_counter() - started
    return response


def static_steps(
    scenario: FrameStatic, structure: FrameStructure, parts: int
) -> Iterator[PathStep]:
    """Steps along the path of a scenario, its range cut into so many `parts`.

    Paths to and fro have longer steps, four times as many in all. Raises `SolverError`.
    """
    pattern = structure.pattern(scenario.loads)
    dof, sign = structure.dof(scenario.node, scenario.direction)
    path = np.array([0.0, *scenario.path])
    travel = float(np.sum(np.abs(np.diff(path))))
    increment = max(float(np.ptp(path)), 0.25 * travel) / parts
    if scenario.control == "displacement":
        return follow_displacement(structure.assembly, pattern, dof, sign, scenario.path, increment)
    if scenario.control == "load":
        return follow_load(structure.assembly, pattern, scenario.path, dof, sign, increment)
    return follow_arc(structure.assembly, pattern, dof, sign, scenario.path[-1], increment)


def impact_steps(
    scenario: FrameImpact,
    structure: FrameStructure,
    spans: Sequence[tuple[float, float]],
    weight: float | None,
    integrator: str = MIDPOINT,
) -> Iterator[TimeStep]:
    """Time steps of an impact.

    Arguments: `spans`, end times and time steps (s) of the parts of the record; `weight` of the
    end stresses in a step and `integrator`, see `impact`. Without a weight the steps are explicit,
    with lumped mass: the spans then bound them and are the intervals of the record. Raises
    `SolverError`, and `OutOfDomainError` where a dof has no mass for explicit steps.
    """
    striker, assembly = scenario.striker, structure.assembly
    dof, sign = structure.dof(striker.node, striker.direction)
    mass = PointMass(striker.mass, striker.velocity, striker.restitution)
    if weight is not None:
        return impact(assembly, dof, mass, spans, weight, sign=sign, integrator=integrator)
    try:
        lumped_mass(assembly)
    except ValueError as error:
        raise OutOfDomainError(f"{error}: take implicit steps") from error
    return explicit_impact(assembly, dof, mass, spans, spans[0][1], sign=sign)


def ground_steps(
    scenario: FrameGroundMotion,
    structure: FrameStructure,
    time_step: float | None,
    weight: float,
    halvings: int = 0,
) -> Iterator[TimeStep]:
    """Implicit time steps of a motion of the ground.

    Arguments: `time_step` in s (None: 1/100 of the fundamental period, at most the step of the
    acceleration); `weight` of the end stresses in a step; `halvings` of the time step. Raises
    `SolverError`.
    """
    assembly, duration = structure.assembly, float(scenario.duration or 0.0)
    direction = rigid_displacement(assembly, scenario.direction)
    if time_step is None:
        period = fundamental_period(assembly, direction)
        time_step = min(scenario.time_step, period / PERIOD_STEPS)
    return ground_motion(
        assembly,
        direction,
        scenario.acceleration,
        scenario.time_step,
        [(duration, time_step / 2.0**halvings)],
        weight,
        scenario.damping,
    )


def fundamental_period(assembly: PlanarAssembly, direction: Array) -> float:
    """Rayleigh's estimate (s) from the elastic shape under inertia along `direction` (dofs,)."""
    assembly.assemble(assembly.displacement, None)
    driven = assembly.mass_times(direction)
    shape = assembly.solve(driven)
    if shape is None:
        raise SolverError("fundamental period", np.inf, "the tangent is singular")
    square = float(shape @ driven) / float(shape @ assembly.mass_times(shape))
    return 2.0 * pi / sqrt(square)
