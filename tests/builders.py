"""Structures that many tests share."""

from __future__ import annotations

from dataclasses import replace

from workbench.scenarios import Frame, Joint, Load, regular_frame
from workbench.sections import Section, square

SQUARE = square(0.2)


def portal(
    *joints: Joint,
    section: Section = SQUARE,
    height: float = 4.0,
    base: str = "clamped",
    loads: tuple[Load, ...] = (),
    **members: object,
) -> Frame:
    """One bay of 6 m and one storey: columns A0-A1 and B0-B1, beam A1-B1, all of one section.

    Arguments: `joints`, of which the first stands at both ends of the beam; `section`; `height`
    in m; `base`, clamped or pinned; dead `loads`; `members`, overrides of every member.
    """
    frame = regular_frame((6.0,), (height,), section, section, base=base)
    parts = [replace(member, **members) for member in frame.members]
    if joints:
        name = joints[0].name
        parts[2] = replace(parts[2], joint_start=name, joint_end=name)
    own = tuple(joint for joint in joints if joint.name not in ("rigid", "pinned"))
    return replace(frame, members=tuple(parts), joints=own, loads=loads)
