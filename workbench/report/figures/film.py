"""A film of deformed shapes: one inline SVG with numbers beside it, played by the report's script.

Without a script, and on paper, the peak stands still. Coordinates are whole quarters of a pixel;
each snapshot is stored as differences from the one before.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import escape

from workbench.content.formatting import TIMES, number
from workbench.report.figures.drawing import Array
from workbench.report.figures.frame_actions import DIRECTIONS
from workbench.report.figures.hinge_states import YIELDS, colour_of, hinge_places
from workbench.report.figures.shapes import (
    Shapes,
    extent_of,
    magnification,
)
from workbench.report.figures.small_multiples import REST
from workbench.report.figures.style import INK, MUTED, PALETTE
from workbench.scenarios import FrameImpact

LARGEST = 290_000  # bytes of one film
_WIDTH, _HIGHEST = 960.0, 400.0  # pixels
_HEAD, _EDGE, _FOOT = 44.0, 26.0, 46.0
_FINE = 4  # steps per pixel
_STRAIGHT = 0.5  # pixels off the chord below which a member is sent by its ends
_LEVELS = 20  # shades of utilisation; one more: yielding
_GAP = 8.0  # pixels from a member's end to its circle


@dataclass(frozen=True)
class _Panel:
    """One label on screen: `left` edge and transformation from m to pixels."""

    label: str
    shapes: Shapes
    left: float
    scale: float
    origin: tuple[float, float]
    base: float
    times: float

    def place(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Pixels of points in m."""
        across = self.left + (x - self.origin[0]) * self.scale
        return across, self.base - (y - self.origin[1]) * self.scale

    def curves(self, snapshot: int) -> tuple[Array, Array]:
        """Pixels (members, points) of a snapshot."""
        return self.place(*self.shapes.magnified(snapshot, self.times))


def film(by_label: Mapping[str, Shapes]) -> tuple[str, int]:
    """HTML of a film of up to three labels, and which of the snapshots it shows (every n-th)."""
    panels, height = _panels(by_label)
    every = 1
    while True:
        text = _html(panels, height, every)
        if len(text.encode()) <= LARGEST:
            return text, every
        every += 1


def _panels(by_label: Mapping[str, Shapes]) -> tuple[list[_Panel], float]:
    everything = list(by_label.values())
    largest = max(shapes.largest(slice(None)) for shapes in everything)
    times = magnification(largest, max(extent_of(shapes.frame) for shapes in everything))
    drawn = [
        points
        for shapes in everything
        for i in range(len(shapes.at))
        for points in (shapes.undeformed, shapes.magnified(i, times))
    ]
    low = min(x.min() for x, _ in drawn), min(y.min() for _, y in drawn)
    high = max(x.max() for x, _ in drawn), max(y.max() for _, y in drawn)
    wide = _WIDTH / len(everything)
    scale = float(
        min(
            (wide - 2.0 * _EDGE) / max(high[0] - low[0], 1e-9),
            (_HIGHEST - _HEAD - _EDGE) / max(high[1] - low[1], 1e-9),
        )
    )
    base = _HEAD + scale * (high[1] - low[1]) + 6.0
    rest = wide - scale * (high[0] - low[0])
    panels = [
        _Panel(label, shapes, i * wide + 0.5 * rest, scale, (low[0], low[1]), base, times)
        for i, (label, shapes) in enumerate(by_label.items())
    ]
    return panels, base + _EDGE + _FOOT


