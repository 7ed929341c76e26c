"""Tables of tests by their schemas; every bad row is named by file, line, column and reason.

`workbench.base.tables` gives the cells; here are the header, cells by the schema, rows by its
rules, and what must not repeat between rows.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from workbench.base.errors import InputError
from workbench.base.fields import Number, did_you_mean
from workbench.base.tables import FOUND_OUT, PLAIN, Cells, Reading, cells_of, read_cells
from workbench.studs.schema import EXTRA, TESTS, Column, Row, RowFinding, Table

_SHOWN = 5  # problems that one message lists by line


@dataclass(frozen=True, slots=True)
class Problem:
    """Problem with one cell or row: `line` of the file (1 is the header), `column` or ''."""

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
    """A table as found: the good `rows`, and the `problems` of all others.

    `notes`, how it was read and what was computed, one sentence each.
    """

    rows: pd.DataFrame
    problems: tuple[Problem, ...]
    notes: tuple[str, ...] = ()

    def accept(self) -> pd.DataFrame:
        """The rows if all are good. Raises `InputError` that names the first bad one."""
        if self.problems:
            first = self.problems[0]
            lines = {problem.line for problem in self.problems[1:]} - {first.line}
            raise first.error(tuple(sorted(lines)))
        return self.rows


def read_tests(path: str | Path, *, keep_good: bool = False) -> pd.DataFrame:
    """Table of tests on studs (schema `TESTS`), one row per specimen.

    Arguments: `path` of a table; `keep_good`, leave bad rows out instead of refusing the file
    (`examine` says which). Missing numbers are NaN, missing texts empty. Raises `InputError`.
    """
    examination = examine(path, TESTS)
    return examination.rows if keep_good else examination.accept()


def read_text(text: str, table: Table, name: str = "table") -> Examination:
    """Examine a table given as text as the workbench writes it (see `examine`)."""
    return examined(cells_of(text.encode(), name, table.names.__contains__, PLAIN), table)


def from_frame(frame: pd.DataFrame, table: Table, name: str = "table") -> pd.DataFrame:
    """A data frame made elsewhere, checked and completed by a schema (see `read_tests`)."""
    return read_text(frame.to_csv(index=False), table, name).accept()


def examine(path: str | Path, table: Table, how: Reading = FOUND_OUT) -> Examination:
    """Read a table row by row, separating good rows from problems.

    Raises `InputError` when no row can be read at all, as of large files, which are not read.
    """
    return examined(read_cells(Path(path), table.names.__contains__, how), table)


def examined(cells: Cells, table: Table) -> Examination:
    """The good rows and the problems of a table by its cells. Raises `InputError`."""
    rows, problems, notes = list[Row](), list[Problem](), Counter[str]()
    columns, seen = _columns(cells, table), _Seen(table)
    for line, texts in cells.rows[1:]:
        row, findings = _row(texts, columns, cells)
        notes.update(() if findings else table.complete(row))
        findings = findings or list(table.rules(row)) or list(seen.repeated(row, line))
        problems.extend(Problem(cells.name, line, *finding) for finding in findings)
        if not findings:
            rows.append(row)
    if not rows and not problems:
        raise InputError(cells.name, "only a header", "must hold one row or more")
    frame, words = _frame(rows, columns, table), "is in no row: models that need it assume this"
    silent = [f"{c} ({value:g})" for c, value in table.assumed.items() if frame[c].isna().all()]
    computed = [f"{note} in {count} rows" for note, count in notes.items()]
    computed += [f"{', '.join(silent)} {words}"] * bool(rows and silent)
    return Examination(frame, tuple(problems), (*cells.notes, *computed))


@dataclass
class _Seen:
    """Names in the rows before: keys, and the spelling of every campaign."""

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


def _columns(cells: Cells, table: Table) -> list[Column | str]:
    """The column of the schema, or the name of the user's own, at every place of the header."""
    names, place = cells.header, f"{cells.name}, line {cells.rows[0][0]}"
    for column in names:
        if not column.startswith(EXTRA) and column not in table.names:
            advice = f"{did_you_mean(column, table.names)} columns of your own begin with {EXTRA}"
            raise InputError(place, column, "unknown column", advice.lstrip())
    missing = ", ".join(c.name for c in table.columns if c.filled and c.name not in names)
    if missing:
        raise InputError(place, missing, "required column missing", "units belong to the name")
    return [name if name.startswith(EXTRA) else table.column(name) for name in names]


def width_findings(cells: list[str], width: int) -> list[RowFinding]:
    """Findings on a row that has not as many cells as the header."""
    if len(cells) == width:
        return []
    reason = f"has {len(cells)} cells where the header has {width}"
    advice = "put a text with separators in quotation marks, and write decimal points: 19.05"
    return [("", ",".join(cells), reason, advice)]


def _row(
    texts: list[str], columns: list[Column | str], cells: Cells
) -> tuple[Row, list[RowFinding]]:
    row, findings = Row(), width_findings(texts, len(columns))
    if findings:
        return row, findings
    for text, column in zip(texts, columns, strict=True):
        if isinstance(column, str):
            row[column] = text
            continue
        try:
            row[column.name] = _cell(text, column, cells)
        except InputError as error:
            findings.append((column.name, error.value, error.allowed, error.advice))
    return row, findings


def _cell(text: str, column: Column, cells: Cells) -> object:
    if not text:
        if column.filled:
            raise InputError(column.name, text, "must not be empty")
        return column.blank
    if not isinstance(column.rule, Number):
        return column.rule.check(column.name, text)
    number = cells.number(text)
    if number is None:
        raise InputError(column.name, text, column.rule.allowed(), cells.advice)
    return float(column.rule.check(column.name, number))


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
