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
from numpy.typing import NDArray

from workbench.report.drawing.style import INK, MUTED, PALETTE, Style

YIELDS = 0.995  # utilisation from which a section counts as yielding
YIELDING = PALETTE[1]
WORDS = f"utilisation of {YIELDS:g} and more: yielding"
_SIZE = 3.2  # of a circle; yielding ones are larger


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
    place: Style = {"shrink": share, "aspect": 24, "pad": 0.02, "extendfrac": 0.07}
    bar = canvas.colorbar(mappable, ax=axes, extend="max", **place)
    bar.set_ticks([0.0, 0.25, 0.5, 0.75, YIELDS], labels=["0", "0.25", "0.5", "0.75", "yields"])
    bar.set_label("N-M utilisation")
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(length=2.0)


def hinge_places(curves: NDArray[np.complex128], gap: float) -> NDArray[np.complex128]:
    """Places (2 members,) of the circles: `gap` from each end along the members' curves.

    Arguments: `curves` (members, points), x + iy; short members have theirs nearer to the ends.
    """
    places = []
    for curve in curves:
        run = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(curve)))])
        near = min(gap, 0.3 * run[-1])
        places.append(np.interp([near, run[-1] - near], run, curve))
    return np.concatenate(places)


def draw_states(panel: Axes, places: NDArray[np.complex128], used: NDArray[np.float64]) -> None:
    """Circles at `places`; yielding ones are larger, with a dark edge, and lie on top."""
    for yields in (False, True):
        chosen = (used >= YIELDS) == yields
        if np.any(chosen):
            panel.scatter(
                places[chosen].real,
                places[chosen].imag,
                s=(_SIZE * (1.45 if yields else 1.0)) ** 2,
                c=[colour_of(float(value)) for value in used[chosen]],
                edgecolors=INK if yields else MUTED,
                linewidths=0.7 if yields else 0.35,
                zorder=5.0 if yields else 4.5,
            )
