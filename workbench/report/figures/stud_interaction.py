"""Tension and shear together: laws, mechanical predictions, and tests where there are any."""

from typing import Any

import numpy as np
import pandas as pd

from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, PALETTE, WARNING, Style, entry, framed
from workbench.studs.interaction import INTERACTIONS

Curve = tuple[str, Style, Any, Any]  # label, how it is drawn, tension and shear
_LINES = {"five-thirds": "-", "linear": "--", "trilinear": "-."}


def draw(request: Request) -> Drawing:
    """Tension across, shear up, both over what the stud bears alone."""
    laws = {label: getattr(model, "law", None) for label, model in request.study.models.items()}
    found = [
        (label, content)
        for _, label, content in studs.contents(request, "tension")
        if laws[label] is not None
    ]
    if not found:
        return nothing("No interaction of tension and shear has answered these cases.")
    curves, said = [], []
    for label, content in found:
        line, look = _LINES.get(str(laws[label])), request.looks[label]
        style: Style = {"color": INK, "linestyle": line, "linewidth": 1.2}
        if line is None:
            style |= {"color": look.color, "linestyle": "-", "marker": look.marker}
            style |= {"markersize": 4.5, "zorder": 3}
            said.append(f"{label}: stud {content['stud']}.")
        curves.append((label, style, content["tension"], content["shear"]))
    tests = (content["tests"] for _, content in found if content["tests"])
    return _drawn(curves, studs.table_of(next(tests, None)), said)


def plot(content: studs.Content) -> Drawing:
    """A fitted law with its tests, and the laws of the codes."""
    own = content["curve"]
    style: Style = {"color": PALETTE[0], "linewidth": 1.8, "zorder": 3}
    curves = [("fitted", style, own["tension"], own["shear"])]
    for name, law in INTERACTIONS.items():
        line: Style = {"color": INK, "linestyle": _LINES[name], "linewidth": 1.0}
        curves.append((name, line, own["tension"], law(np.array(own["tension"]))))
    return _drawn(curves, studs.table_of(content["tests"]), [])


def _drawn(curves: list[Curve], tests: pd.DataFrame, said: list[str]) -> Drawing:
    sheet = Sheet.table(1, 1, 3.7)
    sheet.notes += said
    panel = sheet.panel
    for label, style, tension, shear in curves:
        panel.plot(tension, shear, **style)
        sheet.legend(entry(label, **style))
        sheet.record(label=label, tension_ratio=tension, shear_ratio=shear)
    if tests.empty:
        words = "no combined test in the tables:\nnothing here is validated"
        framed(panel, 0.06, 0.06, words, WARNING, fontsize=8.0)
        sheet.notes.append("No test combines tension and shear: the curves are not validated.")
    else:
        looks = studs.campaign_looks(tests["campaign"], filled=True)
        studs.draw_tests(panel, tests, "tension", "shear", looks)
        sheet.legend(*studs.test_entries(looks, "tests"))
        ratios = {"tension_ratio": tests["tension"], "shear_ratio": tests["shear"]}
        sheet.record(label=tests["campaign"], **ratios)
    panel.set(xlim=(0.0, 1.08), ylim=(0.0, 1.08))
    panel.set_aspect("equal")
    sheet.name(panel, "", "tension over pull-out resistance", "shear over shear resistance")
    names = ", ".join(label for label, *_ in curves)
    return sheet.finish(f"interaction of tension and shear by {names}", beside="upper", width=0.9)
