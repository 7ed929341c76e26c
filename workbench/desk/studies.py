"""A study of scenarios and models at hand, and a fit of a table of tests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.desk.answers import asked
from workbench.errors import InputError
from workbench.models.base import Model
from workbench.scenarios import Scenario
from workbench.studs import TESTS, ResidualFit, examine
from workbench.studs import fit_residual as fit_rows
from workbench.study import Case, Figure, Study


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
    if isinstance(table, pd.DataFrame):
        return fit_rows(table, quantity, **options)
    path = Path(table)
    if not path.is_file():
        raise InputError("table", str(path), "is not a file")
    return fit_rows(examine(path, TESTS).accept(), quantity, **options)
