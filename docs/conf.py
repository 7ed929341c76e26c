"""The documentation site: `make docs`, offline, of the pages of this folder."""

import workbench

project = "Steel-impact validation workbench"
copyright = "The workbench authors"
release = workbench.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["requirements.*"]
html_theme = "sphinx_book_theme"
html_title = project
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
autodoc_typehints = "none"
# links from pages to files of the repository, which the site does not have
suppress_warnings = ["myst.xref_missing", "myst.header"]
