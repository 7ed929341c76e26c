"""Models of studs, common parts: tables split by campaign, responses; the tests as a model."""

import hashlib
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import xarray as xr

from workbench.base.catalogue import dataset
from workbench.base.errors import InputError, OutOfDomainError
from workbench.base.tables import FILES
from workbench.models.base import Answering
from workbench.responses import Finding, Response, build_response, finding, set_attributes
from workbench.responses.uncertainty import DATA_WIDTHS, SAMPLE_WIDTHS, SAMPLED
from workbench.scenarios import Scenario
from workbench.scenarios.stud_tests import StudTests
from workbench.studs.damaged import damaged_rows
from workbench.studs.fit_protocol import StudAnswer, Tables, plain
from workbench.studs.interaction import combined_tests
from workbench.studs.schema import POINTS, TESTS, TableSchema, examine
from workbench.studs.tables import (
    campaigns_of,
    check_campaigns,
    first_loading,
    joined,
    shipped,
    split_table,
    table_schemas,
    undamaged_headed_studs,
)


@dataclass(frozen=True)
class DataSplit:
    """Tests and load-slip points, those that `calibrate` and those that `validate`.

    Frames of the schemas `TESTS` and `POINTS`; without rows where the scenario names no table.
    """

    calibration: pd.DataFrame
    validation: pd.DataFrame
    calibration_points: pd.DataFrame
    validation_points: pd.DataFrame


def load_split(scenario: StudTests) -> DataSplit:
    """The tables of a scenario, split by campaign.

    Raises `InputError` for a name that is no table of the schema, a bad row, a campaign that no
    table has, or a specimen that stands in two tables.
    """
    tests, points = _joined(scenario.tables, TESTS), _joined(scenario.curves, POINTS)
    check_campaigns((*scenario.calibrate, *scenario.validate), tests, points)
    parts = (split_table(each, scenario.calibrate, scenario.validate) for each in (tests, points))
    (calibration, validation), (calibration_points, validation_points) = parts
    return DataSplit(calibration, validation, calibration_points, validation_points)


def _joined(names: Sequence[str], schema: TableSchema) -> pd.DataFrame:
    tables = []
    for name in names:
        if name.endswith(FILES):
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
class StudModel(Answering):
    """A model that answers questions to tests on studs; its options are those of its own fields.

    A model names what may be asked of it (`asks`, empty: anything) and finds the answer in the
    tests that calibrate and validate. `units` of columns of its tables, where not the usual ones.
    A response has the scalars of the answer, and its tables as typed variables. What the tests do
    not support (`InputError` of `find`) becomes a refusal, out-of-domain; `simulate` raises
    `InputError` for tables that cannot be read.
    """

    name: ClassVar[str]
    version: ClassVar[int] = 13
    answers: ClassVar[tuple[str, ...]] = (StudTests.KIND,)
    assumptions: ClassVar[tuple[str, ...]]
    asks: ClassVar[tuple[str, ...]] = ()
    units: ClassVar[Mapping[str, str]] = {}

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
        question = scenario.asked if isinstance(scenario, StudTests) else ""
        if not question or not self.asks or question in self.asks:
            return []
        asks = ", ".join(self.asks)
        return [finding("question", name=self.name, asks=asks, question=question)]

    @abstractmethod
    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """Answer from the tests. Raises `InputError`, `OutOfDomainError`, `SolverError`."""

    def _solve(self, scenario: StudTests) -> Response:
        split = load_split(scenario)
        try:
            answer = self.find(scenario, split)
        except InputError as error:
            raise OutOfDomainError(str(error)) from error
        judged = answer.judged.scalars if answer.judged else {}
        scalars = {**answer.scalars, **{name: each.value for name, each in judged.items()}}
        response = build_response(scalars, warnings=answer.findings)
        widths: dict[str, Any] = {str(name): 0.0 for name in response.data_vars}
        if not answer.exact:
            widths = {name: each.width for name, each in judged.items() if each.width is not None}
        kind = DATA_WIDTHS if answer.exact else SAMPLE_WIDTHS  # over tests
        set_attributes(response, **{kind: plain(widths)})
        if answer.judged is not None:
            ends = {name: each.ends for name, each in judged.items() if each.ends is not None}
            set_attributes(response, **{SAMPLED: plain(ends)})
        return with_tables(response, answer.tables, {**UNITS, **self.units})


_MEANING = {
    "strength": "the strength of undamaged studs",
    "load-slip": "load and slip",
    "interaction": "tension and shear together",
    "residual-strength": "strength after pre-damage",
    "residual-stiffness": "stiffness after pre-damage",
}
RESIDUAL = {"residual-strength": "strength", "residual-stiffness": "stiffness"}


