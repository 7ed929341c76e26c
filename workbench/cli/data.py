"""`workbench data`: the catalogue, and one's own tables."""

import dataclasses
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from workbench.cli.output import Answer, group_of, option, verb, writable
from workbench.cli.studies import StoreRoot
from workbench.report.page.markdown import Block, Table, definitions, paragraph, section

app = group_of("data")


@app.command("list")
@verb
def list_datasets() -> Answer:
    """List the datasets."""
    from workbench.base.catalogue import datasets

    entries = [dataclasses.asdict(entry) for entry in datasets()]
    columns = {"dataset": "name", **{key: key for key in ("role", "licence", "title")}}
    return Answer({"datasets": entries}, [Table.of("datasets", "", columns, entries)])


@app.command("show")
@verb
def show(name: str = typer.Argument(metavar="NAME", help="Name of the dataset.")) -> Answer:
    """Show where a dataset is from, and its rows."""
    from workbench.base.catalogue import dataset, load
    from workbench.studs.fit_protocol import plain

    entry = dataclasses.asdict(dataset(name))
    rows = plain(load(name))
    return Answer({**entry, "rows": rows}, _shown(entry, rows))


def _shown(entry: dict[str, Any], rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield definitions(tuple((key, value) for key, value in entry.items() if isinstance(value, str)))
    yield section("columns", "Columns:", definitions(tuple(entry["columns"].items())))
    yield Table.of("rows", "", {name: name for name in (rows or [entry["columns"]])[0]}, rows)


@app.command("measure")
@verb
def measure(
    name: str = typer.Argument(metavar="TABLE", help="One of columns, directions, pulses, frames."),
    store: StoreRoot = "reports",
    jobs: int | None = option("Worker processes.  [default: one per core]", None),
    out: str | None = option(
        "Where to write.  [default: the tables of the program]", None, "FILE.csv"
    ),
) -> Answer:
    """Measure the anchor of the error model: run the studies that draw, and write its table.

    Answers are stored as by `workbench run`; interrupted, it goes on where it was. The table tells
    the error of any answer, of models of your own too.
    """
    import pandas as pd

    from workbench.base.catalogue import dataset
    from workbench.base.fields import Choice
    from workbench.study import load_study, run_study
    from workbench.study.error_model.error_table import TABLES, TRUTH
    from workbench.study.error_rows import error_rows
    from workbench.study.runner import progress_for
    from workbench.study.store import write_atomically
    from workbench.study.tables import csv_bytes

    chosen = TABLES[Choice(tuple(TABLES)).check("table", name)]
    path = dataset(name).path if out is None else writable("--out", out, "csv")
    progress, parts = progress_for(sys.stderr, os.environ), []
    for study in chosen.studies:
        loaded = load_study(study)
        run_study(loaded.study, Path(store), jobs=jobs, progress=progress, file=loaded.file)
        parts.append(pd.DataFrame(list(error_rows(loaded.study, chosen, Path(store)))))
    rows = pd.concat(parts, ignore_index=True)
    write_atomically(path, csv_bytes(rows))
    judged = int(rows[TRUTH].notna().sum())
    text = f"{len(rows)} rows, {judged} of them with a truth, in {path}."
    return Answer({"rows": len(rows), "judged": judged, "file": str(path)}, [paragraph(text)])
