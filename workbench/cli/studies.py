"""The verbs on studies: run, status, report, validate."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.cli.output import InterruptedByUserError, Json, print_json, print_table

if TYPE_CHECKING:
    from workbench.study import Assessment, LoadedStudy, Study
    from workbench.study.assess import GateResult

StudyName = Annotated[
    str, typer.Argument(metavar="STUDY", help="Name of a study in ./studies, or a study file.")
]
Quick = Annotated[bool, typer.Option("--quick", help="The quick form: fewer cases and models.")]
StoreRoot = Annotated[
    str, typer.Option("--store", metavar="DIR", help="Directory that holds the result stores.")
]


def run(
    study: StudyName,
    quick: Quick = False,
    jobs: Annotated[
        int | None,
        typer.Option(help="Worker processes; 0: none, for a debugger.  [default: one per core]"),
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Run on this Dask cluster.")
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Answer stored cells again.")] = False,
    only: Annotated[
        str | None,
        typer.Option(metavar="PATTERN", help="Cells whose case, label or case/label matches."),
    ] = None,
    timeout: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Time that one cell may take.")
    ] = None,
    store: StoreRoot = "reports",
    as_json: Json = False,
) -> int:
    """Answer the cells that are not stored yet.

    Then the gates are judged. Interrupting loses at most the cells in flight; run again to go
    on. Exit status 1 if a cell that should have an answer has none (a refusal, out-of-domain, is
    an answer); a gate that fails makes the status of `workbench validate`.
    """
    from workbench.report.kinds import check_kind
    from workbench.study import assess, load_study, run_study
    from workbench.study.progress import Silent, progress_for

    loaded = load_study(study)
    for figure in loaded.study.figures:  # before the work, not after it
        check_kind(figure.kind)
    progress = Silent() if as_json else progress_for(sys.stderr, os.environ)
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
        raise InterruptedByUserError(_interrupted(loaded, quick, store)) from None
    result = assess(summary.study, Path(store))
    if as_json:
        print_json(
            {
                "study": summary.study.name,
                "store": str(summary.directory),
                "answered": summary.answered,
                "stored": summary.stored,
                "outcomes": summary.outcomes,
                "gates": gate_objects(result),
            }
        )
    else:
        _print_gates(result)
        for row in result.cells:
            if row["outcome"] not in ("ok", "out-of-domain", "not run"):
                print(f"{row['case']}/{row['label']}: {row['outcome']}: {row['message']}")
        counts = ", ".join(f"{n} {outcome}" for outcome, n in sorted(summary.outcomes.items()))
        print(f"Cells: {counts}.")
        for (label, kind), names in summary.study.unasked().items():
            print(f"Not asked: {label} does not answer {kind} ({len(names)} of the cases).")
        again = f"{study} --quick" if quick else study
        print(f"The results are in {summary.directory}; `workbench report {again}` shows them.")
    return 1 if summary.failed else 0


def status(
    study: StudyName, quick: Quick = False, store: StoreRoot = "reports", as_json: Json = False
) -> None:
    """Show what is done and what would run again.

    Every cell to do comes with the reason why it would run.
    """
    from collections import Counter

    from workbench.study import State, Store, cells_of, survey

    chosen = _chosen(study, quick)
    directory = Path(store) / chosen.name
    entries = survey(chosen, cells_of(chosen), Store(directory))
    counts = Counter(entry.state for entry in entries)
    if as_json:
        print_json(
            {
                "study": chosen.name,
                "store": str(directory),
                "counts": {state.value: counts[state] for state in State},
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
        )
        return
    print(f"{chosen.name}: " + ", ".join(f"{counts[state]} {state}" for state in State))
    failed = Counter(entry.outcome for entry in entries if entry.state is State.FAILED)
    for outcome, count in sorted(failed.items()):
        names = [entry.cell.name for entry in entries if entry.outcome == outcome]
        print(f"  {outcome} ({count}): {_few(names)}")
    reasons: dict[str, list[str]] = {}
    for entry in entries:
        if entry.state is State.TO_DO:
            reasons.setdefault(entry.reason, []).append(entry.cell.name)
    for reason, names in reasons.items():
        print(f"  to do ({len(names)}), {reason}: {_few(names)}")


def report(
    study: StudyName,
    quick: Quick = False,
    formats: Annotated[
        str, typer.Option("--format", metavar="html,pdf", help="What to write.")
    ] = "html,pdf",
    out: Annotated[
        str | None, typer.Option(metavar="DIR", help="Where to write.  [default: the store]")
    ] = None,
    summary: Annotated[
        str | None,
        typer.Option(metavar="DIR", help="Also write README.md and figures there, to keep in git."),
    ] = None,
    store: StoreRoot = "reports",
    as_json: Json = False,
) -> None:
    """Build the report of what is stored.

    Nothing is simulated: cells that have not been run are shown as missing.
    """
    from workbench.errors import InputError

    wanted = tuple(part.strip() for part in formats.split(","))
    for part in wanted:
        if part not in ("html", "pdf"):
            raise InputError("--format", formats, "must be html, pdf or html,pdf")
    from workbench.report import build_report
    from workbench.report import summary as write_summary
    from workbench.study import assess

    chosen = _chosen(study, quick)
    result = assess(chosen, Path(store))
    target = None if out is None else Path(out)
    files = build_report(result.directory, chosen, formats=wanted, out=target)
    if summary is not None:
        files["summary"] = write_summary(result.directory, chosen, Path(summary))
    if as_json:
        print_json(
            {
                "study": chosen.name,
                "files": {name: str(path) for name, path in files.items()},
                "gates": gate_objects(result),
            }
        )
        return
    _print_gates(result)
    for name, path in files.items():
        print(f"{name}: {path}")


def validate(
    study: StudyName, quick: Quick = False, store: StoreRoot = "reports", as_json: Json = False
) -> int:
    """Judge the gates; exit status 1 if one fails.

    Only what is stored counts; a gate that cannot be judged is inconclusive.
    """
    from workbench.study import assess

    chosen = _chosen(study, quick)
    result = assess(chosen, Path(store))
    if as_json:
        print_json({"study": chosen.name, "failed": result.failed, "gates": gate_objects(result)})
    else:
        _print_gates(result)
        for row in result.gates:
            if row["verdict"] != "pass":
                print(f"{row['verdict']}: {row['gate']}, case {row['case'] or '-'}: {row['note']}")
    return 1 if result.failed else 0


def gate_objects(result: Assessment) -> list[dict[str, Any]]:
    """The gates of an assessment, with the row of every case."""
    return [
        {
            "gate": entry.gate,
            "verdict": entry.verdict.value,
            "value": entry.value,
            "uncertainty": entry.uncertainty,
            "case": entry.case,
            "bound": entry.bound,
            "counts": dict(entry.counts),
        }
        for entry in result.results
    ]


def _print_gates(result: Assessment) -> None:
    if not result.results:
        print("The study has no gates.")
        return
    rows = [
        (
            entry.verdict.value,
            entry.gate,
            _interval(entry),
            f"{100.0 * entry.bound:g} %" if _relative(entry) else f"{entry.bound:g}",
            entry.case or "-",
            "{pass} / {inconclusive} / {fail}".format(**entry.counts),
        )
        for entry in result.results
    ]
    header = ("verdict", "gate", "worst", "bound", "in case", "pass / inconclusive / fail")
    print_table(rows, header)


def _chosen(name: str, quick: bool) -> Study:
    from workbench.study import load_study

    study = load_study(name).study
    return study.quickened() if quick else study


def _interrupted(loaded: LoadedStudy, quick: bool, store: str) -> str:
    from workbench.study import State, Store, cells_of, survey

    study = loaded.study.quickened() if quick else loaded.study
    cells = cells_of(study)
    directory = Path(store) / study.name
    entries = survey(study, cells, Store(directory))
    stored = sum(entry.state is not State.TO_DO for entry in entries)
    return (
        f"interrupted: {stored} of {len(cells)} cells are stored in {directory}; run again to go on"
    )


def _few(names: list[str]) -> str:
    shown = ", ".join(names[:4])
    return shown + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def _relative(entry: GateResult) -> bool:
    return entry.metric != "difference"


def _interval(entry: GateResult) -> str:
    """The critical value of a gate with its uncertainty, in percent where it is relative."""
    from workbench.assessment import METRICS, Scope

    if entry.value is None:
        return "-"
    factor, unit = (100.0, " %") if _relative(entry) else (1.0, "")
    if METRICS[entry.metric].scope is Scope.RUN:
        return f"{factor * entry.value:.3g}{unit}"
    width = "?" if entry.uncertainty is None else f"{factor * entry.uncertainty:.2g}"
    return f"{factor * entry.value:+.3g} ± {width}{unit}"
