"""Which model to take: in a group of cases, over drawn columns; the ranking of all."""

from collections.abc import Iterable, Iterator
from math import ceil
from typing import Any

from workbench.report.chapters.configuration import hit_distance
from workbench.report.page.formatting import title_of
from workbench.report.page.markdown import Markdown
from workbench.report.page.page import Page
from workbench.responses import PEAK, RESIDUAL, ExpectedError
from workbench.study.assessor import ERROR, Assessment
from workbench.study.chooser import CORRECTED, SURE
from workbench.study.definition import Study, holds_data
from workbench.study.error_model.error_model import BEYOND
from workbench.study.error_model.error_table import ANCHOR, command_of

FAIR = 0.10  # bound of what may do
SURELY = 0.05  # chance of as many pairs if two models were equal, from which one is better
Row = dict[str, Any]
PAGE = Page(__file__, fair=FAIR, beyond=f"{100 * BEYOND:g}\u2009%")


def first(study: Study, stored: Assessment, group: str) -> str:
    """The model to take in a group of cases; empty without one."""
    return next((row["label"] for row in _sure(study, stored, group)), "")


def named(study: Study, stored: Assessment, groups: Iterable[str]) -> set[str]:
    """Labels that a reader looks for: to take in a group of cases or nearest there, and anchors."""
    anchors = {label for label, model in study.models.items() if model.name == ANCHOR}
    ranked = (_sure(study, stored, g) or _ranked(study, stored, g).values() for g in groups)
    return anchors | {row["label"] for rows in ranked for row in list(rows)[:1]}


def trusted(study: Study, stored: Assessment, groups: Iterable[str]) -> Iterator[str]:
    """The model to take, else the nearest: a sentence for all groups in which it is the same."""
    alike: dict[tuple[str, str], dict[str, Row | None]] = {}
    for group in groups:
        sure = _sure(study, stored, group)
        text = _explain_no_ranking(study, stored, group) or (sure[0]["label"] if sure else "")
        row = next(iter(sure or _ranked(study, stored, group).values()), None)
        quantity = judged(row or stored.records("matrix", group=group)[0])
        alike.setdefault((text, quantity), {})[group] = row
    for (text, quantity), of_group in alike.items():
        rows = [row for row in of_group.values() if row]
        if not text:
            open_by = stored.tables["matrix"].set_index("group").loc[[*of_group], "known"].max()
            nearest = {row["label"]: row for row in sorted(rows, key=_error)}  # each at its worst
            text = PAGE.words("unsure", nearest=list(nearest.values()), open_by=open_by)
        elif rows and text == rows[0]["label"]:
            cost = stored.costs.get(text)
            text = PAGE.words("taken", rows=rows, quantity=quantity, cost=cost)
        yield f"{'; '.join(of_group)}: {text}."


def _error(row: Row) -> float:
    """Largest error of the cases of a row, with its numerical uncertainty where that is known."""
    within: float | None = row[f"{PEAK}_within"]
    return abs(row[f"{PEAK}_worst"]) if within is None else within


def _explain_no_ranking(study: Study, stored: Assessment, group: str) -> str:
    """Explanation why the cases of a group judge no model, or rank them all; may be empty."""
    rows = stored.records("matrix", group=group)
    compared = [row for row in rows if row[f"{PEAK}_count"]]
    if any(row["synthetic"] for row in rows):
        return PAGE.words("synthetic")
    if not compared:
        collapses = any(row["collapsed"] for row in rows if row["label"] in study.ranked)
        false_safe = [row["label"] for row in rows if row["false_safe"]]
        return PAGE.words("not_compared", collapses=collapses, false_safe=false_safe)
    nearest = next(iter(_ranked(study, stored, group).values()), None)
    if nearest and all(row["against_outside"] == row[f"{PEAK}_count"] for row in compared):
        return PAGE.words("no_reference", nearest=nearest)
    rival = stored.records("ranking", group=group)
    if rival and not _sure(study, stored, group):
        return best_ranked(rival, stored.costs)
    return ""


