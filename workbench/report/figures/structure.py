"""The structure to scale: column with supports, load, spring, striker, dimensions and section.

Options: `case` (a name; default every different column of the cases, two at most).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.pieces import (
    LIGHT,
    SMALL,
    STEEL,
    arrow,
    cross_section,
    dimension,
    ground,
    hinge_support,
    side_roller,
    spring,
)
from workbench.report.figures.style import INK, MUTED, PALETTE, new_figure
from workbench.scenarios import Column, ColumnImpact, ColumnPushover
from workbench.study.definition import Case

_MOST = 2
_WIDTH, _BELOW = 1.5, 0.15  # of the picture, over the length of the column


def draw(request: Request) -> Drawing:
    """Every different column once, with all velocities that hit it."""
    named = request.option("case", "")
    groups = _groups([case for case in request.cases if not named or case.name == named])
    if not groups:
        return nothing("None of the cases is a column, the only structure drawn so far.")
    statements = []
    if len(groups) > _MOST:
        statements.append(f"Shown are the first {_MOST} of {len(groups)} different columns.")
        groups = groups[:_MOST]
    height = max(_top(column) for column, _ in groups) + _BELOW
    wide = 3.3 if len(groups) == 2 else 3.5
    canvas = new_figure(wide * height / _WIDTH + 0.3, width=wide * len(groups))
    axes = canvas.subplots(1, len(groups), squeeze=False)[0]
    blocks: list[Any] = []
    for (column, cases), panel in zip(groups, axes, strict=True):
        _column(panel, column, cases)
        if len(groups) > 1:
            panel.set_title(cases[0].name, loc="left")
        properties = column.properties
        entry = {
            "case": cases[0].name,
            "length_below_m": column.length_below,
            "length_above_m": column.length_above,
            "area_m2": properties.area,
            "second_moment_m4": properties.second_moment,
            "plastic_moment_Nm": properties.plastic_moment,
            "squash_load_N": properties.squash_load,
            "shear_resistance_N": properties.shear_resistance,
            "mass_per_length_kg_per_m": properties.mass_per_length,
        }
        blocks.append(rows(entry, 1))
    alt = "; ".join(_words(column) for column, _ in groups)
    return Drawing(canvas, joined(blocks), tuple(statements), alt, (0.52, 1.0)[len(groups) - 1])


def _top(column: Column) -> float:
    """Upper edge of the picture over the length of the column."""
    if column.restraint_stiffness:
        return 1.34
    if column.axial_load or column.head_mass:
        return 1.25
    return 1.1


def _groups(cases: list[Case]) -> list[tuple[Column, list[Case]]]:
    found: list[tuple[Column, list[Case]]] = []
    for case in cases:
        scenario = case.scenario
        if not isinstance(scenario, (ColumnImpact, ColumnPushover)):
            continue
        # pushover and impact of one column share a picture
        same = [group for group in found if replace(group[0]) == scenario.column]
        if same:
            same[0][1].append(case)
        else:
            found.append((scenario.column, [case]))
    return found


def _words(column: Column) -> str:
    return (
        f"column {column.section.name}, {column.length:.4g} m high, {column.base} base, "
        f"{column.head} head, hit {column.length_below:.4g} m above the base"
    )


def _column(panel: Axes, column: Column, cases: list[Case]) -> None:
    length, hit, depth = column.length, column.length_below, column.section.height
    size = 0.16 * length
    panel.set_aspect("equal")
    panel.axis("off")
    # the member, at least 1.5 % of its length wide so that it can be seen
    shown = max(depth, 0.015 * length)
    panel.add_patch(
        Rectangle((-shown / 2, 0.0), shown, length, facecolor=STEEL, edgecolor=INK, linewidth=0.9)
    )
    if column.base == "clamped":
        ground(panel, 0.0, 0.0, 1.6 * size)
    else:
        hinge_support(panel, 0.0, 0.0, 0.8 * size)
    top = _head(panel, column, size, shown)
    _load(panel, column, size, top)
    _strike(panel, cases, column, size, shown)
    right, tick = 0.23 * length, 0.012 * length
    for x, low, high in (
        (right, 0.0, hit),
        (right, hit, length),
        (right + 0.17 * length, 0.0, length),
    ):
        dimension(panel, (x, low), (x, high), f"{high - low:.4g} m", tick=tick)
    for y in (0.0, hit, length):
        panel.plot(
            [shown, right + 0.19 * length], [y, y], color=MUTED, linewidth=0.4, linestyle=":"
        )
    _section(panel, column, length)
    panel.set_xlim(-0.55 * length, (_WIDTH - 0.55) * length)
    panel.set_ylim(-_BELOW * length, _top(column) * length)


def _head(panel: Axes, column: Column, size: float, shown: float) -> float:
    """Draw the head support; return the height above which loads may be drawn."""
    length = column.length
    if column.head == "fixed":
        ground(panel, 0.0, length, 1.6 * size, up=False)
        return length + 0.4 * size
    if column.head == "guided":
        for side in (-1.0, 1.0):
            for y in (length - 0.05 * size, length - 0.55 * size):
                side_roller(panel, side * shown / 2, y, 0.75 * size, side)
        return length
    side_roller(panel, shown / 2, length, 0.9 * size, 1.0)
    return length


def _load(panel: Axes, column: Column, size: float, top: float) -> None:
    if column.restraint_stiffness:
        x, ceiling = 0.5 * size, column.length + 1.7 * size
        start = column.length
        panel.plot([0.0, x], [start, start], color=INK, linewidth=1.0)
        spring(panel, x, start, ceiling, 0.36 * size)
        ground(panel, x, ceiling, 1.1 * size, up=False)
        panel.text(
            x + 0.4 * size,
            column.length + 0.85 * size,
            f"{column.restraint_stiffness / 1e6:.4g} kN/mm",
            fontsize=SMALL,
            va="center",
        )
    if column.axial_load:
        down = column.axial_load > 0.0
        low, high = (0.0, top), (0.0, top + 1.25 * size)
        arrow(panel, high if down else low, low if down else high, PALETTE[1])
        panel.text(
            *(-0.2 * size, top + 1.0 * size, f"{abs(column.axial_load) / 1e3:.4g} kN"),
            fontsize=SMALL,
            ha="right",
            color=PALETTE[1],
        )
    if column.head_mass:
        side = 0.5 * size
        panel.add_patch(
            Rectangle((-side / 2, top), side, side, facecolor=LIGHT, edgecolor=INK, linewidth=0.9)
        )
        panel.text(
            *(-0.35 * size, top + side / 2, f"{column.head_mass:.4g} kg"),
            fontsize=SMALL,
            ha="right",
            va="center",
        )


def _strike(panel: Axes, cases: list[Case], column: Column, size: float, shown: float) -> None:
    hit = column.length_below
    impacts = [c.scenario for c in cases if isinstance(c.scenario, ColumnImpact)]
    end = (-shown / 2, hit)
    if not impacts:
        arrow(panel, (-2.0 * size, hit), end, PALETTE[0])
        panel.text(-1.2 * size, hit + 0.2 * size, "force", fontsize=SMALL, ha="center")
        return
    side = 0.85 * size
    left = -shown / 2 - 2.4 * size
    panel.add_patch(
        Rectangle((left, hit - side / 2), side, side, facecolor=LIGHT, edgecolor=INK, linewidth=0.9)
    )
    arrow(panel, (left + side, hit), end, PALETTE[0])
    masses = sorted({impact.striker.mass for impact in impacts})
    speeds = sorted({impact.striker.velocity for impact in impacts})
    panel.text(
        *(left, hit + 0.75 * side, f"{_listed(speeds)} m/s"), fontsize=SMALL, color=PALETTE[0]
    )
    panel.text(left, hit - 1.05 * side, f"{_listed(masses)} kg", fontsize=SMALL)


def _listed(values: list[float]) -> str:
    if len(values) > 4:
        return f"{values[0]:.4g} to {values[-1]:.4g}"
    return ", ".join(f"{value:.4g}" for value in values)


def _section(panel: Axes, column: Column, length: float) -> None:
    """The cross section beside the column, enlarged, with its own dimensions."""
    section = column.strength_section
    scale = 0.30 * length / max(section.height, section.width)
    centre = (0.70 * length, 0.60 * length)
    cross_section(panel, section, centre, scale)
    x, y = centre
    h, b = section.height * scale, section.width * scale
    tick, gap = 0.012 * length, 0.05 * length
    dimension(
        *(panel, (x + b / 2 + gap, y - h / 2), (x + b / 2 + gap, y + h / 2)),
        f"{1e3 * section.height:.4g} mm",
        tick=tick,
    )
    dimension(
        *(panel, (x - b / 2, y + h / 2 + gap), (x + b / 2, y + h / 2 + gap)),
        f"{1e3 * section.width:.4g} mm",
        tick=tick,
    )
    steel = f"{column.steel.yield_stress / 1e6:.4g} MPa"
    panel.text(
        *(x, y - h / 2 - 0.03 * length, f"{column.section.name}\n{steel}"),
        fontsize=SMALL,
        ha="center",
        va="top",
        linespacing=1.5,
    )
