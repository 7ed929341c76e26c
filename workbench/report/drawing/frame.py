"""A frame and where its parts stand on paper: inches, free sides, levels.

Points and directions are complex numbers, x + iy; z comes towards the viewer, see `on_paper`.

**Second part.** Symbols of structures: supports, springs, arrows, dimension lines, sections.

Points are complex numbers, x + iy in the units of the panel. Symbols that stand somewhere take the
point `at` and the unit vector `out` that leads from the structure into the ground; their own
points are drawn as seen from there, outwards and i times across.

**Third part.** A frame on paper, in inches: members, supports, dead loads, and the actions of
scenarios.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, sin
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, FancyArrowPatch, PathPatch, Polygon
from matplotlib.path import Path
from numpy.typing import NDArray

from workbench.base.arrays import Array
from workbench.report.drawing.sheet import first
from workbench.report.drawing.style import INK, MUTED, PALETTE, Style
from workbench.report.page.formatting import MINUS, NO_BREAK, Unit, brief, count, unit_of
from workbench.scenarios import (
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameScenario,
    FrameStatic,
    Load,
    Member,
    Node,
    Scenario,
    frame_scenario,
)
from workbench.steel.sections import (
    CircularTube,
    ISection,
    RectangularTube,
    Section,
    Shape,
    TurnedISection,
)

_LEAST_DEPTH = 0.035  # inches that a member takes at least, so that it can be seen
_WIDE, _HIGH, _UPRIGHT = 4.2, 2.9, 2.4  # inches that a frame, and a single column, may take
_SAME = 1e-6  # m


RECEDES = 0.45 * np.exp(0.7j)  # place on paper of what lies 1 m behind, of a frame in space


def on_paper(x: Any, y: Any, z: Any = 0.0) -> Any:
    """Places in m as complex numbers, in an oblique view of what has a depth."""
    return x + 1j * np.asarray(y) - RECEDES * np.asarray(z)


def node_on_paper(node: Node) -> complex:
    """The place of a node, in m."""
    return complex(on_paper(node.x, node.y, node.z))


@dataclass(frozen=True)
class Layout:
    """A `frame` drawn at `scale` (inches per m), its lower left corner at the origin."""

    frame: Frame

    @cached_property
    def places(self) -> NDArray[np.complex128]:
        """Places of all nodes, in m."""
        return np.array([node_on_paper(node) for node in self.frame.nodes])

    @cached_property
    def origin(self) -> complex:
        """Lower left corner of all nodes, in m."""
        return complex(self.places.real.min(), self.places.imag.min())

    @cached_property
    def extent(self) -> complex:
        """Width and height between nodes, in m."""
        return complex(self.places.real.max(), self.places.imag.max()) - self.origin

    @cached_property
    def scale(self) -> float:
        """Inches per metre."""
        wide, high = max(self.extent.real, _SAME), max(self.extent.imag, _SAME)
        return min(_WIDE / wide, (_HIGH if wide > _SAME else _UPRIGHT) / high)

    @cached_property
    def small(self) -> float:
        """Factor on symbols that stand at every node: below 1 where members are short."""
        lengths = sorted(self.frame.length(member) * self.scale for member in self.frame.members)
        return min(1.0, lengths[len(lengths) // 2] / 0.6)

    def at(self, node: str) -> complex:
        """Position of a node, in inches."""
        return (node_on_paper(self.frame.node(node)) - self.origin) * self.scale

    def depth(self, member: Member) -> float:
        """Depth of a member as drawn, in inches."""
        return max(float(member.section.height) * self.scale, _LEAST_DEPTH)

    @property
    def deepened(self) -> bool:
        """Whether a member is drawn deeper than it is."""
        depths = [float(member.section.height) * self.scale for member in self.frame.members]
        return min(depths) * 1.001 < _LEAST_DEPTH

    def along(self, member: Member) -> complex:
        """Unit vector from a member's start to its end."""
        run = self.at(member.end) - self.at(member.start)
        return run / abs(run)

    @cached_property
    def members_at(self) -> dict[str, list[tuple[Member, complex]]]:
        """Members that end at each node, with the unit vector that leads away from it."""
        members: dict[str, list[tuple[Member, complex]]] = {n.name: [] for n in self.frame.nodes}
        for member in self.frame.members:
            members[member.start].append((member, self.along(member)))
            members[member.end].append((member, -self.along(member)))
        return members

    def half_depth(self, node: str, direction: complex) -> float:
        """Half the drawn depth of the members at a node, measured along `direction`."""
        reach = [
            0.5 * self.depth(member) * abs((away.conjugate() * direction).imag)
            for member, away in self.members_at[node]
        ]
        return max(reach)

    def edge(self, node: str, direction: complex, beyond: float = 0.0) -> complex:
        """The point at which the members of a node end along `direction`, or `beyond` it."""
        return self.at(node) + (self.half_depth(node, direction) + beyond) * direction

    def outward(self, node: str, axis: str = "") -> complex:
        """The axis direction that leads away from the members at a node.

        `axis`: x or y to choose among its two directions only.
        """
        free = -sum(away for _, away in self.members_at[node])
        if axis == "x" or (axis != "y" and abs(free.real) > abs(free.imag) + _SAME):
            return 1.0 + 0j if free.real > _SAME else -1.0 + 0j
        return 1j if free.imag > _SAME else -1j

    def levels(self, axis: str, further: Iterable[str] = ()) -> list[float]:
        """Different coordinates (m) of joints and ends, and of `further` nodes, rising."""
        names = {n.name for n in self.frame.nodes if not self._only_divides(n.name)} | {*further}
        values = np.sort([float(getattr(self.frame.node(name), axis)) for name in names])
        return [float(v) for v in values[np.diff(values, prepend=-np.inf) > _SAME]]

    def _only_divides(self, node: str) -> bool:
        """Whether a node only divides a straight member."""
        away = [away for _, away in self.members_at[node]]
        if len(away) != 2 or self.frame.node(node).support != "free":
            return False
        return (away[0].conjugate() * away[1]).real < -1.0 + _SAME


