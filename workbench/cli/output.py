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


def quantity(value: float | None, unit: str, width: float | None = 0.0) -> str:
    """A number with four significant digits and its unit, with a prefix where that helps.

    `width` is the half-width of its numerical uncertainty (zero: none is shown, None: unknown).
    """
    if value is None:
        return "not known to this model"
    name, factor = "" if unit == "1" else unit, 1.0
    if unit in _PREFIXED:
        for larger, prefix in _PREFIXES:
            if abs(value) >= larger:
                factor, name = larger, f"{prefix}{name}"
                break
    text = f"{value / factor:.4g} {name}".rstrip()
    if width is None:
        return f"{text} +- unknown"
    return f"{text} +- {width / factor:.2g}" if width else text
