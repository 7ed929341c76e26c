"""Tables of an assessment: typed columns, as netCDF for programs and as CSV for people."""

import io
import json
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial, wraps
from pathlib import Path
from types import NoneType
from typing import Any, ParamSpec

import numpy as np
import pandas as pd
import xarray as xr

from workbench.base.datafiles import check_library
from workbench.study.store import read_netcdf, to_netcdf_bytes, write_atomically

P = ParamSpec("P")
Row = Mapping[str, Any]
Columns = dict[str, Any]  # by name, what stands where a row has none: its type is the column's
Tables = Mapping[str, pd.DataFrame]

FORMULA = ("=", "+", "-", "@", "\t", "\r")  # with which texts begin that are run
_TYPES = {str: "str", float: "float64", int: "int64", NoneType: "object"}


def texts(*names: str) -> Columns:
    """Columns of texts, empty where there is none."""
    return dict.fromkeys(names, "")


def numbers(*names: str) -> Columns:
    """Columns of numbers, NaN where not known."""
    return dict.fromkeys(names, np.nan)


def counts(*names: str) -> Columns:
    """Columns of whole numbers and of flags (0 or 1), 0 where there is none."""
    return dict.fromkeys(names, 0)


def lists(*names: str) -> Columns:
    """Columns of lists of texts, None where there is none."""
    return dict.fromkeys(names)


class GrowingTable:
    """A typed table that grows by rows; None and what a row lacks are the default of its column."""

    def __init__(self, columns: Mapping[str, Any]) -> None:
        self.columns = columns
        self.values: dict[str, list[Any]] = {name: [] for name in columns}

    def __iadd__(self, rows: Iterable[Row]) -> "GrowingTable":
        for row in rows:
            for name, default in self.columns.items():
                self.values[name].append(default if (value := row.get(name)) is None else value)
        return self

    @property
    def table(self) -> pd.DataFrame:
        """The rows so far, as a table with these columns."""
        types = {name: _TYPES[type(default)] for name, default in self.columns.items()}
        return pd.DataFrame({n: pd.Series(self.values[n], dtype=kind) for n, kind in types.items()})


def table(rows: Iterable[Row], columns: Mapping[str, Any]) -> pd.DataFrame:
    """Rows as a typed table with these columns."""
    whole = GrowingTable(columns)
    whole += rows
    return whole.table


def tabled(
    columns: Mapping[str, Any],
) -> Callable[[Callable[P, Iterable[Row]]], Callable[P, pd.DataFrame]]:
    """A function that gives rows, as one that gives the typed table with these columns."""

    def typed(rows: Callable[P, Iterable[Row]]) -> Callable[P, pd.DataFrame]:
        @wraps(rows)
        def tabulated(*arguments: P.args, **options: P.kwargs) -> pd.DataFrame:
            return table(rows(*arguments, **options), columns)

        return tabulated

    return typed


def csv_bytes(table: pd.DataFrame) -> bytes:
    """A table as CSV: numbers keep all digits, unknown ones are empty, lists JSON."""
    return for_spreadsheets(_plain_lists(table)).to_csv(index=False, lineterminator="\n").encode()


def table_bytes(table: pd.DataFrame, ending: str) -> bytes:
    """A table as csv, parquet or xlsx, by the ending. Raises `InputError` without its library."""
    if ending == "csv":
        return csv_bytes(table)
    if ending == "xlsx":
        return workbook_bytes({"table": table})
    check_library(ending, "format")
    return bytes(_plain_lists(table).to_parquet(None, engine="pyarrow", index=False))


def workbook_bytes(tables: Tables) -> bytes:
    """Tables as sheets of one workbook."""
    buffer = io.BytesIO()
    with pd.ExcelWriter(buffer, engine="openpyxl") as book:
        for name, table in tables.items():
            for_spreadsheets(_plain_lists(table)).to_excel(book, sheet_name=name[:31], index=False)
    return buffer.getvalue()


def for_spreadsheets(table: pd.DataFrame) -> pd.DataFrame:
    """The table with an apostrophe before texts and names that spreadsheets take for formulas."""
    listed = table.select_dtypes(exclude="number")
    texts = [name for name, column in listed.items() if any(map(_is_formula, column))]
    plain = {str(name): table[name].map(_no_formula) for name in texts}
    return table.assign(**plain).rename(columns=_no_formula)


def _is_formula(cell: Any) -> bool:
    return isinstance(cell, str) and cell.startswith(FORMULA)


def _no_formula(cell: Any) -> Any:
    return f"'{cell}" if _is_formula(cell) else cell


def from_spreadsheets(table: pd.DataFrame) -> pd.DataFrame:
    """The table without the apostrophes of `for_spreadsheets`."""
    return table.replace(rf"^'(?=[{re.escape(''.join(FORMULA))}])", "", regex=True)


def _plain_lists(table: pd.DataFrame) -> pd.DataFrame:
    """The table with its lists as JSON."""
    return table.assign(**{name: _json(table[name].dropna()) for name in _lists_in(table)})


def _lists_in(table: pd.DataFrame) -> list[str]:
    """Names of the columns of lists."""
    return [str(name) for name, column in table.items() if str(column.dtype) == "object"]


def _json(column: pd.Series) -> pd.Series:
    return column.map(partial(json.dumps, ensure_ascii=False)).astype("str")


def write_table(path: Path, table: pd.DataFrame) -> None:
    """Write ``path.nc`` and ``path.csv``. Raises `InputError` if they cannot be written."""
    variables, lists = {}, _lists_in(table)
    for number, (name, column) in enumerate(table.items()):
        values, attributes = column.to_numpy(), {"long_name": str(name)}
        if name in lists:
            values, attributes["format"] = _json(column).to_numpy().astype(str), "json"
        elif column.dtype.kind not in "fi":
            values = values.astype(str)
        variables[f"column_{number}"] = ("row", values, attributes)
    write_atomically(path.with_suffix(".nc"), to_netcdf_bytes(xr.Dataset(variables)))
    write_atomically(path.with_suffix(".csv"), csv_bytes(table))


def read_table(path: Path) -> pd.DataFrame:
    """The table in ``path.nc``. Raises what reading a file of any content may."""
    series = {}
    stored = read_netcdf(path.with_suffix(".nc")).variables
    for number in range(len(stored)):
        variable = stored[f"column_{number}"]
        values, kind = variable.to_numpy(), variable.dtype.kind
        if variable.attrs.get("format") == "json":
            column = pd.Series([json.loads(text) for text in values], dtype="object")
        else:
            column = pd.Series(values, dtype={"f": "float64", "i": "int64"}.get(kind, "str"))
        series[variable.attrs["long_name"]] = column
    return pd.DataFrame(series)
