"""Questions in one line of Python: one answer, several side by side, a study, a fit.

Many scenarios at once: a table of answers; one with values varied as a labelled dataset.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from workbench.api.accessor import compared, html_of
from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.models import batch
from workbench.models.base import Model, ask, make_model
from workbench.models.batch import FAILURE, OUTCOME
from workbench.responses import SCALARS, Outcome, Response, outcome_of
from workbench.responses.histories import VARIABLES
from workbench.scenarios import (
    Column,
    ColumnImpact,
    Frame,
    FrameImpact,
    FrameStriker,
    Scenario,
    Striker,
    load_scenario,
)
from workbench.scenarios.files import place_of, to_toml
from workbench.scenarios.varied import Varied
from workbench.study.batches import answers_of
from workbench.study.error_model.error_model import advised, choose, quick_reference

if TYPE_CHECKING:
    from workbench.api.plots import Plots
    from workbench.studs.relations import ResidualFit
    from workbench.study import Study


def load(path: Path | str, *overrides: str) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path : path of a TOML file, as ``workbench new column`` prints one.
    overrides : texts ``key.path=value``, such as ``"striker.velocity=20"``.

    Returns
    -------
    Scenario
        Frozen, in SI units.

    Raises
    ------
    InputError
        Naming the key, its value and what is allowed.
    """
    return load_scenario(path, overrides)


def hit(
    structure: Column | Frame,
    mass: float | str,
    velocity: float | str,
    *,
    node: str = "",
    direction: str = "+x",
    restitution: float = 0.0,
    duration: float | str = 0.1,
    name: str = "hit",
) -> ColumnImpact | FrameImpact:
    """A rigid mass that hits a column at its hit point, or a frame at a node.

    Parameters
    ----------
    structure : a `Column` or a `Frame`.
    mass : in kg, or a text with its unit such as ``"1.5 t"``.
    velocity : in m/s, or a text such as ``"90 km/h"``.
    node, direction : of a frame, where and along which axis (``"+x"``) it is hit.
    restitution : Newton's, from 0 to 1.
    duration : of the record, in s.
    name : of the scenario.

    Raises
    ------
    InputError
        Naming the value that cannot be.

    Examples
    --------
    >>> import workbench as wb
    >>> column = wb.Column("HEB 220", length_below="0.8 m", length_above=3.2)
    >>> wb.hit(column, mass=1500, velocity="54 km/h").input_energy
    168750.0
    """
    numbers: Any = (mass, velocity, restitution)
    if isinstance(structure, Frame):
        striker = FrameStriker(*numbers, node=node, direction=direction)
        return FrameImpact(name, structure, striker, duration)  # type: ignore[arg-type]
    if not isinstance(structure, Column):
        raise InputError("structure", structure, "must be a Column or a Frame")
    if node:
        raise InputError("node", node, "is for frames: a column is hit at the end of length_below")
    return ColumnImpact(name, structure, Striker(*numbers), duration)  # type: ignore[arg-type]


def asked(model: Model | str, **options: Any) -> Model:
    """A model by its name and options; one that is made already passes through.

    Raises `InputError` for unknown names and options.
    """
    if isinstance(model, str):
        return make_model(model, options)
    if options:
        raise InputError("option", sorted(options), "is for a model by name: this one has its own")
    return model


