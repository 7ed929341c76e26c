"""Read tables of tests from CSV files; every bad row is named by file, line, column and reason.

The one path by which a table enters: lines, header, cells by the schema, rows by its rules,
and what must not repeat between rows.
"""

import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import pandas as pd

from workbench.datafiles import LARGEST_FILE, open_input
from workbench.errors import InputError
from workbench.fields import Number, did_you_mean
from workbench.studs.schema import COMMENT, EXTRA, TESTS, Column, Row, RowFinding, Table

MOST_ROWS = 50_000
LONGEST_LINE = 65_536  # bytes; no row of any table comes near it
LONGEST_NUMBER = 60  # characters
NUMBER = re.compile(  # float() would also take 1_000 and digits of other scripts
    r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)(e[+-]?[0-9]+)?|[+-]?(nan|inf|infinity)", re.IGNORECASE
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

    def error(self, others: tuple[int, ...] = ()) -> InputError:
        """The problem as an error; `others`, lines of further problems to mention."""
        place = f"{self.file}, line {self.line}" + (f", column {self.column}" * bool(self.column))
        mention = ""
        if others:
            lines = ", ".join(str(line) for line in others[:_SHOWN])
            more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
            mention = f"also look at line{'s' if len(others) > 1 else ''} {lines}{more}"
        advice = "; ".join(text for text in (self.advice, mention) if text)
        return InputError(place, self.value, self.reason, advice)


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


def read_text(text: str, table: Table, name: str = "table") -> Examination:
    """Examine a table given as text (see `examine`)."""
    return _examine(_lines(io.BytesIO(text.encode()), name), name, table)


def from_frame(frame: pd.DataFrame, table: Table, name: str = "table") -> pd.DataFrame:
    """A data frame made elsewhere, checked and completed by a schema (see `read_tests`)."""
    return read_text(frame.to_csv(index=False), table, name).accept()


def examine(path: str | Path, table: Table) -> Examination:
    """Read a CSV file row by row, separating good rows from problems.

    Raises `InputError` when no row can be read at all: missing, too large or binary file, wrong
    separator, unknown or missing columns. Large files are refused before they are read.
    """
    path = Path(path)
    with open_input(path, path.name) as stream:
        return _examine(_lines(stream, path.name), path.name, table)


def raw_rows(path: Path) -> list[tuple[int, list[str]]]:
    """All lines of a CSV file that are not empty, with their numbers; the header is the first.

    Raises `InputError` for what is no such file, and for a header that cannot be one.
    """
    with open_input(path, path.name) as stream:
        rows = list(_rows(_lines(stream, path.name), path.name))
    line, header = rows[0] if rows else (1, None)
    column_names(line, header, path.name)
    return rows


def _rows(lines: Iterator[str], name: str) -> Iterator[tuple[int, list[str]]]:
    """Cells of every line that is neither empty nor, above the header, a comment; its number."""
    reader, above = csv.reader(lines, strict=True), True
    try:
        for count, cells in enumerate(reader):
            if count > MOST_ROWS:
                reason = f"the table has more than {MOST_ROWS} rows"
                raise InputError(f"{name}, line {reader.line_num}", "", reason)
            above = above and (not cells or cells[0].lstrip().startswith(COMMENT))
            if not above and any(cell.strip() for cell in cells):
                yield reader.line_num, [cell.strip() for cell in cells]
    except csv.Error as error:
        place, reason = f"{name}, line {reader.line_num}", f"is not valid CSV: {error}"
        advice = "look for a quotation mark that is not closed"
        raise InputError(place, "", reason, advice) from error


def _lines(stream: BinaryIO, name: str) -> Iterator[str]:
    """Decoded lines; refuses early what is no text, has no line ends or does not stop."""
    total = 0
    save = "save the table as CSV (UTF-8)"
    for number, block in enumerate(iter(lambda: stream.readline(LONGEST_LINE + 1), b""), start=1):
        total += len(block)
        place = f"{name}, line {number}"
        if total > LARGEST_FILE:  # a text has no size to check beforehand
            raise InputError(place, total, f"the file exceeds {LARGEST_FILE / 1e6:.0f} MB")
        if b"\0" in block:
            raise InputError(place, block[:20], "is binary data, not text", save)
        if len(block) > LONGEST_LINE:
            reason = f"has more than {LONGEST_LINE} characters"
            raise InputError(place, block[:20], reason, "one row stands on one line")
        try:
            text = block.decode("utf-8-sig" if number == 1 else "utf-8")
        except UnicodeDecodeError as error:
            wrong = block[error.start : error.start + 4]
            raise InputError(place, wrong, "is not UTF-8 text", save) from error
        yield text


def _examine(lines: Iterator[str], name: str, table: Table) -> Examination:
    rows: list[Row] = []
    problems: list[Problem] = []
    seen = _Seen(table)
    found_rows = _rows(lines, name)
    line, header = next(found_rows, (1, None))
    columns = _columns(line, header, name, table)
    for line, cells in found_rows:
        row, findings = _row(cells, columns)
        findings = findings or list(table.rules(row)) or list(seen.repeated(row, line))
        problems.extend(Problem(name, line, *finding) for finding in findings)
        if not findings:
            rows.append(row)
    if not rows and not problems:
        raise InputError(name, "only a header", "must hold one row or more")
    return Examination(_frame(rows, columns, table), tuple(problems))


