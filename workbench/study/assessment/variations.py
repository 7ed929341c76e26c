"""Variations for a budget of an answer: the varied scenarios, and its terms from their answers.

Inputs are varied one at a time, both ways. What is not known of the strain rate is how sensitive
the steel is: the reference rate D of its law, between the ends of 90 % of the steels. Where the
scenario has no rate law there are two budgets: one with the static yield stress, as it is given,
and one of the real column, whose steel has the law of the grade with the nearest yield stress.
Hardening is no term: beside a rate it is worth little, and both effects do not add.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from typing import Any, TypeVar

from workbench.base.errors import InputError
from workbench.base.fields import Number, check_keys
from workbench.models.base import on_one_mesh
from workbench.models.strain_rate import steel_of, with_rate
from workbench.responses import PEAK, RESIDUAL, Response, error_of, survives
from workbench.responses.uncertainty import WIDTHS, uncertainty_of
from workbench.scenarios import ColumnImpact
from workbench.steel.materials import GRADES, CowperSymonds
from workbench.study.assessment.gates import (
    RATE,
    REFERENCE,
    REMAINS,
    TOTAL,
    Term,
    model_form,
    numerical_term,
    together,
    varied_term,
)

# half-widths of what is known of an input, 90 % intervals, where a user gives no others
SPREADS = {"velocity": 0.05, "mass": 0.05, "yield_stress": 0.05, "restraint_stiffness": 0.05}
M = TypeVar("M")
_SPREAD = Number(0.0, 0.9)
STATIC, RATED = FORMS = "at the static yield stress", "with strain rate"
_ENDS = "rate slow", "rate fast"  # D at both ends
_GIVEN = "one input varied, both ways"


@dataclass(frozen=True)
class Budget:
    """A budget that a study asks for.

    Parameters
    ----------
    case : str
        Name of the case.
    models : tuple of str
        Labels that it is for.
    spreads : mapping
        Half-widths of inputs as shares, instead of those of `SPREADS`; zero leaves one out.

    Raises
    ------
    InputError
        For unknown inputs and shares that are none.

    Examples
    --------
    >>> wb.Budget("slow", ("4 dof",), spreads={"velocity": 0.1}).spreads
    {'velocity': 0.1}
    """

    case: str
    models: tuple[str, ...]
    spreads: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_keys(list(self.spreads), list(SPREADS), "spread")
        for name, share in self.spreads.items():
            _SPREAD.check(f"spread.{name}", share)

    def variations(self, scenario: Any) -> dict[str, ColumnImpact]:
        """The varied scenarios by name. Raises `InputError` for what is no impact on a column.

        Where the steel has no rate law, the scenario with that of its grade too, under the name
        `RATED`, and varied as well.
        """
        if not isinstance(scenario, ColumnImpact):
            raise InputError("budget", scenario.KIND, f"is for {ColumnImpact.KIND} alone")
        varied = self._varied(scenario)
        if scenario.column.steel.rate is None:
            real = with_rate(scenario, rate_law(scenario))
            varied[RATED] = real
            varied |= {_rated(name): each for name, each in self._varied(real).items()}
        return varied

    def _varied(self, scenario: ColumnImpact) -> dict[str, ColumnImpact]:
        """The scenario with its inputs and its rate law varied, one at a time."""
        varied = {}
        for name, share in self.shares(scenario).items():
            for sign in (-1.0, 1.0):
                factor = 1.0 + sign * share
                varied[_key(name, sign * share)] = _VARY[name](scenario, factor)
        law = scenario.column.steel.rate
        if law is not None and law.slow is not None and law.fast is not None:
            for name, rate in zip(_ENDS, (law.slow, law.fast), strict=True):
                end = replace(law, reference_rate=rate, slow=None, fast=None)
                varied[name] = with_rate(scenario, end)
        return varied

    def solver(self, name: str, model: M) -> M:
        """The model that answers the variation of this name: references do it on one mesh.

        The scenario `RATED` has a budget of its own, with its numerical uncertainty.
        """
        return model if name == RATED else on_one_mesh(model)

    def shares(self, scenario: ColumnImpact) -> dict[str, float]:
        """Half-widths of the inputs that count in a scenario."""
        shares = {**SPREADS, **self.spreads}
        if scenario.column.restraint_stiffness == 0.0:
            del shares["restraint_stiffness"]
        return {name: share for name, share in shares.items() if share}

    def rows(
        self, scenario: ColumnImpact, answer: Response, varied_answers: Mapping[str, Response]
    ) -> Iterator[dict[str, Any]]:
        """The budgets of an answer as rows: `form`, `quantity`, `value`, and those of `Term`.

        One with the steel of the scenario and, where that has no rate law, one of the real column.
        Arguments as of `terms`; the answer `RATED` carries the error to expect of it too.
        """
        given = scenario.column.steel.rate is not None
        budgets = {RATED if given else STATIC: (scenario, answer, varied_answers)}
        if RATED in varied_answers:
            real = with_rate(scenario, rate_law(scenario))
            names = {name: _rated(name) for name in self._varied(real)}
            known = {k: varied_answers[n] for k, n in names.items() if n in varied_answers}
            budgets[RATED] = real, varied_answers[RATED], known
        for form in reversed(FORMS):
            if form not in budgets:
                continue
            for quantity, terms in self.terms(*budgets[form]).items():
                value = float(budgets[form][1][quantity])
                who = {"form": form, "quantity": quantity, "value": value}
                yield from ({**who, **term.as_dict(value)} for term in terms)

    def terms(
        self, scenario: ColumnImpact, answer: Response, varied_answers: Mapping[str, Response]
    ) -> dict[str, list[Term]]:
        """Terms and sums of an answer by quantity; none for what it does not know.

        Arguments: the `answer` to the `scenario`, with the error to expect of it (`advised`);
        `varied_answers` by the names of `variations` (absent: no answer). Where a part is not
        known there is no total. The strain rate is a part where the steel has a law.
        """
        peak = _value(answer, PEAK)
        error = error_of(answer) if "error" in answer.attrs else None
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
            parts = [form, *inputs]
            if scenario.column.steel.rate is not None:
                ends = [at(name) for name in _ENDS]
                parts.append(_rate_term(scenario.column.steel.rate, value, ends))
            sums = [
                together(name, of)
                for name, of in ((REFERENCE, parts[:1]), (TOTAL, parts))
                if all(term.known for term in of)
            ]
            by_quantity[quantity] = [numerical_term(value, width), *parts, *sums]
        return by_quantity


def rate_law(scenario: Any) -> CowperSymonds:
    """The rate law of the steel, or of the grade that its yield stress is nearest to."""
    steel: Any = steel_of(scenario)
    nearest = min(GRADES.values(), key=lambda grade: abs(grade[0] - steel.yield_stress))
    return steel.rate or nearest[1]


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


def _rated(name: str) -> str:
    return f"{RATED}, {name}"


def _rate_term(law: CowperSymonds, value: float, answers: Sequence[float | None]) -> Term:
    """Term that the rate law of the steel leaves open, by the `answers` at both ends of its D."""
    if law.slow is None or law.fast is None:
        text = "the 90 % interval of D is not given (D_range)"
        return Term(RATE, text, "", 0.0, None, None)
    term = varied_term(RATE, value, answers, "[@cowper-symonds1957]")
    reason = "; ".join(filter(None, (f"D {law.slow:g} to {law.fast:g} 1/s", term.reason)))
    return replace(term, reason=reason)


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