def frame_scenario_of(scenario: Scenario) -> FrameScenario | None:
    """Return the frame scenario; a column becomes its two-member frame. None without a frame.

    A scenario that is no single event, such as one with uncertain inputs, may have a `structure`.
    """
    if scenario.STATIC is not None:
        return frame_scenario(scenario)
    structure = getattr(scenario, "structure", None)
    return None if structure is None else frame_scenario_of(structure)


def displacement_unit(scenario: FrameScenario) -> Unit:
    """Return the display unit of the displacement that a scenario follows."""
    rotation = getattr(scenario, "direction", "").endswith("rotation")
    return Unit("rad", 1.0) if rotation else unit_of("displacement")


LIGHT = "#eef1f4"
SMALL = 7.0
DOWN, LEFT, RIGHT = -1j, -1.0 + 0j, 1.0 + 0j
_OPEN: Style = {"facecolor": "white", "edgecolor": INK, "linewidth": 1.0}
_ACTION: Style = {"linewidth": 1.4, "zorder": 6}
_TICK = 0.03
_ALONG = 0.42  # length of a dimension that has room for a text along it


def line(
    panel: Axes, points: Any, width: float = 1.0, order: float = 3.0, color: str = INK
) -> None:
    """A line through points."""
    z = np.asarray(points, dtype=complex)
    panel.plot(z.real, z.imag, color=color, linewidth=width, zorder=order)


def face(panel: Axes, corners: Any, order: float, **look: Any) -> None:
    """A polygon, white with a thin edge unless told otherwise."""
    panel.add_patch(Polygon(_pairs(corners), zorder=order, **{**_OPEN, **look}))


def circle(panel: Axes, at: complex, radius: float, order: float, **look: Any) -> None:
    """A circle, white with a thin edge unless told otherwise."""
    panel.add_patch(Circle((at.real, at.imag), radius, zorder=order, **{**_OPEN, **look}))


