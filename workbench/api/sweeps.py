"""Many scenarios at once: a table of answers; one with values varied as a labelled dataset."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import permutations
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from workbench.api.answers import asked
from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.models import batch
from workbench.models.base import Model
from workbench.models.batch import FAILURE, OUTCOME
from workbench.responses import SCALARS, Outcome
from workbench.responses.histories import VARIABLES
from workbench.scenarios import Scenario, load_scenario
from workbench.scenarios.files import place_of, to_toml
from workbench.scenarios.varied import Varied
from workbench.study.batches import answers_of
from workbench.study.error_model.error_model import choose

MOST = 1_000_000


def simulate_many(
    model: Model | str, scenarios: Sequence[Scenario], threads: int | None = None
) -> pd.DataFrame:
    """Answer many scenarios with one model; struck columns that differ in numbers all at once.

    Parameters
    ----------
    model : Model or str
        Model with its options, or its name; references answer on one mesh.
    scenarios : sequence of Scenario, length n
        Of any kinds that the model answers.
    threads : int, optional
        At most; by default one for each core. The numbers do not depend on it.

    Returns
    -------
    pandas.DataFrame, n rows
        A row a scenario: scalars in SI units, NaN where there is none; `outcome`; `failure`, why it
        is not ok, in the words of a single call.

    Raises
    ------
    InputError
        For an unknown model, and a number of threads below 1.

    Examples
    --------
    >>> column = wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN")
    >>> hits = [wb.impact(column, mass=1500, velocity=v) for v in (5, 10, 80)]
    >>> wb.simulate_many("single-dof", hits).outcome.tolist()
    ['ok', 'ok', 'collapse']
    """
    if threads is not None:
        Number(1, 4096, integer=True).check("threads", threads)
    return batch.simulate_many(asked(model), scenarios, threads)


def sweep(
    scenario: Scenario | Path | str,
    over: Mapping[str, Iterable[Any]] | None = None,
    models: Sequence[Model | str] = (),
    jobs: int = 1,
    *,
    cases: pd.DataFrame | None = None,
) -> xr.Dataset:
    """Answer a scenario with some of its values varied, every value with every other, or by rows.

    Parameters
    ----------
    scenario : Scenario, Path or str
        What happens, or the path of its file.
    over : mapping, optional
        Values by key of the scenario, such as ``{"striker.velocity": [5, 10, "54 km/h"]}``.
    models : sequence of Model or str
        Models with their options, or names; by default that of `workbench advise`.
    jobs : int
        Processes.
    cases : pandas.DataFrame, optional
        In place of `over`: columns are keys, a row a case.

    Returns
    -------
    xarray.Dataset
        Scalars in SI units over ``model`` and the keys (or ``case``); NaN where a model collapses,
        refuses or fails, which ``outcome`` and ``failure`` say.

    Raises
    ------
    InputError
        For unknown keys, models and values none of which is allowed.

    Examples
    --------
    >>> column = wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN")
    >>> impact = wb.impact(column, mass=1500, velocity=5)
    >>> swept = wb.sweep(impact, {"striker.velocity": [5, 10, 80]}, ["single-dof", "four-dof"])
    >>> swept.sizes["striker.velocity"]
    3
    >>> str(swept.outcome.sel({"model": "four-dof", "striker.velocity": 80}).item())
    'collapse'
    """
    given = load_scenario(scenario) if isinstance(scenario, (Path, str)) else scenario
    if (over is None) == (cases is None):
        raise InputError("over", None, "must be given, or cases, and not both")
    values: dict[str, list[Any]] = {str(key): list(each) for key, each in (over or {}).items()}
    if cases is not None:
        values = {str(key): cases[key].tolist() for key in cases}
    for key, each in values.items():
        lacking = [value for value in each if value is None or value != value]
        if not each or lacking:
            raise InputError(key, lacking[:1], "needs a value, in every row")
    lengths = [len(each) for each in values.values()]
    count = int(np.prod(lengths, dtype=float)) if cases is None else len(cases)
    if not values or count > MOST:
        text = f"must be 1 to {MOST} combinations of values"
        raise InputError("over", count if values else None, text)
    chosen = [asked(model) for model in models or (choose(given).model,)]
    names = [model.name for model in chosen]
    if len(set(names)) < len(names):
        raise InputError("models", names, "must be different models")
    tables = tomllib.loads(to_toml(given))
    read = {key: _coordinate(tables, key, each) for key, each in values.items()}
    for key, each in read.items():
        if cases is None and len(set(map(str, each))) < len(each):
            raise InputError(key, each, "must be different values")
    places = np.tile(np.arange(count), (len(lengths), 1))
    if cases is None:  # every value with every other
        places = np.indices(lengths).reshape(len(lengths), -1)
    columns = {
        place_of(tables, key, f"{key}={each[0]}"): _column(each)[at]
        for (key, each), at in zip(values.items(), places, strict=True)
    }
    for (a, path), (b, other) in permutations(zip(values, columns, strict=False), 2):
        if other[: len(path)] == path:
            raise InputError(b, None, f"stands within {a}, which is varied too", "vary one of them")
    varied = Varied(tables, columns)
    answers = [answers_of(model, varied, given, jobs) for model in chosen]
    rows: pd.DataFrame = pd.concat(answers, ignore_index=True)
    if (rows[OUTCOME] == Outcome.INVALID_INPUT.value).all():
        _ = varied[0]  # says why
    words = {k: [v if np.isscalar(v) else str(v) for v in each] for k, each in read.items()}
    named = {key: (each, {"units": unit_at(given, key)}) for key, each in words.items()}
    if cases is None:
        crossed = {key: (key, *pair) for key, pair in named.items()}
        return _dataset(rows, {"model": names, **crossed}, named)
    coordinates = {"case": range(count), **{k: ("case", *pair) for k, pair in named.items()}}
    return _dataset(rows, {"model": names, **coordinates}, ["case"])


def _column(values: list[Any]) -> Array:
    """Values as an array: of numbers, or of whatever they are."""
    if all(isinstance(value, float) for value in values):
        return np.array(values)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def _coordinate(tables: dict[str, Any], key: str, values: list[Any]) -> list[Any]:
    """Values as the scenario reads them: numbers with a unit in SI."""
    texts = list(dict.fromkeys(value for value in values if isinstance(value, str)))
    path, read = place_of(tables, key, f"{key}={values[0]}"), {}
    varied = Varied(tables, {path: texts})
    for row, text in enumerate(texts):
        with suppress(InputError, AttributeError):
            scenario = varied[row]
            part: Any = tomllib.loads(to_toml(scenario))
            try:
                for name in path:
                    part = part[name]
            except KeyError:  # files leave it out at its default
                part = attrgetter(key)(scenario)
            read[text] = part
    return [read.get(value, value) if isinstance(value, str) else value for value in values]


def unit_at(scenario: Any, key: str) -> str:
    """The SI unit of a value of a scenario; empty of what has none."""
    *path, name = key.split(".")
    part = scenario
    for each in path:
        part = getattr(part, each, None)
    declared = getattr(part, "__dataclass_fields__", {}).get(name)
    return "" if declared is None else getattr(declared.metadata.get("rule"), "unit", "")


def _dataset(rows: pd.DataFrame, coordinates: Mapping[str, Any], over: Iterable[str]) -> xr.Dataset:
    """Answers, a row a combination, as a dataset over the model and what is varied."""
    empty = xr.Dataset(coords=coordinates)
    dims = ("model", *over)
    shape = tuple(empty.sizes[dim] for dim in dims)
    variables: dict[str, Any] = {}
    for name in SCALARS:
        if name in rows:
            labels = {"long_name": VARIABLES[name].long_name, "units": VARIABLES[name].units}
            variables[name] = (dims, rows[name].to_numpy(dtype=float).reshape(shape), labels)
    for name in (OUTCOME, FAILURE):
        variables[name] = (dims, rows[name].to_numpy(dtype=object).reshape(shape))
    return empty.assign(variables)
