"""Comparing the answers of one case, with the numerical uncertainty that goes with each number.

Where the uncertainty of a comparison comes from:

- A side that is the reference of the study has that of its refinement ladder in this case (grid
  convergence index); without a ladder in the case it is unknown.
- A side that carries published or measured numbers (attribute `data_uncertainty` of its response)
  has the half-width stated there.
- Any other side, a reduced model, counts as exact in itself: its discretisation is part of what
  is judged. The note of the comparison says so when no side has an uncertainty of its own.

For scalar quantities the two sides combine as ASME V&V 20 does. Metrics of histories and curves
are evaluated against every level of the ladder; the ladder of these values gives their interval.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from workbench.assessment import (
    METRICS,
    ErrorInterval,
    Gate,
    Ladder,
    Metric,
    Scope,
    expand,
    judge,
    ladder,
)
from workbench.errors import InputError
from workbench.responses import Outcome, Response, outcome_of
from workbench.study.definition import Case, Study
from workbench.study.tables import Row

_EXACT = "no side has an estimate of its own numerical error; counted as zero"


def _of_logarithm(interval: ErrorInterval, pair: tuple[float, float]) -> float | None:
    relative = interval.relative_uncertainty
    return None if relative is None else relative * abs(pair[1] / pair[0])


# How the uncertainty of the two numbers becomes that of a metric of them.
_SPREAD: dict[str, Callable[[ErrorInterval, tuple[float, float]], float | None]] = {
    "difference": lambda interval, pair: interval.uncertainty,
    "relative_error": lambda interval, pair: interval.relative_uncertainty,
    "log_ratio": _of_logarithm,
}


@dataclass(frozen=True)
class Answers:
    """The stored `responses` of one case by label; `asked` are all labels that are to answer."""

    study: Study
    case: Case
    asked: tuple[str, ...]
    responses: Mapping[str, Response]

    def ok(self, label: str) -> Response | None:
        """The response of a label, if it answered."""
        response = self.responses.get(label)
        if response is None or outcome_of(response) is not Outcome.OK:
            return None
        return response

    def why_not(self, label: str) -> str:
        """Why there is no answer of a label."""
        response = self.responses.get(label)
        if response is None:
            return f"{label} has not been run"
        return f"{label}: {outcome_of(response)}, {response.attrs['message']}"

    def levels(self) -> list[str]:
        """Labels of the ladder that answered, coarse to fine, without a gap up to the finest."""
        levels: list[str] = []
        for label in reversed(self.study.ladder):
            if self.ok(label) is None:
                break
            levels.insert(0, label)
        return levels


@dataclass(frozen=True)
class Comparison:
    """A metric between two answers.

    `value` of the metric, `uncertainty` of it (None: unknown), and a `note` on that; for scalar
    quantities also both numbers that were compared, in SI.
    """

    value: float
    uncertainty: float | None
    note: str
    model_value: float | None = None
    against_value: float | None = None


def quantity_ladder(answers: Answers, quantity: str) -> Ladder | None:
    """The ladder of a scalar quantity of the reference; None if fewer than two levels have it."""
    values: list[float] = []
    for label in reversed(answers.levels()):
        response = answers.ok(label)
        if response is None or quantity not in response:
            break
        values.insert(0, float(response[quantity]))
    return ladder(values) if len(values) > 1 else None


def compare(
    answers: Answers, model: str, against: str, quantity: str, metric: Metric
) -> Comparison:
    """A metric between two labels of a case, with its uncertainty.

    Raises `InputError` where the metric does not exist, for instance for an absent quantity.
    """
    for label in (model, against):
        if answers.ok(label) is None:
            raise InputError("answer", answers.case.name, answers.why_not(label))
    response, reference = answers.responses[model], answers.responses[against]
    value = metric(response, reference, quantity)
    if metric.scope is not Scope.SCALAR:
        uncertainty, note = _by_metric(answers, model, against, quantity, metric)
        return Comparison(value, uncertainty, note)
    pair = float(response[quantity]), float(reference[quantity])
    own, note = _of_side(answers, model, quantity)
    other, other_note = _of_side(answers, against, quantity)
    notes = "; ".join(dict.fromkeys(text for text in (note, other_note) if text)) or _EXACT
    interval = expand(*pair, simulation_uncertainty=own, data_uncertainty=other)
    return Comparison(value, _SPREAD[metric.name](interval, pair), notes, *pair)


def comparison_rows(answers: Answers) -> Iterator[Row]:
    """Rows of every label of a case against the reference, the data and what gates ask for."""
    study = answers.study
    data = [label for label, r in answers.responses.items() if "data_uncertainty" in r.attrs]
    asked = [gate.against for gate in study.gates]
    for against in dict.fromkeys([study.reference, *data, *asked]):
        for model in answers.responses:
            if model == against or (model in data and against in data):
                continue
            for quantity, metric in _pairs(study, answers.case):
                try:
                    found = compare(answers, model, against, quantity, metric)
                except InputError:
                    continue  # one side cannot know the quantity: nothing to compare
                yield {
                    "case": answers.case.name,
                    **answers.case.parameters,
                    "model": model,
                    "against": against,
                    "quantity": quantity,
                    "metric": metric.name,
                    "value": found.model_value,
                    "against_value": found.against_value,
                    "error": found.value,
                    "uncertainty": found.uncertainty,
                    "note": found.note,
                }


def ladder_row(answers: Answers, quantity: str) -> Row | None:
    """The row of the ladder table; None if the case has no ladder."""
    present = [label for label in answers.study.ladder if label in answers.responses]
    pushover = answers.case.scenario.KIND.endswith("pushover")  # has no peak in time
    if len(present) < 2 or (
        pushover and not any(quantity in answers.responses[p] for p in present)
    ):
        return None
    row: dict[str, object] = {"case": answers.case.name, "quantity": quantity}
    for label in present:
        response = answers.ok(label)
        if response is not None and quantity in response:
            row[label] = float(response[quantity])
    found = quantity_ladder(answers, quantity)
    if found is None:
        failed = [answers.why_not(label) for label in present if answers.ok(label) is None]
        missing = [label for label in present if label not in row]
        row["note"] = "; ".join(failed) or f"{quantity} is absent in {', '.join(missing)}"
        return row
    return {
        **row,
        "order": found.order,
        "extrapolated": found.extrapolated,
        "uncertainty": found.uncertainty,
        "relative": found.relative,
        "converging": found.converging,
        "accepted": found.accepted,
        "note": found.note,
    }


def gate_row(answers: Answers, gate: Gate) -> Row | None:
    """The row of a gate for a case; None if the case does not concern it.

    A gate without named cases leaves out those that one of its sides refuses (out-of-domain)
    or is not asked; every other missing answer makes it inconclusive, never silently smaller.
    """
    if gate.cases and answers.case.name not in gate.cases:
        return None
    for label in (gate.model, gate.against):
        response = answers.responses.get(label)
        refused = response is not None and outcome_of(response) is Outcome.OUT_OF_DOMAIN
        if not gate.cases and (label not in answers.asked or refused):
            return None
    row = {**gate_columns(gate), "case": answers.case.name}
    try:
        found = compare(answers, gate.model, gate.against, gate.quantity, METRICS[gate.metric])
    except InputError as error:
        text = error.allowed if error.field == "answer" else str(error)
        return {**row, "verdict": "inconclusive", "note": text}
    verdict = judge(found.value, found.uncertainty, gate.bound)
    return {
        **row,
        "value": found.value,
        "uncertainty": found.uncertainty,
        "verdict": verdict.value,
        "note": found.note,
    }


def gate_columns(gate: Gate) -> dict[str, object]:
    """What every row of a gate says."""
    return {
        "gate": gate.name,
        "model": gate.model,
        "against": gate.against,
        "quantity": gate.quantity,
        "metric": gate.metric,
        "bound": gate.bound,
        "rationale": gate.rationale,
        "source": gate.source,
    }


def check_metrics(study: Study) -> None:
    """Hold the gates to metrics that exist. Raises `InputError`."""
    for gate in study.gates:
        if gate.metric not in METRICS:
            raise InputError("gate.metric", gate.metric, "must be one of " + ", ".join(METRICS))
        if METRICS[gate.metric].scope is Scope.SCALAR and gate.metric not in _SPREAD:
            raise InputError("gate.metric", gate.metric, "has no rule for its uncertainty")


def _pairs(study: Study, case: Case) -> Iterator[tuple[str, Metric]]:
    for quantity in study.quantities:
        yield quantity, METRICS["relative_error"]
    pushover = case.scenario.KIND.endswith("pushover")
    quantity, scope = ("force", Scope.CURVE) if pushover else ("displacement", Scope.HISTORY)
    for metric in METRICS.values():
        if metric.scope is scope:
            yield quantity, metric


def _of_side(answers: Answers, label: str, quantity: str) -> tuple[float | None, str]:
    """Uncertainty of a scalar of one side, with a note on where it comes from."""
    response = answers.responses[label]
    if label == answers.study.reference:
        found = quantity_ladder(answers, quantity)
        if found is not None:
            return found.uncertainty, f"ladder of {label}: {found.note}"
        if "numerical_uncertainty" not in response.attrs:
            return None, f"{label} has no refinement ladder in this case: uncertainty unknown"
    if "data_uncertainty" in response.attrs:
        widths = json.loads(response.attrs["data_uncertainty"])
        if quantity not in widths:
            return None, f"{label} states no uncertainty of {quantity}"
        return float(widths[quantity]), f"{label}: uncertainty of the data"
    if "numerical_uncertainty" in response.attrs:
        width = json.loads(response.attrs["numerical_uncertainty"]).get(quantity)
        if width is None:
            return None, f"{label} could not establish its numerical uncertainty of {quantity}"
        return float(width), f"{label}: refinement of its own"
    return 0.0, ""


def _by_metric(
    answers: Answers, model: str, against: str, quantity: str, metric: Metric
) -> tuple[float | None, str]:
    """Uncertainty of a metric from its values at every level of the reference's ladder."""
    reference = answers.study.reference
    if reference not in (model, against):
        return 0.0, _EXACT
    values = []
    for level in answers.levels():
        response = answers.responses[level if model == reference else model]
        held_against = answers.responses[level if against == reference else against]
        try:
            values.append(metric(response, held_against, quantity))
        except InputError:
            values.clear()
    if len(values) < 2:
        return None, f"{reference} has no refinement ladder in this case: uncertainty unknown"
    found = ladder(values)
    return found.uncertainty, f"ladder of the metric over {reference}: {found.note}"
