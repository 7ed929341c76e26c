"""A content tree as text on a terminal."""

import io
import sys
from collections.abc import Iterable, Iterator

from rich import box
from rich.console import Console, RenderableType
from rich.padding import Padding
from rich.table import Table as Grid
from rich.text import Text

from workbench.report.page import tree
from workbench.report.page.tree import Block, Section, Table, spoken

_STYLES = {"good": "green", "bad": "red", "doubt": "yellow", "muted": "dim"}
_UNBOUNDED = 100_000  # columns of a file or a pipe, where no line is broken


def show(*blocks: Block) -> None:
    """Print blocks on the output stream: coloured and fitted to the width of a terminal.

    A pipe or file gets plain text, every row of a table on one line.
    """
    colour = sys.stdout.isatty()
    console = Console(file=sys.stdout) if colour else None
    width = console.width if console is not None else _UNBOUNDED
    sys.stdout.write(render_text(*blocks, width=width, colour=colour))


def render_text(*blocks: Block, width: int = _UNBOUNDED, colour: bool = False) -> str:
    """Text of blocks within `width` columns; `colour` marks tones by escape sequences."""
    target = io.StringIO()
    console = Console(
        file=target,
        width=width,
        force_terminal=colour,
        color_system="standard" if colour else None,
        highlight=False,
        markup=False,
        emoji=False,
    )
    for content in _all(blocks):
        console.print(content)
    lines = target.getvalue().splitlines()
    return "".join(line.rstrip() + "\n" for line in lines).removeprefix("\n")


def _all(blocks: tuple[Block, ...]) -> Iterator[RenderableType]:
    """Blocks with an empty line around each table and before each section."""
    apart = False
    for number, block in enumerate(blocks):
        wide = isinstance(block, Table)
        if isinstance(block, Section) or (number and (wide or apart)):
            yield Text("")
        apart = wide
        yield from _block(block)


def _block(block: Block) -> Iterator[RenderableType]:
    match block:
        case Section():
            if block.title:
                yield Text(spoken(block.title), style="bold")
            yield from _all(block.blocks)
        case tree.Paragraph():
            yield Text(spoken(block.text))
        case tree.Callout():
            yield Text(spoken(block.text), style=_STYLES.get(block.tone, ""))
        case tree.Bullets():
            yield _pairs((("-", item) for item in block.items), gap=1)
        case tree.Definitions():
            yield _pairs(block.pairs, gap=2)
        case tree.Listing():
            yield Text(spoken(block.title))
            yield Padding(Text(block.text), (0, 0, 0, 2), expand=False)
        case tree.Picture():
            yield Text(spoken(block.alt))
        case Table():
            yield from _table(block)


def _pairs(pairs: Iterable[tuple[str, str]], gap: int) -> RenderableType:
    grid = Grid.grid(padding=(0, gap, 0, 0))
    grid.add_column(no_wrap=True)
    grid.add_column()
    for first, second in pairs:
        grid.add_row(Text(first), Text(spoken(second)))
    return Padding(grid, (0, 0, 0, 2), expand=False)


def _table(block: Table) -> Iterator[RenderableType]:
    if block.caption:
        yield Text(spoken(block.caption))
    grid = Grid(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for column in block.columns:
        grid.add_column(
            Text(column.title),
            justify="right" if column.numeric else "left",
            overflow="fold",
            no_wrap=column.numeric,
        )
    for row in block.rows:
        texts = ((spoken(c.text).replace("\n", " "), _STYLES.get(c.tone, "")) for c in row)
        grid.add_row(*(Text(text, style=style) for text, style in texts))
    yield grid
