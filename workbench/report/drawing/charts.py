"""Charts that verbs draw: pulses on logarithmic axes, a sweep."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import xarray as xr
from matplotlib.figure import Figure as Canvas

from workbench.base.errors import InputError
from workbench.report.drawing.sheet import Drawing, Sheet, canvas_of
from workbench.report.drawing.style import MUTED, Style, entry, logarithmic, numbered
from workbench.report.page.formatting import axis_label, unit_of
from workbench.study.assessment.budget import PEAK

_MOST_LINES = 10  # told apart by their colours and dashes
_HIGH, _WIDE = 3.6, 4.6  # inches
_ASYMPTOTE: Style = {"color": MUTED, "linewidth": 0.6, "linestyle": ":"}


class Line(NamedTuple):
    """Points of a curve, and its two asymptotes: where it goes in x and in y, if known."""

    x: Sequence[float]
    y: Sequence[float]
    left: float | None = None
    floor: float | None = None


def chart(lines: Mapping[str, Line], x: str, y: str) -> Canvas:
    """A chart of labelled lines over the quantities `x` and `y`, on logarithmic axes."""
    return canvas_of(_chart, lines, x, y)


def _chart(lines: Mapping[str, Line], x: str, y: str) -> Drawing:
    sheet = Sheet.table(1, 1, _HIGH, width=_WIDE)
    for i, (label, line) in enumerate(lines.items()):
        sheet.panel.plot(line.x, line.y, **numbered(i).curve())
        sheet.record(label=label, x=line.x, y=line.y)
        if len(lines) > 1:
            sheet.legend(entry(label, **numbered(i).curve()))
    sheet.panel.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
    for line in lines.values():
        if line.left is not None:
            sheet.panel.axvline(line.left, **_ASYMPTOTE)
        if line.floor is not None:
            sheet.panel.axhline(line.floor, **_ASYMPTOTE)
    for axis in (sheet.panel.xaxis, sheet.panel.yaxis):
        logarithmic(axis, lambda value: f"{value:g}")
    return sheet.finish(f"{y} over {x}")


def sweep_chart(answers: xr.Dataset, name: str) -> Canvas:
    """The peak over the first key of a sweep, a line for each model and other value.

    Raises `InputError` where no peak is known, or lines cannot be told apart; `name`, the picture.
    """
    peaks = answers.get(PEAK)
    if peaks is None:
        raise InputError("--plot", name, "there is no peak to draw", "see the outcomes")
    _, key, *others = peaks.dims
    lines = peaks.stack(line=("model", *others)).transpose("line", key)
    if len(lines) > _MOST_LINES or lines[key].dtype.kind not in "if":
        text = f"needs numbers first, and at most {_MOST_LINES} lines"
        raise InputError("--plot", name, text, "vary less, or write the table alone")
    return canvas_of(_sweep, lines, str(key), others)


def _sweep(lines: xr.DataArray, key: str, others: Sequence[str]) -> Drawing:
    sheet, x = Sheet.table(1, 1, _HIGH, width=_WIDE), lines[key].to_numpy()
    for i, (names, line) in enumerate(zip(lines["line"].to_numpy(), lines, strict=True)):
        model, *values = names
        texts = (f"{other} = {value}" for other, value in zip(others, values, strict=True))
        label = ", ".join([str(model), *texts])
        sheet.panel.plot(x, unit_of(PEAK).factor * line.to_numpy(), **numbered(i).curve(marker="o"))
        sheet.record(label=label, x=x, y=line.to_numpy())
        sheet.legend(entry(label, **numbered(i).curve()))
    of = lines[key].attrs.get("units", "")
    sheet.panel.set(xlabel=f"{key} ({of})" if of else key, ylabel=axis_label(PEAK))
    return sheet.finish(f"peaks over {key}")
