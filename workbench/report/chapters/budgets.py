"""Total uncertainty of an answer: sentences and tables."""

from collections.abc import Mapping, Sequence
from functools import partial
from math import floor, isfinite
from typing import Any

from workbench.assessment.budget import COVERAGE, MODEL_FORM, NUMERICAL, PEAK, SUMS, TOTAL
from workbench.content.formatting import in_unit, percent
from workbench.content.page import Page
from workbench.content.tree import Block, Cell, Column, Section, Table
from workbench.report.stored import Stored

Row = Mapping[str, Any]
PAGE = Page(__file__)
_BAR = 41  # characters
_LEAST = 0.05  # of the answer, to which bars reach at least
_COVERAGE = f"{100 * COVERAGE:g} %"


def budgets(stored: Stored, taken: Mapping[str, str]) -> tuple[Block, ...]:
    """A sentence on the peak of the first answer with a budget by the model `taken` in its case."""
    for (case, label, quantity), rows in _groups(stored).items():
        if quantity == PEAK and taken.get(case) == label:
            sentence = budget_sentence(rows[0]["value"], quantity, rows)
            return PAGE.blocks("first_page", case=case, label=label, sentence=sentence)
    return ()


def budget_tables(stored: Stored) -> Section | None:
    """Every term with its reason; None without a budget."""
    tables = [
        (case, label, budget_table(f"budget-terms-{number}", quantity, rows[0]["value"], rows))
        for number, ((case, label, quantity), rows) in enumerate(_groups(stored).items(), 1)
    ]
    return PAGE.section("budgets", tables=tables)


def simulated(values: Mapping[str, float], terms: Mapping[str, Sequence[Row]]) -> tuple[Block, ...]:
    """The budgets of one answer by quantity, with bars; `values` of the answer."""
    entries = [
        (
            budget_sentence(values[quantity], quantity, rows),
            budget_table(quantity, quantity, values[quantity], rows, bars=True),
        )
        for quantity, rows in terms.items()
    ]
    return PAGE.blocks("simulated", entries=entries)


def _groups(stored: Stored) -> dict[tuple[str, str, str], list[Row]]:
    """Rows of the table by case, label and quantity."""
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in stored.rows["budget"]:
        groups.setdefault((row["case"], row["label"], row["quantity"]), []).append(row)
    return groups


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
    value_text = in_unit(value, quantity)
    caption = PAGE.words("terms", quantity=quantity, value=value_text, coverage=_COVERAGE)
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
    by_term = {row["term"]: row for row in rows}
    text = in_unit(value, quantity, 3)
    parts = [row for name, row in by_term.items() if name not in SUMS]
    if TOTAL not in by_term:
        lost = [f"{r['term']} ({r['reason']})" for r in parts[1:] if r["low"] is None]
        return PAGE.words("unknown", quantity=quantity, value=text, lost=lost)
    top = max(parts[1:], key=lambda row: row["high"] - row["low"] + abs(row["shift"]))
    return PAGE.words(
        "known",
        quantity=quantity,
        value=text,
        middle=in_unit(value * (1.0 + by_term[TOTAL]["shift"]), quantity, 3),
        low=_at(quantity, by_term[TOTAL]["least"], named=False),
        high=_at(quantity, by_term[TOTAL]["most"]),
        coverage=_COVERAGE,
        top=top["term"],
        change=change(top),
        form=change(by_term[MODEL_FORM]),
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
