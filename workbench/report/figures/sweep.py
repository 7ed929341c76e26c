"""Maps of a sweep: the error of each model over two parameters, small multiples over a third.

Options: `x`, `y`, `facet` (names of case parameters; default the first three that vary), `rows`
(a parameter for the rows of panels when a single model is shown; default a fourth that varies),
`quantity`, `metric`, `against` (default: of several references the one that counts in a case),
`limit` (value at which the colours end, default 0.2).
Cases that differ only in further parameters share a field; the worst of them is shown.
"""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from matplotlib.ticker import PercentFormatter

from workbench.content.formatting import MINUS, metric_title, title_of
from workbench.report.drawing.sheet import Array, Drawing, Request, Sheet, first, nothing
from workbench.report.drawing.style import INK, TEXT_WIDTH, Look, Style, entry
from workbench.report.stored import BEST
from workbench.study.definition import Case, holds_data

_MOST_FACETS = 6
_HIGHEST = 8.6  # inches
_ROW = 16  # letters of values that stand beside each other below a panel
_CORNER = 0.38, 0.3  # of a field: where the mark of a warning leaves room for the number
_LEAST = 0.26, 0.13  # inches of a field, wide and high, in which a number can be read
_MARKS = {
    "warned": ("outside its domain (warning)", Look(INK, size=3.6).points(markerfacecolor="white")),
    "failed": ("no answer", Look("#b30000", marker="x", size=4.5).points()),
    "collapsed": ("collapse of one side", Look("#6a3d9a", marker="v", size=4.5).points()),
    "both": (
        "collapse of both sides",
        Look("#6a3d9a", marker="v", size=4.5).points(markerfacecolor="none"),
    ),
}


def draw(request: Request) -> Drawing:
    """Rows of panels are models (or values of a parameter), columns values of the facet."""
    cases = [case for case in request.cases if case.parameters]
    names = dict.fromkeys(name for case in cases for name in case.parameters)
    varying = [name for name in names if len(_values(cases, name)) > 1]
    if len(varying) < 2:
        return nothing("A map needs cases with two parameters that vary.")
    x = str(request.option("x", varying[0]))
    y = str(request.option("y", next(name for name in varying if name != x)))
    further = [name for name in varying if name not in (x, y)]
    facet = str(request.option("facet", further[0] if further else ""))
    models, metric = _models(request, cases), str(request.option("metric", "relative_error"))
    best = BEST if len(request.study.ranked) > 1 else request.against
    against = str(request.option("against", best))
    if not models:
        return nothing("No model of the sweep is held against another.")
    what = f"{metric_title(metric)} of the {title_of(request.quantity)}"
    said = [f"Colours and numbers: {what} against {against}, in %."]
    further = [name for name in further if name != facet]
    by = str(request.option("rows", further[0] if further else "")) if len(models) == 1 else ""
    values = _values(cases, facet) if facet else [None]
    columns = first(values, _MOST_FACETS, f"values of {facet}", said)
    rows = _values(cases, by)[:_MOST_FACETS] if by else models
    table = _table(request, cases, models, metric, against)
    grid = (x, _values(cases, x)), (y, _values(cases, y))
    height = min(_HIGHEST, 0.95 + len(rows) * max(1.35, 0.3 * len(grid[1][1]) + 0.5))
    room = int(14.0 * (height - 0.95) / len(rows))  # characters along a panel's height
    sheet = Sheet.table(len(rows), len(columns), height, said, sharex=True, sharey=True)
    limit = float(request.option("limit", 0.2))
    wide = (TEXT_WIDTH - 1.3) / len(columns) / len(grid[0][1])
    tall = 0.8 * (height - 0.95) / len(rows) / len(grid[1][1])
    legible = wide >= _LEAST[0] and tall >= _LEAST[1]
    for i, row in enumerate(rows):
        for j, value in enumerate(columns):
            panel = sheet.panels[i * len(columns) + j]
            here = table[(table[by or "model"] == row) & (not facet or table[facet] == value)]
            field = _field(here, grid)
            image = _map(panel, here, field, grid, limit)
            if legible:
                _numbers(panel, field, limit)
            sheet.record(here)
            head = "" if i or not facet else _shown(value) if j else f"{facet}: {_shown(value)}"
            sheet.name(panel, head, x, "\n".join([_shown(row), *textwrap.wrap(y, room)]))
    place: Style = {"extend": "both", "shrink": 0.85, "aspect": 30, "pad": 0.015}
    bar = sheet.canvas.colorbar(image, ax=sheet.panels, **place)
    bar.set_label(metric_title(metric))
    bar.ax.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    bar.outline.set_linewidth(0.4)
    seen = (look for name, look in _MARKS.items() if table[name].any())
    sheet.legend(*(entry(label, **style) for label, style in seen))
    if by:
        sheet.said.append(f"Model: {models[0]}. Rows of panels: {by}.")
    merged = ", ".join(name for name in further if name != by)
    if merged:
        sheet.said.append(f"Each field shows the worst of the cases that differ in {merged}.")
    alt = f"maps of the {metric_title(metric)} of {title_of(request.quantity)} over {x} and {y}"
    return sheet.finish(alt)


