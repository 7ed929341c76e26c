"""Test against prediction of shear strength, one panel per formula or model.

Options: `cases`; the first case that a label answers counts, and tests that its fit had not seen
are filled.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.content.formatting import number
from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.panels import name_axes, panel_grid
from workbench.report.figures.studs import KILO, campaign_looks, column, contents, handle, points
from workbench.report.figures.style import INK, MUTED, legend_below

_SPREAD = 0.2
_NAMED_BELOW = 0.85  # of the prediction: such a test is named


def draw(request: Request) -> Drawing:
    """Measured strength up, predicted strength across; below the line a prediction is unsafe."""
    found: dict[str, dict[str, Any]] = {}
    for _, label, content in contents(request, "tests"):
        if content.get("fit", {}).get("parameters"):
            found.setdefault(label, content)
    if not found:
        return nothing("No formula of shear strength has answered these cases.")
    series = {label: _points(content) for label, content in found.items()}
    looks = campaign_looks(point["campaign"] for points_ in series.values() for point in points_)
    top = 1.06 * max(max(p["test"], p["prediction"]) for each in series.values() for p in each)
    canvas, axes = panel_grid(len(series), height=2.45, share_x=True)
    blocks = []
    statements = []
    for i, (panel, (label, tests)) in enumerate(zip(axes, series.items(), strict=True)):
        _panel(panel, tests, looks, KILO * top)
        panel.set_title(label, loc="left")
        name_axes(panel, i, len(series), "prediction (kN per stud)", "test (kN per stud)")
        note, text = _summary(label, found[label])
        panel.text(0.96, 0.13, note, transform=panel.transAxes, ha="right", fontsize=7.0)
        statements.append(text)
        blocks.append(rows({"label": label, **_columns(tests)}, len(tests)))
    handles: list[Any] = [
        handle(f"{name}, fitted", **points(**look)) for name, look in looks.items()
    ]
    unseen = {p["campaign"] for each in series.values() for p in each if p["unseen"]}
    handles += [handle(f"{name}, unseen", **points(**looks[name], filled=True))
                for name in looks if name in unseen]  # fmt: skip
    handles.append(handle("test = prediction", color=INK, linewidth=0.9))
    handles.append(handle("± 20 %", color=MUTED, linewidth=0.7, linestyle=":"))
    legend_below(canvas, handles)
    alt = f"measured against predicted strength of push-outs for {', '.join(series)}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _points(content: dict[str, Any]) -> list[dict[str, Any]]:
    """Fitted tests and unseen ones (N), whatever model they come from."""
    result = []
    for row in content["tests"]:
        test = row.get("test", row.get("strength_test"))
        prediction = row.get("prediction", row.get("strength_model"))
        result.append({"campaign": row["campaign"], "specimen": row["specimen"], "test": test,
                       "prediction": prediction, "unseen": False})  # fmt: skip
    if "basis" in content:  # a model that is judged where it is calibrated elsewhere
        result += [{**row, "unseen": True} for row in content.get("judged") or []]
    return result


def _panel(
    panel: Axes, tests: list[dict[str, Any]], looks: dict[str, dict[str, Any]], top: float
) -> None:
    line = np.array([0.0, top])
    panel.fill_between(line, line, 0.0, color="#d55e00", alpha=0.06, linewidth=0.0)
    panel.plot(line, line, color=INK, linewidth=0.9)
    for factor in (1.0 - _SPREAD, 1.0 + _SPREAD):
        panel.plot(line, factor * line, color=MUTED, linewidth=0.7, linestyle=":")
    for name, look in looks.items():
        for unseen in (False, True):
            own = [t for t in tests if t["campaign"] == name and t["unseen"] is unseen]
            if own:
                style = points(**look, filled=unseen)
                panel.plot(KILO * column(own, "prediction"), KILO * column(own, "test"), **style)
    worst = min(tests, key=lambda test: test["test"] / test["prediction"])
    if worst["test"] < _NAMED_BELOW * worst["prediction"]:
        at = KILO * worst["prediction"], KILO * worst["test"]
        panel.annotate(worst["specimen"], at, (0, -5), textcoords="offset points", fontsize=6.5,
                       ha="center", va="top", annotation_clip=True)  # fmt: skip
    panel.text(0.96 * top, 0.04 * top, "unsafe", color="#a04000", fontsize=7.0, ha="right")
    panel.set_xlim(0.0, top)
    panel.set_ylim(0.0, top)
    panel.set_box_aspect(1.0)


def _summary(label: str, content: dict[str, Any]) -> tuple[str, str]:
    """What stands in the panel, and the sentence below the figure."""
    fit = content["fit"]
    bias = fit["parameters"].get("bias")
    if bias is None:
        scatter = fit["scatter"]["strength"]
        text = f"{label}: calibrated on {fit['tests']} tests, scatter there {number(scatter, 2)}"
        judgement = content.get("judgement")
        if judgement:
            least = number(judgement["least_test_over_prediction"], 3)
            text += f"; unseen tests from {least} of the prediction on"
        return f"scatter {number(scatter, 2)}", text + "."
    low, high = bias["profile"]["low"], bias["profile"]["high"]
    span = "interval open" if None in (low, high) else f"{number(low, 3)} to {number(high, 3)}"
    text = (
        f"{label}: median of test over prediction {number(bias['value'], 3)} ({span}), scatter "
        f"{number(fit['sigma']['value'], 2)} within campaigns."
    )
    return f"median {number(bias['value'], 3)}\n({span})", text


def _columns(tests: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "campaign": [t["campaign"] for t in tests],
        "specimen": [t["specimen"] for t in tests],
        "unseen": [t["unseen"] for t in tests],
        "prediction_N": column(tests, "prediction"),
        "test_N": column(tests, "test"),
    }
