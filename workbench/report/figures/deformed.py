"""Deformed shapes: small multiples over time, or all labels over each other.

A frame gets one row per label and one panel per instant, member ends as circles coloured by their
N-M utilisation. Columns lie on their side, one panel per case, every label at its peak and dotted
at the end; those that are hit off the plane of bending move sideways, which a second panel shows.
Options: `cases`; `instants` of frames, among start, half-way, peak, end, times in s or steps.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_hex

from workbench.report.drawing.frame import node_on_paper
from workbench.report.drawing.shapes import (
    REST,
    YIELDING,
    YIELDS,
    Points,
    Shapes,
    ShapesOfCases,
    collected,
    corners_of,
    instants_of,
    magnification,
)
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, first, nothing
from workbench.report.drawing.style import INK, MUTED, TEXT_WIDTH, Style, entry
from workbench.report.page.formatting import TIMES, in_unit
from workbench.study.definition import Case

_MOST_ROWS = 5
_LEAST, _MOST, _HIGHEST = 0.9, 2.9, 7.6  # inches of a panel's and of the figure's height
_LEAST_LYING, _MOST_LYING = 1.05, 3.2  # the same of columns that lie
_SLENDEREST = 0.45  # width over height of a panel
_GAP = 0.06  # inches from a member's end to its circle
_SIZE = 3.2  # of a circle; yielding ones are larger
_END: Style = {"linestyle": (0, (1, 1.5)), "linewidth": 1.0}
_REST: Style = {"color": MUTED, "linewidth": 0.8}
# pale to dark blue below yielding: with vermilion at it safe for colour-blind eyes and in grey
_BLUES = LinearSegmentedColormap.from_list(
    "utilisation", colormaps["Blues"](np.linspace(0.06, 0.95, 256))
).with_extremes(over=YIELDING)


def draw(request: Request) -> Drawing:
    """The shapes that responses know, true to scale unless they are too small to be seen."""
    notes: list[str] = []
    shapes_of_cases = collected(request, request.chosen(notes), notes)
    if not shapes_of_cases:
        return nothing("No model states deformed shapes for these cases.", *notes)
    everything = [shapes for _, by_label in shapes_of_cases for shapes in by_label.values()]
    if all(np.ptp(shapes.rest.real) == 0.0 for shapes in everything):  # upright lines
        return _lying(request, shapes_of_cases, notes)
    return _multiples(request, shapes_of_cases, everything, notes)


class _Window(NamedTuple):
    """Window of a panel: lower left corner and size in m, `wide` and `tall` inches."""

    low: complex
    size: complex
    wide: float
    tall: float

    def show(self, panel: Axes) -> None:
        """Give a panel these limits, both axes to one scale."""
        panel.set_aspect("equal")
        panel.set_xlim(self.low.real, (self.low + self.size).real)
        panel.set_ylim(self.low.imag, (self.low + self.size).imag)


def _window_around(
    curves: list[Points], edge: float, wide: float, least: float, most: float
) -> _Window:
    """Return the window on some curves with an `edge` in m around them, in a panel `wide` inches.

    Its height in inches has room for the numbers on the upright axis (`least`) and a limit.
    """
    low, high = corners_of(curves)
    low, size = low - edge * (1 + 1j), high - low + 2.0 * edge * (1 + 1j)
    natural = wide * size.imag / size.real
    if natural < least:
        spare = 1j * (least / natural - 1.0) * size.imag
        low, size = low - 0.5 * spare, size + spare
    return _Window(low, size, wide, min(max(natural, least), most))


class _Row(NamedTuple):
    """One answer: its instants, and the window and magnification that its case shares."""

    case: Case
    label: str
    shapes: Shapes
    window: _Window
    times: float


def _multiples(
    request: Request,
    shapes_of_cases: ShapesOfCases,
    everything: list[Shapes],
    notes: list[str],
) -> Drawing:
    """Shapes at some instants over the structure at rest, hinge states as coloured circles."""
    instants: tuple[str | float, ...] = ("half-way", "peak", "end")
    if all(shapes.peak == len(shapes.at) - 1 for shapes in everything):
        instants = ("half-way", "end")  # a push that only grows ends at its peak
    instants = instants_of(request.option("instants", instants))
    rows, several = _rows(shapes_of_cases, instants, notes), len(shapes_of_cases) > 1
    heights = [row.window.tall for row in rows]
    size, height = (len(rows), len(instants)), sum(heights) + 0.25 * len(rows) + 0.8
    times = {row.case.name: row.times for row in rows if row.times != 1.0} or {"": 1.0}
    scales = [_scale_text(each, f" of {name}" if several else "") for name, each in times.items()]
    sheet = Sheet.table(*size, height, [*scales, *notes], height_ratios=heights)
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
        _colour_bar(sheet)
    silent = dict.fromkeys(row.label for row in rows if not row.shapes.hinges)
    if silent:
        sheet.notes.append(f"Without utilisation of member ends: {', '.join(silent)}.")
    names = ", ".join(dict.fromkeys(row.label for row in rows))
    alt = f"deformed shapes of {names} at {', '.join(str(instant) for instant in instants)}"
    return sheet.finish(alt)


def _rows(
    shapes_of_cases: ShapesOfCases, instants: tuple[str | float, ...], notes: list[str]
) -> list[_Row]:
    """The answers that are drawn, those to one case with one window and magnification."""
    answers = [(case, label) for case, by_label in shapes_of_cases for label in by_label]
    shown = first(answers, _MOST_ROWS, "answers", notes)
    rows = []
    for case, by_label in shapes_of_cases:
        drawn = {label: shapes for label, shapes in by_label.items() if (case, label) in shown}
        if not drawn:
            continue
        snapshots = [(s, [s.index(instant) for instant in instants]) for s in drawn.values()]
        largest = max(shapes.largest(indices) for shapes, indices in snapshots)
        times = magnification(largest, snapshots[0][0].size)
        curves = [shapes.rest for shapes, _ in snapshots]
        curves += [s.magnified(i, times) for s, indices in snapshots for i in indices]
        low, high = corners_of(curves)
        edge = 0.04 * max((high - low).real, (high - low).imag)
        # room for the numbers on the axis of a single column
        wider = max(0.0, 0.5 * (_SLENDEREST * (high - low).imag - (high - low).real))
        curves.append(np.array([low - wider, high + wider]))
        most = min(_MOST, _HIGHEST / len(shown) - 0.25)
        window = _window_around(curves, edge, (TEXT_WIDTH - 1.35) / len(instants), _LEAST, most)
        rows += [_Row(case, label, shapes, window, times) for label, shapes in drawn.items()]
    return rows


def _panel(panel: Axes, row: _Row, snapshot: int) -> None:
    shapes, window = row.shapes, row.window
    curves = shapes.magnified(snapshot, row.times)
    for drawn, color, width in ((shapes.rest, REST, 0.9), (curves, INK, 1.2)):
        lines = [np.column_stack([curve.real, curve.imag]) for curve in drawn]
        panel.add_collection(LineCollection(lines, colors=color, linewidths=width))
    nodes = np.array([node_on_paper(node) for node in shapes.frame.nodes])
    _mark_supports(panel, shapes, nodes, MUTED, 3.4)
    wide, tall, size = window.wide, window.tall, window.size
    if shapes.hinges:
        gap = _GAP * max(size.real / wide, size.imag / tall)
        _draw_states(panel, hinge_places(curves, gap), shapes.used[:, snapshot])
    window.show(panel)
    room = max(2, int(2.6 * min(wide, tall * size.real / size.imag)))  # numbers on the lower axis
    panel.locator_params(axis="x", nbins=room)
    panel.locator_params(axis="y", nbins=5)
    panel.grid(visible=False)


def _mark_supports(panel: Axes, shapes: Shapes, at: Points, color: str, size: float) -> None:
    """A square at each clamped node, a circle at others that are held; `at` has their places."""
    for node, place in zip(shapes.frame.nodes, at, strict=True):
        look: Style = {"color": color, "markersize": size, "zorder": 2.5, "marker": "s"}
        if node.support != "clamped":
            look |= {"marker": "o", "markerfacecolor": "white"}
        if node.support != "free":
            panel.plot(place.real, place.imag, **look)


def colour_of(utilisation: float) -> str:
    """Colour of a utilisation as hexadecimal text."""
    return YIELDING if utilisation >= YIELDS else to_hex(_BLUES(max(utilisation, 0.0) / YIELDS))


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


def _draw_states(panel: Axes, places: Points, used: Array) -> None:
    """Circles at `places`; yielding ones are larger, with a dark edge, and lie on top."""
    for yields, size, edge, width in ((False, 1.0, MUTED, 0.35), (True, 1.45, INK, 0.7)):
        chosen = (used >= YIELDS) == yields
        panel.scatter(
            places[chosen].real,
            places[chosen].imag,
            s=(_SIZE * size) ** 2,
            c=[colour_of(float(value)) for value in used[chosen]],
            edgecolors=edge,
            linewidths=width,
            zorder=4.5 + 0.5 * yields,
        )


def _colour_bar(sheet: Sheet) -> None:
    """The bar that explains the circles, right of all panels."""
    share = min(0.9, 2.3 / sheet.canvas.get_figheight())
    place: Style = {"shrink": share, "aspect": 24, "pad": 0.02, "extendfrac": 0.07}
    mappable = ScalarMappable(Normalize(0.0, YIELDS), _BLUES)
    bar = sheet.canvas.colorbar(mappable, ax=sheet.panels, extend="max", **place)
    bar.set_ticks([0.0, 0.25, 0.5, 0.75, YIELDS], labels=["0", "0.25", "0.5", "0.75", "yields"])
    bar.set_label("N-M utilisation")
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(length=2.0)
    dot: Style = {"markerfacecolor": YIELDING, "markeredgecolor": INK, "markersize": 4.6}
    words = f"utilisation of {YIELDS:g} and more: yielding"
    sheet.legend(entry(words, linestyle="none", marker="o", **dot))


def _scale_text(times: float, of: str = "") -> str:
    """Return the note on the scale of the displacements."""
    if times == 1.0:
        return "True to scale, displacements too."
    return f"Displacements{of} are drawn {times:g} times as large as they are."


def _lying(request: Request, shapes_of_cases: ShapesOfCases, notes: list[str]) -> Drawing:
    """Columns with their heights across: every label at its peak, and dotted at the end."""
    views: list[tuple[str, Case, dict[str, Shapes]]] = []
    for case, by_label in shapes_of_cases:
        beside = {n: aside for n, each in by_label.items() if (aside := each.aside) is not None}
        views += [("", case, by_label), *([("sideways ", case, beside)] if beside else [])]
    everything = [shapes for _, _, by_label in views for shapes in by_label.values()]
    size = max(shapes.size for shapes in everything)
    largest = max(shapes.largest([shapes.peak, len(shapes.at) - 1]) for shapes in everything)
    times, styles = magnification(largest, size), {"peak": {}, "end": _END}
    curves = [
        _laid(shapes, drawn)
        for shapes in everything
        for drawn in (shapes.rest, *(shapes.magnified(shapes.index(i), times) for i in styles))
    ]
    wide = TEXT_WIDTH - 0.75
    window = _window_around(curves, 0.04 * size, wide, _LEAST_LYING, _MOST_LYING)
    rows = len(views)
    height, notes = (window.tall + 0.35) * rows + 0.75, [_scale_text(times), *notes]
    sheet = Sheet.table(rows, 1, height, notes, sharex=True, sharey=True)
    factor = f" {TIMES} {times:g}" if times != 1.0 else ""
    for (way, case, by_label), panel in zip(views, sheet.panels, strict=True):
        shapes = next(iter(by_label.values()))
        for curve in _laid(shapes, shapes.rest):
            panel.plot(curve.real, curve.imag, **_REST, zorder=1)
        nodes = np.array([node_on_paper(node) for node in shapes.frame.nodes])
        _mark_supports(panel, shapes, _laid(shapes, nodes), INK, 4.0)
        for label, shapes in by_label.items():
            look = request.looks[label]
            sheet.legend(entry(label, **look.curve()))
            for instant, style in styles.items():
                for curve in _laid(shapes, shapes.magnified(shapes.index(instant), times)):
                    panel.plot(curve.real, curve.imag, **look.curve(**style))
                for block in shapes.numbers(instant):
                    view = {"view": "sideways"} if way else {}
                    sheet.record(case=case.name, label=label, **view, **block)
        window.show(panel)
        title = f"{case.name}, sideways" if way else case.name
        sheet.name(panel, title, "height above the base (m)", f"{way}displacement{factor}\n(m)")
    sheet.legend(entry("at the end of the record", color=MUTED, linestyle=_END["linestyle"]))
    sheet.legend(entry("at rest", **_REST))
    texts = []
    for case, _ in shapes_of_cases:
        peaks = (request.number(case, label, "peak_displacement") for label in request.shown(case))
        peak = max((value for value in peaks if value is not None), default=None)
        texts.append(f"{case.name}: {in_unit(peak, 'peak_displacement', 3) if peak else 'no peak'}")
    return sheet.finish(f"deformed shapes at the largest displacement ({', '.join(texts)})")


def _laid(shapes: Shapes, points: Points) -> Points:
    """Points of a structure that lies on its side: heights across."""
    base = complex(shapes.rest.real.min(), shapes.rest.imag.min())
    laid: Points = 1j * np.conj(points - base)
    return laid
