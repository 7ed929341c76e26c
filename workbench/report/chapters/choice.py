"""Which model to take: in a group of cases, over drawn columns, and the ranking of all."""

from math import ceil
from typing import Any

from workbench.assessment.budget import PEAK, RESIDUAL
from workbench.content.formatting import title_of
from workbench.content.page import Page
from workbench.content.tree import Block, Section
from workbench.evidence.descriptors import command_of
from workbench.evidence.error_model import BEYOND
from workbench.report.chapters.configuration import hit_distance
from workbench.report.stored import Stored
from workbench.study.definition import Study

FAIR = 0.10  # bound of what may do
SURE = 0.05  # chance of as many pairs if two models were equal, from which one is better
Row = dict[str, Any]
PAGE = Page(__file__, fair=FAIR, beyond=f"{100 * BEYOND:g}\u2009%")


def first(study: Study, stored: Stored, group: str) -> str:
    """The model to take in a group of cases; empty without one."""
    ranked = _ranked(study, stored, group)
    return next((label for label, row in ranked.items() if _sure(row)), "")


def trusted(study: Study, stored: Stored, group: str) -> str:
    """The model to take, and all that stay within `FAIR` in every case; else the nearest."""
    return f"{group}: {_trusted(study, stored, group)}."


def _trusted(study: Study, stored: Stored, group: str) -> str:
    rows = [row for row in stored.rows["matrix"] if row["group"] == group]
    compared = [row for row in rows if row[f"{PEAK}_count"]]
    if any(row["synthetic"] for row in rows):
        return PAGE.words("synthetic")
    if not compared:
        collapses = any(row["collapsed"] for row in rows if row["label"] in study.ranked)
        false_safe = [row["label"] for row in rows if row["false_safe"]]
        return PAGE.words("not_compared", collapses=collapses, false_safe=false_safe)
    ranked = list(_ranked(study, stored, group).values())
    nearest = ranked[0] if ranked else None
    quantity = judged(nearest or rows[0])
    if nearest and all(row["against_outside"] == row[f"{PEAK}_count"] for row in compared):
        return PAGE.words("no_reference", nearest=nearest, quantity=quantity)
    sure = [row for row in ranked if _sure(row)]
    if not sure:
        rival = [row for row in stored.rows["ranking"] if row["group"] == group]
        if rival:
            return best_ranked(rival, stored.costs)
        open_by = max((row["known"] or 0.0 for row in rows), default=0.0)
        return PAGE.words("unsure", nearest=nearest, quantity=quantity, open_by=open_by)
    return PAGE.words(
        "taken",
        row=sure[0],
        others=[PAGE.words("alike", row=row) for row in sure[1:]],
        quantity=quantity,
        cost=stored.costs.get(sure[0]["label"]),
        hit_at=hit_distance(study, group),
    )


def judged(row: Row) -> str:
    """What the numbers of a row are of, in words."""
    return "peak" if row["quantity"] == PEAK else title_of(row["quantity"]).lower()


def _ranked(study: Study, stored: Stored, group: str) -> dict[str, Row]:
    """Models that answered all cases and no collapse wrongly, the one to take first.

    Inside their domain before others; by whole percents, then by what remains and by the time.
    """
    costs = stored.costs
    rows = {
        row["label"]: row
        for row in stored.rows["matrix"]
        if row["group"] == group
        and row["label"] not in study.ranked
        and row[f"{PEAK}_count"]
        and row[f"{PEAK}_count"] + row["collapsed"] == row["asked"]
        and not any(row[name] for name in ("false_alarm", "false_safe", "synthetic"))
    }

    def place(pair: tuple[str, Row]) -> tuple[float, ...]:
        label, row = pair
        within, remains = row[f"{PEAK}_within"], row[f"{RESIDUAL}_within"] or 0.0
        error = abs(row[f"{PEAK}_worst"]) if within is None else within
        shares = ceil(100.0 * error), ceil(100.0 * remains)
        return bool(row["outside"]), *shares, costs.get(label, 1.0)

    return dict(sorted(rows.items(), key=place))


def _sure(row: Row) -> bool:
    """Whether a model is within `FAIR` with what is open, it and the reference in their domains."""
    within = row[f"{PEAK}_within"]
    return (within or 0.0) <= FAIR and not (
        within is None or row["outside"] or row["against_outside"]
    )


def best_ranked(rows: list[Row], costs: dict[str, float]) -> str:
    """What to take where no model keeps within the bound in every case, and what to expect."""
    best, *others = rows
    equal = [row["label"] for row in others if row["chance"] is None or row["chance"] >= SURE]
    return PAGE.words("ranked", best=best, equal=equal, cost=costs.get(best["label"]))


def tree(stored: Stored) -> tuple[Block, ...]:
    """Which model to take by the tree over all drawn columns, and how it did on hold-out ones."""
    rows = stored.rows["advice"]
    right, asked = (sum(row[name] for row in rows) for name in ("right", "asked"))
    commands = {row["label"]: command_of(stored.study.models[row["label"]]) for row in rows}
    return PAGE.blocks(
        "tree", rows=rows, right=right, asked=asked, commands=commands, costs=stored.costs
    )


def ranking(stored: Stored) -> Section | None:
    """All models of every large group, the best first."""
    return PAGE.section("ranking", rows=stored.rows["ranking"])
