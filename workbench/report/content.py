"""The content tree of a report: what is said, in which order, without any layout.

Texts carry a light markup that every renderer knows: ``[@key]`` cites the bibliography and
backticks mark code. All else is plain text, which the renderers escape.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from workbench.report.bibliography import Reference

_MARKUP = re.compile(r"\[@(?P<cite>[A-Za-z0-9._-]+)\]|`(?P<code>[^`]+)`")


class Run(NamedTuple):
    """A piece of text: `kind` is plain, code or cite; for cite, `text` is the key."""

    kind: str
    text: str


def runs_of(text: str) -> Iterator[Run]:
    """Split a text into its plain, code and cite runs."""
    done = 0
    for match in _MARKUP.finditer(text):
        if match.start() > done:
            yield Run("plain", text[done : match.start()])
        kind = str(match.lastgroup)
        yield Run(kind, match.group(kind))
        done = match.end()
    if done < len(text):
        yield Run("plain", text[done:])


@dataclass(frozen=True, slots=True)
class Paragraph:
    """A paragraph of text."""

    text: str
    kind: ClassVar[str] = "paragraph"


@dataclass(frozen=True, slots=True)
class Bullets:
    """A list of short texts."""

    items: tuple[str, ...]
    kind: ClassVar[str] = "bullets"


@dataclass(frozen=True, slots=True)
class Callout:
    """A text that must not be overlooked; `tone` is good, bad, doubt or note."""

    tone: str
    text: str
    kind: ClassVar[str] = "callout"


@dataclass(frozen=True, slots=True)
class Cell:
    """A table cell: its `text`, the value it sorts by (None: its text), and its `tone`.

    Tones: empty, good, bad, doubt, muted.
    """

    text: str
    sort: float | None = None
    tone: str = ""


@dataclass(frozen=True, slots=True)
class Column:
    """A table column: its `title`, whether it holds numbers, and its share of the `width`."""

    title: str
    numeric: bool = False
    width: float = 1.0


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a caption; `print_limit` rows at most appear on paper (None: all)."""

    key: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    print_limit: int | None = None
    kind: ClassVar[str] = "table"


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure: `svg` text (empty if nothing could be drawn), caption, statements below it.

    `width` is its share of the text width; `files` are the names of data files beside it;
    `moving` is HTML that a screen shows instead of the SVG (empty: the SVG).
    """

    key: str
    title: str
    caption: str
    svg: str
    alt: str
    width: float = 1.0
    statements: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    moving: str = ""
    kind: ClassVar[str] = "picture"


@dataclass(frozen=True, slots=True)
class Listing:
    """Verbatim text under a title; collapsed on screen; `printed`, whether paper shows it."""

    title: str
    text: str
    printed: bool = True
    kind: ClassVar[str] = "listing"


@dataclass(frozen=True, slots=True)
class Definitions:
    """Terms with short texts, such as provenance or a model's options."""

    pairs: tuple[tuple[str, str], ...]
    kind: ClassVar[str] = "definitions"


@dataclass(frozen=True, slots=True)
class Section:
    """A titled part of the report; sections may hold sections."""

    key: str
    title: str
    blocks: tuple[Block, ...]
    kind: ClassVar[str] = "section"


Block = Paragraph | Bullets | Callout | Table | Picture | Listing | Definitions | Section


@dataclass(frozen=True, slots=True)
class Document:
    """A whole report: `facts` are short lines under the title; `references` are numbered."""

    title: str
    subtitle: str
    facts: tuple[str, ...]
    sections: tuple[Section, ...]
    references: tuple[Reference, ...]

    def number_of(self, key: str) -> int | None:
        """Number of a reference, None for a key that is not cited."""
        for number, reference in enumerate(self.references, start=1):
            if reference.key == key:
                return number
        return None


def walk(blocks: tuple[Block, ...]) -> Iterator[Block]:
    """All blocks of a tree, parents before children."""
    for block in blocks:
        yield block
        if isinstance(block, Section):
            yield from walk(block.blocks)
