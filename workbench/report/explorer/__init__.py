"""The explorer: one HTML page over the stored answers of a study, beside its report.

Curves are thinned until the page is as small as its bound.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from workbench.report.chapters import answer, choice, results
from workbench.report.chapters.answer import MatrixCell, MatrixRow, matrix_rows, time_against
from workbench.report.drawing.frame import DIRECTIONS
from workbench.report.drawing.layout import frame_scenario_of
from workbench.report.drawing.shapes import REST, YIELDING, rest_lines
from workbench.report.drawing.style import INTERVAL, looks
from workbench.report.explorer.cells import (
    DETAILS,
    FINE,
    FRAGILITIES,
    HISTORIES,
    ROUGH,
    Detail,
    Plane,
    Record,
    numbers_of,
    record_of,
)
from workbench.report.figures.curves import PARTS
from workbench.report.page.documents import STYLE, templates
from workbench.report.page.formatting import count
from workbench.report.page.reading import callouts
from workbench.report.stored import CellState, Stored
from workbench.scenarios import FrameImpact, UncertainImpact
from workbench.study.definition import Case, Study
from workbench.study.matrix import ALL, against_governing
from workbench.study.tables import rows_of

FILE = "explorer.html"
LARGEST = 5_000_000  # bytes of a page
_HERE = Path(__file__).parent
_DASHES = {"-": "", "--": "6 3", "-.": "7 2 1.5 2"}
_DOTTED = "1.5 2.5"
_MOST = 6  # models shown at first besides the references
_STOPS, _WIDE = 25, 30.0  # places of a slider; ratio of its ends beyond which it is logarithmic
Rows = list[dict[str, Any]]


def explorer(study: Study, stored: Stored, largest: int = LARGEST) -> str | None:
    """HTML of the explorer from stored results, None for a study without histories or curves.

    `largest`, bytes that the page may take: curves are thinned until they fit, or are as rough as
    they may be. Equal stores give equal text.
    """
    uncertain = any(isinstance(case.scenario, UncertainImpact) for case in study.cases)
    plane = FRAGILITIES if uncertain else HISTORIES
    cases = tuple(_cases(study, stored, plane))
    if not any(cell.record for case in cases for cell in case.answers):
        return None
    made = [text for _, text in callouts(results.synthetic(stored))]
    title = f"{results.MARK if made else ''}{study.title}"
    matrix, models, text = matrix_rows(stored), _models(study), ""
    shown = {"study": study, "title": title, "made": made, **_seen(study, cases, matrix, models)}
    shown |= {"plane": plane, "moves": plane is HISTORIES, "timed": time_against(stored)}
    fixed = {**_fixed(study, stored.synthetic, matrix, models), "plane": plane._asdict()}
    for detail in DETAILS:
        texts: dict[str, int] = {"": 0}
        kept = [case.kept(detail, texts) for case in cases]
        data = {**fixed, "cases": kept, "texts": list(texts)}
        text = _page(data, {**shown, "thinned": _thinned(cases, detail, plane)})
        if len(text.encode()) <= largest:
            break
    return text


class _Answer(NamedTuple):
    """One answer: its state, its numbers, and its curves if it has any."""

    state: CellState
    numbers: Mapping[str, Any]
    record: Record | None

    def kept(self, detail: Detail, texts: dict[str, int]) -> dict[str, Any]:
        """The answer as the page holds it; sentences stand once, in `texts`."""
        curves = {} if self.record is None else self.record.kept(detail)
        says = [
            [texts.setdefault(words, len(texts)) for words in (finding.text, finding.remedy)]
            for finding in self.state.findings
        ]
        return {"model": self.state.label, **self.numbers, "says": says, **curves}


class _CaseOfPage(NamedTuple):
    """A case, the row of its governing reference, and its answers."""

    case: Case
    reference: Mapping[str, Any]
    answers: tuple[_Answer, ...]

    def kept(self, detail: Detail, texts: dict[str, int]) -> dict[str, Any]:
        """The case as the page holds it."""
        return {
            "name": self.case.name,
            "at": {name: _plain(value) for name, value in self.case.parameters.items()},
            "reference": self.reference.get("label", ""),
            "inside": bool(self.reference.get("inside")),
            "why": self.reference.get("reason", ""),
            **_structure(self.case),
            "cells": [cell.kept(detail, texts) for cell in self.answers],
        }


def _cases(study: Study, stored: Stored, plane: Plane) -> Iterator[_CaseOfPage]:
    governing = {row["case"]: row for row in stored.rows["references"] if row.get("label")}
    errors: dict[tuple[str, str], dict[str, Any]] = {}
    for row in rows_of(against_governing(stored.tables).reset_index()):
        errors.setdefault((row["case"], row["model"]), {})[row["quantity"]] = row
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
            compared = errors.get((case.name, label), {})
            numbers = numbers_of(state, response, compared, plane, best=best, sure=sure)
            answers.append(_Answer(state, numbers, record))
        yield _CaseOfPage(case, reference, tuple(answers))


def _structure(case: Case) -> dict[str, Any]:
    """Members at rest, supports and the place of the strike, in m."""
    scenario = frame_scenario_of(case.scenario)
    if scenario is None:
        return {}
    frame, hit = scenario.frame, {}
    if isinstance(scenario, FrameImpact):
        node, along = frame.node(scenario.striker.node), DIRECTIONS[scenario.striker.direction]
        hit = {"hit": [node.x, node.y, along.real, along.imag]}
    lines = rest_lines(frame)
    return {
        "rest": np.stack([lines.real, lines.imag], axis=-1).reshape(-1, 4).tolist(),
        "held": [[n.x, n.y, n.support] for n in frame.nodes if n.support != "free"],
        **hit,
    }


def _fixed(study: Study, synthetic: bool, matrix: list[MatrixRow], models: Rows) -> dict[str, Any]:
    """Data of the script besides the cases."""
    groups = dict(study.groups) or {ALL: tuple(case.name for case in study.cases)}
    return {
        "study": f"{'SYNTHETIC ' if synthetic else ''}{study.name}",
        "models": models,
        "groups": {name: list(cases) for name, cases in groups.items()},
        "matrix": [
            {"label": row.label, "cells": {name: _words(cell) for name, cell in row.cells.items()}}
            for row in matrix
        ],
        "parts": [list(part) for part in PARTS],
        "bounds": [answer.GOOD, choice.FAIR],
        "colors": {"band": INTERVAL["color"], "rest": REST, "yields": YIELDING},
    }


def _words(cell: MatrixCell) -> str:
    return "; ".join(filter(None, (cell.statement, cell.ends, cell.details)))


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


def _seen(
    study: Study, cases: Sequence[_CaseOfPage], matrix: list[MatrixRow], models: Rows
) -> dict[str, Any]:
    """Data of the template."""
    names = list(dict.fromkeys(name for case in cases for name in case.case.parameters))
    return {
        "matrix": matrix,
        "groups": list(study.groups),
        "heads": list(dict.fromkeys(group for row in matrix for group in row.cells)),
        "models": models,
        "cases": [case.case.name for case in cases],
        "axes": [axis for name in names for axis in _axis(name, cases)],
        "left": len(study.cases) - len(cases),
        "counted": count(len(cases), "case"),
    }


def _axis(name: str, cases: Sequence[_CaseOfPage]) -> Iterator[dict[str, Any]]:
    """A control over a parameter that varies: its stops, evenly spread if there are many values."""
    given = [c.case.parameters[name] for c in cases if name in c.case.parameters]
    values: list[Any] = list(dict.fromkeys(map(_plain, given)))
    if len(values) < 2:
        return
    if any(isinstance(value, str) for value in values):
        yield {"name": name, "stops": [v if isinstance(v, str) else f"{v:g}" for v in values]}
        return
    low, high = min(values), max(values)
    log = bool(low > 0.0 and high > _WIDE * low)
    values.sort()
    if len(values) > _STOPS:
        spaced = np.geomspace if log else np.linspace
        values = [float(f"{value:.4g}") for value in spaced(low, high, _STOPS)]
    yield {"name": name, "stops": values, "log": log}


def _plain(value: Any) -> float | str:
    """A parameter as JSON holds it: a finite number of five digits, else its text."""
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    return float(f"{float(value):.5g}") if number and np.isfinite(value) else str(value)


def _thinned(cases: Sequence[_CaseOfPage], detail: Detail, plane: Plane) -> str:
    """Return the note on the points that the page leaves out."""
    if plane is FRAGILITIES:
        return "The full curves are in the folder cells of the store."
    records = [cell.record for case in cases for cell in case.answers if cell.record]
    points = max(len(record.time) for record in records)
    taken = max((len(r.shapes.at) for r in records if r.shapes), default=0)
    shapes = min(taken, detail.snapshots + 1)  # the peak may be one more
    return (
        f"Thinned for this page: histories hold about {min(points, detail.points)} of up to "
        f"{points} stored points, their extremes among them, deformed shapes "
        f"{shapes} of up to {taken} stored snapshots, energies and bands {detail.coarse} instants; "
        f"numbers are rounded to 1/{FINE} of the largest of a curve (shapes: 1/{ROUGH}). The full "
        "records are in the folder cells of the store."
    )


def _page(data: Mapping[str, Any], shown: Mapping[str, Any]) -> str:
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    style, scripts = (STYLE, _HERE / "explorer.css"), (_HERE / "plot.js", _HERE / "explorer.js")
    template = templates(_HERE).get_template("explorer.html.jinja")
    return template.render(
        **shown,
        # the only thing that could end the element which holds it, or hide its end
        data=Markup(text.replace("<", "\\u003c")),
        style=Markup("\n".join(path.read_text(encoding="utf-8") for path in style)),
        script=Markup("\n".join(path.read_text(encoding="utf-8") for path in scripts)),
    )