def _pairs(points: Any) -> Array:
    z = np.asarray(points, dtype=complex)
    return np.column_stack([z.real, z.imag])


def ground(panel: Axes, at: complex, out: complex, size: float, hatches: int = 7) -> None:
    """A line of width `size` across `out` at the point, hatched on its far side."""
    depth = 0.22 * size
    line(panel, [at - 0.5j * size * out, at + 0.5j * size * out], 1.2)
    for start in np.linspace(-size / 2, size / 2 - depth, hatches):
        ends = np.array([1j * (start + depth), 1j * start + depth])
        line(panel, at + out * ends, 0.6, 2.0)


def hinge_support(panel: Axes, at: complex, out: complex, size: float, *, rolls: bool) -> None:
    """A pinned support; one that `rolls` is free to move across `out`."""
    low, radius = 0.5 * size, 0.07 * size
    face(panel, at + out * np.array([0.0, low - 0.32j * size, low + 0.32j * size]), 3)
    circle(panel, at, radius, 5)
    if rolls:
        for across in (-0.18j * size, 0.18j * size):
            circle(panel, at + out * (low + radius + across), radius, 4)
        low += 2.0 * radius
    ground(panel, at + low * out, out, size)


def roller(panel: Axes, at: complex, out: complex, size: float) -> None:
    """A single roller between the point and a wall."""
    radius = 0.09 * size
    circle(panel, at + radius * out, radius, 4)
    ground(panel, at + 2.0 * radius * out, out, 0.64 * size, 5)


def guide(panel: Axes, at: complex, out: complex, half: float, size: float) -> None:
    """Two rollers on either side of a member that ends at the point: free along `out` only.

    `half`: half the depth of the member as drawn.
    """
    for wall in (-1j * out, 1j * out):
        for back in (0.05 * size, 0.55 * size):
            roller(panel, at - back * out + half * wall, wall, 0.75 * size)


def spring(panel: Axes, start: complex, end: complex, width: float) -> None:
    """A spring between two points."""
    share = np.array([0.0, *np.linspace(0.18, 0.82, 10), 1.0])
    aside = 0.5 * width * np.array([0, 0, 1, -1, 1, -1, 1, -1, 1, -1, 0, 0])
    out = (end - start) / abs(end - start)
    line(panel, start + share * (end - start) + 1j * out * aside)


def spiral(panel: Axes, at: complex, size: float) -> None:
    """A rotational spring around the point."""
    angle = np.linspace(0.0, 4.6 * np.pi, 90)
    line(panel, at + size * (0.2 + 0.3 * angle / angle[-1]) * np.exp(1j * angle), 0.9, 5.5)


def arrow(panel: Axes, start: complex, end: complex, color: str, style: str = "-|>") -> None:
    """A straight arrow."""
    look: Style = {"mutation_scale": 9.0, "shrinkA": 0, "shrinkB": 0, "color": color, **_ACTION}
    ends = (start.real, start.imag), (end.real, end.imag)
    panel.add_patch(FancyArrowPatch(*ends, arrowstyle=style, **look))


def turning(panel: Axes, at: complex, size: float, color: str, *, counterclockwise: bool) -> None:
    """An arrow that turns around the point, for moments."""
    place: Style = {"theta1": -130.0, "theta2": 130.0, "color": color, **_ACTION}
    panel.add_patch(Arc((at.real, at.imag), size, size, **place))
    sign = 1.0 if counterclockwise else -1.0
    radial = np.exp(1j * sign * np.radians(130.0))
    tip, along = at + 0.5 * size * radial, 1j * sign * radial
    arrow(panel, tip - 0.02 * size * along, tip + 0.25 * size * along, color)


def note(panel: Axes, at: complex, text: str, color: str = INK, **look: Any) -> None:
    """Small text beside a symbol."""
    style: Style = {"va": "center", "fontsize": SMALL, "zorder": 7, **look}
    panel.text(at.real, at.imag, text, color=color, **style)


