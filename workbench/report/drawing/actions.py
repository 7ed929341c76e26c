"""What happens to a frame, on paper: strikers, patterns of loads, motion of the ground."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import MINUS, NO_BREAK, Unit, brief, count
from workbench.report.drawing.frame import ARROW, load_arrows
from workbench.report.drawing.layout import Layout, displacement_unit
from workbench.report.drawing.sheet import first
from workbench.report.drawing.style import INK, PALETTE
from workbench.report.drawing.symbols import LIGHT, arrow, circle, face, note
from workbench.scenarios import FrameGroundMotion, FrameImpact, FrameScenario, FrameStatic

ACTION = PALETTE[0]
_MOST = 3  # different places that are hit
_BOX, _WAY = 0.3, 0.42
DIRECTIONS = {"+x": 1.0 + 0j, "-x": -1.0 + 0j, "+y": 1j, "-y": -1j}


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
    _motion(panel, layout, [s for s in scenarios if isinstance(s, FrameGroundMotion)])
    return []


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


def _motion(panel: Axes, layout: Layout, motions: Sequence[FrameGroundMotion]) -> None:
    shown, low = motions[0], -0.42j
    axis = 0.3j if shown.direction.endswith("y") else 0.3 + 0j
    arrow(panel, low - axis, low + axis, ACTION, "<|-|>")
    peaks = [float(f"{max(map(abs, motion.acceleration)):.3g}") for motion in motions]
    text = f"ground acceleration, at most {listed(peaks)} m/s²"
    note(panel, low + axis.real + 0.08, text, ACTION)
    _ring(panel, layout, shown.node, "displacement")


def _ring(panel: Axes, layout: Layout, node: str, text: str) -> None:
    at = layout.at(node)
    circle(panel, at, 0.1, 6, facecolor="none", edgecolor=ACTION, linewidth=1.3)
    high = layout.half_depth(node, 1j)
    note(panel, at + complex(0.12, max(high + 0.09, 0.13)), text, ACTION)
