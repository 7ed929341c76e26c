"""Total uncertainty of an answer: sentences and tables."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from math import floor, isfinite
from typing import Any

from workbench.report.page.formatting import in_unit, percent
from workbench.report.page.markdown import Cell, Markdown, PageColumn, Table
from workbench.report.page.page import Page
from workbench.responses import COVERAGE, PEAK
from workbench.study.assessment.gates import MODEL_FORM, NUMERICAL, SUMS, TOTAL
from workbench.study.assessor import Assessment

Row = Mapping[str, Any]
PAGE = Page(__file__)
_WHO = ("form", "quantity", "value")
_BAR = 41  # characters
_LEAST = 0.05  # of the answer, to which bars reach at least
_COVERAGE = f"{100 * COVERAGE:g} %"


def budgets(stored: Assessment, taken: Mapping[str, str]) -> Markdown:
    """A sentence on the peak of the first answer with a budget by the model `taken` in its case."""
    groups = _groups(stored.records("budget"), "case", "label")
    for (case, label, quantity), forms in groups.items():
        if quantity == PEAK and taken.get(case) == label:
            parts = [_interval(rows) for rows in forms]
            names = {"case": case, "label": label, "coverage": _COVERAGE}
            return PAGE.blocks("first_page", parts=parts, **names)
    return Markdown()


def budget_tables(stored: Assessment) -> Markdown:
    """Each budget in a sentence and every term with its reason; None without a budget."""
    tables = [
        (
            case,
            label,
            headline(forms),
            [budget_table(f"budget-terms-{number}-{i}", rows) for i, rows in each],
        )
        for number, ((case, label, _), forms) in enumerate(
            _groups(stored.records("budget"), "case", "label").items(), 1
        )
        for each in [enumerate(forms, 1)]
    ]
    return PAGE.blocks("budgets", tables=tables)


def simulated(rows: Iterable[Row]) -> Markdown:
    """The budgets of one answer by quantity, with bars."""
    entries = [
        (
            headline(forms),
            [budget_table(f"{quantity}-{i}", rows, bars=True) for i, rows in enumerate(forms, 1)],
        )
        for (quantity,), forms in _groups(rows).items()
    ]
    return PAGE.blocks("simulated", entries=entries)


def _groups(rows: Iterable[Row], *keys: str) -> dict[tuple[str, ...], list[list[Row]]]:
    """The budgets of each quantity, by these columns and the quantity: a list of each form."""
    groups: dict[tuple[str, ...], dict[str, list[Row]]] = {}
    for row in rows:
        forms = groups.setdefault((*(row[key] for key in keys), row["quantity"]), {})
        forms.setdefault(row["form"], []).append(row)
    return {key: list(forms.values()) for key, forms in groups.items()}


def budget_table(key: str, rows: Sequence[Row], *, bars: bool = False) -> Table:
    """Terms and sums of one form of the budget of a quantity, with `bars` or without."""
    form, quantity, value = (rows[0][name] for name in _WHO)
    columns = [
        PageColumn(
            "term",
            width=1.8,
            of=lambda row: Cell(row["term"], tone="" if row["term"] in SUMS else "muted"),
        ),
        PageColumn("from", True, 0.8, partial(_end, "least", quantity)),
        PageColumn("to", True, 0.8, partial(_end, "most", quantity)),
        PageColumn("change", True, 1.3, change),
        PageColumn(
            "what it is",
            width=4.4,
            of=lambda row: "; ".join(filter(None, (row["reason"], row["source"]))),
        ),
    ]
    if bars:
        columns.insert(4, PageColumn("as a bar", True, of=partial(_bar, *scale(rows))))
    value_text = in_unit(value, quantity)
    names = {"quantity": quantity, "form": form, "value": value_text}
    caption = PAGE.words("terms", **names, coverage=_COVERAGE)
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


def headline(forms: Sequence[Sequence[Row]]) -> str:
    """The budgets of a quantity in one sentence, the first form in full."""
    parts = [_interval(rows) for rows in forms]
    return PAGE.words("headline", parts=parts, coverage=_COVERAGE)


def _interval(rows: Sequence[Row]) -> dict[str, Any]:
    """Interval of a form of a budget: the answer, its interval, the largest part of that."""
    form, quantity, value = (rows[0][name] for name in _WHO)
    by_term = {row["term"]: row for row in rows}
    answer = {"form": form, "quantity": quantity, "value": in_unit(value, quantity, 3)}
    parts = [row for name, row in by_term.items() if name not in SUMS]
    if TOTAL not in by_term:
        lost = [f"{r['term']} ({r['reason']})" for r in parts[1:] if r["low"] is None]
        return {**answer, "lost": lost}
    top, total = max(parts[1:], key=_size), by_term[TOTAL]
    return {
        **answer,
        "lost": [],
        "middle": in_unit(value * (1.0 + total["shift"]), quantity, 3),
        "low": _at(quantity, total["least"], named=False),
        "high": _at(quantity, total["most"]),
        "high_alone": _at(quantity, total["most"], named=False),
        "top": top["term"],
        "change": change(top),
        "form_change": change(by_term[MODEL_FORM]),
    }


def _size(row: Row) -> float:
    return float(row["high"] - row["low"] + abs(row["shift"]))


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
