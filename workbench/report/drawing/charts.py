"""Charts of pulses on logarithmic axes, as SVG text."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from workbench.report.drawing.style import (
    MUTED,
    entry,
    house_style,
    legend_below,
    logarithmic,
    new_figure,
    numbered,
    settle,
)
from workbench.report.gallery import to_svg


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
