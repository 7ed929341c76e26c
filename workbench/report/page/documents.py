"""Whole documents from a content tree: an HTML file, Markdown as git hosts show it, a PDF.

Equal trees give equal bytes.
"""

import json
import re
from dataclasses import asdict
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from workbench.base.errors import WorkbenchError
from workbench.report.page.tree import ELSEWHERE, Document, runs_of, spoken

_TEMPLATES = Path(__file__).with_name("templates")
STYLE = _TEMPLATES / "style.css"
_UNPRINTED = ("of", "sort")  # entries of blocks that paper does not show


def templates(directory: Path, *, escaped: bool = True) -> Environment:
    """The templates in a directory: texts are `escaped`, names that are not given are errors."""
    return Environment(
        loader=FileSystemLoader(directory),
        autoescape=escaped,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render_html(document: Document) -> str:
    """HTML text of a content tree: no outside file is loaded."""
    environment = templates(_TEMPLATES)
    environment.filters["rich"] = lambda text: _rich(document, text)
    environment.filters["anchor"] = anchor
    environment.filters["inline_svg"] = _inline
    return environment.get_template("report.html.jinja").render(
        document=document,
        style=Markup(STYLE.read_text(encoding="utf-8")),
        script=Markup((_TEMPLATES / "script.js").read_text(encoding="utf-8")),
    )


def render_markdown(document: Document) -> str:
    """Markdown text of a content tree; its facts stand at the foot, sections may lack a title.

    Citations become author and year.
    """

    def plain(text: str) -> str:
        whole = spoken(text, document.named)  # bars end cells, tags and line ends mean something
        return whole.replace("<", "&lt;").replace("|", "\\|").replace("\n", " ")

    environment = templates(_TEMPLATES, escaped=False)
    environment.filters["plain"] = plain
    return environment.get_template("report.md.jinja").render(document=document)


def render_pdf(document: Document) -> bytes:
    """PDF bytes of a content tree.

    The template walks the tree, so that texts are data and never read as markup. Only fonts that
    come with Typst are used, and no date is written.
    Raises `WorkbenchError` if Typst refuses the document, which is a defect of the template.
    """
    import typst

    tree = asdict(
        document, dict_factory=lambda pairs: {k: v for k, v in pairs if k not in _UNPRINTED}
    )
    tree["references"] = [
        {"key": work.key, "who": work.who, "title": work.title, "place": work.place}
        for work in document.references
    ]
    tree["named"] = dict(document.named)
    tree["elsewhere"] = ELSEWHERE
    try:
        pdf: bytes = typst.compile(
            str(_TEMPLATES / "report.typ"),
            root=str(_TEMPLATES),
            ignore_system_fonts=True,
            sys_inputs={"document": json.dumps(tree)},
            timestamp=0,
            format="pdf",
        )
    except typst.TypstError as error:
        raise WorkbenchError(f"the PDF cannot be set: {error}") from error
    return pdf


def anchor(key: str) -> str:
    """A key as an HTML id."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", key) or "part"


def _rich(document: Document, text: str) -> Markup:
    """The light markup of the content tree as HTML, everything else escaped."""
    parts = []
    for kind, content in runs_of(text):
        if kind == "code":
            parts.append(Markup("<code>{}</code>").format(content))
        elif kind == "cite":
            link = Markup('<a class="cite" href="#ref-{}">[{}]</a>')
            parts.append(link.format(anchor(content), document.number_of(content)))
        elif kind == "see":
            name = document.named.get(content)
            link = Markup('<a class="see" href="#{}-{}">{}</a>')
            place = "plot" if name and name.startswith("Figure") else "table"
            parts.append(link.format(place, anchor(content), name) if name else escape(ELSEWHERE))
        else:
            parts.append(Markup("<br>").join(escape(line) for line in content.split("\n")))
    return Markup("").join(parts)


def _inline(svg: str) -> Markup:
    """An SVG as part of an HTML document, which needs no namespaces and scales by its viewBox."""
    text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", svg)
    text = text.replace("xlink:href", "href")
    text = re.sub(r'(<svg[^>]*?)\s+width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?)\s+height="[^"]*"', r"\1", text, count=1)
    return Markup(text)
