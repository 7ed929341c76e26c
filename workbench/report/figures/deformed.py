"""Deformed shapes: small multiples over time, or all labels over each other.

Options: `cases`; `layout`, ``instants`` (one row per label, one panel per instant, member ends
coloured by utilisation; the default for frames) or ``overlaid`` (one panel per case, every label
at its peak and dotted at the end; the default for columns, which then lie on their side);
`instants`, among start, half-way, peak, end, times in s or steps (for ``instants``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from workbench.content.formatting import TIMES, in_unit
from workbench.fields import Choice
from workbench.report.figures.drawing import (
    Absences,
    Array,
    Drawing,
    Request,
    joined,
    nothing,
)
from workbench.report.figures.panels import chosen_cases, handle
from workbench.report.figures.shapes import Shapes, extent_of, magnification, shapes_of
from workbench.report.figures.small_multiples import multiples, shape_rows
from workbench.report.figures.style import (
    INK,
    MUTED,
    TEXT_WIDTH,
    Look,
    grid_shape,
    legend_below,
    new_figure,
)
from workbench.study.definition import Case

_LAYOUT = Choice(("instants", "overlaid"))
_DOTS: Any = (0, (1, 1.5))
_LEAST, _MOST = 1.05, 3.2  # inches of a panel's height
Found = list[tuple[Case, dict[str, Shapes]]]


def draw(request: Request) -> Drawing:
    """The shapes that responses know, true to scale unless they are too small to be seen."""
    found, statements = collected(request)
    if not found:
        return nothing("No model states deformed shapes for these cases.", *statements)
    upright = all(_stands(shapes) for _, by_label in found for shapes in by_label.values())
    layout = request.option("layout", "overlaid" if upright else "instants")
    if _LAYOUT.check("figure.options.layout", layout) == "instants":
        return multiples(request, found, statements)
    return _overlaid(request, found, statements, lying=upright)


def collected(request: Request) -> tuple[Found, list[str]]:
    """Shapes by case and label, and statements on what is absent."""
    cases, statements = chosen_cases(request)
    absent = Absences()
    found: Found = []
    for case in cases:
        by_label = {}
        for label in request.shown(case):
            response = request.stored.response(case.name, label)
            if response is None:
                absent.no_answer(label, case.name)
                continue
            shapes = shapes_of(case, response)
            if shapes is None:
                absent.without("deformed shape", label)
            else:
                by_label[label] = shapes
        if by_label:
            found.append((case, by_label))
    statements += absent.sentences()
    chords = [label for _, known in found for label, shapes in known.items() if shapes.chords]
    if chords:
        names = ", ".join(dict.fromkeys(chords))
        statements.append(
            f"Straight lines, {names}: these models state the displacement of the hit point and "
            "the shortening only; the shape between is not known."
        )
    return found, statements


def _stands(shapes: Shapes) -> bool:
    """Whether the structure at rest is one upright line."""
    return float(np.ptp(shapes.undeformed[0])) == 0.0


def _overlaid(request: Request, found: Found, statements: list[str], *, lying: bool) -> Drawing:
    largest = max(
        shapes.largest([shapes.peak, len(shapes.at) - 1])
        for _, by_label in found
        for shapes in by_label.values()
    )
    size = max(extent_of(s.frame) for _, by_label in found for s in by_label.values())
    times = magnification(largest, size)
    columns = 1 if lying else grid_shape(len(found), 2)[1]
    count = -(-len(found) // columns)
    bounds = _bounds(found, times, lying, 0.04 * size)
    wide = (TEXT_WIDTH - 0.75 * columns) / columns
    natural = wide * (bounds[3] - bounds[2]) / (bounds[1] - bounds[0])
    height = min(max(natural, _LEAST), _MOST)
    if natural < _LEAST:  # room for the label of the axis
        spare = 0.5 * (_LEAST / natural - 1.0) * (bounds[3] - bounds[2])
        bounds = (bounds[0], bounds[1], bounds[2] - spare, bounds[3] + spare)
    canvas = new_figure((height + 0.35) * count + 0.75)
    axes = canvas.subplots(count, columns, sharex=True, sharey=True, squeeze=False)
    blocks: list[Any] = []
    handles: list[Any] = []
    for (case, by_label), panel in zip(found, axes.flat, strict=False):
        _at_rest(panel, next(iter(by_label.values())), lying)
        for label, shapes in by_label.items():
            look = request.looks[label]
            handles.append(handle(label, look))
            for instant in ("peak", "end"):
                snapshot = shapes.index(instant)
                style = look.curve() if instant == "peak" else _end(look)
                for line in _lines(shapes, snapshot, times, lying):
                    panel.plot(*line, **style)
                blocks.append(shape_rows(case.name, label, instant, shapes, snapshot))
        panel.set_aspect("equal")
        panel.set_title(case.name, loc="left")
        panel.set_xlim(*bounds[:2])
        panel.set_ylim(*bounds[2:])
    for spare_panel in list(axes.flat)[len(found) :]:
        spare_panel.remove()
    _name_axes(axes, times, lying)
    grey = Line2D([], [], label="at the end of the record", color=MUTED, linestyle=_DOTS)
    rest = Line2D([], [], label="at rest", color=MUTED, linewidth=0.8)
    legend_below(canvas, [*handles, grey, rest])
    at = ", ".join(f"{case.name}: {_largest(request, case)}" for case, _ in found)
    alt = f"deformed shapes at the largest displacement ({at})"
    statements = [_scale_words(times), *statements]
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _scale_words(times: float) -> str:
    if times == 1.0:
        return "True to scale, displacements too."
    return f"Displacements are drawn {times:g} times as large as they are."


def _lines(shapes: Shapes, snapshot: int, times: float, lying: bool) -> list[tuple[Array, Array]]:
    """Curves (across, up) of all members on paper."""
    x, y = shapes.magnified(snapshot, times)
    return _laid(shapes, x, y, lying)


def _laid(shapes: Shapes, x: Array, y: Array, lying: bool) -> list[tuple[Array, Array]]:
    if not lying:
        return list(zip(x, y, strict=True))
    x0, y0 = shapes.undeformed
    return list(zip(y - y0.min(), x - x0.min(), strict=True))


def _bounds(found: Found, times: float, lying: bool, edge: float) -> tuple[float, ...]:
    """Left, right, lower and upper end of everything drawn."""
    across, up = [], []
    for _, by_label in found:
        for shapes in by_label.values():
            for lines in (
                _laid(shapes, *shapes.undeformed, lying),
                *(_lines(shapes, shapes.index(i), times, lying) for i in ("peak", "end")),
            ):
                across += [line[0] for line in lines]
                up += [line[1] for line in lines]
    xs, ys = np.concatenate(across), np.concatenate(up)
    return (
        *(float(xs.min()) - edge, float(xs.max()) + edge),
        *(float(ys.min()) - edge, float(ys.max()) + edge),
    )


def _name_axes(axes: Any, times: float, lying: bool) -> None:
    factor = f" {TIMES} {times:g}" if times != 1.0 else ""
    for row in axes:
        row[0].set_ylabel(f"displacement{factor}\n(m)" if lying else "y (m)")
    for panel in axes[-1]:
        panel.set_xlabel("height above the base (m)" if lying else "x (m)")


def _at_rest(panel: Axes, shapes: Shapes, lying: bool) -> None:
    """The structure without displacements; supports as marks."""
    for line in _laid(shapes, *shapes.undeformed, lying):
        panel.plot(*line, color=MUTED, linewidth=0.8, zorder=1)
    x0, y0 = (float(part.min()) for part in shapes.undeformed)
    for node in shapes.frame.nodes:
        at = (node.y - y0, node.x - x0) if lying else (node.x, node.y)
        if node.support == "clamped":
            panel.plot(*at, marker="s", markersize=4.0, color=INK, zorder=5)
        elif node.support != "free":
            panel.plot(*at, marker="o", markersize=4.0, color=INK, markerfacecolor="w", zorder=5)


def _end(look: Look) -> dict[str, Any]:
    return {**look.curve(), "linestyle": _DOTS, "linewidth": 1.0}


def _largest(request: Request, case: Case) -> str:
    found = [
        request.stored.number(case.name, label, "peak_displacement")
        for label in request.shown(case)
    ]
    known = [value for value in found if value is not None]
    return in_unit(max(known), "peak_displacement", 3) if known else "no peak"
