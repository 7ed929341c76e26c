"""How models of frames answer a scenario: steps, drivers, and a column told as a frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

from threadpoolctl import threadpool_limits

from workbench.errors import OutOfDomainError
from workbench.frames.drives import ground_steps, impact_steps, static_steps
from workbench.frames.runs import OPEN_LEDGER, run_ground_motion, run_impact, run_static
from workbench.frames.structure import FrameStructure
from workbench.frames.timing import Spans
from workbench.responses import Response
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    frame_scenario,
)
from workbench.structures.impact import MIDPOINT

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
