"""A column seen as a frame of two members, the only way in which models of frames see one."""

from dataclasses import replace
from functools import lru_cache

from workbench.scenarios.column import Column, ColumnImpact, ColumnPushover
from workbench.scenarios.frame import Frame
from workbench.scenarios.frame_events import FrameImpact, FramePulse, FrameStatic, FrameStriker
from workbench.scenarios.frame_parts import Load, Member, Node
from workbench.scenarios.members import OVERRIDES
from workbench.scenarios.pulse import UNIFORM, MemberPulse

HEADS = {"guided": "guide-y", "pinned": "roller-y", "fixed": "guide-y"}


@lru_cache(maxsize=64)
def frame_of(column: Column) -> Frame:
    """A column as a frame: nodes base, hit and head, members below and above the hit point.

    Its axial load is a dead load on the head, its restraint a spring there. Members carry their
    own mass: a column's `impact_mass`, meant for lumped models, has no place in a frame.
    """
    head = Node("head", 0.0, column.length, HEADS[column.head], column.head_mass)
    locked = "y" if column.head == "fixed" else "none"
    head = replace(head, spring_y=column.restraint_stiffness, locked=locked)
    base, hit = Node("base", 0.0, 0.0, column.base), Node("hit", 0.0, column.length_below)
    own = {name: getattr(column, name) for name in OVERRIDES}
    members = (
        Member("below", "base", "hit", column.section, **own),
        Member("above", "hit", "head", column.section, **own),
    )
    loads = (Load("head", y=-column.axial_load),) if column.axial_load else ()
    return Frame((base, hit, head), members, loads, steel=column.steel, fillets=column.fillets)


@lru_cache(maxsize=64)
def frame_scenario(
    scenario: ColumnPushover | ColumnImpact | MemberPulse,
) -> FrameStatic | FrameImpact | FramePulse:
    """What happens to a column as what happens to its frame; forces and strikes along +x."""
    frame, name = frame_of(scenario.column), scenario.name
    if isinstance(scenario, ColumnImpact):
        own = scenario.striker
        striker = FrameStriker(own.mass, own.velocity, own.restitution, node="hit", direction="+x")
        return FrameImpact(name, frame, striker, scenario.duration)
    pattern = (Load("hit", x=1.0),)
    if isinstance(scenario, ColumnPushover):
        path = (scenario.displacement,)
        return FrameStatic(name, frame, pattern, "hit", "x", path, "displacement")
    pulse = FramePulse(
        name, frame, scenario.pulse, "hit", "+x", pattern, duration=scenario.duration
    )
    if scenario.load == UNIFORM:
        pulse = replace(pulse, loads=(), members=("below", "above"))
    return pulse