def details(study: Study, stored: Assessment, group: str, row: Row) -> str:
    """Against what a group is judged, a `row` of it, and the rest on the model to take."""
    sure = _sure(study, stored, group)
    best = sure[0] if sure else None
    return PAGE.words(
        "details",
        group=group,
        against=row["against"],
        row=best,
        others=[PAGE.words("alike", row=each) for each in sure[1:]],
        quantity=judged(row),
        hit_at=hit_distance(study, group) if best else "",
        **(_expected(study, stored, group, best["label"]) if best else {"error": "", "case": ""}),
    )


def judged(row: Row) -> str:
    """Quantity of the numbers of a row, in words."""
    return "peak" if row["quantity"] == PEAK else title_of(row["quantity"]).lower()


def _ranked(study: Study, stored: Assessment, group: str) -> dict[str, Row]:
    """Models that answered all cases and no collapse wrongly, the one to take first.

    Inside their domain before others; by whole percents, then by what remains and by the time.
    """
    costs = stored.costs
    no_models = {*study.ranked, *(n for n, model in study.models.items() if holds_data(model))}
    rows = {
        row["label"]: row
        for row in stored.records("matrix", group=group)
        if row["label"] not in no_models
        and row[f"{PEAK}_count"]
        and row[f"{PEAK}_count"] + row["collapsed"] == row["asked"]
        and not any(row[name] for name in ("false_alarm", "false_safe", "synthetic"))
    }

    def place(pair: tuple[str, Row]) -> tuple[float, ...]:
        label, row = pair
        remains = row[f"{RESIDUAL}_within"] or 0.0
        shares = ceil(100.0 * _error(row)), ceil(100.0 * remains)
        warned = bool(row["outside"] or row["warned"])
        return warned, *shares, costs.get(label, 1.0)

    return dict(sorted(rows.items(), key=place))


def _sure(study: Study, stored: Assessment, group: str) -> list[Row]:
    """Models within `FAIR` with what is open, they and the reference in their domains.

    The anchor of the error model comes first: where it is within, nothing else is to choose.
    """
    rows = _ranked(study, stored, group).values()
    sure = [
        row
        for row in rows
        if (row[f"{PEAK}_within"] or 0.0) <= FAIR
        and not (row[f"{PEAK}_within"] is None or row["outside"] or row["against_outside"])
    ]
    return sorted(sure, key=lambda row: study.models[row["label"]].name != ANCHOR)


def _expected(study: Study, stored: Assessment, group: str, label: str) -> Row:
    """The error to expect of a label, in words, in the least certain `case`."""
    names = study.groups.get(group, [case.name for case in study.cases])
    chances = [
        (stored.number(name, label, "error_chance"), name)
        for name in names
        if stored.number(name, label, "error_low") is not None
    ]
    _, case = max(chances, default=(0.0, ""))
    expected, low, high = (stored.number(case, label, f"error_{name}") for name in ERROR[:3])
    return {
        "error": str(ExpectedError(ANCHOR, expected, low, high)),
        "case": case if len(chances) > 1 else "",
    }


def best_ranked(rows: list[Row], costs: dict[str, float]) -> str:
    """Advice where no model keeps within the bound in every case: which to take, what to expect."""
    best, *others = rows
    equal = [row["label"] for row in others if row["chance"] is None or row["chance"] >= SURELY]
    return PAGE.words("ranked", best=best, equal=equal, cost=costs.get(best["label"]))


def anchored(stored: Assessment) -> Markdown:
    """Take the anchor; when not, why: over the drawn scenarios of a study that measures it."""
    cells = stored.records("error-cells")
    if not cells:
        return Markdown()
    anchor, ways = cells[0]["anchor"], {row["way"]: row for row in stored.records("chooser")}
    totals = {name: sum(row[name] for row in cells) for name in ("count", "held")}
    return PAGE.blocks(
        "anchored",
        **{"cells": cells, "anchor": anchor, "own": ways[anchor], **totals},
        **{"corrected": ways[CORRECTED], "sure": ways[SURE]},
        command=command_of(stored.study.models[anchor]),
        costs=stored.costs,
    )


def error_model(stored: Assessment) -> Markdown:
    """Section on the error model: coverage of intervals, error and cost of ways to choose."""
    return PAGE.blocks(
        "error_model", coverage=stored.tables["coverage"], chooser=stored.tables["chooser"]
    )


def ranking(stored: Assessment) -> Markdown:
    """All models of every large group, the best first."""
    return PAGE.blocks("ranking", rows=stored.tables["ranking"])
