"""Files of an explored scenario: a sheet of one page, histories, a picture, a static sweep."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from workbench.api import accessor
from workbench.api.answers import asked
from workbench.api.plots import Plots
from workbench.api.sweeps import unit_at
from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.extras.app.desk import NEAR
from workbench.extras.app.work import inputs_by_path
from workbench.report.gallery import save, to_svg
from workbench.report.page.documents import Document, render_pdf
from workbench.report.page.markdown import Cell, Picture, listing, warnings
from workbench.report.page.page import Page
from workbench.responses import Response, findings_of, survives
from workbench.responses.histories import COORDINATES, FORCE_WINDOW, VARIABLES
from workbench.scenarios import Scenario, to_toml
from workbench.scenarios.files import place_of
from workbench.scenarios.varied import Varied
from workbench.study import Case, Study, assess, run_study
from workbench.study.tables import for_spreadsheets

PAGE = Page(__file__)
_SWEPT = 7  # values of a sweep
_LONG = 60  # characters of a cell beyond which a warning that holds its text tells it
_SHOWN = {"m/s": ("km/h", 3.6), "rad": ("deg", 180.0 / pi), "N": ("kN", 1e-3), "Pa": ("MPa", 1e-6)}


def one_page(
    scenario: Scenario, responses: Mapping[str, Response], reference: str = "", more: Any = ()
) -> bytes:
    """PDF of one A4 page on a scenario and its answers by label, the first of them in full.

    The `reference` among them is black, and stands beside the first; `more` are further blocks.
    Equal input gives equal bytes. Raises `InputError` without an answer.
    """
    if not responses:
        raise InputError("responses", None, "must hold an answer", "ask a model first")
    label, first = next(iter(responses.items()))
    tone = {True: "good", False: "bad", None: "doubt"}[survives(first)]
    answer, other = accessor.as_object(first, scenario), responses.get(reference, first)
    answer["reference"] = None if other is first else accessor.as_object(other, scenario)
    whose: dict[Any, list[str]] = {}  # labels by what warns of them
    for name, response in responses.items():
        for finding in findings_of(response):
            whose.setdefault(finding, []).append(name)
    table: Any = next(accessor.table_blocks("", responses))
    told = " ".join(map(str, whose))
    rows = tuple(tuple(_brief(cell, told) for cell in row) for row in table.rows)
    kinds = "structure", "force-displacement" if scenario.STATIC else "history"
    drawn = {kind: _drawn(kind, scenario, responses, reference) for kind in kinds}
    text = PAGE.blocks(
        "sheet",
        **{"label": label, "answer": answer, "tone": tone, "drawn": drawn},
        **{"models": replace(table, rows=rows), "more": list(more)},
        numbers=accessor.numbers_in_words(first, answer),
        notes=list(accessor.notes_in_words(first, answer)),
        said=[list(warnings([each], f" of {', '.join(names)}")) for each, names in whose.items()],
        words=[pair for pair in scenario.words.items() if pair[0] != "name"],
        file=listing("scenario.toml", to_toml(scenario)),
    )
    made, names = answer["provenance"], ("workbench", "commit", "model_version", "scenario_hash")
    facts = tuple(f"{name.replace('_', ' ')} {made[name]}" for name in names if name in made)
    subtitle = PAGE.words("subtitle")
    return render_pdf(Document(scenario.name, subtitle, facts, text, drawn, layout="sheet"))


def _brief(cell: Cell, told: str) -> Cell:
    """A cell, or a short one where the warnings have `told` its text."""
    long = len(cell.text) > _LONG and cell.text in told
    return Cell(PAGE.words("told", text=cell.text.partition(":")[0])) if long else cell


def _drawn(kind: str, *what: Any) -> Picture:
    """A figure as it stands on the sheet; one with nothing to show says why."""
    words = kind, kind, PAGE.words("caption", kind=kind)
    try:
        drawing: Any = Plots(*what).drawing(kind)
    except InputError as error:
        return Picture(*words, "", "", statements=(str(error.allowed),))
    svg = to_svg(drawing.canvas, kind)
    return Picture(*words, svg, drawing.alt, drawing.width, drawing.statements)


def histories_csv(responses: Mapping[str, Response]) -> str:
    """CSV of all histories one below the other, by label: SI units stand in the names of columns.

    The contact force is its mean over the last ms.
    """
    tables = []
    for label, response in responses.items():
        columns = {
            f"{name}_{known.units}".removesuffix("_1"): response[name].to_numpy()
            for name, known in (COORDINATES | VARIABLES).items()
            if name in response and response[name].dims in (("time",), ("step",))
        }
        if "percussion" in response:
            time, total = columns["time_s"], np.cumsum(response["percussion"].to_numpy())
            before = np.interp(time - FORCE_WINDOW, time, total, left=0.0)
            columns["contact_force_N"] = (total - before) / FORCE_WINDOW
        tables += [pd.DataFrame({"label": label, **columns})] if columns else []
    whole = pd.concat(tables or [pd.DataFrame(columns=["label", "time_s"])])
    whole.columns = whole.columns.str.replace("/", "_per_").str.replace(" ", "_")
    return for_spreadsheets(whole).to_csv(index=False, float_format="%.9g", lineterminator="\n")


def picture(
    scenario: Scenario, responses: Mapping[str, Response], kind: str, ending: str, **options: Any
) -> bytes:
    """Bytes of a figure of a report as SVG or PNG, with its `options` and the `reference`.

    Equal input gives equal bytes.
    Raises `InputError` for unknown kinds and endings, and where there is nothing to show.
    """
    Choice(("svg", "png")).check("ending", ending)
    drawing: Any = Plots(scenario, responses, options.pop("reference", "")).drawing(kind, **options)
    with TemporaryDirectory() as folder:
        save(drawing.canvas, Path(folder, f"{kind}.{ending}"))
        return Path(folder, f"{kind}.{ending}").read_bytes()


def sweep_page(
    scenario: Scenario,
    key: str,
    values: Sequence[float],
    models: Sequence[str],
    reference: str = "",
    folder: Path | None = None,
) -> str:
    """HTML file of a scenario with the value of a `key` varied: the explorer of reports.

    Arguments: `values` in SI units; names of `models`; the `reference` (empty: the first model);
    `folder` that keeps the answers, of which a second page is made without models, byte for byte.
    Raises `InputError` for a value that cannot be, and where no model answers over time.
    """
    from workbench.report.explorer import explorer

    tables, si = tomllib.loads(to_toml(scenario)), unit_at(scenario, key)
    unit, factor = _SHOWN.get(si, (si, 1.0))
    title = f"{key.rpartition('.')[2].replace('_', ' ')}{unit and f' ({unit})'}"
    varied = Varied(tables, {place_of(tables, key, f"{key}={values}"): list(values)})
    shown = [f"{factor * value:.5g}" for value in values]
    pairs = zip(shown, varied, strict=True)
    cases = tuple(Case(f"{title} {n}", each, parameters={title: float(n)}) for n, each in pairs)
    chosen = {name: asked(name) for name in dict.fromkeys(filter(None, (*models, reference)))}
    words = "sweep", scenario.name, PAGE.words("question", title=title)
    study = Study(*words, cases, chosen, reference or next(iter(chosen)))
    with TemporaryDirectory() as empty:
        run_study(study, folder or Path(empty), jobs=0)
        page = explorer(study, assess(study, folder or Path(empty)))
    if page is None:
        raise InputError("models", list(chosen), "answer nothing over time", "take others")
    return re.sub('<span><a href="report.html">.*?</span>', "", page)  # there is none beside it


def picture_if_any(scenario: Scenario, responses: Mapping[str, Response], kind: str) -> str:
    """A figure of the reports as SVG; empty where the answers have nothing to show."""
    try:
        return picture(scenario, responses, kind, "svg").decode()
    except InputError:
        return ""


def swept_page(scenario: Scenario, key: str, names: Sequence[str]) -> str:
    """Page to explore answers over a key, from half to one and a half times the value given."""
    values = np.linspace(*NEAR, _SWEPT) * inputs_by_path(scenario)[key].value
    return sweep_page(scenario, key, values.tolist(), names)
