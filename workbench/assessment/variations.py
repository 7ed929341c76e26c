"""What a budget of an answer takes: the varied scenarios, and its terms from their answers.

Inputs are varied one at a time, both ways. What is not known of the strain rate is how sensitive
the steel is: the reference rate D of its law, between the ends of 90 % of the steels. Where the
scenario has no rate law, the answer moves to that of the grade with the nearest yield stress.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isinf, log
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
from workbench.materials import GRADES, CowperSymonds
from workbench.models.strain_rate import with_rate
from workbench.responses import Response, survives
from workbench.responses.uncertainty import WIDTHS, uncertainty_of
from workbench.scenarios import ColumnImpact

# half-widths of what is known of an input, 90 % intervals, where a user gives no others
SPREADS = {"velocity": 0.05, "mass": 0.05, "yield_stress": 0.05, "restraint_stiffness": 0.05}
_SPREAD = Number(0.0, 0.9)
_RATES = "rate", "rate slow", "rate fast"  # the law itself, and D at both ends
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
        return {**varied, **_rate_variations(scenario)}

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
            parts = [form, *inputs, _rate_term(scenario, value, [at(name) for name in _RATES])]
            sums = [
                together(name, of)
                for name, of in ((REFERENCE, parts[:1]), (TOTAL, parts))
                if all(term.known for term in of)
            ]
            by_quantity[quantity] = [numerical_term(value, width), *parts, *sums]
        return by_quantity


def rate_law(scenario: ColumnImpact) -> CowperSymonds:
    """The rate law of the steel, or of the grade that its yield stress is nearest to."""
    steel = scenario.column.steel
    nearest = min(GRADES.values(), key=lambda grade: abs(grade[0] - steel.yield_stress))
    return steel.rate or nearest[1]


def _rate_variations(scenario: ColumnImpact) -> dict[str, ColumnImpact]:
    law = rate_law(scenario)
    laws: dict[str, CowperSymonds] = {}
    if scenario.column.steel.rate is None:
        laws[_RATES[0]] = law
    if law.slow is not None and law.fast is not None:
        for name, rate in zip(_RATES[1:], (law.slow, law.fast), strict=True):
            laws[name] = replace(law, reference_rate=rate, slow=None, fast=None)
    return {name: with_rate(scenario, each) for name, each in laws.items()}


def _stronger(scenario: ColumnImpact, factor: float) -> ColumnImpact:
    return replace(scenario, column=scenario.column.stronger(factor))


def _heavier(scenario: ColumnImpact, factor: float) -> ColumnImpact:
    striker = scenario.striker
    return replace(scenario, striker=replace(striker, mass=factor * striker.mass))


def _restrained(scenario: ColumnImpact, factor: float) -> ColumnImpact:
    stiffness = factor * scenario.column.restraint_stiffness
    return replace(scenario, column=replace(scenario.column, restraint_stiffness=stiffness))


_VARY: dict[str, Callable[[ColumnImpact, float], ColumnImpact]] = {
    "velocity": lambda scenario, factor: scenario.at_velocity(factor * scenario.striker.velocity),
    "mass": _heavier,
    "yield_stress": _stronger,
    "restraint_stiffness": _restrained,
}


def _key(name: str, share: float) -> str:
    return f"{name} {100 * share:+g} %"


def _rate_term(scenario: ColumnImpact, value: float, answers: Sequence[float | None]) -> Term:
    """What the rate law of the steel leaves open; it moves an answer that has none."""
    law, given = rate_law(scenario), scenario.column.steel.rate is not None
    if law.slow is None or law.fast is None:
        text = "the 90 % interval of D is not given (D_range)"
        return Term(RATE, text, "", 0.0, None, None)
    middle, *ends = (value, *answers[1:]) if given else answers
    term = varied_term(RATE, middle or value, ends, "[@cowper-symonds1957]")
    if middle is None or not term.known:
        return replace(term, below=None, above=None)
    text = f"D {law.slow:g} to {law.fast:g} 1/s" + ("" if given else "; the answer knows no rate")
    reason = "; ".join(filter(None, (text, term.reason)))
    return replace(term, reason=reason, shift=0.0 if isinf(middle) else log(middle / value))


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
