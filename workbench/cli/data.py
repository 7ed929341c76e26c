"""`workbench data`: the catalogue of published numbers, tests and profiles."""

import dataclasses
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from workbench.cli.output import Answer, verb
from workbench.content.tree import Block, Column, Definitions, Paragraph, Section, Table

app = typer.Typer(
    help="Show and check the data catalogue.", rich_markup_mode=None, no_args_is_help=False
)


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
def show(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the dataset.")],
) -> Answer:
    """Show where a dataset is from, and its rows."""
    from workbench.evidence import dataset, load
    from workbench.studs.fit_protocol import plain

    entry = dataclasses.asdict(dataset(name))
    rows = plain(load(name))
    return Answer({**entry, "rows": rows}, _shown(entry, rows))


def _shown(entry: dict[str, Any], rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Definitions(tuple((key, value) for key, value in entry.items() if isinstance(value, str)))
    yield Section("columns", "Columns:", (Definitions(tuple(entry["columns"].items())),))
    yield Table.of("rows", "", (Column(name, of=name) for name in rows[0]), rows)


@app.command("check")
@verb
def check(
    files: Annotated[
        list[str] | None, typer.Argument(metavar="[FILE.csv]...", help="Check these files alone.")
    ] = None,
) -> Answer:
    """Check the catalogue: files, columns and sources, and every row of the tables of studs.

    With files of your own, only those: tests on studs, or points of load-slip curves.
    """
    from workbench.evidence import check as problems_of
    from workbench.evidence import datasets
    from workbench.studs import check_tables
    from workbench.studs.suspicion import check_file

    if files:
        found = {str(file): check_file(file) for file in files}
        content: dict[str, Any] = {"files": {file: bad for file, (bad, _) in found.items()}}
        content["suspicions"] = {file: doubts for file, (_, doubts) in found.items()}
        texts = []
        for file, (bad, doubts) in found.items():
            more = f", {len(doubts)} suspicions" if doubts else ""
            texts += [*bad, *(f"suspicion: {text}" for text in doubts)]
            texts.append(f"{file}: {len(bad)} problems{more}.")
        failed = any(content["files"].values())
    else:
        problems = [*problems_of(), *check_tables()]
        content = {"datasets": len(datasets()), "problems": problems}
        texts = [*problems, f"{len(datasets())} datasets, {len(problems)} problems."]
        failed = bool(problems)
    return Answer(content, [Paragraph(text) for text in texts], int(failed))
