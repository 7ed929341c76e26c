"""Where the mechanical stud fails: ratios by campaign, and predicted curves over measured ones.

Options: `cases`: the one with the judged model, and the one whose tests hold load-slip points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import number
from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.studs import (
    KILO,
    MILLI,
    campaign_looks,
    column,
    contents,
    handle,
    points,
    reference_rows,
)
from workbench.report.figures.style import INK, MUTED, legend_below, new_figure

_MOST = 3  # studs with a curve


def draw(request: Request) -> Drawing:
    """Left the ratios of all tests, right one panel per unseen stud."""
    mechanical = (each for each in contents(request, "judged") if "basis" in each[2])
    found = next(mechanical, None)
    if found is None:
        return nothing("No mechanical prediction has been judged by unseen tests.")
    _, label, content = found
    curves = content["curves"][:_MOST]
    canvas = new_figure(2.9)
    axes = canvas.subplots(1, 1 + len(curves), width_ratios=[1.05, *[1.0] * len(curves)],
                           squeeze=False)[0]  # fmt: skip
    looks = campaign_looks(
        [r["campaign"] for r in content["tests"]] + [r["campaign"] for r in content["judged"]]
    )
    blocks = [_ratios(axes[0], content, looks)]
    for panel, curve in zip(axes[1:], curves, strict=True):
        blocks.append(_curve(panel, curve, _measured(request, curve), looks))
    judgement = content["judgement"]
    statements = [
        f"{label}: {content['basis']}.",
        f"Of {judgement['tests']} unseen tests the worst, {judgement['worst']}, bore "
        f"{number(judgement['least_test_over_prediction'], 2)} of the prediction: the model knows "
        "no cracking or splitting of the slab.",
    ]
    handles = [handle(f"{name}, calibration" if i == 0 else f"{name}, unseen",
                      **points(**look, filled=i > 0))
               for i, (name, look) in enumerate(looks.items())]  # fmt: skip
    handles += [handle("predicted", color=INK, linewidth=1.5),
                handle("of it through the weld collar", color=MUTED, linewidth=0.9,
                       linestyle="--")]  # fmt: skip
    legend_below(canvas, handles)
    alt = "test over prediction of the mechanical stud, and its load-slip curves for unseen studs"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _ratios(panel: Axes, content: dict[str, Any], looks: dict[str, dict[str, Any]]) -> Any:
    entries = [(r["campaign"], r["specimen"], r["strength_ratio"], False) for r in content["tests"]]
    entries += [(r["campaign"], r["specimen"], r["ratio"], True) for r in content["judged"]]
    names = list(looks)
    for name in names:
        own = [entry for entry in entries if entry[0] == name]
        spread = np.linspace(-0.22, 0.22, len(own)) if len(own) > 1 else np.zeros(1)
        for offset, (_, specimen, ratio, unseen) in zip(spread, own, strict=True):
            at = names.index(name) + offset
            panel.plot([at], [ratio], **points(**looks[name], filled=unseen))
            if unseen:
                panel.annotate(specimen, (at, ratio), (6, -3), textcoords="offset points",
                               fontsize=7.0)  # fmt: skip
    panel.axhline(1.0, color=INK, linewidth=0.9, zorder=1)
    panel.axhspan(0.0, 0.85, color="#d55e00", alpha=0.06, linewidth=0.0)
    panel.set_xticks(range(len(names)), names)
    panel.set_xlim(-0.5, len(names) - 0.5)
    values = [entry[2] for entry in entries]
    panel.set_ylim(min(0.6, 0.92 * min(values)), 1.08 * max(values))
    panel.set_ylabel("test over prediction, strength")
    panel.grid(visible=False, axis="x")
    columns = zip(*entries, strict=True)
    block = dict(zip(("campaign", "specimen", "test_over_prediction", "unseen"), columns,
                     strict=True))  # fmt: skip
    return rows({key: list(value) for key, value in block.items()}, len(entries))


def _measured(request: Request, curve: dict[str, Any]) -> list[dict[str, Any]]:
    key = (curve["campaign"], curve["specimen"])
    for case in request.cases:
        own = [
            row
            for part in ("calibration", "validation")
            for row in reference_rows(request, case, part)
            if "slip" in row and (row["campaign"], row["specimen"]) == key
        ]
        if own:
            return own
    return []


def _curve(
    panel: Axes,
    curve: dict[str, Any],
    measured: list[dict[str, Any]],
    looks: dict[str, dict[str, Any]],
) -> Any:
    slip, load = MILLI * np.array(curve["slip"]), KILO * np.array(curve["load"])
    panel.plot(slip, load, color=INK, linewidth=1.5)
    panel.plot(slip, KILO * np.array(curve["collar"]), color=MUTED, linewidth=0.9, linestyle="--")
    block = {"campaign": curve["campaign"], "specimen": curve["specimen"], "curve": "predicted"}
    blocks = [rows({**block, "slip_m": slip / MILLI, "load_N": load / KILO}, len(slip))]
    if measured:
        x, y = MILLI * column(measured, "slip"), KILO * column(measured, "load")
        panel.plot(x, y, **points(**looks[curve["campaign"]], filled=True, size=3.2))
        block["curve"] = "measured"
        blocks.append(rows({**block, "slip_m": x / MILLI, "load_N": y / KILO}, len(x)))
    panel.set_title(f"{curve['campaign']} {curve['specimen']}", loc="left")
    panel.set_xlabel("slip (mm)")
    panel.set_ylabel("load (kN per stud)")
    panel.set_xlim(left=0.0)
    panel.set_ylim(bottom=0.0)
    return joined(blocks)
