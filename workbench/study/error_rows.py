"""The table of an error model, from the stored results of the study that draws its scenarios."""

import json
import tomllib
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any

from workbench.errors import InputError
from workbench.evidence.descriptors import variant_of
from workbench.evidence.error_model import PEAK, RESIDUAL
from workbench.evidence.error_table import FINEST, TRUTH, ErrorTable
from workbench.models.strain_rate import feels_rate
from workbench.responses import Response, findings_of, outcome_of, survives
from workbench.scenarios import canonical
from workbench.study.cells import cells_of
from workbench.study.definition import Study
from workbench.study.store import NOT_RUN, Store
from workbench.study.tables import Row

# subjects of warnings, beside those of its domain, of a reference that judges nobody
DOUBTFUL = ("mesh", "time-step", "energy-balance", "no-peak")
DIGITS = 7


def error_rows(study: Study, table: ErrorTable, root: Path) -> Iterator[Row]:
    """A row for every case: inputs, features, the reference and how it ended, peaks of all models.

    And residual displacements of reference and anchor. All are in m; peaks infinite where the
    structure collapses, None without an answer; that of the finest reference, too, only where it
    does not warn of itself. Where only some of the cases have steel that feels its strain rate
    those are left out. Raises `InputError` for a study without the anchor or the reference.
    """
    names = {label: _name_of(study, label) for label in study.models}
    others = [label for label in names if label != study.reference]
    if names[study.reference] != table.reference or table.anchor not in names.values():
        needed = f"must be of the reference {table.reference} and ask {table.anchor}"
        raise InputError("study", study.name, needed)
    anchor = next(label for label, name in names.items() if name == table.anchor)
    store = Store(Path(root) / study.name)
    cells = {(cell.case, cell.label): cell for cell in cells_of(study)}
    version = {name: study.models[label].version for label, name in names.items()}
    static = [case for case in study.cases if not feels_rate(case.scenario)]
    for case in static or study.cases:
        answers: dict[str, Response] = {}
        for label in names:
            cell = cells.get((case.name, label))
            answer = None if cell is None else store.answer(cell.key, cell.ingredients)
            if answer is not None:
                answers[label] = answer[1]
        reference = answers.get(study.reference)
        peaks: dict[str, float | None] = {}
        for label in others:  # of several solids the first that answers
            if peaks.get(names[label]) is None:
                judges = names[label] == FINEST
                peaks[names[label]] = _peak(answers.get(label), judges=judges)
        yield {
            "case": case.name,
            **{key: _rounded(value) for key, value in inputs_of(case.scenario).items()},
            **{key: _rounded(value) for key, value in table.features(case.scenario).items()},
            "reference": table.reference,
            "reference_version": version[table.reference],
            "anchor_version": version[table.anchor],
            "reference_state": _state(reference),
            TRUTH: _peak(reference, judges=True),
            **{
                f"{name}_residual": _residual(answers.get(label))
                for name, label in (("reference", study.reference), ("anchor", anchor))
            },
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
    """A model by its name and the options that change its numbers, solids by their name alone."""
    model: Any = study.models[label]
    if model.name == FINEST:
        return FINEST
    if label != study.reference and model.name == study.models[study.reference].name:
        return f"{model.name} levels={model.levels}"
    return f"{model.name} {variant_of(model)}".rstrip()


def _state(response: Response | None) -> str:
    """How a reference ended, and the subjects of what it says against itself."""
    if response is None:
        return NOT_RUN
    return ", ".join((outcome_of(response).value, *sorted(_against_itself(response))))


def _against_itself(response: Response) -> set[str]:
    findings = findings_of(response)
    return {f.subject for f in findings if f.outside or f.refusal or f.subject in DOUBTFUL}


def _peak(response: Response | None, *, judges: bool) -> float | None:
    if response is None or (judges and _against_itself(response)):
        return None
    alive = survives(response)
    if alive is None or (alive and PEAK not in response):
        return None
    return _rounded(float(response[PEAK])) if alive else inf


def _residual(response: Response | None) -> float | None:
    if response is None or not survives(response) or RESIDUAL not in response:
        return None
    return float(_rounded(float(response[RESIDUAL])))


def _rounded(value: Any) -> Any:
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
