"""One schema for tests on studs: push-out, pull-out, combined, and after pre-damage.

A table is a CSV file with the unit of every number in the name of its column. `TESTS` holds one
row per specimen, `POINTS` the points of measured curves; `columns.csv` beside this file declares
their columns. An empty cell means that the quantity was not reported; it never means zero.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from workbench.fields import Choice, Number, Text

EXTRA = "x_"  # columns of the user's own begin with this and are kept as they are
NO_PREDAMAGE = "none"
HEADED = "headed stud"


@dataclass(frozen=True, slots=True)
class Column:
    """A column: its name with the unit, what it means, and the rule of its cells.

    `filled`: it must exist and no cell may be empty; `default` fills empty words and flags.
    """

    name: str
    meaning: str
    rule: Number | Choice | Text
    filled: bool = False
    default: str = ""

    @property
    def blank(self) -> object:
        """What an empty cell holds."""
        if isinstance(self.rule, Number):
            return float(self.default or "nan")
        return self.default


@dataclass(frozen=True, slots=True)
class Table:
    """A kind of table: its columns, and the columns that together must not repeat (or none)."""

    name: str
    columns: tuple[Column, ...]
    key: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(column.name for column in self.columns)

    def column(self, name: str) -> Column:
        """The column of this name."""
        return self.columns[self.names.index(name)]

    def words(self, name: str) -> tuple[str, ...]:
        """The words that a column of words allows."""
        rule = self.column(name).rule
        return rule.words if isinstance(rule, Choice) else ()


def _declared(table: str) -> tuple[Column, ...]:
    with Path(__file__).with_name("columns.csv").open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["table"] == table]
    return tuple(
        Column(row["name"], row["meaning"], _rule(row), row["needed"] == "yes", row["default"])
        for row in rows
    )


def _rule(row: dict[str, str]) -> Number | Choice | Text:
    match row["kind"]:
        case "text":
            return Text(1000)
        case "word":
            return Choice(tuple(row["words"].split("|")))
        case "flag":
            return Number(0, 1, integer=True)
    low, high = float(row["low"]), float(row["high"])
    above = row["kind"] == "above"
    return Number(low, high, row["unit"], low_included=not above, advice=row["advice"])


TESTS = Table("tests", _declared("tests"), key=("campaign", "specimen"))
POINTS = Table("points", _declared("points"))
