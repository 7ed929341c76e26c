"""Load-slip curves: laws with their bands over measured points.

Options: `cases` (the first case with answers counts).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.content.formatting import number, percent
from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.panels import name_axes, panel_grid
from workbench.report.figures.studs import (
    MILLI,
    campaign_looks,
    column,
    contents,
    handle,
    reference_rows,
)
from workbench.report.figures.style import legend_below

_LARGEST_SLIP = 10.0  # mm
_BAND = "#0072b2"
# no lines: some curves have nothing between half of the load and the peak
_FITTED: dict[str, Any] = {
    "color": "#8a8a8a",
    "linestyle": "none",
    "marker": ".",
    "markersize": 3.0,
}
_FEW = 5


def draw(request: Request) -> Drawing:
    """One panel per law: median, band, fitted curves in grey, unseen ones in colour."""
    found = {label: (case, content) for case, label, content in contents(request, "grid")}
    if not found:
        return nothing("No load-slip law has answered these cases.")
    case = next(iter(found.values()))[0]
    fitted = _curves(reference_rows(request, case, "calibration"))
    unseen = _curves(reference_rows(request, case, "validation"))
    looks = campaign_looks(campaign for campaign, _ in unseen)
    canvas, axes = panel_grid(len(found), height=2.35, share_x=True)
    blocks: list[Any] = []
    statements = []
    for i, (panel, (label, (_, content))) in enumerate(zip(axes, found.items(), strict=True)):
        _measured(panel, fitted, unseen, looks)
        blocks.append(_law(panel, label, content))
        panel.set_title(label, loc="left")
        name_axes(panel, i, len(found), "slip (mm)", "load over largest load")
        panel.set_xlim(0.0, _LARGEST_SLIP)
        panel.set_ylim(0.0, 1.12)
        statements.append(_sentence(label, content))
    few = sum(len(slip) < _FEW for slip, _ in fitted.values())
    if few:
        statements.append(
            f"{few} of the {len(fitted)} fitted curves have fewer than {_FEW} points, with none "
            "between half of the load and the peak: they hardly tell the shape there."
        )
    for kind, curves in (("fitted", fitted), ("unseen", unseen)):
        for (campaign, specimen), (slip, load) in curves.items():
            block = {"label": kind, "campaign": campaign, "specimen": specimen}
            block |= {"slip_m": slip / MILLI, "median": load}
            blocks.append(rows(block, len(slip)))
    handles: list[Any] = [
        handle("median of the law", color=_BAND, linewidth=1.8),
        Patch(color=_BAND, alpha=0.18, linewidth=0.0, label="90 % band of a further curve"),
        handle(f"{len(fitted)} fitted curves", **_FITTED),
    ]
    for campaign, look in looks.items():
        handles.append(handle(f"{campaign}, unseen", **_unseen(look)))
    legend_below(canvas, handles)
    alt = f"load over largest load against slip for {', '.join(found)}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _curves(points: list[dict[str, Any]]) -> dict[tuple[str, str], tuple[Any, Any]]:
    """Slip in mm and load over the largest load of every specimen."""
    result: dict[tuple[str, str], tuple[Any, Any]] = {}
    keys = dict.fromkeys((point["campaign"], point["specimen"]) for point in points)
    for key in keys:
        own = [p for p in points if (p["campaign"], p["specimen"]) == key]
        slip, load = MILLI * column(own, "slip"), column(own, "load")
        if len(own) > 1 and load.max() > 0.0:
            order = np.argsort(slip, kind="stable")
            result[key] = slip[order], load[order] / load.max()
    return result


def _measured(panel: Axes, fitted: Any, unseen: Any, looks: dict[str, dict[str, Any]]) -> None:
    for slip, load in fitted.values():
        panel.plot(slip, load, **_FITTED, zorder=2)
    for (campaign, _), (slip, load) in unseen.items():
        panel.plot(slip, load, **_unseen(looks[campaign]), zorder=3.5)


def _unseen(look: dict[str, Any]) -> dict[str, Any]:
    color = {"#0072b2": "#d55e00", "#d55e00": "#009e73"}.get(look["color"], look["color"])
    return {"color": color, "marker": look["marker"], "markersize": 2.4, "linewidth": 0.8}


def _law(panel: Axes, label: str, content: dict[str, Any]) -> Any:
    grid = content["grid"]
    slip = MILLI * np.array(grid["slip"])
    panel.plot(slip, grid["median"], color=_BAND, linewidth=1.8, zorder=4)
    block: dict[str, Any] = {"label": label, "slip_m": slip / MILLI, "median": grid["median"]}
    if "low" in grid:
        panel.fill_between(slip, grid["low"], grid["high"], color=_BAND, alpha=0.18, linewidth=0.0,
                           zorder=1)  # fmt: skip
        block |= {"low": grid["low"], "high": grid["high"]}
    return rows(block, len(slip))


def _sentence(label: str, content: dict[str, Any]) -> str:
    text = f"{label}: "
    fit = content["fit"]
    if fit is None:
        text += "no fit"
    else:
        text += f"{fit['curves']} curves fitted, median misfit {number(fit['median_rms'], 2)}"
    judgement = content.get("judgement")
    if judgement:
        text += (
            f"; on {judgement['curves']} unseen curves misfit {number(judgement['median_rms'], 2)}"
        )
        if judgement["coverage"] is not None:
            text += f", {percent(judgement['coverage'], signed=False)} of their points in the band"
        if judgement["stiffness"]:
            ratio = judgement["stiffness"]["test_over_prediction"]
            text += f", stiffness {number(ratio, 3)} times the predicted one"
    return text + "."
