"""How well the reference itself is known: its refinement ladder."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from workbench.content.formatting import axis_label, share, unit_of, valued
from workbench.content.tree import Block, Callout, Cell, Column, Paragraph, Section, Table
from workbench.report.stored import Stored
from workbench.study.definition import DATA, Study

_MEASURED = (*DATA, "stud-measured")
_BEAMS = ("fiber-reissner", "fiber-corotational", "fiber-shear")
_FIRST_ORDER = (
    "First order is expected, although elastic beams converge at second: a plastic hinge forms in "
    "the element at a support or under the striker, whose section is sampled inside it, half an "
    "element (exact beam) or a fifth of one (co-rotational beam) away from where the moment is "
    "largest. The lever arms of a mechanism come out too short by that, and its resistance too "
    "large, in proportion to the element. In time the collision takes half a step."
)
# of a reference that makes these runs itself
_ALONE = (
    " Four times as many fibers and half the steps are tried on the coarsest mesh; what they "
    "change is part of the uncertainty."
)


def convergence(study: Study, stored: Stored, figures: Iterable[Block]) -> Section:
    """The table of the ladder and the figures that show it."""
    blocks = tuple(_convergence(study, stored, figures))
    return Section("convergence", "How good is the reference?", blocks)


def _convergence(study: Study, stored: Stored, figures: Iterable[Block]) -> Iterator[Block]:
    name = study.models[study.reference].name
    if name in _MEASURED:
        yield Paragraph(f"{study.reference} are measured numbers: there is no mesh to refine.")
        return
    if len(study.steps) < 2:
        yield Callout(
            "doubt",
            f"{study.reference} is not refined in this study: its numerical uncertainty is "
            "unknown, and no gate against it can pass.",
        )
        return
    order = "the three finest levels; within 0.7 to 1.1"
    if len(study.steps) >= 4:
        order = f"a fit to all {len(study.steps)} levels [@eca-hoekstra2014]; within 0.5 to 1.1"
    yield Paragraph(
        f"Each level of the ladder {', '.join(study.steps)} halves the element size and the time "
        f"step of the one before. The observed order comes from {order} "
        "of the expected order the uncertainty is the grid convergence index with "
        "safety factor 1.25, else 3 [@roache1994] [@celik2008]. Sequences that oscillate or "
        f"diverge get three times their spread.{'' if study.steps == study.ladder else _ALONE}"
    )
    if name in _BEAMS:
        yield Paragraph(_FIRST_ORDER)
    yield from figures
    rows = [row for row in stored.rows["ladder"] if _has(study, stored, row)]
    if rows:
        caption = (
            f"Refinement ladder of {study.reference}: values, observed order, numerical "
            "uncertainty."
        )
        yield Table.of("ladder", caption, _columns(study), rows, 40)
    else:
        yield Callout("doubt", "No case has answers on two levels of the ladder.")


def _has(study: Study, stored: Stored, row: dict[str, Any]) -> bool:
    """Whether a row of the ladder has values, or lacks them because a level did not answer."""
    return any(row[label] is not None for label in study.steps) or any(
        stored.expects(row["case"], label) and not stored.ok(row["case"], label)
        for label in (*study.ladder, study.reference)
    )


def _columns(study: Study) -> Iterator[Column]:
    def value(name: str) -> Callable[[Any], Cell]:
        return lambda row: valued(row[name], 4, factor=unit_of(row["quantity"]).factor)

    yield Column("case", width=1.6, of="case")
    yield Column("quantity", width=1.7, of=lambda row: axis_label(row["quantity"]))
    for label in study.steps:
        yield Column(label, True, 1.15, value(label))
    yield Column("order", True, 0.7, lambda row: valued(row["order"], 3))
    yield Column("extrapolated", True, 1.1, value("extrapolated"))
    yield Column(
        *("numerical uncertainty", True, 1.05),
        lambda row: share(row["relative"], "" if row["accepted"] == "true" else "doubt"),
    )
    yield Column("note", width=2.4, of=lambda row: Cell(row["note"], tone="muted"))
