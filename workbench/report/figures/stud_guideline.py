"""The guideline chart: what is left of a stud against its damage, with the grade of the evidence.

Options: `cases`: questions of residual strength or stiffness; one row each.
"""

import textwrap
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes

from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, framed

# validated by tests of several campaigns or not
_COLORS = {True: "#009e73", False: "#d55e00"}
# tests or a prediction behind it
_BANDS = {True: "band of a new test", False: "range over what is assumed"}
AXES = {
    "displacement ratio": "uplift over the uplift at failure",
    "load ratio": "tension over the pull-out resistance",
    "life fraction": "share of the fatigue life",
    "S-N life fraction": "share of the fatigue life by EN 1994-1-1",
    "section loss": "share of the section lost",
}


def draw(request: Request) -> Drawing:
    """A panel per quantity and measure of damage; every panel carries its grade."""
    found = [each for each in studs.contents(request, "curve") if "grade" in each[2].get("fit", {})]
    if not found:
        return nothing("No residual capacity has been answered in these cases.")
    return plot([(case.name, label, content) for case, label, content in found])


def plot(found: Sequence[tuple[str, str, studs.Content]]) -> Drawing:
    """A row for each case and a column for each label, of which the contents are given."""
    cases = list(dict.fromkeys(case for case, _, _ in found))
    labels = list(dict.fromkeys(label for _, label, _ in found))
    sheet = Sheet.table(len(cases), len(labels), 2.55 * len(cases) + 0.6, sharey="row")
    tests = [test for _, _, content in found for test in content["tests"]]
    looks = studs.campaign_looks((test["campaign"] for test in tests), filled=True)
    for case, label, content in found:
        place = cases.index(case) * len(labels) + labels.index(label)
        panel, fit = sheet.panels[place], content["fit"]
        sheet.record(case=case, label=label, **_panel(panel, content))
        studs.draw_tests(panel, studs.table_of(content["tests"]), "level", "ratio", looks)
        panel.set_xlabel(AXES.get(fit["measure"], f"damage ({fit['measure']})"))
        if case == cases[0]:
            panel.set_title(label, loc="left")
        if label == labels[0]:
            panel.set_ylabel(f"{fit['quantity']} left")
        sentence = _sentence(content)
        sheet.notes += [] if sentence in sheet.notes else [sentence]
    for panel in sheet.panels:
        if not panel.lines:
            panel.remove()
    for _, _, content in sorted(found, key=lambda each: not each[2]["validated"]):
        names = "what is left", _BANDS[bool(content["tests"])]
        entries = studs.band_entries(_COLORS[content["validated"]], *names)
        sheet.legend(*entries[: 1 if content["curve"]["low"] is None else 2])
    sheet.legend(*studs.test_entries(looks, "tests"))
    return sheet.finish(f"residual capacity of a stud against damage: {', '.join(cases)}")


def _panel(panel: Axes, content: studs.Content) -> dict[str, Any]:
    """The curve with its band and its grade; returns what was drawn."""
    curve, color = studs.table_of(content["curve"]), _COLORS[content["validated"]]
    tested = curve[~curve["extrapolated"].astype(bool)]
    beyond = curve[curve["level"] >= tested["level"].max()]
    studs.draw_band(panel, tested, "level", "left", color)
    if len(beyond) > 1:
        panel.plot(beyond["level"], beyond["left"], color=color, linestyle=":")
        panel.axvline(float(tested["level"].max()), color=INK, linewidth=0.5, linestyle="--")
    panel.axhline(1.0, color=INK, linewidth=0.6, zorder=2)
    panel.set(xlim=(0.0, float(curve["level"].max())), ylim=(0.0, 1.25))
    grade = "\n".join(textwrap.wrap(content["fit"]["grade"], 44, break_on_hyphens=False))
    framed(panel, 0.03, 0.05, grade, color, fontsize=7.0, fontweight="bold")
    return {name: curve[name] for name in ("level", "left", "low", "high") if name in curve}


def _sentence(content: studs.Content) -> str:
    fit, curve = content["fit"], content["curve"]
    beyond = zip(curve["left"], curve["extrapolated"], strict=True)
    known = [(i, left) for i, (left, out) in enumerate(beyond) if left is not None and not out]
    at, left = known[-1]
    level = curve["level"][at]
    text = f"{fit['quantity'].capitalize()} by {fit['measure']}: {left:.2f} left at level {level:g}"
    if curve["low"] is not None:
        text += f" (from {curve['low'][at]:.2f} to {curve['high'][at]:.2f})"
    return f"{text}, stud {fit['stud']}; {fit['grade']}."
