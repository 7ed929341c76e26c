"""The table of an error model, from the stored results of the study that draws its scenarios."""

import json
import tomllib
from collections.abc import Iterator
from math import nan
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.base.errors import InputError
from workbench.responses import Response, findings_of, outcome_of
from workbench.scenarios import canonical
from workbench.study.cells import cells_of
from workbench.study.definition import Study
from workbench.study.error_model.error_model import margin_of, reached
from workbench.study.error_model.error_table import FINEST, MARGIN, TRUTH, ErrorTable, variant_of
from workbench.study.store import NOT_RUN, Store
from workbench.study.tables import Row

# subjects of warnings, beside those of its domain, of a reference that judges nobody
DOUBTFUL = ("mesh", "time-step", "energy-balance", "no-peak")
DIGITS = 7


def error_rows(study: Study, table: ErrorTable, root: Path) -> Iterator[Row]:
    """A row for every case: inputs, features, the reference and how it ended, peaks of all models.

    And residual displacements of reference and anchor. All are in m; peaks infinite where the
    structure collapses, NaN without an answer; that of the finest reference, too, only where it
    does not warn of itself. Raises `InputError` for a study without the anchor or the reference.
    """
    names = {label: _name_of(study, label) for label in study.models}
    if names[study.reference] != table.reference or table.anchor not in names.values():
        needed = f"must be of the reference {table.reference} and ask {table.anchor}"
        raise InputError("study", study.name, needed)
    anchor = next(label for label, name in names.items() if name == table.anchor)
    store = Store(Path(root) / study.name)
    cells = {(cell.case, cell.label): cell for cell in cells_of(study)}
    version = {name: study.models[label].version for label, name in names.items()}
    for case in study.cases:
        reference, state = nan, NOT_RUN
        residuals: dict[str, float] = {}
        peaks: dict[str, float] = {}
        for label, name in names.items():
            cell = cells.get((case.name, label))
            answer = None if cell is None else store.answer(cell.key, cell.ingredients)
            doubts, peak, residuals[label] = set(), nan, nan
            if answer is not None:
                doubts = _against_itself(answer[1])
                peak, residuals[label] = map(_rounded, reached(answer[1])[:2])
            if label == study.reference:
                reference = nan if doubts else peak
                if answer is not None:
                    state = ", ".join((outcome_of(answer[1]).value, *sorted(doubts)))
            elif pd.isna(peaks.get(name)):  # of several solids the first that answers
                peaks[name] = nan if name == FINEST and doubts else peak
        yield {
            "case": case.name,
            **{key: _rounded(value) for key, value in inputs_of(case.scenario).items()},
            **{key: _rounded(value) for key, value in table.features(case.scenario).items()},
            MARGIN: _rounded(margin_of(case.scenario)),
            "reference": table.reference,
            "reference_version": version[table.reference],
            "anchor_version": version[table.anchor],
            "reference_state": state,
            TRUTH: reference,
            "reference_residual": residuals[study.reference],
            "anchor_residual": residuals[anchor],
            **peaks,
        }


def inputs_of(scenario: Any) -> dict[str, Any]:
    """The values of a scenario file by their paths, but for its name and kind; lists as JSON."""
    values = {}
    for table, content in tomllib.loads(canonical(scenario)[0]).items():
        if isinstance(content, dict):
            for key, value in content.items():
                plain = isinstance(value, str | int | float)
                values[f"{table}.{key}"] = value if plain else json.dumps(value)
        elif isinstance(content, list):
            values[table] = json.dumps(content)
    return values


def _name_of(study: Study, label: str) -> str:
    """A model by its name and the options that change its numbers; references by their name."""
    model: Any = study.models[label]
    if model.name == FINEST or label == study.reference:
        name: str = model.name
        return name
    if model.name == study.models[study.reference].name:
        return f"{model.name} levels={model.levels}"
    return f"{model.name} {variant_of(model)}".rstrip()


def _against_itself(response: Response) -> set[str]:
    findings = findings_of(response)
    return {f.subject for f in findings if f.outside or f.refusal or f.subject in DOUBTFUL}


def _rounded(value: Any) -> Any:
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
