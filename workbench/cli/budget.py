"""The error budget of one answer: the varied runs of `workbench simulate --budget`."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import TYPE_CHECKING, Any

from workbench.errors import InputError

if TYPE_CHECKING:
    from workbench.assessment.variations import Budget
    from workbench.content.tree import Block
    from workbench.models.base import Model
    from workbench.responses import Response
    from workbench.scenarios import Scenario


def budget_from(texts: list[str]) -> Budget:
    """The budget with spreads from texts like ``velocity=0.1``. Raises `InputError`."""
    from workbench.assessment.variations import Budget
    from workbench.scenarios import parse_value

    spreads = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise InputError("--spread", text, "must look like velocity=0.1")
        spreads[name.strip()] = parse_value(value.strip())
    return Budget("", (), spreads)


def budgeted(
    budget: Budget, model: Model, scenario: Scenario, answer: Response
) -> dict[str, list[dict[str, Any]]]:
    """Terms and sums by quantity as tables hold them; the model answers the varied scenarios.

    Raises `InputError` if the scenario is no impact on a column.
    """
    from workbench.models.base import on_one_mesh

    runs, alone = budget.variations(scenario), on_one_mesh(model)
    varied = {name: alone.simulate(each) for name, each in runs.items()}
    found = budget.terms(model, scenario, answer, varied)  # type: ignore[arg-type]
    return {quantity: [term.as_dict() for term in terms] for quantity, terms in found.items()}


def plain(found: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """A budget as JSON holds it: an end that is a collapse is null, and `collapses` says so."""

    def term(row: dict[str, Any]) -> dict[str, Any]:
        fallen = row["high"] is not None and not isfinite(row["high"])
        return {**row, "high": None if fallen else row["high"], "collapses": fallen}

    return {quantity: [term(row) for row in rows] for quantity, rows in found.items()}


def budget_blocks(answer: Response, found: dict[str, list[dict[str, Any]]]) -> Iterator[Block]:
    """The tables of a budget with bars, and why there is none."""
    from workbench.content.budgets import budget_table
    from workbench.content.tree import Callout

    if not found:
        yield Callout("doubt", "No error budget: the model gives no displacement.")
    for quantity, rows in found.items():
        yield budget_table(quantity, quantity, float(answer[quantity]), rows, bars=True)
