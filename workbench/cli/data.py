"""`workbench data`: the catalogue, and one's own tables."""

import dataclasses
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from workbench.cli.output import DECIMAL, SEP, SHEET, Answer, Names, option, verb, writable
from workbench.cli.studies import StoreRoot
from workbench.report.page.markdown import (
    Block,
    Table,
    bullets,
    callout,
    definitions,
    paragraph,
    section,
)

app = typer.Typer(
    help="Show, check and extend the data catalogue.", rich_markup_mode=None, no_args_is_help=False
)


@app.command("list")
@verb
def list_datasets() -> Answer:
    """List the datasets."""
    from workbench.study.error_model import datasets

    entries = [dataclasses.asdict(entry) for entry in datasets()]
    columns = {"dataset": "name", **{key: key for key in ("role", "licence", "title")}}
    return Answer({"datasets": entries}, [Table.of("datasets", "", columns, entries)])


@app.command("show")
@verb
def show(name: str = typer.Argument(metavar="NAME", help="Name of the dataset.")) -> Answer:
    """Show where a dataset is from, and its rows."""
    from workbench.studs.fit_protocol import plain
    from workbench.study.error_model import dataset, load

    entry = dataclasses.asdict(dataset(name))
    rows = plain(load(name))
    return Answer({**entry, "rows": rows}, _shown(entry, rows))


def _shown(entry: dict[str, Any], rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield definitions(tuple((key, value) for key, value in entry.items() if isinstance(value, str)))
    yield section("columns", "Columns:", definitions(tuple(entry["columns"].items())))
    yield Table.of("rows", "", {name: name for name in (rows or [entry["columns"]])[0]}, rows)


@app.command("add")
@verb
def add(
    table: str = typer.Argument(metavar="TABLE.csv|xlsx", help="Table of tests."),
    mapping: str | None = option(
        "What its columns are, and where it is from.", None, "MAPPING.toml"
    ),
    kind: str | None = option(
        "impact-tests, stud-tests or stud-points.  [default: told from the columns]", None, "KIND"
    ),
    into: str | None = option(
        "Your own data.  [default: $WORKBENCH_DATA, else ./lab_data]", None, "FOLDER"
    ),
    name: str | None = option("Its name.  [default: that of the file]", None, "NAME"),
    despite_doubts: bool = option(
        "Take it although it looks wrong.", False, flag="--despite-doubts"
    ),
    sheet: str | None = SHEET,
    sep: str | None = SEP,
    decimal: str | None = DECIMAL,
) -> Answer:
    """Add a table to your own data: impacts on steel members, push-outs of studs, their curves.

    Everything is checked before anything is written; numbers without source and licence are not
    taken. Templates: `workbench new impact-tests`, `workbench new mapping`.
    """
    from workbench.base.tables import Reading
    from workbench.extras.intake import add_table

    added = add_table(
        Path(table),
        mapping=None if mapping is None else Path(mapping),
        kind=kind,
        into=None if into is None else Path(into),
        name=name,
        despite_doubts=despite_doubts,
        how=Reading(sheet, sep, decimal),
    )
    entry = dataclasses.asdict(added.entry)
    content = {"dataset": entry, **{n: getattr(added, n) for n in ("already", "read", "rows")}}
    lists = {"notes": list(added.notes), "doubts": list(added.doubts)}
    return Answer({**content, **lists}, _added(added))


def _added(added: Any) -> Iterator[Block]:
    entry = added.entry
    if added.already:
        text = "The same rows are in the catalogue already"
        yield paragraph(f"{text}, as {entry.name}: {entry.path}")
        yield paragraph("Nothing was written.")
        return
    rows = "SYNTHETIC rows" if entry.role == "synthetic" else "rows"
    yield paragraph(f"{added.rows} {rows} of {entry.kind} are in {entry.path} as {entry.name}.")
    stated = ("title", "source", "licence", "year", "role")
    yield definitions(tuple((name, getattr(entry, name)) for name in stated))
    if added.notes:
        yield bullets(added.notes)
    for text in added.doubts:
        yield callout("doubt", f"taken despite: {text}")
    if added.read:
        yield paragraph(f"Next: {added.then}")
    else:
        yield callout("note", f"The catalogue reads this folder with WORKBENCH_DATA={entry.folder}")


@app.command("measure")
@verb
def measure(
    name: str = typer.Argument(metavar="TABLE", help="One of columns, rates, pulses, frames."),
    store: StoreRoot = "reports",
    jobs: int | None = option("Worker processes.  [default: one per core]", None),
    out: str | None = option(
        "Where to write.  [default: the tables of the program]", None, "FILE.csv"
    ),
) -> Answer:
    """Measure the anchor of the error model: run the study that draws, and write its table.

    Answers are stored as by `workbench run`; interrupted, it goes on where it was. The table tells
    the error of any answer, of models of your own too.
    """
    import pandas as pd

    from workbench.base.fields import Choice
    from workbench.study import load_study, run_study
    from workbench.study.error_model import dataset
    from workbench.study.error_model.error_table import TABLES, TRUTH
    from workbench.study.error_rows import error_rows
    from workbench.study.runner import progress_for
    from workbench.study.store import write_atomically
    from workbench.study.tables import csv_bytes

    chosen = TABLES[Choice(tuple(TABLES)).check("table", name)]
    path = dataset(name).path if out is None else writable("--out", out, "csv")
    loaded = load_study(chosen.study)
    progress = progress_for(sys.stderr, os.environ)
    run_study(loaded.study, Path(store), jobs=jobs, progress=progress, file=loaded.file)
    rows = pd.DataFrame(list(error_rows(loaded.study, chosen, Path(store))))
    write_atomically(path, csv_bytes(rows))
    judged = int(rows[TRUTH].notna().sum())
    text = f"{len(rows)} rows, {judged} of them with a truth, in {path}."
    return Answer({"rows": len(rows), "judged": judged, "file": str(path)}, [paragraph(text)])


@app.command("check")
@verb
def check(
    files: Names = typer.Argument(None, metavar="[FILE]...", help="Check these files alone."),
    sheet: str | None = SHEET,
    sep: str | None = SEP,
    decimal: str | None = DECIMAL,
) -> Answer:
    """Check the catalogue: files, columns and sources, and every row of the tables of tests.

    With files of your own, only those: tests on studs, points of load-slip curves, impact tests.
    """
    from workbench.base.tables import Reading
    from workbench.extras.intake import check_file, problems_of_own
    from workbench.studs import check_tables
    from workbench.study.error_model import check as problems_of
    from workbench.study.error_model import datasets

    if files:
        how = Reading(sheet, sep, decimal)
        results = {str(file): check_file(Path(file), how) for file in files}
        content: dict[str, Any] = {
            name: {file: lists[place] for file, lists in results.items()}
            for place, name in enumerate(("files", "suspicions", "notes"))
        }
        texts = []
        for file, (bad, doubts, notes) in results.items():
            more = f", {len(doubts)} suspicions" if doubts else ""
            texts += [*notes, *bad, *(f"suspicion: {text}" for text in doubts)]
            texts.append(f"{file}: {len(bad)} problems{more}.")
        failed = any(content["files"].values())
    else:
        problems = [*problems_of(), *check_tables(), *problems_of_own()]
        content = {"datasets": len(datasets()), "problems": problems}
        texts = [*problems, f"{len(datasets())} datasets, {len(problems)} problems."]
        failed = bool(problems)
    return Answer(content, [paragraph(text) for text in texts], int(failed))
