"""Verbs of tables from elsewhere: `data add`, `data check`, templates of tests and of mappings."""

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import typer

from workbench.cli.new import printed
from workbench.cli.output import DECIMAL, SEP, SHEET, Answer, Json, Names, option, pairs_of, verb
from workbench.report.page.markdown import Block, bullets, callout, definitions, paragraph

INTO = option("Your own data.  [default: $WORKBENCH_DATA, else ./lab_data]", None, "FOLDER")


@verb
def add(
    table: str = typer.Argument(metavar="TABLE.csv|xlsx", help="Table of tests."),
    mapping: str | None = option(
        "What its columns are, and where it is from.", None, "MAPPING.toml"
    ),
    kind: str | None = option(
        "impact-tests, stud-tests or stud-points.  [default: told from the columns]", None, "KIND"
    ),
    into: str | None = INTO,
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
    from workbench.extras.intake.add import add_table

    added = add_table(
        Path(table),
        mapping=None if mapping is None else Path(mapping),
        kind=kind,
        into=None if into is None else Path(into),
        name=name,
        despite_doubts=despite_doubts,
        how=Reading(sheet, sep, decimal),
    )
    return _answer_of(added)


def _answer_of(added: Any, more: Sequence[Block] = ()) -> Answer:
    """Answer of a verb that has added something, with `more` to say."""
    entry = dataclasses.asdict(added.entry)
    content = {"dataset": entry, **{n: getattr(added, n) for n in ("already", "read", "rows")}}
    lists = {"notes": list(added.notes), "doubts": list(added.doubts)}
    return Answer({**content, **lists}, [*more, *_added(added)])


def _added(added: Any) -> Iterator[Block]:
    entry = added.entry
    if added.already:
        text = "The same rows are in the catalogue already"
        yield paragraph(f"{text}, as {entry.name}: {entry.path}")
        yield paragraph("Nothing was written.")
        return
    rows = "SYNTHETIC rows" if entry.role == "synthetic" else "rows"
    yield paragraph(f"{added.rows} {rows} of {entry.kind} are in {entry.path} as {entry.name}.")
    stated = ("title", "source", "licence", "year", "role", "uncertainty")
    yield definitions(tuple((n, getattr(entry, n)) for n in stated if getattr(entry, n)))
    if added.notes:
        yield bullets(added.notes)
    for text in added.doubts:
        yield callout("doubt", f"taken despite: {text}")
    if added.read:
        yield paragraph(f"Next: {added.then}")
    else:
        yield callout("note", f"The catalogue reads this folder with WORKBENCH_DATA={entry.folder}")


@verb
def add_answer(
    result: str = typer.Argument(metavar="RESULT.csv|xlsx", help="A row per instant."),
    scenario: str = option("The scenario that the program was given.", ..., "SCENARIO.toml"),
    model: str = option("The program in words.", ..., "'LS-DYNA, shell 10 mm'"),
    source: str = option("Who ran it, and where that is written.", ..., "TEXT"),
    licence: str | None = option("Who may use it.  [default: not stated]", None, "TEXT"),
    uncertainty: str | None = option(
        "How well displacements are known: half-width of a 95 % interval.", None, "'3 %'|'4 mm'"
    ),
    outcome: str = option("none, or a collapse: geometry, squash, buckling, shear.", "none"),
    units: Names = option("Unit of a column that says none.", None, "COLUMN=UNIT"),
    mapping: str | None = option("What its columns are.", None, "MAPPING.toml"),
    study: str | None = option("Refuse what is no scenario of this study.", None, "STUDY"),
    into: str | None = INTO,
    name: str | None = option("Its name.  [default: that of the file]", None, "NAME"),
    sheet: str | None = SHEET,
    sep: str | None = SEP,
    decimal: str | None = DECIMAL,
) -> Answer:
    """Add the answer of another program to your own data: a side of every study of its scenario.

    Columns are time and displacement, and if known force, velocity, kinetic, elastic, dissipated,
    external_work, contact_loss, with units as in displacement_mm or in a row of units. Everything
    is checked before anything is written.
    """
    from workbench.base.catalogue import ANSWERS
    from workbench.base.tables import Reading
    from workbench.extras.intake.add import add_table
    from workbench.extras.intake.answers import UNSTATED, cases_of_answer
    from workbench.extras.intake.mapping import Mapping, read_mapping
    from workbench.scenarios import load_scenario
    from workbench.study import load_study

    asked = load_scenario(scenario)
    cases = cases_of_answer(load_study(study).study, asked) if study else []
    known = Mapping() if mapping is None else read_mapping(Path(mapping))
    said = dataclasses.replace(
        known,
        title=model,
        source=source,
        licence=licence or known.licence or UNSTATED,
        role="verify",
        uncertainty=known.uncertainty if uncertainty is None else uncertainty,
        units={**(known.units or {}), **pairs_of("--units", units, "displacement=mm")},
        constants={**(known.constants or {}), "collapse": outcome},
    )
    added = add_table(
        Path(result),
        mapping=said,
        scenario=asked,
        kind=ANSWERS,
        into=None if into is None else Path(into),
        name=name,
        how=Reading(sheet, sep, decimal),
    )
    note = paragraph(f"It answers {', '.join(cases)} of {study}.")
    return _answer_of(added, [note] if cases else [])


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
    from workbench.base.catalogue import check as problems_of
    from workbench.base.catalogue import datasets
    from workbench.base.tables import Reading
    from workbench.extras.intake.kinds import check_file, problems_of_own
    from workbench.studs.tables import check_tables

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


@verb
def impact_tests(as_json: Json = False) -> Answer:
    """A table of impact tests on steel members, commented, with an example: for `data add`."""
    from workbench.extras.intake.impact_tests.rows import TEMPLATE

    return printed(TEMPLATE.text, as_json)


@verb
def mapping_template(as_json: Json = False) -> Answer:
    """A mapping file for a published table, for `workbench data add --mapping`."""
    from workbench.extras.intake.mapping import TEMPLATE

    return printed(TEMPLATE.read_text(encoding="utf-8"), as_json)
