"""Sequences of meshes that do not converge because strains localise in single elements.

Perfect plasticity has no length of its own. Hardening gives it one: with enough of it the same
meshes converge, and on one mesh its influence can be told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from workbench.references.quantities import read
from workbench.responses import Outcome, Response, outcome_of
from workbench.responses.uncertainty import (
    SPACE_AND_STEPS,
    Direction,
    Estimate,
    estimate,
    level_names,
)
from workbench.scenarios import Scenario

REGULARISED, SENSITIVITY = "regularised", "hardening times 10"
REGULARISING = 0.01  # hardening over elastic modulus that spreads a hinge over a length of its own
MOST_HARDENING = 0.1

Values = Mapping[str, float]


def localisation_of(
    meshes: Sequence[Any],
    scenario: Scenario,
    values: Mapping[str, Values],
    quantities: Sequence[str],
    drifting: Sequence[str],
) -> tuple[dict[str, Any], list[str]]:
    """What hardening changes: tables for the attributes of a response, and sentences.

    Arguments: the model on its `meshes` from coarse to fine; `values` of the `quantities` by run;
    those that are `drifting`. The coarsest mesh answers with ten times the hardening; all meshes
    answer with a hardening that regularises, if a quantity drifts.
    """
    names = level_names(len(meshes))
    base = values.get(names[0], {})
    if not hasattr(meshes[0], "hardening_ratio") or not base:
        return {}, []
    sensitivity: dict[str, float] = {}
    ratio = meshes[0].hardening_ratio
    more = min(10.0 * ratio, MOST_HARDENING)
    if more > ratio:
        changed = _values(replace(meshes[0], hardening_ratio=more), scenario, quantities)
        both = [q for q in quantities if base.get(q) and q in changed]
        sensitivity = {q: changed[q] / base[q] - 1.0 for q in both}
    if not drifting:
        return {SENSITIVITY: sensitivity}, []
    table = {
        name: _values(replace(mesh, hardening_ratio=REGULARISING), scenario, drifting)
        for name, mesh in zip(names, meshes, strict=True)
    }
    ladder = (Direction(SPACE_AND_STEPS, names),)
    found = {q: estimate(ladder, by_run(table, q)) for q in drifting}
    regular = {q: told(found[q], by_run(table, q)) for q in drifting}
    return (
        {SENSITIVITY: sensitivity, REGULARISED: regular},
        [_regular_text(q, found[q]) for q in drifting],
    )


def by_run(values: Mapping[str, Values], quantity: str) -> dict[str, float]:
    """Values of a quantity by run, from the values of all quantities by run."""
    return {name: found[quantity] for name, found in values.items() if quantity in found}


def told(found: Estimate, values: Values) -> dict[str, Any]:
    """An estimate and its values, as the attributes of a response hold them."""
    table: dict[str, Any] = {"values": dict(values), "parts": dict(found.parts), "note": found.note}
    if found.found is not None:
        for name in ("order", "extrapolated", "converging", "accepted"):
            table[name] = getattr(found.found, name)
    return table


def drift_text(quantities: Sequence[str], response: Response) -> str:
    """What to say of quantities of a response that the meshes do not agree on."""
    text = (
        f"{', '.join(quantities)}: the sequence of meshes does not converge, three times the "
        "spread stands for the uncertainty"
    )
    if "dissipated" in response and float(response["dissipated"].max()) == 0.0:
        return text
    return (
        f"{text}. Perfect plasticity has no length of its own, strains localise in single "
        "elements: use a hardening_ratio for an answer that does not depend on the mesh"
    )


def _values(model: Any, scenario: Scenario, quantities: Sequence[str]) -> dict[str, float]:
    response = model.simulate(scenario)
    return read(response, quantities) if outcome_of(response) is Outcome.OK else {}


def _regular_text(quantity: str, regular: Estimate) -> str:
    head = f"{quantity} with hardening_ratio = {REGULARISING:g}"
    found = regular.found
    if found is None:
        return f"{head}: {regular.note}"
    ends = "converges" if found.converging else "does not converge either"
    return f"{head} {ends}: {found.finest:.6g} +- {found.uncertainty:.2g} ({found.note})"
