"""What happens to a frame, on paper: strikers, patterns of loads, motion of the ground."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from workbench.content.formatting import MINUS, NO_BREAK, Unit, brief, count
from workbench.report.figures.frame_layout import Layout, Point
from workbench.report.figures.frame_picture import ARROW, load_arrows
from workbench.report.figures.frames import FrameScenario, displacement_unit
from workbench.report.figures.pieces import LIGHT, arrow, note
from workbench.report.figures.style import INK, PALETTE
from workbench.scenarios import FrameGroundMotion, FrameImpact, FrameStatic

ACTION = PALETTE[0]
_MOST = 3  # different places that are hit
_BOX, _WAY = 0.3, 0.42
DIRECTIONS = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}


def draw_actions(panel: Axes, layout: Layout, scenarios: Sequence[FrameScenario]) -> list[str]:
    """Draw what the scenarios of one frame do to it; return sentences on what is not drawn.

    Strikers go before patterns of loads, patterns before the motion of the ground.
    """
    impacts = [s for s in scenarios if isinstance(s, FrameImpact)]
    pushes = [s for s in scenarios if isinstance(s, FrameStatic)]
    if impacts:
        return _strikers(panel, layout, impacts)
    if pushes:
        return _pattern(panel, layout, pushes)
    motions = [s for s in scenarios if isinstance(s, FrameGroundMotion)]
    return _motion(panel, layout, motions) if motions else []


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
    for node, direction in places[:_MOST]:
        strikers = [
            s.striker for s in impacts if (s.striker.node, s.striker.direction) == (node, direction)
        ]
        speeds = f"{listed([s.velocity for s in strikers])} m/s"
        masses = f"{listed([s.mass for s in strikers])} kg"
        (dx, dy), (x, y) = DIRECTIONS[direction], layout.at(node)
        half = layout.half_depth(node, (dx, dy)) + 0.01 + _beyond(layout, node, (dx, dy))
        end = (x - half * dx, y - half * dy)
        start = (end[0] - _WAY * dx, end[1] - _WAY * dy)
        corner = (start[0] - _BOX / 2 * (1.0 + dx), start[1] - _BOX / 2 * (1.0 + dy))
        look: dict[str, Any] = {"facecolor": LIGHT, "edgecolor": INK, "linewidth": 0.9, "zorder": 5}
        panel.add_patch(Rectangle(corner, _BOX, _BOX, **look))
        arrow(panel, start, end, ACTION)
        middle = (corner[0] + _BOX / 2, corner[1] + _BOX / 2)
        if dx:
            note(panel, (middle[0], middle[1] + 0.23), speeds, ACTION, ha="center")
            note(panel, (middle[0], middle[1] - 0.23), masses, INK, ha="center")
        else:
            note(panel, (middle[0] + 0.2, middle[1] + 0.07), speeds, ACTION)
            note(panel, (middle[0] + 0.2, middle[1] - 0.07), masses, INK)
    if len(places) > _MOST:
        return [f"Shown are the first {_MOST} of {len(places)} places that are hit."]
    return []


def _pattern(panel: Axes, layout: Layout, pushes: Sequence[FrameStatic]) -> list[str]:
    first = pushes[0]
    alone = len(first.loads) == 1
    for load in first.loads:
        words = "λ P" if alone else "λ × {}"
        away = _beyond(layout, load.node, (load.x, load.y))
        load_arrows(panel, layout, load, ACTION, words, away)
    if not alone or first.loads[0].node != first.node:
        _ring(panel, layout, first.node, "control" if first.control != "load" else "displacement")
    said = [f"{push.name}: {_path(push)}." for push in pushes]
    if any(push.loads != first.loads for push in pushes):
        said.append(f"Shown is the pattern of loads of {first.name}; others differ.")
    if alone:
        kind = "force" if first.loads[0].x or first.loads[0].y else "moment"
        said.insert(0, f"λ P is the {kind} that is sought.")
    return said


def _beyond(layout: Layout, node: str, direction: Point) -> float:
    """How far to stay off a node for the arrow of a dead load that comes from the same side."""
    x, y = direction
    taken = any(
        dead.node == node and (dead.x * x > 0.0 or dead.y * y > 0.0) for dead in layout.frame.loads
    )
    return 1.25 * ARROW * layout.small if taken else 0.0


def _path(push: FrameStatic) -> str:
    """What is imposed, in words."""
    unit = displacement_unit(push)
    values, what = [brief(unit.factor * value) for value in push.path], f"rotation of {push.node}"
    if not push.direction.endswith("rotation"):
        what = f"displacement of {push.node} along {push.direction.replace('-', MINUS)}"
    if push.control == "load":
        values = [brief(value) for value in push.path]
        unit, what = Unit("", 1.0), "load factor λ"
    elif push.control == "arc-length":
        what = f"arc length until the {what}"
    text = f"{NO_BREAK}{unit.text}" if unit.text else ""
    if len(values) == 1:
        return f"{what} to {values[0]}{text}"
    if len(values) <= 8:
        return f"{what} to {', '.join(values)}{text} in turn"
    low, high = values[int(np.argmin(push.path))], values[int(np.argmax(push.path))]
    return f"{what} through {count(len(values), 'target')} between {low} and {high}{text}"


def _motion(panel: Axes, layout: Layout, motions: Sequence[FrameGroundMotion]) -> list[str]:
    first = motions[0]
    low = -0.42
    axis = (0.0, 0.3) if first.direction.endswith("y") else (0.3, 0.0)
    arrow(panel, (-axis[0], low - axis[1]), (axis[0], low + axis[1]), ACTION, "<|-|>")
    peaks = [float(f"{max(map(abs, motion.acceleration)):.3g}") for motion in motions]
    largest = listed(peaks)
    text = f"ground acceleration, at most {largest} m/s²"
    note(panel, (axis[0] + 0.08, low), text, ACTION)
    _ring(panel, layout, first.node, "displacement")
    return []


def _ring(panel: Axes, layout: Layout, node: str, text: str) -> None:
    x, y = layout.at(node)
    panel.add_patch(Circle((x, y), 0.1, facecolor="none", edgecolor=ACTION, lw=1.3, zorder=6))
    high = layout.half_depth(node, (0.0, 1.0))
    note(panel, (x + 0.12, y + max(high + 0.09, 0.13)), text, ACTION)
