"""Cases as frames: a column is the frame of its two segments."""

from __future__ import annotations

from workbench.content.formatting import Unit, unit_of
from workbench.scenarios import ColumnImpact, ColumnPushover, FrameScenario, frame_scenario
from workbench.study.definition import Case


def frame_scenario_of(case: Case) -> FrameScenario | None:
    """The scenario of a case on a frame; None if the case is about no frame or column."""
    scenario = case.scenario
    if isinstance(scenario, (ColumnImpact, ColumnPushover)):
        return frame_scenario(scenario)
    return scenario if isinstance(scenario, FrameScenario) else None


def displacement_unit(scenario: FrameScenario) -> Unit:
    """Display unit of the displacement that a scenario follows."""
    rotation = getattr(scenario, "direction", "").endswith("rotation")
    return Unit("rad", 1.0) if rotation else unit_of("displacement")
