"""The stored answers of a case, and how well one side of a comparison between them is known."""

import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import hypot
from typing import Any

from workbench.assessment import Ladder, Metric, ladder
from workbench.errors import InputError
from workbench.responses import Outcome, Response, findings_of, outcome_of
from workbench.responses.uncertainty import (
    BASIS,
    CURVES,
    WIDTHS,
    directions_of,
    estimate,
    uncertainty_of,
    variants,
)
from workbench.study.definition import Case, Study

_EXACT = "no side has an estimate of its own numerical error; counted as zero"

Known = tuple[float | None, str]  # half-width (None: unknown) and a note on where it comes from


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
        if label not in self.asked:
            return f"the study does not ask {label}"
        if response is None:
            return f"{label} has not been run"
        refusals = [finding.text for finding in findings_of(response) if finding.refusal]
        said = refusals[0] if refusals else response.attrs["message"]
        return f"{label}: {outcome_of(response)}, {said}"

    def levels(self) -> list[str]:
        """Labels of the ladder that answered, coarse to fine, without a gap up to the finest."""
        levels: list[str] = []
        for label in reversed(self.study.ladder):
            if self.ok(label) is None:
                break
            levels.insert(0, label)
        return levels


def quantity_ladder(answers: Answers, quantity: str) -> Ladder | None:
    """The ladder of a scalar quantity of the reference; None if fewer than two levels have it."""
    values: list[float] = []
    for label in reversed(answers.levels()):
        response = answers.ok(label)
        if response is None or quantity not in response:
            break
        values.insert(0, float(response[quantity]))
    return ladder(values) if len(values) > 1 else None


def of_side(answers: Answers, label: str, quantity: str) -> Known:
    """Half-width of a scalar of one side."""
    response = answers.responses[label]
    if _refined(response):
        return uncertainty_of(response, quantity), f"{label}: {own_note(response, quantity)}"
    if label == answers.study.reference:
        found = quantity_ladder(answers, quantity)
        if found is not None:
            return found.uncertainty, f"ladder of {label}: {found.note}"
        if "data_uncertainty" not in response.attrs:
            return None, _no_ladder(label)
    if "sampling_uncertainty" in response.attrs:
        width = json.loads(response.attrs["sampling_uncertainty"]).get(quantity)
        if width is None:
            return None, f"{label}: one test has no interval"
        return float(width), f"{label}: interval over the tests judged"
    if "data_uncertainty" in response.attrs:
        widths = json.loads(response.attrs["data_uncertainty"])
        if quantity not in widths:
            return None, f"{label} states no uncertainty of {quantity}"
        return float(widths[quantity]), f"{label}: uncertainty of the data"
    if WIDTHS in response.attrs:
        return None, f"{label}: {own_note(response, quantity)}"
    return 0.0, ""


def by_metric(answers: Answers, model: str, against: str, quantity: str, metric: Metric) -> Known:
    """Half-width of a metric of histories or curves, from its values with every run of a side."""
    response, reference = answers.responses[model], answers.responses[against]
    own, note = _spread(answers, model, quantity, lambda run: metric(run, reference, quantity))
    other, other_note = _spread(
        answers, against, quantity, lambda run: metric(response, run, quantity)
    )
    width = None if own is None or other is None else hypot(own, other)
    return width, joined(note, other_note)


def joined(*notes: str) -> str:
    """Notes of both sides in one."""
    return "; ".join(dict.fromkeys(text for text in notes if text)) or _EXACT


def own_note(response: Response, quantity: str) -> str:
    """What a response says of its own numerical uncertainty of a quantity."""
    basis = json.loads(response.attrs[BASIS])
    known = basis["quantities"].get(quantity)
    if known is None:
        return f"its numerical uncertainty of {quantity} was not asked for"
    if uncertainty_of(response, quantity) is None:
        return _said(basis) or known["note"]
    return f"refinement of its own, {known['note']}"


def _spread(
    answers: Answers, label: str, quantity: str, evaluate: Callable[[Response], float]
) -> Known:
    """Half-width of a metric that one side gives, from its values over the runs of that side."""
    response, what = answers.responses[label], f"the metric over {label}"
    if _refined(response):
        if CURVES.get(quantity) not in response:
            return None, f"{label} keeps no {quantity} of its coarser runs: uncertainty unknown"
        directions = directions_of(response)
        if not directions:
            return None, f"{label}: {_said(json.loads(response.attrs[BASIS]))}"
        values = _values(dict(variants(response)), evaluate)
        found = estimate(directions, values)
        return found.width, f"refinement of {what}: {found.note}"
    if label == answers.study.reference:
        levels = _values({name: answers.responses[name] for name in answers.levels()}, evaluate)
        if len(levels) < 2 or len(levels) < len(answers.levels()):
            return None, _no_ladder(label)
        ladder_found = ladder(list(levels.values()))
        return ladder_found.uncertainty, f"ladder of {what}: {ladder_found.note}"
    if WIDTHS in response.attrs:
        return None, f"{label}: one mesh only, numerical uncertainty unknown"
    return 0.0, ""


def _values(
    runs: Mapping[str, Response], evaluate: Callable[[Response], float]
) -> dict[str, float]:
    values = {}
    for name, run in runs.items():
        with suppress(InputError):  # a run that does not know the quantity leaves a gap
            values[name] = evaluate(run)
    return values


def _refined(response: Response) -> bool:
    """Whether a response tried coarser meshes of its own."""
    return len(json.loads(response.attrs.get(BASIS, "{}")).get("levels", ())) > 1


def _said(basis: Mapping[str, Any]) -> str:
    """The statements of a refinement in one line, without those that another one repeats."""
    said = list(dict.fromkeys(basis["statements"]))
    return "; ".join(text for text in said if not any(text != o and text in o for o in said))


def _no_ladder(label: str) -> str:
    return f"{label} has no refinement ladder in this case: uncertainty unknown"