def _html(panels: list[_Panel], height: float, every: int) -> str:
    """The whole film: picture, controls (the script shows them), numbers."""
    lead = max(panels, key=lambda panel: len(panel.shapes.at)).shapes
    frames = sorted({*range(0, len(lead.at), every), lead.peak, len(lead.at) - 1})
    still = frames.index(lead.peak)
    seen = [[_nearest(panel.shapes, lead, frame) for frame in frames] for panel in panels]
    parts = [_svg_panel(panel, picks[still]) for panel, picks in zip(panels, seen, strict=True)]
    names = ", ".join(panel.label for panel in panels)
    svg = (
        f'<svg viewBox="0 0 {_WIDTH:g} {height:.0f}" role="img" aria-label="'
        f'{escape(f"deformed shapes of {names}; the peak unless played")}" '
        f'font-family="sans-serif" font-size="13" fill="{INK}">'
        f"{''.join(parts)}{_legend(panels, height)}</svg>"
    )
    data: dict[str, Any] = {
        "at": _rounded(lead.at[frames] / max(lead.at[-1], 1e-300)),
        "fine": _FINE,
        "colours": [colour_of(i / _LEVELS) for i in range(_LEVELS)] + [colour_of(1.0)],
        "panels": [_numbers(panel, picks) for panel, picks in zip(panels, seen, strict=True)],
    }
    numbers = json.dumps(data, separators=(",", ":"), ensure_ascii=True).replace("<", "\\u003c")
    controls = (
        '<div class="film-controls" hidden><button type="button">Play</button>'
        f'<input type="range" min="0" max="{len(frames) - 1}" value="{still}" step="1" '
        'aria-label="snapshot"></div>'
    )
    return (
        f'<div class="film">{svg}{controls}<script type="application/json">{numbers}</script></div>'
    )


def _nearest(shapes: Shapes, lead: Shapes, frame: int) -> int:
    """The snapshot that stands beside a frame of the leading label."""
    when = lead.at[frame]
    if shapes.history == "step":  # steps differ between models: the same share of the record
        when = when / max(lead.at[-1], 1e-300) * shapes.at[-1]
    return int(np.argmin(np.abs(shapes.at - when)))


def _numbers(panel: _Panel, picks: list[int]) -> dict[str, Any]:
    """What moves in a panel: curves, circles, readings, one string of numbers per curve."""
    curves = [panel.curves(i) for i in picks]
    x, y = (np.stack([curve[k] for curve in curves]) for k in (0, 1))  # frames, members, points
    paths = []
    for member in range(x.shape[1]):
        track = np.stack([x[:, member], y[:, member]], axis=2)
        if _off_chord(track) < _STRAIGHT:
            track = track[:, [0, -1]]
        paths.append(_differences(track))
    shapes = panel.shapes
    found: dict[str, Any] = {
        "paths": paths,
        "words": [_words(shapes, i) for i in picks],
    }
    if shapes.hinges:
        places = np.stack([hinge_places(a, b, _GAP) for a, b in curves])
        found["circles"] = _differences(places)
        found["used"] = ["".join(_letter(u) for u in shapes.used[:, i]) for i in picks]
    return found


def _words(shapes: Shapes, snapshot: int) -> str:
    """When a snapshot was taken; the peak is named."""
    return f"{'peak: ' if snapshot == shapes.peak else ''}{shapes.words(snapshot)}"


def _off_chord(track: Array) -> float:
    """Largest distance (pixels) of points (frames, points, 2) from straight, even spacing."""
    share = np.linspace(0.0, 1.0, track.shape[1])[:, None]
    straight = track[:, :1] + share * (track[:, -1:] - track[:, :1])
    return float(np.abs(track - straight).max())


def _differences(track: Array) -> str:
    """Numbers of each frame less those of the frame before, frames divided by semicolons."""
    whole = np.round(track.reshape(len(track), -1) * _FINE).astype(int)
    steps = np.diff(whole, axis=0, prepend=0 * whole[:1])
    return ";".join(" ".join(str(n) if n else "" for n in row) for row in steps)


def _letter(used: float) -> str:
    level = _LEVELS if used >= YIELDS else min(int(used * _LEVELS), _LEVELS - 1)
    return chr(ord("a") + level)


def _rounded(values: Array) -> list[float]:
    return [round(float(value), 4) for value in values]


def _svg_panel(panel: _Panel, still: int) -> str:
    """A panel with its still snapshot; what the script moves has classes of its own."""
    shapes = panel.shapes
    x0, y0 = panel.place(*shapes.undeformed)
    rest = "".join(_path(x[[0, -1]], y[[0, -1]]) for x, y in zip(x0, y0, strict=True))
    x, y = panel.curves(still)
    head = panel.left - 4.0
    parts = [
        "<g>",
        f'<text x="{head:.0f}" y="16" font-weight="bold">{escape(panel.label)}</text>',
        f'<text class="film-words" x="{head:.0f}" y="34">{escape(_words(shapes, still))}</text>',
        f'<path d="{rest}" fill="none" stroke="{REST}" stroke-width="1.5"/>',
        *_supports(panel),
        _target(panel),
    ]
    for across, up in zip(x, y, strict=True):
        parts.append(
            f'<path class="film-member" d="{_path(across, up)}" fill="none" stroke="{INK}" '
            'stroke-width="2.2"/>'
        )
    if shapes.hinges:
        places = hinge_places(x, y, _GAP)
        for (across, up), used in zip(places, shapes.used[:, still], strict=True):
            parts.append(_circle(across, up, float(used), ' class="film-hinge"'))
    return "".join([*parts, "</g>"])


