"""The report of a stored study, and the page of it that is kept in git."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from workbench.base.datafiles import check_library
from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.base.offered import offered
from workbench.report.chapters import (
    answer,
    budgets,
    choice,
    configuration,
    limits,
    results,
    stud_study,
    verdicts,
)
from workbench.report.explorer import FILE, explorer
from workbench.report.gallery import draw_all, save_all, save_png
from workbench.report.page.documents import Document, render_html, render_markdown, render_pdf
from workbench.report.page.formatting import count
from workbench.report.page.markdown import Picture, bullets, callout, literal, paragraph, section
from workbench.report.page.reading import callouts
from workbench.study.assessor import Assessment
from workbench.study.definition import Study, holds_data
from workbench.study.store import own_directory, write_atomically
from workbench.study.tables import table_bytes, workbook_bytes

_FORMAT = Choice(("html", "pdf", "xlsx", "parquet"))
# figures of these kinds stand in chapters of their own
_ELSEWHERE = ("convergence", "cost")
_VARYING = ("cost",)  # kinds whose picture differs from machine to machine
_MOST_PICTURES = 8
_EXPLORE = "Explore answers"


def build_report(
    stored: Assessment, formats: Sequence[str] = ("html", "pdf"), out: Path | None = None
) -> dict[str, Path]:
    """Write the report of a stored and assessed study; nothing is simulated or assessed.

    Arguments: `stored`, the study in the form that was run; `formats`, any of html, pdf, and the
    tables as sheets of one workbook (xlsx) or as files (parquet); `out`, where to write (default:
    ``report`` in the store). Returns the path of each format, of the ``figures`` with their
    numbers, and beside html of the ``explorer`` of a study with histories or curves.
    Equal stores give equal bytes, but for workbooks.
    Raises `InputError` for an unknown format, a study without results, a figure of unknown kind
    or a directory that cannot be written.
    """
    for name in formats:
        _FORMAT.check("--format", name)
        check_library(name, "--format")
    study = stored.study
    target = own_directory(stored.directory, "report") if out is None else Path(out)
    written = {"figures": own_directory(target, "figures")}
    plates = draw_all(study, stored)
    pictures = {plate.figure.key: plate.picture() for plate in plates}
    kinds = {plate.figure.key: plate.figure.kind for plate in plates}
    content = document(study, stored, [(kinds[key], pictures[key]) for key in kinds])
    page = explorer(study, stored) if "html" in formats else None
    try:
        save_all(plates, written["figures"], pictures)
        if page is not None:
            content = replace(content, beside=((FILE, _EXPLORE),))
            written["explorer"] = target / FILE
            write_atomically(written["explorer"], page.encode())
        if "html" in formats:
            written["html"] = target / "report.html"
            write_atomically(written["html"], render_html(content).encode())
        if "pdf" in formats:
            written["pdf"] = target / "report.pdf"
            write_atomically(written["pdf"], render_pdf(replace(content, on_paper=True)))
        if "xlsx" in formats:
            written["xlsx"] = target / "tables.xlsx"
            write_atomically(written["xlsx"], workbook_bytes(stored.tables))
        if "parquet" in formats:
            written["parquet"] = own_directory(target, "tables")
            for name, table in stored.tables.items():
                target_of = written["parquet"] / f"{name}.parquet"
                write_atomically(target_of, table_bytes(table, "parquet"))
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError("--out", str(target), f"cannot be written: {reason}") from error
    return written


def document(study: Study, stored: Assessment, drawn: Sequence[tuple[str, Picture]]) -> Document:
    """The page of a study, from stored results and drawn figures with their kinds."""
    apart = {kind: [picture for of, picture in drawn if of == kind] for kind in _ELSEWHERE}
    first = answer.decisive(study, {p.key for _, p in drawn if p.svg})
    pictures = [
        section(f"figure-{p.key}", p.title, p, level=2)
        for of, p in drawn
        if of not in apart and p.key != first
    ]
    decisive = [p for _, p in drawn if p.key == first]
    chapters = [stud_study.in_short, *(point.load() for point in offered("chapters"))]
    more = literal([chapter(study, stored) for chapter in chapters])
    parts = [
        answer.answer(study, stored, decisive, more),
        choice.error_model(stored),
        choice.ranking(stored),
        results.validation(study, stored),
        verdicts.verdicts(stored),
        limits.collapses(stored),
        limits.missing(study, stored),
        limits.domain(study, stored),
        limits.notes(study),
        section("results", "Results", *pictures),
        budgets.budget_tables(stored),
        stud_study.design(study, stored),
        results.numbers(study, stored),
        results.convergence(study, stored, apart["convergence"]),
        results.cost(study, stored, apart["cost"]),
        configuration.configuration(study, stored),
        configuration.checks(study, stored),
    ]
    data = sum(map(holds_data, study.models.values()))
    numbers = f", {count(data, 'data set')}" if data else ""
    models = count(len(study.models) - data, "model")
    facts = [f"{count(len(study.cases), 'case')}, {models}{numbers}", f"study: {study.name}"]
    if study.whole is not None:
        lost = {
            "model": len(study.whole.models) - len(study.models),
            "case": len(study.whole.cases) - len(study.cases),
        }
        gone = " and ".join(count(number, what) for what, number in lost.items() if number)
        facts.insert(0, f"Quick form: without {gone or 'nothing'} of {study.whole.name}")
    held = {picture.key: picture for _, picture in drawn}
    whole = Document(study.title, "Validation report", tuple(facts), literal(parts), held)
    return whole.marked(results.MARK) if stored.synthetic else whole


def summary(stored: Assessment, target: Path) -> Path:
    """Write ``README.md`` and ``figures/<study>-<key>.png`` under `target`; return the page.

    Figures with the option ``summary = True`` appear (without any: the first eight that do not
    depend on the machine). Equal results give equal bytes: no times, dates or paths.
    Raises `InputError` for a study without results.
    """
    study = stored.study
    own_directory(target, "figures")
    limited = [
        limits.collapses(stored),
        limits.missing(study, stored),
        limits.domain(study, stored),
    ]
    alarms = [callout(tone, text) for tone, text in callouts(literal(limited))]
    short = paragraph(study.question), answer.in_brief(study, stored), *alarms
    parts, pictures = [section("short", "", *short)], {}
    drawn = [plate for plate in draw_all(study, stored) if plate.drawing.canvas is not None]
    marked = [plate for plate in drawn if plate.figure.options.get("summary")]
    steady = [plate for plate in drawn if plate.figure.kind not in _VARYING]
    for plate in marked or steady[:_MOST_PICTURES]:
        name = f"figures/{study.name}-{plate.figure.key}.png"
        assert plate.drawing.canvas is not None
        save_png(plate.drawing.canvas, target / name)
        picture = replace(plate.picture(), image=name, files=())
        pictures[picture.key] = picture
        parts.append(section(picture.key, picture.title, picture))
    if study.notes:
        parts.append(section("notes", "How to read this", bullets(study.notes)))
    facts = (
        f"Made by `workbench report {study.name}` from {count(len(stored.cells), 'cell')}; the "
        "full report adds tables, costs, configuration, provenance and sources.",
        *(f"{_made_with(record)}." for record in stored.provenance),
    )
    page = target / "README.md"
    content = Document(study.title, "", facts, literal(parts), pictures)
    content = content.marked(results.MARK) if stored.synthetic else content
    write_atomically(page, render_markdown(content).encode())
    return page


def _made_with(record: Mapping[str, str]) -> str:
    """Versions of one provenance record, without the machine."""
    names = ("workbench", "commit", "requirements_lock", "python", "numpy", "numba")
    versions = (f"{name.replace('_', '.')} {record[name]}" for name in names if name in record)
    return f"Cells answered with {', '.join(versions)}"
