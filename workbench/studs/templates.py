"""Commented templates of tables of tests: what to fill in, what it means, and an example that runs.

A template is CSV whose comments stand above the header; the reader passes over them. What is in
each, ``templates.toml`` beside this file declares.
"""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from workbench.fields import Choice, Text
from workbench.studs.reading import COMMENT
from workbench.studs.schema import POINTS, TESTS, Table


class Template(NamedTuple):
    """What a table is for: its `title`, columns and example `rows`; `verb` that takes it.

    `more`, columns that help and may be added; `notes`, what columns alone do not tell; `units`, a
    second line for names without units (empty: the names hold them).
    """

    title: str
    schema: Table
    columns: tuple[str, ...]
    more: tuple[str, ...]
    verb: str
    rows: tuple[str, ...]
    notes: tuple[str, ...] = ()
    units: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The whole template: comments, the header, and the line of units if there is one."""
        lines = (f"{COMMENT} {line}".rstrip() for line in _comments(self))
        header = ",".join(_shown(self, name) for name in self.columns)
        return "\n".join([*lines, header, *([",".join(self.units)] if self.units else [])]) + "\n"


def templates_in(path: Path, *schemas: Table) -> dict[str, Template]:
    """The templates that a file such as ``templates.toml`` declares, by their kinds."""
    named = {schema.name: schema for schema in schemas}
    found = {}
    for kind, told in tomllib.loads(path.read_text(encoding="utf-8")).items():
        columns, more, units = (_names(told.get(key, "")) for key in ("columns", "more", "units"))
        rows, notes = (tuple(told.get(key, "").splitlines()) for key in ("rows", "notes"))
        which = named[told["table"]], columns, more
        found[kind] = Template(told["title"], *which, told["verb"], rows, notes, units)
    return found


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",")) if text else ()


TEMPLATES = templates_in(Path(__file__).with_name("templates.toml"), TESTS, POINTS)


def template(kind: str) -> str:
    """The text of a template. Raises `InputError` for an unknown kind."""
    Choice(tuple(TEMPLATES)).check("--kind", kind)
    return TEMPLATES[kind].text


def _shown(told: Template, name: str) -> str:
    return told.schema.column(name).base if told.units else name


def _comments(told: Template) -> Iterator[str]:
    yield f"{told.title}. Then"
    yield "    workbench data check FILE.csv"
    yield f"    workbench {told.verb}"
    yield "Lines above the header that begin with # are not read; an empty cell: not reported."
    for title, names in (("Columns:", told.columns), ("Columns that help:", told.more)):
        yield ""
        yield title
        wide = max(len(_shown(told, name)) for name in names)
        for name in names:
            column = told.schema.column(name)
            rule = column.rule.allowed().removeprefix("must be ")
            words = "" if isinstance(column.rule, Text) else f"; {rule}"
            yield f"    {_shown(told, name):{wide}}  {column.meaning}{words}"
    yield ""
    yield from told.notes
    yield ""
    yield "Example:"
    yield from (f"    {row}" for row in told.rows)
