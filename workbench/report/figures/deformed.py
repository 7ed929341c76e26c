"""Deformed shapes: small multiples over time, or all labels over each other.

Options: `cases`; `layout`, ``instants`` (one row per label, one panel per instant, member ends
coloured by utilisation; the default for frames) or ``overlaid`` (one panel per case, every label
at its peak and dotted at the end; the default for columns, which then lie on their side);
`instants`, among start, half-way, peak, end, times in s or steps (for ``instants``).
"""

import numpy as np

from workbench.content.formatting import TIMES, in_unit
from workbench.fields import Choice
from workbench.report.drawing.multiples import mark_supports, multiples, scale_words, window_of
from workbench.report.drawing.shapes import Found, Points, Shapes, collected, magnification
from workbench.report.drawing.sheet import Drawing, Request, Sheet, grid_shape, nothing
from workbench.report.drawing.style import INK, MUTED, TEXT_WIDTH, Style, entry

_LAYOUT = Choice(("instants", "overlaid"))
_END: Style = {"linestyle": (0, (1, 1.5)), "linewidth": 1.0}
_REST: Style = {"color": MUTED, "linewidth": 0.8}
_LEAST, _MOST = 1.05, 3.2  # inches of a panel's height


def draw(request: Request) -> Drawing:
    """The shapes that responses know, true to scale unless they are too small to be seen."""
    said: list[str] = []
    found = collected(request, request.chosen(said), said)
    if not found:
        return nothing("No model states deformed shapes for these cases.", *said)
    # whether every structure at rest is one upright line
    upright = all(np.ptp(s.rest.real) == 0.0 for _, known in found for s in known.values())
    layout = request.option("layout", "overlaid" if upright else "instants")
    if _LAYOUT.check("figure.options.layout", layout) == "instants":
        return multiples(request, found, said)
    return _overlaid(request, found, said, lying=upright)


def _overlaid(request: Request, found: Found, said: list[str], *, lying: bool) -> Drawing:
    everything = [shapes for _, known in found for shapes in known.values()]
    largest = max(shapes.largest([shapes.peak, len(shapes.at) - 1]) for shapes in everything)
    size = max(shapes.size for shapes in everything)
    times = magnification(largest, size)
    columns = 1 if lying else grid_shape(len(found), 2)[1]
    count = -(-len(found) // columns)
    curves = [
        _laid(shapes, drawn, lying)
        for shapes in everything
        for drawn in (shapes.rest, *(shapes.magnified(shapes.index(i), times) for i in _INSTANTS))
    ]
    wide = (TEXT_WIDTH - 0.75 * columns) / columns
    window = window_of(curves, 0.04 * size, wide, _LEAST, _MOST)
    height, said = (window.tall + 0.35) * count + 0.75, [scale_words(times), *said]
    shared = {"sharex": True, "sharey": True}
    sheet = Sheet.table(count, columns, height, said, count=len(found), **shared)
    factor = f" {TIMES} {times:g}" if times != 1.0 else ""
    across = "height above the base (m)" if lying else "x (m)"
    up = f"displacement{factor}\n(m)" if lying else "y (m)"
    for (case, known), panel in zip(found, sheet.panels, strict=True):
        shapes = next(iter(known.values()))
        for curve in _laid(shapes, shapes.rest, lying):
            panel.plot(curve.real, curve.imag, **_REST, zorder=1)
        nodes = np.array([complex(node.x, node.y) for node in shapes.frame.nodes])
        mark_supports(panel, shapes, _laid(shapes, nodes, lying), INK, 4.0)
        for label, shapes in known.items():
            look = request.looks[label]
            sheet.legend(entry(label, **look.curve()))
            for instant in _INSTANTS:
                style = look.curve(**(_END if instant == "end" else {}))
                drawn = shapes.magnified(shapes.index(instant), times)
                for curve in _laid(shapes, drawn, lying):
                    panel.plot(curve.real, curve.imag, **style)
                for block in shapes.numbers(instant):
                    sheet.record(case=case.name, label=label, **block)
        window.show(panel)
        sheet.name(panel, case.name, across, up)
    sheet.legend(entry("at the end of the record", color=MUTED, linestyle=_END["linestyle"]))
    sheet.legend(entry("at rest", **_REST))
    largest_of = []
    for case, _ in found:
        peaks = (request.number(case, label, "peak_displacement") for label in request.shown(case))
        values = [peak for peak in peaks if peak is not None]
        words = in_unit(max(values), "peak_displacement", 3) if values else "no peak"
        largest_of.append(f"{case.name}: {words}")
    return sheet.finish(f"deformed shapes at the largest displacement ({', '.join(largest_of)})")


_INSTANTS = ("peak", "end")


def _laid(shapes: Shapes, points: Points, lying: bool) -> Points:
    """Points as they are, or of a structure that lies on its side: heights across."""
    if not lying:
        return points
    base = complex(shapes.rest.real.min(), shapes.rest.imag.min())
    laid: Points = 1j * np.conj(points - base)
    return laid
