"""Impact tests: the schema, one row per test in SI, and the tests of the data catalogue.

``columns.csv`` beside this file declares the columns. A beam is a column without axial load. An
empty cell means that the quantity was not reported. An input of which a range is known has the
middle in its own column and half of the range in that of its uncertainty.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import nan
from pathlib import Path
from typing import Any

from workbench.base.catalogue import IMPACT_TESTS, SYNTHETIC, Dataset, dataset, datasets
from workbench.base.errors import Collapse, InputError, Mechanism
from workbench.base.tables import plain_rows
from workbench.scenarios import ColumnImpact, scenario_from, scenario_hash
from workbench.studs.schema import (
    Row,
    RowFinding,
    TableSchema,
    declared,
    examine,
    known,
    templates_in,
)

# measured quantities: response variable, column, and column of its half-width
MEASURED = {
    "peak_displacement": ("peak_m", "peak_uncertainty_m"),
    "residual_displacement": ("residual_m", "residual_uncertainty_m"),
}
STANDS = "none"  # in the column collapse: the member survived
LARGEST_SHARE = 0.5  # of the span that a peak may reach: beyond, a unit is meant otherwise
_DIMENSIONS = ("height", "width", "web", "flange", "fillet", "side", "wall", "diameter")
# columns of the table by the keys of scenarios, which messages name too
_KEYS = {
    "column.base": "base",
    "column.head": "head",
    "column.axial_load": "axial_load_N",
    "column.restraint_stiffness": "restraint_N_per_m",
    "column.head_mass": "head_mass_kg",
    "steel.elastic_modulus": "elastic_modulus_Pa",
    "steel.yield_stress": "yield_stress_Pa",
    "steel.density": "density_kg_per_m3",
    "striker.mass": "mass_kg",
    "striker.velocity": "velocity_m_per_s",
    "striker.restitution": "restitution",
    "time.duration": "duration_s",
}
# inputs that a test may leave open, by the columns of their half-widths and of the other supports
OPEN = {
    "yield_stress_Pa": "yield_stress_uncertainty_Pa",
    "wall_m": "wall_uncertainty_m",
    "mass_kg": "mass_uncertainty_kg",
    "velocity_m_per_s": "velocity_uncertainty_m_per_s",
    "axial_load_N": "axial_load_uncertainty_N",
}
_ELSE = {"base": "base_else", "head": "head_else"}
SUPPORTS = "supports"
_NAMED = {**_KEYS, "column.section": "section", "column.length_below": "hit_at_m"}


def scenario_of(row: Row) -> ColumnImpact:
    """The scenario of a row of the schema. Raises `InputError` by the keys of scenarios."""
    row = {**{column.name: column.blank for column in IMPACTS.columns}, **row}
    span, hit = float(row["span_m"]), float(row["hit_at_m"])  # type: ignore[arg-type]
    sizes = {name: known(row, f"{name}_m") for name in _DIMENSIONS}
    given = {name: size for name, size in sizes.items() if size is not None}
    tables: dict[str, dict[str, Any]] = {}
    for key, name in _KEYS.items():
        table, _, field = key.partition(".")
        tables.setdefault(table, {})[field] = row[name]
    tables["column"] |= {"section": row["section"] or given, "fillets": row["fillets"] != 0.0}
    tables["column"] |= {"length_below": hit, "length_above": round(span - hit, 9)}
    name = f"{row['campaign']} {row['specimen']}"
    scenario = scenario_from({"kind": ColumnImpact.KIND, "name": name, **tables})
    assert isinstance(scenario, ColumnImpact)
    return scenario


def ends_of(row: Row) -> dict[str, tuple[ColumnImpact, ...]]:
    """The scenarios at the ends of each input that a row leaves open, one input at a time.

    Keys are columns, and `SUPPORTS`: those of both ends of a member are one input.
    Raises `InputError` by the keys of scenarios.
    """
    halves = {name: half for name, column in OPEN.items() if (half := known(row, column))}
    ends = {
        name: tuple(
            scenario_of({**row, name: (known(row, name) or 0.0) + way}) for way in (-half, half)
        )
        for name, half in halves.items()
    }
    other = {name: row[column] for name, column in _ELSE.items() if row.get(column)}
    return {**ends, SUPPORTS: (scenario_of({**row, **other}),)} if other else ends


def _open(row: Row) -> Iterator[RowFinding]:
    """Contradictions of what a row leaves open."""
    for name, column in OPEN.items():
        half, middle = known(row, column), abs(known(row, name) or 0.0)
        if half is not None and half >= middle:
            yield column, half, f"is no less than {name}, {middle:g}", "it is half of a range"
    for name, column in _ELSE.items():
        if row.get(column) and row[column] == row[name]:
            yield column, row[column], f"is {name} itself", "leave it empty"


def _contradictions(row: Row) -> Iterator[RowFinding]:
    """Contradictions within a row whose cells are possible one by one."""
    span, hit = known(row, "span_m") or 0.0, known(row, "hit_at_m") or 0.0
    if hit >= span:
        yield "hit_at_m", hit, f"must be less than the span, {span:g} m", "are columns swapped?"
        return
    sizes = [f"{name}_m" for name in _DIMENSIONS if known(row, f"{name}_m") is not None]
    if row.get("section") and sizes:
        yield "section", row["section"], f"is given, and {', '.join(sizes)} too", "give one of both"
    elif not row.get("section") and not sizes:
        yield "section", "", "must name a profile", "or give its dimensions: side_m, height_m, ..."
    else:
        try:
            scenario_of(row)
        except InputError as error:
            key = next((k for k in _NAMED if error.field.startswith(k)), "")
            yield _NAMED.get(key, ""), error.value, error.allowed, error.advice
    yield from _open(row)
    yield from _measured(row, span)


def _measured(row: Row, span: float) -> Iterator[RowFinding]:
    values = {name: known(row, column) for name, (column, _) in MEASURED.items()}
    if row.get("collapse", STANDS) != STANDS:
        if values["residual_displacement"] is not None:
            yield "residual_m", values["residual_displacement"], "is no result of a collapse", ""
        if values["peak_displacement"] is None:
            yield "peak_m", "", "must be given: the displacement reached in the collapse", ""
        return
    if not any(value is not None for value in values.values()):
        yield "peak_m", "", "must be given, or residual_m: a test without a result is none", ""
    for name, (column, width) in MEASURED.items():
        value, half = values[name], known(row, width)
        if value is None:
            continue
        if half is None:
            reason = f"must be given with {column}"
            yield width, "", reason, "it is the half-width of the 95 % interval"
        elif half >= value:
            yield width, half, f"is no less than {column}, {value:g} m", "are columns swapped?"
        if value > LARGEST_SHARE * span:
            reason = f"is {value / span:.2g} times the span"
            yield column, value, reason, "is it in mm or cm? lengths are in m"
    peak, residual = values.values()
    if peak is not None and residual is not None and residual > peak:
        yield "residual_m", residual, f"exceeds peak_m, {peak:g} m", "are columns swapped?"


IMPACTS = TableSchema(
    "impacts",
    declared("impacts", Path(__file__).with_name("columns.csv")),
    ("campaign", "specimen"),
    _contradictions,
)
(TEMPLATE,) = templates_in(Path(__file__).with_name("templates.toml"), IMPACTS).values()


@dataclass(frozen=True)
class ImpactTest:
    """One test, or several of one scenario: their `names`, `scenario`, `campaign` and `entries`.

    `measured` gives the mean of each quantity with its half-width (95 %): that of single tests, as
    equal tests share their systematic errors, or the farthest of them if that is wider. It is empty
    where the member collapsed, in `collapsed` of the tests: `collapse` says how. `open`: the
    scenarios at the ends of the inputs that it leaves open, by input.
    """

    names: tuple[str, ...]
    campaign: str
    scenario: ColumnImpact
    measured: dict[str, tuple[float, float]]
    entries: tuple[Dataset, ...]
    collapse: Collapse | None = None
    collapsed: int = 0
    open: Mapping[str, tuple[ColumnImpact, ...]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of a case of this test."""
        more = len(self.names) - 1
        return f"{self.names[0]} and {more} equal" if more else self.names[0]

    @property
    def synthetic(self) -> bool:
        """Whether its numbers are made, not measured."""
        return any(entry.role == SYNTHETIC for entry in self.entries)


