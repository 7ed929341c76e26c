"""The guideline chart: what is left of a stud against its damage, with the grade of the evidence.

Options: `cases`: questions of residual strength or stiffness; one row each.
"""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.studs import campaign_looks, column, contents, handle, points
from workbench.report.figures.style import INK, legend_below, new_figure

_COLORS = {True: "#009e73", False: "#d55e00"}  # validated by tests of several campaigns or not
AXES = {
    "displacement ratio": "uplift over the uplift at failure",
    "load ratio": "tension over the pull-out resistance",
    "life fraction": "share of the fatigue life",
    "section loss": "share of the section lost",
}


def draw(request: Request) -> Drawing:
    """A panel per quantity and measure of damage; every panel carries its grade."""
    found = [
        (case, label, content)
        for case, label, content in contents(request, "curve")
        if "grade" in content.get("fit", {})
    ]
    if not found:
        return nothing("No residual capacity has been answered in these cases.")
    cases = list(dict.fromkeys(case.name for case, _, _ in found))
    labels = list(dict.fromkeys(label for _, label, _ in found))
    canvas = new_figure(2.55 * len(cases) + 0.6)
    axes = canvas.subplots(len(cases), len(labels), sharey="row", squeeze=False)
    blocks: list[Any] = []
    statements = []
    looks = campaign_looks(test["campaign"] for _, _, c in found for test in c["tests"])
    colors = set()
    for case, label, content in found:
        panel = axes[cases.index(case.name), labels.index(label)]
        colors.add(_COLORS[content["validated"]])
        blocks.append(_panel(panel, content, looks, case.name, label))
        fit = content["fit"]
        panel.set_xlabel(AXES.get(fit["measure"], f"damage ({fit['measure']})"))
        if case.name == cases[0]:
            panel.set_title(label, loc="left")
        if label == labels[0]:
            panel.set_ylabel(f"{fit['quantity']} left")
        statements.append(_sentence(content))
    for panel in axes.flat:
        if not panel.lines:
            panel.remove()
    handles: list[Any] = []
    for color in sorted(colors):
        handles.append(handle("what is left", color=color, linewidth=1.8))
        band = "range over what is assumed" if color == _COLORS[False] else "band of a new test"
        handles.append(Patch(color=color, alpha=0.18, linewidth=0.0, label=band))
    handles += [handle(f"{n}, tests", **points(**look, filled=True)) for n, look in looks.items()]
    legend_below(canvas, handles)
    alt = f"residual capacity of a stud against damage: {', '.join(cases)}"
    return Drawing(canvas, joined(blocks), tuple(dict.fromkeys(statements)), alt)


def _panel(
    panel: Axes, content: dict[str, Any], looks: dict[str, dict[str, Any]], case: str, label: str
) -> Any:
    curve, color = content["curve"], _COLORS[content["validated"]]
    level, left = np.array(curve["level"]), column([{"x": v} for v in curve["left"]], "x")
    panel.plot(level, left, color=color, linewidth=1.8, zorder=4)
    block: dict[str, Any] = {"case": case, "label": label, "level": level, "left": left}
    if curve["low"] is not None:
        low, high = (column([{"x": v} for v in curve[n]], "x") for n in ("low", "high"))
        panel.fill_between(level, low, high, color=color, alpha=0.18, linewidth=0.0, zorder=1)
        block |= {"low": low, "high": high}
    for campaign, look in looks.items():
        own = [test for test in content["tests"] if test["campaign"] == campaign]
        if own:
            panel.plot(column(own, "level"), column(own, "ratio"), **points(**look, filled=True))
    panel.axhline(1.0, color=INK, linewidth=0.6, zorder=2)
    panel.set_xlim(0.0, 1.0)
    panel.set_ylim(0.0, 1.25)
    grade = "\n".join(textwrap.wrap(content["fit"]["grade"], 44, break_on_hyphens=False))
    panel.text(0.03, 0.05, grade, transform=panel.transAxes, fontsize=7.0, color=color, va="bottom",
               fontweight="bold", zorder=6,
               bbox={"facecolor": "white", "edgecolor": color, "linewidth": 0.8, "alpha": 0.92,
                     "boxstyle": "round,pad=0.35"})  # fmt: skip
    return rows(block, len(level))


def _sentence(content: dict[str, Any]) -> str:
    fit, curve = content["fit"], content["curve"]
    known = [(d, r) for d, r in zip(curve["level"], curve["left"], strict=True) if r is not None]
    level, left = known[-1]
    text = f"{fit['quantity'].capitalize()} by {fit['measure']}: {left:.2f} left at level {level:g}"
    if curve["low"] is not None:
        at = curve["level"].index(level)
        text += f" (from {curve['low'][at]:.2f} to {curve['high'][at]:.2f})"
    return f"{text}; {fit['grade']}."
