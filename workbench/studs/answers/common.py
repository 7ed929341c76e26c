"""What the models of studs share: their tables, the split of the campaigns, their responses."""

import hashlib
import json
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import xarray as xr

from workbench.errors import InputError, OutOfDomainError
from workbench.evidence import dataset
from workbench.fields import Declared
from workbench.models.base import respond
from workbench.responses import Finding, Response, build_response
from workbench.responses.uncertainty import SAMPLED
from workbench.scenarios import Scenario
from workbench.scenarios.laboratory import CSV, StudTests
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


# -- the content of an answer as typed variables of its response ---------------------------------
# A number, flag or word is a variable of no dimension, a list one along ``....item``, and the
# columns of a table lie along ``....row``; names are paths, ``answer.fit.sigma.value``. NaN: not
# known, or not reported. Any netCDF reader gets numbers and units.

ROOT, ROW, ITEM = "answer", "row", "item"
UNITS = {
    **dict.fromkeys(("load", "collar", "friction", "P_Rk", "P_Rd", "r_m", "r_k", "r_d"), "N"),
    **dict.fromkeys(("r_nominal", "strength_test", "strength_model"), "N"),
    **dict.fromkeys(("steel_term", "concrete_term", "other_concrete_term", "resistance"), "N"),
    **dict.fromkeys(("slip", "slip_at_max", "slip_capacity", "slip_test", "slip_model"), "m"),
    **dict.fromkeys(("diameter", "height", "peak_slip", "yield_slip"), "m"),
    **dict.fromkeys(("concrete_strength", "concrete_modulus", "ultimate_strength"), "Pa"),
    **dict.fromkeys(("chord_stiffness", "stiffness_test", "stiffness_model"), "N/m"),
    "rate": "1/m",
}


def with_content(
    response: Response, content: Mapping[str, Any], units: Mapping[str, str]
) -> Response:
    """The response with the content of an answer; `units` of columns where they are not usual."""
    held: Response = response.assign(dict(_variables(ROOT, plain(content), {**UNITS, **units})))
    return held


def _variables(
    path: str, value: Any, units: Mapping[str, str], along: str = ""
) -> Iterator[tuple[str, xr.Variable]]:
    """Every leaf of a nesting by its path; lists of one mapping, alike in length, lie `along`."""
    if isinstance(value, dict):
        lengths = {len(each) for each in value.values() if isinstance(each, list)}
        shared = f"{path}.{ITEM}" if len(lengths) == 1 else ""
        for key, each in value.items():
            yield from _variables(f"{path}.{key}", each, units, shared)
    elif not isinstance(value, list):
        yield path, _variable(path, [value], units)[0]
    elif not value or not isinstance(value[0], dict):
        yield path, _variable(path, value, units, along or f"{path}.{ITEM}")
    elif any(isinstance(cell, (dict, list)) for row in value for cell in row.values()):
        for place, each in enumerate(value):
            yield from _variables(f"{path}.{place}", each, units)
    else:
        for key, column in pd.DataFrame(value).items():
            name = f"{path}.{key}"
            yield name, _variable(name, column.tolist(), units, f"{path}.{ROW}")


def _variable(
    path: str, values: list[Any], units: Mapping[str, str], along: str = ITEM
) -> xr.Variable:
    if any(isinstance(each, str) for each in values):
        array = np.array([str(each or "") for each in values])
    elif values and all(isinstance(each, (bool, int)) for each in values):
        array = np.array(values)
    else:
        array = np.array([np.nan if each is None else each for each in values], float)
    unit = units.get(path.rpartition(".")[2], "1")
    attributes = {"units": unit, "long_name": path[len(ROOT) + 1 :].replace(".", " ")}
    return xr.Variable(along, array, attributes)


def content_of(response: Response) -> dict[str, Any]:
    """The content that a model of studs has put into a response; empty for other responses."""
    tree: dict[str, Any] = {}
    for path, variable in response.variables.items():
        root, *keys = str(path).split(".")
        if root == ROOT:
            branch = tree
            for key in keys[:-1]:
                branch = branch.setdefault(key, {})
            branch[keys[-1]] = plain(variable.values)
    content: dict[str, Any] = _nested(tree, ROOT, response.sizes)
    return content


def _nested(value: Any, path: str, sizes: Mapping[Any, int]) -> Any:
    """Columns become the rows of their table, mappings whose keys are places lists again."""
    if not isinstance(value, dict):
        return value
    if f"{path}.{ROW}" in sizes:
        return plain(pd.DataFrame(value))
    inner = {key: _nested(each, f"{path}.{key}", sizes) for key, each in value.items()}
    if inner and all(key.isdigit() for key in inner):
        return [inner[key] for key in sorted(inner, key=int)]
    return inner