def simulate(
    scenario: Scenario | Path | str, model: Model | str | None = None, **options: Any
) -> Response:
    """Answer a scenario with one model, and the error to expect of it.

    Parameters
    ----------
    scenario : what happens, or the path of its file.
    model : name of a model, or a `Model` with its options; without one that of `workbench advise`.
    options : of the model by name, such as ``beta=1.3``.

    Returns
    -------
    xarray.Dataset
        Histories over ``time`` (s) or ``step``, scalars and energies in SI units, of a record that
        is made longer where it ends before its peak. Its accessor ``.workbench`` gives `findings`,
        `outcome`, numbers and plots, of a collapse too: that is an answer, as a refusal is, and no
        exception.

    Raises
    ------
    InputError
        For unknown names, options out of range, input that no model can use.

    Examples
    --------
    >>> import workbench as wb
    >>> column = wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN")
    >>> response = wb.simulate(wb.hit(column, mass=1500, velocity=5), "four-dof")
    >>> response.workbench.outcome.value
    'ok'
    >>> wb.simulate(wb.hit(column, 1500, 80), "four-dof").workbench.outcome.value
    'collapse'
    """
    given = load_scenario(scenario) if isinstance(scenario, (Path, str)) else scenario
    choice = choose(given) if model is None else None
    chosen = asked(choice.model if choice else model or "", **options)
    given, answer = ask(chosen, given)
    response = advised(chosen, given, answer)
    if choice:
        response.attrs["because"] = choice.because
    if outcome_of(response) is Outcome.INVALID_INPUT:
        raise InputError("scenario", given.name, response.attrs["message"])
    return response


@dataclass(frozen=True)
class Comparison:
    """Answers of several models to one `scenario`.

    Attributes: `responses` by label; `reference`, the label that the others are held against
    (empty: none is inside its domain).
    """

    scenario: Scenario
    responses: Mapping[str, Response]
    reference: str = ""

    @cached_property
    def table(self) -> pd.DataFrame:
        """One row per model, SI: outcome, scalars (NaN where not known), error of the peak."""
        return compared(self.responses, self.reference)

    @property
    def plot(self) -> Plots:
        """Pictures with all answers, as those of one response."""
        from workbench.api.plots import Plots

        return Plots(self.scenario, self.responses, self.reference)

    def __getitem__(self, label: str) -> Response:
        """The response of a label."""
        if label not in self.responses:
            raise InputError("label", label, f"must be one of {', '.join(self.responses)}")
        return self.responses[label]

    def _repr_html_(self) -> str:
        return html_of(self.scenario.name, self.table)


def compare(
    scenario: Scenario | Path | str,
    models: Iterable[Model | str] | Mapping[str, Model | str],
    reference: Model | str | None = None,
) -> Comparison:
    """Answer a scenario with several models.

    Parameters
    ----------
    scenario : what happens, or the path of its file.
    models : names or models; a mapping gives them labels of your own.
    reference : label, name or model that the others are held against. Without one it is the
        quickest reference inside its domain, if there is one.

    Returns
    -------
    Comparison
        `.table`, `.plot.history()` and the responses by label.

    Raises
    ------
    InputError
        As `simulate`.

    Examples
    --------
    >>> import workbench as wb
    >>> hit = wb.hit(wb.Column("HEB 220", 2.0, 2.0), mass=1500, velocity=5)
    >>> answers = wb.compare(hit, ["four-dof", "energy-estimate"], reference="four-dof")
    >>> list(answers.table["model"])
    ['four-dof', 'energy-estimate']
    """
    given = load_scenario(scenario) if isinstance(scenario, (Path, str)) else scenario
    labelled = dict(models) if isinstance(models, Mapping) else {_label(m): m for m in models}
    if reference is None:
        reference = quick_reference(given)
    label = _label(reference) if reference else ""
    if label and label not in labelled:
        labelled[label] = reference
    chosen = {label: asked(model) for label, model in labelled.items()}  # all, before the work
    return Comparison(given, {key: simulate(given, each) for key, each in chosen.items()}, label)


def _label(model: Model | str) -> str:
    return model if isinstance(model, str) else model.name


