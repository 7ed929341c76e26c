"""A content tree as Markdown, as hosts of git repositories show it."""

from collections.abc import Callable, Iterator

from workbench.content import tree
from workbench.content.tree import Block, Cell, Document, Section, Table, spoken

Said = Callable[[str], str]  # a text of the tree as Markdown
_MARKS = {"good": "✅ ", "bad": "❌ ", "doubt": "❔ "}


def render_markdown(document: Document) -> str:
    """Markdown text of a content tree; its facts stand at the foot, sections may lack a title.

    Citations become author and year. Equal trees give equal text.
    """

    def said(text: str) -> str:
        plain = spoken(text, document.named)  # bars end cells, tags and line ends mean something
        return plain.replace("<", "&lt;").replace("|", "\\|").replace("\n", " ")

    lines = [f"# {said(document.title)}", ""]
    for section in document.sections:
        lines += _block(section, 2, said)
    return "\n".join([*lines, "---", "", *map(said, document.facts)]) + "\n"


def _block(block: Block, level: int, said: Said) -> Iterator[str]:
    """Lines of a block, an empty one at its end."""
    match block:
        case Section():
            if block.title:
                yield from (f"{'#' * level} {said(block.title)}", "")
            for inner in block.blocks:
                yield from _block(inner, level + 1, said)
            return
        case tree.Paragraph():
            yield said(block.text)
        case tree.Bullets():
            yield from (f"- {said(item)}" for item in block.items)
        case tree.Callout():
            yield f"> {said(block.text)}"
        case tree.Definitions():
            yield from (f"- {said(term)}: {said(text)}" for term, text in block.pairs)
        case tree.Listing():
            yield from (said(block.title), "", "```", block.text, "```")
        case tree.Picture():
            yield from (f"![{said(block.alt)}]({block.image})", "")
            yield f"**{block.name}.** {said(block.caption)}"
            if block.statements:
                yield ""
            yield from (f"- {said(statement)}" for statement in block.statements)
        case Table():
            yield from (f"**{block.name}.** {said(block.caption)}".rstrip(), "")
            yield _row(said(column.title) for column in block.columns)
            yield "|" + "|".join("---:" if c.numeric else "---" for c in block.columns) + "|"
            yield from (_row(_cell(cell, said) for cell in row) for row in block.rows)
    yield ""


def _cell(cell: Cell, said: Said) -> str:
    hatch = "▨ " if cell.hatched else ""
    return _MARKS.get(cell.tone, "") + hatch + said(cell.text)


def _row(cells: Iterator[str]) -> str:
    return f"| {' | '.join(cells)} |"
