"""A content tree as Markdown, as hosts of git repositories show it."""

from collections.abc import Iterator

from workbench.content import tree
from workbench.content.tree import Block, Cell, Document, Section, Table, spoken

_MARKS = {"good": "✅ ", "bad": "❌ ", "doubt": "❔ "}


def render_markdown(document: Document) -> str:
    """Markdown text of a content tree; its facts stand at the foot, sections may lack a title.

    Citations become author and year. Equal trees give equal text.
    """
    lines = [f"# {escaped(document.title)}", ""]
    for section in document.sections:
        lines += _block(section, 2)
    return "\n".join([*lines, "---", "", *map(escaped, document.facts)]) + "\n"


def escaped(text: str) -> str:
    """A text of the tree as Markdown: table bars and tags are escaped, line ends are blanks."""
    return spoken(text).replace("<", "&lt;").replace("|", "\\|").replace("\n", " ")


def _block(block: Block, level: int) -> Iterator[str]:
    """Lines of a block, an empty one at its end."""
    match block:
        case Section():
            if block.title:
                yield from (f"{'#' * level} {escaped(block.title)}", "")
            for inner in block.blocks:
                yield from _block(inner, level + 1)
            return
        case tree.Paragraph():
            yield escaped(block.text)
        case tree.Bullets():
            yield from (f"- {escaped(item)}" for item in block.items)
        case tree.Callout():
            yield f"> {escaped(block.text)}"
        case tree.Definitions():
            yield from (f"- {escaped(term)}: {escaped(text)}" for term, text in block.pairs)
        case tree.Listing():
            yield from (escaped(block.title), "", "```", block.text, "```")
        case tree.Picture():
            yield from (f"![{escaped(block.alt)}]({block.image})", "", escaped(block.caption))
            if block.statements:
                yield ""
            yield from (f"- {escaped(statement)}" for statement in block.statements)
        case Table():
            if block.caption:
                yield from (escaped(block.caption), "")
            yield _row(escaped(column.title) for column in block.columns)
            yield "|" + "|".join("---:" if c.numeric else "---" for c in block.columns) + "|"
            yield from (_row(map(_cell, row)) for row in block.rows)
    yield ""


def _cell(cell: Cell) -> str:
    hatch = "▨ " if cell.hatched else ""
    return _MARKS.get(cell.tone, "") + hatch + escaped(cell.text)


def _row(cells: Iterator[str]) -> str:
    return f"| {' | '.join(cells)} |"
