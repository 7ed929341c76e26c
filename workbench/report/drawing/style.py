"""One house style: paper-sized figures, safe colours, one look per label in every figure."""

import io
import itertools
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib import rc_context, rc_params_from_file
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from workbench.base.catalogue import IMPORTED
from workbench.study.definition import Study, holds_data

Style = dict[str, Any]
_HOUSE = rc_params_from_file(Path(__file__).with_name("house.mplstyle"), use_default_template=False)
_LEGEND_ROW = 0.16  # inches
_PASSES = 6
TEXT_WIDTH = 6.7  # inches: the text width of the printed page
INK, MUTED, GRID = "#1a1a1a", "#6b6b6b", "#d9d9d9"
WARNING = "#a04000"

# Okabe and Ito's palette without yellow, which vanishes on white, and black (the reference).
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5e3c99", "#8c510a")
_LINES = ("-", "--", "-.", (0, (1, 1.2)))
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h")
_IMPORTED = "#b2182b"  # of answers of other programs, which no model has
_STEPS = ("#4d4d4d", "#808080", "#a6a6a6", "#bfbfbf")
# the interval that its refinement leaves around the reference
INTERVAL: Style = {"color": "#56b4e9", "alpha": 0.35, "linewidth": 0.0}


class Look(NamedTuple):
    """Look of a label: lines for histories, markers for single values."""

    color: str
    line: Any = "-"
    marker: str = "o"
    width: float = 1.3
    filled: bool = True
    order: float = 3.0
    size: float = 5.0

    def curve(self, **more: Any) -> Style:
        """Keyword arguments for a line."""
        style: Style = {"color": self.color, "linestyle": self.line, "linewidth": self.width}
        return {**style, "zorder": self.order, **more}

    def points(self, **more: Any) -> Style:
        """Keyword arguments for markers without a line."""
        return {
            "color": self.color,
            "linestyle": "none",
            "marker": self.marker,
            "markersize": self.size,
            "markerfacecolor": self.color if self.filled else "white",
            "markeredgecolor": self.color,
            "markeredgewidth": 0.24 * self.size,
            "zorder": self.order,
            **more,
        }


def entry(label: str, **style: Any) -> Line2D:
    """A legend entry that shows a line or a marker."""
    return Line2D([], [], label=label, **style)


def numbered(i: int, order: float = 3.0) -> Look:
    """The i-th look: colours come again with other lines and markers."""
    color, turn = PALETTE[i % len(PALETTE)], i // len(PALETTE)
    marker = _MARKERS[(i + turn) % len(_MARKERS)]
    return Look(color, _LINES[turn % len(_LINES)], marker, order=order)


def looks(study: Study) -> Mapping[str, Look]:
    """The look of every label of a study, the same in all of its figures and in its quick form.

    The reference is black, coarser steps of its ladder are grey, published series take the
    colour of the model that a gate holds against them, with an open marker.
    """
    chosen: dict[str, Look] = {}
    whole = study.whole or study
    published = [label for label, model in whole.models.items() if holds_data(model)]
    steps = [label for label in whole.ladder[::-1] if label != study.reference]
    free = map(numbered, itertools.count())
    for label in whole.models:
        if label in (study.reference, whole.reference):
            chosen[label] = Look("#000000", width=1.8, order=2.5)
        elif label in steps:
            shade = _STEPS[min(steps.index(label), len(_STEPS) - 1)]
            chosen[label] = Look(shade, "--", width=1.0, order=2.2)
        elif label not in published:
            chosen[label] = next(free)
    partner = {g.against: g.model for g in whole.gates if g.against in published}
    for i, label in enumerate(published):
        look = chosen.get(partner.get(label, "")) or next(free)
        marker = _MARKERS[(3 + i) % len(_MARKERS)]
        chosen[label] = look._replace(line=":", marker=marker, filled=False, width=1.1, order=4.0)
        if whole.models[label].name == IMPORTED:  # a history, as others have
            line = _LINES[1 + i % 3]
            chosen[label] = chosen[label]._replace(color=_IMPORTED, line=line, width=1.5)
    return {label: chosen[label] for label in study.models}


def house_style() -> AbstractContextManager[None]:
    """Return a context in which figures are drawn and saved in the house style."""
    return rc_context(_HOUSE)


class Shown(Figure):
    """A figure that a notebook shows by itself."""

    def _repr_svg_(self) -> str:
        buffer = io.StringIO()
        with house_style():
            self.savefig(buffer, format="svg")
        return buffer.getvalue()


def new_figure(height: float, width: float = TEXT_WIDTH) -> Figure:
    """An empty figure of the given size in inches, laid out without overlaps."""
    layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06, hspace=0.04)
    return Shown(figsize=(width, height), layout=layout)


def logarithmic(axis: Axis, words: Callable[[float], str]) -> None:
    """A decade at least; ticks at 1, 2, 5 over short ranges, at full decades over long ones."""
    low, high = sorted(axis.get_view_interval())
    if high < 10.0 * low:
        middle = (low * high) ** 0.5
        low, high = middle / 10.0**0.5, middle * 10.0**0.5
        axis.set_view_interval(low, high, ignore=True)
    short = high / low < 150.0
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if short else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: words(float(value))))
    axis.set_minor_formatter(NullFormatter())


def settle(figure: Figure) -> None:
    """Lay a figure out until nothing moves any more, then keep it so.

    One pass is not enough where panels keep an aspect: margins are measured before they shrink.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    before: list[float] = []
    for _ in range(_PASSES):
        engine.execute(figure)
        places = [edge for panel in figure.axes for edge in panel.get_position().extents]
        if before and max(abs(a - b) for a, b in zip(places, before, strict=True)) < 1e-3:
            break
        before = places
    figure.set_layout_engine("none")


def legend_below(figure: Figure, handles: Iterable[Any]) -> None:
    """A legend under all panels, outside the data.

    Each row beyond the second makes the figure higher: panels keep their size.
    """
    shown = list(handles)
    widths = [0.062 * len(str(handle.get_label())) + 0.55 for handle in shown]
    wide = figure.get_figwidth()
    wanted = len(shown) if sum(widths) <= wide else min(max(1, int(wide / max(widths))), 5)
    rows = -(-len(shown) // wanted)
    figure.set_figheight(figure.get_figheight() + _LEGEND_ROW * max(rows - 2, 0))
    place: Style = {"loc": "outside lower center", "columnspacing": 1.6}
    figure.legend(handles=shown, ncols=wanted, handletextpad=0.6, **place)


def framed(panel: Axes, x: float, y: float, text: str, color: str, **more: Any) -> None:
    """A text that must not be overlooked, in a frame at a place in shares of the panel."""
    box: Style = {"facecolor": "white", "edgecolor": color, "linewidth": 0.8, "alpha": 0.92}
    box["boxstyle"] = "round,pad=0.35"
    look: Style = {"va": "bottom", "zorder": 6, "bbox": box, **more}
    panel.text(x, y, text, transform=panel.transAxes, color=color, **look)