def dimension(panel: Axes, start: complex, end: complex, text: str) -> None:
    """A dimension line with oblique ticks and its text beside it."""
    line(panel, [start, end], 0.7, 2, MUTED)
    for at in (start, end):
        line(panel, [at - _TICK * (1 + 1j), at + _TICK * (1 + 1j)], 0.9, 3)
    run, middle = end - start, 0.5 * (start + end)
    upright = abs(run.real) < abs(run.imag)
    look: Style = {"xytext": (0.0, 3.0), "ha": "center", "va": "bottom"}
    if upright:
        rotation = 90 if abs(run.imag) > _ALONG else 0  # a short one has no room along its line
        look = {"xytext": (3.5, 0.0), "ha": "left", "va": "center", "rotation": rotation}
    look |= {"textcoords": "offset points", "fontsize": SMALL}
    panel.annotate(text, (middle.real, middle.imag), **look)


def cross_section(panel: Axes, section: Section, centre: complex, scale: float, color: str) -> None:
    """The section to `scale`, its height upright."""
    loops = [
        Path(_pairs([*(centre + scale * z), 0.0]), closed=True) for z in _outlines(section.shape)
    ]
    look: Style = {"facecolor": color, "edgecolor": INK, "linewidth": 0.9, "zorder": 3}
    panel.add_patch(PathPatch(Path.make_compound_path(*loops), **look))


def _outlines(shape: Shape) -> Sequence[NDArray[np.complex128]]:
    """Corners of a shape around its centre in m: from outside, and of a tube from inside."""
    h, b = shape.height, shape.width
    if isinstance(shape, TurnedISection):
        return [1j * loop for loop in _outlines(shape.turned)]
    if isinstance(shape, ISection):
        # quarter of the outline from the flange tip to the web, fillet included
        r, middle = shape.fillet, shape.web / 2 + shape.fillet
        turn = np.exp(1j * np.linspace(0.5 * np.pi, np.pi, 9))
        arc = middle + 1j * (h / 2 - shape.flange - r) + r * turn
        upper = np.array([b / 2 + 0.5j * h, b / 2 + 1j * (h / 2 - shape.flange), *arc])
        right = np.concatenate([upper, upper.conj()[::-1]])
        return [np.concatenate([right, -right.conj()[::-1]])]
    if isinstance(shape, CircularTube):
        ring = np.exp(2j * np.pi * np.arange(72) / 72)
        return [h / 2 * ring, (h / 2 - shape.wall) * ring[::-1]]
    corner = 0.5 * (b + 1j * h)
    outside = np.array([-corner, corner.conjugate(), corner, -corner.conjugate()])
    if isinstance(shape, RectangularTube):
        wall = shape.wall * (np.sign(outside.real) + 1j * np.sign(outside.imag))
        return [outside, (outside - wall)[::-1]]
    return [outside]


TINTS = ("#b9c4cf", "#e3cfa8", "#a9cdb9", "#d9b8cc")  # one per section
ACTION, DEAD = PALETTE[:2]
ARROW = 0.38  # length
_SUPPORT, _GAP, _DIAMOND = 0.34, 0.06, 0.055
_LINE_LOAD_ARROWS = (0.1, 0.3, 0.5, 0.7, 0.9)  # of a member, where arrows of a line load stand
_MANY = 4  # equal loads or masses beyond this share one label
_MOST_NAMES = 24
_MOST = 3  # different places that are hit
_BOX, _WAY = 0.3, 0.42
_DOT: Style = {"facecolor": INK, "edgecolor": "white", "linewidth": 0.6}
DIRECTIONS = {"+x": 1.0 + 0j, "-x": -1.0 + 0j, "+y": 1j, "-y": -1j}


