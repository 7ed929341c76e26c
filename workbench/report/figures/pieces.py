"""Drawing pieces of structures: supports, springs, dimension lines, sections. Lengths in m."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, PathPatch, Polygon, Rectangle
from matplotlib.path import Path
from numpy.typing import NDArray

from workbench.report.figures.style import INK, MUTED
from workbench.sections import CircularTube, ISection, RectangularTube, Section

Array = NDArray[np.float64]
STEEL, LIGHT = "#b9c4cf", "#eef1f4"
SMALL = 7.0


def ground(panel: Axes, x: float, y: float, size: float, up: bool = True) -> None:
    """A hatched line of width `size` centred at (x, y), hatches below it (or above)."""
    depth = 0.22 * size
    panel.plot([x - size / 2, x + size / 2], [y, y], color=INK, linewidth=1.2, zorder=3)
    for start in np.linspace(x - size / 2, x + size / 2 - depth, 7):
        end = y - depth if up else y + depth
        panel.plot([start + depth, start], [y, end], color=INK, linewidth=0.6, zorder=2)


def hinge_support(panel: Axes, x: float, y: float, size: float) -> None:
    """A pinned support below the point (x, y)."""
    corners = [(x, y), (x - 0.32 * size, y - 0.5 * size), (x + 0.32 * size, y - 0.5 * size)]
    panel.add_patch(Polygon(corners, facecolor="white", edgecolor=INK, linewidth=1.0, zorder=3))
    panel.add_patch(
        Circle((x, y), 0.07 * size, facecolor="white", edgecolor=INK, linewidth=1.0, zorder=5)
    )
    ground(panel, x, y - 0.5 * size, size)


def side_roller(panel: Axes, x: float, y: float, size: float, side: float) -> None:
    """A roller between the point (x, y) and a wall at `side` (+1 right, -1 left)."""
    radius = 0.09 * size
    panel.add_patch(
        Circle((x + side * radius, y), radius, facecolor="white", edgecolor=INK, lw=1.0, zorder=4)
    )
    wall = x + side * 2.0 * radius
    panel.plot([wall, wall], [y - 0.32 * size, y + 0.32 * size], color=INK, lw=1.2, zorder=3)
    depth = side * 0.16 * size
    for low in np.linspace(y - 0.32 * size, y + 0.16 * size, 5):
        panel.plot([wall, wall + depth], [low, low + 0.16 * size], color=INK, lw=0.6, zorder=2)


def spring(panel: Axes, x: float, low: float, high: float, width: float) -> None:
    """A vertical spring between two heights."""
    straight = 0.18 * (high - low)
    turns = np.linspace(low + straight, high - straight, 10)
    offsets = width / 2 * np.array([0, 1, -1, 1, -1, 1, -1, 1, -1, 0])
    panel.plot(
        np.concatenate([[x], x + offsets, [x]]),
        np.concatenate([[low], turns, [high]]),
        color=INK,
        linewidth=1.0,
        zorder=3,
    )


def arrow(panel: Axes, start: tuple[float, float], end: tuple[float, float], color: str) -> None:
    """A straight arrow."""
    style = {"arrowstyle": "-|>", "color": color, "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0}
    panel.annotate("", xy=end, xytext=start, arrowprops=style, zorder=5)


def dimension(
    panel: Axes, start: tuple[float, float], end: tuple[float, float], text: str, *, tick: float
) -> None:
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


def cross_section(panel: Axes, section: Section, centre: tuple[float, float], scale: float) -> None:
    """The section to `scale`, its height upright."""
    x, y = centre
    look: dict[str, Any] = {"facecolor": STEEL, "edgecolor": INK, "linewidth": 0.9, "zorder": 3}
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
