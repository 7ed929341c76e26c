"""Tables of points that a user gives as CSV text: curves and histories."""

import csv
from collections.abc import Mapping

import numpy as np

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.fields import Number

_MOST_POINTS = 10_000


def read_points(
    data: bytes, name: str, field: str, columns: Mapping[str, Number], fewest: int = 3
) -> tuple[Array, list[int]]:
    """Points (n, columns) of a CSV text of numbers, rising in the first column; and their lines.

    Arguments: `name` of the file, `field` that asks for it, rules of its `columns` by their names.
    Raises `InputError` with the name and the line.
    """
    try:
        lines = list(csv.reader(data.decode("utf-8-sig").splitlines(), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(field, name, f"is no CSV text: {error}") from error
    rows = [(n, row) for n, row in enumerate(lines, 1) if row]
    if not rows or [cell.strip() for cell in rows[0][1]] != list(columns):
        raise InputError(field, name, f"must begin with the line {','.join(columns)}")
    if not fewest <= len(rows) - 1 <= _MOST_POINTS:
        text = f"must have {fewest} to {_MOST_POINTS} points, not {len(rows) - 1}"
        raise InputError(field, name, text)
    table = np.array([_numbers(f"{name}, line {n}", row, columns) for n, row in rows[1:]])
    falls = np.flatnonzero(np.diff(table[:, 0]) <= 0.0)
    if len(falls):
        n, row = rows[falls[0] + 2]
        text = "must be larger than that of the point before"
        raise InputError(f"{name}, line {n}, {next(iter(columns))}", float(row[0]), text)
    return table, [n for n, _ in rows[1:]]


def _numbers(place: str, row: list[str], columns: Mapping[str, Number]) -> list[float]:
    try:
        numbers = [float(cell) for cell in row]
    except ValueError:
        numbers = []
    if len(numbers) != len(columns):
        count = {2: "two", 3: "three"}.get(len(columns), str(len(columns)))
        advice = "decimals have a point, columns a comma"
        raise InputError(place, ",".join(row), f"must be {count} numbers", advice)
    held = zip(columns.items(), numbers, strict=True)
    return [float(rule.check(f"{place}, {column}", value)) for (column, rule), value in held]
