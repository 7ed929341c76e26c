"""The motion of a frame: an animation on screen, still pictures on paper.

Options: `case` (a name; default the first with deformed shapes); `instants`, those of the still
pictures (default start, half-way, peak, end). Snapshots are shown as they were stored, without
anything between them.

The film is one inline SVG with numbers beside it, played by the report's script; without a script
the peak stands still. Coordinates are whole quarters of a pixel; each snapshot is stored as
differences from the one before. Points are complex numbers, x + iy.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.content.formatting import TIMES, number
from workbench.content.html import templates
from workbench.report.drawing.frame import DIRECTIONS
from workbench.report.drawing.multiples import REST, YIELDS, colour_of, hinge_places, multiples
from workbench.report.drawing.shapes import (
    INSTANTS,
    Points,
    Shapes,
    collected,
    corners_of,
    magnification,
)
from workbench.report.drawing.sheet import Drawing, Request, first, nothing
from workbench.report.drawing.style import INK, MUTED, PALETTE
from workbench.scenarios import FrameImpact

_MOST = 3  # answers side by side
LARGEST = 290_000  # bytes of one film
_WIDTH, _HIGHEST = 960.0, 400.0  # pixels
_HEAD, _EDGE, _FOOT = 44.0, 26.0, 46.0
_FINE = 4  # steps per pixel
_STRAIGHT = 0.5  # pixels off the chord below which a member is sent by its ends
_LEVELS = 20  # shades of utilisation; one more: yielding
_GAP = 8.0  # pixels from a member's end to its circle
_TEMPLATE = templates(Path(__file__).parent).get_template("film.html.jinja")


def draw(request: Request) -> Drawing:
    """Stills of up to three answers to one case, and the film that an HTML report shows."""
    said: list[str] = []
    found = collected(request, request.named()[:6], said)
    if not found:
        return nothing("No model states deformed shapes for these cases.", *said)
    case, known = found[0]
    known = dict(first(list(known.items()), _MOST, "answers", said))
    stills = multiples(request, [(case, known)], said, INSTANTS)
    moving, every = film(known)
    said = [f"Case: {case.name}.", *stills.statements]
    if every > 1:
        said.append(
            f"On screen, one of {every} stored snapshots is shown: the animation stays below "
            f"{LARGEST // 1000} kB."
        )
    return replace(stills, statements=tuple(said), moving=moving, alt=f"motion: {stills.alt}")


@dataclass(frozen=True)
class _Panel:
    """One label on screen: the pixel of a point in m, pixels per m, and displacements as drawn."""

    label: str
    shapes: Shapes
    pixel: complex
    point: complex
    scale: float
    times: float

    def place(self, points: Any) -> Any:
        """Pixels of points in m; they count downwards."""
        return self.pixel + self.scale * np.conj(points - self.point)

    def curves(self, snapshot: int) -> Points:
        """Pixels (members, points) of a snapshot."""
        drawn: Points = self.place(self.shapes.magnified(snapshot, self.times))
        return drawn

    def words(self, snapshot: int) -> str:
        """When a snapshot was taken; the peak is named."""
        peak = "peak: " if snapshot == self.shapes.peak else ""
        return f"{peak}{self.shapes.words(snapshot)}"

    def still(self, snapshot: int) -> dict[str, Any]:
        """What the template draws of one snapshot."""
        shapes, curves = self.shapes, self.curves(snapshot)
        circles = []
        if shapes.hinges:
            places, used = hinge_places(curves, _GAP), shapes.used[:, snapshot]
            circles = [_circle(*each) for each in zip(places, used, strict=True)]
        return {
            "label": self.label,
            "words": self.words(snapshot),
            "left": self.pixel.real - 4.0,
            "rest": "".join(_path(curve[[0, -1]]) for curve in self.place(shapes.rest)),
            "held": [
                (self.place(complex(node.x, node.y)), node.support == "clamped")
                for node in shapes.frame.nodes
                if node.support != "free"
            ],
            "arrow": self.arrow(),
            "members": [_path(curve) for curve in curves],
            "circles": circles,
        }

    def arrow(self) -> str:
        """Path of an arrow at the place that is hit, empty if there is none."""
        scenario = self.shapes.scenario
        if not isinstance(scenario, FrameImpact):
            return ""
        node = scenario.frame.node(scenario.striker.node)
        along = DIRECTIONS[scenario.striker.direction].conjugate()
        tip = self.place(complex(node.x, node.y)) - 5.0 * along
        back, wing = tip - 8.0 * along, 4.0j * along
        return f"{_path([tip - 26.0 * along, tip])} {_path([back - wing, tip, back + wing])}"

    def numbers(self, picks: list[int]) -> dict[str, Any]:
        """What moves: curves, circles, readings, one string of numbers per curve."""
        frames = np.stack([self.curves(i) for i in picks])  # frames, members, points
        paths = []
        for track in frames.transpose(1, 0, 2):
            share = np.linspace(0.0, 1.0, track.shape[1])
            off = track - track[:, :1] - share * (track[:, -1:] - track[:, :1])
            straight = max(np.abs(off.real).max(), np.abs(off.imag).max()) < _STRAIGHT
            paths.append(_differences(track[:, [0, -1]] if straight else track))
        found: dict[str, Any] = {"paths": paths, "words": [self.words(i) for i in picks]}
        if self.shapes.hinges:
            found["circles"] = _differences(np.stack([hinge_places(z, _GAP) for z in frames]))
            used = self.shapes.used
            level = np.where(used >= YIELDS, _LEVELS, np.minimum(used * _LEVELS, _LEVELS - 1))
            letters = np.array(list(ascii_lowercase))[level.astype(int)]
            found["used"] = ["".join(letters[:, i]) for i in picks]
        return found


def film(by_label: Mapping[str, Shapes]) -> tuple[str, int]:
    """HTML of a film of up to three labels, and which of the snapshots it shows (every n-th)."""
    panels, height = _panels(by_label)
    every = 1
    while len((text := _html(panels, height, every)).encode()) > LARGEST:
        every += 1
    return text, every


def _panels(by_label: Mapping[str, Shapes]) -> tuple[list[_Panel], float]:
    """The panels side by side in one scale, and the height of the film in pixels."""
    everything = list(by_label.values())
    largest = max(shapes.largest(slice(None)) for shapes in everything)
    times = magnification(largest, max(shapes.size for shapes in everything))
    moving = [shapes.magnified(i, times) for shapes in everything for i in range(len(shapes.at))]
    low, high = corners_of([*(shapes.rest for shapes in everything), *moving])
    size, wide = high - low, _WIDTH / len(everything)
    room = complex(wide - 2.0 * _EDGE, _HIGHEST - _HEAD - _EDGE)
    scale = min(room.real / max(size.real, 1e-9), room.imag / max(size.imag, 1e-9))
    base, rest = _HEAD + scale * size.imag + 6.0, wide - scale * size.real
    panels = [
        _Panel(label, shapes, complex(i * wide + 0.5 * rest, base), low, scale, times)
        for i, (label, shapes) in enumerate(by_label.items())
    ]
    return panels, base + _EDGE + _FOOT


def _html(panels: list[_Panel], height: float, every: int) -> str:
    """The whole film: picture, controls (the script shows them), numbers."""
    lead = max(panels, key=lambda panel: len(panel.shapes.at)).shapes
    frames = sorted({*range(0, len(lead.at), every), lead.peak, len(lead.at) - 1})
    still = frames.index(lead.peak)
    seen = [[_nearest(panel.shapes, lead, frame) for frame in frames] for panel in panels]
    at = lead.at[frames] / max(lead.at[-1], 1e-300)
    shades = [colour_of(i / _LEVELS) for i in range(_LEVELS)]
    data: dict[str, Any] = {
        "at": [round(float(value), 4) for value in at],
        "fine": _FINE,
        "colours": [*shades, colour_of(1.0)],
        "panels": [panel.numbers(picks) for panel, picks in zip(panels, seen, strict=True)],
    }
    times, y = panels[0].times, height - 16.0
    return _TEMPLATE.render(
        panels=[panel.still(picks[still]) for panel, picks in zip(panels, seen, strict=True)],
        names=", ".join(panel.label for panel in panels),
        width=_WIDTH,
        height=height,
        y=y,
        colors={"ink": INK, "muted": MUTED, "rest": REST, "striker": PALETTE[0]},
        scale=f"{TIMES} {number(times, 3)}" if times != 1.0 else "true to scale",
        shades=shades if any(panel.shapes.hinges for panel in panels) else [],
        yields=f"{YIELDS:g}",
        yielding=_circle(complex(400.0 + 7 * _LEVELS + 70.0, y - 4.5), 1.0),
        last=len(frames) - 1,
        still=still,
        numbers=Markup(json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")),
    )


def _nearest(shapes: Shapes, lead: Shapes, frame: int) -> int:
    """The snapshot that stands beside a frame of the leading label."""
    when = lead.at[frame]
    if shapes.history == "step":  # steps differ between models: the same share of the record
        when = when / max(lead.at[-1], 1e-300) * shapes.at[-1]
    return int(np.argmin(np.abs(shapes.at - when)))


def _differences(track: Points) -> str:
    """Numbers of each frame less those of the frame before, frames divided by semicolons."""
    pairs = np.stack([track.real, track.imag], axis=-1).reshape(len(track), -1)
    whole = np.round(pairs * _FINE).astype(int)
    steps = np.diff(whole, axis=0, prepend=0 * whole[:1])
    return ";".join(" ".join(str(n) if n else "" for n in row) for row in steps)


def _circle(at: complex, used: float) -> dict[str, Any]:
    return {"at": at, "yields": used >= YIELDS, "color": colour_of(float(used))}


def _path(points: Any) -> str:
    return "M" + " ".join(f"{point.real:.2f},{point.imag:.2f}" for point in points)
