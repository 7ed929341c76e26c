"""One house style: paper-sized figures, safe colours, one look per label in every figure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import matplotlib
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from workbench.study.definition import Study

_LEGEND_ROW = 0.16  # inches
_PASSES = 6
TEXT_WIDTH = 6.7  # inches: the text width of the printed page
INK, MUTED, GRID = "#1a1a1a", "#6b6b6b", "#d9d9d9"

# Okabe and Ito's palette without yellow, which vanishes on white, and black (the reference).
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5e3c99", "#8c510a")
_LINES = ("-", "--", "-.", (0, (1, 1.2)))
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h")

SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.3,
    "lines.markersize": 5.0,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "axes.unicode_minus": True,
    # names come from users: a dollar sign in one is no formula
    "text.parse_math": False,
    "axes.formatter.use_mathtext": False,
    "svg.fonttype": "path",
    "svg.hashsalt": "workbench",
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


class Look(NamedTuple):
    """How a label looks: lines for histories, markers for single values.

    `point_only`: the label has values but no curves (published numbers, estimates).
    """

    color: str
    line: Any
    marker: str
    width: float
    filled: bool
    order: float

    def curve(self) -> dict[str, Any]:
        """Keyword arguments for a line."""
        return {
            "color": self.color,
            "linestyle": self.line,
            "linewidth": self.width,
            "zorder": self.order,
        }

    def points(self) -> dict[str, Any]:
        """Keyword arguments for markers without a line."""
        return {
            "color": self.color,
            "linestyle": "none",
            "marker": self.marker,
            "markerfacecolor": self.color if self.filled else "white",
            "markeredgecolor": self.color,
            "markeredgewidth": 1.2,
            "zorder": self.order,
        }


def looks(study: Study) -> Mapping[str, Look]:
    """The look of every label of a study, the same in all of its figures.

    The reference is black, coarser steps of its ladder are grey, published series take the
    colour of the model that a gate holds against them, with an open marker.
    """
    found: dict[str, Look] = {}
    published = [label for label, model in study.models.items() if model.name == "published"]
    steps = [label for label in study.ladder if label != study.reference]
    free = 0
    for label in study.models:
        if label == study.reference:
            found[label] = Look("#000000", "-", "o", 1.8, True, 2.5)
        elif label in steps:
            shade = ("#4d4d4d", "#808080", "#a6a6a6", "#bfbfbf")[min(steps[::-1].index(label), 3)]
            found[label] = Look(shade, "--", "o", 1.0, True, 2.2)
        elif label not in published:
            found[label] = _numbered(free, 3.0)
            free += 1
    partner = {g.against: g.model for g in study.gates if g.against in published}
    for i, label in enumerate(published):
        judged = found.get(partner.get(label, ""))
        if judged is None or label not in partner:
            look = _numbered(free, 4.0)
            free += 1
        else:
            look = judged
        marker = _MARKERS[(3 + i) % len(_MARKERS)]
        found[label] = look._replace(line=":", marker=marker, filled=False, width=1.1, order=4.0)
    return {label: found[label] for label in study.models}


def _numbered(i: int, order: float) -> Look:
    color = PALETTE[i % len(PALETTE)]
    turn = i // len(PALETTE)  # colours come again with other lines and markers
    line = _LINES[turn % len(_LINES)]
    return Look(color, line, _MARKERS[(i + turn) % len(_MARKERS)], 1.3, True, order)


@contextmanager
def house_style() -> Iterator[None]:
    """Everything drawn or saved inside has the house style."""
    with matplotlib.rc_context(SETTINGS):  # type: ignore[arg-type]
        yield


def new_figure(height: float, width: float = TEXT_WIDTH) -> Figure:
    """An empty figure of the given size in inches, laid out without overlaps."""
    layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06, hspace=0.04)
    return Figure(figsize=(width, height), layout=layout)


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


def legend_beside(figure: Figure, handles: list[Any]) -> None:
    """A legend right of all panels, for high figures of one panel; equal names appear once."""
    named = {str(handle.get_label()): handle for handle in handles}
    if named:
        figure.legend(handles=list(named.values()), loc="outside right center", handletextpad=0.6)


def legend_below(figure: Figure, handles: list[Any], columns: int = 0) -> None:
    """A legend under all panels, outside the data; equal names appear once.

    Each row beyond the second makes the figure higher: panels keep their size.
    """
    named = {str(handle.get_label()): handle for handle in handles}
    if not named:
        return
    longest = max(len(name) for name in named)
    fit = max(1, int(figure.get_figwidth() / (0.062 * longest + 0.55)))
    wanted = columns or min(fit, len(named), 5)
    rows = -(-len(named) // wanted)
    figure.set_figheight(figure.get_figheight() + _LEGEND_ROW * max(rows - 2, 0))
    figure.legend(
        handles=list(named.values()),
        loc="outside lower center",
        ncols=wanted,
        columnspacing=1.6,
        handletextpad=0.6,
    )


def grid_shape(count: int, most: int = 3) -> tuple[int, int]:
    """Rows and columns for a number of panels, at most `most` side by side."""
    columns = min(count, most)
    if count == 4 and most < 4:
        columns = 2
    return -(-count // columns), columns
