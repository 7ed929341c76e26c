"""The governing reference of a case, and the verdicts of gates.

The best reference that answered and is inside its own domain governs a case. The verdict of a gate
counts all cases that are asked; the rule itself stands in `assessment/gates`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import NamedTuple

from workbench.base.errors import InputError
from workbench.responses import (
    PEAK,
    Finding,
    Outcome,
    Response,
    findings_of,
    is_synthetic,
    outcome_of,
    survives,
)
from workbench.study.assessment import METRICS
from workbench.study.assessment.gates import CaseVerdict, Gate, GateVerdict, Verdict, judge
from workbench.study.comparisons import CaseAnswers, compare, of_side
from workbench.study.definition import Study
from workbench.study.tables import Row, counts, lists, numbers, tabled, texts

REFERENCE_COLUMNS = (
    texts("case", "label")
    | counts("inside", "synthetic")
    | numbers("uncertainty")
    | texts("reason")
)
_GATE = counts("number") | texts("gate", "model", "against", "quantity", "metric")
_JUDGED = (
    texts("case")
    | numbers("value", "uncertainty", "low", "high")
    | lists("collapsed")
    | numbers("bound")
)
GATE_COLUMNS = _GATE | _JUDGED | texts("verdict", "note", "doubt")
VERDICT_COLUMNS = (
    _GATE
    | texts("verdict")
    | counts("asked", *(verdict.value for verdict in Verdict), "collapses")
    | _JUDGED
    | lists("reasons")
    | texts("rationale", "source")
)
FORM = "synthetic, shows the form only,"
BOTH = "within the bound, but both sides are outside their domain,"


def outside(response: Response) -> list[Finding]:
    """Findings of an answer that put it outside the domain of its model."""
    return [finding for finding in findings_of(response) if finding.outside]


class Governing(NamedTuple):
    """The governing reference of a case: its `label`, and whether it is `inside` its domain.

    `reason` says why no better one governs (empty: it is the best of the study).
    """

    label: str
    inside: bool
    reason: str


def governing_of(answers: CaseAnswers) -> Governing | None:
    """The governing reference of a case, None if none answered."""
    reasons: list[str] = []
    best_outside = None
    for label in answers.study.ranked:
        if answers.ok(label) is None and answers.collapse(label) is None:
            reasons.append(answers.why_not(label))
            continue
        findings = outside(answers.responses[label])
        if not findings:
            return Governing(label, True, "; ".join(reasons))
        none_inside = "; ".join([*reasons, "no reference is inside its domain"])
        best_outside = best_outside or Governing(label, False, none_inside)
        subjects = ", ".join(dict.fromkeys(finding.subject for finding in findings))
        reasons.append(f"{label} is outside its domain ({subjects})")
    return best_outside


def reference_row(answers: CaseAnswers) -> Row:
    """The row of a case in the table of references, with the relative uncertainty of the peak."""
    row: dict[str, object] = {"case": answers.case.name}
    governing = governing_of(answers)
    if governing is None:
        return {**row, "reason": "no reference answered"}
    row |= governing._asdict()
    response = answers.responses[governing.label]
    row["synthetic"] = is_synthetic(response)
    if PEAK in response:
        width, value = of_side(answers, governing.label, PEAK)[0], float(response[PEAK])
        row["uncertainty"] = None if width is None or value == 0.0 else width / abs(value)
    return row


def doubted(gate: Gate, answers: CaseAnswers, judged: CaseVerdict) -> CaseVerdict:
    """The verdict of a case, inconclusive where it says nothing about the structure.

    Made numbers neither pass nor fail a model. A pass says nothing where both sides are outside
    their domain, or what the model is held against is and a better reference does not confirm it.
    """
    if any(is_synthetic(answers.responses[label]) for label in (gate.model, gate.against)):
        return replace(judged, verdict=Verdict.INCONCLUSIVE, doubt=FORM)
    if judged.verdict is not Verdict.PASS or gate.model == gate.against:
        return judged
    model, against = (outside(answers.responses[label]) for label in (gate.model, gate.against))
    if not against:
        return judged
    if model:
        return replace(judged, verdict=Verdict.INCONCLUSIVE, doubt=BOTH)
    best = governing_of(answers)
    sides = (gate.model, gate.against)
    if best is None or best.label in sides or _confirmed(gate, answers, best.label):
        return judged
    doubt = f"{gate.against} is outside its domain and {best.label} does not confirm it"
    return replace(judged, verdict=Verdict.INCONCLUSIVE, doubt=doubt)


def _confirmed(gate: Gate, answers: CaseAnswers, best: str) -> bool:
    """Whether a better reference would let the model pass too, or does not know the quantity."""
    collapsed = [answers.collapse(label) is not None for label in (gate.model, best)]
    if any(collapsed):
        return all(collapsed)
    try:
        other = compare(answers, gate.model, best, gate.quantity, METRICS[gate.metric])
    except InputError:
        return True
    return judge(other.error, other.uncertainty, gate.bound, other.low, other.high) is Verdict.PASS


def verdicts_of(study: Study, answers: Sequence[CaseAnswers]) -> tuple[GateVerdict, ...]:
    """The verdict of every gate, from the answers of all cases of the study."""
    verdicts = []
    for number, gate in enumerate(study.gates, 1):
        both = {gate.model, gate.against}
        named = {*gate.cases} or {each.case.name for each in answers if both <= {*each.asked}}
        judged = (_judged(gate, each) for each in answers if each.case.name in named)
        verdicts.append(GateVerdict(number, gate, tuple(judged)))
    return tuple(verdicts)


def _judged(gate: Gate, answers: CaseAnswers) -> CaseVerdict:
    name = answers.case.name
    collapses = {label: answers.collapse(label) for label in (gate.model, gate.against)}
    for label, collapse in collapses.items():
        if answers.ok(label) is None and collapse is None:
            response = answers.responses.get(label)
            refused = response is not None and outcome_of(response) is Outcome.OUT_OF_DOMAIN
            verdict = Verdict.REFUSED if refused else Verdict.UNANSWERED
            return CaseVerdict(name, verdict, None, None, answers.why_not(label))
    collapsed = tuple(label for label, collapse in collapses.items() if collapse is not None)
    if collapsed:
        return doubted(gate, answers, _collapsed(gate, answers, collapsed))
    try:
        compared = compare(answers, gate.model, gate.against, gate.quantity, METRICS[gate.metric])
    except InputError as error:
        return CaseVerdict(name, Verdict.INCONCLUSIVE, None, None, str(error))
    value, width, low, high = compared.error, compared.uncertainty, compared.low, compared.high
    verdict = judge(value, width, gate.bound, low, high)
    judged = CaseVerdict(name, verdict, value, width, compared.note, low=low, high=high)
    return doubted(gate, answers, judged)


def _collapsed(gate: Gate, answers: CaseAnswers, collapsed: tuple[str, ...]) -> CaseVerdict:
    """The verdict of a case in which the structure of these labels collapses."""
    note = "; ".join(answers.why_not(label) for label in collapsed)
    verdict = Verdict.PASS
    if gate.model == gate.against:
        verdict, note = Verdict.INCONCLUSIVE, f"{note}: no number of the run"
    elif len(collapsed) == 1:
        (other,) = {gate.model, gate.against} - {*collapsed}
        survived = survives(answers.responses[other])
        verdict = Verdict.FAIL if survived else Verdict.INCONCLUSIVE
        ending = "survives" if survived else "ends before its peak and may still collapse"
        note += f"; {other} {ending}"
    return CaseVerdict(answers.case.name, verdict, None, None, note, collapsed)


@tabled(GATE_COLUMNS)
def gates(verdicts: Sequence[GateVerdict]) -> Iterator[Row]:
    """A row for every gate and case."""
    for gate in verdicts:
        yield from ({**_columns(gate), **asdict(case)} for case in gate.cases)


@tabled(VERDICT_COLUMNS)
def verdict_table(verdicts: Sequence[GateVerdict]) -> Iterator[Row]:
    """A row for every gate."""
    for judged in verdicts:
        critical = {} if judged.critical is None else asdict(judged.critical)
        yield {
            **_columns(judged),
            **{**critical, "collapsed": list(critical.get("collapsed", ()))},
            **{"verdict": judged.verdict.value, "reasons": list(judged.reasons)},
            **judged.counts,
        }


def _columns(judged: GateVerdict) -> dict[str, object]:
    return {"number": judged.number, "gate": judged.gate.name, **asdict(judged.gate)}
