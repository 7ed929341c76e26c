"""Test against prediction of shear strength, one panel per formula or model.

Options: `cases`; the first case that a label answers counts, and tests that its fit had not seen
are filled.
"""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from workbench.content.formatting import number
from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import PALETTE, WARNING, Look, Style

_NAMED_BELOW = 0.85  # of the prediction: such a test is named


def draw(request: Request) -> Drawing:
    """Measured strength up, predicted strength across; below the line a prediction is unsafe."""
    found: dict[str, studs.Content] = {}
    for _, label, content in studs.contents(request, "tests"):
        if content.get("fit", {}).get("parameters"):
            found.setdefault(label, content)
    if not found:
        return nothing("No formula of shear strength has answered these cases.")
    return plot(found)


def plot(found: dict[str, studs.Content]) -> Drawing:
    """The contents of formulas by their labels."""
    tests = pd.concat([studs.judged_tests(*each) for each in found.items()]).drop(columns="ratio")
    looks = studs.campaign_looks(tests["campaign"])
    top = 1.06 * studs.KILO * float(np.max(tests[["test", "prediction"]].to_numpy(float)))
    sheet = Sheet.grid(len(found), height=2.45, sharex=True)
    for panel, (label, content) in zip(sheet.panels, found.items(), strict=True):
        own = tests[tests["label"] == label]
        _panel(panel, own, looks, top)
        sheet.name(panel, label, "prediction (kN per stud)", "test (kN per stud)")
        note, text = _summary(label, content)
        panel.text(0.96, 0.13, note, transform=panel.transAxes, ha="right", fontsize=7.0)
        sheet.notes.append(text)
        sheet.record(own.rename(columns={"prediction": "prediction_N", "test": "test_N"}))
    new = set(tests.loc[tests["unseen"], "campaign"])
    unseen = {name: look._replace(filled=True) for name, look in looks.items() if name in new}
    sheet.legend(*studs.test_entries(looks, "fitted"), *studs.test_entries(unseen, "unseen"))
    sheet.legend(*studs.diagonal_entries("test = prediction"))
    return sheet.finish(f"measured against predicted strength of push-outs for {', '.join(found)}")


def _panel(panel: Axes, tests: pd.DataFrame, looks: dict[str, Look], top: float) -> None:
    panel.fill_between([0.0, top], [0.0, top], 0.0, color=PALETTE[1], alpha=0.06, linewidth=0.0)
    studs.draw_diagonal(panel, top)
    shown = tests.assign(**studs.KILO * tests[["test", "prediction"]])
    studs.draw_tests(panel, shown, "prediction", "test", looks)
    worst = shown.iloc[int((shown["test"] / shown["prediction"]).argmin())]
    if worst["test"] < _NAMED_BELOW * worst["prediction"]:
        at = worst["prediction"], worst["test"]
        below: Style = {"textcoords": "offset points", "ha": "center", "va": "top", "fontsize": 6.5}
        panel.annotate(worst["specimen"], at, (0, -5), **below, annotation_clip=True)
    panel.text(0.96 * top, 0.04 * top, "unsafe", color=WARNING, fontsize=7.0, ha="right")


def _summary(label: str, content: studs.Content) -> tuple[str, str]:
    """What stands in the panel, and the sentence below the figure."""
    fit = content["fit"]
    bias = fit["parameters"].get("bias")
    if bias is None:
        scatter = number(fit["scatter"]["strength"], 2)
        text = f"{label}: calibrated on {fit['tests']} tests, scatter there {scatter}"
        judgement = content.get("judgement")
        if judgement:
            least = number(judgement["least_test_over_prediction"], 3)
            text += f"; unseen tests from {least} of the prediction on"
        return f"scatter {scatter}", f"{text}."
    low, high = bias["profile"]["low"], bias["profile"]["high"]
    span = "interval open" if None in (low, high) else f"{number(low, 3)} to {number(high, 3)}"
    median = number(bias["value"], 3)
    return f"median {median}\n({span})", (
        f"{label}: median of test over prediction {median} ({span}), scatter "
        f"{number(fit['sigma']['value'], 2)} within campaigns."
    )
