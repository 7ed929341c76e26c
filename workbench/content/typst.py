"""A content tree as PDF, set by Typst."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from workbench.content.tree import (
    Block,
    Bullets,
    Callout,
    Cell,
    Column,
    Definitions,
    Document,
    Listing,
    Paragraph,
    Picture,
    Section,
    Table,
    runs_of,
    walk,
)
from workbench.errors import WorkbenchError

_TEMPLATE = Path(__file__).with_name("templates") / "report.typ"
_SOFT = re.compile(r"(?<=[A-Za-z0-9])([-_/.])(?=[A-Za-z0-9])")


def render_pdf(document: Document) -> bytes:
    """PDF bytes of a content tree; equal trees give equal bytes.

    Only fonts that come with Typst are used, and no date is written.
    Raises `WorkbenchError` if Typst refuses the document, which is a defect of this module.
    """
    import typst

    source = to_typst(document)
    with tempfile.TemporaryDirectory(prefix="workbench-") as name:
        directory = Path(name)
        for block in walk(document.sections):
            if isinstance(block, Picture) and block.svg:
                (directory / f"{block.key}.svg").write_text(block.svg, encoding="utf-8")
        main = directory / "report.typ"
        main.write_text(source, encoding="utf-8")
        try:
            pdf: bytes = typst.compile(
                str(main), root=name, ignore_system_fonts=True, timestamp=0, format="pdf"
            )
        except typst.TypstError as error:
            raise WorkbenchError(f"the PDF cannot be set: {error}") from error
    return pdf


def to_typst(document: Document) -> str:
    """Typst source of a content tree, without the pictures."""
    lines = [_TEMPLATE.read_text(encoding="utf-8")]
    facts = ", ".join(quoted(fact) for fact in document.facts)
    head = f"title: {quoted(document.title)}, subtitle: {quoted(document.subtitle)}"
    lines.append(f"#show: report.with({head}, facts: ({facts},))")
    for section in document.sections:
        lines.append(_block(document, section, 1))
    if document.references:
        lines.append("= References")
        for number, work in enumerate(document.references, start=1):
            parts = f"{quoted(work.who)}, {quoted(work.title)}, {quoted(work.place)}"
            lines.append(f"#reference({number}, {parts})")
    return "\n\n".join(lines) + "\n"


def quoted(text: str) -> str:
    """A Typst string literal; nothing inside is ever read as markup."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    escaped = escaped.replace("\n", "\\n").replace("\r", "").replace("\t", "  ")
    return f'"{escaped}"'


def _rich(document: Document, text: str) -> str:
    """Content of a text: plain strings, code and numbered citations."""
    parts = []
    for kind, content in runs_of(text):
        if kind == "code":
            parts.append(f"code({quoted(_soft(content))})")
        elif kind == "cite":
            parts.append(f"cited({document.number_of(content)})")
        else:
            lines = [f"plain({quoted(_soft(line))})" for line in content.split("\n")]
            parts.append(" + linebreak() + ".join(lines))
    return " + ".join(parts) or "[]"


def _soft(text: str) -> str:
    """Let long words break after hyphens, underscores, slashes and dots."""
    words = text.split(" ")
    return " ".join(
        _SOFT.sub("\\1\u200b", word) if len(word) > 12 and "=" not in word else word
        for word in words
    )


def _block(document: Document, block: Block, level: int) -> str:
    match block:
        case Section() if all(_is_plate(inner) for inner in block.blocks):
            return _plates(document, block, level)
        case Section():
            title = f"#heading(level: {min(level, 4)}, {quoted(block.title)})"
            inner = [_block(document, inner, level + 1) for inner in block.blocks]
            return "\n\n".join([title, *(text for text in inner if text)])
        case Paragraph():
            return f"#par({_rich(document, block.text)})"
        case Bullets():
            items = ", ".join(_rich(document, item) for item in block.items)
            return f"#list({items})"
        case Callout():
            return f"#callout({quoted(block.tone)}, {_rich(document, block.text)})"
        case Definitions():
            pairs = ", ".join(f"({quoted(t)}, {_rich(document, x)})" for t, x in block.pairs)
            return f"#definitions(({pairs},))"
        case Listing():
            if not block.printed:
                return ""
            return f"#listing({quoted(block.title)}, {quoted(block.text)})"
        case Picture():
            return _picture(document, block)
        case Table():
            return _table(document, block)


def _is_plate(block: Block) -> bool:
    """A section that holds one picture and nothing else."""
    match block:
        case Section(blocks=(Picture(svg=svg),)):
            return bool(svg)
    return False


def _plates(document: Document, section: Section, level: int) -> str:
    """A chapter of pictures: the template lets them share pages."""
    items = []
    for block in section.blocks:
        assert isinstance(block, Section)
        picture = block.blocks[0]
        assert isinstance(picture, Picture)
        caption, statements = _below(document, picture)
        content = f"scale => {_image(picture, ' * scale')}"
        items.append(
            f"  (title: {quoted(block.title)}, content: {content}, caption: {caption}, "
            f"statements: ({statements})),"
        )
    return "\n".join([f"#plates({quoted(section.title)}, {level}, (", *items, "))"])


def _image(block: Picture, scale: str = "") -> str:
    width = f"{100 * block.width:.0f}%{scale}"
    return f"image({quoted(block.key + '.svg')}, width: {width}, alt: {quoted(block.alt)})"


def _below(document: Document, block: Picture) -> tuple[str, str]:
    """Caption and statements of a picture."""
    statements = [_rich(document, text) for text in block.statements]
    statements += [f'plain("Numbers: ") + code({quoted(name)})' for name in block.files]
    return _rich(document, block.caption), "".join(f"{text}, " for text in statements)


def _picture(document: Document, block: Picture) -> str:
    caption, statements = _below(document, block)
    if not block.svg:
        return f"#undrawn({caption}, ({statements}))"
    return f"#picture({_image(block)}, {caption}, ({statements}))"


def _table(document: Document, block: Table) -> str:
    rows = block.rows if block.print_limit is None else block.rows[: block.print_limit]
    widths = ", ".join(f"{column.width:g}fr" for column in block.columns)
    sides = ", ".join("right" if column.numeric else "left" for column in block.columns)
    heads = ", ".join(f"head({_rich(document, column.title)})" for column in block.columns)
    cells = []
    for row in rows:
        line = ", ".join(
            _cell(document, cell, column) for cell, column in zip(row, block.columns, strict=True)
        )
        cells.append(f"  {line},")
    left = len(block.rows) - len(rows)
    more = f"{left} more rows are in the HTML report and in the CSV tables." if left else ""
    return "\n".join(
        [
            f"#listed-table({_rich(document, block.caption)}, ({widths},), ({sides},), "
            f"({heads},), {quoted(more)},",
            *cells,
            ")",
        ]
    )


def _cell(document: Document, cell: Cell, column: Column) -> str:
    content = _rich(document, cell.text)
    return f"toned({quoted(cell.tone)}, {content})" if cell.tone else f"({content})"
