"""Which model to take over many drawn columns, by counts and by pairs of answers."""

from typing import Any

from workbench.content.formatting import count, part, percent, several
from workbench.content.tree import Block, Bullets, Cell, Column, Paragraph, Section, Table
from workbench.evidence.descriptors import asked_for, variant_of
from workbench.evidence.measured import BEYOND
from workbench.report.stored import Stored

SURE = 0.05  # chance of as many pairs if two models were equal, from which one is better
Row = dict[str, Any]
_WIDE = 40  # rows


def advice(stored: Stored, group: str) -> str:
    """What to take where no model keeps within the bound in every case, and what to expect.

    Empty for a group of too few cases to rank.
    """
    rows = [row for row in stored.rows["ranking"] if row["group"] == group]
    if not rows:
        return ""
    best = rows[0]
    text = _take(best, best["judged"])
    if best["refused"]:
        text += f"; no answer in {best['refused']}"
    equal = [row["label"] for row in rows[1:] if row["chance"] is None or row["chance"] >= SURE]
    if equal:
        text += f". Not surely worse: {several(equal, 5)}"
    return text + _time(stored, best)


def tree(stored: Stored) -> tuple[Block, ...]:
    """Which model to take by the tree over all drawn columns, and how it did on unseen ones."""
    rows = stored.rows["advice"]
    if not rows:
        return ()
    right, asked = (sum(row[name] for row in rows) for name in ("right", "asked"))
    said = (
        f"Which model for which column; right, with a peak within {100 * BEYOND:g}\u2009%, on "
        f"{right} of {asked} columns that this choice had not seen:"
    )
    items = []
    for row in rows:
        model = stored.study.models[row["label"]]
        asked = f" (`{asked_for(f'{model.name} {variant_of(model)}')}`)"  # on the command line
        text = _take(row, row["count"], asked) + _time(stored, row)
        items.append(f"{row['region'] or 'any column'}: {text}")
    return Paragraph(said), Bullets(tuple(items))


def _take(row: Row, judged: int, asked: str = "") -> str:
    """The model to take, how often it is within the bound, and what to expect."""
    text = (
        f"take {row['label']}{asked}; peak within {100 * BEYOND:g}\u2009% in {row['within']} of "
        f"{judged}, expect {_expected(row)}, nine of ten in brackets"
    )
    wrong = row["falls"] + row["stands"]
    return text + (f"; collapse told wrongly in {wrong}" if wrong else "")


def _time(stored: Stored, row: Row) -> str:
    """What the model of a row costs, where that is known; the end of a sentence."""
    ratio = stored.costs.get(row["label"])
    return "." if ratio is None else f". Time: {part(ratio)} of the reference."


def table(stored: Stored) -> Section | None:
    """All models of every large group, the best first."""
    rows = stored.rows["ranking"]
    if not rows:
        return None
    caption = (
        f"Cases by group: peaks within {100 * BEYOND:g} % of the best reference, too small "
        "and too large ones (a model that survives where the reference collapses counts as too "
        "small: false safe; the other way round: false alarm), and the pairs of answers in "
        "which the first model of the group errs less, with the chance of as many if both were "
        "equal (sign test)."
    )
    columns = (
        Column("group", width=1.4, of="group"),
        Column("model", width=1.6, of="label"),
        Column("within", True, of=lambda row: Cell(f"{row['within']} of {row['judged']}")),
        Column("too small", True, of="low"),
        Column("too large", True, of="high"),
        Column("false safe", True, of="stands"),
        Column("false alarm", True, of="falls"),
        Column("refused", True, of="refused"),
        Column("median, 5 to 95 %", width=1.6, of=_expected),
        Column("first errs less", width=1.2, of=_pairs),
    )
    return Section("ranking", "Which model", (Table.of("ranking", caption, columns, rows, _WIDE),))


def _expected(row: Row) -> str:
    """The median error and where nine of ten cases lie."""
    if row["median"] is None:
        return "no number"
    middle, *ends = (percent(row[name] - 1.0, rough=True) for name in ("median", "least", "most"))
    return f"{middle} ({' to '.join(ends)})"


def _pairs(row: Row) -> str:
    if row["against"] == row["label"]:
        return "itself"
    chance = "" if row["chance"] is None else f" ({row['chance']:.2g})"
    return f"{row['wins']} of {count(row['pairs'], 'pair')}{chance}"
