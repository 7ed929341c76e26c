"""The content tree: what is said, in which order, without any layout.

Texts carry a light markup that every renderer knows: ``[@key]`` cites the bibliography, ``[#key]``
names a figure or table of the document by its number, and backticks mark code. All else is plain
text, which the renderers escape.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

from workbench.report.page.bibliography import Reference, reference_of

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
    should not be relied on. `brief` is what a screen shows of a long text, the whole at a pointer.
    """

    text: str
    sort: float | None = None
    tone: str = ""
    hatched: bool = False
    more: str = ""
    brief: str = ""


ABSENT = Cell("–", tone="muted")


@dataclass(frozen=True, slots=True)
class Column:
    """A table column: its `title`, whether it holds numbers, and its share of the `width`.

    `of` says where `Table.of` finds its cells: the name of an entry or attribute of a record, or
    a function of the record. It may give a `Cell`, a text, a number, or None for a dash.
    """

    title: str
    numeric: bool = False
    width: float = 1.0
    of: str | Callable[[Any], Cell | str | float | None] = field(default="", compare=False)

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
        if isinstance(value, float):
            return Cell(f"{value:.4g}", value)
        return Cell(str(value), value if isinstance(value, int) else None)


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a caption; `print_limit` rows at most appear on paper (None: all).

    `in_sight`, how many rows a screen shows before it is asked for the others (None: all);
    `number`, its place among the tables of a document, which gives it (0: outside of one).
    """

    key: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    print_limit: int | None = None
    in_sight: int | None = None
    number: int = 0
    kind: str = field(default="table", init=False)

    @classmethod
    def of(
        cls,
        key: str,
        caption: str,
        columns: Iterable[Column] | Mapping[str, Any],
        records: Iterable[Any],
        print_limit: int | None = None,
    ) -> Table:
        """A table with one row for each record, its cells as the columns find them.

        Columns may be given by title, with where they find their cells; they are numeric where
        all their cells are absent or have a value to sort by.
        """
        listed: list[Column] = []
        if isinstance(columns, Mapping):
            listed += (Column(title, of=of) for title, of in columns.items())
        else:
            listed += columns
        rows = tuple(tuple(column.cell(record) for column in listed) for record in records)
        heads = [replace(column, of="") for column in listed]
        if isinstance(columns, Mapping):
            cells = zip(*rows, strict=True) if rows else [()] * len(heads)
            numeric = [all(each is ABSENT or each.sort is not None for each in c) for c in cells]
            heads = [replace(h, numeric=n) for h, n in zip(heads, numeric, strict=True)]
        return cls(key, caption, tuple(heads), rows, print_limit)


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

        def numbered(block: Block) -> Block:
            if not isinstance(block, Table | Picture):
                return block
            counts[block.kind] += 1
            return replace(block, number=counts[block.kind])

        object.__setattr__(self, "sections", rewritten(self.sections, numbered))

    @cached_property
    def named(self) -> Mapping[str, str]:
        """``Figure 2`` or ``Table 3`` by key; of several with one key the first."""
        names: dict[str, str] = {}
        for block in walk(self.sections):
            if isinstance(block, Table | Picture):
                kind = "Table" if isinstance(block, Table) else "Figure"
                names.setdefault(block.key, f"{kind} {block.number}")
        return names

    @cached_property
    def references(self) -> tuple[Reference, ...]:
        """The works that the texts cite, in that order; they are numbered from one."""
        runs = (run for text in _texts(self.sections) for run in runs_of(text))
        keys = dict.fromkeys(run.text for run in runs if run.kind == "cite")
        return tuple(reference_of(key) for key in keys)

    def on_paper(self) -> Document:
        """The document without what is folded, which its last line names."""
        titles: list[str] = []

        def printed(block: Block) -> Block | None:
            if not (isinstance(block, Section) and block.folded):
                return block
            titles.append(block.title)
            return None

        sections = rewritten(self.sections, printed)
        if titles:
            text = f"In the electronic report alone: {'; '.join(titles)}."
            sections = (*sections, Section("folded", "More", (Paragraph(text),)))
        return replace(self, sections=sections)

    def marked(self, mark: str) -> Document:
        """The document with a mark before its title and before every caption."""
        sections: Any = marked(self.sections, mark)
        return replace(self, title=f"{mark}{self.title}", sections=sections)

    def number_of(self, key: str) -> int:
        """Number of a work that a text of this document cites."""
        return 1 + [reference.key for reference in self.references].index(key)


def rewritten(blocks: Iterable[Block], change: Callable[[Block], Block | None]) -> tuple[Any, ...]:
    """Blocks as `change` gives them, at any depth; those for which it gives None are left out."""
    copies: list[Block] = []
    for block in blocks:
        if (changed := change(block)) is None:
            continue
        if isinstance(changed, Section):
            changed = replace(changed, blocks=rewritten(changed.blocks, change))
        copies.append(changed)
    return tuple(copies)


def marked(blocks: Iterable[Block], mark: str) -> tuple[Block, ...]:
    """Blocks whose tables and pictures, at any depth, have captions that begin with a mark."""

    def change(block: Block) -> Block:
        if not isinstance(block, Table | Picture) or block.caption.startswith(mark):
            return block
        return replace(block, caption=f"{mark}{block.caption}")

    return rewritten(blocks, change)


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