def _circle(x: float, y: float, used: float, more: str = "") -> str:
    yields = used >= YIELDS
    return (
        f'<circle{more} cx="{x:.2f}" cy="{y:.2f}" r="{5 if yields else 3.5}" '
        f'fill="{colour_of(used)}" stroke="{INK if yields else MUTED}" '
        f'stroke-width="{1.2 if yields else 0.6}"/>'
    )


def _path(x: Array, y: Array) -> str:
    points = " ".join(f"{a:.2f},{b:.2f}" for a, b in zip(x, y, strict=True))
    return f"M{points}"


def _supports(panel: _Panel) -> list[str]:
    found = []
    for node in panel.shapes.frame.nodes:
        if node.support == "free":
            continue
        (x,), (y,) = panel.place(np.array([node.x]), np.array([node.y]))
        if node.support == "clamped":
            found.append(
                f'<rect x="{x - 7:.2f}" y="{y:.2f}" width="14" height="5" fill="{MUTED}"/>'
            )
        else:
            d = f"M{x:.2f},{y:.2f} l-6,9 h12 z"
            found.append(f'<path d="{d}" fill="#fff" stroke="{MUTED}" stroke-width="1.2"/>')
    return found


def _target(panel: _Panel) -> str:
    """An arrow at the place that is hit, or whose displacement is followed."""
    scenario = panel.shapes.scenario
    if not isinstance(scenario, FrameImpact):
        return ""
    node = scenario.frame.node(scenario.striker.node)
    dx, dy = DIRECTIONS[scenario.striker.direction]
    (x,), (y,) = panel.place(np.array([node.x]), np.array([node.y]))
    tip = x - 5.0 * dx, y + 5.0 * dy
    tail = tip[0] - 26.0 * dx, tip[1] + 26.0 * dy
    back = tip[0] - 8.0 * dx, tip[1] + 8.0 * dy
    wing = 4.0 * dy, 4.0 * dx
    d = (
        f"M{tail[0]:.2f},{tail[1]:.2f} L{tip[0]:.2f},{tip[1]:.2f} "
        f"M{back[0] - wing[0]:.2f},{back[1] - wing[1]:.2f} L{tip[0]:.2f},{tip[1]:.2f} "
        f"L{back[0] + wing[0]:.2f},{back[1] + wing[1]:.2f}"
    )
    return f'<path d="{d}" fill="none" stroke="{PALETTE[0]}" stroke-width="2"/>'


def _legend(panels: list[_Panel], height: float) -> str:
    """Scale of displacements, colours of utilisation, what the grey lines are."""
    y = height - 16.0
    parts = [
        f'<path d="M10,{y - 4:.0f} h22" stroke="{REST}" stroke-width="1.5"/>',
        f'<text x="38" y="{y:.0f}">at rest</text>',
    ]
    times = panels[0].times
    said = "displacements true to scale"
    if times != 1.0:
        said = f"displacements {TIMES} {number(times, 3)}"
    parts.append(f'<text x="104" y="{y:.0f}">{said}</text>')
    if any(panel.shapes.hinges for panel in panels):
        left = 400.0
        parts.append(
            f'<text x="{left - 8:.0f}" y="{y:.0f}" text-anchor="end">N-M utilisation 0</text>'
        )
        for i in range(_LEVELS):
            parts.append(
                f'<rect x="{left + 7 * i:.0f}" y="{y - 10:.0f}" width="7" height="12" '
                f'fill="{colour_of(i / _LEVELS)}"/>'
            )
        right = left + 7 * _LEVELS + 8
        parts.append(f'<text x="{right:.0f}" y="{y:.0f}">{YIELDS:g}</text>')
        parts.append(_circle(right + 62.0, y - 4.5, 1.0))
        parts.append(f'<text x="{right + 73:.0f}" y="{y:.0f}">and more: yielding</text>')
    return "".join(parts)
