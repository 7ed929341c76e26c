"""Read tables of tests from CSV files; every bad row is named by file, line, column and reason."""

from __future__ import annotations

import csv
import difflib
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import pandas as pd

from workbench.errors import InputError
from workbench.fields import Number
from workbench.studs.checks import row_findings
from workbench.studs.schema import EXTRA, POINTS, TESTS, Column, Table

LARGEST_FILE = 20_000_000  # bytes; a row has some 500, so this holds some 40 000 tests
MOST_ROWS = 50_000
LONGEST_LINE = 65_536  # bytes; no row of any table comes near it
_NUMBER = re.compile(  # float() would also take 1_000 and digits of other scripts
    r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?|[+-]?(nan|inf|infinity)", re.IGNORECASE
)
_SHOWN = 5  # problems that one message lists by line


@dataclass(frozen=True, slots=True)
class Problem:
    """What is wrong with one cell or row: `line` of the file (1 is the header), `column` or ''."""

    file: str
    line: int
    column: str
    value: object
    reason: str
    advice: str = ""

    @property
    def place(self) -> str:
        """File, line and column."""
        return f"{self.file}, line {self.line}" + (f", column {self.column}" if self.column else "")

    def error(self, others: tuple[int, ...] = ()) -> InputError:
        """The problem as an error; `others`, lines of further problems to mention."""
        advice = self.advice
        if others:
            lines = ", ".join(str(line) for line in others[:_SHOWN])
            more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
            mention = f"also look at line{'s' if len(others) > 1 else ''} {lines}{more}"
            advice = f"{advice}; {mention}" if advice else mention
        return InputError(self.place, self.value, self.reason, advice)


@dataclass(frozen=True)
class Examination:
    """A table as found: the good `rows`, and the `problems` of all others."""

    rows: pd.DataFrame
    problems: tuple[Problem, ...]

    def accept(self) -> pd.DataFrame:
        """The rows if all are good. Raises `InputError` that names the first bad one."""
        if self.problems:
            first = self.problems[0]
            lines = {problem.line for problem in self.problems[1:]} - {first.line}
            raise first.error(tuple(sorted(lines)))
        return self.rows


def read_tests(path: str | Path, *, keep_good: bool = False) -> pd.DataFrame:
    """Table of tests on studs (schema `TESTS`), one row per specimen.

    Arguments: `path` of a CSV file; `keep_good`, leave bad rows out instead of refusing the file
    (`examine` says which). Missing numbers are NaN, missing texts empty. Raises `InputError`.
    """
    examination = examine(path, TESTS)
    return examination.rows if keep_good else examination.accept()


def read_points(path: str | Path, *, keep_good: bool = False) -> pd.DataFrame:
    """Table of points of load-slip curves (schema `POINTS`); see `read_tests`."""
    examination = examine(path, POINTS)
    return examination.rows if keep_good else examination.accept()


def examine(path: str | Path, table: Table) -> Examination:
    """Read a CSV file row by row, separating good rows from problems.

    Raises `InputError` when no row can be read at all: missing, too large or binary file, wrong
    separator, unknown or missing columns. Large files are refused before they are read.
    """
    path = Path(path)
    name = path.name
    try:
        size = path.stat().st_size
        if path.is_dir():
            raise InputError(name, str(path), "is a directory, not a CSV file")
        if size > LARGEST_FILE:
            raise InputError(
                name, f"{size / 1e6:.0f} MB", f"must not exceed {LARGEST_FILE / 1e6:.0f} MB",
                "a table of stud tests has a few hundred bytes per specimen: is this the right "
                "file?",
            )  # fmt: skip
        with path.open("rb") as stream:
            return _examine(_lines(stream, name), name, table)
    except OSError as error:
        raise InputError(name, str(path), f"cannot be read: {error.strerror or error}") from error


def _lines(stream: BinaryIO, name: str) -> Iterator[str]:
    """Decoded lines; refuses early what is no text, has no line ends or does not stop."""
    total = 0
    number = 0
    while block := stream.readline(LONGEST_LINE + 1):
        number += 1
        total += len(block)
        place = f"{name}, line {number}"
        if b"\0" in block:
            raise InputError(
                place, block[:20], "is binary data, not text", "save the table as CSV (UTF-8)"
            )
        if len(block) > LONGEST_LINE:
            raise InputError(
                place, block[:20], f"has more than {LONGEST_LINE} characters",
                "one row stands on one line",
            )  # fmt: skip
        if total > LARGEST_FILE:  # a pipe has no size to check beforehand
            raise InputError(place, total, f"the file exceeds {LARGEST_FILE / 1e6:.0f} MB")
        try:
            text = block.decode("utf-8-sig" if number == 1 else "utf-8")
        except UnicodeDecodeError as error:
            raise InputError(
                place, block[error.start : error.start + 4], "is not UTF-8 text",
                "save the table as CSV (UTF-8)",
            ) from error  # fmt: skip
        yield text


