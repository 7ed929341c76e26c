"""What a budget of an answer takes: the varied scenarios, and its terms from their answers.

Inputs are varied one at a time, both ways. The models know no strain rate, so that its effect is an
estimate: all of the steel is as strong as Cowper and Symonds find mild steel at the rate of the
hinges, while the column is hit. It can only make the answer smaller, and by less in stronger steels
and at large strains, where the sensitivity fades: by an unknown part of what is stated.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from typing import Any

from workbench.assessment.budget import (
    PEAK,
    RATE,
    REFERENCE,
    REMAINS,
    RESIDUAL,
    TOTAL,
    Term,
    model_form,
    numerical_term,
    together,
    varied_term,
)
from workbench.errors import InputError
from workbench.fields import Number, check_keys
from workbench.responses import Response, survives
from workbench.responses.uncertainty import WIDTHS, uncertainty_of
from workbench.scenarios import ColumnImpact

# half-widths of what is known of an input, 90 % intervals, where a user gives no others
SPREADS = {"velocity": 0.05, "mass": 0.05, "yield_stress": 0.05, "restraint_stiffness": 0.05}
_SPREAD = Number(0.0, 0.9)
MILD_STEEL = 40.4, 5.0  # D in 1/s and q of mild steel (cowper-symonds1957)
_STRENGTHS = ("plastic_moment", "squash_load")  # overrides that grow with the yield stress
_RATE_KEY = "rate"
_GIVEN = "one input varied, both ways"


@dataclass(frozen=True)
class Budget:
    """A budget that a study asks for: a `case` and the labels of the `models` that it is for.

    `spreads` are half-widths of inputs as shares, instead of those of `SPREADS`; zero leaves an
    input out. Raises `InputError` for unknown inputs and shares that are none.
    """

    case: str
    models: tuple[str, ...]
    spreads: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_keys(list(self.spreads), list(SPREADS), "spread")
        for name, share in self.spreads.items():
            _SPREAD.check(f"spread.{name}", share)

    def variations(self, scenario: Any) -> dict[str, ColumnImpact]:
        """The varied scenarios by name. Raises `InputError` for what is no impact on a column."""
        if not isinstance(scenario, ColumnImpact):
            raise InputError("budget", scenario.KIND, f"is for {ColumnImpact.KIND} alone")
        varied = {}
        for name, share in self.shares(scenario).items():
            for sign in (-1.0, 1.0):
                factor = 1.0 + sign * share
                varied[_key(name, sign * share)] = _VARY[name](scenario, factor)
        return {**varied, _RATE_KEY: stronger(scenario, rate_factor(strain_rate(scenario)))}

    def shares(self, scenario: ColumnImpact) -> dict[str, float]:
        """Half-widths of the inputs that count in a scenario."""
        shares = {**SPREADS, **self.spreads}
        if scenario.column.restraint_stiffness == 0.0:
            del shares["restraint_stiffness"]
        return {name: share for name, share in shares.items() if share}

    def terms(
        self, scenario: ColumnImpact, answer: Response, varied_answers: Mapping[str, Response]
    ) -> dict[str, list[Term]]:
        """Terms and sums of an answer by quantity; none for what it does not know.

        Arguments: the `answer` to the `scenario`, with the error to expect of it (`advised`);
        `varied_answers` by the names of `variations` (absent: no answer). Where a part is not
        known there is no total.
        """
        peak = _value(answer, PEAK)
        error = json.loads(answer.attrs.get("error", "{}"))
        by_quantity = {}
        for quantity in (PEAK, RESIDUAL):
            value = _value(answer, quantity)
            if value is None or peak is None or value < REMAINS * peak or value <= 0.0:
                continue
            at = partial(_varied_value, varied_answers, quantity)
            width = uncertainty_of(answer, quantity) if WIDTHS in answer.attrs else 0.0
            form = model_form(error, quantity, value)
            inputs = [
                varied_term(f"{name.replace('_', ' ')} ±{100 * share:g} %", value, ends, _GIVEN)
                for name, share in self.shares(scenario).items()
                for ends in [[at(_key(name, -share)), at(_key(name, share))]]
            ]
            parts = [form, *inputs, _rate_term(scenario, value, at(_RATE_KEY))]
            sums = [
                together(name, of)
                for name, of in ((REFERENCE, parts[:1]), (TOTAL, parts))
                if all(term.known for term in of)
            ]
            by_quantity[quantity] = [numerical_term(value, width), *parts, *sums]
        return by_quantity


def strain_rate(scenario: ColumnImpact) -> float:
    """Mean strain rate of the steel in the hinges while the column is hit, 1/s.

    The hit point moves at half the velocity that striker and lumped mass share at first; the
    shorter segment turns as a bar, over a hinge as long as the section is high. A web that slides
    instead has an equivalent rate (1 / 3^½ of its shear) 15 % higher.
    """
    column, striker = scenario.column, scenario.striker
    shared = striker.mass / (striker.mass + column.properties.impact_mass)
    mean = 0.5 * shared * striker.velocity
    return 0.5 * mean / min(column.length_below, column.length_above)


def rate_factor(rate: float) -> float:
    """Yield stress of mild steel at a strain rate (1/s) over the static one."""
    reference, exponent = MILD_STEEL
    return float(1.0 + (rate / reference) ** (1.0 / exponent))


def stronger(scenario: ColumnImpact, factor: float) -> ColumnImpact:
    """The scenario with another yield stress, and the strengths given for the section alike."""
    column = scenario.column
    strengths = {name: getattr(column, name) for name in _STRENGTHS}
    given = {name: factor * value for name, value in strengths.items() if value is not None}
    steel = replace(column.steel, yield_stress=factor * column.steel.yield_stress)
    return replace(scenario, column=replace(column, steel=steel, **given))


def _heavier(scenario: ColumnImpact, factor: float) -> ColumnImpact:
    striker = scenario.striker
    return replace(scenario, striker=replace(striker, mass=factor * striker.mass))


def _restrained(scenario: ColumnImpact, factor: float) -> ColumnImpact:
    stiffness = factor * scenario.column.restraint_stiffness
    return replace(scenario, column=replace(scenario.column, restraint_stiffness=stiffness))


_VARY: dict[str, Callable[[ColumnImpact, float], ColumnImpact]] = {
    "velocity": lambda scenario, factor: scenario.at_velocity(factor * scenario.striker.velocity),
    "mass": _heavier,
    "yield_stress": stronger,
    "restraint_stiffness": _restrained,
}


def _key(name: str, share: float) -> str:
    return f"{name} {100 * share:+g} %"


def _rate_term(scenario: ColumnImpact, value: float, stronger_value: float | None) -> Term:
    rate = strain_rate(scenario)
    term = varied_term(RATE, value, [stronger_value], "[@cowper-symonds1957]")
    text = f"estimate: {rate_factor(rate):.2f} times the yield stress at {rate:.2g} 1/s, one-sided"
    return replace(term, reason=text if term.known else term.reason, pulls=True)


def _value(answer: Response | None, quantity: str) -> float | None:
    if answer is None or quantity not in answer:
        return None
    return float(answer[quantity])


def _varied_value(answers: Mapping[str, Response], quantity: str, key: str) -> float | None:
    answer = answers.get(key)
    if answer is not None and survives(answer) is False:
        return inf
    value = _value(answer, quantity)
    return value if value is not None and value > 0.0 else None
