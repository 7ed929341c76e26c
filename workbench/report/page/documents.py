"""Whole documents of a page in Markdown: an HTML file, a PDF, Markdown as git hosts show it.

Equal pages give equal bytes.
"""

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from workbench.base.errors import WorkbenchError
from workbench.report.page.bibliography import Reference, reference_of
from workbench.report.page.markdown import Markdown, Picture, before_captions, paragraph, section
from workbench.report.page.reading import (
    ELSEWHERE,
    Block,
    PageSection,
    Printer,
    Quote,
    Run,
    Runs,
    Words,
    cites,
    named,
    read,
    spoken,
)

_TEMPLATES = Path(__file__).with_name("templates")
STYLE = _TEMPLATES / "style.css"


@dataclass(frozen=True)
class Document:
    """A whole report: `facts` are short lines on what it holds and what it is made of.

    Its figures and tables get their numbers in the order in which they are read; `pictures` are
    what stands in its figures, by key. `beside` are files in its folder that a screen links to,
    each with what it is. `on_paper`: without what is folded, which its last line names. The PDF has
    the `layout` of a report, or of a sheet, which is one page and as small as that takes.
    """

    title: str
    subtitle: str
    facts: tuple[str, ...]
    text: Markdown
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    beside: tuple[tuple[str, str], ...] = ()
    on_paper: bool = False
    layout: str = "report"

    @cached_property
    def sections(self) -> tuple[Block, ...]:
        """The page as printers read it."""
        blocks = read(self.text)
        if not self.on_paper:
            return blocks
        titles: list[str] = []
        shown = _unfolded(blocks, titles)
        if not titles:
            return shown
        text = paragraph(f"In the electronic report alone: {'; '.join(titles)}.")
        return (*shown, *read(section("folded", "More", text)))

    @cached_property
    def named(self) -> Mapping[str, str]:
        """``Figure 2`` or ``Table 3`` by key; of several with one key the first."""
        return named(self.sections)

    @cached_property
    def references(self) -> tuple[Reference, ...]:
        """The works that the texts cite, in that order; they are numbered from one."""
        return tuple(map(reference_of, cites(self.sections)))

    def marked(self, mark: str) -> "Document":
        """The document with a mark before its title and before every caption."""
        return replace(self, title=f"{mark}{self.title}", text=before_captions(self.text, mark))

    def number_of(self, key: str) -> int:
        """Number of a work that a text of this document cites."""
        return 1 + [reference.key for reference in self.references].index(key)


def _unfolded(blocks: Iterable[Block], titles: list[str]) -> tuple[Block, ...]:
    """Blocks without folded sections, whose `titles` are kept."""
    shown: list[Block] = []
    for block in blocks:
        if not isinstance(block, PageSection):
            shown.append(block)
        elif block.folded:
            titles.append(spoken(block.title))
        else:
            shown.append(replace(block, blocks=_unfolded(block.blocks, titles)))
    return tuple(shown)


