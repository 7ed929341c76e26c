"""Questions in one line of Python: one answer, several side by side, a study, a fit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

import workbench.api.accessor  # noqa: F401 - gives responses their `.workbench`
from workbench.api.accessor import compared, table_blocks
from workbench.base.errors import InputError
from workbench.models.base import Model, ask, make_model
from workbench.responses import Outcome, Response, findings_of, outcome_of, set_findings
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
from workbench.study.error_model.error_model import advised, choose, off_line, quick_reference

if TYPE_CHECKING:
    from workbench.api.plots import Plots
    from workbench.studs.relations import ResidualFit
    from workbench.study import Study


def load(path: Path | str, *overrides: str) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path : Path or str
        TOML file, as ``workbench new column`` prints one.
    *overrides : str
        Values by key, such as ``"striker.velocity=20"``.

    Returns
    -------
    Scenario
        Frozen, in SI units.

    Raises
    ------
    InputError
        Naming the key, its value and what is allowed.

    Examples
    --------
    >>> wb.load("scenario.toml", "striker.velocity=20").striker.velocity
    20.0
    """
    return load_scenario(path, overrides)


def impact(
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
    """A rigid mass that hits a column at its impact point, or a frame at a node.

    Parameters
    ----------
    structure : Column or Frame
        At rest under its dead loads.
    mass : float or str
        In kg, or a text with its unit such as ``"1.5 t"``.
    velocity : float or str
        In m/s, or a text such as ``"90 km/h"``.
    node, direction : str
        Where, and along which axis (``"+x"``), a frame is hit.
    restitution : float
        Newton's, from 0 to 1.
    duration : float or str
        Length of the record, in s.
    name : str
        Name of the scenario.

    Returns
    -------
    ColumnImpact or FrameImpact
        Frozen, in SI units.

    Raises
    ------
    InputError
        Naming the value that cannot be.

    Examples
    --------
    >>> column = wb.Column("HEB 220", length_below="0.8 m", length_above=3.2)
    >>> wb.impact(column, mass=1500, velocity="54 km/h").input_energy
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


def asked(model: Model | str, /, **options: Any) -> Model:
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
    scenario : Scenario, Path or str
        What happens, or the path of its file.
    model : Model or str, optional
        Model with its options, or its name; by default that of `workbench advise`.
    **options
        Options of the model by name, such as ``beta=1.3``.

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
    >>> column = wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN")
    >>> response = wb.simulate(wb.impact(column, mass=1500, velocity=5), "four-dof")
    >>> response.workbench.outcome.value
    'ok'
    >>> wb.simulate(wb.impact(column, 1500, 80), "four-dof").workbench.outcome.value
    'collapse'
    """
    given = load_scenario(scenario) if isinstance(scenario, (Path, str)) else scenario
    choice = choose(given) if model is None else None
    chosen = asked(choice.model if choice else model or "", **options)
    given, answer = ask(chosen, given)
    response = advised(chosen, given, answer)
    set_findings(response, [*findings_of(response), *off_line(given, response)])
    if choice:
        response.attrs["because"] = choice.because
    if outcome_of(response) is Outcome.INVALID_INPUT:
        raise InputError("scenario", given.name, response.attrs["message"])
    return response


@dataclass(frozen=True)
class Comparison:
    """Answers of several models to one scenario, as `compare` gives them.

    Parameters
    ----------
    scenario : Scenario
        What happens.
    responses : mapping of str to xarray.Dataset
        Answers by label.
    reference : str
        Label that the others are held against; empty: none is inside its domain.

    Examples
    --------
    >>> impact = wb.impact(wb.Column("HEB 220", 2.0, 2.0), mass=1500, velocity=5)
    >>> answers = wb.compare(impact, ["single-dof", "energy-estimate"], reference="single-dof")
    >>> answers["energy-estimate"].workbench.outcome.value
    'ok'
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
        from workbench.report.page.documents import html_of_blocks

        return html_of_blocks(*table_blocks(self.scenario.name, self.responses))


def compare(
    scenario: Scenario | Path | str,
    models: Iterable[Model | str] | Mapping[str, Model | str],
    reference: Model | str | None = None,
) -> Comparison:
    """Answer a scenario with several models.

    Parameters
    ----------
    scenario : Scenario, Path or str
        What happens, or the path of its file.
    models : iterable or mapping of Model or str
        Models or their names; a mapping gives them labels of your own.
    reference : Model or str, optional
        Label, name or model that the others are held against; by default the quickest reference
        inside its domain, if there is one.

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
    >>> hit = wb.impact(wb.Column("HEB 220", 2.0, 2.0), mass=1500, velocity=5)
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
    scenarios : iterable or mapping of Scenario
        Cases by their names, or scenarios whose names differ.
    models : iterable of str, or mapping of Model or str
        Names, or names and models by labels of your own.
    reference : str
        Label of the model that the others are held against.
    name, question : str
        Name of the study, and what it answers.
    **parts
        Further parts of `Study`, such as `gates` or `figures`.

    Returns
    -------
    Study
        Checked; nothing is answered yet.

    Raises
    ------
    InputError
        For names that do not fit together.

    Examples
    --------
    >>> column = wb.Column("HEB 220", 2.0, 2.0)
    >>> hits = {f"{v} m/s": wb.impact(column, mass=1500, velocity=v) for v in (4, 7)}
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
    table : pandas.DataFrame, Path or str
        Rows in the columns of `workbench new studs --kind residual`, or the path of such a CSV.
    quantity : str
        ``"strength"`` or ``"stiffness"``.
    **options
        `predamage`, `measure`, `loss`, `confidence`, `mechanical`; see
        `workbench.studs.fit_residual`.

    Returns
    -------
    ResidualFit
        Relation between damage and what is left, a share of 1; its `band`, `grade` and `findings`.

    Raises
    ------
    InputError
        For a table that cannot be read, with its first bad line, or without tests to fit.

    Examples
    --------
    >>> fit = wb.fit_residual("residual.csv", "strength")
    >>> fit.left([0.0, 0.5]).shape
    (2,)
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
