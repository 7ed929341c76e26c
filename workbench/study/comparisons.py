"""Comparing the answers of one case, with the numerical uncertainty that goes with each number.

The uncertainty of a side is that of its own coarser runs, if it made some. Otherwise the reference
of the study has that of its ladder of labels (unknown without one), published or measured numbers
the half-width stated with them, a sample of tests that of its interval. Any other side, a reduced
model, counts as exact: its discretisation is part of what is judged; a note says where no side has
an uncertainty of its own.

For scalar quantities the two sides combine as ASME V&V 20 does. Metrics of histories and curves
are evaluated with every run of a side; these values give their interval by the same rules.
Metrics of a response alone are numbers about the run: they have no interval.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass

from workbench.assessment import METRICS, Metric, Scope
from workbench.errors import InputError
from workbench.responses import Response
from workbench.responses.uncertainty import BASIS, directions_of, uncertainty_of
from workbench.study.definition import Case, Study
from workbench.study.sides import Answers, by_metric, joined, of_side, own_note, quantity_ladder
from workbench.study.store import Row

LADDER_COLUMNS = (
    *("order", "extrapolated", "uncertainty", "relative", "converging", "accepted", "note"),
)
_OF_THE_RUN = "a number about the run itself"


@dataclass(frozen=True)
class Comparison:
    """A metric between two answers.

    `error` is the value of the metric, with its `uncertainty` (None: unknown) and a `note` on that;
    for scalar quantities also both numbers that were compared, in SI.
    """

    error: float
    uncertainty: float | None
    note: str
    value: float | None = None
    against_value: float | None = None


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
    if metric.scope is Scope.RUN:
        return Comparison(value, 0.0, _OF_THE_RUN)
    if metric.spread is None:
        return Comparison(value, *by_metric(answers, model, against, quantity, metric))
    pair = float(response[quantity]), float(reference[quantity])
    own, note = of_side(answers, model, quantity)
    other, other_note = of_side(answers, against, quantity)
    notes = joined(note, other_note)
    return Comparison(value, metric.half_width(*pair, own, other), notes, *pair)


def comparison_rows(answers: Answers) -> Iterator[Row]:
    """Rows of every label of a case against the reference, the data and what gates ask for."""
    study = answers.study
    data = [label for label, r in answers.responses.items() if "data_uncertainty" in r.attrs]
    asked = [gate.against for gate in study.gates if gate.against != gate.model]
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
                    **asdict(found),
                }


def ladder_row(answers: Answers, quantity: str) -> Row | None:
    """The row of the ladder table; None if the case has no ladder.

    The meshes that stand behind the reference's own answer come first; a study may instead give
    labels.
    """
    finest = answers.ok(answers.study.reference)
    if finest is not None and directions_of(finest):
        return _own_ladder(answers.case, finest, quantity)
    present = [label for label in answers.study.ladder if label in answers.responses]
    static = answers.case.scenario.STATIC  # has no peak in time
    if len(present) < 2 or (static and not any(quantity in answers.responses[p] for p in present)):
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
    return {**row, **{name: getattr(found, name) for name in LADDER_COLUMNS}}


def _own_ladder(case: Case, response: Response, quantity: str) -> Row | None:
    """The row of the ladder table from the runs behind a response; None without the quantity."""
    table = json.loads(response.attrs[BASIS])["quantities"].get(quantity)
    if table is None:
        return None
    width = uncertainty_of(response, quantity)
    value = float(response[quantity])
    return {
        "case": case.name,
        "quantity": quantity,
        **table["values"],
        **{name: table.get(name) for name in LADDER_COLUMNS},
        "uncertainty": width,
        "relative": None if width is None or value == 0.0 else width / abs(value),
        "note": own_note(response, quantity),
    }


def _pairs(study: Study, case: Case) -> Iterator[tuple[str, Metric]]:
    for quantity in study.quantities:
        yield quantity, METRICS["relative_error"]
    static = case.scenario.STATIC
    quantity, scope = ("force", Scope.CURVE) if static else ("displacement", Scope.HISTORY)
    for metric in METRICS.values():
        if metric.scope is scope:
            yield quantity, metric
