"""Paths of the hinges in the plane of axial force and moment, with the yield surfaces.

Options: `case` (a name; default the first with hinge forces), `surfaces`: pairs (alpha, beta)
drawn besides the surface that the model states.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from workbench.report.figures.drawing import (
    Array,
    Drawing,
    Request,
    joined,
    nothing,
    rows,
)
from workbench.report.figures.panels import first_answered, name_axes, panel_grid
from workbench.report.figures.style import INK, MUTED, PALETTE, legend_below
from workbench.responses import Response
from workbench.study.definition import Case

_MOST_PANELS = 6
_MOST_POINTS = 1200


def draw(request: Request) -> Drawing:
    """One panel per label: N/Npl across, M/Mpl up, hinges as lines that end in a dot."""
    case, found, statements = first_answered(request, {"axial_force", "moment"}, "forces in hinges")
    if case is None:
        return nothing("No model states hinge forces over time for these cases.", *statements)
    if len(found) > _MOST_PANELS:
        statements.append(f"Shown are the first {_MOST_PANELS} of {len(found)} models.")
        found = dict(list(found.items())[:_MOST_PANELS])
    canvas, axes = panel_grid(len(found), height=2.5)
    blocks: list[Any] = []
    handles: list[Any] = []
    for i, ((label, response), panel) in enumerate(zip(found.items(), axes, strict=True)):
        handles.extend(_surfaces(request, case, label, panel))
        handles.extend(_paths(case, label, response, panel, blocks))
        panel.set_title(label, loc="left")
        name_axes(panel, i, len(found), "N/Nₚₗ (tension positive)", "M/Mₚₗ")
        panel.axhline(0.0, color=MUTED, linewidth=0.5)
        panel.axvline(0.0, color=MUTED, linewidth=0.5)
        panel.set_xlim(-1.12, 1.12)
        panel.set_ylim(-1.12, 1.12)
        panel.set_xticks([-1, -0.5, 0, 0.5, 1])
        panel.set_yticks([-1, -0.5, 0, 0.5, 1])
        panel.set_aspect("equal")
    legend_below(canvas, handles)
    statements.insert(0, f"Case: {case.name}. Dots mark the end of the record.")
    alt = f"axial force and moment of the hinges of {', '.join(found)} for {case.name}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _surfaces(request: Request, case: Case, label: str, panel: Axes) -> list[Line2D]:
    column = case.scenario.column
    n, m = column.strength_section.interaction_envelope()
    exact = {"color": "#9a9a9a", "linewidth": 2.6, "alpha": 0.7, "zorder": 1}
    _all_quadrants(panel, n, m, **exact)
    handles = [Line2D([], [], label="exact plastic envelope of the section", **exact)]  # type: ignore[arg-type]
    pairs = [(float(a), float(b)) for a, b in request.option("surfaces", ())]
    stated = getattr(request.study.models[label], "surface", None)
    if callable(stated):
        surface = stated(column)
        pairs.insert(0, (float(surface.alpha), float(surface.beta)))
    for i, (alpha, beta) in enumerate(dict.fromkeys(pairs)):
        share = np.linspace(0.0, 1.0, 121) ** 2
        style = {"color": INK, "linewidth": 1.0, "linestyle": ("--", ":", "-.")[i % 3], "zorder": 2}
        _all_quadrants(panel, share ** (1.0 / beta), (1.0 - share) ** (1.0 / alpha), **style)
        name = f"super-ellipse α = {alpha:.3g}, β = {beta:.3g}"
        handles.append(Line2D([], [], label=name, **style))  # type: ignore[arg-type]
    return handles


def _all_quadrants(panel: Axes, n: Array, m: Array, **style: Any) -> None:
    x = np.concatenate([n, n[::-1], -n, -n[::-1]])
    y = np.concatenate([m, -m[::-1], -m, m[::-1]])
    panel.plot(np.append(x, x[0]), np.append(y, y[0]), **style)


def _paths(
    case: Case, label: str, response: Response, panel: Axes, blocks: list[Any]
) -> list[Line2D]:
    properties = case.scenario.column.properties
    handles = []
    history = "time" if "time" in response.dims else "step"
    size = response.sizes[history]
    index = np.unique(np.linspace(0, size - 1, min(size, _MOST_POINTS)).astype(int))
    for i, name in enumerate(response["hinge"].values):
        color = PALETTE[i % len(PALETTE)]
        n = response["axial_force"].isel(hinge=i).values[index] / properties.squash_load
        m = response["moment"].isel(hinge=i).values[index] / properties.plastic_moment
        panel.plot(n, m, color=color, linewidth=0.9, zorder=3)
        panel.plot(n[-1:], m[-1:], color=color, marker="o", markersize=3.5, zorder=4)
        handles.append(Line2D([], [], color=color, label=f"hinge: {name}"))
        block = {
            "case": case.name,
            "label": label,
            "hinge": str(name),
            history: response[history].values[index],
            "axial_force_over_squash_load": n,
            "moment_over_plastic_moment": m,
        }
        blocks.append(rows(block, len(index)))
    return handles
