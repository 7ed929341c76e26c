"""A frame on paper, in inches: members, supports, dead loads, and the actions of scenarios."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes

from workbench.report.drawing import symbols
from workbench.report.drawing.layout import Layout, displacement_unit
from workbench.report.drawing.sheet import first
from workbench.report.drawing.style import INK, MUTED, PALETTE, Style
from workbench.report.drawing.symbols import DOWN, LEFT, LIGHT, RIGHT, arrow, face, note
from workbench.report.page.formatting import MINUS, NO_BREAK, Unit, brief, count
from workbench.scenarios import (
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameScenario,
    FrameStatic,
    Load,
    Member,
    Node,
)

TINTS = ("#b9c4cf", "#e3cfa8", "#a9cdb9", "#d9b8cc")  # one per section
ACTION, DEAD = PALETTE[:2]
ARROW = 0.38  # length
_SUPPORT, _GAP, _DIAMOND = 0.34, 0.06, 0.055
_ALONG = (0.1, 0.3, 0.5, 0.7, 0.9)  # of a member, where arrows of a line load stand
_MANY = 4  # equal loads or masses beyond this share one label
_MOST_NAMES = 24
_MOST = 3  # different places that are hit
_BOX, _WAY = 0.3, 0.42
_DOT: Style = {"facecolor": INK, "edgecolor": "white", "linewidth": 0.6}
DIRECTIONS = {"+x": 1.0 + 0j, "-x": -1.0 + 0j, "+y": 1j, "-y": -1j}


def draw_frame(panel: Axes, layout: Layout, named: Sequence[str] = ()) -> None:
    """Draw the frame at rest; nodes in `named` get their names even where there are many."""
    frame = layout.frame
    sections = list(dict.fromkeys(member.section for member in frame.members))
    for member in frame.members:
        _member(panel, layout, member, TINTS[sections.index(member.section) % len(TINTS)])
        along = layout.along(member)
        ends = (member.start, member.joint_start, along), (member.end, member.joint_end, -along)
        for node, joint, away in ends:
            if joint != "rigid":
                joint_mark(panel, layout.edge(node, away, _GAP), joint)
    for place in frame.nodes:
        _support(panel, layout, place)
        _springs(panel, layout, place)
        if len(frame.nodes) <= _MOST_NAMES or place.name in named:
            _name(panel, layout, place)
    _masses(panel, layout)
    alike = len({(load.x, load.y, load.moment) for load in frame.loads}) == 1
    alike &= len(frame.loads) > _MANY
    highest = max(frame.loads, key=lambda load: layout.at(load.node).imag, default=None)
    for load in frame.loads:
        template = "" if alike and load is not highest else "each {}" if alike else "{}"
        load_arrows(panel, layout, load, DEAD, template)


def _member(panel: Axes, layout: Layout, member: Member, color: str) -> None:
    along = layout.along(member)
    across = 0.5j * along * layout.depth(member)
    # members meet in full corners
    start, end = layout.edge(member.start, -along), layout.edge(member.end, along)
    outline = [start - across, start + across, end + across, end - across]
    # the face hides the outlines of members that pass through it: what is left is the contour
    face(panel, outline, 1.5, facecolor=INK, linewidth=1.6)
    face(panel, outline, 1.6, facecolor=color, edgecolor="none")


def joint_mark(panel: Axes, at: complex, joint: str) -> None:
    """Draw a white circle for a pinned joint, a diamond for one with declared properties."""
    if joint == "pinned":
        symbols.circle(panel, at, 0.042, 4)
    else:
        face(panel, at + _DIAMOND * np.array([-1.0, 1j, 1.0, -1j]), 4)


def _support(panel: Axes, layout: Layout, node: Node) -> None:
    at, kind, name = layout.at(node.name), node.support, node.name
    if kind == "clamped":
        symbols.ground(panel, at, layout.outward(name), 1.2 * _SUPPORT)
    elif kind == "pinned":
        symbols.hinge_support(panel, at, layout.outward(name, "y"), _SUPPORT, rolls=False)
    elif kind.startswith("roller"):
        out = layout.outward(name, "y" if kind == "roller-x" else "x")
        if out.imag:
            symbols.hinge_support(panel, at, out, _SUPPORT, rolls=True)
        else:
            symbols.roller(panel, layout.edge(name, out), out, _SUPPORT)
    elif kind.startswith("guide"):
        out = layout.outward(name, kind[-1])
        symbols.guide(panel, at, out, layout.half_depth(name, 1j * out), _SUPPORT)
    if node.locked != "none":
        out = layout.outward(name, node.locked)
        end = layout.edge(name, out, 0.03)
        symbols.ground(panel, end, out, 1.2 * _SUPPORT)
        beside = complex(0.26 - 0.2 * abs(out.real), 0.12 * out.imag)
        note(panel, end + beside, "held once loaded", MUTED)


def _springs(panel: Axes, layout: Layout, node: Node) -> None:
    at, loaded = layout.at(node.name), any(load.node == node.name for load in layout.frame.loads)
    for axis, stiffness in (("x", node.spring_x), ("y", node.spring_y)):
        if not stiffness:
            continue
        out = layout.outward(node.name, axis)
        # aside of supports and loads, which stand in line with the node
        aside = 0.2 if axis == "y" and (node.support != "free" or loaded) else 0.0
        start = layout.edge(node.name, out) + aside
        end = start + 0.6 * out
        if aside:
            symbols.line(panel, [complex(at.real, start.imag), start])
        symbols.spring(panel, start, end, 0.13)
        symbols.ground(panel, end, out, 0.9 * _SUPPORT)
        beside, side = (0.12, "left") if axis == "y" else (0.16j, "center")
        text = f"{brief(stiffness / 1e6)} kN/mm"
        note(panel, 0.5 * (start + end) + beside, text, ha=side)
    if node.spring_rotation:
        symbols.spiral(panel, at, 0.2)
        text = f"{brief(node.spring_rotation / 1e3)} kN m/rad"
        note(panel, _lower_right(layout, node.name) + 0.05 - 0.23j, text)


def _lower_right(layout: Layout, node: str) -> complex:
    """The corner of the members at a node."""
    right, low = layout.half_depth(node, RIGHT), layout.half_depth(node, DOWN)
    return layout.at(node) + complex(right, -low)


def _masses(panel: Axes, layout: Layout) -> None:
    heavy = [node for node in layout.frame.nodes if node.mass or node.rotary_inertia]
    alike = len({(node.mass, node.rotary_inertia) for node in heavy}) == 1 and len(heavy) > _MANY
    for node in heavy:
        symbols.circle(panel, layout.at(node.name), 0.075 * layout.small, 4.5, **_DOT)
        if alike and node is not heavy[0]:
            continue
        values = ((node.mass, "kg"), (node.rotary_inertia, "kg m²"))
        text = ", ".join(f"{brief(value)} {unit}" for value, unit in values if value)
        # left of and below the node: loads, their values and the node's name stand elsewhere
        at = layout.edge(node.name, LEFT, 0.05) - 0.21j
        note(panel, at, f"each {text}" if alike else text, ha="right")


def load_arrows(
    panel: Axes, layout: Layout, load: Load, color: str, template: str = "{}", away: float = 0.0
) -> None:
    """Draw the arrows of a load on its node, `away` from it; `template` holds each value."""
    for value, axis in ((load.x, 1.0 + 0j), (load.y, 1j)):
        if not value:
            continue
        out = np.sign(value) * axis
        end = layout.edge(load.node, -out, 0.01 + away)
        start = end - ARROW * layout.small * out
        arrow(panel, start, end, color)
        text = template.format(f"{brief(abs(value) / 1e3)} kN")
        if out.imag:
            # the spring stands on the right
            left = layout.frame.node(load.node).spring_y > 0.0
            # a value that stands for all arrows has its place above the highest one
            high = 0.1 if template.startswith("each") else 0.07 * out.imag
            at = start + complex(-0.06 if left else 0.06, high)
            note(panel, at, text, color, ha="right" if left else "left")
        else:
            note(panel, 0.5 * (start + end) - 0.1 * out + 0.1j, text, color, ha="center")
    if load.moment:
        at = layout.at(load.node)
        symbols.turning(panel, at, 0.3, color, counterclockwise=load.moment > 0.0)
        text = template.format(f"{brief(abs(load.moment) / 1e3)} kN m")
        note(panel, at + 0.2 + 0.14j, text, color)


def _name(panel: Axes, layout: Layout, node: Node) -> None:
    below = node.support == "free" or layout.outward(node.name) != DOWN
    rolls = node.support == "roller-y" and layout.outward(node.name, "x") == RIGHT
    corner, at = _lower_right(layout, node.name), layout.at(node.name)
    right = corner.real + (0.26 if rolls or node.support.startswith("guide") else 0.05)
    high = corner.imag - 0.08 if below else at.imag + 0.09
    look: Style = {"fontsize": symbols.SMALL - 1.0, "zorder": 3}
    note(panel, complex(right, high), node.name, MUTED, **look)


def draw_actions(panel: Axes, layout: Layout, scenarios: Sequence[FrameScenario]) -> list[str]:
    """Draw what the scenarios of one frame do to it; return sentences on what is not drawn.

    Strikers go before patterns of loads, patterns before the motion of the ground.
    """
    drawn: dict[type, Callable[..., list[str]]] = {
        FrameImpact: _strikers,
        FrameStatic: _pattern,
        FramePulse: _pulses,
        FrameGroundMotion: _motion,
    }
    kind = next(kind for kind in drawn if any(isinstance(s, kind) for s in scenarios))
    return drawn[kind](panel, layout, [s for s in scenarios if isinstance(s, kind)])


def targets(scenarios: Sequence[FrameScenario]) -> list[str]:
    """Nodes that are hit, or whose displacement is followed."""
    nodes = [s.striker.node if isinstance(s, FrameImpact) else s.node for s in scenarios]
    return list(dict.fromkeys(nodes))


def _strikers(panel: Axes, layout: Layout, impacts: Sequence[FrameImpact]) -> list[str]:
    strikers_at: dict[tuple[str, str], list[FrameImpact]] = {}
    for impact in impacts:
        place = impact.striker.node, impact.striker.direction
        strikers_at.setdefault(place, []).append(impact)
    notes: list[str] = []
    for node, direction in first(list(strikers_at), _MOST, "places that are hit", notes):
        strikers = [impact.striker for impact in strikers_at[node, direction]]
        along = DIRECTIONS[direction]
        end = layout.edge(node, -along, 0.01 + _beyond(layout, node, along))
        start = end - _WAY * along
        middle = start - 0.5 * _BOX * along
        corners = 0.5 * _BOX * np.array([-1.0 - 1j, 1.0 - 1j, 1.0 + 1j, -1.0 + 1j])
        face(panel, middle + corners, 5, facecolor=LIGHT, linewidth=0.9)
        arrow(panel, start, end, ACTION)
        beside = 0.23j if along.real else 0.2 + 0.07j
        side = "center" if along.real else "left"
        speeds = f"{_listed([s.velocity for s in strikers])} m/s"
        note(panel, middle + beside, speeds, ACTION, ha=side)
        masses = f"{_listed([s.mass for s in strikers])} kg"
        note(panel, middle + beside.conjugate(), masses, INK, ha=side)
    return notes


def _pattern(panel: Axes, layout: Layout, pushes: Sequence[FrameStatic]) -> list[str]:
    shown = pushes[0]
    alone = len(shown.loads) == 1
    for load in shown.loads:
        away = _beyond(layout, load.node, complex(load.x, load.y))
        load_arrows(panel, layout, load, ACTION, "λ P" if alone else "λ × {}", away)
    if not alone or shown.loads[0].node != shown.node:
        _ring(panel, layout, shown.node, "control" if shown.control != "load" else "displacement")
    notes = [f"{push.name}: {_path(push)}." for push in pushes]
    if any(push.loads != shown.loads for push in pushes):
        notes.append(f"Shown is the pattern of loads of {shown.name}; others differ.")
    if alone:
        kind = "force" if shown.loads[0].x or shown.loads[0].y else "moment"
        notes.insert(0, f"λ P is the {kind} that is sought.")
    return notes


def _path(push: FrameStatic) -> str:
    """Return the imposed displacements or load factors in words."""
    unit, what = displacement_unit(push), f"rotation of {push.node}"
    if not push.direction.endswith("rotation"):
        what = f"displacement of {push.node} along {push.direction.replace('-', MINUS)}"
    if push.control == "load":
        unit, what = Unit("", 1.0), "load factor λ"
    elif push.control == "arc-length":
        what = f"arc length until the {what}"
    values = [brief(unit.factor * value) for value in push.path]
    text = f"{NO_BREAK}{unit.text}" if unit.text else ""
    if len(values) == 1:
        return f"{what} to {values[0]}{text}"
    if len(values) <= 8:
        return f"{what} to {', '.join(values)}{text} in turn"
    low, high = values[int(np.argmin(push.path))], values[int(np.argmax(push.path))]
    return f"{what} through {count(len(values), 'target')} between {low} and {high}{text}"


def _pulses(panel: Axes, layout: Layout, pulses: Sequence[FramePulse]) -> list[str]:
    shown = pulses[0]
    for load in shown.loads:
        away = _beyond(layout, load.node, complex(load.x, load.y))
        load_arrows(panel, layout, load, ACTION, "p(t)", away)
    along = DIRECTIONS[shown.direction]
    for member in (layout.frame.member(name) for name in shown.members):
        start, end = layout.at(member.start), layout.at(member.end)
        for share in _ALONG:
            tip = start + share * (end - start) - (0.5 * layout.depth(member) + 0.01) * along
            arrow(panel, tip - 0.6 * ARROW * layout.small * along, tip, ACTION)
    _ring(panel, layout, shown.node, "displacement")
    on = f", a line load along {shown.direction} on {', '.join(shown.members)}"
    shapes = ", ".join(dict.fromkeys(each.pulse.shape for each in pulses))
    peaks = _listed([each.pulse.peak for each in pulses])
    unit = "N/m" if shown.members else "N"
    return [f"Pulses p(t), {shapes}, of at most {peaks} {unit}{on if shown.members else ''}."]


def _motion(panel: Axes, layout: Layout, motions: Sequence[FrameGroundMotion]) -> list[str]:
    shown, low = motions[0], -0.42j
    axis = 0.3j if shown.direction.endswith("y") else 0.3 + 0j
    arrow(panel, low - axis, low + axis, ACTION, "<|-|>")
    peaks = [float(f"{max(map(abs, motion.acceleration)):.3g}") for motion in motions]
    text = f"ground acceleration, at most {_listed(peaks)} m/s²"
    note(panel, low + axis.real + 0.08, text, ACTION)
    _ring(panel, layout, shown.node, "displacement")
    return []


def _beyond(layout: Layout, node: str, direction: complex) -> float:
    """Return the distance that the arrow of a dead load from the same side takes."""
    taken = any(
        dead.node == node and (dead.x * direction.real > 0.0 or dead.y * direction.imag > 0.0)
        for dead in layout.frame.loads
    )
    return 1.25 * ARROW * layout.small if taken else 0.0


def _ring(panel: Axes, layout: Layout, node: str, text: str) -> None:
    at = layout.at(node)
    symbols.circle(panel, at, 0.1, 6, facecolor="none", edgecolor=ACTION, linewidth=1.3)
    high = layout.half_depth(node, 1j)
    note(panel, at + complex(0.12, max(high + 0.09, 0.13)), text, ACTION)


def _listed(values: Sequence[float]) -> str:
    """Different values in words: all of a few, the range of many."""
    different = sorted(set(values))
    if len(different) > 4:
        return f"{brief(different[0])} to {brief(different[-1])}"
    return ", ".join(f"{brief(value)}" for value in different)
