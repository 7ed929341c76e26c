"""The content tree: what is said, in which order, without any layout.

Texts carry a light markup that every renderer knows: ``[@key]`` cites the bibliography, ``[#key]``
names a figure or table of the document by its number, and backticks mark code. All else is plain
text, which the renderers escape.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

from workbench.content.bibliography import Reference, reference_of

_KEY = r"[A-Za-z0-9._-]+"
_MARKUP = re.compile(rf"\[@(?P<cite>{_KEY})\]|\[#(?P<see>{_KEY})\]|`(?P<code>[^`]+)`")
ELSEWHERE = "a figure or table of another form of this report"


class Run(NamedTuple):
    """A piece of text: `kind` is plain, code, cite or see; for these two, `text` is the key."""

    kind: str
    text: str


def runs_of(text: str) -> Iterator[Run]:
    """Split a text into its plain, code, cite and see runs."""
    done = 0
    for match in _MARKUP.finditer(text):
        if match.start() > done:
            yield Run("plain", text[done : match.start()])
        kind = str(match.lastgroup)
        yield Run(kind, match.group(kind))
        done = match.end()
    if done < len(text):
        yield Run("plain", text[done:])


def spoken(text: str, named: Mapping[str, str] | None = None) -> str:
    """A text for renderers without links: citations become author and year.

    `named` are the figures and tables of the document by key, see `Document.named`.
    """
    read: dict[str, Callable[[str], str]] = {
        "plain": str,
        "code": "`{}`".format,
        "cite": lambda key: f"({reference_of(key).short})",
        "see": lambda key: (named or {}).get(key, ELSEWHERE),
    }
    return "".join(read[kind](content) for kind, content in runs_of(text))


@dataclass(frozen=True, slots=True)
class Paragraph:
    """A paragraph of text."""

    text: str
    kind: str = field(default="paragraph", init=False)


@dataclass(frozen=True, slots=True)
class Bullets:
    """A list of short texts."""

    items: tuple[str, ...]
    kind: str = field(default="bullets", init=False)


@dataclass(frozen=True, slots=True)
class Callout:
    """A text that must not be overlooked; `tone` is good, bad, doubt or note."""

    tone: str
    text: str
    kind: str = field(default="callout", init=False)


@dataclass(frozen=True, slots=True)
class Cell:
    """A table cell: its `text`, the value it sorts by (None: its text), and its `tone`.

    Tones: empty, good, bad, doubt, muted. Of several lines the first one is the statement, the
    others are details; `more` is shown where a pointer rests. A `hatched` cell holds a number that
    should not be relied on.
    """

    text: str
    sort: float | None = None
    tone: str = ""
    hatched: bool = False
    more: str = ""


ABSENT = Cell("–", tone="muted")


@dataclass(frozen=True, slots=True)
class Column:
    """A table column: its `title`, whether it holds numbers, and its share of the `width`.

    `of` says where `Table.of` finds its cells: the name of an entry or attribute of a record, or
    a function of the record. It may give a `Cell`, a text, a whole number, or None for a dash.
    """

    title: str
    numeric: bool = False
    width: float = 1.0
    of: str | Callable[[Any], Cell | str | int | None] = field(default="", compare=False)

    def cell(self, record: Any) -> Cell:
        """The cell of this column in the row of a record."""
        if callable(self.of):
            value = self.of(record)
        elif isinstance(record, Mapping):
            value = record[self.of]
        else:
            value = getattr(record, self.of)
        if isinstance(value, Cell):
            return value
        if value is None:
            return ABSENT
        return Cell(str(value), value if isinstance(value, int) else None)


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a caption; `print_limit` rows at most appear on paper (None: all).

    `number`, its place among the tables of a document, which gives it (0: outside of one).
    """

    key: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    print_limit: int | None = None
    number: int = 0
    kind: str = field(default="table", init=False)

    @property
    def name(self) -> str:
        """How texts call it: ``Table 3``; empty outside of a document."""
        return f"Table {self.number}" if self.number else ""

    @classmethod
    def of(
        cls,
        key: str,
        caption: str,
        columns: Iterable[Column],
        records: Iterable[Any],
        print_limit: int | None = None,
    ) -> Table:
        """A table with one row for each record, its cells as the columns find them."""
        columns = tuple(columns)
        rows = tuple(tuple(column.cell(record) for column in columns) for record in records)
        heads = tuple(replace(column, of="") for column in columns)
        return cls(key, caption, heads, rows, print_limit)


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure: `svg` text (empty if nothing could be drawn), caption, statements below it.

    `width` is its share of the text width; `files` are the names of data files beside it;
    `image` is the path of an image file for renderers that hold no SVG; `number`, its place among
    the figures of a document, which gives it (0: outside of one).
    """

    key: str
    title: str
    caption: str
    svg: str
    alt: str
    width: float = 1.0
    statements: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    image: str = ""
    number: int = 0
    kind: str = field(default="picture", init=False)

    @property
    def name(self) -> str:
        """How texts call it: ``Figure 3``; empty outside of a document."""
        return f"Figure {self.number}" if self.number else ""


@dataclass(frozen=True, slots=True)
class Listing:
    """Verbatim text under a title; collapsed on screen; `printed`, whether paper shows it."""

    title: str
    text: str
    printed: bool = True
    kind: str = field(default="listing", init=False)


@dataclass(frozen=True, slots=True)
class Definitions:
    """Terms with short texts, such as provenance or a model's options."""

    pairs: tuple[tuple[str, str], ...]
    kind: str = field(default="definitions", init=False)


