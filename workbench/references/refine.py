"""Numerical uncertainty of a reference: refinement by direction, combined, with its statements.

Space and time are halved together, as the discretisation errors of both are of first order; time
alone and fibers alone are halved on the coarsest mesh. See docs/theory/numerical-uncertainty.md.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.references.column_rules import time_spans
from workbench.responses import Finding, Outcome, Response, add_warnings, outcome_of
from workbench.responses.convergence import Ladder, ladder
from workbench.responses.variables import SCALARS
from workbench.scenarios import ColumnImpact, ColumnPushover, Scenario

IMPACT_QUANTITIES = ("peak_displacement", "time_of_peak", "residual_displacement")
PUSH_SHARES = (0.25, 0.5, 0.75, 1.0)  # of the final displacement, where forces are read
FORCE_AT = "force at "  # followed by a displacement: "force at 0.05 m"
SPACE_AND_TIME, TIME, FIBERS, STEPS = "space and time", "time", "fibers", "push steps"
REGULARISED, SENSITIVITY = "regularised", "hardening times 10"
REGULARISING = 0.01  # hardening over elastic modulus that spreads a hinge over a length of its own
SEPARATE_LEVELS = 3

Values = Mapping[str, float]


@dataclass(frozen=True)
class Direction:
    """What halving one kind of step says about one quantity.

    `values` from coarse to fine; `found`, their ladder (None: unknown); `uncertainty`, half-width
    that this direction leaves in the response (None: unknown); `note`, one sentence.
    """

    values: tuple[float, ...]
    found: Ladder | None
    uncertainty: float | None
    note: str


def refine(
    model: Any,
    scenario: Scenario,
    quantities: Sequence[str] | None = None,
    levels: int = 3,
) -> Response:
    """The response on the finest of several meshes, with its numerical uncertainty.

    Arguments: `model`, a reference with the option `refinement`, as it is the coarsest level;
    `quantities`, scalars of a response or ``"force at 0.05 m"`` in a pushover (None: peak, its
    time and residual displacement under impact; input energy and forces at quarters of the push);
    `levels` in space and time, each half of the one before.
    The result carries two attributes in JSON: `numerical_uncertainty`, quantity to absolute
    half-width in SI (null: unknown, the reason stands in the other), and `refinement` with the
    levels, all directions and the statements. A level that fails leaves the uncertainty unknown;
    if the finest fails, its outcome is the answer. Raises `InputError` for a model without
    refinement, fewer than two levels, or quantities that are not known.
    """
    options = {field.name for field in fields(model)}
    if "refinement" not in options:
        raise InputError("model", model.name, "has no option refinement", "use a reference")
    if levels < 2:
        raise InputError("levels", levels, "must be 2 or more")
    asked = _quantities(scenario, quantities)
    failures: list[str] = []

    def run(name: str, variant: Any) -> Values:
        response = variant.simulate(scenario)
        if outcome_of(response) is not Outcome.OK:
            failures.append(f"{name}: {outcome_of(response)}, {response.attrs['message']}")
            return {}
        return read(response, asked)

    joint = [replace(model, refinement=model.refinement + k) for k in range(levels)]
    coarse = [run(f"{SPACE_AND_TIME}, level {k}", joint[k]) for k in range(levels - 1)]
    finest: Response = joint[-1].simulate(scenario)
    if outcome_of(finest) is not Outcome.OK:
        return finest
    tables = {SPACE_AND_TIME: [*coarse, read(finest, asked)]}
    for name, variants in _separate(model, scenario, options, levels).items():
        first = coarse[0] if variants[0] == model else run(f"{name}, level 0", variants[0])
        rest = [run(f"{name}, level {k}", v) for k, v in enumerate(variants[1:], 1)]
        tables[name] = [first, *rest]
    found = {q: {n: _direction(n, t, q) for n, t in tables.items()} for q in asked}
    widths = {q: combined({n: d.uncertainty for n, d in found[q].items()}) for q in asked}
    statements = [*failures]
    drifting = [q for q in asked if _drifts(found[q][SPACE_AND_TIME])]
    hardening = {} if "hardening_ratio" not in options else _hardening(model, coarse[0], asked, run)
    regular: dict[str, Direction] = {}
    if drifting:
        statements.append(_drift_text(drifting))
        if hardening:
            variants = [replace(m, hardening_ratio=REGULARISING) for m in joint]
            table = [run(f"{REGULARISED}, level {k}", v) for k, v in enumerate(variants)]
            regular = {q: _direction(SPACE_AND_TIME, table, q) for q in drifting}
            statements.extend(_regular_text(q, d) for q, d in regular.items())
    if failures and any(width is None for width in widths.values()):
        statements.append("a level without an answer leaves the uncertainty unknown")
    finest.attrs["numerical_uncertainty"] = json.dumps(widths, sort_keys=True)
    finest.attrs["refinement"] = json.dumps(
        {
            "levels": [m.refinement for m in joint],
            "directions": {q: {n: asdict(d) for n, d in found[q].items()} for q in asked},
            SENSITIVITY: hardening,
            REGULARISED: {q: asdict(d) for q, d in regular.items()},
            "quadrature": "fixed by the element, no option: part of space",
            "statements": statements,
        },
        sort_keys=True,
    )
    add_warnings(finest, [Finding("refinement", text) for text in statements])
    return finest


def combined(widths: Mapping[str, float | None]) -> float | None:
    """Half-width from those of the directions: the larger of joint and time alone, plus the rest.

    Discretisation errors are not random and may have one sign, so that they add up (ASME V&V 20
    adds them likewise). Time is part of the joint sequence; alone it counts if it says more, as
    errors of space and time may cancel. None (unknown) in any direction makes the result None.
    """
    if any(width is None for width in widths.values()):
        return None
    known = {name: width or 0.0 for name, width in widths.items()}
    both = max(known.pop(SPACE_AND_TIME, 0.0), known.pop(TIME, 0.0))
    return both + sum(known.values())


def read(response: Response, quantities: Sequence[str]) -> dict[str, float]:
    """Values of scalars, or of the force at a displacement; those that are absent are left out."""
    values = {}
    for quantity in quantities:
        if quantity.startswith(FORCE_AT):
            at, reached = _displacement(quantity), response["displacement"].values
            if at <= reached[-1] * (1.0 + 1e-9):
                values[quantity] = float(np.interp(at, reached, response["force"].values))
        elif quantity in response:
            values[quantity] = float(response[quantity])
    return values


def _quantities(scenario: Scenario, quantities: Sequence[str] | None) -> tuple[str, ...]:
    pushed = isinstance(scenario, ColumnPushover)
    if quantities is None:
        if not isinstance(scenario, ColumnPushover):
            return IMPACT_QUANTITIES
        forces = [f"{FORCE_AT}{share * scenario.displacement:.12g} m" for share in PUSH_SHARES]
        return ("input_energy", *forces)
    for quantity in quantities:
        force = pushed and quantity.startswith(FORCE_AT)
        if force:
            _displacement(quantity)
        elif quantity not in SCALARS:
            allowed = f"must be one of {', '.join(SCALARS)}, or in a pushover 'force at 0.05 m'"
            raise InputError("quantities", quantity, allowed)
    return tuple(quantities)


def _displacement(quantity: str) -> float:
    try:
        return float(quantity.removeprefix(FORCE_AT).removesuffix(" m"))
    except ValueError as error:
        raise InputError("quantities", quantity, "must read 'force at 0.05 m'") from error


def _separate(
    model: Any, scenario: Scenario, options: set[str], levels: int
) -> dict[str, list[Any]]:
    """Sequences that halve one thing on the coarsest mesh, coarse to fine."""
    sequences: dict[str, list[Any]] = {}
    if "layers" in options:
        sequences[FIBERS] = [
            replace(model, layers=model.layers * 2**k) for k in range(SEPARATE_LEVELS)
        ]
    if "time_step" in options and isinstance(scenario, ColumnImpact):
        # constant steps as long as the first ones of the default, so that only they differ
        first = time_spans(scenario, model.time_step, 0)[0][1]
        sequences[TIME] = [replace(model, time_step=first / 2**k) for k in range(levels)]
    if "step" in options and isinstance(scenario, ColumnPushover):
        first = float(np.max(np.diff(model.path(scenario))))
        sequences[STEPS] = [replace(model, step=first / 2**k) for k in range(SEPARATE_LEVELS)]
    return sequences


def _direction(name: str, table: Sequence[Values], quantity: str) -> Direction:
    values = tuple(level[quantity] for level in table if quantity in level)
    if len(values) < len(table):
        missing = [str(k) for k, level in enumerate(table) if quantity not in level]
        note = f"level {', '.join(missing)} has no {quantity}: unknown"
        return Direction(values, None, None, note)
    found = ladder(values)
    if name in (SPACE_AND_TIME, TIME):
        return Direction(values, found, found.uncertainty, found.note)
    # the response keeps the first of these values: its distance to the limit counts as well
    width = abs(values[0] - found.extrapolated) + found.uncertainty
    return Direction(values, found, width, found.note)


def _drifts(joint: Direction) -> bool:
    return joint.found is not None and not joint.found.converging


def _hardening(
    model: Any, base: Values, asked: Sequence[str], run: Callable[[str, Any], Values]
) -> dict[str, float]:
    """Relative change of every quantity by ten times the hardening, on the coarsest mesh."""
    more = min(10.0 * model.hardening_ratio, 0.1)
    if more <= model.hardening_ratio:
        return {}
    changed = run(SENSITIVITY, replace(model, hardening_ratio=more))
    return {q: changed[q] / base[q] - 1.0 for q in asked if base.get(q) and q in changed}


def _drift_text(quantities: Sequence[str]) -> str:
    return (
        f"{', '.join(quantities)}: the sequence of meshes does not converge. Perfect plasticity "
        "has no length of its own, strains localise in single elements; three times the spread "
        "stands for the uncertainty. Use a hardening_ratio for an answer that does not depend on "
        "the mesh"
    )


def _regular_text(quantity: str, direction: Direction) -> str:
    found = direction.found
    if found is None:
        return f"{quantity} with hardening_ratio = {REGULARISING:g}: {direction.note}"
    ends = "converges" if found.converging else "does not converge either"
    return (
        f"{quantity} with hardening_ratio = {REGULARISING:g} {ends}: {found.finest:.6g} "
        f"+- {found.uncertainty:.2g} ({found.note})"
    )
