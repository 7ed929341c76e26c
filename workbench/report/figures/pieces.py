"""Drawing pieces of structures: supports, springs, dimension lines, sections. Lengths in m.

Pieces that stand somewhere take the point `at` and the unit vector `out` that leads from the
structure into the ground.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, FancyArrowPatch, PathPatch, Polygon, Rectangle
from matplotlib.path import Path
from numpy.typing import NDArray

from workbench.report.figures.style import INK, MUTED
from workbench.sections import CircularTube, ISection, RectangularTube, Section

Array = NDArray[np.float64]
Point = tuple[float, float]
LIGHT = "#eef1f4"
SMALL = 7.0
DOWN, LEFT, RIGHT = (0.0, -1.0), (-1.0, 0.0), (1.0, 0.0)


def _placed(at: Point, out: Point, local: Any) -> Array:
    """Points (n, 2), across and out, as seen from the ground at `at`."""
    across = np.array([-out[1], out[0]])
    points = np.asarray(local, dtype=float)
    moved: Array = np.asarray(at) + points[:, :1] * across + points[:, 1:] * np.asarray(out)
    return moved


def _line(panel: Axes, points: Array, width: float = 1.0, order: float = 3.0) -> None:
    panel.plot(points[:, 0], points[:, 1], color=INK, linewidth=width, zorder=order)


def ground(panel: Axes, at: Point, out: Point, size: float, hatches: int = 7) -> None:
    """A line of width `size` across `out` at the point, hatched on its far side."""
    depth = 0.22 * size
    _line(panel, _placed(at, out, [(-size / 2, 0.0), (size / 2, 0.0)]), 1.2)
    for start in np.linspace(-size / 2, size / 2 - depth, hatches):
        _line(panel, _placed(at, out, [(start + depth, 0.0), (start, depth)]), 0.6, 2.0)


def hinge_support(panel: Axes, at: Point, out: Point, size: float, *, rolls: bool = False) -> None:
    """A pinned support; with `rolls` it is free to move across `out`."""
    low = 0.5 * size
    corners = _placed(at, out, [(0.0, 0.0), (-0.32 * size, low), (0.32 * size, low)])
    look: dict[str, Any] = {"facecolor": "white", "edgecolor": INK, "linewidth": 1.0}
    panel.add_patch(Polygon(corners.tolist(), zorder=3, **look))
    panel.add_patch(Circle(at, 0.07 * size, zorder=5, **look))
    if rolls:
        radius = 0.07 * size
        for across in (-0.18 * size, 0.18 * size):
            centre = _placed(at, out, [(across, low + radius)])[0]
            panel.add_patch(Circle((centre[0], centre[1]), radius, zorder=4, **look))
        low += 2.0 * radius
    x, y = _placed(at, out, [(0.0, low)])[0]
    ground(panel, (x, y), out, size)


def roller(panel: Axes, at: Point, out: Point, size: float) -> None:
    """A single roller between the point and a wall."""
    radius = 0.09 * size
    x, y = _placed(at, out, [(0.0, radius)])[0]
    panel.add_patch(Circle((x, y), radius, facecolor="white", edgecolor=INK, lw=1.0, zorder=4))
    x, y = _placed(at, out, [(0.0, 2.0 * radius)])[0]
    ground(panel, (x, y), out, 0.64 * size, 5)


def guide(panel: Axes, at: Point, out: Point, half: float, size: float) -> None:
    """Two rollers on either side of a member that ends at the point: free along `out` only.

    `half`: half the depth of the member as drawn.
    """
    for side in (-1.0, 1.0):
        wall = (-out[1] * side, out[0] * side)
        for back in (0.05 * size, 0.55 * size):
            x, y = _placed(at, out, [(side * half, -back)])[0]
            roller(panel, (x, y), wall, 0.75 * size)


def spring(panel: Axes, start: Point, end: Point, width: float) -> None:
    """A spring between two points."""
    length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
    out = ((end[0] - start[0]) / length, (end[1] - start[1]) / length)
    turns = np.linspace(0.18 * length, 0.82 * length, 10)
    offsets = width / 2 * np.array([0, 1, -1, 1, -1, 1, -1, 1, -1, 0])
    local = np.column_stack([offsets, turns])
    _line(panel, _placed(start, out, np.vstack([[0.0, 0.0], local, [0.0, length]])))


def spiral(panel: Axes, at: Point, size: float) -> None:
    """A rotational spring around the point."""
    angle = np.linspace(0.0, 4.6 * np.pi, 90)
    radius = size * (0.2 + 0.3 * angle / angle[-1])
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]) + np.asarray(at)
    _line(panel, points, 0.9, 5.5)


def arrow(panel: Axes, start: Point, end: Point, color: str, style: str = "-|>") -> None:
    """A straight arrow."""
    look: dict[str, Any] = {"color": color, "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0}
    head = FancyArrowPatch(start, end, arrowstyle=style, mutation_scale=9.0, zorder=6, **look)
    panel.add_patch(head)


def note(panel: Axes, at: Point, text: str, color: str = INK, **look: Any) -> None:
    """Small text beside a piece."""
    panel.text(*at, text, fontsize=SMALL, color=color, zorder=7, **{"va": "center", **look})


def turning(panel: Axes, at: Point, size: float, color: str, *, counterclockwise: bool) -> None:
    """An arrow that turns around the point, for moments."""
    look: dict[str, Any] = {"color": color, "linewidth": 1.4, "zorder": 6}
    panel.add_patch(Arc(at, size, size, theta1=-130.0, theta2=130.0, **look))
    sign = 1.0 if counterclockwise else -1.0
    angle = np.radians(130.0) * sign
    tip = np.asarray(at) + size / 2 * np.array([np.cos(angle), np.sin(angle)])
    along = sign * np.array([-np.sin(angle), np.cos(angle)])
    arrow(panel, tuple(tip - 0.02 * size * along), tuple(tip + 0.25 * size * along), color)


def dimension(panel: Axes, start: Point, end: Point, text: str, *, tick: float) -> None:
    """A dimension line with oblique ticks of size `tick` and its text beside it."""
    (x0, y0), (x1, y1) = start, end
    panel.plot([x0, x1], [y0, y1], color=MUTED, linewidth=0.7, zorder=2)
    for x, y in (start, end):
        panel.plot([x - tick, x + tick], [y - tick, y + tick], color=INK, linewidth=0.9, zorder=3)
    upright = abs(x1 - x0) < abs(y1 - y0)
    # a short dimension has no room along its line
    turned = upright and abs(y1 - y0) > 14.0 * tick
    panel.annotate(
        text,
        ((x0 + x1) / 2, (y0 + y1) / 2),
        xytext=(3.5, 0.0) if upright else (0.0, 3.0),
        textcoords="offset points",
        rotation=90 if turned else 0,
        ha="left" if upright else "center",
        va="center" if upright else "bottom",
        fontsize=SMALL,
    )


def cross_section(panel: Axes, section: Section, centre: Point, scale: float, color: str) -> None:
    """The section to `scale`, its height upright."""
    x, y = centre
    look: dict[str, Any] = {"facecolor": color, "edgecolor": INK, "linewidth": 0.9, "zorder": 3}
    shape = section.shape
    h, b = scale * section.height, scale * section.width
    if isinstance(shape, ISection):
        outline = _i_outline(shape) * scale + np.array([x, y])
        panel.add_patch(Polygon(outline.tolist(), closed=True, **look))
    elif isinstance(shape, RectangularTube):
        t = scale * shape.wall
        path = _ring(_box(x, y, b, h), _box(x, y, b - 2 * t, h - 2 * t)[::-1])
        panel.add_patch(PathPatch(path, **look))
    elif isinstance(shape, CircularTube):
        angle = np.linspace(0.0, 2 * np.pi, 73)
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        inner = h / 2 - scale * shape.wall
        outside = ring * h / 2 + np.array([x, y])
        inside = ring[::-1] * inner + np.array([x, y])
        panel.add_patch(PathPatch(_ring(outside, inside), **look))
    else:
        panel.add_patch(Rectangle((x - b / 2, y - h / 2), b, h, **look))


def _i_outline(shape: ISection) -> Array:
    b, h, tw, tf, r = shape.width / 2, shape.height / 2, shape.web / 2, shape.flange, shape.fillet
    angle = np.linspace(0.0, np.pi / 2, 9)
    # quarter of the outline from the flange tip to the web, fillet included
    arc = [(tw + r - r * np.sin(a), h - tf - r + r * np.cos(a)) for a in angle]
    quarter = np.array([(b, h), (b, h - tf), *arc])
    upper_right = quarter
    lower_right = (quarter * [1, -1])[::-1]
    right = np.concatenate([upper_right, lower_right])
    return np.concatenate([right, (right * [-1, 1])[::-1]])


def _box(x: float, y: float, b: float, h: float) -> Array:
    return np.array(
        [
            (x - b / 2, y - h / 2),
            (x + b / 2, y - h / 2),
            (x + b / 2, y + h / 2),
            (x - b / 2, y + h / 2),
            (x - b / 2, y - h / 2),
        ]
    )


def _ring(
    outside: Array,
    inside: Array,
) -> Path:
    codes = [Path.MOVETO, *[Path.LINETO] * (len(outside) - 1)]
    codes += [Path.MOVETO, *[Path.LINETO] * (len(inside) - 1)]
    return Path(np.concatenate([outside, inside]), codes)
