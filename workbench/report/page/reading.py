"""Pages as printers read them: sections within sections, and the blocks of Markdown in them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Generic, NamedTuple, TypeVar

from markdown_it import MarkdownIt
from markdown_it.rules_inline import StateInline
from markdown_it.tree import SyntaxTreeNode as Node

from workbench.report.page.bibliography import reference_of
from workbench.report.page.markdown import KEY, printed

_MARK = re.compile(rf"\[(?:@(?P<cite>{KEY})|#(?P<see>{KEY})|!(?P<mark>[^\]]*))\]")
_RULES = (
    *("table", "blockquote", "list", "heading", "fence"),
    *("backticks", "emphasis", "escape", "entity", "newline"),
)
ELSEWHERE = "a figure or table of another form of this report"
_KINDS = {"table": "Table", "figure": "Figure"}

Form = TypeVar("Form")


class Run(NamedTuple):
    """A piece of text: `kind` is plain, code, em, strong, cite or see; for the last two, a key."""

    kind: str
    text: str


Runs = tuple[Run, ...]


class Words(NamedTuple):
    """A text that may begin with a mark: the words of that by name, and the runs."""

    mark: Mapping[str, str]
    runs: Runs


@dataclass(frozen=True)
class PageSection:
    """A titled part of a page and all that stands in it; `folded`: it opens on demand."""

    key: str
    title: Runs
    blocks: tuple[Block, ...]
    folded: bool


@dataclass(frozen=True)
class Quote:
    """Quote that stands apart: the words it begins with, and further nodes."""

    kind: str  # table, figure, definitions or the tone of a callout
    words: Words
    nodes: tuple[Node, ...]

    @property
    def key(self) -> str:
        """The key of a table or figure."""
        return self.words.mark.get(self.kind, "")

    @property
    def items(self) -> list[Words]:
        """The items of its list: statements below a figure, definitions with their terms."""
        return [item for node in self.nodes for item in items_of(node)]

    @property
    def numeric(self) -> list[bool]:
        """Which columns of a table hold numbers."""
        return ["right" in str(cell.attrs.get("style")) for cell in self._grid[0].children]

    @property
    def widths(self) -> list[float]:
        """Shares of the columns of a table in its width."""
        stated = self.words.mark.get("widths")
        return [float(w) for w in stated.split(",")] if stated else [1.0] * len(self.titles)

    @property
    def titles(self) -> list[Runs]:
        """Titles of the columns of a table."""
        return [words_of(cell).runs for cell in self._grid[0].children]

    @property
    def rows(self) -> list[list[Words]]:
        """Cells of a table, row by row."""
        return [[words_of(cell) for cell in row.children] for row in self._grid[1:]]

    @property
    def _grid(self) -> list[Node]:
        (table,) = self.nodes
        return [row for part in table.children for row in part.children]

    def whole(self, name: str) -> int | None:
        """A whole number of its mark."""
        value = self.words.mark.get(name)
        return None if value is None else int(value)


Block = PageSection | Quote | Node


@cache
def _parser() -> MarkdownIt:
    parser = MarkdownIt("zero").enable(_RULES)
    parser.inline.ruler.push("mark", _read_mark)
    return parser


def _read_mark(state: StateInline, silent: bool) -> bool:
    match = _MARK.match(state.src, state.pos)
    if match is None:
        return False
    if not silent:
        kind = str(match.lastgroup)
        state.push(kind, "", 0).content = match[kind]
    state.pos = match.end()
    return True


def read(text: str) -> tuple[Block, ...]:
    """The blocks of a page; sections without content are left out.

    A heading ends the sections of its depth and below; one that is marked ``[!/]`` does no more.
    """
    whole: list[Block] = []
    within: list[tuple[int, Node, list[Block]]] = []  # open sections: depth, head, blocks

    def close(depth: int) -> None:
        while within and within[-1][0] >= depth:
            _, head, blocks = within.pop()
            if blocks:
                mark, title = words_of(head)
                key, *words = (*mark, "")
                section = PageSection(key, title, tuple(blocks), "folded" in words)
                (within[-1][2] if within else whole).append(section)

    for node in Node(_parser().parse(text)).children:
        if node.type == "heading":
            depth = int(node.tag[1])
            close(depth)
            if "/" not in words_of(node).mark:
                within.append((depth, node, []))
        else:
            (within[-1][2] if within else whole).append(
                _quote(node) if node.type == "blockquote" else node
            )
    close(0)
    return tuple(whole)


def _quote(node: Node) -> Quote:
    words = words_of(node)
    return Quote(next(iter(words.mark), "note"), words, tuple(node.children[1:]))


def words_of(node: Node) -> Words:
    """The first text in a node."""
    inline = next((each for each in node.walk() if each.type == "inline"), None)
    nodes = [] if inline is None else inline.children
    mark: dict[str, str] = {}
    if nodes and nodes[0].type == "mark":
        pairs = (word.partition("=") for word in nodes[0].content.split())
        mark = {printed(name): printed(value) for name, _, value in pairs}
        nodes = nodes[1:]
    runs = [run for each in nodes for run in _runs(each)]
    if mark and runs:
        runs[0] = Run(runs[0].kind, runs[0].text.removeprefix(" "))
    return Words(mark, tuple(run for run in runs if run.text))


def _runs(node: Node) -> Iterator[Run]:
    if node.type in ("em", "strong"):
        yield Run(node.type, "".join(text for each in node.children for _, text in _runs(each)))
    elif node.type in ("softbreak", "hardbreak"):
        yield Run("plain", " ")
    elif node.type in ("cite", "see"):
        yield Run(node.type, node.content)
    else:
        yield Run("code" if node.type == "code_inline" else "plain", printed(node.content))


def items_of(node: Node) -> list[Words]:
    """The items of a list."""
    items = node.children if node.type.endswith("_list") else []
    for item in items:
        _hold_no_more("item of a list", item.children[1:])
    return [words_of(item) for item in items]


def _hold_no_more(what: str, nodes: Sequence[Node]) -> None:
    """Raises `ValueError` for a template that no printer would show in full."""
    if nodes:
        raise ValueError(f"a {what} on a page is one paragraph, and no {nodes[0].type}")


def walk(blocks: Iterable[Block]) -> Iterator[Block]:
    """All blocks of a page, sections before what stands in them."""
    for block in blocks:
        yield block
        if isinstance(block, PageSection):
            yield from walk(block.blocks)


def named(blocks: Iterable[Block]) -> dict[str, str]:
    """``Figure 2`` or ``Table 3`` by key, in the order in which they are read.

    Of several with one key the first.
    """
    names: dict[str, str] = {}
    counts = dict.fromkeys(_KINDS, 0)
    for block in walk(blocks):
        if isinstance(block, Quote) and block.kind in _KINDS:
            counts[block.kind] += 1
            names.setdefault(block.key, f"{_KINDS[block.kind]} {counts[block.kind]}")
    return names


def callouts(text: str) -> list[tuple[str, str]]:
    """The callouts of a page, each by its tone and its text."""
    back = {"code": "`{}`", "cite": "[@{}]", "see": "[#{}]"}
    return [
        (
            block.kind,
            "".join(back.get(kind, "{}").format(words) for kind, words in block.words.runs),
        )
        for block in walk(read(text))
        if isinstance(block, Quote) and block.kind not in (*_KINDS, "definitions")
    ]


def cites(blocks: Iterable[Block]) -> list[str]:
    """The keys of the works that texts cite, in that order."""
    keys: dict[str, None] = {}
    for block in walk(blocks):
        if isinstance(block, PageSection):
            runs: Iterable[Run] = block.title
        elif isinstance(block, Quote):
            rest = (node for each in block.nodes for node in each.walk())
            keys |= {run.text: None for run in block.words.runs if run.kind == "cite"}
            runs = (Run("cite", node.content) for node in rest if node.type == "cite")
        else:
            runs = (Run("cite", node.content) for node in block.walk() if node.type == "cite")
        keys |= {run.text: None for run in runs if run.kind == "cite"}
    return list(keys)


def spoken(runs: Iterable[Run], names: Mapping[str, str] | None = None) -> str:
    """A text for pages without links: citations become author and year.

    `names` are the figures and tables of the document by key.
    """
    read: dict[str, Any] = {
        "code": "`{}`".format,
        "cite": lambda key: f"({reference_of(key).short})",
        "see": lambda key: (names or {}).get(key, ELSEWHERE),
    }
    return "".join(read.get(kind, str)(text) for kind, text in runs)


class Printer(Generic[Form]):
    """A form of a page; its methods say how each kind of block looks.

    They are ``_section(section, level)``, ``_paragraph(runs)``, ``_bullets(texts)``,
    ``_callout(tone, runs)``, ``_definitions(pairs)``, ``_listing(title, text, on_paper)``,
    ``_figure(quote, name)`` and ``_table(quote, name)``; figures and tables are counted.
    """

    def __init__(self) -> None:
        self._counts = dict.fromkeys(_KINDS, 0)

    def numbered(self, block: Quote) -> str:
        """The name of the next figure or table."""
        self._counts[block.kind] += 1
        return f"{_KINDS[block.kind]} {self._counts[block.kind]}"

    def block(self, block: Block, level: int = 1) -> Form:
        """A block; sections have a level."""
        kind, *values = self._parts(block, level)
        form: Form = getattr(self, f"_{kind}")(*values)
        return form

    def _parts(self, block: Block, level: int) -> tuple[Any, ...]:
        """The kind of a block and what its method takes."""
        if isinstance(block, PageSection):
            return "section", block, level
        if isinstance(block, Quote):
            if block.kind in _KINDS:
                return block.kind, block, self.numbered(block)
            if block.kind == "definitions":
                return "definitions", [(next(iter(i.mark), ""), i.runs) for i in block.items]
            _hold_no_more("callout", block.nodes)
            return "callout", block.kind, block.words.runs
        if block.type == "fence":
            place, _, title = block.info.strip().partition(" ")
            text = printed(block.content).removesuffix("\n")
            return "listing", printed(title), text, place != "screen"
        if items := items_of(block):
            return "bullets", [item.runs for item in items]
        return "paragraph", words_of(block).runs
