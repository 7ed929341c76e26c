"""The documentation site: `make docs`, offline, of the pages of this folder."""

from typing import Any

from docutils import nodes
from docutils.utils.math import latex2mathml

import workbench

project = "Steel-impact validation workbench"
copyright = "The workbench authors"
release = workbench.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["requirements.*"]
html_theme = "sphinx_book_theme"
html_title = project
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "dollarmath"]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
autodoc_typehints = "none"
# links from pages to files of the repository, which the site does not have
suppress_warnings = ["myst.xref_missing", "myst.header"]
html_math_renderer = "mathml"


def _formula(writer: Any, node: nodes.math | nodes.math_block) -> None:
    """A formula as MathML, which browsers draw by themselves: nothing is fetched."""
    block = isinstance(node, nodes.math_block)
    mathml = latex2mathml.tex2mathml(node.astext(), as_block=block)
    writer.body.append(f"<div class='formula'>{mathml}</div>" if block else mathml)
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Draw formulas offline."""
    app.add_html_math_renderer("mathml", (_formula, None), (_formula, None))
