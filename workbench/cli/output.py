"""What the verbs print: JSON objects, aligned tables, numbers with units."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]

_PREFIXES = ((1e6, "M"), (1e3, "k"))
_PREFIXED = ("N", "N m", "N s", "J", "Pa", "N/m")


class InterruptedByUserError(Exception):
    """The user ended a verb; the message says what is left behind."""


def print_json(content: Any) -> None:
    """Print one JSON object on the output stream. NaN is refused, not printed."""
    json.dump(content, sys.stdout, indent=2, ensure_ascii=False, allow_nan=False)
    sys.stdout.write("\n")


def print_table(rows: Sequence[Sequence[object]], header: Sequence[str] = ()) -> None:
    """Print rows in aligned columns, two spaces apart."""
    texts = [[str(cell) for cell in row] for row in ([header, *rows] if header else rows)]
    if not texts:
        return
    widths = [max(len(row[i]) for row in texts) for i in range(len(texts[0]))]
    for number, row in enumerate(texts):
        line = "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        print(line.rstrip())
        if header and number == 0:
            print("  ".join("-" * width for width in widths))


def quantity(value: float | None, unit: str) -> str:
    """A number with four significant digits and its unit, with a prefix where that helps."""
    if value is None:
        return "not known to this model"
    name = "" if unit == "1" else unit
    if unit in _PREFIXED:
        for factor, prefix in _PREFIXES:
            if abs(value) >= factor:
                return f"{value / factor:.4g} {prefix}{name}"
    return f"{value:.4g} {name}".rstrip()
