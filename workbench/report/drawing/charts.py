"""Charts that verbs draw: those of pulses on logarithmic axes, and a fragility curve."""

from collections.abc import Mapping, Sequence
from math import isinf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr

from workbench.assessment.budget import PEAK
from workbench.content.formatting import axis_label, unit_of
from workbench.errors import InputError
from workbench.report.drawing.style import (
    INTERVAL,
    MUTED,
    Style,
    entry,
    house_style,
    legend_below,
    logarithmic,
    new_figure,
    numbered,
    settle,
)
from workbench.report.gallery import to_svg

if TYPE_CHECKING:
    from workbench.uncertainty.fragility import Fragility


_MOST_LINES = 10  # told apart by their colours and dashes


class Line(NamedTuple):
    """Points of a curve, and its two asymptotes: where it goes in x and in y, if known."""

    x: Sequence[float]
    y: Sequence[float]
    left: float | None = None
    floor: float | None = None


def chart(lines: Mapping[str, Line], x: str, y: str) -> str:
    """SVG text of a chart: labelled lines over the quantities `x` and `y`."""
    with house_style():
        figure = new_figure(3.6, 4.6)
        panel = figure.add_subplot()
        for i, line in enumerate(lines.values()):
            panel.plot(line.x, line.y, **numbered(i).curve())
        panel.set_xscale("log")
        panel.set_yscale("log")
        for line in lines.values():
            if line.left is not None:
                panel.axvline(line.left, color=MUTED, linewidth=0.6, linestyle=":")
            if line.floor is not None:
                panel.axhline(line.floor, color=MUTED, linewidth=0.6, linestyle=":")
        for axis, words in ((panel.xaxis, x), (panel.yaxis, y)):
            logarithmic(axis, lambda value: f"{value:g}")
            axis.set_label_text(words)
        panel.grid(True, linewidth=0.4)
        handles = [entry(label, **numbered(i).curve()) for i, label in enumerate(lines)]
        if len(lines) > 1:
            legend_below(figure, handles)
        settle(figure)
    return to_svg(figure, "chart")


def draw_sweep(answers: xr.Dataset, path: Path) -> None:
    """Write the peak over the first key of a sweep, a line for each model and other value.

    Raises `InputError` where no peak is known, or lines cannot be told apart.
    """
    peaks = answers.get(PEAK)
    if peaks is None:
        raise InputError("--plot", path.name, "there is no peak to draw", "see the outcomes")
    _, key, *others = peaks.dims
    lines = peaks.stack(line=("model", *others)).transpose("line", key)
    x, unit = lines[key].to_numpy(), unit_of(PEAK)
    if len(lines) > _MOST_LINES or x.dtype.kind not in "if":
        text = f"needs numbers first, and at most {_MOST_LINES} lines"
        raise InputError("--plot", path.name, text, "vary less, or write the table alone")
    with house_style():
        figure = new_figure(3.6, 4.6)
        panel, handles = figure.add_subplot(), []
        for i, (names, line) in enumerate(zip(lines["line"].to_numpy(), lines, strict=True)):
            panel.plot(x, unit.factor * line.to_numpy(), **numbered(i).curve(marker="o"))
            model, *values = names
            texts = (f"{other} = {value}" for other, value in zip(others, values, strict=True))
            handles.append(entry(", ".join([str(model), *texts]), **numbered(i).curve()))
        of = lines[key].attrs.get("units", "")
        panel.set_xlabel(f"{key} ({of})" if of else str(key))
        panel.set_ylabel(axis_label(PEAK))
        panel.grid(True, linewidth=0.4)
        legend_below(figure, handles)
        settle(figure)
        figure.savefig(path, dpi=160)


def draw_fragility(result: "Fragility", path: Path) -> None:
    """Write a fragility curve with its band, and the reduced model alone, as PNG, SVG or PDF."""
    curve, setup = result.curve, result.setup
    velocity = np.exp(curve.log_velocity)
    with house_style():
        figure = new_figure(3.6, 5.2)
        panel = figure.add_subplot()
        panel.fill_between(velocity, curve.low, curve.high, **INTERVAL)
        corrected = numbered(0).curve()
        panel.plot(velocity, curve.median, **corrected)
        alone: Style = {"color": MUTED, "linestyle": "--", "linewidth": 1.0}
        panel.plot(velocity, result.reduced_curve, **alone)
        panel.set_ylim(0.0, 1.0)
        panel.set_xlim(max(velocity[0], setup.ends[0]), min(velocity[-1], setup.ends[1]))
        panel.set_xlabel("impact velocity (m/s)")
        falls = isinf(setup.limit.displacement)
        of = "collapse" if falls else f"exceeding {setup.limit}"
        panel.set_ylabel(f"probability of {of}")
        panel.grid(True, linewidth=0.4)
        band = {**INTERVAL, "linewidth": 6.0}
        handles = [
            entry(f"{setup.reduced.name}, corrected by {setup.reference.name}", **corrected),
            entry("90 %: samples, model, reference", **band),
            entry(f"{setup.reduced.name} alone", **alone),
        ]
        legend_below(figure, handles)
        settle(figure)
        figure.savefig(path, dpi=160)
