"""The error budget of an answer as a table, with bars of characters where nothing can be drawn."""

from collections.abc import Mapping, Sequence
from functools import partial
from math import floor, isfinite
from typing import Any

from workbench.assessment.budget import COVERAGE, MODEL_FORM, NUMERICAL, SUMS, TOTAL
from workbench.content.formatting import in_unit, percent, title_of
from workbench.content.tree import Cell, Column, Table

_BAR = 41  # characters
_LEAST = 0.05  # of the answer, to which bars reach at least

Row = Mapping[str, Any]


def budget_table(
    key: str, quantity: str, value: float, rows: Sequence[Row], *, bars: bool = False
) -> Table:
    """Terms and sums of a quantity whose answer is `value` (SI), with `bars` or without."""
    columns = [
        Column(
            "term",
            width=1.8,
            of=lambda row: Cell(row["term"], tone="" if row["term"] in SUMS else "muted"),
        ),
        Column("from", True, 0.8, partial(_end, "least", quantity)),
        Column("to", True, 0.8, partial(_end, "most", quantity)),
        Column("change", True, 1.3, change),
        Column(
            "what it is",
            width=4.4,
            of=lambda row: "; ".join(filter(None, (row["reason"], row["source"]))),
        ),
    ]
    if bars:
        columns.insert(4, Column("as a bar", True, of=partial(_bar, *scale(rows))))
    caption = (
        f"{title_of(quantity).capitalize()}, {in_unit(value, quantity)}: what each source of error "
        f"may make of it, {100 * COVERAGE:g} % intervals."
    )
    return Table.of(key, caption, columns, rows)


def scale(rows: Sequence[Row]) -> tuple[float, float]:
    """Ends of an axis that holds all that is finite, zero among it."""
    ends = [row[end] for row in rows for end in ("low", "high")]
    known = [end for end in ends if end is not None and isfinite(end)]
    return min([-_LEAST, *known]), max([_LEAST, *known])


def change(row: Row) -> str:
    """Both ends of a term in words."""
    if row["low"] is None:
        return "not known"
    if _unstated(row):
        return "not estimated"
    low, high = (percent(row[end], rough=True) for end in ("low", "high"))
    return f"{low} to {high if isfinite(row['high']) else 'collapse'}"


def budget_sentence(value: float, quantity: str, rows: Sequence[Row]) -> str:
    """What a budget says, in one sentence: the answer, its interval, the largest part of that."""
    known = {row["term"]: row for row in rows if row["low"] is not None}
    text = f"{title_of(quantity)} {in_unit(value, quantity, 3)}"
    if TOTAL not in known:
        (form,) = (row for row in rows if row["term"] == MODEL_FORM)
        return f"{text}, without an interval: the model form is not known ({form['reason']})"
    parts = [row for name, row in known.items() if name not in SUMS]
    top = max(parts, key=lambda row: row["high"] - row["low"] + abs(row["shift"]))
    total = known[TOTAL]
    lacks = f", without {', '.join(total['lacks'])}" if total["lacks"] else ""
    own = known.get(NUMERICAL)
    numerical = "not known" if own is None else change(own)
    low, high = _at(quantity, total["least"], named=False), _at(quantity, total["most"])
    return (
        f"{text} ({low} to {high}, {100 * COVERAGE:g} %{lacks}), most of it by {top['term']} "
        f"({change(top)}); the numerical part is {numerical}"
    )


def _unstated(row: Row) -> bool:
    """Whether a reduced model has no numerical uncertainty, which does not say that it is zero."""
    return bool(row["term"] == NUMERICAL and row["low"] == row["high"])


def _at(quantity: str, value: float, *, named: bool = True) -> str:
    return in_unit(value, quantity, 3, named=named) if isfinite(value) else "collapse"


def _end(end: str, quantity: str, row: Row) -> Cell | None:
    value = row[end]
    return None if value is None or _unstated(row) else Cell(_at(quantity, value), value)


def _bar(low: float, high: float, row: Row) -> str:
    """A bar from the low to the high end; ``+`` is where the answer moves to, ``|`` the answer."""

    def place(value: float) -> int:
        return min(floor((value - low) / (high - low) * _BAR), _BAR - 1)

    marks = ["."] * _BAR
    if row["low"] is not None:
        last = place(min(row["high"], high))
        for i in range(place(row["low"]), last + 1):
            marks[i] = "="
        marks[place(row["shift"])] = "+"
        if row["high"] > high:
            marks[-1] = ">"
    marks[place(0.0)] = "|"
    return "".join(marks)
