"""The explorer: one HTML page over the stored answers of a study, beside its report.

Curves are thinned until the page is as small as its bound.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bokeh.core.json_encoder import serialize_json
from bokeh.document import Document
from bokeh.layouts import column
from bokeh.layouts import row as beside
from bokeh.models import (
    Arrow,
    Button,
    CategoricalSlider,
    ColumnDataSource,
    DataRange1d,
    FixedTicker,
    HoverTool,
    Legend,
    Select,
    Slider,
    Span,
    TapTool,
    Toggle,
    UIElement,
    VeeHead,
)
from bokeh.plotting import figure
from bokeh.resources import Resources
from markupsafe import Markup
from matplotlib.ticker import MaxNLocator

from workbench.report.chapters import answer, results
from workbench.report.chapters.answer import GOOD, matrix_rows, time_against
from workbench.report.chapters.choice import FAIR
from workbench.report.drawing.frame import frame_scenario_of, node_on_paper, way_on_paper
from workbench.report.drawing.shapes import REST, YIELDING, Shapes, magnification, rest_lines
from workbench.report.drawing.style import GRID, INK, INTERVAL, MUTED, looks
from workbench.report.explorer.cells import (
    DETAILS,
    FRAGILITIES,
    HISTORIES,
    CurveRecord,
    Plane,
    coarse,
    is_upright,
    numbers_of,
    record_of,
)
from workbench.report.figures.curves import PARTS
from workbench.report.page.documents import STYLE, templates
from workbench.report.page.formatting import count, direction
from workbench.report.page.reading import callouts
from workbench.scenarios import FrameImpact, canonical
from workbench.study.assessor import BEST, Assessment, CellState
from workbench.study.chooser import ALL
from workbench.study.definition import Case, Study

FILE = "explorer.html"
LARGEST = 6_500_000  # bytes of a page, of which BokehJS takes 1.7 million
MOST_CELLS = 5_000  # of a study that a browser can hold
_HERE = Path(__file__).parent
_DASHES = {"-": "solid", "--": "6 3", "-.": "7 2 2 2"}
_DOTTED = "2 3"
_MOST = 6  # models shown at first besides the references
_WIDE = 30.0  # ratio of the ends of an axis beyond which it is logarithmic
_SCALES = ("1", "2", "5", "10", "50")  # of displacements that may be chosen
_LOWER = 0.35  # of its length, by which a column is drawn lower as seen along the hit
_MOST_NAMES = 8  # cases that an axis names; more are counted
Rows = list[dict[str, Any]]


def explorer(study: Study, stored: Assessment, largest: int = LARGEST) -> str | None:
    """HTML of the explorer from stored results; None without histories or curves, or of too many.

    `largest`, bytes that the page may take: curves are thinned until they fit, or are as rough as
    they may be. Equal stores give equal text.
    """
    if len(stored.cells) > MOST_CELLS:
        return None
    uncertain = any(hasattr(case.scenario, "structure") for case in study.cases)
    plane = FRAGILITIES if uncertain else HISTORIES
    cases = tuple(_cases(study, stored, plane))
    if not any(cell.record for case in cases for cell in case.answers):
        return None
    made = [text for _, text in callouts(results.synthetic(stored))]
    title = f"{results.MARK if made else ''}{study.title}"
    matrix, models, axes = matrix_rows(stored), _models(study), _axes(cases)
    groups, moves, text = tuple(study.groups), plane is HISTORIES, ""
    drawn, roots = plots(plane, moves, groups, axes, list(study.models))
    shown = {
        **{"study": study, "title": title, "made": made, "matrix": matrix, "models": models},
        **{"heads": list(dict.fromkeys(group for row in matrix for group in row.cells))},
        **{"left": len(study.cases) - len(cases), "counted": count(len(cases), "case")},
        **{"plane": plane, "moves": moves, "timed": time_against(stored), "roots": roots},
        **{"plots": _escaped(drawn), "bokeh": Markup(bokeh_script())},
    }
    fixed = {
        "study": f"{'SYNTHETIC ' if stored.synthetic else ''}{study.name}",
        "models": models,
        "groups": dict(study.groups) or {ALL: tuple(case.name for case in study.cases)},
        "axes": axes,
        "parts": [list(part) for part in PARTS],
        "bounds": [100.0 * bound for bound in (0.0, GOOD, -GOOD, FAIR, -FAIR)],
        "plane": {**plane._asdict(), "moves": moves, "main": next(iter(plane.numbers.values()))},
        "titles": [titled(plane.across), titled(next(iter(plane.numbers.values())))],
        "colors": {"band": INTERVAL["color"], "yields": YIELDING, "ink": INK},
    }
    for points in DETAILS:
        data = {**fixed, "cases": [case.kept(points) for case in cases]}
        text = _page(data, {**shown, "thinned": _thinned(cases, points, plane)})
        if len(text.encode()) <= largest:
            break
    return text


class _Answer(NamedTuple):
    """One answer: its state, its numbers, and its curves if it has any."""

    state: CellState
    numbers: Mapping[str, Any]
    record: CurveRecord | None

    def kept(self, points: int, aside: bool) -> dict[str, Any]:
        """The answer as the page holds it; with `aside`, shapes as seen along the hit, too."""
        curves = {} if self.record is None else self.record.kept(points, aside)
        says = [
            f"{f.text}. Instead: {f.remedy}." if f.remedy else f"{f.text}."
            for f in self.state.findings
        ]
        return {"model": self.state.label, **self.numbers, "says": says, **curves}


class _CaseOfPage(NamedTuple):
    """A case, the row of its governing reference, and its answers."""

    case: Case
    reference: Mapping[str, Any]
    answers: tuple[_Answer, ...]

    def kept(self, points: int) -> dict[str, Any]:
        """The case as the page holds it."""
        label, words = self.reference.get("label", ""), "there is nothing to compare with."
        about = f"No reference answered this case: {words}"
        if label:
            inside = "" if self.reference.get("inside") else ", which is outside its own domain"
            about = f"Errors against {label}{inside}."
        if why := self.reference.get("reason", ""):
            about = f"{about} Why this reference: {why}."
        named = self.case.name, direction(canonical(self.case.scenario)[0])
        shapes = [cell.record.shapes for cell in self.answers if cell.record and cell.record.shapes]
        aside = any(each.aside is not None for each in shapes)
        return {
            "name": self.case.name,
            "reference": label,
            "about": f"{', '.join(filter(None, named))}. {about}",
            **_structure(self.case, shapes, aside),
            "cells": [cell.kept(points, aside) for cell in self.answers],
        }


def _cases(study: Study, stored: Assessment, plane: Plane) -> Iterator[_CaseOfPage]:
    governing = {row["case"]: row for row in stored.records("references") if row["label"]}
    errors = {q: stored.errors(q, "relative_error", BEST) for q in plane.numbers}
    for case in study.cases:
        if plane is HISTORIES and case.scenario.STATIC is not False:
            continue
        reference = governing.get(case.name, {})
        best = stored.cells.get((case.name, reference.get("label", "")))
        best, sure = None if stored.synthetic else best, bool(reference.get("inside"))
        answers = []
        for label in study.models:
            state = stored.cells.get((case.name, label))
            if state is None:
                continue
            response = stored.response(case.name, label, keep=False)
            band = label == reference.get("label")
            record = None if response is None else record_of(case, response, band=band)
            cell = case.name, label
            compared = {q: known[cell] for q, known in errors.items() if cell in known}
            numbers = numbers_of(state, response, compared, plane, best=best, sure=sure)
            answers.append(_Answer(state, numbers, record))
        yield _CaseOfPage(case, reference, tuple(answers))


def _structure(case: Case, shapes: Sequence[Shapes], aside: bool) -> dict[str, Any]:
    """Members at rest, supports, place of the strike in m; a lone column lies, `aside` twice."""
    scenario = frame_scenario_of(case.scenario)
    if scenario is None:
        return {}
    frame, hit = scenario.frame, {}
    lines = rest_lines(frame)
    upright, foot = is_upright(lines), float(lines.real.min())

    def place(z: complex) -> list[float]:
        return [z.imag, z.real - foot] if upright else [z.real, z.imag]

    if isinstance(scenario, FrameImpact):
        tip = node_on_paper(frame.node(scenario.striker.node))
        along = way_on_paper(frame, scenario.striker)
        size = max(np.ptp(lines.real), np.ptp(lines.imag))
        hit = {"hit": [*place(tip - 0.12 * size * along), *place(tip)]}
    rest = [[*place(start), *place(end)] for start, end in lines]
    if aside:
        lower = _LOWER * float(np.ptp(lines.imag))
        rest += [[x, y - lower, end, height - lower] for x, y, end, height in rest]
    largest = max((s.largest(list(range(len(s.at)))) for s in shapes), default=0.0)
    return {
        "rest": rest,
        "aside": aside,
        "held": [
            [*place(node_on_paper(n)), "square" if n.support == "clamped" else "circle"]
            for n in frame.nodes
            if n.support != "free"
        ],
        "upright": upright,
        "times": magnification(largest, shapes[0].size) if shapes else 1.0,
        **hit,
    }


def _models(study: Study) -> Rows:
    """Labels with their looks, and whether they are shown at first."""
    figures = [f.models for f in study.figures if f.key == answer.decisive(study)]
    wanted = (*figures, ())[0] or tuple(study.models)
    first = {*study.ranked, *[label for label in wanted if label not in study.ranked][:_MOST]}
    return [
        {
            "label": label,
            "color": look.color,
            "dash": _DASHES.get(str(look.line), _DOTTED),
            "width": look.width,
            "rank": study.ranked.index(label) + 1 if label in study.ranked else 0,
            "shown": label in first,
        }
        for label, look in looks(study).items()
    ]


def _axes(cases: Sequence[_CaseOfPage]) -> Rows:
    """The ways to lay out the cases: parameters that vary, each with a control; their order.

    Of each: `stops`, the values of the control as text; `at`, the stop of each case; `place`,
    where each case stands; `ticks`, pairs of a place and its text.
    """
    ways: Rows = []
    for name in dict.fromkeys(name for case in cases for name in case.case.parameters):
        given = [
            _plain(c.case.parameters[name]) if name in c.case.parameters else None for c in cases
        ]
        values: list[Any] = list(dict.fromkeys(value for value in given if value is not None))
        if len(values) < 2:
            continue
        words = any(isinstance(value, str) for value in values)
        values = values if words else sorted(values)
        stops = [value if isinstance(value, str) else f"{value:.5g}" for value in values]
        at = [None if value is None else values.index(value) for value in given]
        log = not words and values[0] > 0.0 and values[-1] > _WIDE * values[0]
        way = {"name": name, "stops": stops, "at": at, "words": words}
        if words:
            ways.append({**way, "place": at, "ticks": list(enumerate(stops))})
            continue
        scale = np.log10 if log else np.asarray
        marks: Sequence[float] = MaxNLocator(5).tick_values(values[0], values[-1])
        if log:
            within = [1, 2, 5] if values[-1] < 200 * values[0] else [1]
            marks = [k * 10.0**decade for decade in range(-9, 13) for k in within]
        marks = [m for m in marks if values[0] * (1 - 1e-9) <= m <= values[-1] * (1 + 1e-9)]
        place = [None if value is None else float(scale(value)) for value in given]
        ways.append({**way, "place": place, "ticks": [(float(scale(m)), f"{m:g}") for m in marks]})
    every = -(-len(cases) // _MOST_NAMES)
    names = [c.case.name if every == 1 else str(i + 1) for i, c in enumerate(cases)]
    order = list(range(len(cases)))
    last = {"name": "the cases in order", "stops": [], "at": order, "words": False}
    return [*ways, {**last, "place": order, "ticks": list(enumerate(names))[::every]}]


def _plain(value: Any) -> float | str:
    """A parameter as JSON holds it: a finite number of five digits, else its text."""
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    return float(f"{float(value):.5g}") if number and np.isfinite(value) else str(value)


def _thinned(cases: Sequence[_CaseOfPage], points: int, plane: Plane) -> str:
    """Return the note on the points that the page leaves out."""
    if plane is FRAGILITIES:
        return "The full curves are in the folder cells of the store."
    records = [cell.record for case in cases for cell in case.answers if cell.record]
    most = max(len(record.time) for record in records)
    taken = max((len(r.shapes.at) for r in records if r.shapes), default=0)
    shapes = min(taken, coarse(points) + 1)  # the peak may be one more
    return (
        f"Thinned for this page: histories hold about {min(most, points)} of up to "
        f"{most} stored points, their extremes among them, deformed shapes "
        f"{shapes} of up to {taken} stored snapshots, energies and bands {coarse(points)} "
        "instants; numbers are rounded to 1/32000 of the largest of a curve. The full records "
        "are in the folder cells of the store."
    )


def _escaped(text: str) -> Markup:
    """JSON inside its element: the only thing that could end it, or hide its end, is escaped."""
    return Markup(text.replace("<", "\\u003c"))


def _page(data: Mapping[str, Any], shown: Mapping[str, Any]) -> str:
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    style, script = (STYLE, _HERE / "explorer.css"), _HERE / "explorer.js"
    template = templates(_HERE).get_template("explorer.html.jinja")
    return template.render(
        **shown,
        data=_escaped(text),
        style=Markup("\n".join(path.read_text(encoding="utf-8") for path in style)),
        script=Markup(script.read_text(encoding="utf-8")),
    )


def bokeh_script() -> str:
    """The library that draws, as the page holds it."""
    return "\n".join(Resources(mode="inline", components=["bokeh", "bokeh-widgets"]).js_raw)


def plots(
    plane: Plane, moves: bool, groups: Sequence[str], axes: Sequence[dict[str, Any]], labels: Any
) -> tuple[str, list[str]]:
    """The document of Bokeh as JSON text, and the names of its roots, each an element of the page.

    Arguments: the `plane` of the curves; whether structures move (`moves`); the `groups` of cases;
    `axes`, the ways to lay out all cases, those with stops as a control too; `labels` of models.
    """
    roots = {
        "controls": _controls(groups, axes),
        "history": _history(plane, moves),
        "sweep": _sweep(plane, moves, axes),
        "focus": _select("focus", "large and bold", labels),
    }
    if moves:
        roots |= {"shape": _shape(), "energy": _energy()}
    document = Document(title="explorer")
    for root in roots.values():
        document.add_root(root)
    ids = [root.id for root in roots.values()]
    items = [{"docid": "page", "root_ids": ids, "roots": dict(zip(ids, roots, strict=True))}]
    text = serialize_json([{"page": document.to_json(deferred=False)}, items])
    # Bokeh counts its models through the process: equal pages count from one
    known: dict[str, str] = {}
    for name in re.findall(r'"id":"(p\d+)"', text):
        known.setdefault(name, f'"p{len(known) + 1}"')
    return re.sub(r'"(p\d+)"', lambda found: known.get(found[1], found[0]), text), list(roots)


def _select(name: str, title: str, options: Sequence[Any], value: str = "") -> Select:
    pairs = [option if isinstance(option, tuple) else (option, option) for option in options]
    value = value or (pairs[0][0] if pairs else "")
    return Select(name=name, title=title, options=pairs, value=value, sizing_mode="stretch_width")


def _buttons(*labels: tuple[str, str]) -> UIElement:
    buttons = [Button(name=name, label=label, margin=4) for name, label in labels]
    return beside(*buttons, styles={"flex-wrap": "wrap"})


def _controls(groups: Sequence[str], axes: Sequence[dict[str, Any]]) -> UIElement:
    parts: list[UIElement] = []
    if groups:
        parts.append(_select("group", "group", [("", "all"), *groups]))
    for i, axis in enumerate(axes):
        stops, name = axis["stops"], f"axis-{i}"
        if axis["words"]:
            parts.append(_select(name, axis["name"], stops))
        elif stops:
            parts.append(
                CategoricalSlider(
                    name=name,
                    title=axis["name"],
                    categories=stops,
                    value=stops[0],
                    sizing_mode="stretch_width",
                )
            )
    walk = _buttons(("previous", "◂ Previous"), ("next", "Next ▸"))
    return column(*parts, _select("case", "case", []), walk, sizing_mode="stretch_width")


def new_plot(name: str, across: str, upward: str, height: int, **more: Any) -> figure:
    """An empty plot in the look of the reports, with titles of its axes."""
    plot = figure(
        name=name,
        height=height,
        sizing_mode="stretch_width",
        x_axis_label=across,
        y_axis_label=upward,
        tools="box_zoom,reset,save",
        active_drag=None,  # a finger scrolls the page
        **more,
    )
    plot.toolbar.logo, plot.toolbar.autohide = None, True
    plot.outline_line_color = None
    plot.grid.grid_line_color = GRID
    plot.axis.axis_line_color = plot.axis.major_tick_line_color = MUTED
    plot.axis.minor_tick_line_color = None
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.axis_label_text_color = plot.axis.major_label_text_color = INK
    return plot


def empty_source(name: str, *columns: str) -> ColumnDataSource:
    """A source without rows, by which a page finds what it draws."""
    return ColumnDataSource(name=name, data={column: [] for column in columns})


def _lines(plot: figure, name: str, **more: Any) -> Any:
    looks: dict[str, Any] = {"line_color": "color", "line_width": "width", "line_dash": "dash"}
    source = empty_source(name, "x", "y", "label", *looks.values())
    return plot.multi_line("x", "y", **looks, line_join="round", source=source, **more)


def _cursor(plot: figure, name: str) -> None:
    plot.add_layout(Span(name=name, dimension="height", location=0, line_color=INK, line_width=1.4))


def titled(named: tuple[str, str, float]) -> str:
    """The title of an axis with its unit."""
    return f"{named[0]} ({named[1]})" if named[1] else named[0]


def _history(plane: Plane, moves: bool) -> UIElement:
    across, upward = plane.across, plane.upward
    plot = new_plot("history-plot", titled(across), titled(upward), 340)
    band = empty_source("band", "x", "y", "color")
    plot.patches("x", "y", fill_color="color", fill_alpha=0.3, line_color=None, source=band)
    lines = _lines(plot, "lines")
    ends = empty_source("ends", "x", "y", "color")
    crosses = plot.scatter(
        "x", "y", color="color", marker="x", size=11, line_width=2.4, source=ends
    )
    plot.scatter("x", "y", color="color", size=7, source=empty_source("dots", "x", "y", "color"))
    plot.x_range = DataRange1d(renderers=[lines, crosses], range_padding=0.0)
    plot.y_range = DataRange1d(renderers=[lines, crosses], range_padding=0.06)
    _cursor(plot, "cursor")
    told = [
        (title, f"${side}{{0.00}} {unit}")
        for side, (title, unit, _) in (("x", across), ("y", upward))
    ]
    plot.add_tools(HoverTool(renderers=[lines], tooltips=[("", "@label"), *told]))
    slider = Slider(name="time", title=titled(across), start=0.0, end=1.0, value=0.0, step=0.0025)
    slider.update(format="0.0" if moves else "0.00", sizing_mode="stretch_width", margin=8)
    play = Toggle(name="play", label="Play", width=80)
    buttons = _buttons(
        ("all", "All models"),
        ("none", "References only"),
        ("csv", "Download these curves (CSV)"),
        ("link", "Copy a link to this view"),
    )
    moved = beside(play, slider, sizing_mode="stretch_width")
    return column(plot, moved, buttons, sizing_mode="stretch_width")


def _shape() -> UIElement:
    plot = new_plot("shape-plot", "m", "m", 380, match_aspect=True)
    rest = empty_source("rest", "x", "y")
    plot.multi_line("x", "y", line_color=REST, line_width=1.5, source=rest)
    box = plot.scatter("x", "y", alpha=0.0, source=empty_source("box", "x", "y"))
    plot.x_range = DataRange1d(renderers=[box], range_padding=0.12)
    plot.y_range = DataRange1d(renderers=[box], range_padding=0.12)
    held = empty_source("held", "x", "y", "marker")
    looks: dict[str, Any] = {
        "fill_color": "white",
        "line_color": MUTED,
        "line_width": 2,
        "size": 11,
    }
    plot.scatter("x", "y", marker="marker", source=held, **looks)
    _lines(plot, "shapes")
    hinges = empty_source("hinges", "x", "y", "color")
    plot.scatter("x", "y", fill_color="color", line_color=INK, size=9, source=hinges)
    tip = VeeHead(size=10, fill_color=INK, line_color=INK)
    hit = empty_source("hit", "x_start", "y_start", "x_end", "y_end")
    plot.add_layout(Arrow(end=tip, line_color=INK, line_width=2, source=hit))
    scales = [("", "so that they are seen"), *((s, f"× {s}") for s in _SCALES)]
    times = _select("times", "displacements drawn", scales)
    return column(times, plot, sizing_mode="stretch_width")


def _energy() -> UIElement:
    plot = new_plot("energy-plot", "time (ms)", "energy (kJ)", 340)
    names = [name for name, _, _ in PARTS]
    source = empty_source("energy", "t", "brought", *names)
    areas = plot.varea_stack(names, x="t", color=[color for *_, color in PARTS], source=source)
    line = plot.line("t", "brought", line_color=INK, line_dash="dashed", source=source)
    plot.x_range = DataRange1d(range_padding=0.0)
    _cursor(plot, "energy-cursor")
    items: list[Any] = [(title, [area]) for (_, title, _), area in zip(PARTS, areas, strict=True)]
    items.append(("brought in so far", [line]))
    plot.add_layout(
        Legend(items=items, ncols=2, label_text_font_size="11px", border_line_color=None), "below"
    )
    return column(plot, sizing_mode="stretch_width")


def _sweep(plane: Plane, moves: bool, axes: Sequence[dict[str, Any]]) -> UIElement:
    main = next(iter(plane.numbers.values()))
    kinds = [("error", f"error of the {main[0]}"), ("main", main[0])]
    plot = new_plot("sweep-plot", "", "", 320)
    looks: dict[str, Any] = {
        "line_color": "color",
        "fill_color": "fill",
        "size": "size",
        "marker": "marker",
    }
    looks |= {"alpha": "alpha", "line_width": "width"}
    source = empty_source("points", "x", "y", "label", "case", *looks.values())
    points = plot.scatter("x", "y", source=source, **looks)
    ring = empty_source("ring", "x", "y")
    plot.scatter("x", "y", size=16, fill_color=None, line_color=INK, line_width=1.5, source=ring)
    tips = [("", "@label"), ("case", "@case"), (main[0], "@y{0.00}")]
    plot.add_tools(TapTool(renderers=[points]), HoverTool(renderers=[points], tooltips=tips))
    plot.hspan("y", line_color=MUTED, line_dash="dash", source=empty_source("bounds", "y", "dash"))
    plot.x_range = DataRange1d(renderers=[points], range_padding=0.08)
    plot.y_range = DataRange1d(renderers=[points], range_padding=0.08)
    plot.xaxis.ticker = FixedTicker(ticks=[])
    plot.xaxis.name, plot.yaxis.name = "sweep-across", "sweep-upward"
    y = _select("y", "shown", kinds if moves else kinds[::-1])
    x = _select("x", "over", [axis["name"] for axis in axes])
    return column(beside(y, x, sizing_mode="stretch_width"), plot, sizing_mode="stretch_width")
