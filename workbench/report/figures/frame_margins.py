"""Around a frame on paper: dimension lines, cross sections, the meaning of symbols."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes

from workbench.content.formatting import TIMES, brief
from workbench.report.figures.frame_layout import Layout, Point
from workbench.report.figures.frame_picture import TINTS, joint_mark, sections_of
from workbench.report.figures.pieces import SMALL, cross_section, dimension
from workbench.report.figures.style import MUTED
from workbench.scenarios import Frame

_TICK, _ROW = 0.03, 0.38
_MOST_SPANS = 8
_LINE = 14  # characters of a section's name
_MOST_SECTIONS = len(TINTS)


def draw_dimensions(panel: Axes, layout: Layout, further: Sequence[str], corner: Point) -> Point:
    """Bays below and storeys on the right, with the heights of `further` nodes nearer.

    `corner`: right and lower end of what is drawn already. Returns that of the dimensions.
    """
    right, low = corner
    for chain in _chains(layout, "y", further):
        right += _ROW
        for a, b, text in _spans(chain):
            base = layout.origin[1]
            ends = (a - base) * layout.scale, (b - base) * layout.scale
            dimension(panel, (right, ends[0]), (right, ends[1]), text, tick=_TICK)
    for chain in _chains(layout, "x", further):
        low -= _ROW
        for a, b, text in _spans(chain):
            base = layout.origin[0]
            ends = (a - base) * layout.scale, (b - base) * layout.scale
            dimension(panel, (ends[0], low), (ends[1], low), text, tick=_TICK)
    return right, low


def _chains(layout: Layout, axis: str, further: Sequence[str]) -> list[list[float]]:
    """Chains of levels from the inner to the outer: with `further` nodes, without, overall."""
    main, fine = layout.levels(axis), layout.levels(axis, further)
    found = [fine] if len(fine) > len(main) else []
    if len(main) > 1:
        found.append(main)
    if 3 < len(main) <= _MOST_SPANS + 1:  # longer chains say it themselves
        found.append([main[0], main[-1]])
    return found


def _spans(levels: Sequence[float]) -> list[tuple[float, float, str]]:
    pairs = list(itertools.pairwise(levels))
    if len(pairs) <= _MOST_SPANS:
        return [(a, b, f"{brief(b - a)} m") for a, b in pairs]
    each = {f"{brief(b - a)}" for a, b in pairs}
    whole = f"{brief(levels[-1] - levels[0])} m"
    text = f"{len(pairs)} {TIMES} {each.pop()} m = {whole}" if len(each) == 1 else whole
    return [(levels[0], levels[-1], text)]


def draw_sections(panel: Axes, frame: Frame, corner: Point) -> list[str]:
    """Cross sections, enlarged to one scale, and joints, below the upper left `corner`.

    Returns sentences on what has no room.
    """
    left, high = corner
    sections = sections_of(frame)
    shown = sections[:_MOST_SECTIONS]
    scale = 0.62 / max(max(s.height, s.width) for s in shown)
    for i, section in enumerate(shown):
        h, b = section.height * scale, section.width * scale
        high -= 0.2
        centre, y = left + b / 2, high - h / 2
        cross_section(panel, section, (centre, y), scale, TINTS[i])
        right = centre + b / 2 + 0.09
        text = f"{brief(1e3 * section.height)} mm"
        dimension(panel, (right, y - h / 2), (right, y + h / 2), text, tick=_TICK)
        over = y + h / 2 + 0.09
        text = f"{brief(1e3 * section.width)} mm"
        dimension(panel, (centre - b / 2, over), (centre + b / 2, over), text, tick=_TICK)
        name = "\n".join(textwrap.wrap(section.name.replace(" x ", TIMES), _LINE))
        if len(sections) > 1:
            name += f"\n{_role(frame, i)}"
        if i == len(shown) - 1:
            name += f"\n{brief(frame.steel.yield_stress / 1e6)} MPa"
        look: dict[str, Any] = {"fontsize": SMALL, "va": "top", "linespacing": 1.4}
        panel.text(left, y - h / 2 - 0.06, name, **look)
        high = y - h / 2 - 0.1 - 0.14 * (name.count("\n") + 1) - 0.12
    for joint in _joints(frame):
        joint_mark(panel, (left + 0.1, high), joint)
        text = "pinned joint" if joint == "pinned" else f"joint {joint}"
        panel.text(left + 0.24, high, text, fontsize=SMALL, va="center", color=MUTED)
        high -= 0.19
    said = [_joint_words(frame, joint) for joint in _joints(frame) if joint != "pinned"]
    if len(sections) > len(shown):
        said.append(f"Shown are the first {len(shown)} of {len(sections)} sections.")
    return said


def _role(frame: Frame, number: int) -> str:
    """What the members of a section are: columns, beams, or members."""
    sections = list(dict.fromkeys(member.section for member in frame.members))
    upright = set()
    for member in frame.members:
        if member.section == sections[number]:
            start, end = frame.node(member.start), frame.node(member.end)
            upright.add("columns" if abs(end.y - start.y) > abs(end.x - start.x) else "beams")
    return upright.pop() if len(upright) == 1 else "columns and beams"


def _joints(frame: Frame) -> list[str]:
    names = [joint for m in frame.members for joint in (m.joint_start, m.joint_end)]
    return [joint for joint in dict.fromkeys(names) if joint != "rigid"]


def _joint_words(frame: Frame, name: str) -> str:
    joint = frame.joint(name)
    facts = []
    if joint.rotational_stiffness is not None:
        facts.append(f"rotational stiffness {brief(joint.rotational_stiffness / 1e3)} kN m/rad")
    if joint.axial_stiffness is not None:
        facts.append(f"axial stiffness {brief(joint.axial_stiffness / 1e6)} kN/mm")
    sagging, hogging = joint.plastic_moment, joint.plastic_moment_negative
    if sagging is not None:
        facts.append(f"plastic moment {brief(sagging / 1e3)} kN m")
    if hogging is not None:
        facts.append(f"{brief(hogging / 1e3)} kN m where moments are negative")
    for value, what in (
        (joint.tension_resistance, "tension"),
        (joint.compression_resistance, "compression"),
    ):
        if value is not None:
            facts.append(f"resistance in {what} {brief(value / 1e3)} kN")
    return f"Joint {name}: {', '.join(facts) or 'as the member'}."
