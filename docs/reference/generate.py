"""Reference pages from the declarations: arguments, keys of files, options, columns of tables.

`python docs/reference/generate.py` writes them beside this file; a test compares them with it.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import workbench as wb
from workbench.base.fields import Declared, Instance, Many, path_of
from workbench.base.offered import offered
from workbench.cli import run
from workbench.extras.intake.answers import SERIES
from workbench.extras.intake.impact_tests.rows import IMPACTS
from workbench.report.chapters.configuration import claims
from workbench.responses.histories import COORDINATES, VARIABLES
from workbench.scenarios.files import KINDS
from workbench.studs.schema import POINTS, TESTS, TableSchema

Row = tuple[str, ...]


def _table(heads: str, rows: Iterable[Row]) -> str:
    names = heads.split(", ")
    lines = [names, ["---"] * len(names), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |\n" for line in lines)


def _values(rule: Any) -> str:
    if getattr(rule, "integer", False) and (rule.low, rule.high) == (0, 1):
        return "0 or 1"
    return str(rule.allowed()).removeprefix("must be ")


def _default(value: Any) -> str:
    if value is dataclasses.MISSING:
        return "needed"
    return "" if value is None else f"`{json.dumps(value)}`"


def _keys(kind: Any, array: str = "") -> Iterator[tuple[str, Row]]:
    """Keys of a declared class as a file has them: table, then key, values, default, meaning."""
    for field in dataclasses.fields(kind):
        rule = field.metadata["rule"]
        item = rule.item if isinstance(rule, Many) else rule
        table, _, key = (field.name if array else path_of(field, kind.TABLE)).rpartition(".")
        if isinstance(item, Instance) and not item.read:
            listed = f"[[{key}]]" if item is not rule else ""
            yield from _keys(item.form or item.kind, listed)
        else:
            values = "see the guide" if isinstance(rule, Instance) else _values(rule)
            meaning = field.metadata["help"]
            yield array or table, (f"`{key}`", values, _default(field.default), meaning)


def inputs() -> str:
    """Page of the keys of scenario files."""
    places: dict[str, dict[Row, list[str]]] = {}
    tables: dict[str, list[str]] = {}
    companions = {point.name: point.load() for point in offered("scenarios")}
    for name, kind in (KINDS | companions).items():
        for place, row in _keys(kind):
            head = place if place.startswith("[") else f"[{place}]" if place else "top"
            places.setdefault(head, {}).setdefault(row, []).append(name)
            if head not in tables.setdefault(name, []):
                tables[name].append(head)
    text = "# Keys of scenario files\n\nThe tables that each kind of scenario may have.\n\n"
    rows = ((f"`{name}`", ", ".join(f"`{each}`" for each in has)) for name, has in tables.items())
    text += _table("kind, tables", rows)
    for place, keys in places.items():
        holders = list(dict.fromkeys(name for names in keys.values() for name in names))
        lines = (
            (*row, "" if names == holders else ", ".join(names)) for row, names in keys.items()
        )
        text += f"\n## `{place}`\n\n" + _table("key, values, default, meaning, in", lines)
    return text


def arguments() -> str:
    """Page of the arguments of the public classes whose fields are declared."""
    text = (
        "# Arguments of the classes\n\nNumbers are in SI units or texts with a unit. A value that"
        " is not allowed raises `InputError` with field, value, allowed range and remedy.\n"
    )
    for name, kind in ((name, getattr(wb, name)) for name in wb.__all__):
        if not (isinstance(kind, type) and issubclass(kind, Declared)):
            continue
        rows = (
            (
                f"`{field.name}`",
                _values(field.metadata["rule"]),
                _default(None if isinstance(field.default, Declared) else field.default),
                field.metadata["help"],
            )
            for field in dataclasses.fields(kind)
        )
        head, together = (str(doc).partition("\n")[0] for doc in (kind.__doc__, kind.check.__doc__))
        text += f"\n## `{name}`\n\n{head}\n\n" + _table("argument, values, default, meaning", rows)
        if kind.check is not Declared.check:
            text += f"\nWhen made: {together[0].lower()}{together[1:]}\n"
    return text


def options() -> str:
    """Page of the models and their options."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        run(["models", "--json"])
    models = json.loads(printed.getvalue())["models"]
    taken: dict[tuple[str, str, str], list[str]] = {}
    for model in models:
        for name, default in model["options"].items():
            key = f"`{name}`", _default(default), model["meanings"][name]
            taken.setdefault(key, []).append(f"`{model['name']}`")
    heads = ((f"`{m['name']}`", m["title"], ", ".join(m["answers"])) for m in models)
    rows = ((*key, ", ".join(names)) for key, names in sorted(taken.items()))
    return (
        "# Models and their options\n\n`workbench models NAME` prints one of them in full.\n\n"
        + _table("model, what it is, answers", heads)
        + "\n## Options\n\nSet with `--option name=value`, or as arguments of `wb.make_model`.\n\n"
        + _table("option, default, meaning, models", rows)
    )


def _columns(table: TableSchema) -> str:
    rows = (
        (
            f"`{each.name}`{' (must exist)' if each.filled else ''}",
            each.meaning,
            _values(each.rule),
            each.default,
        )
        for each in table.columns
    )
    return _table("column, meaning, values, default", rows)


def columns() -> str:
    """Page of the columns of tables and of the variables of responses."""
    rows = (
        (f"`{name}`", each.long_name, each.units, ", ".join(each.dims))
        for name, each in (COORDINATES | VARIABLES).items()
    )
    return (
        "# Columns of tables, variables of responses\n\n## Tests on studs\n\n"
        + _columns(TESTS)
        + "\n## Points of load-slip curves\n\n"
        + _columns(POINTS)
        + "\n## Tests of impacts\n\n"
        + _columns(IMPACTS)
        + "\n## Answers of other programs\n\n"
        + _columns(SERIES)
        + "\n## Responses\n\n"
        + _table("variable, meaning, unit, dimensions", rows)
    )


def checks() -> str:
    """Page of the independent checks, from what tests claim and have computed."""
    kinds: dict[str, list[Row]] = {}
    for row in claims():
        numbers = (row["expected"], row["tolerance"], row["computed"], row["error"])
        rest = (row["says"], *numbers, row["source"], "`{}` {}".format(*row["test"].split("::")))
        for kind, _, name in (subject.partition(":") for subject in row["subject"].split()):
            kinds.setdefault(f"\n## Kind: {kind}\n\n", []).append((f"`{name}`", *rest))
    heads = "of, check, expected, tolerance, computed, error, source, test"
    text = (
        "# Independent checks\n\nChecks of every part of the workbench, as computed when its tests"
        " ran last (`make manual`). A source is a work of the bibliography, or what else stands"
        " against the number: a closed form, independent code, another program, a property.\n"
    )
    return text + "".join(head + _table(heads, sorted(rows)) for head, rows in kinds.items())


PAGES = {"arguments": arguments, "checks": checks, "columns": columns, "inputs": inputs}
PAGES |= {"options": options}

if __name__ == "__main__":
    for name, page in PAGES.items():
        Path(__file__).with_name(f"{name}.md").write_text(page(), encoding="utf-8")
