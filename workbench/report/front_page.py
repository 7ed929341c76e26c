"""The page of a study that is kept in git: verdicts, key pictures and the versions behind them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from workbench.report.bibliography import BIBLIOGRAPHY
from workbench.report.chapters import limits
from workbench.report.chapters.verdicts import question_of, verdict_rows
from workbench.report.content import Callout, runs_of, walk
from workbench.report.figures.drawing import save_png
from workbench.report.formatting import count, interval, metric_value
from workbench.report.gallery import Plate, draw_all
from workbench.report.stored import Stored
from workbench.study.definition import Study
from workbench.study.files import write_atomically

_MARKS = {"pass": "✅ pass", "fail": "❌ fail", "inconclusive": "❔ inconclusive"}
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
    lines = [f"# {_escaped(study.title)}", "", _escaped(study.question), ""]
    lines += _verdicts(stored)
    shear = limits.shear_demand(study, stored)
    for section in (limits.missing(study, stored), limits.domain(stored, shear)):
        for block in walk((section,)):
            if isinstance(block, Callout):
                lines += [f"> {_escaped(block.text)}", ""]
    for plate in _chosen(draw_all(study, stored)):
        name = f"figures/{study.name}-{plate.figure.key}.png"
        assert plate.drawing.canvas is not None
        save_png(plate.drawing.canvas, target / name)
        lines += [f"## {_escaped(plate.figure.title)}", ""]
        lines += [f"![{_escaped(plate.drawing.alt)}]({name})", ""]
        lines += [_escaped(plate.figure.caption), ""]
        lines += [f"- {_escaped(statement)}" for statement in plate.drawing.statements]
        if plate.drawing.statements:
            lines.append("")
    if study.notes:
        lines += ["## How to read this", ""]
        lines += [f"- {_escaped(note)}" for note in study.notes]
        lines.append("")
    lines += [
        "---",
        "",
        f"Made by `workbench report {study.name}` from {count(len(stored.cells), 'cell')}; the "
        "full report adds tables, costs, configuration, provenance and sources.",
        *(f"{_made_with(record)}." for record in stored.provenance),
    ]
    page = target / "README.md"
    write_atomically(page, ("\n".join(lines) + "\n").encode())
    return page


def _verdicts(stored: Stored) -> list[str]:
    rows = verdict_rows(stored)
    if not rows:
        return ["The study sets no acceptance gates.", ""]
    lines = [
        "| verdict | what is judged | critical value ± uncertainty | bound | why this bound |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        value = interval(row["metric"], row["quantity"], row["value"], row["uncertainty"])
        if row["value"] is None:
            value = "; ".join(row["unjudged"]) or "not judged"
        elif row["cases"] > 1:
            value += f" ({row['case']}; {row['passed']} of {row['cases']} cases pass)"
        bound = "±" + metric_value(row["metric"], row["quantity"], row["bound"], bound=True)
        source = BIBLIOGRAPHY.get(row["source"])
        cited = f"{source.authors} {source.year}" if source else row["source"]
        why = f"{row['rationale']} ({cited})" if cited else row["rationale"]
        cells = (_MARKS[row["verdict"]], question_of(row), value, bound, why)
        lines.append("| " + " | ".join(_escaped(cell) for cell in cells) + " |")
    return [*lines, ""]


def _chosen(plates: tuple[Plate, ...]) -> list[Plate]:
    drawn = [plate for plate in plates if plate.drawing.canvas is not None]
    marked = [plate for plate in drawn if plate.figure.options.get("summary")]
    steady = [plate for plate in drawn if plate.figure.kind not in _VARYING]
    return marked or steady[:_MOST_PICTURES]


def _escaped(text: str) -> str:
    """Text as Markdown; citations become author and year, table bars and tags are escaped."""
    parts = []
    for kind, content in runs_of(text):
        if kind == "code":
            parts.append(f"`{content}`")
        elif kind == "cite":
            work = BIBLIOGRAPHY.get(content)
            parts.append(f"({work.authors} {work.year})" if work else f"({content})")
        else:
            parts.append(content.replace("<", "&lt;").replace("|", "\\|").replace("\n", " "))
    return "".join(parts)


def _made_with(record: Mapping[str, str]) -> str:
    """Versions of one provenance record, without the machine."""
    names = ("workbench", "commit", "requirements_lock", "python", "numpy", "numba")
    return "Cells answered with " + ", ".join(
        f"{name.replace('_', '.')} {record[name]}" for name in names if name in record
    )
