"""Deformed shapes as small multiples: one row per label, one panel per instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from workbench.content.formatting import TIMES
from workbench.report.figures.drawing import Array, Drawing, Request, joined, rows
from workbench.report.figures.hinge_states import (
    WORDS,
    YIELDING,
    colour_bar,
    draw_states,
    hinge_places,
)
from workbench.report.figures.shapes import (
    Shapes,
    extent_of,
    instants_of,
    magnification,
)
from workbench.report.figures.style import INK, MUTED, TEXT_WIDTH, legend_below, new_figure
from workbench.study.definition import Case

_MOST_ROWS = 5
_LEAST, _MOST, _HIGHEST = 0.9, 2.9, 7.6  # inches of a panel's and of the figure's height
_SLENDEREST = 0.45  # width over height of a panel
_GAP = 0.06  # inches from a member's end to its circle
REST = "#a8a8a8"
Found = list[tuple[Case, dict[str, Shapes]]]


@dataclass(frozen=True)
class _Row:
    """One answer: its snapshots, and the window that all answers to its case share."""

    case: Case
    label: str
    shapes: Shapes
    picks: list[int]
    window: _Window


@dataclass(frozen=True)
class _Window:
    """What panels of a case show: `bounds` in m, displacements `times` as large, `high` inches."""

    bounds: tuple[float, ...]
    times: float
    wide: float
    high: float

    @property
    def gap(self) -> float:
        """Distance of circles from the ends of members, in m."""
        left, right, low, up = self.bounds
        return _GAP * max((right - left) / self.wide, (up - low) / self.high)

    @property
    def ticks(self) -> int:
        """Numbers that have room on the lower axis."""
        left, right, low, up = self.bounds
        return max(2, int(2.6 * min(self.wide, self.high * (right - left) / (up - low))))


def multiples(
    request: Request,
    found: Found,
    statements: list[str],
    instants: tuple[str | float, ...] = ("half-way", "peak", "end"),
) -> Drawing:
    """Shapes at some instants over the structure at rest, hinge states as coloured circles."""
    instants = instants_of(request.option("instants", _different(found, instants)))
    lines, statements = _rows(found, instants, statements)
    canvas = new_figure(sum(line.window.high + 0.25 for line in lines) + 0.8)
    axes = canvas.subplots(
        len(lines),
        len(instants),
        squeeze=False,
        height_ratios=[line.window.high for line in lines],
    )
    blocks: list[Any] = []
    several = len(found) > 1
    between = "\n" if len(instants) > 3 else " "
    for i, (line, row) in enumerate(zip(lines, axes, strict=True)):
        lowest = i + 1 == len(lines) or lines[i + 1].case is not line.case
        for j, (instant, snapshot, panel) in enumerate(zip(instants, line.picks, row, strict=True)):
            _panel(panel, line.shapes, snapshot, line.window)
            title = line.shapes.words(snapshot)
            if isinstance(instant, str):
                title = f"{instant}:{between}{title}"
            panel.set_title(title, loc="left", fontsize=7.0)
            panel.tick_params(labelbottom=lowest, labelleft=j == 0)
            blocks.append(
                shape_rows(line.case.name, line.label, str(instant), line.shapes, snapshot)
            )
        head = f"{line.case.name}\n{line.label}" if several else line.label
        row[0].set_ylabel(f"{head}\ny (m)")
        if lowest:
            times = line.window.times
            factor = f", displacements {TIMES} {times:g}" if times != 1.0 else ""
            row[len(instants) // 2].set_xlabel(f"x (m){factor}")
    handles: list[Any] = [
        Line2D([], [], color=REST, linewidth=0.9, label="at rest"),
        Line2D([], [], color=INK, linewidth=1.2, label="deformed"),
    ]
    if any(line.shapes.hinges for line in lines):
        colour_bar(canvas, axes, min(0.9, 2.3 / canvas.get_figheight()))
        look: dict[str, Any] = {
            "markersize": 4.6,
            "markerfacecolor": YIELDING,
            "markeredgecolor": INK,
        }
        handles.append(Line2D([], [], linestyle="none", marker="o", label=WORDS, **look))
    silent = [line.label for line in lines if not line.shapes.hinges]
    if silent:
        names = ", ".join(dict.fromkeys(silent))
        statements = [*statements, f"Without utilisation of member ends: {names}."]
    legend_below(canvas, handles, len(handles))
    names = ", ".join(dict.fromkeys(line.label for line in lines))
    alt = f"deformed shapes of {names} at {', '.join(str(instant) for instant in instants)}"
    said = (*_scales(lines, several), *statements)
    return Drawing(canvas, joined(blocks), said, alt)


def _different(found: Found, instants: tuple[str | float, ...]) -> tuple[str | float, ...]:
    """The instants, without the peak where every answer ends at it: a push that only grows."""
    if all(s.peak == len(s.at) - 1 for _, known in found for s in known.values()):
        return tuple(instant for instant in instants if instant != "peak")
    return instants


def _rows(
    found: Found, instants: tuple[str | float, ...], statements: list[str]
) -> tuple[list[_Row], list[str]]:
    """The answers that are drawn, and the statements with one on those that are not."""
    answers = [(case, label) for case, known in found for label in known]
    if len(answers) > _MOST_ROWS:
        said = f"Shown are the first {_MOST_ROWS} of {len(answers)} answers."
        statements, answers = [*statements, said], answers[:_MOST_ROWS]
    lines = []
    for case, known in found:
        shown = {label: known[label] for other, label in answers if other is case}
        if not shown:
            continue
        picks = {label: [s.index(i) for i in instants] for label, s in shown.items()}
        largest = max(s.largest(picks[label]) for label, s in shown.items())
        frame = next(iter(shown.values())).frame
        times = magnification(largest, extent_of(frame))
        bounds = _bounds(list(shown.values()), list(picks.values()), times)
        wide = (TEXT_WIDTH - 1.35) / len(instants)
        natural = wide * (bounds[3] - bounds[2]) / (bounds[1] - bounds[0])
        if natural < _LEAST:  # room for the numbers on the upright axis
            spare = 0.5 * (_LEAST / natural - 1.0) * (bounds[3] - bounds[2])
            bounds = (*bounds[:2], bounds[2] - spare, bounds[3] + spare)
        high = min(max(natural, _LEAST), _MOST, _HIGHEST / len(answers) - 0.25)
        window = _Window(bounds, times, wide, high)
        lines += [_Row(case, label, s, picks[label], window) for label, s in shown.items()]
    return lines, statements


def _scales(lines: list[_Row], several: bool) -> list[str]:
    times = {line.case.name: line.window.times for line in lines}
    if set(times.values()) == {1.0}:
        return ["True to scale, displacements too."]
    return [
        f"Displacements{f' of {name}' if several else ''} are drawn {factor:g} times as large as "
        "they are."
        for name, factor in times.items()
        if factor != 1.0
    ]


def _panel(panel: Axes, shapes: Shapes, snapshot: int, window: _Window) -> None:
    x, y = shapes.magnified(snapshot, window.times)
    for curves, color, width in ((shapes.undeformed, REST, 0.9), ((x, y), INK, 1.2)):
        lines = np.stack(curves, axis=-1)
        panel.add_collection(LineCollection(list(lines), colors=color, linewidths=width))
    for node in shapes.frame.nodes:
        if node.support == "clamped":
            panel.plot(node.x, node.y, marker="s", markersize=3.4, color=MUTED, zorder=2.5)
        elif node.support != "free":
            look: dict[str, Any] = {"markerfacecolor": "white", "markersize": 3.4, "color": MUTED}
            panel.plot(node.x, node.y, marker="o", zorder=2.5, **look)
    if shapes.hinges:
        draw_states(panel, hinge_places(x, y, window.gap), shapes.used[:, snapshot])
    panel.set_aspect("equal")
    panel.set_xlim(*window.bounds[:2])
    panel.set_ylim(*window.bounds[2:])
    panel.locator_params(axis="x", nbins=window.ticks)
    panel.locator_params(axis="y", nbins=5)
    panel.grid(visible=False)


def _bounds(found: list[Shapes], chosen: list[list[int]], times: float) -> tuple[float, ...]:
    """Left, right, lower and upper end of everything drawn, with an edge."""
    xs, ys = [], []
    for shapes, picks in zip(found, chosen, strict=True):
        for x, y in (shapes.undeformed, *(shapes.magnified(i, times) for i in picks)):
            xs.append(x.ravel())
            ys.append(y.ravel())
    across, up = np.concatenate(xs), np.concatenate(ys)
    edge = 0.04 * max(np.ptp(across), np.ptp(up))
    # room for the numbers on the axis of a single column
    wider = max(0.0, 0.5 * (_SLENDEREST * np.ptp(up) - np.ptp(across)))
    return (
        *(float(across.min() - edge - wider), float(across.max() + edge + wider)),
        *(float(up.min() - edge), float(up.max() + edge)),
    )


def shape_rows(case: str, label: str, instant: str, shapes: Shapes, snapshot: int) -> Any:
    """The numbers of a drawn shape: points of the members, then states of their ends."""
    points = shapes.x.shape[1]
    share = np.linspace(0.0, 1.0, points)
    head = {"case": case, "label": label, "instant": instant, shapes.history: shapes.at[snapshot]}
    names: list[str] = [member.name for member in shapes.frame.members]
    blocks = [
        rows(
            {
                **head,
                "member": np.repeat(names, points),
                "point": np.tile(share, len(names)),
                "x_m": _flat(shapes.x, snapshot),
                "y_m": _flat(shapes.y, snapshot),
            },
            points * len(names),
        )
    ]
    if shapes.hinges:
        states = {"hinge": list(shapes.hinges), "utilisation": shapes.used[:, snapshot]}
        blocks.append(rows({**head, **states}, len(shapes.hinges)))
    return joined(blocks)


def _flat(values: Array, snapshot: int) -> Array:
    flat: Array = values[..., snapshot].ravel()
    return flat
