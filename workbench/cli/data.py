"""`workbench data` and `new`: the catalogue, one's own tables, and templates to fill in."""

import dataclasses
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import typer

from workbench.cli.output import Answer, Json, Names, option, verb, writable
from workbench.cli.studies import StoreRoot
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
    name: str = typer.Argument(metavar="TABLE", help="Which table: columns, pulses or frames."),
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

    from workbench.evidence import dataset
    from workbench.evidence.error_table import TABLES, TRUTH
    from workbench.fields import Choice
    from workbench.study import load_study, run_study
    from workbench.study.error_rows import error_rows
    from workbench.study.runner import progress_for
    from workbench.study.store import write_atomically
    from workbench.study.tables import csv_bytes

    tables = {each.dataset: each for each in TABLES.values()}
    chosen = tables[Choice(tuple(tables)).check("table", name)]
    path = dataset(name).path if out is None else writable("--out", out, "csv")
    loaded = load_study(chosen.study)
    progress = progress_for(sys.stderr, os.environ)
    run_study(loaded.study, Path(store), jobs=jobs, progress=progress, file=loaded.file)
    rows = pd.DataFrame(list(error_rows(loaded.study, chosen, Path(store))))
    write_atomically(path, csv_bytes(rows))
    judged = int(rows[TRUTH].notna().sum())
    text = f"{len(rows)} rows, {judged} of them with a truth, in {path}."
    return Answer({"rows": len(rows), "judged": judged, "file": str(path)}, [Paragraph(text)])


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


@templates.command("striker")
@verb
def striker(
    traffic: str = typer.Argument(metavar="TRAFFIC", help="Such as motorway, urban or garage."),
    distance: float = option("From where it leaves its lane to the column, m.", 0.0, "M"),
    deceleration: float = option("On this way, m/s2.", 3.0, "A"),
    angle: float = option("To the road, degrees.", 10.0, "DEGREES"),
    as_json: Json = False,
) -> Answer:
    """A vehicle of EN 1991-1-7, Table C.2, as the table [striker] of a scenario."""
    from workbench.scenarios.traffic import TRAFFIC, design_striker

    made = design_striker(traffic, distance, deceleration, angle)
    text = (
        f"# {TRAFFIC[traffic].title}: EN 1991-1-7, Table C.2, recalled and not verified in print\n"
        f"# braked by {deceleration:g} m/s2, {distance:g} m from its lane, at {angle:g} degrees\n"
        f"[striker]\nmass = {made.mass!r}\nvelocity = {made.velocity:.9g}\n"
    )
    return _printed(text, as_json)


@templates.command("missile")
@verb
def missile(
    file: Path = typer.Argument(metavar="FILE", help="station_m,mass_kg_per_m,crushing_force_N"),
    velocity: float = option("At which it hits, m/s.", ..., "V"),
    as_json: Json = False,
) -> Answer:
    """The force of a missile that crushes at a rigid wall (Riera), as the table [pulse]."""
    from workbench.datafiles import open_input
    from workbench.scenarios.load_histories import missile_of, missile_pulse

    with open_input(file, "missile") as stream:
        pulse = missile_pulse(missile_of(stream.read(), str(file)), velocity)
    text = (
        f"# {file.name} at {velocity:g} m/s: {pulse.whole:.6g} N s in {pulse.end:.4g} s\n"
        f'[pulse]\nshape = "table"\npeak = {pulse.peak:.9g}\nload = "point"\n'
        f"times = {_listed(pulse.times or ())}\nfactors = {_listed(pulse.factors or ())}\n"
    )
    return _printed(text, as_json)


@templates.command("near-fault")
@verb
def near_fault(
    amplitude: float = option("Of the velocity, m/s.", ..., "A"),
    frequency: float = option("Of the wave, Hz.", ..., "F"),
    cycles: float = option("Periods of the wave in the pulse.", 2.0, "GAMMA"),
    phase: float = option("Of the wave, degrees.", 90.0, "NU"),
    as_json: Json = False,
) -> Answer:
    """The ground near a fault (Mavroeidis and Papageorgiou), as the table [ground] of a frame."""
    from workbench.scenarios.load_histories import near_fault_motion

    step, acceleration = near_fault_motion(amplitude, frequency, cycles, phase)
    text = f"[ground]\ntime_step = {step!r}\nacceleration = {_listed(acceleration)}\n"
    return _printed(text, as_json)


def _listed(numbers: Iterable[float]) -> str:
    return "[" + ", ".join(f"{number:.12g}" for number in numbers) + "]"


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
