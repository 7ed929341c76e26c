"""Pages: Markdown templates that hold the words of a chapter.

The template ``limits.jinja`` stands beside ``limits.py``; each of its macros is a part of a page or
a sentence, in Markdown as `page.markdown` describes it. Blocks that are made elsewhere
stand where they are named in double braces; `caption` gives a table its words.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template, pass_context
from jinja2.runtime import Context

from workbench.report.page import formatting
from workbench.report.page.bibliography import cited
from workbench.report.page.markdown import (
    Cell,
    Markdown,
    PageColumn,
    Table,
    definitions,
    line,
    literal,
    printed,
)

_FILTERS = (
    *("axis_label", "brief", "count", "duration", "in_unit", "number", "part", "percent"),
    *("rounded", "several", "share", "span_cell", "spans", "up", "valued"),
)


class Page:
    """The template beside a module, by the file of the module; `names` are known to all parts."""

    def __init__(self, module: str, **names: Any) -> None:
        self._file, self._names = Path(module).with_suffix(".jinja"), names

    def words(self, part: str, **values: Any) -> str:
        """The text of one of its macros."""
        return printed(line(self._macro(part, values)))

    def blocks(self, part: str, **values: Any) -> Markdown:
        """Markdown of one of its macros, whose lines may be indented."""
        lines = [each.strip(" ") for each in self._macro(part, values).split("\n")]
        return Markdown("\n".join(["", *lines, "", ""])) if any(lines) else Markdown()

    def _macro(self, part: str, values: dict[str, Any]) -> Markdown:
        text: Markdown = getattr(_template(self._file).make_module(self._names), part)(**values)
        return text


@cache
def _template(file: Path) -> Template:
    environment = Environment(
        loader=FileSystemLoader(file.parent),
        autoescape=True,  # so that what macros give is known to be Markdown
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_filled,
    )
    environment.filters |= {name: getattr(formatting, name) for name in _FILTERS}
    environment.filters |= {"title": formatting.title_of, "cited": cited, "cell": Cell}
    environment.globals |= {"caption": _captioned, "definitions": definitions, "table": _table}
    environment.globals |= {"text": _text, "number": _number}
    return environment.get_template(file.name)


def _filled(value: Any) -> Markdown:
    """Markdown of a value in braces; sentences of macros without the ends of their lines."""
    text = literal(value)
    return text if "\n\n" in text else Markdown(text.strip("\n"))


@pass_context
def _text(
    context: Context, title: str, of: str | Callable[..., Any], width: float = 1.0
) -> PageColumn:
    """A column whose cells are what an expression, a macro or a function makes of a `row`."""
    if callable(of):
        return PageColumn(title, width=width, of=of)
    expression = context.environment.compile_expression(of, undefined_to_none=False)
    names = context.get_all()
    return PageColumn(title, width=width, of=lambda row: expression(names, row=row))


@pass_context
def _number(
    context: Context, title: str, of: str | Callable[..., Any], width: float = 1.0
) -> PageColumn:
    """Plain form of numbers."""
    return replace(_text(context, title, of, width), numeric=True)


def _table(
    key: str,
    rows: Sequence[Any],
    columns: Sequence[PageColumn],
    limit: int | None = None,
    caller: Callable[[], str] = str,
) -> Markdown:
    """A table of rows or a frame, the text of a call block its caption; nothing without a row."""
    return literal(Table.of(key, caller(), columns, rows, limit) if len(rows) else None)


def _captioned(table: Table | None, caller: Callable[[], str]) -> Markdown:
    """A table with the words of a call block as its caption."""
    return literal(table and replace(table, caption=caller()))
