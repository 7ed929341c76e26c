"""The drivers of the structures floor, started from a scenario."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from workbench.errors import OutOfDomainError, SolverError
from workbench.frames.structure import FrameStructure
from workbench.scenarios import FrameGroundMotion, FrameImpact, FrameStatic
from workbench.structures.arc_length import follow_arc
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.explicit import explicit_impact, lumped_mass
from workbench.structures.ground_motion import ground_motion, rigid_displacement
from workbench.structures.impact import MIDPOINT, impact
from workbench.structures.paths import PathStep, follow_displacement, follow_load
from workbench.structures.time_steps import PointMass, TimeStep

Array = NDArray[np.float64]
PERIOD_STEPS = 100.0  # time steps of a fundamental period, at least


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
