"""A content tree as PDF, set by Typst."""

import json
from dataclasses import asdict
from pathlib import Path

from workbench.content.tree import ELSEWHERE, Document
from workbench.errors import WorkbenchError

_TEMPLATE = Path(__file__).with_name("templates") / "report.typ"
_UNPRINTED = ("of", "sort")  # entries of blocks that paper does not show


def render_pdf(document: Document) -> bytes:
    """PDF bytes of a content tree; equal trees give equal bytes.

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
            str(_TEMPLATE),
            root=str(_TEMPLATE.parent),
            ignore_system_fonts=True,
            sys_inputs={"document": json.dumps(tree)},
            timestamp=0,
            format="pdf",
        )
    except typst.TypstError as error:
        raise WorkbenchError(f"the PDF cannot be set: {error}") from error
    return pdf
