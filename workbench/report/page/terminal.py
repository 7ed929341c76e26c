"""A page as text on a terminal."""

import io
import sys
from collections.abc import Iterable, Iterator

from rich import box
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table as Grid
from rich.text import Text

from workbench.report.page.markdown import literal
from workbench.report.page.reading import Block, PageSection, Printer, Quote, Runs, read, spoken

_STYLES = {"good": "green", "bad": "red", "doubt": "yellow", "muted": "dim"}
_UNBOUNDED = 100_000  # columns of a file or a pipe, where no line is broken


def show(*blocks: object) -> None:
    """Print blocks of a page on the output stream: coloured and fitted to the width of a terminal.

    A pipe or file gets plain text, every row of a table on one line.
    """
    colour = sys.stdout.isatty()
    console = Console(file=sys.stdout) if colour else None
    width = console.width if console is not None else _UNBOUNDED
    sys.stdout.write(render_text(*blocks, width=width, colour=colour))


def render_text(*blocks: object, width: int = _UNBOUNDED, colour: bool = False) -> str:
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
    for content in _Terminal().apart(read(literal(blocks))):
        console.print(content)
    lines = target.getvalue().splitlines()
    return "".join(line.rstrip() + "\n" for line in lines).removeprefix("\n")


class _Terminal(Printer[RenderableType]):
    """Renderables of blocks."""

    def apart(self, blocks: Iterable[Block]) -> Iterator[RenderableType]:
        """Blocks with an empty line around each table and before each section."""
        apart = False
        for number, block in enumerate(blocks):
            wide = isinstance(block, Quote) and block.kind == "table"
            if isinstance(block, PageSection) or (number and (wide or apart)):
                yield Text("")
            apart = wide
            yield self.block(block)

    def _section(self, section: PageSection, level: int) -> RenderableType:
        title = [Text(spoken(section.title), style="bold")] * bool(section.title)
        return Group(*title, *self.apart(section.blocks))

    def _paragraph(self, runs: Runs) -> RenderableType:
        return Text(spoken(runs))

    def _bullets(self, items: list[Runs]) -> RenderableType:
        return _pairs((("-", item) for item in items), gap=1)

    def _callout(self, tone: str, runs: Runs) -> RenderableType:
        return Text(spoken(runs), style=_STYLES.get(tone, ""))

    def _definitions(self, pairs: list[tuple[str, Runs]]) -> RenderableType:
        return _pairs(pairs, gap=2)

    def _listing(self, title: str, text: str, on_paper: bool) -> RenderableType:
        return Group(Text(title), Padding(Text(text), (0, 0, 0, 2), expand=False))

    def _figure(self, figure: Quote, name: str) -> RenderableType:
        return Text(spoken(figure.words.runs))

    def _table(self, table: Quote, name: str) -> RenderableType:
        caption = [Text(spoken(table.words.runs))] * bool(table.words.runs)
        grid = Grid(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
        for title, numeric in zip(table.titles, table.numeric, strict=True):
            grid.add_column(
                Text(spoken(title)),
                justify="right" if numeric else "left",
                overflow="fold",
                no_wrap=numeric,
            )
        for row in table.rows:
            texts = (spoken(cell.runs).replace("\n", " ") for cell in row)
            styles = (_STYLES.get(cell.mark.get("tone", ""), "") for cell in row)
            grid.add_row(*map(Text, texts, styles))
        return Group(*caption, grid)


def _pairs(pairs: Iterable[tuple[str, Runs]], gap: int) -> RenderableType:
    grid = Grid.grid(padding=(0, gap, 0, 0))
    grid.add_column(no_wrap=True)
    grid.add_column()
    for first, second in pairs:
        grid.add_row(Text(first), Text(spoken(second)))
    return Padding(grid, (0, 0, 0, 2), expand=False)
