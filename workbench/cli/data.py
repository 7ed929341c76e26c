"""`workbench data` and `new`: the catalogue, one's own tables, and templates to fill in."""

import dataclasses
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from workbench.cli.output import Answer, Json, Names, option, verb
from workbench.cli.studies import StoreRoot, StudyName
from workbench.content.tree import (
    Block,
    Bullets,
    Callout,
    Column,
    Definitions,
    Paragraph,
    Section,
    Table,
)

app = typer.Typer(
    help="Show, check and extend the data catalogue.", rich_markup_mode=None, no_args_is_help=False
)
templates = typer.Typer(
    help="Print a template to fill in.", rich_markup_mode=None, no_args_is_help=False
)
TablesRoot = Annotated[
    str | None, option("Where to write.  [default: the tables of the program]", metavar="DIR")
]
Earlier = Annotated[
    bool, option("Count answers of earlier versions of models too.", flag="--earlier")
]


@app.command("list")
@verb
def list_datasets() -> Answer:
    """List the datasets."""
    from workbench.evidence import datasets

    entries = [dataclasses.asdict(entry) for entry in datasets()]
    listed = ("role", "licence", "title")
    columns = (Column("dataset", of="name"), *(Column(key, of=key) for key in listed))
    return Answer({"datasets": entries}, [Table.of("datasets", "", columns, entries)])


@app.command("show")
@verb
def show(name: str = typer.Argument(metavar="NAME", help="Name of the dataset.")) -> Answer:
    """Show where a dataset is from, and its rows."""
    from workbench.evidence import dataset, load
    from workbench.studs.fit_protocol import plain

    entry = dataclasses.asdict(dataset(name))
    rows = plain(load(name))
    return Answer({**entry, "rows": rows}, _shown(entry, rows))


