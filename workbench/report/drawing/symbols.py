"""Symbols of structures: supports, springs, arrows, dimension lines, sections.

Points are complex numbers, x + iy in the units of the panel. Symbols that stand somewhere take the
point `at` and the unit vector `out` that leads from the structure into the ground; their own
points are drawn as seen from there, outwards and i times across.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, FancyArrowPatch, PathPatch, Polygon
from matplotlib.path import Path
from numpy.typing import NDArray

from workbench.base.arrays import Array
from workbench.report.drawing.style import INK, MUTED, Style
from workbench.steel.sections import CircularTube, ISection, RectangularTube, Section

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
    loops = [Path(_pairs([*(centre + scale * z), 0.0]), closed=True) for z in _outlines(section)]
    look: Style = {"facecolor": color, "edgecolor": INK, "linewidth": 0.9, "zorder": 3}
    panel.add_patch(PathPatch(Path.make_compound_path(*loops), **look))


def _outlines(section: Section) -> Sequence[NDArray[np.complex128]]:
    """Corners of a section around its centre in m: from outside, and of a tube from inside."""
    shape, h, b = section.shape, section.height, section.width
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
