"""Running the bench: a study of all its cases, its answers as the table that anyone submits."""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.base.errors import InputError
from workbench.base.fields import did_you_mean
from workbench.extras.bench.answers import PEAK, SECONDS, WIDTH
from workbench.extras.bench.cases import BenchCase
from workbench.models.base import Model, make_model, model_names
from workbench.responses import Outcome, Response, error_of, findings_of, outcome_of, scalars_of
from workbench.study.cells import cells_of
from workbench.study.definition import Case, Study
from workbench.study.error_model.error_model import CLOSE
from workbench.study.runner import Progress, run_study
from workbench.study.store import Store
from workbench.study.tables import Row, numbers, table, texts

NAME, MODELS = "bench", Path(__file__).with_name("models.toml")
_ENDS = {Outcome.OK: "ok", Outcome.COLLAPSE: "collapse", Outcome.OUT_OF_DOMAIN: "refused"}
_COLUMNS = texts("case", "model", "outcome") | numbers(PEAK, WIDTH, SECONDS) | texts("warned")


def entrants(names: Sequence[str] = (), every: bool = False) -> dict[str, Model]:
    """Models of the bench by label: those of `names`, labels or registered ones.

    Without any those of the table `default`, or `every` one. Raises `InputError`.
    """
    tables = tomllib.loads(MODELS.read_text(encoding="utf-8"))
    listed = tables["default"] | tables["more"]
    names = names or list(listed if every else tables["default"])
    for name in names:
        if name not in listed and name not in model_names():
            advice = did_you_mean(name, [*listed, *model_names()], "see `workbench models`")
            raise InputError("--model", name, "is no model of the workbench", advice)
    return {name: make_model(*listed.get(name, (name,))) for name in names}


def run_bench(
    cases: Sequence[BenchCase],
    models: Mapping[str, Model],
    root: Path,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Answers of every model to every case; those that are stored under `root` are not run anew.

    The references are stored with the cases, and many sealed: `scores` compares, no cell does.
    Raises `InputError` as `run_study` does.
    """
    study = Study(
        NAME,
        "Impact bench",
        "How far is every model off where it was not tuned?",
        tuple(Case(case.name, case.scenario) for case in cases),
        models,
        reference=next(iter(models)),
    )
    store = Store(run_study(study, root, jobs=jobs, progress=progress).directory)
    return table(_rows(study, store), _COLUMNS)


def _rows(study: Study, store: Store) -> Iterator[Row]:
    """A row for every case and label; a kind that a model does not answer it refuses."""
    cells = {(cell.case, cell.label): cell for cell in cells_of(study)}
    for label in study.models:
        for case in study.cases:
            row: dict[str, Any] = {"case": case.name, "model": label, "outcome": "refused"}
            cell = cells.get((case.name, label))
            if cell is not None:
                answer = store.answer(cell.key, cell.ingredients)
                row["outcome"] = "failed"
                if answer is not None:
                    row |= answered(answer[1]) | {SECONDS: answer[0]["wall_time"]}
            yield {"warned": "no", **row}


def answered(response: Response) -> dict[str, Any]:
    """Cells of a response: how it ended, its peak and interval (m), whether it is warned of.

    The interval of 90 % of the error model may be skewed: the half-width reaches its farther end.
    """
    outcome, peak = outcome_of(response), abs(scalars_of(response).get("peak_displacement", 0.0))
    doubts = any(f.outside or f.subject == CLOSE for f in findings_of(response))
    row: dict[str, Any] = {"outcome": _ENDS.get(outcome, "failed")}
    row["warned"] = "yes" if doubts and outcome.is_answer else "no"
    if outcome is not Outcome.OK:
        return row
    if not (isfinite(peak) and peak > 0.0):
        return row | {"outcome": "failed"}
    error = error_of(response)
    row[PEAK] = peak
    if error.high is not None and error.low is not None and error.low > -1.0:
        row[WIDTH] = max(abs(peak / (1.0 + end) - peak) for end in (error.low, error.high))
    return row
