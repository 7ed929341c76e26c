"""Published numbers as a model: they answer exactly the scenario they were published for."""

import hashlib
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, ClassVar

import pandas as pd

from workbench.base.catalogue import dataset, datasets, load
from workbench.base.datafiles import data_directory
from workbench.base.errors import InputError, OutOfDomainError
from workbench.base.fields import Text, checked
from workbench.models.base import Answering
from workbench.responses import SCALARS, Finding, Response, build_response, finding, set_attributes
from workbench.scenarios import ColumnImpact, FrameImpact, Scenario, load_scenario


@dataclass(frozen=True)
class Published(Answering):
    """One published series. Options: `dataset`, a catalogue name; `series`, a row label of it.

    Both must be given; what is missing or unknown is refused with the choices.
    The response holds the published scalars only, and as attribute `data_uncertainty` how well
    they can be read (JSON: quantity to half-width in SI).
    """

    dataset: str = checked(Text(), optional=True)
    series: str = checked(Text(), optional=True)

    name: ClassVar[str] = "published"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, FrameImpact.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Numbers as printed or as read from the figure; they answer only their own scenario.",
    )

    def check(self) -> None:
        """Refuse a dataset or a series that is not there."""
        tables = [entry.name for entry in datasets() if entry.scenario]
        if self.dataset not in tables:
            allowed = "must be one of " + "; ".join(tables)
            raise self.refusal("dataset", allowed, "see `workbench data list`")
        known = sorted(set(load(self.dataset)["series"]))
        if self.series not in known:
            raise self.refusal("series", "must be one of " + "; ".join(known))

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography key of the dataset."""
        return (dataset(self.dataset).key,)

    @property
    def data_digest(self) -> str:
        """Hash of the table, so that a stored cell is renewed when the data change."""
        return hashlib.sha256(dataset(self.dataset).path.read_bytes()).hexdigest()[:16]

    def domain(self, scenario: Scenario) -> list[Finding]:
        """Refuse every scenario that the series was not published for."""
        if self._row(scenario) is None:
            entry = dataset(self.dataset)
            values: dict[str, Any] = {"title": entry.title, "series": self.series}
            values |= {"published_for": entry.scenario, "axis": entry.axis}
            return [finding("published", **values)]
        return []

    def _row(self, scenario: Scenario) -> pd.Series | None:
        entry = dataset(self.dataset)
        rows = load(self.dataset)
        rows = rows[rows["series"] == self.series]
        if not isinstance(scenario, (ColumnImpact, FrameImpact)):
            return None
        for _, row in rows.iterrows():
            published = _published_scenario(entry.name, float(row[entry.axis_column]))
            # how long a response is followed is not part of what was published
            alike = replace(published, name=scenario.name, duration=scenario.duration)
            if alike == scenario:
                return row
        return None

    def _solve(self, scenario: Scenario) -> Response:
        row = self._row(scenario)
        if row is None:
            raise OutOfDomainError("nothing was published for this scenario")
        values: dict[str, float] = {}
        widths: dict[str, float] = {}
        for quantity in SCALARS:
            for column in (str(c) for c in row.index if str(c).startswith(f"{quantity}_")):
                target = widths if "_uncertainty_" in column else values
                target[quantity] = float(row[column])
        response = build_response(values)
        set_attributes(response, data_uncertainty=widths)
        return response


@cache
def _published_scenario(name: str, value: float) -> ColumnImpact | FrameImpact:
    entry = dataset(name)
    scenario = load_scenario(data_directory() / entry.scenario, [f"{entry.axis}={value!r}"])
    if not isinstance(scenario, (ColumnImpact, FrameImpact)):
        raise InputError("data catalogue", name, "its scenario must be an impact")
    return scenario