def _examine(lines: Iterator[str], name: str, table: Table) -> Examination:
    reader = csv.reader(lines, strict=True)
    try:
        header = next(reader, None)
        columns = _columns(header, name, table)
        rows: list[dict[str, object]] = []
        problems: list[Problem] = []
        seen: dict[tuple[str, ...], int] = {}
        spelling: dict[str, tuple[str, int]] = {}
        for cells in reader:
            line = reader.line_num
            if len(rows) + len(problems) >= MOST_ROWS:
                raise InputError(
                    f"{name}, line {line}", "", f"the table has more than {MOST_ROWS} rows"
                )
            if not any(cell.strip() for cell in cells):
                continue  # an empty line
            row, found = _row(cells, columns, name, line)
            if not found:
                found = [Problem(name, line, *finding) for finding in row_findings(row, table.name)]
            if not found and table.key:
                key = tuple(str(row[part]).casefold() for part in table.key)
                if key in seen:
                    label = ", ".join(str(row[part]) for part in table.key)
                    found = [
                        Problem(name, line, table.key[-1], label, f"stands in line {seen[key]} too",
                                "every specimen of a campaign has its own name")
                    ]  # fmt: skip
                else:
                    seen[key] = line
            if not found and "campaign" in row:
                campaign = str(row["campaign"])
                spelled, first = spelling.setdefault(campaign.casefold(), (campaign, line))
                if campaign != spelled:
                    found = [
                        Problem(name, line, "campaign", campaign,
                                f"is spelled {spelled} in line {first}",
                                "one campaign has one spelling: scatter between campaigns counts")
                    ]  # fmt: skip
            if found:
                problems.extend(found)
            else:
                rows.append(row)
    except csv.Error as error:
        raise InputError(
            f"{name}, line {reader.line_num}", "", f"is not valid CSV: {error}",
            "look for a quotation mark that is not closed",
        ) from error  # fmt: skip
    if not rows and not problems:
        raise InputError(name, "only a header", "must hold one row or more")
    return Examination(_frame(rows, columns, table), tuple(problems))


def _columns(header: list[str] | None, name: str, table: Table) -> list[Column | str]:
    place = f"{name}, line 1"
    if header is None or not any(cell.strip() for cell in header):
        raise InputError(name, "", "is empty", "the first line names the columns")
    if len(header) == 1:
        for separator, word in ((";", "semicolons"), ("\t", "tabulators")):
            if separator in header[0]:
                raise InputError(
                    place, header[0], f"columns are separated by {word}",
                    "separate them by commas, and write decimal points",
                )  # fmt: skip
    names = [cell.strip() for cell in header]
    known = table.names
    columns: list[Column | str] = []
    for position, column in enumerate(names, start=1):
        if not column:
            raise InputError(place, column, f"column {position} has no name")
        if names.count(column) > 1:
            raise InputError(place, column, "the column stands twice")
        if column.startswith(EXTRA):
            columns.append(column)
        elif column in known:
            columns.append(table.column(column))
        else:
            near = difflib.get_close_matches(column, known, 1, 0.5)
            advice = f"did you mean {near[0]}? " if near else ""
            raise InputError(
                place, column, "unknown column",
                f"{advice}columns of your own begin with {EXTRA}",
            )  # fmt: skip
    missing = [c.name for c in table.columns if c.required and c.name not in names]
    if missing:
        raise InputError(
            place, ", ".join(missing), "required column missing", "units belong to the name"
        )
    return columns


def _row(
    cells: list[str], columns: list[Column | str], name: str, line: int
) -> tuple[dict[str, object], list[Problem]]:
    if len(cells) != len(columns):
        reason = f"has {len(cells)} cells where the header has {len(columns)}"
        advice = "put a text with commas in quotation marks, and write decimal points: 19.05"
        return {}, [Problem(name, line, "", ",".join(cells), reason, advice)]
    row: dict[str, object] = {}
    found: list[Problem] = []
    for cell, column in zip(cells, columns, strict=True):
        text = cell.strip()
        if isinstance(column, str):
            row[column] = text
            continue
        try:
            row[column.name] = _cell(text, column)
        except InputError as error:
            found.append(Problem(name, line, column.name, error.value, error.allowed, error.advice))
    return row, found


def _cell(text: str, column: Column) -> object:
    if not text:
        if column.filled:
            raise InputError(column.name, text, "must not be empty")
        if column.is_number:
            return float(column.default) if column.default else float("nan")
        return column.default
    if not isinstance(column.rule, Number):
        return column.rule.check(column.name, text)
    if not _NUMBER.fullmatch(text):
        allowed = column.rule.allowed()
        advice = "write the number alone: no unit, no words"
        parts = text.split(",")
        if len(parts) == 2 and all(part.lstrip("-").isdigit() for part in parts):
            advice = f"write a decimal point: {parts[0]}.{parts[1]}"
        raise InputError(column.name, text, allowed, advice)
    return float(column.rule.check(column.name, float(text)))


def _frame(
    rows: list[dict[str, object]], columns: list[Column | str], table: Table
) -> pd.DataFrame:
    """All columns of the schema in its order, then the user's own."""
    present = {column.name for column in columns if isinstance(column, Column)}
    data: dict[str, object] = {}
    for column in table.columns:
        if column.name in present:
            values = [row[column.name] for row in rows]
        else:
            values = [_cell("", _optional(column)) for _ in rows]
        dtype = float if column.is_number else object
        data[column.name] = pd.Series(values, dtype=dtype)
    for extra in columns:
        if isinstance(extra, str):
            data[extra] = pd.Series([row[extra] for row in rows], dtype=object)
    return pd.DataFrame(data)


def _optional(column: Column) -> Column:
    return Column(column.name, column.meaning, column.rule, default=column.default)


def read_text(text: str, table: Table, name: str = "table") -> Examination:
    """Examine a table given as text (see `examine`)."""
    return _examine(_lines(io.BytesIO(text.encode()), name), name, table)


def from_frame(frame: pd.DataFrame, table: Table, name: str = "table") -> pd.DataFrame:
    """A data frame made elsewhere, checked and completed by a schema (see `read_tests`)."""
    return read_text(frame.to_csv(index=False), table, name).accept()
