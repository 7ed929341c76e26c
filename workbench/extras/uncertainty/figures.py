"""Figures of probabilities over velocity: a chart of a verb, and the figure of a report.

``exceedance``: probability over velocity with its band, one panel per case, named with its limit.
Option: `cases`.
"""

from collections.abc import Mapping, Sequence
from math import isinf

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from workbench.base.arrays import Array
from workbench.extras.uncertainty.fragility import Fragility
from workbench.report.drawing.sheet import Drawing, Request, Sheet, canvas_of
from workbench.report.drawing.style import INTERVAL, MUTED, Style, entry, numbered

VELOCITY = "impact velocity (m/s)"
_HIGH = 3.6  # inches


def exceedance(panel: Axes, velocity: Array, edges: Sequence[Array], look: Style) -> None:
    """Draw a fragility curve, the middle one of the `edges` of its band, over velocity (m/s)."""
    low, median, high = edges
    panel.fill_between(velocity, low, high, **{**INTERVAL, "color": look["color"]})
    panel.plot(velocity, median, **look)


def fragility_chart(results: Mapping[str, Fragility]) -> Canvas:
    """Fragility curves with their bands by what is given; a single one beside its reduced model."""
    return canvas_of(_fragility, results)


def _fragility(results: Mapping[str, Fragility]) -> Drawing:
    sheet = Sheet.table(1, 1, _HIGH, width=5.2)
    panel = sheet.panel
    alone: Style = {"color": MUTED, "linestyle": "--", "linewidth": 1.0}
    setup = next(iter(results.values())).setup
    band = entry("90 %: samples, model, reference", **{**INTERVAL, "linewidth": 6.0})
    firsts, lasts = [], []
    for i, (given, result) in enumerate(results.items()):
        curve, look = result.curve, numbered(i).curve()
        velocity = np.exp(curve.log_velocity)
        exceedance(panel, velocity, (curve.low, curve.median, curve.high), look)
        corrected = f"{setup.reduced.name}, corrected by {setup.reference.name}"
        sheet.legend(entry(given or corrected, **look))
        edges = {"low": curve.low, "median": curve.median, "high": curve.high}
        sheet.record(given=given, velocity=velocity, **edges)
        firsts.append(velocity[0])
        lasts.append(velocity[-1])
        if len(results) == 1:
            panel.plot(velocity, result.reduced_curve, **alone)
            sheet.legend(band, entry(f"{setup.reduced.name} alone", **alone))
    of = "collapse" if isinf(setup.limit.displacement) else f"exceeding {setup.limit}"
    ends = max(min(firsts), setup.ends[0]), min(max(lasts), setup.ends[1])
    panel.set(xlim=ends, ylim=(0.0, 1.0))
    panel.set(xlabel=VELOCITY, ylabel=f"probability of {of}")
    return sheet.finish(f"probability of {of} over the impact velocity")


def exceedance_bands(request: Request) -> Drawing:
    """Fragility curves of all labels, each with its band."""
    sheet, panels = request.case_panels(sharey=True)
    for case, panel in panels:
        answers = request.answers(case, sheet.absent, ("curve.median",), "fragility curve")
        for label, response in answers.items():
            velocity, *edges = (
                response[f"curve.{name}"].to_numpy()
                for name in ("velocity", "low", "median", "high")
            )
            look = request.looks[label].curve()
            exceedance(panel, velocity, edges, look)
            sheet.legend(entry(label, **look))
            columns = dict(zip(("low", "median", "high"), edges, strict=True))
            sheet.record(case=case.name, label=label, velocity_SI=velocity, **columns)
        panel.set_ylim(0.0, 1.0)
        beyond = getattr(case.scenario, "displacement", None)
        limit = "collapse" if beyond is None else f"{beyond:g} m"
        title = case.name if limit in case.name else f"{case.name}: {limit}"
        sheet.name(panel, title, VELOCITY, "probability of exceedance")
    empty = "No model answered with a fragility curve."
    return sheet.finish("probability of exceedance over the impact velocity", empty=empty)
