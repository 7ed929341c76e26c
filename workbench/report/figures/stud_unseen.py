"""Where the mechanical stud fails: ratios by campaign, and predicted curves over measured ones.

Options: `cases`: the one with the judged model, and the one whose tests hold load-slip points.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from workbench.content.formatting import number
from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, MUTED, PALETTE, Look, Style, entry, new_figure

_MOST = 3  # studs with a curve
_SPREAD = 0.22  # half of the width over which the tests of a campaign stand side by side
_PREDICTED: Style = {"color": INK, "linewidth": 1.5}
_COLLAR: Style = {"color": MUTED, "linewidth": 0.9, "linestyle": "--"}


def draw(request: Request) -> Drawing:
    """Left the ratios of all tests, right one panel per unseen stud."""
    found = next((each for each in studs.contents(request, "judged") if "basis" in each[2]), None)
    if found is None:
        return nothing("No mechanical prediction has been judged by unseen tests.")
    _, label, content = found
    curves, judgement = content["curves"][:_MOST], content["judgement"]
    canvas = new_figure(2.9)
    widths = [1.05, *[1.0] * len(curves)]
    sheet = Sheet(canvas, canvas.subplots(1, len(widths), width_ratios=widths, squeeze=False)[0])
    tests = studs.judged_tests(label, content)[["campaign", "specimen", "ratio", "unseen"]]
    tests = tests.rename(columns={"ratio": "test_over_prediction"})
    looks = studs.campaign_looks(tests["campaign"])
    _ratios(sheet.panel, tests, list(looks), looks)
    sheet.record(tests)
    for panel, curve in zip(sheet.panels[1:], curves, strict=True):
        _curve(sheet, panel, curve, _measured(request, curve), looks)
    sheet.notes += [
        f"{label}: {content['basis']}.",
        f"Of {judgement['tests']} unseen tests the worst, {judgement['worst']}, bore "
        f"{number(judgement['least_test_over_prediction'], 2)} of the prediction: cracking "
        "and splitting of the slab enter through the limit of EN 1994-1-1 (mean form) alone.",
    ]
    for i, (name, look) in enumerate(looks.items()):
        known = f"{name}, unseen" if i else f"{name}, calibration"
        sheet.legend(entry(known, **(look._replace(filled=True) if i else look).points()))
    sheet.legend(entry("predicted", **_PREDICTED))
    sheet.legend(entry("of it through the weld collar", **_COLLAR))
    alt = "test over prediction of the mechanical stud, and its load-slip curves for unseen studs"
    return sheet.finish(alt)


def _ratios(panel: Axes, tests: pd.DataFrame, names: list[str], looks: Mapping[str, Look]) -> None:
    size = tests.groupby("campaign")["campaign"].transform("size")
    place = tests.groupby("campaign").cumcount() / (size - 1).clip(lower=1)
    slots = tests["campaign"].map({name: i for i, name in enumerate(names)})
    tests = tests.assign(at=slots + _SPREAD * (2.0 * place - 1.0) * (size > 1))
    studs.draw_tests(panel, tests, "at", "test_over_prediction", looks)
    for row in tests[tests["unseen"]].itertuples():
        beside: Style = {"xytext": (6, -3), "textcoords": "offset points", "fontsize": 7.0}
        panel.annotate(str(row.specimen), (row.at, row.test_over_prediction), **beside)
    panel.axhline(1.0, color=INK, linewidth=0.9, zorder=1)
    panel.axhspan(0.0, 0.85, color=PALETTE[1], alpha=0.06, linewidth=0.0)
    panel.set_xticks(range(len(names)), names)
    panel.set_xlim(-0.5, len(names) - 0.5)
    values = tests["test_over_prediction"]
    panel.set_ylim(min(0.6, 0.92 * values.min()), 1.08 * values.max())
    panel.set_ylabel("test over prediction, strength")
    panel.grid(visible=False, axis="x")


def _measured(request: Request, curve: studs.Content) -> pd.DataFrame:
    """The measured points of a stud, from the first case that has them."""
    for case in request.cases:
        both = [studs.measured(request, case, part) for part in ("calibration", "validation")]
        points = pd.concat([part for part in both if "slip" in part] or both[:1])
        if "slip" in points:
            same = points["specimen"].eq(curve["specimen"])
            points = points[same & points["campaign"].eq(curve["campaign"])]
            if len(points):
                return points
    return pd.DataFrame()


def _curve(
    sheet: Sheet, panel: Axes, curve: studs.Content, points: pd.DataFrame, looks: Mapping[str, Look]
) -> None:
    slip, load = np.array(curve["slip"]), np.array(curve["load"])
    panel.plot(studs.MILLI * slip, studs.KILO * load, **_PREDICTED)
    panel.plot(studs.MILLI * slip, studs.KILO * np.array(curve["collar"]), **_COLLAR)
    head = {"campaign": curve["campaign"], "specimen": curve["specimen"]}
    sheet.record(**head, curve="predicted", slip_m=slip, load_N=load)
    if len(points):
        look = looks[curve["campaign"]]._replace(filled=True).points(markersize=3.2)
        panel.plot(studs.MILLI * points["slip"], studs.KILO * points["load"], **look)
        sheet.record(**head, curve="measured", slip_m=points["slip"], load_N=points["load"])
    sheet.name(panel, f"{curve['campaign']} {curve['specimen']}", "", "load (kN per stud)")
    panel.set_xlabel("slip (mm)")
    panel.set_xlim(left=0.0)
    panel.set_ylim(bottom=0.0)
