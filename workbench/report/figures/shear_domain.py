"""Where shear-free models end: ratio of final forces against the shear force over V_pl.

Options: `against` (the shear-free label, default the reference), `tolerance` (default 0.05),
`group` (case parameter that tells the series of a model apart).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.style import INK, MUTED, legend_below, new_figure
from workbench.responses import Response

Array = NDArray[np.float64]
_MARKERS = ("o", "s", "^", "D", "v")


def draw(request: Request) -> Drawing:
    """One series per model and group; the utilisation is that of the shear-free model."""
    against = str(request.option("against", request.study.reference))
    tolerance = float(request.option("tolerance", 0.05))
    group = str(request.option("group", ""))
    points: dict[tuple[str, str], list[tuple[float, float, str]]] = {}
    statements: list[str] = []
    for case in request.cases:
        free = request.stored.response(case.name, against)
        if free is None or not {"shear_utilisation", "force"} <= set(free.data_vars):
            statements.append(f"{case.name}: no force and shear force from {against}.")
            continue
        x = float(free["shear_utilisation"].max())
        for label in request.shown(case):
            response = request.stored.response(case.name, label)
            if label == against:
                continue
            if response is None or "force" not in response:
                statements.append(f"{case.name}: no force from {label}.")
                continue
            ratio = _final_force(response) / _final_force(free)
            series = points.setdefault((label, str(case.parameters.get(group, ""))), [])
            series.append((x, ratio, case.name))
    if not points:
        return nothing(*statements)
    canvas = new_figure(3.4)
    panel = canvas.subplots()
    groups = list(dict.fromkeys(name for _, name in points))
    blocks: list[Any] = []
    for (label, name), series in points.items():
        series.sort()
        xs = np.array([point[0] for point in series])
        ys = np.array([point[1] for point in series])
        panel.plot(
            *(xs, ys),
            color=request.looks[label].color,
            marker=_MARKERS[groups.index(name) % len(_MARKERS)],
            markersize=4.0,
            linewidth=1.1,
            linestyle="-" if groups.index(name) == 0 else "--",
            label=f"{label}, {name}" if name else label,
        )
        blocks.append(
            rows(
                {
                    "case": [point[2] for point in series],
                    "label": label,
                    "group": name,
                    "shear_over_plastic_shear": xs,
                    "force_ratio": ys,
                },
                len(xs),
            )
        )
        statements.append(f"{label}{', ' + name if name else ''}: {_bound(xs, ys, tolerance)}.")
    panel.axhspan(1.0 - tolerance, 1.0 + tolerance, color=MUTED, alpha=0.18, linewidth=0.0)
    panel.axhline(1.0, color=INK, linewidth=0.6)
    panel.set_xlabel(f"V/Vpl in {against}")
    panel.set_ylabel(f"force over that of {against}")
    panel.set_xlim(left=0.0)
    legend_below(canvas, panel.get_legend_handles_labels()[0])
    alt = f"ratio of the final force to that of {against} over its shear force"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def crossing(x: Array, ratio: Array, tolerance: float) -> float | None:
    """First x (rising) at which |ratio - 1| passes the tolerance for good, interpolated.

    Infinite if it stays within, None if it is outside from the first point on.
    """
    outside = np.abs(ratio - 1.0) > tolerance
    if not outside[-1]:
        return float("inf")
    inside = np.flatnonzero(~outside)
    if len(inside) == 0:
        return None
    last = int(inside[-1])
    error = np.abs(ratio - 1.0)
    share = (tolerance - error[last]) / (error[last + 1] - error[last])
    return float(x[last] + share * (x[last + 1] - x[last]))


def _bound(x: Array, ratio: Array, tolerance: float) -> str:
    found = crossing(x, ratio, tolerance)
    percent = f"{100.0 * tolerance:g} %"
    if found is None:
        return f"further off than {percent} at every V/Vpl from {x[0]:.2f} on"
    if np.isinf(found):
        return f"within {percent} up to V/Vpl = {x[-1]:.2f}, the largest that was run"
    return f"beyond V/Vpl = {found:.2f} further off than {percent}"


def _final_force(response: Response) -> float:
    return float(response["force"].values[-1])
