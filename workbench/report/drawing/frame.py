"""A frame on paper, in inches: members, supports and loads, and what happens to it."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import MINUS, NO_BREAK, Unit, brief, count
from workbench.report.drawing import symbols
from workbench.report.drawing.layout import Layout, displacement_unit
from workbench.report.drawing.sheet import first
from workbench.report.drawing.style import INK, MUTED, PALETTE, Style
from workbench.report.drawing.symbols import LIGHT, arrow, circle, face, note
from workbench.scenarios import (
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameScenario,
    FrameStatic,
)
from workbench.scenarios.parts import Load, Member, Node
from workbench.sections import Section

TINTS = ("#b9c4cf", "#e3cfa8", "#a9cdb9", "#d9b8cc")  # one per section
ACTION, DEAD = PALETTE[:2]
ARROW = 0.38  # length
_SUPPORT, _GAP, _DIAMOND = 0.34, 0.06, 0.055
_ALONG = (0.1, 0.3, 0.5, 0.7, 0.9)  # of a member, where arrows of a line load stand
_MANY = 4  # equal loads or masses beyond this share one label
_MOST_NAMES = 24
_MOST = 3  # different places that are hit
_BOX, _WAY = 0.3, 0.42
DIRECTIONS = {"+x": 1.0 + 0j, "-x": -1.0 + 0j, "+y": 1j, "-y": -1j}


def sections_of(frame: Frame) -> dict[Section, Section]:
    """The different sections of a frame in order, as given and as their strength is counted."""
    return {member.section: frame.strength_section(member) for member in frame.members}


def draw_frame(panel: Axes, layout: Layout, named: Sequence[str] = ()) -> None:
    """Draw the frame at rest; nodes in `named` get their names even where there are many."""
    frame = layout.frame
    sections = list(dict.fromkeys(member.section for member in frame.members))
    for member in frame.members:
        _member(panel, layout, member, TINTS[sections.index(member.section) % len(TINTS)])
        along = layout.along(member)
        for node, joint, away in (
            (member.start, member.joint_start, along),
            (member.end, member.joint_end, -along),
        ):
            if joint != "rigid":
                joint_mark(panel, layout.edge(node, away, _GAP), joint)
    for place in frame.nodes:
        _support(panel, layout, place)
        _springs(panel, layout, place)
    _masses(panel, layout)
    _dead_loads(panel, layout)
    for place in frame.nodes:
        if len(frame.nodes) <= _MOST_NAMES or place.name in named:
            _name(panel, layout, place)


def _member(panel: Axes, layout: Layout, member: Member, color: str) -> None:
    along = layout.along(member)
    across = 0.5j * along * layout.depth(member)
    # members meet in full corners
    start = layout.at(member.start) - along * layout.half_depth(member.start, along)
    end = layout.edge(member.end, along)
    outline = [start - across, start + across, end + across, end - across]
    # the face hides the outlines of members that pass through it: what is left is the contour
    symbols.face(panel, outline, 1.5, facecolor=INK, linewidth=1.6)
    symbols.face(panel, outline, 1.6, facecolor=color, edgecolor="none")


def joint_mark(panel: Axes, at: complex, joint: str) -> None:
    """A white circle for a pinned joint, a diamond for one with properties of its own."""
    if joint == "pinned":
        symbols.circle(panel, at, 0.042, 4)
    else:
        symbols.face(panel, at + _DIAMOND * np.array([-1.0, 1j, 1.0, -1j]), 4)


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
        symbols.note(panel, end + beside, "held once loaded", MUTED)


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
        symbols.note(panel, 0.5 * (start + end) + beside, text, ha=side)
    if node.spring_rotation:
        symbols.spiral(panel, at, 0.2)
        right, low = (layout.half_depth(node.name, side) for side in (symbols.RIGHT, symbols.DOWN))
        text = f"{brief(node.spring_rotation / 1e3)} kN m/rad"
        symbols.note(panel, at + complex(right + 0.05, -low - 0.23), text)


def _masses(panel: Axes, layout: Layout) -> None:
    heavy = [node for node in layout.frame.nodes if node.mass or node.rotary_inertia]
    alike = len({(node.mass, node.rotary_inertia) for node in heavy}) == 1 and len(heavy) > _MANY
    for node in heavy:
        dot: Style = {"facecolor": INK, "edgecolor": "white", "linewidth": 0.6}
        symbols.circle(panel, layout.at(node.name), 0.075 * layout.small, 4.5, **dot)
        if alike and node is not heavy[0]:
            continue
        values = ((node.mass, "kg"), (node.rotary_inertia, "kg m²"))
        text = ", ".join(f"{brief(value)} {unit}" for value, unit in values if value)
        # left of and below the node: loads, their values and the node's name stand elsewhere
        at = layout.edge(node.name, symbols.LEFT, 0.05) - 0.21j
        symbols.note(panel, at, f"each {text}" if alike else text, ha="right")


def _dead_loads(panel: Axes, layout: Layout) -> None:
    loads = layout.frame.loads
    alike = len({(load.x, load.y, load.moment) for load in loads}) == 1 and len(loads) > _MANY
    highest = max(loads, key=lambda load: layout.at(load.node).imag, default=None)
    for load in loads:
        words = "" if alike and load is not highest else "each {}" if alike else "{}"
        load_arrows(panel, layout, load, DEAD, words)


def load_arrows(
    panel: Axes, layout: Layout, load: Load, color: str, words: str = "{}", away: float = 0.0
) -> None:
    """Arrows of a load on its node; `words` are written around each value (empty: no text).

    `away`: how far from the node they end.
    """
    for value, axis in ((load.x, 1.0 + 0j), (load.y, 1j)):
        if not value:
            continue
        out = np.sign(value) * axis
        end = layout.edge(load.node, -out, 0.01 + away)
        start = end - ARROW * layout.small * out
        symbols.arrow(panel, start, end, color)
        text = words.format(f"{brief(abs(value) / 1e3)} kN")
        if out.imag:
            # the spring stands on the right
            left = layout.frame.node(load.node).spring_y > 0.0
            # a value that stands for all arrows has its place above the highest one
            high = 0.1 if words.startswith("each") else 0.07 * out.imag
            at = start + complex(-0.06 if left else 0.06, high)
            symbols.note(panel, at, text, color, ha="right" if left else "left")
        else:
            symbols.note(panel, 0.5 * (start + end) - 0.1 * out + 0.1j, text, color, ha="center")
    if load.moment:
        at = layout.at(load.node)
        symbols.turning(panel, at, 0.3, color, counterclockwise=load.moment > 0.0)
        text = words.format(f"{brief(abs(load.moment) / 1e3)} kN m")
        symbols.note(panel, at + 0.2 + 0.14j, text, color)


def _name(panel: Axes, layout: Layout, node: Node) -> None:
    right, low = (layout.half_depth(node.name, side) for side in (symbols.RIGHT, symbols.DOWN))
    below = node.support == "free" or layout.outward(node.name) != symbols.DOWN
    rolls = node.support == "roller-y" and layout.outward(node.name, "x") == symbols.RIGHT
    beside = 0.26 if rolls or node.support.startswith("guide") else 0.05
    at = layout.at(node.name) + complex(right + beside, -low - 0.08 if below else 0.09)
    symbols.note(panel, at, node.name, MUTED, fontsize=symbols.SMALL - 1.0, zorder=3)


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


def listed(values: Sequence[float]) -> str:
    """Different values in words: all of a few, the range of many."""
    different = sorted(set(values))
    if len(different) > 4:
        return f"{brief(different[0])} to {brief(different[-1])}"
    return ", ".join(f"{brief(value)}" for value in different)


def _strikers(panel: Axes, layout: Layout, impacts: Sequence[FrameImpact]) -> list[str]:
    places = list(dict.fromkeys((s.striker.node, s.striker.direction) for s in impacts))
    said: list[str] = []
    for node, direction in first(places, _MOST, "places that are hit", said):
        strikers = [
            s.striker for s in impacts if (s.striker.node, s.striker.direction) == (node, direction)
        ]
        speeds = f"{listed([s.velocity for s in strikers])} m/s"
        masses = f"{listed([s.mass for s in strikers])} kg"
        along = DIRECTIONS[direction]
        end = layout.edge(node, -along, 0.01 + _beyond(layout, node, along))
        start = end - _WAY * along
        middle = start - 0.5 * _BOX * along
        corners = 0.5 * _BOX * np.array([-1.0 - 1j, 1.0 - 1j, 1.0 + 1j, -1.0 + 1j])
        face(panel, middle + corners, 5, facecolor=LIGHT, linewidth=0.9)
        arrow(panel, start, end, ACTION)
        beside = 0.23j if along.real else 0.2 + 0.07j
        side = "center" if along.real else "left"
        note(panel, middle + beside, speeds, ACTION, ha=side)
        note(panel, middle + beside.conjugate(), masses, INK, ha=side)
    return said


def _pattern(panel: Axes, layout: Layout, pushes: Sequence[FrameStatic]) -> list[str]:
    shown = pushes[0]
    alone = len(shown.loads) == 1
    for load in shown.loads:
        words = "λ P" if alone else "λ × {}"
        away = _beyond(layout, load.node, complex(load.x, load.y))
        load_arrows(panel, layout, load, ACTION, words, away)
    if not alone or shown.loads[0].node != shown.node:
        _ring(panel, layout, shown.node, "control" if shown.control != "load" else "displacement")
    said = [f"{push.name}: {_path(push)}." for push in pushes]
    if any(push.loads != shown.loads for push in pushes):
        said.append(f"Shown is the pattern of loads of {shown.name}; others differ.")
    if alone:
        kind = "force" if shown.loads[0].x or shown.loads[0].y else "moment"
        said.insert(0, f"λ P is the {kind} that is sought.")
    return said


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
            symbols.arrow(panel, tip - 0.6 * ARROW * layout.small * along, tip, ACTION)
    _ring(panel, layout, shown.node, "displacement")
    on = f", a line load along {shown.direction} on {', '.join(shown.members)}"
    shapes = ", ".join(dict.fromkeys(each.pulse.shape for each in pulses))
    peaks = listed([each.pulse.peak for each in pulses])
    unit = "N/m" if shown.members else "N"
    return [f"Pulses p(t), {shapes}, of at most {peaks} {unit}{on if shown.members else ''}."]


def _beyond(layout: Layout, node: str, direction: complex) -> float:
    """How far to stay off a node for the arrow of a dead load that comes from the same side."""
    taken = any(
        dead.node == node and (dead.x * direction.real > 0.0 or dead.y * direction.imag > 0.0)
        for dead in layout.frame.loads
    )
    return 1.25 * ARROW * layout.small if taken else 0.0


def _path(push: FrameStatic) -> str:
    """What is imposed, in words."""
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


def _motion(panel: Axes, layout: Layout, motions: Sequence[FrameGroundMotion]) -> list[str]:
    shown, low = motions[0], -0.42j
    axis = 0.3j if shown.direction.endswith("y") else 0.3 + 0j
    arrow(panel, low - axis, low + axis, ACTION, "<|-|>")
    peaks = [float(f"{max(map(abs, motion.acceleration)):.3g}") for motion in motions]
    text = f"ground acceleration, at most {listed(peaks)} m/s²"
    note(panel, low + axis.real + 0.08, text, ACTION)
    _ring(panel, layout, shown.node, "displacement")
    return []


def _ring(panel: Axes, layout: Layout, node: str, text: str) -> None:
    at = layout.at(node)
    circle(panel, at, 0.1, 6, facecolor="none", edgecolor=ACTION, linewidth=1.3)
    high = layout.half_depth(node, 1j)
    note(panel, at + complex(0.12, max(high + 0.09, 0.13)), text, ACTION)