def study_of(
    scenarios: Iterable[Scenario] | Mapping[str, Scenario],
    models: Iterable[str] | Mapping[str, Model | str],
    reference: str,
    *,
    name: str = "study",
    question: str = "How far can each model be trusted?",
    **parts: Any,
) -> Study:
    """A study of scenarios and models, with pictures of all; `run_study` answers it.

    Parameters
    ----------
    scenarios : cases by their names, or scenarios whose names differ.
    models : names, or names and models by labels of your own.
    reference : label of the model that the others are held against.
    name, question : of the study.
    parts : further parts of `Study`, such as `gates` or `figures`.

    Raises
    ------
    InputError
        For names that do not fit together.

    Examples
    --------
    >>> import workbench as wb
    >>> column = wb.Column("HEB 220", 2.0, 2.0)
    >>> hits = {f"{v} m/s": wb.hit(column, mass=1500, velocity=v) for v in (4, 7)}
    >>> len(wb.study_of(hits, ["four-dof", "energy-estimate"], "four-dof").cases)
    2
    """
    from workbench.study import Case, Figure, Study

    if not isinstance(scenarios, Mapping):
        pairs: list[tuple[str, Any]] = [(each.name, each) for each in scenarios]
    else:
        pairs = list(scenarios.items())
    labelled = models if isinstance(models, Mapping) else {label: label for label in models}
    words = {"title": name, "question": question}
    figures = (Figure("peaks", "peaks", "Peaks", "Of all models."),)
    return Study(
        name,
        cases=tuple(Case(key, scenario) for key, scenario in pairs),
        models={label: asked(model) for label, model in labelled.items()},
        reference=reference,
        **{**words, "figures": figures, **parts},
    )


def fit_residual(
    table: pd.DataFrame | Path | str, quantity: str = "strength", **options: Any
) -> ResidualFit:
    """Fit what is left of studs after pre-damage.

    Parameters
    ----------
    table : rows in the columns of `workbench new studs --kind residual`, or the path of such a CSV.
    quantity : ``"strength"`` or ``"stiffness"``.
    options : `predamage`, `measure`, `loss`, `confidence`, `mechanical`; see
        `workbench.studs.fit_residual`.

    Raises
    ------
    InputError
        For a table that cannot be read, with its first bad line, or without tests to fit.
    """
    from workbench.studs.relations import fit_residual as fit_rows
    from workbench.studs.schema import TESTS, examine, from_frame

    if isinstance(table, pd.DataFrame):
        read = "use_for_fit" in table  # a table that was read is complete
        rows = table if read else from_frame(table, TESTS)
        return fit_rows(rows, quantity, **options)
    path = Path(table)
    if not path.is_file():
        raise InputError("table", str(path), "is not a file")
    return fit_rows(examine(path, TESTS).accept(), quantity, **options)


MOST = 1_000_000


def simulate_many(
    model: Model | str, scenarios: Sequence[Scenario], threads: int | None = None
) -> pd.DataFrame:
    """Answer many scenarios with one model; struck columns that differ in numbers all at once.

    Parameters
    ----------
    model : its name, or the model with its options; references answer on one mesh.
    scenarios : any number of them, of any kinds that the model answers.
    threads : at most (None: one for each core); the numbers do not depend on it.

    Returns
    -------
    pandas.DataFrame
        A row a scenario: scalars in SI units, NaN where there is none; `outcome`; `failure`, why it
        is not ok, in the words of a single call.

    Raises
    ------
    InputError
        For an unknown model, and a number of threads below 1.

    Examples
    --------
    >>> import workbench as wb
    >>> column = wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN")
    >>> hits = [wb.hit(column, mass=1500, velocity=v) for v in (5, 10, 80)]
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
    scenario : what happens, or the path of its file.
    over : values by key of the scenario, such as ``{"striker.velocity": [5, 10, "54 km/h"]}``.
    models : names, or models with their options; without any that of `workbench advise`.
    jobs : processes.
    cases : in place of `over`: a table whose columns are keys, a row a case.

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
    >>> import workbench as wb
    >>> column = wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN")
    >>> impact = wb.hit(column, mass=1500, velocity=5)
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
        if not each or any(value is None or value != value for value in each):
            raise InputError(key, each[:1], "needs a value, in every row")
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
    named = {key: (each, {"units": unit_at(given, key)}) for key, each in read.items()}
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
        with suppress(InputError, KeyError):
            part: Any = tomllib.loads(to_toml(varied[row]))
            for name in path:
                part = part[name]
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
