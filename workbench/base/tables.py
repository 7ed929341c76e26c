"""THE reader of tables that people give: text of any separator, or a sheet of a workbook of Excel.

Separator, decimal sign and the line of the header are found out and said; a number stays a text
until who knows its column asks `Cells.number`. Points of curves and histories are read here too.
"""

import csv
import io
import re
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from itertools import compress, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.datafiles import LARGEST_FILE, open_input
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Number, did_you_mean

if TYPE_CHECKING:
    import pandas as pd

FILES = (".csv", ".xlsx")  # endings of tables that options and scenarios name
COMMENT = "#"  # begins a line above the header that is not read
MOST_ROWS, MOST_COLUMNS, MOST_POINTS = 50_000, 1_000, 10_000
LONGEST_LINE = 65_536  # bytes; no row of any table comes near it
LONGEST_NUMBER = 60  # characters
LARGEST_UNPACKED = 200_000_000  # bytes of a workbook, which is packed
NUMBER = re.compile(  # float() would also take 1_000 and digits of other scripts
    r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)(e[+-]?[0-9]+)?|[+-]?(nan|inf|infinity)", re.IGNORECASE
)
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2}[.,][0-9]{3}")  # or with a decimal sign
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabulators"}
_SEP, _DECIMAL = Choice((",", ";", "tab")), Choice((".", ","))
_LOOKED_AT = 30  # lines that tell the separator and the header
_SAVE = "save the table as CSV (UTF-8) or as a workbook (.xlsx)"
Lines = list[tuple[int, list[Any]]]  # cells of every line that is not empty, with its number
Known = Callable[[str], object]  # whether a text names a column


class Reading(NamedTuple):
    """How a table is read: `sheet` of a workbook, `sep` and `decimal` (None: found out)."""

    sheet: str | None = None
    sep: str | None = None
    decimal: str | None = None


FOUND_OUT, PLAIN = Reading(), Reading(sep=",", decimal=".")  # PLAIN as the workbench writes


class Cells(NamedTuple):
    """A table as texts: `rows` with their lines, the header first; the `decimal` sign of numbers.

    `notes`: what was found out of the table, one sentence each.
    """

    name: str
    rows: Lines
    decimal: str
    notes: tuple[str, ...] = ()

    @property
    def header(self) -> list[str]:
        """The names of the columns, each of which stands once. Raises `InputError`."""
        line, names = self.rows[0]
        times = Counter(names)
        for position, column in enumerate(names, start=1):
            if not column or times[column] > 1:
                reason = "the column stands twice" if column else f"column {position} has no name"
                raise InputError(f"{self.name}, line {line}", column, reason)
        return names

    def number(self, text: str) -> float | None:
        """The number in a cell, None for what is none in this table."""
        if self.decimal == ",":
            text = "" if "." in text else text.replace(",", ".", 1)
        alone = len(text) <= LONGEST_NUMBER and NUMBER.fullmatch(text)
        return float(text) if alone else None

    @property
    def advice(self) -> str:
        """Advice on a cell that is no number."""
        rule = "the number alone: no unit, no words, no separators of thousands"
        word = "point" if self.decimal == "." else "comma"
        return f"write {rule}, and a decimal {word} as in this table, or tell --decimal"


def text_of(value: Any, decimal: str) -> str:
    """A value as the text of a cell, numbers with a `decimal` sign."""
    if isinstance(value, float):
        return repr(value).replace(".", decimal)
    return "" if value is None else str(int(value) if isinstance(value, bool) else value).strip()


def read_cells(path: Path, known: Known, how: Reading = FOUND_OUT) -> Cells:
    """The cells of a file that a user names.

    Arguments: `known`, whether a text names a column, which tells the header from titles above it;
    `how` to read it. Raises `InputError` for what is no such file.
    """
    with open_input(path, path.name) as stream:
        return cells_of(stream.read(), path.name, known, how)


def cells_of(data: bytes, name: str, known: Known, how: Reading = FOUND_OUT) -> Cells:
    """The cells of a table, text or workbook, of a `name`; see `read_cells`."""
    sep = None if how.sep is None else _SEP.check("--sep", how.sep).replace("tab", "\t")
    packed, notes = zipfile.is_zipfile(io.BytesIO(data)), list[str]()
    if packed:
        values = _sheet(data, name, how.sheet, notes)
    elif how.sheet is not None:
        raise InputError("--sheet", how.sheet, f"{name} is a text, which has no sheets")
    else:
        lines = list(_lines(data, name))
        sep = sep or _separator(lines, known)
        values = _rows(lines, name, sep)
        notes += [f"columns are separated by {_SEPARATORS[sep]}"] * (sep != "," and not how.sep)
    if not values:
        raise InputError(name, "", "is empty", "the first line names the columns")
    if len(values) > MOST_ROWS + 1:
        raise InputError(name, len(values), f"the table has more than {MOST_ROWS} rows")
    decimal = _DECIMAL.check("--decimal", how.decimal or _decimal(values, sep == ","))
    notes += ["numbers have decimal commas"] * (decimal == "," and not how.decimal)
    rows = [(line, [text_of(cell, decimal) for cell in cells]) for line, cells in values]
    top = _header(rows, known)
    if top:
        title = " ".join(filter(None, rows[0][1]))
        notes.append(f"the header is line {rows[top][0]}, below '{title[:60]}'")
    rows = rows[top:]
    if packed:  # the table need not begin in the first column, nor end in the last with a format
        used = [any(column) for column in zip_longest(*(cells for _, cells in rows))]
        wide = [(line, cells + [""] * (len(used) - len(cells))) for line, cells in rows]
        rows = [(line, list(compress(cells, used))) for line, cells in wide]
    return Cells(name, rows, decimal, tuple(notes))


