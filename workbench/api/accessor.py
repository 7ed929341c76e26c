"""Accessor ``response.workbench``: a response in words, with its findings as objects."""

from __future__ import annotations

import tomllib
from functools import cached_property
from math import nan
from typing import TYPE_CHECKING

import xarray as xr

from workbench.api.summary import error_of, headline, html_of
from workbench.base.errors import Collapse, InputError
from workbench.base.fields import did_you_mean
from workbench.report.page.formatting import in_unit
from workbench.responses import (
    SCALARS,
    VARIABLES,
    Finding,
    Outcome,
    Response,
    collapse_of,
    findings_of,
    outcome_of,
    scalars_of,
)
from workbench.scenarios import Scenario
from workbench.scenarios.files import scenario_from
from workbench.study.error_model.error_model import ExpectedError

if TYPE_CHECKING:
    from workbench.api.plots import Plots


@xr.register_dataset_accessor("workbench")  # type: ignore[no-untyped-call]
class Answered:
    """A response with its findings as objects, its numbers and its pictures.

    Of responses of this session and of files that `simulate --out` wrote.

    Examples
    --------
    >>> import workbench as wb
    >>> hit = wb.hit(wb.Column("HEB 220", 0.8, 3.2), mass=1500, velocity=80)
    >>> answer = wb.simulate(hit, "four-dof").workbench
    >>> answer.outcome.value, answer.number("peak_displacement")
    ('collapse', nan)
    """

    def __init__(self, response: Response) -> None:
        self._response = response

    @property
    def outcome(self) -> Outcome:
        """How it ended; a collapse is an answer."""
        return outcome_of(self._response)

    @property
    def collapse(self) -> Collapse | None:
        """Mechanism, parts, displacement (m) and time (s) of a collapse; None without one."""
        return collapse_of(self._response)

    @property
    def findings(self) -> list[Finding]:
        """Warnings and refusals, each with sentence, remedy, number and limit."""
        return findings_of(self._response)

    @property
    def error(self) -> ExpectedError:
        """The error to expect of the peak displacement."""
        return error_of(self._response)

    @property
    def headline(self) -> str:
        """The answer in one sentence."""
        return headline(self._response)

    @cached_property
    def scenario(self) -> Scenario:
        """Scenario that was answered."""
        return scenario_from(tomllib.loads(self._response.attrs["scenario"]))

    @property
    def plot(self) -> Plots:
        """Pictures: `history`, `structure`, `deformed`, `interaction`, `energy`."""
        from workbench.api.plots import Plots

        return Plots(self.scenario, {self._response.attrs["model"]: self._response})

    def number(self, name: str) -> float:
        """A scalar in SI; NaN where the answer does not know it, as after a collapse.

        Raises `InputError` for a name that no response has.
        """
        if name not in SCALARS:
            advice = did_you_mean(name, SCALARS, f"known are {', '.join(SCALARS)}")
            raise InputError("quantity", name, "is not a scalar of responses", advice)
        return scalars_of(self._response).get(name, nan)

    def _repr_html_(self) -> str:
        values = scalars_of(self._response)
        rows = {VARIABLES[name].long_name: in_unit(v, name) for name, v in values.items()}
        rows |= {f"{each.subject}": str(each) for each in self.findings}
        return html_of(self.scenario.name, rows, self.headline)