def _shown(entry: dict[str, Any], rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Definitions(tuple((key, value) for key, value in entry.items() if isinstance(value, str)))
    yield Section("columns", "Columns:", (Definitions(tuple(entry["columns"].items())),))
    yield Table.of(
        "rows", "", (Column(name, of=name) for name in (rows or [entry["columns"]])[0]), rows
    )


@app.command("add")
@verb
def add(
    table: str = typer.Argument(metavar="TABLE.csv", help="Table of tests."),
    mapping: str | None = option(
        "What its columns are, and where it is from.", None, "MAPPING.toml"
    ),
    kind: str | None = option(
        "impact-tests or stud-tests.  [default: told from the columns]", None, "KIND"
    ),
    into: str | None = option(
        "Your own data.  [default: $WORKBENCH_DATA, else ./lab_data]", None, "FOLDER"
    ),
    name: str | None = option("Its name.  [default: that of the file]", None, "NAME"),
    despite_doubts: bool = option(
        "Take it although it looks wrong.", False, flag="--despite-doubts"
    ),
) -> Answer:
    """Add a table of tests to your own data: impacts on steel members, or push-outs of studs.

    Everything is checked before anything is written; numbers without source and licence are not
    taken. Templates: `workbench new impact-tests`, `workbench new mapping`.
    """
    from workbench.intake import add_table

    added = add_table(
        Path(table),
        mapping=None if mapping is None else Path(mapping),
        kind=kind,
        into=None if into is None else Path(into),
        name=name,
        despite_doubts=despite_doubts,
    )
    entry = dataclasses.asdict(added.entry)
    content = {"dataset": entry, **{n: getattr(added, n) for n in ("already", "read", "rows")}}
    lists = {"notes": list(added.notes), "doubts": list(added.doubts)}
    return Answer({**content, **lists}, _added(added))


def _added(added: Any) -> Iterator[Block]:
    entry = added.entry
    if added.already:
        text = "The same rows are in the catalogue already"
        yield Paragraph(f"{text}, as {entry.name}: {entry.path}")
        yield Paragraph("Nothing was written.")
        return
    rows = "SYNTHETIC rows" if entry.role == "synthetic" else "rows"
    yield Paragraph(f"{added.rows} {rows} of {entry.kind} are in {entry.path} as {entry.name}.")
    stated = ("title", "source", "licence", "year", "role")
    yield Definitions(tuple((name, getattr(entry, name)) for name in stated))
    if added.notes:
        yield Bullets(added.notes)
    for text in added.doubts:
        yield Callout("doubt", f"taken despite: {text}")
    if added.read:
        yield Paragraph(f"Next: {added.then}")
    else:
        yield Callout("note", f"The catalogue reads this folder with WORKBENCH_DATA={entry.folder}")


@app.command("measure")
@verb
def measure(
    study: StudyName, store: StoreRoot = "reports", out: TablesRoot = None, earlier: Earlier = False
) -> Answer:
    """Measure the model form in a stored study of columns: bias and scatter by region.

    Writes the tables from which `workbench simulate --budget` knows the model form.
    """
    from workbench.assessment.budget import RANGES, TABLE
    from workbench.study import assess, load_study
    from workbench.study.model_form import COLUMNS, RANGE_COLUMNS, model_form_rows, range_rows
    from workbench.study.tables import table

    chosen = load_study(study).study
    assessed = assess(chosen, Path(store), earlier=earlier)
    forms = table(model_form_rows(chosen, assessed), COLUMNS)
    written = _written({TABLE: forms, RANGES: table(range_rows(chosen), RANGE_COLUMNS)}, out)
    text = f"{len(forms)} rows on {forms['model'].nunique()} models in {written[0]}."
    return Answer({"rows": len(forms), "files": written}, [Paragraph(text)])


@app.command("rules")
@verb
def rules(
    study: StudyName, store: StoreRoot = "reports", out: TablesRoot = None, earlier: Earlier = False
) -> Answer:
    """Find the rules of validity in a stored study of drawn columns, and check them.

    A small tree per model tells regions in which its peak is off; the hold-out columns
    of the study check it. Writes the table from which models warn, and what the columns span.
    """
    from workbench.evidence.measured import RANGES, TABLE
    from workbench.study import assess, load_study
    from workbench.study.model_form import RANGE_COLUMNS, range_rows
    from workbench.study.tables import table
    from workbench.study.validity import VALIDITY_COLUMNS, checked, held_out_of, validity_rows

    chosen = load_study(study).study
    tables = assess(chosen, Path(store), earlier=earlier).tables
    held_out = held_out_of(chosen)
    rows = table(validity_rows(chosen, tables, held_out), VALIDITY_COLUMNS)
    checks = list(checked(chosen, tables, held_out))
    path, _ = _written({TABLE: rows, RANGES: table(range_rows(chosen), RANGE_COLUMNS)}, out)
    right, total = (sum(row[name] for row in checks) for name in ("right", "asked"))
    text = f"{len(rows)} regions of {len(checks)} models in {path}."
    share = f" Right on {right} of {total} answers on hold-out columns." if total else ""
    columns = tuple(Column(title, of=title) for title in ("label", "asked", "right"))
    shown = Table.of("checks", "Hold-out columns.", columns, checks)
    content = {"rows": len(rows), "file": path, "checks": checks}
    return Answer(content, [Paragraph(text + share), shown])


def _written(tables: Mapping[str, Any], out: str | None) -> list[str]:
    """Paths of tables of the catalogue, once they are written."""
    from workbench.evidence import dataset
    from workbench.study.store import write_atomically
    from workbench.study.tables import csv_bytes

    written = []
    for name, table in tables.items():
        path = dataset(name).path if out is None else Path(out) / dataset(name).path.name
        write_atomically(path, csv_bytes(table))
        written.append(str(path))
    return written


@app.command("check")
@verb
def check(
    files: Names = typer.Argument(None, metavar="[FILE.csv]...", help="Check these files alone."),
) -> Answer:
    """Check the catalogue: files, columns and sources, and every row of the tables of tests.

    With files of your own, only those: tests on studs, points of load-slip curves, impact tests.
    """
    from workbench.evidence import check as problems_of
    from workbench.evidence import datasets
    from workbench.intake import check_file, problems_of_own
    from workbench.studs import check_tables

    if files:
        results = {str(file): check_file(Path(file)) for file in files}
        content: dict[str, Any] = {"files": {file: bad for file, (bad, _) in results.items()}}
        content["suspicions"] = {file: doubts for file, (_, doubts) in results.items()}
        texts = []
        for file, (bad, doubts) in results.items():
            more = f", {len(doubts)} suspicions" if doubts else ""
            texts += [*bad, *(f"suspicion: {text}" for text in doubts)]
            texts.append(f"{file}: {len(bad)} problems{more}.")
        failed = any(content["files"].values())
    else:
        problems = [*problems_of(), *check_tables(), *problems_of_own()]
        content = {"datasets": len(datasets()), "problems": problems}
        texts = [*problems, f"{len(datasets())} datasets, {len(problems)} problems."]
        failed = bool(problems)
    return Answer(content, [Paragraph(text) for text in texts], int(failed))


# -- workbench new: templates of tables and files, to be redirected into a file and filled ---------


def _printed(text: str, as_json: bool) -> Answer:
    """The template as it is: no line of a file may be wrapped."""
    if not as_json:
        sys.stdout.write(text)
    return Answer({"template": text})


@templates.command("impact-tests")
@verb
def impact_tests(as_json: Json = False) -> Answer:
    """A table of impact tests on steel members, commented, with an example: for `data add`."""
    from workbench.impact_tests.rows import TEMPLATE

    return _printed(TEMPLATE.text, as_json)


@templates.command("mapping")
@verb
def mapping_template(as_json: Json = False) -> Answer:
    """A mapping file for a published table, for `workbench data add --mapping`."""
    from workbench.intake.mapping import TEMPLATE

    return _printed(TEMPLATE.read_text(encoding="utf-8"), as_json)


@templates.command("studs")
@verb
def studs(
    kind: str = option(
        "strength, load-slip, residual, fatigue, combined or deck.", "strength", "NAME"
    ),
    as_json: Json = False,
) -> Answer:
    """A table of tests on studs, commented, with an example: for `workbench fit`."""
    from workbench.studs.schema import template

    return _printed(template(kind), as_json)
