"""`workbench fit`: strength, load-slip and residual capacity of studs from tables of tests.

A verb is a question of `workbench.studs.questions`: its flags, and what `--set` may name, are made
of the fields that the question declares. Here are the files that it is asked of.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import Field, fields
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Flag, Many, Number, check_keys
from workbench.cli.output import (
    DECIMAL,
    SEP,
    SHEET,
    Answer,
    Names,
    group_of,
    option,
    pairs_of,
    verb,
    writable,
)
from workbench.studs.questions import QUESTIONS, Question

if TYPE_CHECKING:
    import pandas as pd

    from workbench.report.page.markdown import Block
    from workbench.studs.fit_protocol import Tables

app = group_of("fit")
FORMATS = ("html", "pdf")
_TABLE = "Your table of {}.  [default: shipped tables]"
_FILES: dict[str, tuple[Any, Any]] = {  # parameters that every verb has besides its question
    "with_shipped": (
        bool,
        option("Add the shipped tables to FILE.", False, None, "--with-shipped"),
    ),
    "keep_good": (bool, option("Leave bad rows of FILE out.", False, None, "--keep-good")),
    "report": (
        Names,
        option("Write a report, its curves as CSV beside it.", None, "FILE.html|pdf"),
    ),
    "sheet": (str | None, SHEET),
    "sep": (str | None, SEP),
    "decimal": (str | None, DECIMAL),
    "settings": (Names, option("Set an option by its name.", None, "OPTION=VALUE", "--set")),
}


def _flag(field: Field[Any]) -> str:
    return field.metadata["path"] or f"--{field.name.replace('_', '-')}"


def _option(field: Field[Any]) -> tuple[Any, Any]:
    """Type and option of the command line that a declared field is."""
    rule, words = field.metadata["rule"], field.metadata["help"]
    if isinstance(rule, Flag):
        return bool, option(words, field.default, None, "" if field.default else _flag(field))
    kind: Any = Names if isinstance(rule, Many) else str
    if isinstance(rule, Number):
        kind = int if rule.integer else float
    if isinstance(rule, Choice):
        words = "; ".join(filter(None, (words, ", ".join(rule.words))))
    metavar = None if isinstance(rule, Number) else "NAME"
    return kind | None, option(words, field.default, metavar, _flag(field))


def _command(kind: type[Question]) -> None:
    """Make a command of a question."""
    name, rows = ("POINTS", "points") if kind.on_curves else ("FILE", "tests")
    file = typer.Argument(None, metavar=f"[{name}.csv]", help=_TABLE.format(rows))
    options = {field.name: _option(field) for field in fields(kind)}

    def command(**values: Any) -> Answer:
        return _answer(kind, {name: values.pop(name) for name in options}, **values)

    parameters = {"file": (str | None, file), **_FILES, **options}
    command.__signature__ = Signature([  # type: ignore[attr-defined]
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in parameters.items()
    ])  # fmt: skip
    command.__doc__ = kind.__doc__
    app.command(kind.name)(verb(command))


for _kind in QUESTIONS:
    _command(_kind)


def _asked(kind: type[Question], values: dict[str, Any], settings: Names) -> Question:
    """The question with its options, those of ``--set`` last. Raises `InputError`."""
    declared = {field.name: field for field in fields(kind)}
    pairs = pairs_of("--set", settings, "loss=huber")
    check_keys(list(pairs), list(declared), "")
    for name, value in pairs.items():
        several = isinstance(declared[name].metadata["rule"], Many) and isinstance(value, str)
        values[name] = [value] if several else value
    try:
        return kind(**values)
    except InputError as error:
        name = error.field.partition(".")[0]
        if name not in declared:
            raise
        flag = _flag(declared[name])
        raise InputError(flag, error.value, error.allowed, error.advice) from error


def _answer(
    kind: type[Question],
    values: dict[str, Any],
    file: str | None,
    report: Names,
    settings: Names,
    **how: Any,
) -> Answer:
    """Read the tables, find the answer, write the reports that are asked for."""
    from workbench.studs.fit_protocol import plain
    from workbench.studs.laboratory import find

    question = _asked(kind, values, settings)
    targets, inputs = {}, (file, getattr(question, "points", None))
    for name in report or ():  # refused before anything is computed
        target = writable("--report", name, *FORMATS, inputs=inputs)
        targets[target.suffix.lower().removeprefix(".")] = target
    table, told = _read(question, file, how)
    fitted, held = question.split(table)
    head = question.head(table, held, how, **told)
    written: dict[str, Path] = {}
    try:
        tables = find(question, fitted, held)
    except InputError as error:
        if len(fitted) or not head["roles"]:
            raise
        roles = ", ".join(f"{role} in {n}" for role, n in head["roles"].items())
        advice = 'give rows to fit the role "calibrate"; --with-shipped judges by the others'
        reason = f"none may be fitted: their role is {roles}"
        rows = f"{sum(head['roles'].values())} rows"
        raise InputError("table", rows, reason, advice) from error
    if targets:
        from workbench.report.fit_report import write

        written = write(head, tables, (fitted, held), targets)
    return Answer({**head, "results": plain(tables)}, _blocks(head, tables, written))


def _read(
    question: Question, file: str | None, how: dict[str, Any]
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """The rows that a question is asked of, and what its head tells of them."""
    from workbench.base.datafiles import digest
    from workbench.base.tables import Reading
    from workbench.studs.schema import POINTS, TESTS, examine
    from workbench.studs.tables import joined, shipped

    schema = POINTS if question.on_curves else TESTS
    with_shipped = how["with_shipped"] or file is None
    parts = [shipped("stud-load-slip" if question.on_curves else "stud-push-out")] * with_shipped
    notes, left_out = list[str](), list[str]()
    if file is not None:
        found = examine(file, schema, Reading(how["sheet"], how["sep"], how["decimal"]))
        notes += (f"{Path(file).name}: {note}" for note in found.notes)
        parts.append(found.rows if how["keep_good"] else found.accept())
        left_out += (str(problem.error()) for problem in found.problems)
    return joined(parts, unique=bool(schema.key)), {
        "tables": [*([file] if file else []), *["shipped"] * with_shipped],
        "digest": None if file is None else digest(Path(file)),
        "rows_left_out": left_out,
        "notes": notes,
    }


def _blocks(head: dict[str, Any], tables: Tables, written: dict[str, Path]) -> Iterator[Block]:
    """The answer on a terminal, and the reports that were written."""
    from workbench.report.chapters.studs import of_fit
    from workbench.report.page.markdown import paragraph

    yield of_fit("shown", head, tables)
    yield from (paragraph(f"{words}: {path}") for words, path in written.items())
