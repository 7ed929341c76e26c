"""A table of any header and units in the form of a schema of the workbench, line by line.

Columns are found by the mapping, by the name of the schema (``span_m``), or by that name without
its unit or with another one (``span``, ``span_ft``). Every number that has a dimension must say its
unit: in the name, in brackets after the name, in a row of units, or in the mapping. Units are a
closed list per quantity, each with its value in SI.
"""

import re
from collections.abc import Iterator
from collections.abc import Mapping as Dictionary
from dataclasses import dataclass, replace
from typing import NamedTuple

from workbench.base.errors import InputError
from workbench.base.fields import Number, did_you_mean
from workbench.base.tables import Cells, text_of
from workbench.extras.intake.mapping import Mapping
from workbench.studs.schema import (
    EXTRA,
    CellProblem,
    Examination,
    TableColumn,
    TableSchema,
    examined,
    width_findings,
)

_BRACKETS = re.compile(r"(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]+)[\])]")
_PURE = {"": 1.0, "-": 1.0, "1": 1.0, "%": 0.01}  # units of what has no dimension


class ColumnMapping(NamedTuple):
    """A column of a table: its `name` there, the `column` of the schema, its `unit` ("": open).

    The column is None for one of the user's own; `factor`, what numbers are multiplied by.
    """

    name: str
    column: TableColumn | None
    unit: str = ""
    factor: float | None = None

    @property
    def target(self) -> str:
        """Its name in the form of the schema."""
        return self.column.name if self.column else self.name


@dataclass(frozen=True)
class Converted:
    """A table as `cells` of a schema, on the lines that it had; `notes` say what was changed.

    `origin` gives the name in the table, with its unit, of columns that were converted or renamed;
    `problems`, rows that have not as many cells as the header, which are left out.
    """

    cells: Cells
    origin: dict[str, str]
    notes: tuple[str, ...]
    problems: tuple[CellProblem, ...]


def find(name: str, table: TableSchema) -> ColumnMapping | None:
    """The column of a schema that a name means, with the unit that the name says."""
    for column in table.columns:
        unit, base = column.unit, column.base
        if name == column.name:
            return ColumnMapping(name, column, unit)
        if unit and name == base:
            return ColumnMapping(name, column)
        ending = name.removeprefix(f"{base}_").replace("_per_", "/")
        if unit and name.startswith(f"{base}_") and is_unit(ending):
            return ColumnMapping(name, column, ending)
    return None


def convert(
    cells: Cells, table: TableSchema, mapping: Mapping, constants: Dictionary[str, str]
) -> Converted:
    """The cells of a table in the form of a schema.

    Arguments: `constants`, cells of columns of the schema that the table lacks, beside those of the
    mapping. Raises `InputError` for columns and units that are not known.
    """
    name, names, rows = cells.name, cells.header, cells.rows[1:]
    field = f"{name}, line {cells.rows[0][0]}"
    _check_mapping(mapping, names)
    places = [place_of(name, table, mapping, field) for name in names]
    taken_by: dict[str, str] = {}
    for place in filter(None, places):
        if (first := taken_by.setdefault(place.target, place.name)) != place.name:
            raise InputError(field, place.name, f"is {place.target}, and so is {first}")
    units = _unit_row(cells, places, mapping)
    if units is not None:
        rows = rows[1:]
    places = [
        place and _scaled(place, unit, mapping, name)
        for place, unit in zip(places, units or [""] * len(places), strict=True)
    ]
    fixed = _constants(mapping, table, places, cells.decimal)
    taken = {place.target for place in places if place} | set(fixed)
    fixed |= {name: cell for name, cell in constants.items() if name not in taken}
    header = [place.target for place in places if place] + list(fixed)
    converted, problems = [(cells.rows[0][0], header)], list[CellProblem]()
    for line, texts in rows:
        if wrong := width_findings(texts, len(places)):
            problems.append(CellProblem(name, line, *wrong[0]))
            continue
        values = [
            _cell(text, place.factor, mapping.missing, cells)
            for text, place in zip(texts, places, strict=True)
            if place
        ]
        converted.append((line, values + list(fixed.values())))
    origin, changes = _changes(filter(None, places), mapping)
    kept, notes = cells._replace(rows=converted), (*cells.notes, *changes)
    return Converted(kept, origin, notes, tuple(problems))


