"""How superelements answer a scenario: steps, drivers, and a column told as a frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from threadpoolctl import threadpool_limits

from workbench.frames.drives import ground_steps, impact_steps, static_steps
from workbench.frames.runs import (
    OPEN_LEDGER,
    run_ground_motion,
    run_impact,
    run_static,
)
from workbench.frames.structure import FrameStructure
from workbench.frames.timing import time_to_peak, wave_times
from workbench.responses import Response
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    Frame,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    frame_scenario,
)
from workbench.structures.impact import MOREAU

PUSH_PARTS = 1000  # load steps over the range of a static path
PEAK_STEPS = 150.0  # time steps up to the expected peak
LEAST_STEPS = 100.0  # of a record
FIRST_SPAN, LATER = 6.0, 4.0  # beyond so many times to the peak, so many times longer steps
WEIGHT = 0.5  # conserves energy
COLUMN_HINGES = ("base", "hit-below", "hit-above", "head")


def answer(
    scenario: FrameScenario | ColumnScenario,
    build: Callable[[Frame], FrameStructure],
    integrator: str,
    time_step: float | None,
) -> Response:
    """Answer a scenario of a frame, or of a column seen as one.

    Arguments: `build` stands the frame up under its dead loads; `integrator`; `time_step` in s
    (None: by rule). Raises `SolverError`, `OutOfDomainError`.
    """
    if isinstance(scenario, ColumnImpact | ColumnPushover):
        return _answer_column(scenario, build, integrator, time_step)
    return _answer_frame(scenario, build, integrator, time_step)


def _answer_frame(
    scenario: FrameScenario,
    build: Callable[[Frame], FrameStructure],
    integrator: str,
    time_step: float | None,
) -> Response:
    with threadpool_limits(1, user_api="blas"):  # band solves are far too small for threads
        structure = build(scenario.frame)
        started = perf_counter()
        if isinstance(scenario, FrameStatic):
            pushed = static_steps(scenario, structure, PUSH_PARTS)
            response = run_static(scenario, structure, pushed)
        elif isinstance(scenario, FrameImpact):
            parts = structure.elements // len(scenario.frame.members)
            spans = time_spans(scenario, parts, time_step)
            steps = impact_steps(scenario, structure, spans, WEIGHT, integrator)
            largest = None if integrator == MOREAU else OPEN_LEDGER
            response = run_impact(scenario, structure, steps, largest_error=largest)
        else:
            shaken = ground_steps(scenario, structure, time_step, WEIGHT)
            response = run_ground_motion(scenario, structure, shaken)
        response.attrs["solve_time"] = perf_counter() - started
    return response


def time_spans(
    scenario: FrameImpact, parts: int, time_step: float | None
) -> list[tuple[float, float]]:
    """End times and time steps (s) of the parts of the record.

    Arguments: `parts` of every member; `time_step` in s (None: by rule). Steps longer than a wave
    takes along an element and back make its hinges ring, which softens them artificially. Rebounds
    need half the step.
    """
    duration = scenario.duration
    if time_step is not None:
        return [(duration, time_step)]
    peak = time_to_peak(scenario)
    coarsest = min(duration / LEAST_STEPS, 2.0 * min(wave_times(scenario.frame)) / parts)
    first = min(coarsest, peak / PEAK_STEPS)
    later = min(coarsest, LATER * first)
    share = 1.0 if scenario.striker.restitution == 0.0 else 0.5
    return [(min(FIRST_SPAN * peak, duration), share * first), (duration, share * later)]


def _answer_column(
    scenario: ColumnScenario,
    build: Callable[[Frame], FrameStructure],
    integrator: str,
    time_step: float | None,
) -> Response:
    """The answer of the column's frame in the words of a column.

    The strike flies along +x and the column goes up, so that moments are those of a frame with
    the opposite sign: positive at the base.
    """

    def column(frame: Frame) -> FrameStructure:
        structure = build(frame)
        head = structure.dof("head", "-y")
        return replace(structure, watched={"shortening": head})

    response = _answer_frame(frame_scenario(scenario), column, integrator, time_step)
    for name in ("moment", "plastic_rotation"):
        response[name].values *= -1.0
    return response.assign_coords(
        hinge=response["hinge"].copy(data=list(COLUMN_HINGES)),
    )
