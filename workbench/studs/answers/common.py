"""What the models of studs share: their tables, the split of the campaigns, their responses."""

import hashlib
import json
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import pandas as pd

from workbench.errors import InputError, OutOfDomainError
from workbench.evidence import dataset
from workbench.fields import Declared
from workbench.models.base import respond
from workbench.responses import Finding, Response, build_response
from workbench.responses.uncertainty import SAMPLED
from workbench.scenarios import Scenario
from workbench.scenarios.stud import CSV, StudTests
from workbench.studs.answers.typed import with_content
from workbench.studs.fit_protocol import Judged, plain
from workbench.studs.reading import examine
from workbench.studs.schema import POINTS, TESTS, Table
from workbench.studs.tables import check_campaigns, joined, shipped, split_table, table_schemas


@dataclass(frozen=True)
class Split:
    """Tests and load-slip points, those that `calibrate` and those that `validate`.

    Frames of the schemas `TESTS` and `POINTS`; without rows where the scenario names no table.
    """

    calibration: pd.DataFrame
    validation: pd.DataFrame
    calibration_points: pd.DataFrame
    validation_points: pd.DataFrame


def load_split(scenario: StudTests) -> Split:
    """The tables of a scenario, split by campaign.

    Raises `InputError` for a name that is no table of the schema, a bad row, a campaign that no
    table has, or a specimen that stands in two tables.
    """
    tests, points = _joined(scenario.tables, TESTS), _joined(scenario.curves, POINTS)
    check_campaigns((*scenario.calibrate, *scenario.validate), tests, points)
    parts = (split_table(each, scenario.calibrate, scenario.validate) for each in (tests, points))
    (calibration, validation), (calibration_points, validation_points) = parts
    return Split(calibration, validation, calibration_points, validation_points)


def _joined(names: Sequence[str], schema: Table) -> pd.DataFrame:
    tables = []
    for name in names:
        if name.endswith(CSV):
            tables.append(examine(name, schema).accept())
            continue
        schemas = table_schemas()
        if schemas.get(name) is not schema:
            known = [known for known, each in schemas.items() if each is schema]
            raise InputError("tests.tables", name, "must be a CSV file or " + ", ".join(known))
        tables.append(shipped(name))
    if not tables:
        return pd.DataFrame(columns=list(schema.names))
    return joined(tables, unique=schema is TESTS)


@dataclass(frozen=True)
class Found:
    """What a model found: the whole `content`, `findings`, how unseen tests judge it, `scalars`.

    `units` of columns of the content where they are not the usual ones. `exact`: the scalars are
    definitions, without uncertainty.
    """

    content: Mapping[str, Any]
    findings: Sequence[Finding] = ()
    judged: Judged | None = None
    scalars: Mapping[str, float | None] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    exact: bool = False


@dataclass(frozen=True)
class StudModel(Declared, table="option"):
    """A model that answers questions to tests on studs; its options are those of its own fields.

    A model names what may be asked of it (`asks`, empty: anything) and finds the answer in the
    tests that calibrate and validate.
    """

    name: ClassVar[str]
    version: ClassVar[int] = 11
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]]
    asks: ClassVar[tuple[str, ...]] = ()

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model."""
        return ()

    @property
    def data_digest(self) -> str:
        """Hash of the tables, so that stored answers are renewed when they change."""
        digest = hashlib.sha256()
        for name in table_schemas():
            digest.update(dataset(name).path.read_bytes())
        return digest.hexdigest()[:16]

    def domain(self, scenario: Scenario) -> list[Finding]:
        """It answers the questions that it is made for, and refuses others."""
        asked = scenario.asked if isinstance(scenario, StudTests) else ""
        if not asked or not self.asks or asked in self.asks:
            return []
        text = f"{self.name} answers {', '.join(self.asks)}, not {asked}"
        return [Finding("question", text, refusal=True)]

    def simulate(self, scenario: Scenario) -> Response:
        """The scalars of the answer, and its content as typed variables.

        What the tests do not support (`InputError` of `find`) becomes a refusal, out-of-domain.
        Raises `InputError` for tables that cannot be read.
        """
        return respond(self, scenario, self._solve)

    @abstractmethod
    def find(self, scenario: StudTests, split: Split) -> Found:
        """Answer from the tests. Raises `InputError`, `OutOfDomainError`, `SolverError`."""

    def _solve(self, scenario: StudTests) -> Response:
        split = load_split(scenario)
        try:
            found = self.find(scenario, split)
        except InputError as error:
            raise OutOfDomainError(str(error)) from error
        told = found.judged.told if found.judged else {}
        scalars = {**found.scalars, **{name: each.value for name, each in told.items()}}
        response = build_response(scalars, warnings=found.findings)
        widths: dict[str, Any] = {str(name): 0.0 for name in response.data_vars}
        if not found.exact:
            widths = {name: each.width for name, each in told.items() if each.width is not None}
        kind = "data_uncertainty" if found.exact else "sampling_uncertainty"  # over tests
        response.attrs[kind] = json.dumps(plain(widths), sort_keys=True)
        if found.judged is not None:
            ends = {name: each.ends for name, each in told.items() if each.ends is not None}
            response.attrs[SAMPLED] = json.dumps(plain(ends), sort_keys=True)
        return with_content(response, found.content, found.units)