def _lines(data: bytes, name: str) -> Iterator[str]:
    """Lines of a text; refuses early what is none or has no line ends."""
    if len(data) > LARGEST_FILE:  # a text has no size to check beforehand
        raise InputError(name, len(data), f"the file exceeds {LARGEST_FILE / 1e6:.0f} MB")
    for number, block in enumerate(data.splitlines(keepends=True), start=1):
        place = f"{name}, line {number}"
        if b"\0" in block:
            raise InputError(place, block[:20], "is binary data, not text", _SAVE)
        if len(block) > LONGEST_LINE:
            reason = f"has more than {LONGEST_LINE} characters"
            raise InputError(place, block[:20], reason, "one row stands on one line")
        try:
            yield block.decode("utf-8-sig" if number == 1 else "utf-8")
        except UnicodeDecodeError as error:
            wrong = block[error.start : error.start + 4]
            raise InputError(place, wrong, "is not UTF-8 text", _SAVE) from error


def _rows(lines: list[str], name: str, sep: str) -> Lines:
    """Lines of a text, comments above the header left out."""
    reader, rows = csv.reader(lines, delimiter=sep, strict=True), Lines()
    try:
        for cells in reader:
            comment = not rows and cells and cells[0].lstrip().startswith(COMMENT)
            if not comment and any(cell.strip() for cell in cells):
                rows.append((reader.line_num, cells))
    except csv.Error as error:
        place, reason = f"{name}, line {reader.line_num}", f"is not valid CSV: {error}"
        advice = "look for a quotation mark that is not closed"
        raise InputError(place, "", reason, advice) from error
    return rows


def _separator(lines: list[str], known: Known) -> str:
    """Separator of columns: with it a line names most columns, or most lines are as wide."""
    head = [line for line in lines[: 3 * _LOOKED_AT] if line.strip() and line[0] != COMMENT]

    def merit(sep: str) -> tuple[int, int, int]:
        rows = list(csv.reader(head[:_LOOKED_AT], delimiter=sep)) or [[]]
        named = max(sum(bool(known(cell.strip())) for cell in row) for row in rows)
        width, count = Counter(map(len, rows)).most_common(1)[0]
        return named, count * (width > 1), width

    return max(_SEPARATORS, key=merit)


def _decimal(values: Lines, commas_separate: bool) -> str:
    """The decimal sign of most numbers; one that may be of thousands tells little."""
    texts = [cell for _, cells in values for cell in cells if isinstance(cell, str)]
    signed = {sign: [cell for cell in texts if sign in cell] for sign in ".,"}
    points, commas = (
        [cell for cell in cells if Cells("", [], sign).number(cell) is not None]
        for sign, cells in signed.items()
    )
    more = sum(not _THOUSANDS.fullmatch(cell) for cell in commas)
    more -= sum(not _THOUSANDS.fullmatch(cell) for cell in points)
    even = more == 0 and len(commas) > len(points) and not commas_separate
    return "," if more > 0 or even else "."


def _header(rows: Lines, known: Known) -> int:
    """Which of the first rows is the header: it names columns, or is the first that is wide."""
    filled = [[cell for cell in cells if cell] for _, cells in rows[:_LOOKED_AT]]
    for place, cells in enumerate(filled):
        if sum(bool(known(cell)) for cell in cells) >= min(2, len(cells)):
            return place
    wide = 0.5 * max(map(len, filled))
    place = next(place for place, cells in enumerate(filled) if len(cells) > wide)
    return 0 if any(map(NUMBER.fullmatch, filled[place])) else place


