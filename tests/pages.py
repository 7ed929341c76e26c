"""Blocks of a page as tests look at them: texts in the light markup, cells with their marks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.report.page.markdown import Cell
from workbench.report.page.reading import PageSection, Printer, Quote, Runs, read, walk
from workbench.study.assessor import Assessment

_BACK = {"code": "`{}`", "cite": "[@{}]", "see": "[#{}]"}


@dataclass(frozen=True)
class View:
    """A block: its kind and what it says."""

    kind: str
    key: str = ""
    text: str = ""  # words, caption, or verbatim
    title: str = ""
    tone: str = ""
    items: list[str] = field(default_factory=list)
    pairs: list[tuple[str, str]] = field(default_factory=list)
    titles: list[str] = field(default_factory=list)
    numeric: list[bool] = field(default_factory=list)
    rows: list[list[Cell]] = field(default_factory=list)
    folded: bool = False
    on_paper: bool = True


def assessment(study: Any = None, **tables: Sequence[dict[str, Any]]) -> Assessment:
    """An assessment that holds nothing but these rows."""
    names = ("matrix", "ranking", "cost", "error-cells", "coverage", "chooser")
    columns = ["group", "label", "against", "ratio"]
    frames = {
        name: pd.DataFrame(tables[name]) if tables.get(name) else pd.DataFrame(columns=columns)
        for name in names
    }
    return Assessment(Path(), study, frames)


def views(page: str | PageSection, kind: str = "") -> list[View]:
    """All blocks of a page, or of a section as it is read; of one `kind`."""
    blocks = read(page) if isinstance(page, str) else (page,)
    seen = [_Viewer().block(block) for block in walk(blocks)]
    return [view for view in seen if kind in ("", view.kind)]


def text_of(runs: Runs) -> str:
    """A text in the light markup."""
    return "".join(_BACK.get(kind, "{}").format(text) for kind, text in runs)


class _Viewer(Printer[View]):
    def _section(self, section: PageSection, level: int) -> View:
        return View("section", section.key, title=text_of(section.title), folded=section.folded)

    def _paragraph(self, runs: Runs) -> View:
        return View("paragraph", text=text_of(runs))

    def _bullets(self, items: list[Runs]) -> View:
        return View("bullets", items=[text_of(item) for item in items])

    def _callout(self, tone: str, runs: Runs) -> View:
        return View("callout", text=text_of(runs), tone=tone)

    def _definitions(self, pairs: list[tuple[str, Runs]]) -> View:
        return View("definitions", pairs=[(term, text_of(text)) for term, text in pairs])

    def _listing(self, title: str, text: str, on_paper: bool) -> View:
        return View("listing", title=title, text=text, on_paper=on_paper)

    def _figure(self, figure: Quote, name: str) -> View:
        items = [text_of(item.runs) for item in figure.items]
        return View("figure", figure.key, text_of(figure.words.runs), name, items=items)

    def _table(self, table: Quote, name: str) -> View:
        titles = [text_of(title) for title in table.titles]
        rows = [[_cell(text_of(c.runs), c.mark) for c in row] for row in table.rows]
        caption = text_of(table.words.runs)
        return View(
            "table", table.key, caption, name, titles=titles, numeric=table.numeric, rows=rows
        )


def _cell(text: str, mark: Any) -> Cell:
    sort = float(mark["sort"]) if "sort" in mark else None
    words = {name: mark.get(name, "") for name in ("tone", "more", "brief")}
    return Cell(text, sort, hatched="hatched" in mark, **words)
