"""Which reference counts in a case: the best that answered and is inside its own domain."""

from dataclasses import replace
from typing import NamedTuple

from workbench.assessment import METRICS
from workbench.assessment.budget import PEAK
from workbench.assessment.gates import CaseVerdict, Gate, Verdict, judge
from workbench.errors import InputError
from workbench.responses import Finding, Response, findings_of, is_synthetic
from workbench.study.comparisons import Answers, compare, of_side
from workbench.study.tables import Row, counts, numbers, texts

REFERENCE_COLUMNS = (
    texts("case", "label")
    | counts("inside", "synthetic")
    | numbers("uncertainty")
    | texts("reason")
)
FORM = "synthetic, shows the form only,"
BOTH = "within the bound, but both sides are outside their domain,"


def outside(response: Response) -> list[Finding]:
    """What an answer says of itself about being outside the domain of its model."""
    return [finding for finding in findings_of(response) if finding.outside]


class Standing(NamedTuple):
    """The reference that counts in a case: its `label`, and whether it is `inside` its domain.

    `reason` says why no better one counts (empty: it is the best of the study).
    """

    label: str
    inside: bool
    reason: str


def standing_of(answers: Answers) -> Standing | None:
    """The reference that counts in a case, None if none answered."""
    reasons: list[str] = []
    best_outside = None
    for label in answers.study.ranked:
        if answers.ok(label) is None and answers.collapse(label) is None:
            reasons.append(answers.why_not(label))
            continue
        findings = outside(answers.responses[label])
        if not findings:
            return Standing(label, True, "; ".join(reasons))
        none_inside = "; ".join([*reasons, "no reference is inside its domain"])
        best_outside = best_outside or Standing(label, False, none_inside)
        subjects = ", ".join(dict.fromkeys(finding.subject for finding in findings))
        reasons.append(f"{label} is outside its domain ({subjects})")
    return best_outside


def reference_row(answers: Answers) -> Row:
    """The row of a case in the table of references, with the relative uncertainty of the peak."""
    row: dict[str, object] = {"case": answers.case.name}
    found = standing_of(answers)
    if found is None:
        return {**row, "reason": "no reference answered"}
    row |= {"label": found.label, "inside": int(found.inside), "reason": found.reason}
    response = answers.responses[found.label]
    row["synthetic"] = int(is_synthetic(response))
    if PEAK in response:
        width, value = of_side(answers, found.label, PEAK)[0], float(response[PEAK])
        row["uncertainty"] = None if width is None or value == 0.0 else width / abs(value)
    return row


def doubted(gate: Gate, answers: Answers, found: CaseVerdict) -> CaseVerdict:
    """The verdict of a case, inconclusive where it says nothing about the structure.

    Made numbers neither pass nor fail a model. A pass says nothing where both sides are outside
    their domain, or what the model is held against is and a better reference does not confirm it.
    """
    if any(is_synthetic(answers.responses[label]) for label in (gate.model, gate.against)):
        return replace(found, verdict=Verdict.INCONCLUSIVE, doubt=FORM)
    if found.verdict is not Verdict.PASS or gate.model == gate.against:
        return found
    model, against = (outside(answers.responses[label]) for label in (gate.model, gate.against))
    if not against:
        return found
    if model:
        return replace(found, verdict=Verdict.INCONCLUSIVE, doubt=BOTH)
    best = standing_of(answers)
    sides = (gate.model, gate.against)
    if best is None or best.label in sides or _confirmed(gate, answers, best.label):
        return found
    doubt = f"{gate.against} is outside its domain and {best.label} does not confirm it"
    return replace(found, verdict=Verdict.INCONCLUSIVE, doubt=doubt)


def _confirmed(gate: Gate, answers: Answers, best: str) -> bool:
    """Whether a better reference would let the model pass too, or does not know the quantity."""
    fallen = [answers.collapse(label) is not None for label in (gate.model, best)]
    if any(fallen):
        return all(fallen)
    try:
        other = compare(answers, gate.model, best, gate.quantity, METRICS[gate.metric])
    except InputError:
        return True
    return judge(other.error, other.uncertainty, gate.bound, other.low, other.high) is Verdict.PASS