def templates(directory: Path) -> Environment:
    """The templates in a directory: texts are escaped, names that are not given are errors."""
    return Environment(
        loader=FileSystemLoader(directory),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render_html(document: Document) -> str:
    """HTML text of a document: no outside file is loaded."""
    environment = templates(_TEMPLATES)
    environment.filters["anchor"] = anchor
    printer = _Html(document)
    return environment.get_template("report.html.jinja").render(
        document=document,
        parts=[(part, Markup(printer.block(part, 2))) for part in document.sections],
        spoken=spoken,
        style=Markup(STYLE.read_text(encoding="utf-8")),
        script=Markup((_TEMPLATES / "script.js").read_text(encoding="utf-8")),
    )


def html_of_blocks(*blocks: Any) -> str:
    """HTML of blocks within another page: tables do not sort, terms stand beside their texts."""
    document = Document("", "", (), Markdown().join(blocks))
    text = _Html(document).blocks(document.sections, 3)
    text = text.replace("<dl>", '<dl style="display: grid; grid-template-columns: auto 1fr">')
    return re.sub(r'</?button[^>]*>| aria-sort="none"', "", text)


def render_markdown(document: Document) -> str:
    """Markdown text of a document as git hosts show it; its facts stand at the foot.

    Citations become author and year.
    """
    printer = _Git(document)
    text = "\n\n".join(printer.block(part, 2) for part in document.sections)
    facts = "\n".join(printer.plain(fact) for fact in document.facts)
    return f"# {printer.plain(document.title)}\n\n{text}\n\n---\n\n{facts}\n"


def render_pdf(document: Document) -> bytes:
    """PDF bytes of a document.

    Texts are strings of the Typst code and never read as markup. Only fonts that come with Typst
    are used, and no date is written.
    Raises `WorkbenchError` if Typst refuses the document, which is a defect of the template.
    """
    import typst

    pictures = {key: asdict(picture) for key, picture in document.pictures.items()}
    try:
        pdf: bytes = typst.compile(  # type: ignore[call-overload]  # the root is no source
            typst_source(document).encode(),
            root=str(_TEMPLATES),
            ignore_system_fonts=True,
            sys_inputs={"pictures": json.dumps(pictures)},
            timestamp=0,
            format="pdf",
        )
    except typst.TypstError as error:
        raise WorkbenchError(f"the PDF cannot be set: {error}") from error
    return pdf


def typst_source(document: Document) -> str:
    """Typst code of a document, whose layout stands in ``report.typ``."""
    printer = _Typst(document)
    facts = _listed(map(_string, document.facts))
    title, subtitle = _string(document.title), _string(document.subtitle)
    parts = [printer.block(part, 1) for part in document.sections]
    works = [
        f"reference({number}, {_string(work.who)}, {_string(work.title)}, {_string(work.place)})"
        for number, work in enumerate(document.references, 1)
    ]
    if works:
        works.insert(0, 'heading(level: 1, "References")')
    return "\n".join(
        (
            f'#import "{document.layout}.typ": *',
            f"#show: report.with(title: {title}, subtitle: {subtitle}, facts: {facts})",
            "#{",
            *(*parts[:1], "contents", *parts[1:], *works),
            "}",
        )
    )


def anchor(key: str) -> str:
    """A key as an HTML id."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", key) or "part"


class _Printer(Printer[str]):
    """Text of the blocks of a document."""

    def __init__(self, document: Document) -> None:
        super().__init__()
        self._document = document

    def blocks(self, blocks: Iterable[Block], level: int) -> str:
        """Blocks one below the other."""
        return "".join(self.block(block, level) for block in blocks)


class _Html(_Printer):
    """HTML of blocks."""

    def rich(self, runs: Runs) -> str:
        """HTML of a text."""
        return "".join(self._run(*run) for run in runs)

    def _run(self, kind: str, text: str) -> str:
        if kind in ("code", "em", "strong"):
            return f"<{kind}>{escape(text)}</{kind}>"
        if kind == "cite":
            number = self._document.number_of(text)
            return f'<a class="cite" href="#ref-{anchor(text)}">[{number}]</a>'
        if kind == "see":
            name = self._document.named.get(text)
            place = "plot" if name and name.startswith("Figure") else "table"
            link = f'<a class="see" href="#{place}-{anchor(text)}">{name}</a>'
            return link if name else str(escape(ELSEWHERE))
        return "<br>".join(str(escape(line)) for line in text.split("\n"))

    def _section(self, section: PageSection, level: int) -> str:
        head = f"<h{level}>{self.rich(section.title)}</h{level}>"
        body = self.blocks(section.blocks, min(level + 1, 5))
        if section.folded:
            fold = '<details class="fold screen-only">'
            body = f"{fold}<summary>{head}</summary>\n{body}</details>\n"
        else:
            body = f"{head}\n{body}"
        return f'<section id="{anchor(section.key)}">\n{body}</section>\n'

    def _paragraph(self, runs: Runs) -> str:
        return f"<p>{self.rich(runs)}</p>\n"

    def _bullets(self, items: list[Runs]) -> str:
        return "\n".join(["<ul>", *(f"<li>{self.rich(item)}</li>" for item in items), "</ul>\n"])

    def _callout(self, tone: str, runs: Runs) -> str:
        return f'<p class="callout {escape(tone)}">{self.rich(runs)}</p>\n'

    def _definitions(self, pairs: list[tuple[str, Runs]]) -> str:
        rows = (f"<dt>{escape(term)}</dt><dd>{self.rich(runs)}</dd>\n" for term, runs in pairs)
        return f"<dl>\n{''.join(rows)}</dl>\n"

    def _listing(self, title: str, text: str, on_paper: bool) -> str:
        shown = "" if on_paper else ' class="screen-only"'
        head = f"<details{shown}><summary>{escape(title)}</summary>"
        return f"{head}\n<pre>{escape(text)}\n</pre>\n</details>\n\n"

    def _figure(self, figure: Quote, name: str) -> str:
        picture = self._document.pictures[figure.key]
        drawn = '<p class="callout note">Not drawn.</p>'
        if picture.svg:
            share = f'style="--share: {round(picture.width, 3)}" role="img"'
            label = f'aria-label="{escape(picture.alt)}"'
            drawn = f'<div class="plot" {share} {label}>{_inline(picture.svg)}</div>'
        words = f"<b>{name}.</b> {self.rich(figure.words.runs)}\n"
        for item in figure.items:
            words += f'<span class="statement">{self.rich(item.runs)}</span>\n'
        head = f'<figure id="plot-{anchor(figure.key)}">'
        return f"{head}\n{drawn}\n<figcaption>{words}</figcaption>\n</figure>\n"

    def _table(self, table: Quote, name: str) -> str:
        rows = table.rows
        sight = table.whole("in_sight") or len(rows)
        text = self._grid(table, rows, range(sight), f"<b>{name}.</b> ")
        if rows[sight:]:
            more = self._grid(table, rows, range(sight, len(rows)))
            head = f"<details><summary>{len(rows) - sight} more</summary>"
            text += f"{head}\n{more}</details>\n"
        limit = table.whole("limit")
        if limit is not None and len(rows) > limit:
            words = f"{len(rows) - limit} more rows are in the electronic report."
            text += f'<p class="paper-only">{words}</p>\n'
        return f'<div class="table" id="table-{anchor(table.key)}">\n{text}</div>\n'

    def _grid(self, table: Quote, rows: list[list[Words]], shown: range, name: str = "") -> str:
        """Some rows of a table; its caption stands over the first."""
        titles, numeric, widths = table.titles, table.numeric, table.widths
        stacks = 3 < len(titles) < 10
        kind = "sortable" + " wide" * (len(titles) > 12) + " stacks" * stacks
        text = f'<table class="{kind}" style="--columns: {len(titles)}">\n'
        if name:
            text += f"<caption><div>{name}{self.rich(table.words.runs)}</div></caption>\n"
        shares = (f'<col style="width: {100.0 * w / sum(widths):.2f}%">' for w in widths)
        text += f"<colgroup>{''.join(shares)}</colgroup>\n<thead><tr>\n"
        for title, number in zip(titles, numeric, strict=True):
            side = ' class="number"' if number else ""
            button = f'<button type="button">{self.rich(title)}</button>'
            text += f'<th scope="col"{side} aria-sort="none">{button}</th>\n'
        text += "</tr></thead>\n<tbody>\n"
        heads = [f' data-head="{escape(spoken(title))}"' if stacks else "" for title in titles]
        limit = table.whole("limit")
        for index, row in list(enumerate(rows))[shown.start : shown.stop]:
            beyond = limit is not None and index >= limit
            text += '<tr class="screen-only">\n' if beyond else "<tr>\n"
            for cell, number, head in zip(row, numeric, heads, strict=True):
                text += self._cell(cell, number, head)
            text += "</tr>\n"
        return f"{text}</tbody>\n</table>\n"

    def _cell(self, cell: Words, numeric: bool, head: str) -> str:
        """A cell: what it says, what it sorts by, what is shown at a pointer."""
        mark = cell.mark
        kinds = ("number" * numeric, mark.get("tone", ""), "hatched" * ("hatched" in mark))
        brief, sort = mark.get("brief"), mark.get("sort")
        whole = "; ".join(filter(None, (spoken(cell.runs) if brief else "", mark.get("more"))))
        text = f'<td class="{escape(" ".join(filter(None, kinds)))}"'
        text += "" if sort is None else f' data-sort="{sort}"'
        text += f' title="{escape(whole)}"' if whole else ""
        words = str(escape(brief)) if brief else self.rich(cell.runs)
        return f"{text}{head}>{words}</td>\n"


def _inline(svg: str) -> str:
    """An SVG as part of an HTML document, which needs no namespaces and scales by its viewBox."""
    text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", svg)
    text = text.replace("xlink:href", "href")
    text = re.sub(r'(<svg[^>]*?)\s+width="[^"]*"', r"\1", text, count=1)
    return re.sub(r'(<svg[^>]*?)\s+height="[^"]*"', r"\1", text, count=1)


class _Typst(_Printer):
    """Typst code of blocks: calls of the functions in ``report.typ``, a statement on each line."""

    def rich(self, runs: Runs) -> str:
        """An expression for the content of a text."""
        return " + ".join(self._run(*run) for run in runs) or "[]"

    def _run(self, kind: str, text: str) -> str:
        if kind == "cite":
            return f'linked("[{self._document.number_of(text)}]")'
        if kind == "see":
            return f"linked({_string(self._document.named.get(text, ELSEWHERE))})"
        if kind in ("em", "strong"):
            return f"{'emph' if kind == 'em' else kind}(plain({_string(text)}))"
        return f"{kind}({_string(text)})"

    def _section(self, section: PageSection, level: int) -> str:
        title = _string(spoken(section.title))
        if all(map(_is_plate, section.blocks)):
            figures = _listed(map(self._plate, section.blocks))
            return f"plates({title}, {level}, {figures})\n"
        head = f"heading(level: {min(level, 4)}, {title})\n"
        return head + self.blocks(section.blocks, level + 1)

    def _plate(self, block: Block) -> str:
        assert isinstance(block, PageSection)
        (figure,) = block.blocks
        assert isinstance(figure, Quote)
        words = self._captioned(figure, self.numbered(figure))
        return f"plate({_string(spoken(block.title))}, {words})"

    def _captioned(self, figure: Quote, name: str) -> str:
        caption = f"captioned({_string(name)}, {self.rich(figure.words.runs)})"
        statements = _listed(self.rich(item.runs) for item in figure.items)
        return f"{_string(figure.key)}, {caption}, {statements}"

    def _paragraph(self, runs: Runs) -> str:
        return f"par({self.rich(runs)})\n"

    def _bullets(self, items: list[Runs]) -> str:
        return f"list({', '.join(map(self.rich, items))})\n"

    def _callout(self, tone: str, runs: Runs) -> str:
        return f"callout({_string(tone)}, {self.rich(runs)})\n"

    def _definitions(self, pairs: list[tuple[str, Runs]]) -> str:
        rows = _listed(f"({_string(term)}, {self.rich(runs)})" for term, runs in pairs)
        return f"definitions({rows})\n"

    def _listing(self, title: str, text: str, on_paper: bool) -> str:
        return f"listing({_string(title)}, {_string(text)})\n" if on_paper else ""

    def _figure(self, figure: Quote, name: str) -> str:
        return f"figure-of({self._captioned(figure, name)})\n"

    def _table(self, table: Quote, name: str) -> str:
        rows = table.rows
        limit = table.whole("limit")
        shown = rows if limit is None else rows[:limit]
        arguments = (
            f"captioned({_string(name)}, {self.rich(table.words.runs)})",
            _listed(f"{width}" for width in table.widths),
            _listed("right" if numeric else "left" for numeric in table.numeric),
            _listed(map(self.rich, table.titles)),
            f"{len(rows) - len(shown)}",
            *(self._cell(cell) for row in shown for cell in row),
        )
        return f"listed-table({', '.join(arguments)})\n"

    def _cell(self, cell: Words) -> str:
        lines: list[list[Run]] = [[]]
        for kind, text in cell.runs:
            first, *more = text.split("\n")
            lines[-1].append(Run(kind, first))
            lines += ([Run(kind, each)] for each in more)
        tone, hatched = _string(cell.mark.get("tone", "")), str("hatched" in cell.mark).lower()
        return f"cell({tone}, {hatched}, {', '.join(self.rich(tuple(line)) for line in lines)})"


def _is_plate(block: Block) -> bool:
    """Whether a block is a figure under a heading."""
    if not isinstance(block, PageSection) or len(block.blocks) != 1:
        return False
    (inner,) = block.blocks
    return isinstance(inner, Quote) and inner.kind == "figure"


def _string(text: str) -> str:
    """A string of Typst."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + re.sub(r"[\x00-\x1f]", lambda m: f"\\u{{{ord(m[0]):x}}}", escaped) + '"'


def _listed(items: Iterable[str]) -> str:
    """An array of Typst."""
    return "(" + "".join(f"{item}, " for item in items) + ")"


_SIGNS = {"good": "✅ ", "bad": "❌ ", "doubt": "❔ "}  # of tones


class _Git(_Printer):
    """Markdown of blocks as git hosts show it."""

    def plain(self, text: str) -> str:
        """A text on one line; bars end cells, tags mean something."""
        return text.replace("<", "&lt;").replace("|", "\\|").replace("\n", " ")

    def rich(self, runs: Runs) -> str:
        """A text without links."""
        return self.plain(spoken(runs, self._document.named))

    def _section(self, section: PageSection, level: int) -> str:
        title = self.rich(section.title)
        parts = [self.block(block, level + 1) for block in section.blocks]
        return "\n\n".join([f"{'#' * level} {title}"] * bool(title) + parts)

    def _paragraph(self, runs: Runs) -> str:
        return self.rich(runs)

    def _bullets(self, items: list[Runs]) -> str:
        return "\n".join(f"- {self.rich(item)}" for item in items)

    def _callout(self, tone: str, runs: Runs) -> str:
        return f"> {self.rich(runs)}"

    def _definitions(self, pairs: list[tuple[str, Runs]]) -> str:
        return "\n".join(f"- {self.plain(term)}: {self.rich(runs)}" for term, runs in pairs)

    def _listing(self, title: str, text: str, on_paper: bool) -> str:
        return f"{self.plain(title)}\n\n```\n{text}\n```"

    def _figure(self, figure: Quote, name: str) -> str:
        picture = self._document.pictures[figure.key]
        image = f"![{self.plain(picture.alt)}]({picture.image})"
        parts = [image, f"**{name}.** {self.rich(figure.words.runs)}"]
        if figure.items:
            parts.append(self._bullets([item.runs for item in figure.items]))
        return "\n\n".join(parts)

    def _table(self, table: Quote, name: str) -> str:
        rows = (map(self.rich, table.titles), *(map(self._cell, row) for row in table.rows))
        lines = [f"| {' | '.join(row)} |" for row in rows]
        sides = ("---:" if numeric else "---" for numeric in table.numeric)
        lines.insert(1, f"|{'|'.join(sides)}|")
        return "\n".join([f"**{name}.** {self.rich(table.words.runs)}".rstrip(), "", *lines])

    def _cell(self, cell: Words) -> str:
        tone = _SIGNS.get(cell.mark.get("tone", ""), "")
        return f"{tone}{'▨ ' * ('hatched' in cell.mark)}{self.rich(cell.runs)}"
