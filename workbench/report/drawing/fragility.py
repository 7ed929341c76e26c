"""A fragility curve with its band, and what the reduced model says alone."""

from math import isinf
from pathlib import Path

import numpy as np

from workbench.report.drawing.style import (
    INTERVAL,
    MUTED,
    Style,
    entry,
    house_style,
    legend_below,
    new_figure,
    numbered,
    settle,
)
from workbench.uncertainty.fragility import Fragility


def draw_fragility(result: Fragility, path: Path) -> None:
    """Write the curve as PNG, SVG or PDF, by the ending."""
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
