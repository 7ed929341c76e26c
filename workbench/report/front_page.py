"""The page of a study that is kept in git: verdicts, key pictures and the versions behind them."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from workbench.content.formatting import count
from workbench.content.markdown import render_markdown
from workbench.content.tree import Block, Bullets, Callout, Document, Paragraph, Section, walk
from workbench.report.chapters import limits, verdicts
from workbench.report.gallery import Plate, draw_all, save_png
from workbench.report.stored import Stored
from workbench.study.definition import Study
from workbench.study.files import write_atomically

_VARYING = ("cost",)  # kinds whose picture differs from machine to machine
_MOST_PICTURES = 8


def summary(directory: Path, study: Study, target: Path) -> Path:
    """Write ``README.md`` and ``figures/<study>-<key>.png`` under `target`; return the page.

    Arguments: `directory`, the store of the study; `study`, in the form that was run. Figures
    with the option ``summary = True`` appear (without any: the first eight that do not depend on
    the machine). Equal results give equal bytes: no times, dates or paths.
    Raises `InputError` for a study without results.
    """
    stored = Stored(Path(directory), study)
    target = Path(target)
    (target / "figures").mkdir(parents=True, exist_ok=True)
    sections = [Section("short", "", tuple(_short(study, stored)))]
    for plate in _chosen(draw_all(study, stored)):
        name = f"figures/{study.name}-{plate.figure.key}.png"
        assert plate.drawing.canvas is not None
        save_png(plate.drawing.canvas, target / name)
        picture = replace(plate.picture(), image=name)
        sections.append(Section(plate.figure.key, plate.figure.title, (picture,)))
    if study.notes:
        sections.append(Section("notes", "How to read this", (Bullets(tuple(study.notes)),)))
    facts = (
        f"Made by `workbench report {study.name}` from {count(len(stored.cells), 'cell')}; the "
        "full report adds tables, costs, configuration, provenance and sources.",
        *(f"{_made_with(record)}." for record in stored.provenance),
    )
    page = target / "README.md"
    content = Document(study.title, "", facts, tuple(sections))
    write_atomically(page, render_markdown(content).encode())
    return page


def _short(study: Study, stored: Stored) -> Iterator[Block]:
    """The question, the table of verdicts, and what must not be overlooked."""
    yield Paragraph(study.question)
    rows = stored.rows["verdicts"]
    yield verdicts.headline(rows)
    if rows:
        yield replace(verdicts.summary_table(rows), caption="")
    shear = limits.shear_demand(study, stored)
    told = walk((limits.missing(study, stored), limits.domain(stored, shear)))
    yield from (block for block in told if isinstance(block, Callout))


def _chosen(plates: tuple[Plate, ...]) -> list[Plate]:
    drawn = [plate for plate in plates if plate.drawing.canvas is not None]
    marked = [plate for plate in drawn if plate.figure.options.get("summary")]
    steady = [plate for plate in drawn if plate.figure.kind not in _VARYING]
    return marked or steady[:_MOST_PICTURES]


def _made_with(record: Mapping[str, str]) -> str:
    """Versions of one provenance record, without the machine."""
    names = ("workbench", "commit", "requirements_lock", "python", "numpy", "numba")
    return "Cells answered with " + ", ".join(
        f"{name.replace('_', '.')} {record[name]}" for name in names if name in record
    )
