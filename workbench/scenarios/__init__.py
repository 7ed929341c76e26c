"""What happens, independent of any model: frozen value objects, TOML in and out."""

from workbench.scenarios.column import Column, ColumnImpact, ColumnPushover, Striker
from workbench.scenarios.column_as_frame import frame_of, frame_scenario
from workbench.scenarios.files import (
    ColumnScenario,
    FrameScenario,
    Scenario,
    canonical,
    load_scenario,
    parse_value,
    scenario_from,
    scenario_hash,
    to_tables,
    to_toml,
)
from workbench.scenarios.frame import Frame
from workbench.scenarios.frame_events import (
    FrameGroundMotion,
    FrameImpact,
    FrameStatic,
    FrameStriker,
    cyclic_path,
)
from workbench.scenarios.frame_forms import regular_frame
from workbench.scenarios.frame_parts import Joint, Load, Member, Node
from workbench.scenarios.members import MemberProperties
from workbench.scenarios.stud import StudTests

__all__ = [
    "Column",
    "ColumnImpact",
    "ColumnPushover",
    "ColumnScenario",
    "Frame",
    "FrameGroundMotion",
    "FrameImpact",
    "FrameScenario",
    "FrameStatic",
    "FrameStriker",
    "Joint",
    "Load",
    "Member",
    "MemberProperties",
    "Node",
    "Scenario",
    "Striker",
    "StudTests",
    "canonical",
    "cyclic_path",
    "frame_of",
    "frame_scenario",
    "load_scenario",
    "parse_value",
    "regular_frame",
    "scenario_from",
    "scenario_hash",
    "to_tables",
    "to_toml",
]
