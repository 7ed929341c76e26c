"""Tension and shear together: laws, mechanical predictions, and tests where there are any."""

from __future__ import annotations

from typing import Any

from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.studs import campaign_looks, column, contents, handle, points
from workbench.report.figures.style import INK, new_figure

_LINES = {"five-thirds": "-", "linear": "--", "trilinear": "-."}


def draw(request: Request) -> Drawing:
    """Tension across, shear up, both over what the stud bears alone."""
    found = [
        (case, label, content)
        for case, label, content in contents(request, "tension")
        if hasattr(request.study.models[label], "law")
    ]
    if not found:
        return nothing("No interaction of tension and shear has answered these cases.")
    canvas = new_figure(3.7)
    panel = canvas.subplots()
    blocks: list[Any] = []
    handles: list[Any] = []
    tests: list[dict[str, Any]] = []
    statements = []
    for _, label, content in found:
        line = _LINES.get(str(getattr(request.study.models[label], "law", "")))
        x, y = content["tension"], content["shear"]
        if line is None:
            own = request.looks[label]
            style: dict[str, Any] = {"color": own.color, "marker": own.marker, "linewidth": 1.2,
                                     "markersize": 4.5, "zorder": 3}  # fmt: skip
            statements.append(f"{label}: stud {content['stud']}.")
        else:
            style = {"color": INK, "linestyle": line, "linewidth": 1.2}
        panel.plot(x, y, **style)
        handles.append(handle(label, **style))
        blocks.append(rows({"label": label, "tension_ratio": x, "shear_ratio": y}, len(x)))
        tests = tests or content["tests"]
    looks = campaign_looks(test["campaign"] for test in tests)
    for campaign, look in looks.items():
        those = [test for test in tests if test["campaign"] == campaign]
        style = points(**look, filled=True)
        panel.plot(column(those, "tension"), column(those, "shear"), **style)
        handles.append(handle(f"{campaign}, tests", **style))
        block = {"label": campaign, "tension_ratio": column(those, "tension")}
        blocks.append(rows({**block, "shear_ratio": column(those, "shear")}, len(those)))
    if not tests:
        panel.text(0.06, 0.06, "no combined test in the tables:\nnothing here is validated",
                   transform=panel.transAxes, fontsize=8.0, color="#a04000", va="bottom",
                   bbox={"facecolor": "white", "edgecolor": "#a04000", "linewidth": 0.8,
                         "boxstyle": "round,pad=0.4"})  # fmt: skip
        statements.append("No test combines tension and shear: the curves are not validated.")
    panel.set_xlim(0.0, 1.08)
    panel.set_ylim(0.0, 1.08)
    panel.set_aspect("equal")
    panel.set_xlabel("tension over pull-out resistance")
    panel.set_ylabel("shear over shear resistance")
    canvas.legend(handles=handles, loc="outside right upper")
    alt = f"interaction of tension and shear by {', '.join(label for _, label, _ in found)}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt, 0.9)
