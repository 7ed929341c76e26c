"""Deformed shapes on paper: windows, supports, hinge states, labels over instants.

A hinge state is a circle at a member's end, its colour the N-M utilisation.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize, to_hex

from workbench.content.formatting import TIMES
from workbench.report.drawing.shapes import (
    Found,
    Points,
    Shapes,
    corners_of,
    instants_of,
    magnification,
)
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, first
from workbench.report.drawing.style import INK, MUTED, PALETTE, TEXT_WIDTH, Style, entry
from workbench.study.definition import Case

_MOST_ROWS = 5
_LEAST, _MOST, _HIGHEST = 0.9, 2.9, 7.6  # inches of a panel's and of the figure's height
_SLENDEREST = 0.45  # width over height of a panel
_GAP = 0.06  # inches from a member's end to its circle
REST = "#a8a8a8"
YIELDS = 0.995  # utilisation from which a section counts as yielding
YIELDING = PALETTE[1]
WORDS = f"utilisation of {YIELDS:g} and more: yielding"
_SIZE = 3.2  # of a circle; yielding ones are larger


class Window(NamedTuple):
    """What a panel shows: lower left and upper right corner in m, `wide` and `tall` inches."""

    low: complex
    high: complex
    wide: float
    tall: float

    @property
    def size(self) -> complex:
        """Width and height in m."""
        return self.high - self.low

    def show(self, panel: Axes) -> None:
        """Give a panel these limits, both axes to one scale."""
        panel.set_aspect("equal")
        panel.set_xlim(self.low.real, self.high.real)
        panel.set_ylim(self.low.imag, self.high.imag)


def window_of(curves: list[Points], edge: float, wide: float, least: float, most: float) -> Window:
    """The window on some curves with an `edge` in m around them, in a panel `wide` inches.

    Its height in inches has room for the numbers on the upright axis (`least`) and a limit
    (`most`).
    """
    low, high = corners_of(curves)
    low, high = low - edge * (1 + 1j), high + edge * (1 + 1j)
    size = high - low
    natural = wide * size.imag / size.real
    if natural < least:
        spare = 0.5j * (least / natural - 1.0) * size.imag
        low, high = low - spare, high + spare
    return Window(low, high, wide, min(max(natural, least), most))


def mark_supports(panel: Axes, shapes: Shapes, at: Points, color: str, size: float) -> None:
    """A square at each clamped node, a circle at others that are held; `at` has their places."""
    for node, place in zip(shapes.frame.nodes, at, strict=True):
        look: Style = {"color": color, "markersize": size, "zorder": 2.5, "marker": "s"}
        if node.support != "clamped":
            look |= {"marker": "o", "markerfacecolor": "white"}
        if node.support != "free":
            panel.plot(place.real, place.imag, **look)


@cache
def colours() -> Colormap:
    """Pale to dark blue below yielding, vermilion at it: safe for colour-blind eyes and in grey."""
    blues = colormaps["Blues"](np.linspace(0.06, 0.95, 256))
    return LinearSegmentedColormap.from_list("utilisation", blues).with_extremes(over=YIELDING)


def colour_of(utilisation: float) -> str:
    """Colour of a utilisation as hexadecimal text."""
    if utilisation >= YIELDS:
        return YIELDING
    return to_hex(colours()(max(utilisation, 0.0) / YIELDS))


def colour_bar(sheet: Sheet, share: float) -> None:
    """The bar that explains the circles, right of all panels, over a `share` of their height."""
    mappable = ScalarMappable(Normalize(0.0, YIELDS), colours())
    place: Style = {"shrink": share, "aspect": 24, "pad": 0.02, "extendfrac": 0.07}
    bar = sheet.canvas.colorbar(mappable, ax=sheet.panels, extend="max", **place)
    bar.set_ticks([0.0, 0.25, 0.5, 0.75, YIELDS], labels=["0", "0.25", "0.5", "0.75", "yields"])
    bar.set_label("N-M utilisation")
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(length=2.0)


def hinge_places(curves: Points, gap: float) -> Points:
    """Places (2 members,) of the circles: `gap` from each end along the members' curves.

    Arguments: `curves` (members, points), x + iy; short members have theirs nearer to the ends.
    """
    places = []
    for curve in curves:
        run = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(curve)))])
        near = min(gap, 0.3 * run[-1])
        places.append(np.interp([near, run[-1] - near], run, curve))
    return np.concatenate(places)


def draw_states(panel: Axes, places: Points, used: Array) -> None:
    """Circles at `places`; yielding ones are larger, with a dark edge, and lie on top."""
    for yields in (False, True):
        chosen = (used >= YIELDS) == yields
        if np.any(chosen):
            panel.scatter(
                places[chosen].real,
                places[chosen].imag,
                s=(_SIZE * (1.45 if yields else 1.0)) ** 2,
                c=[colour_of(float(value)) for value in used[chosen]],
                edgecolors=INK if yields else MUTED,
                linewidths=0.7 if yields else 0.35,
                zorder=5.0 if yields else 4.5,
            )


def scale_words(times: float, of: str = "") -> str:
    """How displacements are drawn, as a statement."""
    if times == 1.0:
        return "True to scale, displacements too."
    return f"Displacements{of} are drawn {times:g} times as large as they are."


@dataclass(frozen=True)
class _Row:
    """One answer: its instants, and the window and magnification that its case shares."""

    case: Case
    label: str
    shapes: Shapes
    window: Window
    times: float


def multiples(request: Request, found: Found, said: list[str]) -> Drawing:
    """Shapes at some instants over the structure at rest, hinge states as coloured circles."""
    instants: tuple[str | float, ...] = ("half-way", "peak", "end")
    if all(shapes.peak == len(shapes.at) - 1 for _, known in found for shapes in known.values()):
        # a push that only grows ends at its peak
        instants = ("half-way", "end")
    instants = instants_of(request.option("instants", instants))
    rows, several = _rows(found, instants, said), len(found) > 1
    heights = [row.window.tall for row in rows]
    size, height = (len(rows), len(instants)), sum(heights) + 0.25 * len(rows) + 0.8
    times = {row.case.name: row.times for row in rows if row.times != 1.0} or {"": 1.0}
    scales = [scale_words(each, f" of {name}" if several else "") for name, each in times.items()]
    sheet = Sheet.table(*size, height, [*scales, *said], height_ratios=heights)
    between = "\n" if len(instants) > 3 else " "
    last = [*(a.case is not b.case for a, b in pairwise(rows)), True]
    panels_of = np.array(sheet.panels, dtype=object).reshape(size)
    for row, panels, lowest in zip(rows, panels_of, last, strict=True):
        for instant, panel in zip(instants, panels, strict=True):
            snapshot = row.shapes.index(instant)
            _panel(panel, row, snapshot)
            title = row.shapes.words(snapshot)
            title = f"{instant}:{between}{title}" if isinstance(instant, str) else title
            panel.set_title(title, loc="left", fontsize=7.0)
            panel.tick_params(labelbottom=lowest, labelleft=panel is panels[0])
            for block in row.shapes.numbers(instant):
                sheet.record(case=row.case.name, label=row.label, **block)
        head = f"{row.case.name}\n{row.label}" if several else row.label
        panels[0].set_ylabel(f"{head}\ny (m)")
        if lowest:
            factor = f", displacements {TIMES} {row.times:g}" if row.times != 1.0 else ""
            panels[len(instants) // 2].set_xlabel(f"x (m){factor}")
    sheet.legend(entry("at rest", color=REST, linewidth=0.9))
    sheet.legend(entry("deformed", color=INK, linewidth=1.2))
    if any(row.shapes.hinges for row in rows):
        colour_bar(sheet, min(0.9, 2.3 / sheet.canvas.get_figheight()))
        dot: Style = {"markerfacecolor": YIELDING, "markeredgecolor": INK, "markersize": 4.6}
        sheet.legend(entry(WORDS, linestyle="none", marker="o", **dot))
    silent = dict.fromkeys(row.label for row in rows if not row.shapes.hinges)
    if silent:
        sheet.said.append(f"Without utilisation of member ends: {', '.join(silent)}.")
    names = ", ".join(dict.fromkeys(row.label for row in rows))
    alt = f"deformed shapes of {names} at {', '.join(str(instant) for instant in instants)}"
    return sheet.finish(alt)


def _rows(found: Found, instants: tuple[str | float, ...], said: list[str]) -> list[_Row]:
    """The answers that are drawn, those to one case with one window and magnification."""
    answers = [(case, label) for case, known in found for label in known]
    shown = first(answers, _MOST_ROWS, "answers", said)
    rows = []
    for case, known in found:
        own = {label: shapes for label, shapes in known.items() if (case, label) in shown}
        if not own:
            continue
        picks = {label: [s.index(instant) for instant in instants] for label, s in own.items()}
        largest = max(s.largest(picks[label]) for label, s in own.items())
        times = magnification(largest, next(iter(own.values())).size)
        curves = [s.rest for s in own.values()]
        curves += [s.magnified(i, times) for label, s in own.items() for i in picks[label]]
        low, high = corners_of(curves)
        edge = 0.04 * max((high - low).real, (high - low).imag)
        # room for the numbers on the axis of a single column
        wider = max(0.0, 0.5 * (_SLENDEREST * (high - low).imag - (high - low).real))
        curves.append(np.array([low - wider, high + wider]))
        most = min(_MOST, _HIGHEST / len(shown) - 0.25)
        window = window_of(curves, edge, (TEXT_WIDTH - 1.35) / len(instants), _LEAST, most)
        rows += [_Row(case, label, shapes, window, times) for label, shapes in own.items()]
    return rows


def _panel(panel: Axes, row: _Row, snapshot: int) -> None:
    shapes, window = row.shapes, row.window
    curves = shapes.magnified(snapshot, row.times)
    for drawn, color, width in ((shapes.rest, REST, 0.9), (curves, INK, 1.2)):
        lines = [np.column_stack([curve.real, curve.imag]) for curve in drawn]
        panel.add_collection(LineCollection(lines, colors=color, linewidths=width))
    nodes = np.array([complex(node.x, node.y) for node in shapes.frame.nodes])
    mark_supports(panel, shapes, nodes, MUTED, 3.4)
    wide, tall, size = window.wide, window.tall, window.size
    if shapes.hinges:
        gap = _GAP * max(size.real / wide, size.imag / tall)
        draw_states(panel, hinge_places(curves, gap), shapes.used[:, snapshot])
    window.show(panel)
    room = max(2, int(2.6 * min(wide, tall * size.real / size.imag)))  # numbers on the lower axis
    panel.locator_params(axis="x", nbins=room)
    panel.locator_params(axis="y", nbins=5)
    panel.grid(visible=False)
