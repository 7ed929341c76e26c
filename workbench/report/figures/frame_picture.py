"""A frame on paper: members, joints, supports, springs, masses and dead loads. Units: inches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from workbench.content.formatting import brief
from workbench.report.figures.frame_layout import Layout, Point
from workbench.report.figures.pieces import (
    DOWN,
    LEFT,
    RIGHT,
    SMALL,
    arrow,
    ground,
    guide,
    hinge_support,
    note,
    roller,
    spiral,
    spring,
    turning,
)
from workbench.report.figures.style import INK, MUTED, PALETTE
from workbench.scenarios import Frame, Load, Member, Node
from workbench.sections import Section

TINTS = ("#b9c4cf", "#e3cfa8", "#a9cdb9", "#d9b8cc")  # one per section
DEAD = PALETTE[1]
ARROW = 0.38  # length
_SUPPORT, _GAP = 0.34, 0.06
_MANY = 4  # equal loads or masses beyond this share one label
_MOST_NAMES = 24


def sections_of(frame: Frame) -> list[Section]:
    """The different sections of a frame, as their strength is counted, in order."""
    found: dict[Section, Section] = {}
    for member in frame.members:
        found.setdefault(member.section, frame.strength_section(member))
    return list(found.values())


def tints_of(frame: Frame) -> dict[Section, str]:
    """The colour of the members of each section."""
    different = dict.fromkeys(member.section for member in frame.members)
    return {section: TINTS[i % len(TINTS)] for i, section in enumerate(different)}


def draw_frame(panel: Axes, layout: Layout, named: Sequence[str] = ()) -> None:
    """Draw the frame at rest; nodes in `named` get their names even where there are many."""
    tints = tints_of(layout.frame)
    for member in layout.frame.members:
        _member(panel, layout, member, tints[member.section])
        for node, joint in ((member.start, member.joint_start), (member.end, member.joint_end)):
            if joint != "rigid":
                joint_mark(panel, _joint_place(layout, member, node), joint)
    for place in layout.frame.nodes:
        _support(panel, layout, place)
        _springs(panel, layout, place)
    _masses(panel, layout)
    _dead_loads(panel, layout)
    many = len(layout.frame.nodes) > _MOST_NAMES
    for place in layout.frame.nodes:
        if not many or place.name in named:
            _name(panel, layout, place)


def _member(panel: Axes, layout: Layout, member: Member, color: str) -> None:
    start, end = np.array(layout.at(member.start)), np.array(layout.at(member.end))
    along = np.array(layout.along(member))
    across = np.array([-along[1], along[0]]) * 0.5 * layout.depth(member)
    # members meet in full corners
    start = start - along * layout.half_depth(member.start, (along[0], along[1]))
    end = end + along * layout.half_depth(member.end, (along[0], along[1]))
    corners = [start - across, start + across, end + across, end - across]
    outline = np.array(corners).tolist()
    # the face hides the outlines of members that pass through it: what is left is the contour
    panel.add_patch(Polygon(outline, facecolor=INK, edgecolor=INK, lw=1.6, zorder=1.5))
    panel.add_patch(Polygon(outline, facecolor=color, edgecolor="none", zorder=1.6))


def _joint_place(layout: Layout, member: Member, node: str) -> Point:
    x, y = layout.at(node)
    away = next(away for found, away in layout.members_at[node] if found is member)
    shift = layout.half_depth(node, away) + _GAP
    return x + shift * away[0], y + shift * away[1]


def joint_mark(panel: Axes, at: Point, joint: str) -> None:
    """A white circle for a pinned joint, a diamond for one with properties of its own."""
    if joint == "pinned":
        panel.add_patch(Circle(at, 0.042, facecolor="white", edgecolor=INK, lw=1.0, zorder=4))
        return
    x, y = at
    r = 0.055
    corners = [(x - r, y), (x, y + r), (x + r, y), (x, y - r)]
    panel.add_patch(Polygon(corners, facecolor="white", edgecolor=INK, lw=1.0, zorder=4))


def _support(panel: Axes, layout: Layout, node: Node) -> None:
    at, kind = layout.at(node.name), node.support
    if kind == "clamped":
        ground(panel, at, layout.outward(node.name), 1.2 * _SUPPORT)
    elif kind == "pinned":
        hinge_support(panel, at, layout.outward(node.name, "y"), _SUPPORT)
    elif kind.startswith("roller"):
        out = layout.outward(node.name, "y" if kind == "roller-x" else "x")
        if out in (LEFT, RIGHT):
            half = layout.half_depth(node.name, out)
            roller(panel, (at[0] + out[0] * half, at[1]), out, _SUPPORT)
        else:
            hinge_support(panel, at, out, _SUPPORT, rolls=True)
    elif kind.startswith("guide"):
        out = layout.outward(node.name, kind[-1])
        guide(panel, at, out, layout.half_depth(node.name, (-out[1], out[0])), _SUPPORT)
    if node.locked != "none":
        out = layout.outward(node.name, node.locked)
        half = layout.half_depth(node.name, out) + 0.03
        x, y = at[0] + half * out[0], at[1] + half * out[1]
        ground(panel, (x, y), out, 1.2 * _SUPPORT)
        note(panel, (x + 0.26 - 0.2 * abs(out[0]), y + 0.12 * out[1]), "held once loaded", MUTED)


def _springs(panel: Axes, layout: Layout, node: Node) -> None:
    x, y = layout.at(node.name)
    for axis, stiffness in (("x", node.spring_x), ("y", node.spring_y)):
        if not stiffness:
            continue
        out = layout.outward(node.name, axis)
        half = layout.half_depth(node.name, out)
        # aside of supports and loads, which stand in line with the node
        aside = 0.2 if axis == "y" and (node.support != "free" or _loaded(layout, node)) else 0.0
        start = (x + aside + half * out[0], y + half * out[1])
        end = (start[0] + 0.6 * out[0], start[1] + 0.6 * out[1])
        if aside:
            panel.plot([x, start[0]], [start[1], start[1]], color=INK, linewidth=1.0)
        spring(panel, start, end, 0.13)
        ground(panel, end, out, 0.9 * _SUPPORT)
        middle = (start[0] + 0.3 * out[0], start[1] + 0.3 * out[1])
        shift = (0.12, 0.0) if axis == "y" else (0.0, 0.16)
        where = {"ha": "left" if axis == "y" else "center"}
        text = f"{brief(stiffness / 1e6)} kN/mm"
        note(panel, (middle[0] + shift[0], middle[1] + shift[1]), text, **where)
    if node.spring_rotation:
        spiral(panel, (x, y), 0.2)
        low = layout.half_depth(node.name, DOWN)
        right = layout.half_depth(node.name, RIGHT)
        note(
            panel,
            (x + right + 0.05, y - low - 0.23),
            f"{brief(node.spring_rotation / 1e3)} kN m/rad",
        )


def _loaded(layout: Layout, node: Node) -> bool:
    return any(load.node == node.name for load in layout.frame.loads)


def _masses(panel: Axes, layout: Layout) -> None:
    heavy = [node for node in layout.frame.nodes if node.mass or node.rotary_inertia]
    alike = len({(node.mass, node.rotary_inertia) for node in heavy}) == 1 and len(heavy) > _MANY
    for node in heavy:
        x, y = layout.at(node.name)
        panel.add_patch(
            Circle(
                (x, y), 0.075 * layout.small, facecolor=INK, edgecolor="white", lw=0.6, zorder=4.5
            )
        )
        if alike and node is not heavy[0]:
            continue
        text = f"{brief(node.mass)} kg" if node.mass else ""
        if node.rotary_inertia:
            text += f"{', ' if text else ''}{brief(node.rotary_inertia)} kg m²"
        # left of and below the node: loads, their values and the node's name stand elsewhere
        at = (x - layout.half_depth(node.name, LEFT) - 0.05, y - 0.21)
        note(panel, at, f"each {text}" if alike else text, ha="right")


def _dead_loads(panel: Axes, layout: Layout) -> None:
    loads = layout.frame.loads
    alike = len({(load.x, load.y, load.moment) for load in loads}) == 1 and len(loads) > _MANY
    highest = max(loads, key=lambda load: layout.at(load.node)[1], default=None)
    for load in loads:
        words = "" if alike and load is not highest else "each {}" if alike else "{}"
        load_arrows(panel, layout, load, DEAD, words)


def load_arrows(
    panel: Axes, layout: Layout, load: Load, color: str, words: str = "{}", away: float = 0.0
) -> None:
    """Arrows of a load on its node; `words` are written around each value (empty: no text).

    `away`: how far from the node they end.
    """
    x, y = layout.at(load.node)
    for value, axis in ((load.x, (1.0, 0.0)), (load.y, (0.0, 1.0))):
        if not value:
            continue
        sign = np.sign(value)
        dx, dy = sign * axis[0], sign * axis[1]
        gap = layout.half_depth(load.node, (dx, dy)) + 0.01 + away
        end = (x - gap * dx, y - gap * dy)
        length = ARROW * layout.small
        start = (end[0] - length * dx, end[1] - length * dy)
        arrow(panel, start, end, color)
        text = words.format(f"{brief(abs(value) / 1e3)} kN")
        if dy:
            left = layout.frame.node(load.node).spring_y > 0.0  # the spring stands on the right
            # a value that stands for all arrows has its place above the highest one
            high = 0.1 if words.startswith("each") else 0.07 * dy
            at = (start[0] + (-0.06 if left else 0.06), start[1] + high)
            note(panel, at, text, color, ha="right" if left else "left")
        else:
            middle = 0.5 * (start[0] + end[0]) - 0.1 * dx
            note(panel, (middle, start[1] + 0.1), text, color, ha="center")
    if load.moment:
        turning(panel, (x, y), 0.3, color, counterclockwise=load.moment > 0.0)
        text = words.format(f"{brief(abs(load.moment) / 1e3)} kN m")
        note(panel, (x + 0.2, y + 0.14), text, color)


def _name(panel: Axes, layout: Layout, node: Node) -> None:
    x, y = layout.at(node.name)
    half = layout.half_depth(node.name, RIGHT)
    low = layout.half_depth(node.name, DOWN)
    below = node.support == "free" or layout.outward(node.name) != DOWN
    rolls = node.support == "roller-y" and layout.outward(node.name, "x") == RIGHT
    beside = 0.26 if rolls or node.support.startswith("guide") else 0.05
    at = (x + half + beside, y - low - 0.08 if below else y + 0.09)
    panel.text(*at, node.name, fontsize=SMALL - 1.0, color=MUTED, va="center", zorder=3)
