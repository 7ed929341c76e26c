"""The verbs on studies: run, status, report, validate."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.base.errors import InputError
from workbench.base.offered import companion
from workbench.cli.output import Answer, InterruptedByUserError, Json, option, verb, writable
from workbench.report.page.markdown import Block, bullets, definitions, paragraph

if TYPE_CHECKING:
    from workbench.study import Assessment, CellStatus, RunSummary, Study

# columns of the table of verdicts
_SHOWN = ("number", "gate", "verdict", "value", "uncertainty", "case", "bound", "reasons")
StudyName = Annotated[
    str, typer.Argument(metavar="STUDY", help="Name of a study in ./studies, or a study file.")
]
Quick = Annotated[bool, option("The quick form: fewer cases and models.", flag="--quick")]
StoreRoot = Annotated[str, option("Directory that holds the result stores.", ..., "DIR", "--store")]


@verb
def run(
    study: StudyName,
    quick: Quick = False,
    jobs: int | None = option(
        "Worker processes; 0: none, for a debugger.  [default: one per core]", None
    ),
    scheduler: str | None = option("Run on this Dask cluster.", None, "ADDRESS"),
    fresh: bool = option("Answer stored cells again.", False, flag="--fresh"),
    only: str | None = option("Cells whose case, label or case/label matches.", None, "PATTERN"),
    timeout: float | None = option("Time that one cell may take.", None, "SECONDS"),
    store: StoreRoot = "reports",
    as_json: Json = False,
) -> Answer:
    """Answer the cells that are not stored yet.

    Then the gates are judged. Interrupting loses at most the cells in flight; run again to go
    on. Exit status 1 if a cell that should have an answer has none (a refusal, out-of-domain, is
    an answer); a gate that fails makes the status of `workbench validate`.
    """
    from workbench.report.figures import check_kind
    from workbench.study import CellProgress, assess, load_study, run_study
    from workbench.study.runner import Progress, progress_for

    loaded = load_study(study)
    for figure in loaded.study.figures:  # before the work, not after it
        check_kind(figure.kind)
    progress = Progress() if as_json else progress_for(sys.stderr, os.environ)
    try:
        summary = run_study(
            loaded.study,
            Path(store),
            jobs=jobs,
            quick=quick,
            fresh=fresh,
            only=only,
            timeout=timeout,
            progress=progress,
            scheduler=scheduler,
            file=loaded.file,
        )
    except KeyboardInterrupt:
        directory, entries = _surveyed(_chosen(study, quick), store)
        stored = sum(entry.state is not CellProgress.TO_DO for entry in entries)
        many = f"interrupted: {stored} of {len(entries)} cells are stored in {directory}"
        raise InterruptedByUserError(f"{many}; run again to go on") from None
    result = assess(summary.study, Path(store))
    content = {
        "study": summary.study.name,
        "store": str(summary.directory),
        "answered": summary.answered,
        "stored": summary.stored,
        "outcomes": summary.outcomes,
        "gates": gate_objects(result),
    }
    again = f"{study} --quick" if quick else study
    return Answer(content, _ran(summary, result, again), int(bool(summary.failed)))


def _ran(summary: RunSummary, result: Assessment, again: str) -> Iterator[Block]:
    from workbench.responses import Outcome
    from workbench.study.store import NOT_RUN

    yield _answer(summary.study, result)
    for row in result.records("cells"):
        if row["outcome"] != NOT_RUN and Outcome(row["outcome"]).is_failure:
            yield paragraph(f"{row['case']}/{row['label']}: {row['outcome']}: {row['message']}")
    counts = ", ".join(f"{n} {outcome}" for outcome, n in sorted(summary.outcomes.items()))
    yield paragraph(f"Cells: {counts}.")
    for (label, kind), names in summary.study.unsupported().items():
        yield paragraph(f"Not asked: {label} does not answer {kind} ({len(names)} of the cases).")
    text = f"The results are in {summary.directory}; `workbench report {again}` shows them."
    yield paragraph(text)


@verb
def status(study: StudyName, quick: Quick = False, store: StoreRoot = "reports") -> Answer:
    """Show what is done and what would run again.

    Every cell to do comes with the reason why it would run.
    """
    from collections import Counter

    from workbench.report.page.formatting import several
    from workbench.study import CellProgress

    chosen = _chosen(study, quick)
    directory, entries = _surveyed(chosen, store)
    counts = Counter(entry.state for entry in entries)
    content = {
        "study": chosen.name,
        "store": str(directory),
        "counts": {state.value: counts[state] for state in CellProgress},
        "cells": [
            {
                "case": entry.cell.case,
                "label": entry.cell.label,
                "state": entry.state.value,
                "outcome": entry.outcome or None,
                "reason": entry.reason or None,
                "key": entry.cell.key,
            }
            for entry in entries
        ],
    }
    waiting: dict[tuple[str, str], list[str]] = {}
    for entry in entries:
        if entry.state is not CellProgress.DONE:
            failed = entry.state is CellProgress.FAILED
            state = (entry.outcome, "") if failed else ("to do", f", {entry.reason}")
            waiting.setdefault(state, []).append(entry.cell.name)
    items = tuple(f"{a} ({len(names)}){b}: {several(names)}" for (a, b), names in waiting.items())
    line = f"{chosen.name}: " + ", ".join(f"{counts[state]} {state}" for state in CellProgress)
    return Answer(content, (paragraph(line), bullets(items)))


@verb
def report(
    study: StudyName,
    quick: Quick = False,
    formats: str = option("What to write.", "html,pdf", "html,pdf,xlsx,parquet", "--format"),
    out: str | None = option("Where to write.  [default: the store]", None, "DIR"),
    summary: str | None = option(
        "Also write README.md and figures there, to keep in git.", None, "DIR"
    ),
    crate: str | None = option(
        "Also write an RO-Crate: report, tables, cells, what made them.", None, "FILE.zip"
    ),
    store: StoreRoot = "reports",
) -> Answer:
    """Build the report of what is stored.

    Nothing is simulated: cells that have not been run are shown as missing.
    """
    wanted = tuple(part.strip() for part in formats.split(","))
    if not set(wanted) <= {"html", "pdf", "xlsx", "parquet"}:
        raise InputError("--format", formats, "must be among html, pdf, xlsx, parquet")
    archive = writable("--crate", crate, "zip")
    from workbench.report.build import build_report
    from workbench.report.build import summary as write_summary
    from workbench.report.chapters.answer import in_brief
    from workbench.report.explorer import MOST_CELLS
    from workbench.study import assess

    chosen = _chosen(study, quick)
    result = assess(chosen, Path(store))
    files = build_report(result, formats=wanted, out=None if out is None else Path(out))
    if archive is not None:
        form = f"{study} --quick" if quick else study
        commands = f"workbench run {form}", f"workbench report {form} --crate {archive.name}"
        companion("exports", "crate")(result, files["figures"].parent, archive, commands)
        files["crate"] = archive
    if summary is not None:
        files["summary"] = write_summary(result, Path(summary))
    content: dict[str, Any] = {
        "study": chosen.name,
        "files": {name: str(path) for name, path in files.items()},
        "gates": gate_objects(result),
    }
    shown = [in_brief(chosen, result), definitions(content["files"].items())]
    if "html" in files and "explorer" not in files:
        why = "no answer of this study is a history or a curve"
        many = f"a browser does not hold {len(result.cells)} answers"
        few = len(result.cells) <= MOST_CELLS
        shown.append(paragraph(f"No explorer: {why if few else many}."))
    return Answer(content, tuple(shown))


@verb
def validate(study: StudyName, quick: Quick = False, store: StoreRoot = "reports") -> Answer:
    """Judge the gates; exit status 1 if one fails.

    Only what is stored counts; a gate that cannot be judged is inconclusive.
    """
    from workbench.study import assess

    chosen = _chosen(study, quick)
    result = assess(chosen, Path(store))
    content = {"study": chosen.name, "failed": result.failed, "gates": gate_objects(result)}
    cases = result.tables["gates"].query("verdict != 'pass'").itertuples()
    reasons = tuple(f"{each.verdict}: {each.gate}, case {each.case}: {each.note}" for each in cases)
    return Answer(content, (_answer(chosen, result), bullets(reasons)), int(result.failed))


def gate_objects(result: Assessment) -> list[dict[str, Any]]:
    """The verdicts of the gates, as the table of verdicts has them."""
    return [
        {**{name: row[name] for name in _SHOWN}, "counts": verdict.counts}
        for row, verdict in zip(result.records("verdicts"), result.verdicts, strict=True)
    ]


def _answer(study: Study, result: Assessment) -> Block:
    """The matrix and the verdicts as the report has them."""
    from workbench.report.chapters.answer import in_brief

    return in_brief(study, result)


def _chosen(name: str, quick: bool) -> Study:
    from workbench.study import load_study

    study = load_study(name).study
    return study.quickened() if quick else study


def _surveyed(study: Study, store: str) -> tuple[Path, list[CellStatus]]:
    """The store of a study and where each of its cells stands."""
    from workbench.study import Store, cells_of, survey

    directory = Path(store) / study.name
    return directory, survey(study, cells_of(study), Store(directory))
