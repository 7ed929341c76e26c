"""`workbench bench`: the cases of the impact bench, answers to them, submissions, the ranking."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import typer

from workbench.cli.output import Answer, Jobs, Json, Names, option, processes, verb, writable
from workbench.report.page.markdown import Table, callout, paragraph

app = typer.Typer(
    help="Target cases of impacts, answers of anyone, ranks.",
    rich_markup_mode=None,
    no_args_is_help=False,
)
_OWN = "workbench.csv"  # answers of the models of the workbench, in the folder of the cases


@app.command("list")
@verb
def list_cases() -> Answer:
    """The cases: what is asked, who computed the reference, whether it is sealed."""
    from workbench.extras.bench.cases import bench_directory, load_bench

    cases = load_bench()
    heads = {"case": "name", "group": "group", "reference": "model", "hit": "hit", "sealed": "seal"}
    rows = [
        {**vars(case), "hit": case.scenario.name, "seal": "yes" if case.seal else "no"}
        for case in cases
    ]
    sealed = sum(bool(case.seal) for case in cases)
    text = f"{len(cases)} cases, the references of {sealed} sealed; folder: {bench_directory()}"
    listed = [{head: row[of] for head, of in heads.items()} for row in rows]
    content = {"cases": listed, "folder": str(bench_directory())}
    return Answer(content, (Table.of("cases", "", heads, rows), paragraph(text)))


@app.command("run")
@verb
def run(
    model: Names = option("One of the bench, or any registered one, once for each.", None),
    every: bool = option("Hinges and fibers of other authors too.", False, flag="--all"),
    out: str | None = option(
        "Answers, as anyone submits them.  [default: bench-answers.csv in the store]",
        None,
        "FILE.csv",
    ),
    jobs: Jobs = None,
    store: str = option("Directory that holds the result stores.", "reports", "DIR"),
    as_json: Json = False,
) -> Answer:
    """Answer all cases by models: by default by all reduced ones and the rules of hand.

    What is stored is not run again. Exit status 1 if an answer failed (a refusal is none).
    """
    from workbench.extras.bench.answers import answer_bytes
    from workbench.extras.bench.cases import load_bench
    from workbench.extras.bench.run import entrants, run_bench
    from workbench.report.page.formatting import count
    from workbench.study.runner import Progress, progress_for
    from workbench.study.store import write_atomically

    Path(store).mkdir(parents=True, exist_ok=True)
    target = writable("--out", out or str(Path(store) / "bench-answers.csv"), "csv")
    models, workers = entrants(model or (), every), processes(jobs)
    progress = Progress() if as_json else progress_for(sys.stderr, os.environ)
    answers = run_bench(load_bench(), models, Path(store), workers, progress)
    write_atomically(target, answer_bytes(answers))
    ends = answers["outcome"].value_counts().to_dict()
    text = ", ".join(f"{number} {end}" for end, number in sorted(ends.items()))
    blocks = (
        paragraph(f"{count(len(models), 'model')}, {len(answers)} answers: {text}."),
        paragraph(f"`workbench bench report --answers {target}` compares them."),
    )
    content = {"models": list(models), "outcomes": ends, "answers": str(target)}
    return Answer(content, blocks, int("failed" in ends), {"table of answers": target})


@app.command("submit")
@verb
def submit(
    answers: str = typer.Argument(metavar="ANSWERS.csv", help="Answers to the cases."),
    name: str = option("Who answers: program, elements, mesh."),
    contact: str = option("Who can be asked."),
) -> Answer:
    """Keep answers of another program beside those of the workbench, in your own data.

    They are checked and never run. Columns: case, outcome (ok, collapse, refused, failed),
    peak_displacement_mm (or _m, _in, ...); optional half_width_mm, wall_time_s, warned (yes, no),
    and model where a file holds several.
    """
    from workbench.extras.bench.answers import submit as keep
    from workbench.extras.bench.cases import load_bench
    from workbench.extras.bench.run import entrants
    from workbench.models.base import model_names

    cases = load_bench()
    names = [case.name for case in cases]
    ours = [*entrants(every=True), *model_names()]
    folder, rows = keep(Path(answers), name, contact, names, ours)
    sealed = int(rows["case"].isin([each.name for each in cases if each.reference is None]).sum())
    counts = rows["model"].value_counts(sort=False)
    missing = {model: len(names) - number for model, number in counts.items()}
    blocks = [
        paragraph(f"{len(rows)} answers are in {folder}; `workbench bench report` shows them.")
    ]
    for model, number in missing.items():
        text = f"{model}: {number} cases without an answer count as failed"
        blocks += [callout("doubt", text)] * bool(number)
    if sealed:
        text = f"{sealed} answers are to sealed cases, which only the organiser can judge"
        blocks.append(callout("note", text))
    return Answer({"folder": str(folder), "answers": len(rows), "missing": missing}, blocks)


@app.command("report")
@verb
def report(
    answers: Names = option("Answers that were not submitted, once for each file.", None),
    key: str | None = option("Key of the organiser: the sealed cases too.", None, "FILE"),
    own: bool = option("Leave out the models of the workbench.", True, flag="--own/--no-own"),
    out: str = option("Directory of page and tables.", "reports/bench-report", "DIR"),
) -> Answer:
    """Rank models and submissions by their errors: page and CSV.

    With intervals of the ranks, silent misses, refusals, verdicts on collapse and cost. Without the
    key of the organiser only cases count whose reference stands in the open.
    """
    import pandas as pd

    from workbench.base.errors import InputError
    from workbench.base.tables import plain_rows
    from workbench.extras.bench.answers import read_answers, submissions
    from workbench.extras.bench.cases import bench_directory, load_bench, opened
    from workbench.extras.bench.report import write_bench

    cases = load_bench()
    names = [case.name for case in cases]
    known = opened(cases, None if key is None else Path(key))
    given = [read_answers(bench_directory() / _OWN, names)] if own else []
    given += [read_answers(Path(file), names, Path(file).stem) for file in answers or ()]
    given += submissions(names)
    if not given:
        raise InputError("bench", None, "has no answers to compare", "give --answers FILE.csv")
    rows = pd.concat(given, ignore_index=True)
    for model in rows.loc[rows.duplicated(["case", "model"]), "model"]:
        advice = "rename one of the files, or leave out --answers of what was submitted"
        raise InputError("bench", model, "answers twice", advice)
    ranking, scores, files = write_bench(cases, known, rows, Path(out))
    named = {what: str(file) for what, file in files.items()}
    return Answer({"scores": plain_rows(scores), "files": named}, (ranking,), 0, files)