def _sheet(data: bytes, name: str, wanted: str | None, notes: list[str]) -> Lines:
    """Lines of a sheet of a workbook; `notes` gets which one it is."""
    from openpyxl import load_workbook

    packed = io.BytesIO(data)
    try:
        size = sum(each.file_size for each in zipfile.ZipFile(packed).infolist())
        if size > LARGEST_UNPACKED:
            raise InputError(name, size, f"must not unpack to over {LARGEST_UNPACKED} bytes")
        with warnings.catch_warnings():  # of styles, which are not read
            warnings.simplefilter("ignore")
            books = (load_workbook(packed, True, data_only=v).worksheets for v in (True, False))
            # what formulas made; and the formulas, which tell where no value was stored
            values, written = ({each.title: each for each in book} for book in books)
            filled = [title for title, each in values.items() if any(map(any, _values(each, name)))]
            if wanted is not None:
                Choice(tuple(values), did_you_mean(wanted, values)).check("--sheet", wanted)
            elif len(filled) > 1:
                raise InputError("--sheet", None, f"must be given: {name} has {', '.join(filled)}")
            title = wanted or (filled or list(values))[0]
            both = [*zip(*(_values(b[title], name) for b in (values, written)), strict=True)]
    except InputError:
        raise
    except Exception as error:  # packed files may hold anything
        raise InputError(name, None, "is no workbook of Excel that can be read", _SAVE) from error
    rows = []
    for line, (cells, texts) in enumerate(both, start=1):
        if any(c is None and t is not None for c, t in zip(cells, texts, strict=True)):
            reason, advice = "holds a formula without a value", "open and save the file in Excel"
            raise InputError(f"{name}, line {line}", None, reason, advice)
        if any(text_of(cell, ".") for cell in cells):
            rows.append((line, list(cells)))
    notes += [f"the rows are those of the sheet {title}"] * (len(values) > 1)
    return rows


def _values(sheet: Any, name: str) -> Iterator[tuple[Any, ...]]:
    """Lines of a sheet, whatever size its file states. Raises `InputError` for a wide one."""
    sheet.reset_dimensions()
    for line, cells in enumerate(sheet.iter_rows(values_only=True), start=1):
        if len(cells) > MOST_COLUMNS:
            raise InputError(f"{name}, line {line}", None, f"has over {MOST_COLUMNS} columns")
        yield cells


def frame_of(stream: Any) -> "pd.DataFrame":
    """A data frame of CSV text with decimal points, its columns of the type that they hold.

    Raises what reading text of any content may.
    """
    import pandas as pd

    # only an empty cell is missing: "NA" and "None" are names like any other
    missing: dict[str, Any] = {"keep_default_na": False, "na_values": [""]}
    table: pd.DataFrame = pd.read_csv(stream, low_memory=False, **missing)
    if not isinstance(table.index, pd.RangeIndex):
        raise ValueError("its rows have more cells than its header")
    return table


def records(text: str) -> Iterator[dict[str, str]]:
    """The rows of a table that comes with the workbench, by its names."""
    return iter(csv.DictReader(text.splitlines()))


def read_points(
    data: bytes, name: str, field: str, columns: Mapping[str, Number], fewest: int = 3
) -> tuple[Array, list[int]]:
    """Points (n, columns) of a table of numbers, rising in the first column; and their lines.

    Arguments: `name` of the file, `field` that asks for it, rules of its `columns` by their names.
    Raises `InputError` with the name and the line.
    """
    cells = cells_of(data, name, columns.__contains__)
    (_, header), *rows = cells.rows
    if header != list(columns):
        raise InputError(field, name, f"must begin with the line {','.join(columns)}")
    if not fewest <= len(rows) <= MOST_POINTS:
        text = f"must have {fewest} to {MOST_POINTS} points, not {len(rows)}"
        raise InputError(field, name, text)
    table = np.array([_numbers(cells, n, row, columns) for n, row in rows])
    falls = np.flatnonzero(np.diff(table[:, 0]) <= 0.0)
    if len(falls):
        place = f"{name}, line {rows[falls[0] + 1][0]}, {next(iter(columns))}"
        text = "must be larger than that of the point before"
        raise InputError(place, float(table[falls[0] + 1, 0]), text)
    return table, [n for n, _ in rows]


def _numbers(cells: Cells, line: int, row: list[str], columns: Mapping[str, Number]) -> list[float]:
    place, numbers = f"{cells.name}, line {line}", [cells.number(cell) for cell in row]
    if len(numbers) != len(columns) or None in numbers:
        count = {2: "two", 3: "three"}.get(len(columns), str(len(columns)))
        advice = "decimals have a point, columns a comma"
        raise InputError(place, ",".join(row), f"must be {count} numbers", advice)
    held = zip(columns.items(), numbers, strict=True)
    return [float(rule.check(f"{place}, {column}", value)) for (column, rule), value in held]


def plain_rows(table: "pd.DataFrame") -> list[dict[str, Any]]:
    """Rows of a table as plain values; numbers that are not known are None."""
    plain = table.astype(object)
    known = plain.where(plain.notna(), None)
    return [dict(zip(map(str, table), row, strict=True)) for row in known.to_numpy().tolist()]
