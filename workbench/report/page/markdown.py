"""Markdown of pages: paragraphs, lists, callouts, tables and figures, without any layout.

CommonMark with pipe tables, and marks in square brackets: ``[@key]`` cites the bibliography,
``[#key]`` names a figure or table by its number, and ``[!words]`` at the beginning of a heading,
quote, list item or cell says what that is. Quotes are what stands apart: callouts by their tone,
tables and figures by their key, definitions.

Values are never read as structure: their signs have a place of their own in Unicode until they are
printed. Code between backticks, ``[@key]`` and ``[#key]`` are understood in values too.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from markupsafe import Markup

if TYPE_CHECKING:
    import pandas as pd

Markdown: TypeAlias = Markup

KEY = r"[A-Za-z0-9._-]+"
_LIGHT = re.compile(rf"(\[[@#]{KEY}\])|`([^`]+)`")
_SIGNS = {sign: 0xE000 + sign for sign in range(128) if not chr(sign).isalnum()}
_PRINTED = {place: sign for sign, place in _SIGNS.items()}
_BREAK = re.compile(r"\s*\n\s*")
MOST_ROWS = 5_000  # of a table on a page


def coded(text: str) -> str:
    """A text without a sign that Markdown reads."""
    return text.translate(_SIGNS)


def printed(text: str) -> str:
    """A text of Markdown as it is printed, with the signs of its values."""
    return text.translate(_PRINTED)


def literal(value: object) -> Markdown:
    """Markdown of a value: of blocks as they are, of texts all signs but code and keys coded."""
    if hasattr(value, "__html__"):
        return Markdown(value.__html__())
    if isinstance(value, list | tuple):
        return Markdown("".join(map(literal, value)))
    text, done, parts = "" if value is None else str(value), 0, []
    for match in _LIGHT.finditer(text):
        mark = match[1] or f"`{coded(match[2])}`"
        parts += [coded(text[done : match.start()]), mark]
        done = match.end()
    return Markdown("".join([*parts, coded(text[done:])]))


def line(text: object) -> Markdown:
    """Markdown of a text on one line."""
    return Markdown(_BREAK.sub(" ", literal(text).strip(" \n")))


def paragraph(text: object) -> Markdown:
    """A paragraph of text."""
    return _apart(line(text))


def bullets(items: Iterable[object]) -> Markdown:
    """A list of short texts."""
    return _apart(*(f"- {line(item)}" for item in items))


def callout(tone: str, text: object) -> Markdown:
    """A text that must not be overlooked; `tone` is good, bad, doubt or note."""
    return _apart(f"> [!{tone}] {line(text)}")


def warnings(findings: Iterable[Any], source: str = "") -> Iterator[Block]:
    """Findings as callouts; `source`, whose they are."""
    for finding in findings:
        yield callout("doubt", f"warning{source} ({finding.subject}): {finding}")


def definitions(pairs: Iterable[tuple[str, object]]) -> Markdown:
    """Terms with short texts, such as provenance or a model's options; nothing without one."""
    lines = [f"> - [!{coded(term)}] {line(text)}" for term, text in pairs]
    return _apart("> [!definitions]", ">", *lines) if lines else Markdown()


def listing(title: str, text: str, *, on_paper: bool = True) -> Markdown:
    """Verbatim text under a title, collapsed on screen."""
    place = "everywhere" if on_paper else "screen"
    return _apart(f"~~~ {place} {coded(title)}", *map(coded, text.splitlines()), "~~~")


def section(
    key: str, title: object, *blocks: object, level: int = 1, folded: bool = False
) -> Markdown:
    """A titled part of a page; one that is `folded` opens on demand, and paper only names it."""
    mark = coded(key) + (" folded" if folded else "")
    return _apart(f"{'#' * level} [!{mark}] {line(title)}") + literal(blocks)


def _apart(*lines: str) -> Markdown:
    return Markdown("\n".join(("", *lines, "", "")))


