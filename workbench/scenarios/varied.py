"""A scenario with some of its values varied, a row each: built when asked, or many as a stack.

A *stack* is a struck column whose numbers are arrays, a value per row: formulas that take arrays
answer all its rows at once. Sections, ends and laws are the same in all rows of a stack.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any, overload

import numpy as np
import pandas as pd

from workbench.base.arrays import Array, Indices
from workbench.base.codec import Input, inputs_of, values_beside
from workbench.base.errors import InputError
from workbench.base.fields import Flag, Number
from workbench.scenarios.column import Column, ColumnImpact, Striker
from workbench.scenarios.files import KINDS, Scenario, scenario_from, to_toml
from workbench.scenarios.parts import OVERRIDES
from workbench.steel.materials import Steel

Path_ = tuple[str | int, ...]
_PARTS: dict[str, Any] = {"column": Column, "steel": Steel, "striker": Striker}
_LAWS = ("stiffness", "hardening_modulus")  # with them, or without: other equations
NUMBERS: dict[Path_, Number] = {  # of struck columns, that may differ within a stack
    (table, field.name): field.metadata["rule"]
    for table, kind in {**_PARTS, "time": ColumnImpact}.items()
    for field in fields(kind)
    if isinstance(field.metadata["rule"], Number) and field.name not in _LAWS
}


@dataclass(frozen=True)
class Varied(Sequence[Scenario]):
    """Scenarios by row, each built from its values when it is asked for.

    Arguments: `tables` of a scenario as TOML gives them; values of each row, `by_key` (and
    numbers of list entries) that leads to them. Taking a row raises `InputError` for its values.
    """

    tables: Mapping[str, Any]
    by_key: Mapping[Path_, Sequence[Any] | Array]

    def __len__(self) -> int:
        return len(next(iter(self.by_key.values())))

    @overload
    def __getitem__(self, row: int) -> Scenario: ...
    @overload
    def __getitem__(self, row: slice) -> "Varied": ...
    def __getitem__(self, row: int | slice) -> "Scenario | Varied":
        if isinstance(row, slice):
            return Varied(self.tables, {path: each[row] for path, each in self.by_key.items()})
        tables = self.tables
        for path, column in self.by_key.items():
            tables = put(tables, path, column[row])
        return scenario_from(tables, self._alike)

    @cached_property
    def _alike(self) -> dict[tuple[Any, str], Any]:
        """Values that all rows have in common, a frame or its members, made once."""
        varied = {str(path[0]) for path in self.by_key}
        kind = None if "kind" in varied else KINDS.get(str(self.tables.get("kind")))
        try:
            return {} if kind is None else values_beside(kind, self.tables, varied)
        except InputError:  # each row says so
            return {}


_SIZES = {  # of what is 0 or not given, by unit
    **{
        "": 0.5,
        "rad": 0.5,
        "kg": 500.0,
        "kg m2": 50.0,
        "kg/m": 100.0,
        "m": 0.05,
        "m2": 5e-3,
        "m4": 4e-5,
    },
    **{"N": 2e5, "N m": 1e5, "N/m": 1e7, "N m/rad": 1e6, "Pa": 1e9, "s": 0.05, "1/s": 10.0},
}


NO_VALUES: Mapping[str, Sequence[Any]] = MappingProxyType({})


def with_other_inputs(
    scenario: Any, values: Mapping[str, Sequence[Any]] = NO_VALUES
) -> Iterator[tuple[Input, Scenario]]:
    """Scenarios that differ from this one in a single input, with that.

    Of each number, flag or choice, and of what has `values` by its path; none that is refused.
    """
    tables = tomllib.loads(to_toml(scenario))
    for each in inputs_of(scenario):
        for value in values.get(each.path) or _others(each.rule, each.value):
            with suppress(InputError):
                yield each, scenario_from(put(tables, each.keys, value))


def _others(rule: Any, present: Any) -> list[Any]:
    """Other values than the present one that a rule may allow."""
    if isinstance(rule, Number):
        return [1.3 * present, 0.7 * present] if present else [_SIZES.get(rule.unit)]
    if isinstance(rule, Flag):
        return [not present]
    return [word for word in getattr(rule, "words", ()) if word != present]


def put(part: Any, path: Path_, value: Any) -> Any:
    """Return nested tables with another value; they share what is not on the path to it."""
    if not path:
        return value.item() if isinstance(value, np.generic) else value
    copy: Any = list(part) if isinstance(part, list) else dict(part)
    inner = copy.get(path[0], {}) if isinstance(copy, dict) else copy[path[0]]
    copy[path[0]] = put(inner, path[1:], value)
    return copy


def stacks(scenarios: Sequence[Scenario]) -> Iterator[tuple[Indices, ColumnImpact | None]]:
    """Rows that are a stack together, with it; with None rows that must be asked one by one.

    Those are no struck columns, or are refused, each with its own words.
    """
    if isinstance(scenarios, Varied):
        yield from _of_values(scenarios)
        return
    alike: dict[Any, list[int]] = {}
    for row, scenario in enumerate(scenarios):
        alike.setdefault(_same(scenario), []).append(row)
    for key, rows in alike.items():
        if key is None:
            yield np.array(rows), None
        else:
            yield np.array(rows), _gathered([scenarios[row] for row in rows])


def take(part: Any, rows: Any) -> Any:
    """Some rows of a stack, as a stack; of one row, a whole number, the numbers."""
    values = {}
    for field in fields(part):
        value = getattr(part, field.name)
        if isinstance(value, np.ndarray):
            values[field.name] = float(value[rows]) if isinstance(rows, int) else value[rows]
        elif isinstance(value, (Column, Steel, Striker)):
            values[field.name] = take(value, rows)
    return part.unchecked(**values) if values else part


def spread(value: Any, count: int) -> Array:
    """A number, or one per row, as an array of `count`."""
    return np.ascontiguousarray(np.broadcast_to(np.asarray(value, float), count))


def _of_values(varied: Varied) -> Iterator[tuple[Indices, ColumnImpact | None]]:
    """The stacks of a varied scenario: what is no number of a column tells them apart."""
    rows = np.arange(len(varied))
    if varied.tables.get("kind") != ColumnImpact.KIND:
        yield rows, None
        return
    numbers: dict[Path_, Array] = {}
    groups = np.zeros(len(varied), np.int64)
    for path, column in varied.by_key.items():
        array = _numbers(path, column)
        if array is not None:
            numbers[path] = array
        else:
            codes = pd.factorize(np.array([repr(value) for value in column], object))[0]
            groups = pd.factorize(groups * (codes.max() + 1) + codes)[0]
    inside = np.ones(len(varied), bool)
    for path, array in numbers.items():
        inside &= NUMBERS[path].holds(array)
    for group in range(int(groups.max(initial=0)) + 1):
        members = rows[groups == group]
        base = _first(varied, members[inside[members]])
        if not isinstance(base, ColumnImpact) or (base.striker.crushes and len(numbers) > 0):
            yield members, None
            continue
        stack = _stacked(
            base, {path: array[members] for path, array in numbers.items()}, len(members)
        )
        refused = stack.column.is_squashed | stack.column.is_stocky | stack.is_turned_twice
        fit = inside[members] & ~refused
        if fit.any():
            yield members[fit], take(stack, fit)
        if not fit.all():
            yield members[~fit], None


def _first(varied: Varied, rows: Indices) -> Scenario | None:
    """The first of some rows that can be built; None if none can."""
    for row in rows:
        try:
            return varied[int(row)]
        except InputError:
            continue
    return None


def _numbers(path: Path_, values: Sequence[Any] | Array) -> Array | None:
    """Values as an array, NaN where they are not allowed; None of what is no number of a column."""
    rule = NUMBERS.get(path)
    if rule is None:
        return None
    if isinstance(values, np.ndarray) and values.dtype.kind == "f":
        return values + 0.0
    read = np.empty(len(values))
    known: dict[str, float] = {}
    for row, value in enumerate(values):
        key = repr(value)
        if key not in known:
            try:
                known[key] = rule.check("", value.item() if hasattr(value, "item") else value)
            except InputError:
                known[key] = np.nan
        read[row] = known[key]
    return read


def _stacked(base: ColumnImpact, numbers: Mapping[Path_, Array], count: int) -> ColumnImpact:
    """A stack of `count` struck columns with other numbers; those of the base stand in each row."""
    by_part: dict[str, dict[str, Array]] = {"column": {}, "steel": {}, "striker": {}, "time": {}}
    for path in NUMBERS:
        table, name = map(str, path)
        given = getattr(_part(base, table), name)
        if path in numbers:
            by_part[table][name] = numbers[path]
        elif given is not None:
            by_part[table][name] = np.broadcast_to(given, count)
    steel = base.column.steel.unchecked(**by_part["steel"])
    column = base.column.unchecked(steel=steel, **by_part["column"])
    striker = base.striker.unchecked(**by_part["striker"])
    return base.unchecked(column=column, striker=striker, **by_part["time"])


def _same(scenario: Scenario) -> Any:
    """Key of what the struck columns of a stack have in common; None of other scenarios."""
    if not isinstance(scenario, ColumnImpact) or scenario.striker.crushes:
        return None
    column, steel = scenario.column, scenario.column.steel
    names = *OVERRIDES, "impact_mass", "unbraced_length"
    given = tuple(getattr(column, name) is None for name in names)
    laws = steel.rate, steel.hardening_modulus
    ends = column.axis, *column.ends, *column.ends_about("weak")
    directions = scenario.acceleration, scenario.striker.angle > 0.0
    return column.section, column.fillets, *ends, *directions, laws, given


def _gathered(scenarios: Sequence[Any]) -> ColumnImpact:
    """The stack of struck columns that are alike."""
    numbers: dict[Path_, Array] = {}
    for table, name in NUMBERS:
        parts = [_part(scenario, str(table)) for scenario in scenarios]
        if getattr(parts[0], str(name)) is not None:
            numbers[table, name] = np.array([getattr(part, str(name)) for part in parts])
    return _stacked(scenarios[0], numbers, len(scenarios))


def _part(scenario: ColumnImpact, table: str) -> Any:
    """The part of a struck column that has a table of its own in files."""
    parts = {"column": scenario.column, "steel": scenario.column.steel, "time": scenario}
    return parts.get(table, scenario.striker)
