"""How hinge states look: a circle at each member end, its colour the N-M utilisation."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize, to_hex
from matplotlib.figure import Figure as Canvas

from workbench.report.figures.drawing import Array
from workbench.report.figures.style import INK, MUTED, PALETTE

YIELDS = 0.995  # utilisation from which a section counts as yielding
YIELDING = PALETTE[1]
WORDS = f"utilisation of {YIELDS:g} and more: yielding"


@cache
def colours() -> Colormap:
    """Pale to dark blue below yielding, vermilion at it: safe for colour-blind eyes and in grey."""
    blues = colormaps["Blues"](np.linspace(0.06, 0.95, 256))
    return LinearSegmentedColormap.from_list("utilisation", blues).with_extremes(over=YIELDING)


def colour_of(utilisation: float) -> str:
    """Colour of a utilisation as hexadecimal text."""
    if utilisation >= YIELDS:
        return YIELDING
    return to_hex(colours()(max(utilisation, 0.0) / YIELDS))


def colour_bar(canvas: Canvas, axes: Any, share: float) -> None:
    """The bar that explains the circles, right of all panels, over a `share` of their height."""
    mappable = ScalarMappable(Normalize(0.0, YIELDS), colours())
    bar = canvas.colorbar(
        mappable, ax=axes, extend="max", shrink=share, aspect=24, pad=0.02, extendfrac=0.07
    )
    bar.set_ticks([0.0, 0.25, 0.5, 0.75, YIELDS], labels=["0", "0.25", "0.5", "0.75", "yields"])
    bar.set_label("N-M utilisation")
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(length=2.0)


def hinge_places(x: Array, y: Array, gap: float) -> Array:
    """Places (2 members, 2) of the circles: `gap` from each end along the members' curves.

    Arguments: `x`, `y` (members, points); short members have theirs nearer to the ends.
    """
    places = []
    for across, up in zip(x, y, strict=True):
        run = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(across), np.diff(up)))])
        near = min(gap, 0.3 * run[-1])
        places += [
            (np.interp(s, run, across), np.interp(s, run, up)) for s in (near, run[-1] - near)
        ]
    return np.array(places)


def draw_states(panel: Axes, places: Array, used: Array, *, size: float = 3.2) -> None:
    """Circles at `places`; yielding ones are larger, with a dark edge."""
    for yields in (False, True):
        chosen = (used >= YIELDS) == yields
        if np.any(chosen):
            panel.scatter(
                places[chosen, 0],
                places[chosen, 1],
                s=(size * (1.45 if yields else 1.0)) ** 2,
                c=[colour_of(float(value)) for value in used[chosen]],
                edgecolors=INK if yields else MUTED,
                linewidths=0.7 if yields else 0.35,
                zorder=5.0 if yields else 4.5,
            )
