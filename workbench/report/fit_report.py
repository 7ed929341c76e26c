"""The report of a fit to tests on studs: the answer and its grade, what it rests on, the tests.

Made of the content that `workbench fit --json` prints and of the rows of the table; nothing is
fitted here. One self-contained HTML file or PDF, and the numbers of every figure as CSV beside it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.content.documents import render_html, render_pdf
from workbench.content.tree import Block, Bullets, Callout, Definitions, Document, Picture, Section
from workbench.errors import InputError
from workbench.report.chapters import fit_answer, fit_rows
from workbench.report.chapters.stud_tables import Content
from workbench.report.drawing import influence
from workbench.report.drawing.sheet import Drawing, drawn
from workbench.report.drawing.studs import table_of
from workbench.report.figures import (
    stud_curves,
    stud_guideline,
    stud_interaction,
    stud_residuals,
    stud_scatter,
)
from workbench.report.gallery import Plate, to_csv
from workbench.responses.provenance import provenance
from workbench.studs.tables import first_loading
from workbench.study.definition import Figure
from workbench.study.store import own_directory, write_atomically

_RENDERERS = {"html": lambda content: render_html(content).encode(), "pdf": render_pdf}
FORMATS = tuple(_RENDERERS)
_TITLES = {
    "stud-strength": "Shear strength of headed studs",
    "load-slip": "Load and slip of headed studs",
    "residual": "What is left of headed studs after damage",
    "interaction": "Tension and shear of headed studs together",
    "few-tests": "Characteristic values of few tests on headed studs",
}
_TESTS = "tests"  # name of the file with the rows
_SOFTWARE = ("workbench", "commit", "requirements_lock", "python", "numpy", "scipy")
Drawn = tuple[str, str, str, Drawing]  # key, title, caption


def write(
    result: Mapping[str, Any], rows: Sequence[pd.DataFrame], targets: Mapping[str, Path]
) -> dict[str, Path]:
    """Write reports of a fit; returns what was written, by words.

    Arguments: `result`, what `workbench fit --json` prints; `rows`, the fitted and the unseen rows
    of the tables (schema `TESTS` or `POINTS`); `targets`, paths by format, any of `FORMATS`. Equal
    input gives equal bytes: no time, no path. Raises `InputError` for what cannot be written.
    """
    tables = [Path(name).name for name in result["tables"]]
    content = fit_answer.labelled({**result, "tables": tables})
    figures = list(_figures(content, *rows))
    written: dict[str, Path] = {}
    numbers = {key: drawing.data for key, _, _, drawing in figures if drawing.canvas is not None}
    numbers[_TESTS] = pd.concat(rows).dropna(axis="columns", how="all")
    for kind, target in targets.items():
        try:
            folder = own_directory(target.parent, f"{target.stem}-curves")
            for key, data in numbers.items():
                write_atomically(folder / f"{key}.csv", to_csv(data).encode())
            tree = document(content, rows, figures, folder.name)
            write_atomically(target, _RENDERERS[kind](tree))
        except OSError as error:
            reason = error.strerror or "unknown reason"
            raise InputError("--report", str(target), f"cannot be written: {reason}") from error
        written |= {f"report ({kind})": target, f"its curves ({kind})": folder}
    return written


def document(
    result: Content, rows: Sequence[pd.DataFrame], figures: Sequence[Drawn], folder: str
) -> Document:
    """The content tree of a fit; `folder`, where the numbers of its figures are."""
    warnings = fit_answer.warnings_of(result)
    answer = [*fit_answer.grade(result), *fit_answer.answer(result)]
    if warnings:
        answer.insert(1, Callout("doubt", f"Decisive: {warnings[0]}"))
    rows_of = fit_rows.tests(result, rows, f"{folder}/{_TESTS}.csv")
    pictures = tuple(
        Section(f"figure-{key}", title, (_picture(key, title, caption, drawing, folder),))
        for key, title, caption, drawing in figures
    )
    record = provenance()
    software = ((n.replace("_", " "), f"`{record[n]}`") for n in _SOFTWARE if n in record)
    parts = (
        Section("answer", "The answer", tuple(answer)),
        Section("basis", "What it rests on", tuple(_basis(result))),
        Section("warnings", "Warnings, the decisive ones first", tuple(_warnings(result))),
        Section("figures", "Figures", pictures),
        Section("numbers", "Numbers", tuple(fit_answer.tables_of(result))),
        Section("method", "Formulas and method", tuple(fit_answer.method(result))),
        Section("tests", "The tests", tuple(rows_of)),
        Section("software", "Software", (Definitions(tuple(software)),)),
    )
    sections = tuple(part for part in parts if part.blocks)
    made = [f"{name} {record[name]}" for name in ("workbench", "commit") if name in record]
    facts = (fit_answer.size(result), f"table: {fit_answer.sources_of(result)}", ", ".join(made))
    return Document(_TITLES[result["fit"]], "Evaluation of tests", facts, sections)


def _picture(key: str, title: str, caption: str, drawing: Drawing, folder: str) -> Picture:
    found = Plate(Figure(key, "", title, caption), drawing).picture()
    return replace(found, files=tuple(f"{folder}/{Path(name).name}" for name in found.files))


def _figures(result: Content, fitted: pd.DataFrame, held: pd.DataFrame) -> Iterator[Drawn]:
    """Predictions, residuals or curves of a fit, and how every test moves it."""
    named = fit_answer.named_of(result)
    contents = fit_answer.contents_of(result)
    titles = list(named)
    match result["fit"]:
        case "stud-strength":
            caption = "Measured over predicted strength; below the line a prediction is unsafe."
            # the figure draws unseen tests of contents with a basis
            told = {name: {**c, "basis": ""} if c["judged"] else c for name, c in named.items()}
            yield "prediction", "Prediction", caption, drawn(stud_scatter.plot, told)
            name, content = fit_answer.formula(result)
            caption = f"What {name} misses: a trend in a variable is one that it lacks."
            tests = table_of(content["tests"])
            yield "residuals", "Residuals", caption, drawn(stud_residuals.plot, name, tests)
        case "load-slip":
            points = (first_loading(p, falling=True) if len(p) else p for p in (fitted, held))
            caption = "Load over its largest value: the laws with their bands over the tests."
            yield "curves", "Curves", caption, drawn(stud_curves.plot, dict(named), *points)
        case "residual":
            titles = [fit_answer.stud_of(content) for content in contents]
            panels = [(c["fit"]["quantity"], t, c) for c, t in zip(contents, titles, strict=True)]
            caption = (
                "Share that is left; the band ends where the tested damage ends, beyond it the "
                "line is an extrapolation."
            )
            yield "left", "What is left", caption, drawn(stud_guideline.plot, panels)
            single = len(set(titles)) == 1
            titles = [q if single else f"{q}, {t}" for q, t, _ in panels]
        case "interaction":
            caption = "Tension and shear over the resistances under one of them alone."
            (content,) = contents
            yield "interaction", "Law", caption, drawn(stud_interaction.plot, content)
    moved = {
        (title if len(set(rows["answer"])) == 1 else f"{title}, {answer}"): own
        for title, content in zip(titles, contents, strict=True)
        if content["influence"]
        for rows in [pd.DataFrame(content["influence"])]
        for answer, own in rows.groupby("answer", sort=False)
    }
    if moved:
        caption = "Change of the answer when one test is left out, all else kept."
        yield "influence", "Influence of single tests", caption, drawn(influence.plot, moved)


def _basis(result: Content) -> Iterator[Block]:
    campaigns = {name for c in fit_answer.contents_of(result) for name in c["fit"]["campaigns"]}
    given = {k: v if isinstance(v, list) else [v] for k, v in result["options"].items()}
    options = ", ".join(f"{name} = {', '.join(map(str, v))}" for name, v in given.items())
    pairs = [
        ("tests", fit_answer.size(result)),
        *([("campaigns", ", ".join(sorted(campaigns)))] if campaigns else []),
        ("held out to judge the fit", ", ".join(result["validate"]) or "none"),
        ("the grade holds", fit_answer.holds(result)),
        ("table", fit_answer.sources_of(result)),
        ("SHA-256 of the table", f"`{result['digest']}`" if result["digest"] else "shipped"),
        ("confidence of intervals", f"{100 * result['confidence']:g} %"),
        ("options", options or "none"),
    ]
    yield Definitions(tuple(pairs))
    if out := list(fit_answer.left_out(result)):
        yield Bullets(tuple(out))


def _warnings(result: Content) -> Iterator[Block]:
    warnings = fit_answer.warnings_of(result)
    if warnings:
        yield Bullets(tuple(map(str, warnings)))
    elif fit_answer.contents_of(result):
        yield Callout("good", "None of the checks found anything to warn of.")
