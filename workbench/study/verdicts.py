"""The verdicts of a study's gates over all cases that are asked, and their tables.

The rule itself stands in `assessment/gates`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict

from workbench.assessment import METRICS, CaseVerdict, Gate, GateVerdict, Verdict, judge
from workbench.errors import InputError
from workbench.responses import Outcome, outcome_of
from workbench.study.comparisons import compare
from workbench.study.definition import Study
from workbench.study.files import Row
from workbench.study.sides import Answers

_GATE = ("number", "gate", "model", "against", "quantity", "metric")
CASE_COLUMNS = (*_GATE, "case", "value", "uncertainty", "bound", "verdict", "note")
COLUMNS = (
    *(*_GATE, "verdict", "asked", *(verdict.value for verdict in Verdict)),
    *("case", "value", "uncertainty", "bound", "reasons", "rationale", "source"),
)


def verdicts_of(study: Study, answers: Sequence[Answers]) -> tuple[GateVerdict, ...]:
    """The verdict of every gate, from the answers of all cases of the study."""
    return tuple(
        GateVerdict(
            number, gate, tuple(_judged(gate, each) for each in answers if _asks(gate, each))
        )
        for number, gate in enumerate(study.gates, 1)
    )


def _asks(gate: Gate, answers: Answers) -> bool:
    """Whether a case concerns a gate: it is named, or the study asks it of both labels."""
    if gate.cases:
        return answers.case.name in gate.cases
    return {gate.model, gate.against} <= set(answers.asked)


def _judged(gate: Gate, answers: Answers) -> CaseVerdict:
    name = answers.case.name
    for label in (gate.model, gate.against):
        if answers.ok(label) is None:
            response = answers.responses.get(label)
            refused = response is not None and outcome_of(response) is Outcome.OUT_OF_DOMAIN
            verdict = Verdict.REFUSED if refused else Verdict.UNANSWERED
            return CaseVerdict(name, verdict, None, None, answers.why_not(label))
    try:
        found = compare(answers, gate.model, gate.against, gate.quantity, METRICS[gate.metric])
    except InputError as error:
        return CaseVerdict(name, Verdict.INCONCLUSIVE, None, None, str(error))
    verdict = judge(found.error, found.uncertainty, gate.bound)
    return CaseVerdict(name, verdict, found.error, found.uncertainty, found.note)


def verdict_row(found: GateVerdict) -> Row:
    """The row of a gate in the table of verdicts."""
    top = found.critical
    return {
        **_columns(found),
        "verdict": found.verdict.value,
        **found.counts,
        "case": None if top is None else top.case,
        "value": None if top is None else top.value,
        "uncertainty": None if top is None else top.uncertainty,
        "reasons": list(found.reasons),
    }


def case_rows(found: GateVerdict) -> Iterator[Row]:
    """The rows of a gate in the table of all its cases."""
    for case in found.cases:
        yield {**_columns(found), **asdict(case)}


def _columns(found: GateVerdict) -> dict[str, object]:
    return {"number": found.number, "gate": found.gate.name, **asdict(found.gate)}
