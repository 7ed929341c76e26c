"""Pictures of the page that follow the hand: histories, deformed structure, small curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isinf
from typing import Any

import numpy as np
from bokeh.models import BoxAnnotation, ColumnDataSource, DataRange1d, HoverTool, Span
from bokeh.plotting import figure

from workbench.base.units import in_si
from workbench.extras.app.desk import NEAR, SmallCurve
from workbench.report.drawing.shapes import REST, YIELDING, YIELDS, Shapes, magnification
from workbench.report.drawing.sheet import thinned
from workbench.report.drawing.style import INK, MUTED, PALETTE
from workbench.report.explorer import empty_source, new_plot
from workbench.report.figures.deformed import hinge_places
from workbench.responses import PEAK, Response, error_of

_GAP = 0.012  # of the size of the structure, from the end of a member to its hinge
_DASHES = ("solid", "dashed", "dotdash", "dotted")


def _look(place: int) -> tuple[str, str]:
    """Colour and dash of the model at a place of the list."""
    return PALETTE[place % len(PALETTE)], _DASHES[place // len(PALETTE) % len(_DASHES)]


class History:
    """Displacement of the impact point over time, a line for each model."""

    def __init__(self) -> None:
        self.plot = new_plot("history", "time (ms)", "displacement (mm)", 300)
        self._lines: dict[str, Any] = {}
        self._ends = empty_source("interval", "x", "low", "high")
        self.plot.segment("x", "low", "x", "high", source=self._ends, line_width=6, line_alpha=0.4)
        self._time = Span(dimension="height", location=0, line_color=INK, line_dash="dotted")
        self.plot.add_layout(self._time)
        tips = [("", "$name"), ("time", "$x{0.0} ms"), ("displacement", "$y{0.0} mm")]
        self.plot.add_tools(HoverTool(tooltips=tips))

    def show(self, responses: Mapping[str, Response], order: Sequence[str]) -> None:
        """Lines of these responses, and the interval of 90 % of the first at its peak."""
        for name in responses.keys() - self._lines.keys():
            color, dash = _look(order.index(name) if name in order else len(self._lines))
            source = ColumnDataSource({"x": [], "y": []})
            style: dict[str, Any] = {"line_color": color, "line_dash": dash, "line_width": 2}
            self._lines[name] = self.plot.line(
                "x", "y", source=source, legend_label=name, name=name, **style
            )
            self.plot.legend.click_policy = "hide"
            self.plot.legend.background_fill_alpha = 0.7
        for name, line in self._lines.items():
            line.data_source.data = _history(responses.get(name))
        for item in self.plot.legend[0].items if self.plot.legend else ():
            item.visible = item.label.value in responses
        self._ends.data = _interval(next(iter(responses.values()), None))

    def at(self, time: float) -> None:
        """Mark a time (s)."""
        self._time.location = 1e3 * time


def _history(response: Response | None) -> dict[str, Any]:
    if response is None or "time" not in response or "displacement" not in response:
        return {"x": [], "y": []}
    x, y = thinned(response["time"].to_numpy(), response["displacement"].to_numpy())
    return {"x": 1e3 * x, "y": 1e3 * y}


def _interval(response: Response | None) -> dict[str, Any]:
    """Ends of 90 % (mm) at the time of the peak (ms), where both are known."""
    if response is None or PEAK not in response or "time_of_peak" not in response:
        return {"x": [], "low": [], "high": []}
    error, peak = error_of(response), 1e3 * float(response[PEAK])
    if error.low is None or error.high is None or error.low <= -1.0 or isinf(error.high):
        return {"x": [], "low": [], "high": []}
    ends = peak / (1.0 + error.high), peak / (1.0 + error.low)
    return {"x": [1e3 * float(response["time_of_peak"])], "low": ends[:1], "high": ends[1:]}


class Deformed:
    """Deformed structure at an instant of the record of one model, over the one at rest."""

    def __init__(self) -> None:
        self.plot = new_plot("deformed", "m", "m", 340, match_aspect=True)
        self._rest, self._now = empty_source("rest", "x", "y"), empty_source("now", "x", "y")
        self._box, self._yields = empty_source("box", "x", "y"), empty_source("yields", "x", "y")
        self.plot.multi_line("x", "y", source=self._rest, line_color=REST, line_width=1.5)
        lines = self.plot.multi_line("x", "y", source=self._now, line_color=INK, line_width=2.5)
        self.plot.scatter(
            "x", "y", source=self._yields, size=9, fill_color=YIELDING, line_color=INK
        )
        box = self.plot.scatter("x", "y", source=self._box, alpha=0.0)
        self.plot.x_range = DataRange1d(renderers=[box, lines], range_padding=0.15)
        self.plot.y_range = DataRange1d(renderers=[box, lines], range_padding=0.08)
        self.shapes: Shapes | None = None
        self._times = 1.0  # that displacements are drawn

    def show(self, shapes: Shapes | None) -> None:
        """The shapes of a response; None: it knows none."""
        self.shapes = shapes
        if shapes is not None:
            self._times = magnification(shapes.largest(list(range(len(shapes.at)))), shapes.size)
        rest: Any = () if shapes is None else shapes.rest
        self._rest.data = _curves(rest)
        corners = np.ravel(rest)
        self._box.data = {"x": corners.real, "y": corners.imag}

    def at(self, snapshot: int) -> str:
        """Draw a snapshot; returns when it is, and how many times it is drawn."""
        if self.shapes is None:
            self._now.data = self._yields.data = _curves(())
            return "No model that answered states a deformed shape."
        shapes, times = self.shapes, self._times
        drawn = shapes.magnified(snapshot, times)
        self._now.data = _curves(drawn)
        yields = shapes.used[:, snapshot] >= YIELDS if len(shapes.hinges) else np.zeros(0, bool)
        places = hinge_places(drawn, _GAP * shapes.size)
        places = places[yields] if len(yields) == len(places) else places[:0]
        self._yields.data = {"x": places.real, "y": places.imag}
        scale = "" if times == 1.0 else f"; displacements drawn {times:g} times"
        return f"{shapes.words(snapshot)}{scale}; filled circles yield"


def _curves(curves: Iterable[Any]) -> dict[str, Any]:
    drawn = list(curves)
    return {"x": [each.real for each in drawn], "y": [each.imag for each in drawn]}


class Dependence:
    """Small curve of the peak over one input; where the structure collapses is shaded."""

    def __init__(self) -> None:
        self.plot = new_plot("dependence", "", "peak (mm)", 190)
        self._curve = empty_source("curve", "x", "y")
        self.plot.line("x", "y", source=self._curve, line_color=PALETTE[0], line_width=2)
        self._here = Span(dimension="height", location=0, line_color=INK, line_dash="dotted")
        self._falls = BoxAnnotation(fill_color=PALETTE[1], fill_alpha=0.15, visible=False)
        self.plot.add_layout(self._here)
        self.plot.add_layout(self._falls)

    def show(self, curve: SmallCurve, field: Mapping[str, Any]) -> str:
        """Draw the curve in the unit of the `field` of its key; return it in words."""
        title, unit = field["label"], field.get("unit") or curve.unit
        x, fallen = curve.values / (in_si(f"1 {unit}", curve.unit) or 1.0), np.isinf(curve.peaks)
        self.plot.xaxis.axis_label = f"{title} ({unit})" if unit else title
        self._curve.data = {"x": x, "y": np.where(fallen, np.nan, 1e3 * curve.peaks)}
        self._here.location = x[0] / NEAR[0]
        self._falls.visible = bool(fallen.any())
        if fallen.any():
            step = 0.5 * (x[1] - x[0])
            self._falls.left, self._falls.right = x[fallen].min() - step, x[fallen].max() + step
        known = np.isfinite(curve.peaks)
        if not known.any():
            return f"{title}: {'collapses at all values' if fallen.any() else 'no answer'}."
        low, high = (1e3 * curve.peaks[known][end] for end in (0, -1))
        ends = f"{x[known][0]:.3g} to {x[known][-1]:.3g} {unit}".strip()
        falls = f"; collapses at {x[fallen][0]:.3g} {unit}" if fallen.any() else ""
        return f"{title}: {low:.3g} mm to {high:.3g} mm over {ends}{falls}."


def fragility_plot(table: Any) -> figure:
    """Probability to exceed the limit over the velocity (m/s), with its band of 90 %."""
    plot = new_plot("fragility", "velocity (m/s)", "probability", 260)
    source = ColumnDataSource(table)
    plot.varea("velocity", "low", "high", source=source, fill_color=MUTED, fill_alpha=0.3)
    plot.line("velocity", "median", source=source, line_color=PALETTE[0], line_width=2)
    return plot
