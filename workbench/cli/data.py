"""`workbench data`: the catalogue of published numbers, tests and profiles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.cli.output import Json, print_json, print_table

if TYPE_CHECKING:
    from workbench.evidence import Dataset

app = typer.Typer(
    help="Show and check the data catalogue.",
    rich_markup_mode=None,
    no_args_is_help=False,
)


@app.command("list")
def list_datasets(as_json: Json = False) -> None:
    """List the datasets."""
    from workbench.evidence import datasets

    entries = datasets()
    if as_json:
        print_json({"datasets": [_entry(entry) for entry in entries]})
        return
    print_table(
        [(entry.name, entry.role, entry.licence, entry.title) for entry in entries],
        ("dataset", "role", "licence", "title"),
    )


@app.command("show")
def show(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the dataset.")],
    as_json: Json = False,
) -> None:
    """Show where a dataset is from, and its rows."""
    from workbench.evidence import dataset, load

    entry = dataset(name)
    table = load(name)
    rows = [
        {str(column): _plain(value) for column, value in row.items()}
        for row in table.to_dict("records")
    ]
    if as_json:
        print_json({**_entry(entry), "rows": rows})
        return
    print_table([(key, value) for key, value in _entry(entry).items() if isinstance(value, str)])
    print("\nColumns:")
    print_table([(f"  {column}", meaning) for column, meaning in entry.columns.items()])
    print()
    texts = [["" if value is None else str(value) for value in row.values()] for row in rows]
    print_table(texts, [str(column) for column in table.columns])


@app.command("check")
def check(
    files: Annotated[
        list[str] | None, typer.Argument(metavar="[FILE.csv]...", help="Check these files alone.")
    ] = None,
    as_json: Json = False,
) -> int:
    """Check the catalogue: files, columns and sources, and every row of the tables of studs.

    With files of your own, only those: tests on studs, or points of load-slip curves.
    """
    from workbench.evidence import check as problems_of
    from workbench.evidence import datasets
    from workbench.studs import check_tables
    from workbench.studs.tables import check_file

    if files:
        found = {str(file): check_file(file) for file in files}
        if as_json:
            print_json({"files": found})
        else:
            for file, sentences in found.items():
                print(*sentences, f"{file}: {len(sentences)} problems.", sep="\n")
        return 1 if any(found.values()) else 0
    problems = [*problems_of(), *check_tables()]
    count = len(datasets())
    if as_json:
        print_json({"datasets": count, "problems": problems})
    else:
        for problem in problems:
            print(problem)
        print(f"{count} datasets, {len(problems)} problems.")
    return 1 if problems else 0


def _entry(entry: Dataset) -> dict[str, Any]:
    import dataclasses

    return {f.name: getattr(entry, f.name) for f in dataclasses.fields(entry)}


def _plain(value: Any) -> Any:
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and math.isnan(value) else value