def examined_from(converted: Converted, table: TableSchema) -> Examination:
    """The rows; a bad cell is named by the column of the file that it came from."""
    if converted.problems and len(converted.cells.rows) == 1:
        raise converted.problems[0].error()
    found, problems = examined(converted.cells, table), list(converted.problems)
    for problem in found.problems:
        column, origin = problem.column, converted.origin.get(problem.column)
        problems.append(replace(problem, column=f"{column} (from {origin})" if origin else column))
    problems.sort(key=lambda problem: problem.line)
    return replace(found, problems=tuple(problems))


def place_of(name: str, table: TableSchema, mapping: Mapping, field: str) -> ColumnMapping | None:
    """Where a column of a table belongs; None if it is to be ignored. Raises `InputError`."""
    if name in mapping.ignore:
        return None
    bracketed = _BRACKETS.fullmatch(name)
    bare, unit = name, ""
    if bracketed and (is_unit(bracketed["unit"]) or bracketed["unit"] in _PURE):
        bare, unit = bracketed["name"], spelled(bracketed["unit"])
    columns = mapping.columns or {}
    given = columns.get(name, columns.get(bare))
    meant = find(given or bare, table)
    if meant is not None:
        if not given and meant.unit and unit and spelled(meant.unit) != unit:
            raise InputError(field, name, f"says two units, {meant.unit} and {unit}")
        if given == meant.target:  # the column of the schema: the unit of the table is open
            meant = meant._replace(unit="")
        return meant._replace(name=name, unit=unit or meant.unit)
    if (given or bare).startswith(EXTRA):
        return ColumnMapping(name, None)
    text, guess = "is no column of the workbench", did_you_mean(given or bare, table.names)
    if given:
        raise InputError(f"mapping, columns.{name}", given, text, guess)
    advice = f"{guess} name it in [columns] or in `ignore` of a mapping file".lstrip()
    raise InputError(field, name, text, advice)


def _check_mapping(mapping: Mapping, names: list[str]) -> None:
    """Refuse a mapping of columns that are not there."""
    bare = {match["name"] for name in names if (match := _BRACKETS.fullmatch(name))}
    for part in ("columns", "units", "ignore"):
        for name in getattr(mapping, part) or ():
            if name not in names and name not in bare:
                text = "names a column that the table does not have"
                advice = "it has " + ", ".join(names)
                raise InputError(f"mapping, {part}", name, text, advice)


def _unit_row(
    cells: Cells, places: list[ColumnMapping | None], mapping: Mapping
) -> list[str] | None:
    """The units in the first row after the header, None if it holds a test."""
    if len(cells.rows) < 2 or mapping.unit_row is False:
        return None
    line, texts = cells.rows[1]
    of_numbers = [
        text
        for text, place in zip(texts, places, strict=False)
        if place and place.column and isinstance(place.column.rule, Number)
    ]
    has_units = any(map(is_unit, of_numbers))
    has_units = has_units and not any(cells.number(text) is not None for text in of_numbers)
    if mapping.unit_row and (not has_units or len(texts) != len(places)):
        raise InputError(f"{cells.name}, line {line}", ",".join(texts), "is no row of units")
    if not has_units or len(texts) != len(places):
        return None
    return [spelled(text) for text in texts]


def _scaled(place: ColumnMapping, in_row: str, mapping: Mapping, name: str) -> ColumnMapping:
    """A column with the unit of its numbers and their factor, which words do not have."""
    column = place.column
    if column is None or not isinstance(column.rule, Number):
        return place
    field = f"{name}, column {place.name}"
    given = (mapping.units or {}).get(place.name, "")
    stated = [unit for unit in (place.unit, in_row, given) if unit not in ("", "-")]
    units = list(dict.fromkeys(map(spelled, stated)))
    if len(units) > 1:
        advice = "its name, the row of units and the mapping must agree"
        raise InputError(field, " and ".join(units), "says two units", advice)
    if column.unit and not units:
        text = f"says no unit: {column.meaning}"
        advice = "give it in the name, in a row of units, or in [units] of the mapping"
        raise InputError(field, None, text, advice)
    (unit,) = units or [""]
    if not column.unit and unit not in _PURE:
        raise InputError(field, unit, "has no unit: " + column.meaning)
    by = factor(unit, column.unit, field) if column.unit else _PURE[unit]
    return place._replace(unit=given or in_row or place.unit, factor=by)


