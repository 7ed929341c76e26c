"""How well the reference itself is known: its refinement ladder."""

from __future__ import annotations

import numpy as np

from workbench.content.formatting import number, percent, title_of, unit_of
from workbench.content.tree import Block, Callout, Cell, Column, Paragraph, Section, Table
from workbench.report.stored import Stored
from workbench.study.definition import Study

_MEASURED = ("published", "stud-measured")
_BEAMS = ("fiber-reissner", "fiber-corotational", "fiber-shear")
_FIRST_ORDER = (
    "First order is expected, although elastic beams converge at second: a plastic hinge forms in "
    "the element at a support or under the striker, whose section is sampled inside it, half an "
    "element (exact beam) or a fifth of one (co-rotational beam) away from where the moment is "
    "largest. The lever arms of a mechanism come out too short by that, and its resistance too "
    "large, in proportion to the element. In time the collision takes half a step."
)


def convergence(study: Study, stored: Stored, figures: list[Block]) -> Section:
    """The table of the ladder and the figures that show it."""
    if study.models[study.reference].name in _MEASURED:
        text = f"{study.reference} are measured numbers: there is no mesh to refine."
        return Section("convergence", "How good is the reference?", (Paragraph(text),))
    if len(study.steps) < 2:
        text = (
            f"{study.reference} is not refined in this study: its numerical uncertainty is "
            "unknown, and no gate against it can pass."
        )
        return Section("convergence", "How good is the reference?", (Callout("doubt", text),))
    method = Paragraph(
        f"Each level of the ladder {', '.join(study.steps)} halves the element size and the time "
        f"step of the one before. The observed order comes from {_levels(study)} "
        "of the expected order the uncertainty is the grid convergence index with "
        "safety factor 1.25, else 3 [@roache1994] [@celik2008]. Sequences that oscillate or "
        f"diverge get three times their spread.{_alone(study)}"
    )
    blocks: list[Block] = [method]
    if study.models[study.reference].name in _BEAMS:
        blocks.append(Paragraph(_FIRST_ORDER))
    blocks.extend(figures)
    table = _table(study, stored)
    if table is None:
        blocks.append(Callout("doubt", "No case has answers on two levels of the ladder."))
    else:
        blocks.append(table)
    return Section("convergence", "How good is the reference?", tuple(blocks))


def _levels(study: Study) -> str:
    """What the order of a ladder is taken from, and where it is relied on."""
    if len(study.steps) < 4:
        return "the three finest levels; within 0.7 to 1.1"
    return f"a fit to all {len(study.steps)} levels [@eca-hoekstra2014]; within 0.5 to 1.1"


def _alone(study: Study) -> str:
    """What the interval holds beside the ladder, if the reference makes these runs itself."""
    if study.steps == study.ladder:
        return ""
    return (
        " Four times as many fibers and half the steps are tried on the coarsest mesh; what they "
        "change is part of the uncertainty."
    )


def _table(study: Study, stored: Stored) -> Table | None:
    rows = []
    for row in stored.tables["ladder"].to_dict("records"):
        known = any(not np.isnan(float(row.get(label, np.nan))) for label in study.steps)
        answered = all(
            stored.ok(row["case"], label)
            for label in (*study.ladder, study.reference)
            if stored.expects(row["case"], label)
        )
        if answered and not known:
            continue  # this kind of case does not have the quantity
        unit = unit_of(row["quantity"])
        levels = [float(row.get(label, np.nan)) for label in study.steps]
        accepted = row["accepted"] == "true"
        quantity = title_of(row["quantity"])
        rows.append(
            (
                Cell(row["case"]),
                Cell(f"{quantity} ({unit.text})" if unit.text else quantity),
                *(Cell(number(level * unit.factor), level) for level in levels),
                Cell(number(row["order"], 3), row["order"]),
                Cell(number(row["extrapolated"] * unit.factor), row["extrapolated"]),
                Cell(
                    percent(row["relative"], signed=False),
                    row["relative"],
                    "" if accepted else "doubt",
                ),
                Cell(row["note"], tone="muted"),
            )
        )
    if not rows:
        return None
    columns = (
        Column("case", width=1.6),
        Column("quantity", width=1.7),
        *(Column(label, True, 1.15) for label in study.steps),
        Column("order", True, 0.7),
        Column("extrapolated", True, 1.1),
        Column("uncertainty", True, 1.05),
        Column("note", width=2.4),
    )
    caption = f"Refinement ladder of {study.reference}: values, observed order, uncertainty."
    return Table("ladder", caption, columns, tuple(rows), 40)
