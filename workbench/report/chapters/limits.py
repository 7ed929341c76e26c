"""Limits of a study: missing answers, and models outside their own assumptions."""

from collections.abc import Iterable
from functools import partial
from math import nan
from typing import Any

import pandas as pd

from workbench.report.page.formatting import several, valued
from workbench.report.page.markdown import Cell, Markdown, PageColumn, Table
from workbench.report.page.page import Page
from workbench.responses import Outcome
from workbench.responses.outcome import WARNING
from workbench.study.assessor import Assessment
from workbench.study.definition import Study
from workbench.study.store import NOT_RUN

_PRINTED = 40
PAGE = Page(__file__, printed=_PRINTED, mild=(NOT_RUN, Outcome.OUT_OF_DOMAIN))
_SIMILAR = 3  # sentences of one kind that are all shown


def _names(names: Iterable[str]) -> Cell:
    distinct = list(dict.fromkeys(names))
    return Cell(several(distinct), len(distinct))


def _groups(cells_of_kind: pd.DataFrame, *kind: str) -> list[dict[str, Any]]:
    """Groups of cells that say the same; of many sentences that differ in numbers one example.

    `kind`: the columns that they have in common, besides `sentence` and `number`.
    """
    rows = []
    for _, alike in cells_of_kind.groupby(list(kind), sort=False):
        sentences = list(alike.groupby("sentence", sort=False))
        if len(sentences) > _SIMILAR:
            worst = alike.iloc[int(alike["number"].abs().fillna(0.0).argmax())]
            text = PAGE.words("alike", text=worst["sentence"], others=len(sentences) - 1)
            sentences = [(text, alike.assign(number=worst["number"]))]
        for sentence, cells in sentences:
            names = {"cases": _names(cells["case"]), "labels": _names(cells["label"])}
            rows.append({**cells.iloc[0], "sentence": sentence, **names})
    return rows


def missing(study: Study, stored: Assessment) -> Markdown:
    """Cells without an answer, grouped by what happened, and what was not asked."""
    cells = pd.DataFrame(map(vars, stored.cells.values()))
    silent = cells[~cells["outcome"].isin([Outcome.OK, Outcome.COLLAPSE])]
    sentences = silent["message"].where(silent["message"] != "", PAGE.words("not_run"))
    refusals = int((silent["outcome"] == Outcome.OUT_OF_DOMAIN).sum())
    return PAGE.blocks(
        "missing",
        cells=len(cells),
        silent=[
            (label, study.models[label].name, kind, names)
            for (label, kind), names in study.unsupported().items()
        ],
        refusals=refusals,
        failures=len(silent) - refusals,
        groups=_groups(silent.assign(sentence=sentences, number=nan), "label", "outcome"),
    )


def collapses(stored: Assessment) -> Markdown:
    """Where structures do not survive: an answer, with its mechanism, time and place."""
    collapsed = [cell for cell in stored.cells.values() if cell.collapse is not None]
    return PAGE.blocks("collapses", collapsed=collapsed, cells=len(stored.cells))


def domain(study: Study, stored: Assessment) -> Markdown:
    """Warnings of the models, and the shear demand of every case."""
    findings = stored.tables["findings"]
    shear: dict[str, dict[str, float]] = {}
    for (case, label), value in stored.values("shear_utilisation").items():
        shear.setdefault(case, {})[label] = value
    over = {name: top for name, values in shear.items() if (top := max(values.values())) > 1.0}
    worst = max(over, key=over.__getitem__, default="")
    return PAGE.blocks(
        "domain",
        over=len(over),
        cases=len(shear),
        worst=worst,
        ratio=over.get(worst),
        reference_too=any(values.get(study.reference, 0.0) > 1.0 for values in shear.values()),
        shear=_shear_table(study, shear),
        warnings=_groups(findings[findings["severity"] == WARNING], "subject", "remedy"),
    )


def _shear_table(study: Study, shear: dict[str, dict[str, float]]) -> Table | None:
    """V/Vpl by case and label, where models state it."""
    entries = list(shear.items())
    labels = [label for label in study.models if any(values.get(label) for _, values in entries)]
    if len(entries) > _PRINTED:
        entries.sort(key=lambda entry: -max(entry[1].values()))
    columns = (
        PageColumn("case", width=2.5, of=lambda entry: entry[0]),
        *(PageColumn(label, True, 1.2, partial(_ratio, label)) for label in labels),
    )
    return Table.of("shear", "", columns, entries, _PRINTED) if labels else None


def _ratio(label: str, entry: tuple[str, dict[str, float]]) -> Cell:
    value = entry[1].get(label)
    return valued(value, 3, "bad" if value is not None and value > 1.0 else "")


def notes(study: Study) -> Markdown:
    """Section of notes: reconstructed, inferred or assumed values, in the words of the study."""
    return PAGE.blocks("notes", notes=list(study.notes)) if study.notes else Markdown()