def _table(
    request: Request, cases: Sequence[Case], models: Sequence[str], metric: str, against: str
) -> pd.DataFrame:
    """A row per case and model: parameters, error, and which of `_MARKS` there is to see."""
    known = request.stored.errors(request.quantity, metric, against)
    found = []
    for case in cases:
        held = request.stored.held_against(case.name, against)
        for label in models:
            sides = label, held
            fallen = sum(request.stored.collapses(case.name, side) for side in sides)
            known_sides = sum(request.stored.ok(case.name, side) for side in sides)
            row = {"case": case.name, "model": label, "against": held, **case.parameters}
            row["error"] = known.get((case.name, label), {}).get("error", np.nan)
            warned = bool(request.stored.cells[case.name, label].outside)
            row |= {"warned": known_sides == 2 and warned, "failed": known_sides + fallen < 2}
            row |= {"collapsed": fallen == known_sides == 1, "both": fallen == 2}
            found.append(row)
    return pd.DataFrame(found)


def _field(table: pd.DataFrame, grid: Any) -> Array:
    """The worst error of every field of a panel, NaN where there is none."""
    (x, xs), (y, ys) = grid
    finite = table[np.isfinite(table["error"])]
    worst = finite.pivot_table("error", y, x, lambda errors: max(errors, key=abs))
    return np.asarray(worst.reindex(index=ys, columns=xs), dtype=float)


def _map(panel: Axes, table: pd.DataFrame, field: Array, grid: Any, limit: float) -> AxesImage:
    """One panel: the error of every field, and marks of its warnings and failures."""
    (x, xs), (y, ys) = grid
    across, up = table[x].map(xs.index), table[y].map(ys.index)
    style: Style = {"origin": "lower", "aspect": "auto", "cmap": "PuOr_r"}
    image = panel.imshow(field, vmin=-limit, vmax=limit, **style)
    panel.set_facecolor("#e8e8e8")
    panel.grid(visible=False)
    panel.spines[:].set_visible(True)
    for column, (_, mark) in _MARKS.items():
        if table[column].any():
            aside = _CORNER if column == "warned" else (0.0, 0.0)
            panel.plot(across[table[column]] + aside[0], up[table[column]] + aside[1], **mark)
    panel.set_xticks(range(len(xs)), [_shown(value) for value in xs])
    panel.set_yticks(range(len(ys)), [_shown(value) for value in ys])
    if sum(len(_shown(value)) for value in xs) > _ROW:
        panel.tick_params(axis="x", labelrotation=90)
    panel.tick_params(length=0)
    return image


def _numbers(panel: Axes, field: Array, limit: float) -> None:
    """The value of every field in whole percent."""
    for (up, across), value in np.ndenumerate(field):
        if np.isfinite(value):
            text = "0" if abs(value) < 0.005 else f"{100.0 * value:+.0f}".replace("-", MINUS)
            colour = "white" if abs(value) > 0.75 * limit else INK
            panel.text(across, up, text, color=colour, fontsize=6.5, ha="center", va="center")


def _models(request: Request, cases: Sequence[Case]) -> list[str]:
    if request.figure.models:
        return [label for label in request.labels if label != request.against]
    skipped = {request.against, *request.study.ladder}
    return [
        label
        for label in request.labels
        if label not in skipped
        and not holds_data(request.study.models[label])
        and any(request.stored.expects(case.name, label) for case in cases)
    ]


def _values(cases: Sequence[Case], name: str) -> list[Any]:
    """The values of a parameter: numbers in rising order, words as they come."""
    found = list(dict.fromkeys(c.parameters[name] for c in cases if name in c.parameters))
    numbers = all(isinstance(value, (int, float)) for value in found)
    return sorted(found) if numbers else found


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)
