"""Maps of a sweep: the error of each model over two parameters, small multiples over a third.

Options: `x`, `y`, `facet` (names of case parameters; default the first three that vary), `rows`
(a parameter for the rows of panels when a single model is shown; default a fourth that varies),
`quantity`, `metric`, `against`, `limit` (value at which the colours end, default 0.2).
Cases that differ only in further parameters share a field; the worst of them is shown.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from workbench.content.formatting import metric_title, title_of
from workbench.report.figures.drawing import Drawing, Request, joined, nothing, rows
from workbench.report.figures.style import INK, legend_below, new_figure
from workbench.study.definition import Case

_MOST_FACETS = 6
_HIGHEST = 8.6  # inches


def draw(request: Request) -> Drawing:
    """Rows of panels are models (or values of a parameter), columns values of the facet."""
    cases = [case for case in request.cases if case.parameters]
    names = _varying(cases)
    if len(names) < 2:
        return nothing("A map needs cases with two parameters that vary.")
    x = str(request.option("x", names[0]))
    y = str(request.option("y", next(name for name in names if name != x)))
    rest = [name for name in names if name not in (x, y)]
    facet = str(request.option("facet", rest[0] if rest else ""))
    quantity = str(request.option("quantity", request.study.quantities[0]))
    metric = str(request.option("metric", "relative_error"))
    against = str(request.option("against", request.study.reference))
    models = _models(request, cases, against)
    if not models:
        return nothing("No model of the sweep is held against another.")
    table = request.stored.errors(quantity, metric, against)
    known = {(r["case"], r["model"]): float(r["error"]) for r in table.to_dict("records")}
    facets = _values(cases, facet) if facet else [None]
    colour = f"{metric_title(metric)} of the {title_of(quantity)} against {against}"
    statements = [f"Colour: {colour}."]
    if len(facets) > _MOST_FACETS:
        statements.append(f"Shown are the first {_MOST_FACETS} of {len(facets)} values of {facet}.")
        facets = facets[:_MOST_FACETS]
    lines: list[tuple[str, Any]] = [(model, None) for model in models]
    further = [name for name in rest if name != facet]
    by = str(request.option("rows", further[0] if further else "")) if len(models) == 1 else ""
    if by:
        lines = [(models[0], value) for value in _values(cases, by)[:_MOST_FACETS]]
        further = [name for name in further if name != by]
    limit = float(request.option("limit", 0.2))
    grid = (_values(cases, x), _values(cases, y))
    high = max(1.35, 0.3 * len(grid[1]) + 0.5)
    height = min(_HIGHEST, 0.95 + len(lines) * high)
    room = int(14.0 * (height - 0.95) / len(lines))  # characters along a panel's height
    canvas = new_figure(height)
    axes = canvas.subplots(len(lines), len(facets), squeeze=False, sharex=True, sharey=True)
    blocks: list[Any] = []
    image = None
    for i, (label, line) in enumerate(lines):
        for j, value in enumerate(facets):
            here = [
                case
                for case in cases
                if (not facet or case.parameters.get(facet) == value)
                and (not by or case.parameters.get(by) == line)
            ]
            panel = axes[i, j]
            image = _panel(request, panel, here, label, against, (x, y), grid, known, limit, blocks)
            if i == 0 and facet:
                panel.set_title(_shown(value) if j else f"{facet}: {_shown(value)}", loc="left")
            if i == len(lines) - 1:
                panel.set_xlabel(x)
            if j == 0:
                head = _shown(line) if by else label
                panel.set_ylabel("\n".join([head, *textwrap.wrap(y, room)]))
    assert image is not None
    bar = canvas.colorbar(image, ax=axes, extend="both", shrink=0.85, aspect=30, pad=0.015)
    bar.set_label(metric_title(metric))
    bar.ax.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    bar.outline.set_linewidth(0.4)
    legend_below(canvas, _legend())
    if by:
        statements.append(f"Model: {models[0]}. Rows of panels: {by}.")
    if further:
        shown = ", ".join(further)
        statements.append(f"Each field shows the worst of the cases that differ in {shown}.")
    alt = f"maps of the {metric_title(metric)} of {title_of(quantity)} over {x} and {y}"
    return Drawing(canvas, joined(blocks), tuple(statements), alt)


def _panel(
    request: Request,
    panel: Axes,
    cases: Sequence[Case],
    label: str,
    against: str,
    names: tuple[str, str],
    grid: tuple[list[Any], list[Any]],
    known: dict[tuple[str, str], float],
    limit: float,
    blocks: list[Any],
) -> Any:
    (x, y), (xs, ys) = names, grid
    field = np.full((len(ys), len(xs)), np.nan)
    warned: set[tuple[int, int]] = set()
    failed: set[tuple[int, int]] = set()
    for case in cases:
        at = ys.index(case.parameters[y]), xs.index(case.parameters[x])
        sides = [request.stored.cells.get((case.name, side)) for side in (label, against)]
        if any(cell is None or not cell.ok for cell in sides):
            failed.add(at)
        elif sides[0] is not None and sides[0].warnings:
            warned.add(at)
        error = known.get((case.name, label))
        if error is not None and not abs(error) <= abs(field[at]):
            field[at] = error
        entry = {
            "case": case.name,
            "model": label,
            **case.parameters,
            "error": np.nan if error is None else error,
            "warned": at in warned,
            "failed": at in failed,
        }
        blocks.append(rows(entry, 1))
    image = panel.imshow(
        *(field,), origin="lower", aspect="auto", cmap="PuOr_r", vmin=-limit, vmax=limit
    )
    panel.set_facecolor("#e8e8e8")
    panel.grid(visible=False)
    for spine in panel.spines.values():
        spine.set_visible(True)
    for fields, style in ((warned, _WARNED), (failed, _FAILED)):
        if fields:
            row, column = np.array(sorted(fields)).T
            panel.plot(column, row, linestyle="none", **style)
    panel.set_xticks(range(len(xs)), [_shown(value) for value in xs])
    panel.set_yticks(range(len(ys)), [_shown(value) for value in ys])
    if sum(len(_shown(value)) for value in xs) > 16:
        panel.tick_params(axis="x", labelrotation=90)
    panel.tick_params(length=0)
    return image


_WARNED: dict[str, Any] = {
    "marker": "o",
    "markersize": 3.2,
    "markerfacecolor": "none",
    "markeredgecolor": INK,
    "markeredgewidth": 0.8,
}
_FAILED: dict[str, Any] = {
    "marker": "x",
    "markersize": 4.5,
    "markeredgecolor": "#b30000",
    "markeredgewidth": 1.2,
}


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], linestyle="none", label="outside a model assumption (warning)", **_WARNED),
        Line2D([], [], linestyle="none", label="no answer", **_FAILED),
    ]


def _models(request: Request, cases: Sequence[Case], against: str) -> list[str]:
    if request.figure.models:
        return [label for label in request.labels if label != against]
    skipped = {against, *request.study.ladder}
    return [
        label
        for label in request.labels
        if label not in skipped
        and request.study.models[label].name != "published"
        and any(request.stored.expects(case.name, label) for case in cases)
    ]


def _varying(cases: Sequence[Case]) -> list[str]:
    names = dict.fromkeys(name for case in cases for name in case.parameters)
    return [name for name in names if len(_values(cases, name)) > 1]


def _values(cases: Sequence[Case], name: str) -> list[Any]:
    """The values of a parameter: numbers in rising order, words as they come."""
    found = list(dict.fromkeys(c.parameters[name] for c in cases if name in c.parameters))
    numbers = all(isinstance(value, (int, float)) for value in found)
    return sorted(found) if numbers else found


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)
