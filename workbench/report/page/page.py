"""Pages: Jinja templates that hold the words of a chapter, read as blocks of the content tree.

The template ``limits.jinja`` stands beside ``limits.py``; each of its macros is a part of a page or
a sentence. A part is written as it is read: paragraphs between empty lines, ``- `` before the items
of a list, ``! tone: `` before what must not be overlooked, ``# key: Title`` before a section and
``##`` before one inside it, ``#-`` before one that opens on demand. Blocks that are made elsewhere
stand where they are named in double braces; `caption` gives a table its words. Values are never
read as structure.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template, pass_context
from jinja2.runtime import Context

from workbench.report.page import formatting
from workbench.report.page.bibliography import cited
from workbench.report.page.tree import (
    Block,
    Bullets,
    Callout,
    Cell,
    Column,
    Definitions,
    Paragraph,
    Section,
    Table,
)

_MARK = re.compile(
    r"(?P<hashes>#+)(?P<fold>-?) (?P<key>\S+): ?(?P<title>.*)"
    r"|- (?P<item>.*)|! (?P<tone>\S+): (?P<callout>.*)"
)
_VALUE = re.compile("\x02(\\d+)\x03")  # the place of a value in a list
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
        text, placed = self._filled(part, values)
        return _resolved(text, placed)

    def blocks(self, part: str, **values: Any) -> tuple[Block, ...]:
        """The blocks of one of its macros; sections without content are left out."""
        return _read(*self._filled(part, values))

    def section(self, part: str, **values: Any) -> Section | None:
        """The section that one of its macros is; None where it has no content."""
        blocks = self.blocks(part, **values)
        if not blocks:
            return None
        (section,) = blocks
        assert isinstance(section, Section)
        return section

    def _filled(self, part: str, values: dict[str, Any]) -> tuple[str, list[Any]]:
        placed: list[Any] = []
        module = _template(self._file).make_module({**self._names, "placed": placed})
        return str(getattr(module, part)(**values)), placed


@cache
def _template(file: Path) -> Template:
    environment = Environment(
        loader=FileSystemLoader(file.parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_placed,
    )
    environment.filters |= {name: getattr(formatting, name) for name in _FILTERS}
    environment.filters |= {"title": formatting.title_of, "cited": cited, "cell": Cell}
    environment.globals |= {"caption": _captioned, "definitions": _definitions, "table": _table}
    environment.globals |= {"text": _text, "number": _number}
    return environment.get_template(file.name)


@pass_context
def _text(context: Context, title: str, of: str | Callable[..., Any], width: float = 1.0) -> Column:
    """A column whose cells are what an expression, a macro or a function makes of a `row`."""
    if callable(of):
        return Column(title, width=width, of=of)
    expression = context.environment.compile_expression(of, undefined_to_none=False)
    names = context.get_all()
    return Column(title, width=width, of=lambda row: expression(names, row=row))


@pass_context
def _number(
    context: Context, title: str, of: str | Callable[..., Any], width: float = 1.0
) -> Column:
    """The same of numbers."""
    return replace(_text(context, title, of, width), numeric=True)


@pass_context
def _table(
    context: Context,
    key: str,
    rows: Sequence[Any],
    columns: Sequence[Column],
    limit: int | None = None,
    caller: Callable[[], str] | None = None,
) -> str:
    """A table of rows, the text of a call block its caption; nothing without a row."""
    if not rows:
        return ""
    placed = context["placed"]

    def resolved(column: Column) -> Column:
        return replace(column, of=lambda row: _in_place(column.cell(row), placed))

    words = "" if caller is None else _resolved(caller(), placed)
    return _placed(context, Table.of(key, words, map(resolved, columns), rows, limit))


def _in_place(cell: Cell, placed: list[Any]) -> Cell:
    """A cell with the values of the macro that wrote it."""
    return replace(cell, text=_resolved(cell.text, placed)) if "\x02" in cell.text else cell


@pass_context
def _placed(context: Context, value: Any) -> str:
    """Keep a value out of the text until its structure is read."""
    placed: list[Any] = context["placed"]
    placed.append(value)
    return f"\x02{len(placed) - 1}\x03"


@pass_context
def _captioned(context: Context, table: Table | None, caller: Callable[[], str]) -> str:
    """A table with the words of a call block as its caption."""
    if table is None:
        return ""
    words = _resolved(caller(), context["placed"])
    return _placed(context, replace(table, caption=words))


def _definitions(pairs: Any) -> Definitions | None:
    return Definitions(tuple(pairs)) if pairs else None


def _resolved(text: str, placed: list[Any]) -> str:
    """A text on one line with its values in place."""

    def value(match: re.Match[str]) -> str:
        kept = placed[int(match[1])]
        if isinstance(kept, str) and "\x02" in kept:  # what another macro gave
            return _resolved(kept, placed)
        return "" if kept is None else str(kept)

    return _VALUE.sub(value, re.sub(r"\s*\n\s*", " ", text.strip(" \n")))


def _read(text: str, placed: list[Any]) -> tuple[Block, ...]:
    """Blocks of a text, whose values are `placed` in it."""
    whole: list[Block] = []
    within: list[tuple[int, Section, list[Block]]] = []  # open sections: depth, head, blocks

    def close(depth: int) -> None:
        while within and within[-1][0] >= depth:
            _, head, blocks = within.pop()
            if blocks:
                section = replace(head, blocks=tuple(blocks))
                (within[-1][2] if within else whole).append(section)

    for lines in _pieces(text, placed):
        target = within[-1][2] if within else whole
        mark, kept = _MARK.fullmatch(lines), _block_at(lines, placed)
        if mark and mark["hashes"]:
            close(len(mark["hashes"]))
            key, title = (_resolved(mark[name], placed) for name in ("key", "title"))
            head = Section(key, title, (), folded=bool(mark["fold"]))
            within.append((len(mark["hashes"]), head, []))
        elif mark and mark["tone"]:
            tone, callout = (_resolved(mark[name], placed) for name in ("tone", "callout"))
            target.append(Callout(tone, callout))
        elif mark:
            item = _resolved(mark["item"], placed)
            if target and isinstance(target[-1], Bullets):
                target[-1] = Bullets((*target[-1].items, item))
            else:
                target.append(Bullets((item,)))
        elif kept is not None:
            blocks = kept if isinstance(kept, tuple | list) else (kept,)
            target += (_worded(block, placed) for block in blocks)
        elif paragraph := _resolved(lines, placed):
            target.append(Paragraph(paragraph))
    close(0)
    return tuple(whole)


def _worded(block: Any, placed: list[Any]) -> Any:
    """A block whose caption another macro wrote, with the values of that."""
    if not isinstance(block, Table) or "\x02" not in block.caption:
        return block
    return replace(block, caption=_resolved(block.caption, placed))


def _block_at(line: str, placed: list[Any]) -> Any:
    """The block or blocks that a line stands for; None if it holds words."""
    alone = _VALUE.fullmatch(line)
    kept = placed[int(alone[1])] if alone else None
    return None if isinstance(kept, str | int | float) else kept


def _pieces(text: str, placed: list[Any]) -> list[str]:
    """Pieces between empty lines; what begins with a mark, or is a block, begins one."""
    pieces: list[str] = [""]
    for line in map(str.strip, text.splitlines()):
        if not line or _MARK.fullmatch(line):
            pieces.append(line)
        elif _block_at(line, placed) is not None:
            pieces += [line, ""]
        else:
            pieces[-1] = f"{pieces[-1]} {line}".strip()
    return [piece for piece in pieces if piece]