def way_on_paper(frame: Frame, part: Any) -> complex:
    """Unit vector along which a striker flies or a pulse acts."""
    along = DIRECTIONS[part.direction]
    if frame.spatial:
        along = complex(on_paper(along.real * cos(part.angle), along.imag, sin(part.angle)))
    return along / abs(along)


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
        circle(panel, at, 0.042, 4)
    else:
        face(panel, at + _DIAMOND * np.array([-1.0, 1j, 1.0, -1j]), 4)


def _support(panel: Axes, layout: Layout, node: Node) -> None:
    at, kind, name = layout.at(node.name), node.support, node.name
    if kind == "clamped":
        ground(panel, at, layout.outward(name), 1.2 * _SUPPORT)
    elif kind == "pinned":
        hinge_support(panel, at, layout.outward(name, "y"), _SUPPORT, rolls=False)
    elif kind.startswith("roller"):
        out = layout.outward(name, "y" if kind == "roller-x" else "x")
        if out.imag:
            hinge_support(panel, at, out, _SUPPORT, rolls=True)
        else:
            roller(panel, layout.edge(name, out), out, _SUPPORT)
    elif kind.startswith("guide"):
        out = layout.outward(name, kind[-1])
        guide(panel, at, out, layout.half_depth(name, 1j * out), _SUPPORT)
    if node.locked != "none":
        out = layout.outward(name, node.locked)
        end = layout.edge(name, out, 0.03)
        ground(panel, end, out, 1.2 * _SUPPORT)
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
            line(panel, [complex(at.real, start.imag), start])
        spring(panel, start, end, 0.13)
        ground(panel, end, out, 0.9 * _SUPPORT)
        beside, side = (0.12, "left") if axis == "y" else (0.16j, "center")
        text = f"{brief(stiffness / 1e6)} kN/mm"
        note(panel, 0.5 * (start + end) + beside, text, ha=side)
    if node.spring_rotation:
        spiral(panel, at, 0.2)
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
        circle(panel, layout.at(node.name), 0.075 * layout.small, 4.5, **_DOT)
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
        turning(panel, at, 0.3, color, counterclockwise=load.moment > 0.0)
        text = template.format(f"{brief(abs(load.moment) / 1e3)} kN m")
        note(panel, at + 0.2 + 0.14j, text, color)


def _name(panel: Axes, layout: Layout, node: Node) -> None:
    below = node.support == "free" or layout.outward(node.name) != DOWN
    rolls = node.support == "roller-y" and layout.outward(node.name, "x") == RIGHT
    corner, at = _lower_right(layout, node.name), layout.at(node.name)
    right = corner.real + (0.26 if rolls or node.support.startswith("guide") else 0.05)
    high = corner.imag - 0.08 if below else at.imag + 0.09
    look: Style = {"fontsize": SMALL - 1.0, "zorder": 3}
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
    strikers_at: dict[tuple[str, complex], list[FrameImpact]] = {}
    for impact in impacts:
        place = impact.striker.node, way_on_paper(layout.frame, impact.striker)
        strikers_at.setdefault(place, []).append(impact)
    notes: list[str] = []
    for node, along in first(list(strikers_at), _MOST, "places that are hit", notes):
        strikers = [impact.striker for impact in strikers_at[node, along]]
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
    along = way_on_paper(layout.frame, shown)
    for member in (layout.frame.member(name) for name in shown.members):
        start, end = layout.at(member.start), layout.at(member.end)
        for share in _LINE_LOAD_ARROWS:
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
    circle(panel, at, 0.1, 6, facecolor="none", edgecolor=ACTION, linewidth=1.3)
    high = layout.half_depth(node, 1j)
    note(panel, at + complex(0.12, max(high + 0.09, 0.13)), text, ACTION)


def _listed(values: Sequence[float]) -> str:
    """Different values in words: all of a few, the range of many."""
    different = sorted(set(values))
    if len(different) > 4:
        return f"{brief(different[0])} to {brief(different[-1])}"
    return ", ".join(f"{brief(value)}" for value in different)