@dataclass(frozen=True)
class StudMeasured(StudModel):
    """Tests on studs: test over prediction is one for them, and bands hold what they claim.

    It refuses what the validating campaigns do not hold, so that nothing is judged by it.
    """

    name: ClassVar[str] = "stud-measured"
    assumptions: ClassVar[tuple[str, ...]] = (
        "Tests as published transcriptions give them; the uncertainty of single loads and slips "
        "is not reported, so that it stays in the scatter.",
        "Rows that their authors or the catalogue flag as unfit do not count.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the shipped tests."""
        tables = ("stud-push-out", "stud-load-slip")
        return tuple(dict.fromkeys(key for name in tables for key in dataset(name).keys))

    def find(self, scenario: StudTests, split: DataSplit) -> StudAnswer:
        """The tests that validate, with the values that a perfect prediction would have."""
        question = scenario.asked
        fitted = _rows(question, split.calibration, split.calibration_points)
        if split.validation.empty and split.validation_points.empty:
            counted = len(fitted.drop_duplicates(["campaign", "specimen"])) if len(fitted) else 0
            scalars: dict[str, float | None] = {"tests_fitted": float(counted)}
            return StudAnswer({"calibration": fitted}, scalars=scalars, exact=True)
        rows = _rows(question, split.validation, split.validation_points)
        if rows.empty:
            campaigns = ", ".join(campaigns_of(split.validation, split.validation_points))
            where = f"in the validating campaigns ({campaigns})"
            raise OutOfDomainError(f"no test of {_MEANING[question]} {where}")
        names = ["test_over_prediction", "least_test_over_prediction"]
        names = ["stiffness_test_over_prediction"] if question == "load-slip" else names
        scalars = {"coverage": scenario.confidence, **dict.fromkeys(names, 1.0)}
        return StudAnswer({"calibration": fitted, "validation": rows}, scalars=scalars, exact=True)


def _rows(question: str, tests: pd.DataFrame, points: pd.DataFrame) -> pd.DataFrame:
    """Rows that answer the question, one per test or point; may be empty."""
    nothing = pd.DataFrame(columns=["campaign", "specimen"])
    if question == "load-slip":
        return nothing if points.empty else first_loading(points, falling=True)
    if question == "interaction":
        return combined_tests(tests)
    if question in RESIDUAL:
        rows = damaged_rows(tests, RESIDUAL[question])
        return rows[["campaign", "specimen", "predamage", "level", "ratio", "origin"]]
    try:
        rows = undamaged_headed_studs(tests)
    except InputError:
        return nothing
    return rows[["campaign", "specimen", "diameter_mm", "fcm_MPa", "fu_MPa", "shear_kN"]]


# -- the tables of an answer as typed variables of its response ----------------------------------
# Column `bias` of the table `fit` is the variable ``answer.fit.bias`` along ``answer.fit.row``; NaN
# is not known, or not reported. Any netCDF reader gets numbers and units.

ROOT = "answer"
UNITS = {
    **dict.fromkeys(("load", "collar", "friction", "P_Rk", "P_Rd", "r_m", "r_k", "r_d"), "N"),
    **dict.fromkeys(("r_nominal", "strength_test", "strength_model", "mean", "lowest"), "N"),
    **dict.fromkeys(("steel_term", "concrete_term", "other_concrete_term", "resistance"), "N"),
    **dict.fromkeys(("slip", "slip_at_max", "slip_capacity", "slip_test", "slip_model"), "m"),
    **dict.fromkeys(("diameter", "height", "peak_slip", "yield_slip"), "m"),
    **dict.fromkeys(("embedment", "head_diameter"), "m"),
    **dict.fromkeys(("concrete_strength", "concrete_modulus", "ultimate_strength"), "Pa"),
    **dict.fromkeys(("chord_stiffness", "stiffness_test", "stiffness_model"), "N/m"),
    "rate": "1/m",
}


def with_tables(response: Response, tables: Tables, units: Mapping[str, str]) -> Response:
    """The response with tables; `units` by column, of numbers that have one."""
    columns = {
        f"{ROOT}.{key}.{name}": xr.Variable(
            f"{ROOT}.{key}.row",
            _typed(column),
            {"units": units.get(str(name), "1"), "long_name": f"{key} {name}".replace("_", " ")},
        )
        for key, table in tables.items()
        if len(table)
        for name, column in table.items()
    }
    stored: Response = response.assign(columns)
    return stored


def _typed(column: pd.Series) -> np.ndarray[Any, Any]:
    """Words, flags and whole numbers as they are, other numbers as floats."""
    if any(isinstance(value, str) for value in column):
        return column.fillna("").to_numpy(str)
    if column.dtype.kind in "biu":
        return column.to_numpy()
    return column.to_numpy(float, na_value=np.nan)


def tables_of(response: Response) -> Tables:
    """The tables that a model of studs has put into a response; empty for other responses."""
    columns: dict[str, dict[str, Any]] = {}
    for path, variable in response.variables.items():
        root, _, rest = str(path).partition(".")
        if root == ROOT:
            key, _, name = rest.partition(".")
            columns.setdefault(key, {})[name] = variable.to_numpy()
    return {key: pd.DataFrame(each) for key, each in columns.items()}
