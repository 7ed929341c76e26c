"""Frames of regular form, and a column seen as a frame."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from workbench.fields import Choice, Instance, Numbers
from workbench.materials import Steel
from workbench.scenarios.column import Column, ColumnImpact, ColumnPushover
from workbench.scenarios.frame import Frame
from workbench.scenarios.frame_events import FrameImpact, FrameStatic, FrameStriker
from workbench.scenarios.frame_parts import RIGID, Joint, Load, Member, Node
from workbench.scenarios.members import LENGTH
from workbench.sections import Section

SPANS = Numbers(LENGTH, 1, 100)
BASES = Choice(("clamped", "pinned"))
HEADS = {"guided": "guide-y", "pinned": "roller-y", "fixed": "guide-y"}
OVERRIDES = ("area", "second_moment", "plastic_moment", "squash_load", "mass_per_length")


def regular_frame(
    bays: Sequence[float],
    storeys: Sequence[float],
    column: Section,
    beam: Section,
    base: str = "clamped",
    steel: Steel | None = None,
    fillets: bool = True,
    beam_joint: str | Joint = RIGID.name,
    joints: Sequence[Joint] = (),
) -> Frame:
    """A frame of columns on axes A, B, ... and of beams on every level above the ground.

    Arguments: widths of the `bays` from the left and heights of the `storeys` from the ground, in
    m; sections; `base`, clamped or pinned; `beam_joint` at both ends of every beam, a joint or the
    name of one of `joints`, rigid or pinned. Nodes are named A0, B0, ..., A1, ... (axis and level),
    columns A0-A1 (from the bottom to the top), beams A1-B1 (from the left to the right).
    Raises `InputError`.
    """
    widths, heights = SPANS.check("frame.bays", bays), SPANS.check("frame.storeys", storeys)
    support = BASES.check("frame.base", base)
    for name, section in (("column", column), ("beam", beam)):
        Instance(Section, "use sections.find(name)").check(f"frame.{name}", section)
    axes = [_letters(i) for i in range(len(widths) + 1)]
    levels = range(len(heights) + 1)
    nodes = tuple(
        Node(
            f"{axis}{level}",
            sum(widths[:i]),
            sum(heights[:level]),
            support="free" if level else support,
        )
        for level in levels
        for i, axis in enumerate(axes)
    )

    if isinstance(beam_joint, Joint):
        joints, beam_joint = (*joints, beam_joint), beam_joint.name

    def member(start: str, end: str, section: Section, joint: str = RIGID.name) -> Member:
        return Member(f"{start}-{end}", start, end, section, joint_start=joint, joint_end=joint)

    columns = [
        member(f"{axis}{level}", f"{axis}{level + 1}", column)
        for axis in axes
        for level in levels[:-1]
    ]
    beams = [
        member(f"{left}{level}", f"{right}{level}", beam, beam_joint)
        for level in levels[1:]
        for left, right in pairwise(axes)
    ]
    given = Steel() if steel is None else steel
    return Frame(nodes, (*columns, *beams), joints=tuple(joints), steel=given, fillets=fillets)


def frame_of(column: Column) -> Frame:
    """A column as a frame: nodes base, hit and head, members below and above the hit point.

    Its axial load is a dead load on the head, its restraint a spring there. Members carry their
    own mass: a column's `impact_mass`, meant for lumped models, has no place in a frame.
    """
    nodes = (
        Node("base", 0.0, 0.0, support=column.base),
        Node("hit", 0.0, column.length_below),
        Node(
            "head",
            0.0,
            column.length,
            support=HEADS[column.head],
            mass=column.head_mass,
            spring_y=column.restraint_stiffness,
            locked="y" if column.head == "fixed" else "none",
        ),
    )
    own = {name: getattr(column, name) for name in OVERRIDES}
    members = (
        Member("below", "base", "hit", column.section, **own),
        Member("above", "hit", "head", column.section, **own),
    )
    loads = (Load("head", y=-column.axial_load),) if column.axial_load else ()
    return Frame(nodes, members, loads, steel=column.steel, fillets=column.fillets)


def frame_scenario(scenario: ColumnPushover | ColumnImpact) -> FrameStatic | FrameImpact:
    """What happens to a column as what happens to its frame; forces and strikes along +x."""
    frame = frame_of(scenario.column)
    if isinstance(scenario, ColumnPushover):
        pattern = (Load("hit", x=1.0),)
        return FrameStatic(
            scenario.name, frame, pattern, "hit", "x", (scenario.displacement,), "displacement"
        )
    striker = FrameStriker(
        scenario.striker.mass,
        scenario.striker.velocity,
        scenario.striker.restitution,
        node="hit",
        direction="+x",
    )
    return FrameImpact(scenario.name, frame, striker, scenario.duration)


def _letters(number: int) -> str:
    """A to Z, then AA, AB and so on."""
    letters = ""
    number += 1
    while number:
        number, rest = divmod(number - 1, 26)
        letters = chr(ord("A") + rest) + letters
    return letters
