"""The page of the bench: ranking, kinds of cases, and who computed the references."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from workbench import __version__
from workbench.extras.bench.cases import FALLS, BenchCase, ReferenceAnswer
from workbench.extras.bench.scores import BEYOND, DRAWS, by_group, judged, scores
from workbench.report.page.documents import Document, render_html, render_markdown
from workbench.report.page.markdown import Markdown, PageColumn
from workbench.report.page.page import Page
from workbench.study.store import own_directory, write_atomically
from workbench.study.tables import csv_bytes

_PAGE = Page(__file__)
_OF_CASES = ["model", "case", "group", "outcome", "error", "loss", "missed"]


def write_bench(
    cases: Sequence[BenchCase],
    known: Mapping[str, ReferenceAnswer],
    answers: pd.DataFrame,
    target: Path,
) -> tuple[Markdown, pd.DataFrame, dict[str, Path]]:
    """Write page and tables under `target`: the ranking as page and table, files by what they are.

    Errors of single cases are written where their reference stands in the open: elsewhere they
    would tell it. Equal answers give equal bytes. Raises `InputError` for what cannot be written.
    """
    rows = judged(cases, known, answers)
    tables = {"ranking": scores(rows), "groups": by_group(rows)}
    tables["cases"] = rows.loc[~rows["case"].isin([c.name for c in cases if c.seal]), _OF_CASES]
    ranking = _PAGE.blocks(
        "ranking",
        rows=tables["ranking"],
        asked=len(known),
        cases=len(cases),
        collapses=sum(each.outcome == FALLS for each in known.values()),
    )
    asked = Counter(case.group for case in cases if case.name in known)
    columns = [PageColumn(f"{name} ({asked[name]})", True, of=name) for name in asked]
    text = _PAGE.blocks(
        "page",
        ranking=ranking,
        groups=tables["groups"],
        columns=[PageColumn("model", width=3.0, of="model"), *columns],
        solvers=pd.Series([case.model for case in cases]).value_counts().sort_index().items(),
        **{"beyond": BEYOND, "draws": DRAWS},
    )
    facts = (f"{len(known)} of {len(cases)} cases", f"workbench {__version__}")
    page = Document("Impact bench", "Errors of models against references", facts, text)
    own_directory(target.parent, target.name)
    files = {f"table of {name}": target / f"{name}.csv" for name in tables}
    for file, frame in zip(files.values(), tables.values(), strict=True):
        write_atomically(file, csv_bytes(frame))
    files |= {"page": target / "report.html", "page in Markdown": target / "README.md"}
    write_atomically(files["page"], render_html(page).encode())
    write_atomically(files["page in Markdown"], render_markdown(page).encode())
    return ranking, tables["ranking"], files