def _marked(**words: Any) -> str:
    """The words of a mark; those that are None or empty are left out."""
    known = {name: value for name, value in words.items() if value not in (None, "", False)}
    return " ".join(n if v is True else f"{n}={coded(str(v))}" for n, v in known.items())


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

    def __html__(self) -> str:
        """Markdown of the cell."""
        words = {"tone": self.tone, "hatched": self.hatched, "more": self.more}
        mark = _marked(
            **words, brief=self.brief, sort=None if self.sort is None else f"{self.sort}"
        )
        return f"[!{mark}] {line(self.text)}" if mark else line(self.text)


ABSENT = Cell("–", tone="muted")


@dataclass(frozen=True, slots=True)
class PageColumn:
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
        if isinstance(value, str):
            return Cell(value)
        return Cell(str(value), value if isinstance(value, int) else None)


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a caption; `limit` rows at most appear on paper (None: all).

    `in_sight`, how many rows a screen shows before it is asked for the others (None: all).
    """

    key: str
    caption: str
    columns: tuple[PageColumn, ...]
    rows: tuple[tuple[Cell, ...], ...]
    limit: int | None = None
    in_sight: int | None = None

    @classmethod
    def of(
        cls,
        key: str,
        caption: str,
        columns: Iterable[PageColumn] | Mapping[str, Any],
        records: Iterable[Any] | pd.DataFrame,
        limit: int | None = None,
    ) -> Table:
        """A table with one row for each record, its cells as the columns find them.

        A data frame is read by its rows, in which numbers that are not known are None.
        Columns may be given by title, with where they find their cells; they are numeric where
        all their cells are absent or have a value to sort by.
        """
        listed: list[PageColumn] = []
        if isinstance(columns, Mapping):
            listed += (PageColumn(title, of=of) for title, of in columns.items())
        else:
            listed += columns
        listing: Any = records
        if hasattr(listing, "itertuples"):
            from workbench.base.tables import plain_rows

            listing = plain_rows(listing)
        listing = list(listing)
        if len(listing) > MOST_ROWS:
            caption += f" The first {MOST_ROWS} of {len(listing)} rows; the stored tables hold all."
        shown = listing[:MOST_ROWS]
        rows = tuple(tuple(column.cell(record) for column in listed) for record in shown)
        heads = [replace(column, of="") for column in listed]
        if isinstance(columns, Mapping):
            cells = zip(*rows, strict=True) if rows else [()] * len(heads)
            numeric = [all(each is ABSENT or each.sort is not None for each in c) for c in cells]
            heads = [replace(h, numeric=n) for h, n in zip(heads, numeric, strict=True)]
        return cls(key, caption, tuple(heads), rows, limit)

    def __html__(self) -> str:
        """Markdown of the table."""
        widths = ",".join(f"{column.width}" for column in self.columns)
        mark = _marked(table=self.key, widths=widths, limit=self.limit, in_sight=self.in_sight)
        grid: list[list[str]] = [
            [line(column.title) for column in self.columns],
            ["---:" if column.numeric else "---" for column in self.columns],
            *([cell.__html__() for cell in row] for row in self.rows),
        ]
        rows = (f"> | {' | '.join(cells)} |" for cells in grid)
        return _apart(f"> [!{mark}] {line(self.caption)}", ">", *rows)


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure: `svg` text (empty if nothing could be drawn), caption, statements below it.

    `width` is its share of the text width; `files` are the names of data files beside it;
    `image` is the path of an image file for pages that hold no SVG.
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

    def __html__(self) -> str:
        """Markdown of the figure, whose picture a document holds by its key."""
        words = (*self.statements, *(f"Numbers: `{name}`" for name in self.files))
        items = (f"> - {line(text)}" for text in words)
        return _apart(f"> [!{_marked(figure=self.key)}] {line(self.caption)}", ">", *items)


Block = Markdown | Table


def before_captions(text: Markdown, words: str) -> Markdown:
    """A page whose tables and figures have captions that begin with words."""
    mark = re.compile(rf"^(> \[!(?:table|figure)=[^\]]*\] )(?!{re.escape(coded(words))})", re.M)
    return Markdown(mark.sub(lambda found: found[1] + coded(words), text))
