"""A content tree as one self-contained HTML file."""

import re
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from workbench.content.tree import ELSEWHERE, Document, runs_of

_TEMPLATES = Path(__file__).with_name("templates")
STYLE = _TEMPLATES / "style.css"


def render_html(document: Document) -> str:
    """HTML text of a content tree: no outside file is loaded, equal trees give equal text."""
    environment = templates(_TEMPLATES)
    environment.filters["rich"] = lambda text: _rich(document, text)
    environment.filters["anchor"] = anchor
    environment.filters["inline_svg"] = _inline
    return environment.get_template("report.html.jinja").render(
        document=document,
        style=Markup(STYLE.read_text(encoding="utf-8")),
        script=Markup((_TEMPLATES / "script.js").read_text(encoding="utf-8")),
    )


def templates(directory: Path) -> Environment:
    """The templates in a directory: texts are escaped, names that are not given are errors."""
    return Environment(
        loader=FileSystemLoader(directory),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


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