def _constants(
    mapping: Mapping, table: TableSchema, places: list[ColumnMapping | None], decimal: str
) -> dict[str, str]:
    """Cells that the mapping gives for all rows, by column of the schema."""
    taken = {place.target: place.name for place in places if place}
    cells: dict[str, str] = {}
    written = Cells("mapping", [], ".")
    for name, cell in (mapping.constants or {}).items():
        field = f"mapping, constants.{name}"
        place = find(name, table)
        if place is None or place.column is None:
            advice = did_you_mean(name, table.names)
            raise InputError(field, cell, "is no column of the workbench", advice)
        column = place.column
        if column.name in taken:
            raise InputError(field, cell, f"stands in the table too, in {taken[column.name]}")
        if column.unit and not place.unit:
            raise InputError(field, cell, "says no unit", f"write {column.name}")
        by = factor(place.unit, column.unit, field) if column.unit else None
        text = _cell(cell, by, (), written)
        number = isinstance(column.rule, Number)
        cells[column.name] = text.replace(".", decimal) if number else text
    return cells


def _cell(cell: str, by: float | None, missing: tuple[str, ...], cells: Cells) -> str:
    """A cell in the unit of the schema; what is no number is left to the schema to refuse."""
    text = " ".join(cell.split())
    if by is None:
        return text
    if text in missing:
        return ""
    number = cells.number(text)
    if by == 1.0 or number is None:
        return text
    return text_of(float(f"{number * by:.12g}"), cells.decimal)


def _changes(
    places: Iterator[ColumnMapping], mapping: Mapping
) -> tuple[dict[str, str], tuple[str, ...]]:
    """Where converted columns are from, and what was changed, one sentence per column."""
    origin, notes = {}, []
    for name, column, unit, by in places:
        if column and (name in (mapping.columns or {}) or by not in (None, 1.0)):
            origin[column.name] = name + (f" in {unit}" if unit and by else "")
            times = f", times {by:.9g}" if by not in (None, 1.0) else ""
            notes.append(f"{origin[column.name]} is {column.name}{times}")
    notes += [f"{name} is left out" for name in mapping.ignore]
    notes += [f"{name} = {cell} in all rows" for name, cell in (mapping.constants or {}).items()]
    return origin, tuple(notes)


_INCH, _POUND, _POUND_FORCE = 0.0254, 0.45359237, 4.4482216152605
_SQUARE_INCH = _INCH**2
UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 0.01, "mm": 1e-3, "in": _INCH, "ft": 12.0 * _INCH},
    "force": {
        **{"N": 1.0, "kN": 1e3, "MN": 1e6, "kgf": 9.80665, "tf": 9806.65},
        **{"lbf": _POUND_FORCE, "kip": 1e3 * _POUND_FORCE},
    },
    "stress": {
        **{"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm2": 1e6},
        **{"psi": _POUND_FORCE / _SQUARE_INCH, "ksi": 1e3 * _POUND_FORCE / _SQUARE_INCH},
    },
    "stiffness": {
        **{"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "kN/mm": 1e6},
        **{"lbf/in": _POUND_FORCE / _INCH, "kip/in": 1e3 * _POUND_FORCE / _INCH},
    },
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": _POUND},
    "velocity": {
        **{"m/s": 1.0, "mm/s": 1e-3, "mm/ms": 1.0, "km/h": 1.0 / 3.6},
        **{"ft/s": 12.0 * _INCH, "mph": 0.44704},
    },
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "energy": {"J": 1.0, "kJ": 1e3, "MJ": 1e6, "N m": 1.0, "kN m": 1e3, "N mm": 1e-3, "kN mm": 1.0},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3, "lb/ft3": _POUND / (12.0 * _INCH) ** 3},
}
_SPELLED = {
    **{"kips": "kip", "lbs": "lb", "inch": "in", "inches": "in", "kph": "km/h", "N/mm²": "N/mm2"},
    **{"kg/m³": "kg/m3", "kg/m^3": "kg/m3", "N/mm^2": "N/mm2", "g/cm³": "g/cm3", "pcf": "lb/ft3"},
}
_ALL = {unit: (quantity, value) for quantity, of in UNITS.items() for unit, value in of.items()}


def spelled(unit: str) -> str:
    """A unit as the list spells it, brackets around it left out."""
    bare = unit.strip().strip("[]()").strip().rstrip(".")
    return _SPELLED.get(bare, bare)


def is_unit(text: str) -> bool:
    """Whether a text is a unit of the list."""
    return spelled(text) in _ALL


def factor(unit: str, into: str, field: str) -> float:
    """How many of the unit `into` one `unit` is.

    Raises `InputError` naming `field` for a unit that is not on the list, or of another quantity.
    """
    quantity, value = _ALL[into]
    exact = _ALL.get(spelled(unit))
    if exact is None or exact[0] != quantity:
        allowed = f"is no unit of a {quantity} that is known; " + ", ".join(UNITS[quantity])
        raise InputError(field, unit, allowed, did_you_mean(unit, UNITS[quantity]))
    return exact[1] / value
