"""Load-slip curves: laws with their bands over measured points.

Options: `cases` (the first case with answers counts).
"""

from typing import Any

import pandas as pd

from workbench.content.formatting import number, percent
from workbench.report.drawing import studs
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import PALETTE, Style, entry, numbered

_LARGEST_SLIP = 10.0  # mm
_LAW = PALETTE[0]
# no lines: some curves have nothing between half of the load and the peak
_FITTED: Style = {"color": "#8a8a8a", "linestyle": "none", "marker": ".", "markersize": 3.0}
_FEW = 5


def draw(request: Request) -> Drawing:
    """One panel per law: median, band, fitted curves in grey, unseen ones in colour."""
    found = {label: (case, content) for case, label, content in studs.contents(request, "grid")}
    if not found:
        return nothing("No load-slip law has answered these cases.")
    case = next(iter(found.values()))[0]
    points = (studs.measured(request, case, part) for part in ("calibration", "validation"))
    return plot({label: content for label, (_, content) in found.items()}, *points)


def plot(
    found: dict[str, studs.Content], calibration: pd.DataFrame, validation: pd.DataFrame
) -> Drawing:
    """The contents of laws by their labels, and points (SI) of fitted and of unseen curves."""
    fitted, unseen = _curves(calibration), _curves(validation)
    # the colour of the law is not used again
    campaigns = dict.fromkeys(campaign for campaign, _ in unseen)
    looks = {name: numbered(i + 1) for i, name in enumerate(campaigns)}
    styles = {
        name: look.curve(linestyle="-", linewidth=0.8, marker=look.marker, markersize=2.4)
        for name, look in looks.items()
    }
    sheet = Sheet.grid(len(found), height=2.35, sharex=True)
    for panel, (label, content) in zip(sheet.panels, found.items(), strict=True):
        for own in fitted.values():
            panel.plot(own["slip_mm"], own["load"], **_FITTED, zorder=2)
        for (campaign, _), own in unseen.items():
            panel.plot(own["slip_mm"], own["load"], **{**styles[campaign], "zorder": 3.5})
        grid = studs.table_of(content["grid"])
        law = grid.assign(slip=studs.MILLI * grid["slip"])
        studs.draw_band(panel, law, "slip", "median", _LAW)
        drawn = grid[[name for name in ("median", "low", "high") if name in grid]]
        sheet.record(label=label, slip_m=grid["slip"], **drawn)
        sheet.name(panel, label, "slip (mm)", "load over largest load")
        panel.set(xlim=(0.0, _LARGEST_SLIP), ylim=(0.0, 1.12))
        sheet.notes.append(_sentence(label, content))
    few = sum(len(own) < _FEW for own in fitted.values())
    if few:
        sheet.notes.append(
            f"{few} of the {len(fitted)} fitted curves have fewer than {_FEW} points, with none "
            "between half of the load and the peak: they hardly tell the shape there."
        )
    for kind, curves in (("fitted", fitted), ("unseen", unseen)):
        for own in curves.values():
            points = {"slip_m": own["slip"], "median": own["load"]}
            sheet.record(label=kind, **own[["campaign", "specimen"]], **points)
    sheet.legend(
        *studs.band_entries(_LAW, "median of the law", "90 % band of a further curve"),
        entry(f"{len(fitted)} fitted curves", **_FITTED),
        *(entry(f"{campaign}, unseen", **style) for campaign, style in styles.items()),
    )
    return sheet.finish(f"load over largest load against slip for {', '.join(found)}")


def _curves(points: pd.DataFrame) -> dict[Any, pd.DataFrame]:
    """Points of every specimen that has several, rising in slip, loads over the largest."""
    if points.empty:
        return {}
    points = points.assign(slip_mm=studs.MILLI * points["slip"])
    groups = points.groupby(["campaign", "specimen"], sort=False)
    return {
        key: own.assign(load=own["load"] / own["load"].max()).sort_values("slip", kind="stable")
        for key, own in groups
        if len(own) > 1 and own["load"].max() > 0.0
    }


def _sentence(label: str, content: studs.Content) -> str:
    fit, judgement = content["fit"], content.get("judgement")
    text = f"{label}: no fit"
    if fit is not None:
        misfit = number(fit["median_rms"], 2)
        text = f"{label}: {fit['curves']} curves fitted, median misfit {misfit}"
    if judgement:
        misfit = number(judgement["median_rms"], 2)
        text += f"; on {judgement['curves']} unseen curves misfit {misfit}"
        if judgement["coverage"] is not None:
            text += f", {percent(judgement['coverage'], signed=False)} of their points in the band"
        if judgement["stiffness"]:
            ratio = judgement["stiffness"]["test_over_prediction"]
            text += f", stiffness {number(ratio, 3)} times the predicted one"
    return text + "."
