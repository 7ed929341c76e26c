"""Tables of a study as CSV: full precision, fixed order, equal content gives equal bytes."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from workbench.study.files import write_atomically

Row = Mapping[str, Any]


def csv_bytes(rows: Sequence[Row], columns: Sequence[str]) -> bytes:
    """Rows as CSV with a header; None is an empty field, floats keep all digits, lists are JSON."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow([_text(row.get(column)) for column in columns])
    return stream.getvalue().encode()


def write_table(path: Path, rows: Sequence[Row], columns: Sequence[str]) -> None:
    """Write a table atomically."""
    write_atomically(path, csv_bytes(rows, columns))


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(float(value))  # a NumPy float would print its type
    return json.dumps(value, ensure_ascii=False) if isinstance(value, list) else str(value)