@dataclass(frozen=True, slots=True)
class Section:
    """A titled part of the report; sections may hold sections.

    One that is `folded` opens on demand on a screen; paper leaves it out and names it.
    """

    key: str
    title: str
    blocks: tuple[Block, ...]
    folded: bool = False
    kind: str = field(default="section", init=False)


Block = Paragraph | Bullets | Callout | Table | Picture | Listing | Definitions | Section


@dataclass(frozen=True)
class Document:
    """A whole report: `facts` are short lines on what it holds and what it is made of.

    Its figures and tables get their numbers here, in the order in which they are read.
    `beside` are files in its folder that a screen links to, each with what it is.
    """

    title: str
    subtitle: str
    facts: tuple[str, ...]
    sections: tuple[Section, ...]
    beside: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        counts = Counter[str]()

        def numbered(block: Any) -> Any:
            if isinstance(block, Section):
                return replace(block, blocks=tuple(map(numbered, block.blocks)))
            if isinstance(block, Table | Picture):
                counts[block.kind] += 1
                return replace(block, number=counts[block.kind])
            return block

        object.__setattr__(self, "sections", tuple(map(numbered, self.sections)))

    @cached_property
    def named(self) -> Mapping[str, str]:
        """``Figure 2`` or ``Table 3`` by key; of several with one key the first."""
        names: dict[str, str] = {}
        for block in walk(self.sections):
            if isinstance(block, Table | Picture):
                names.setdefault(block.key, block.name)
        return names

    @cached_property
    def references(self) -> tuple[Reference, ...]:
        """The works that the texts cite, in that order; they are numbered from one."""
        runs = (run for text in _texts(self.sections) for run in runs_of(text))
        keys = dict.fromkeys(run.text for run in runs if run.kind == "cite")
        return tuple(reference_of(key) for key in keys)

    def on_paper(self) -> Document:
        """The document without what is folded, which its last line names."""
        sections = [part for part in unfolded(self.sections) if isinstance(part, Section)]
        titles = [b.title for b in walk(self.sections) if isinstance(b, Section) and b.folded]
        if titles:
            text = f"In the electronic report alone: {'; '.join(titles)}."
            sections.append(Section("folded", "More", (Paragraph(text),)))
        return replace(self, sections=tuple(sections))

    def marked(self, mark: str) -> Document:
        """The document with a mark before its title and before every caption."""
        sections = tuple(replace(part, blocks=marked(part.blocks, mark)) for part in self.sections)
        return replace(self, title=f"{mark}{self.title}", sections=sections)

    def number_of(self, key: str) -> int:
        """Number of a work that a text of this document cites."""
        return 1 + [reference.key for reference in self.references].index(key)


def marked(blocks: Iterable[Block], mark: str) -> tuple[Block, ...]:
    """Blocks whose tables and pictures, at any depth, have captions that begin with a mark."""
    copies: list[Block] = []
    for block in blocks:
        if isinstance(block, Section):
            block = replace(block, blocks=marked(block.blocks, mark))
        elif isinstance(block, (Table, Picture)) and not block.caption.startswith(mark):
            block = replace(block, caption=f"{mark}{block.caption}")
        copies.append(block)
    return tuple(copies)


def folded(blocks: tuple[Block, ...], keys: Collection[str]) -> tuple[Block, ...]:
    """Blocks whose sections of some keys, at any depth, are folded."""
    return tuple(
        replace(each, blocks=folded(each.blocks, keys), folded=each.key in keys)
        if isinstance(each, Section)
        else each
        for each in blocks
    )


def unfolded(blocks: tuple[Block, ...]) -> tuple[Block, ...]:
    """Blocks without their folded sections."""
    return tuple(
        replace(each, blocks=unfolded(each.blocks)) if isinstance(each, Section) else each
        for each in blocks
        if not (isinstance(each, Section) and each.folded)
    )


def walk(blocks: tuple[Block, ...]) -> Iterator[Block]:
    """All blocks of a tree, parents before children."""
    for block in blocks:
        yield block
        if isinstance(block, Section):
            yield from walk(block.blocks)


def _texts(blocks: tuple[Block, ...]) -> Iterator[str]:
    """All texts with markup, in the order of the tree."""
    for block in walk(blocks):
        match block:
            case Paragraph(text=text) | Callout(text=text):
                yield text
            case Bullets():
                yield from block.items
            case Definitions():
                yield from (text for _, text in block.pairs)
            case Table():
                yield block.caption
                yield from (column.title for column in block.columns)
                yield from (cell.text for row in block.rows for cell in row)
            case Picture():
                yield block.caption
                yield from block.statements