@dataclass
class _Seen:
    """What the rows before have named: keys, and the spelling of every campaign."""

    table: Table
    lines: dict[tuple[str, ...], int] = field(default_factory=dict)
    spelling: dict[str, tuple[str, int]] = field(default_factory=dict)

    def repeated(self, row: Row, line: int) -> Iterator[RowFinding]:
        """A specimen that stands twice, or else a campaign in another spelling."""
        key = tuple(str(row[part]) for part in self.table.key)
        first = self.lines.setdefault(tuple(part.casefold() for part in key), line)
        if key and first != line:
            advice = "every specimen of a campaign has its own name"
            yield self.table.key[-1], ", ".join(key), f"stands in line {first} too", advice
            return
        campaign = str(row["campaign"])
        spelled, first = self.spelling.setdefault(campaign.casefold(), (campaign, line))
        if campaign != spelled:
            advice = "one campaign has one spelling: scatter between campaigns counts"
            yield "campaign", campaign, f"is spelled {spelled} in line {first}", advice


def column_names(line: int, header: list[str] | None, name: str) -> list[str]:
    """The names in a header, each of which stands once. Raises `InputError`."""
    place = f"{name}, line {line}"
    if header is None or not any(cell.strip() for cell in header):
        raise InputError(name, "", "is empty", "the first line names the columns")
    for separator, word in ((";", "semicolons"), ("\t", "tabulators")):
        if len(header) == 1 and separator in header[0]:
            reason = f"columns are separated by {word}"
            advice = "separate them by commas, and write decimal points"
            raise InputError(place, header[0], reason, advice)
    names = [cell.strip() for cell in header]
    times = Counter(names)
    for position, column in enumerate(names, start=1):
        if not column:
            raise InputError(place, column, f"column {position} has no name")
        if times[column] > 1:
            raise InputError(place, column, "the column stands twice")
    return names


def _columns(line: int, header: list[str] | None, name: str, table: Table) -> list[Column | str]:
    """The column of the schema, or the name of the user's own, at every place of the header."""
    names, place = column_names(line, header, name), f"{name}, line {line}"
    for column in names:
        if not column.startswith(EXTRA) and column not in table.names:
            advice = f"{did_you_mean(column, table.names)} columns of your own begin with {EXTRA}"
            raise InputError(place, column, "unknown column", advice.lstrip())
    missing = ", ".join(c.name for c in table.columns if c.filled and c.name not in names)
    if missing:
        raise InputError(place, missing, "required column missing", "units belong to the name")
    return [name if name.startswith(EXTRA) else table.column(name) for name in names]


def width_findings(cells: list[str], width: int) -> list[RowFinding]:
    """What there is to say of a row that has not as many cells as the header."""
    if len(cells) == width:
        return []
    reason = f"has {len(cells)} cells where the header has {width}"
    advice = "put a text with commas in quotation marks, and write decimal points: 19.05"
    return [("", ",".join(cells), reason, advice)]


def _row(cells: list[str], columns: list[Column | str]) -> tuple[Row, list[RowFinding]]:
    row: Row = {}
    findings = width_findings(cells, len(columns))
    if findings:
        return row, findings
    for cell, column in zip(cells, columns, strict=True):
        if isinstance(column, str):
            row[column] = cell.strip()
            continue
        try:
            row[column.name] = _cell(cell.strip(), column)
        except InputError as error:
            findings.append((column.name, error.value, error.allowed, error.advice))
    return row, findings


def _cell(text: str, column: Column) -> object:
    if not text:
        if column.filled:
            raise InputError(column.name, text, "must not be empty")
        return column.blank
    if not isinstance(column.rule, Number):
        return column.rule.check(column.name, text)
    if len(text) > LONGEST_NUMBER or not NUMBER.fullmatch(text):
        advice = "write the number alone: no unit, no words"
        parts = text.split(",")
        if len(parts) == 2 and all(part.lstrip("-").isdigit() for part in parts):
            advice = f"write a decimal point: {parts[0]}.{parts[1]}"
        raise InputError(column.name, text, column.rule.allowed(), advice)
    return float(column.rule.check(column.name, float(text)))


def _frame(rows: list[Row], columns: Iterable[Column | str], table: Table) -> pd.DataFrame:
    """All columns of the schema in its order, then the user's own."""
    data = {
        column.name: pd.Series(
            [row.get(column.name, column.blank) for row in rows],
            dtype=float if isinstance(column.rule, Number) else object,
        )
        for column in table.columns
    }
    extra = (column for column in columns if isinstance(column, str))
    return pd.DataFrame(
        {**data, **{name: pd.Series([row[name] for row in rows], dtype=object) for name in extra}}
    )