def tables(name: str | None = None) -> tuple[Dataset, ...]:
    """The tables of impact tests in the catalogue, or the one of this name.

    Raises `InputError` for a name that is none of them.
    """
    entries = tuple(entry for entry in datasets() if entry.kind == IMPACT_TESTS)
    if name is None:
        return entries
    if dataset(name) not in entries:
        known_names = ", ".join(entry.name for entry in entries)
        raise InputError("dataset", name, f"holds no impact tests; there are {known_names}")
    return (dataset(name),)


def impact_tests(name: str | None = None) -> tuple[ImpactTest, ...]:
    """All impact tests of the catalogue, or those of one table; equal scenarios are one test.

    A scenario that has been tested is not shown by synthetic rows. Raises `InputError`.
    """
    groups: dict[str, list[tuple[Dataset, Row, ColumnImpact]]] = {}
    for entry in tables(name):
        digest = hashlib.sha256(entry.path.read_bytes()).hexdigest()
        for row, scenario in _rows(entry.path, digest):
            # how long a response is followed is not part of what was tested
            key = scenario_hash(replace(scenario, duration=1.0))
            groups.setdefault(key, []).append((entry, row, scenario))
    return tuple(_test(group) for group in groups.values())


@lru_cache(maxsize=16)
def _rows(path: Path, digest: str) -> tuple[tuple[Row, ColumnImpact], ...]:
    """The rows of a table with their scenarios; `digest` of the file renews them."""
    rows = examine(path, IMPACTS).accept()
    return tuple((row, scenario_of(row)) for row in plain_rows(rows))


def _test(group: list[tuple[Dataset, Row, ColumnImpact]]) -> ImpactTest:
    real = [part for part in group if part[0].role != SYNTHETIC] or group
    measured = {}
    fallen = [row for _, row, _ in real if row["collapse"] != STANDS]
    for quantity, columns in MEASURED.items():
        pairs = [[known(row, column) or nan for column in columns] for _, row, _ in real]
        reported = [(value, width) for value, width in pairs if value == value]
        if reported and not fallen:
            mean = sum(value for value, _ in reported) / len(reported)
            single = sum(width for _, width in reported) / len(reported)
            farthest = max(abs(value - mean) for value, _ in reported)
            measured[quantity] = (mean, max(single, farthest))
    collapse = None
    if fallen:
        reached = max(known(each, "peak_m") or 0.0 for each in fallen)
        collapse = Collapse(Mechanism(str(fallen[0]["collapse"])), ("member",), reached)
    _, row, scenario = real[0]
    return ImpactTest(
        names=tuple(each.name for _, _, each in real),
        campaign=str(row["campaign"]),
        scenario=scenario,
        measured=measured,
        entries=tuple({entry.name: entry for entry, _, _ in real}.values()),
        collapse=collapse,
        collapsed=len(fallen),
        open=ends_of(row),
    )
