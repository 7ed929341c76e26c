"""Advice on an answer: the error to expect of it, and the model to take where that is warned of.

One order for all scenarios: the anchor of the error model, then the references. A model is named
only where it is inside its own domain, and only above the model that warns, so that no advice goes
in a circle. Where the error was measured it stands in place of what a domain says about physics.
"""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from workbench.base.errors import InputError, OutOfDomainError, WorkbenchError
from workbench.mechanics.frames.members import SPREAD
from workbench.mechanics.frames.runs import LARGEST_SHEAR_STRAIN
from workbench.models.base import Model, findings_before
from workbench.models.registry import make_model
from workbench.models.resistance import column_curve
from workbench.models.strain_rate import with_strain_rate
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    finding,
    findings_of,
    outcome_of,
    refusal_message,
    set_findings,
    survives,
)
from workbench.scenarios import ColumnImpact
from workbench.study.error_model.descriptors import DEMAND, features
from workbench.study.error_model.error_model import ExpectedError, anchor_error, expected_error
from workbench.study.error_model.error_table import ANCHOR, FINEST, REFERENCE, table_of

ORDER = (ANCHOR, REFERENCE, FINEST)
REMAINING = ("residual_displacement", "displacement", "peak_displacement")
CLOSE, UNMEASURED = "close-to-collapse", "error-not-measured"  # subjects
NONE = "no model of more trust is inside its domain here"
_BECAUSE = {  # subjects of warnings that a measured error replaces, as its cause
    "buckling": "the axial load bends what is deflected",
    "shear": "webs yield in shear",
    "stub": "a segment is hardly longer than its section is high",
    "plates": "the strength given is not that of the plates",
    "small-rotations": "bars turn far",
    "simplification": "the resistance is simplified",
    "striker": "the striker is soft here",
    "hard-impact": "the structure is soft here",
    "catenary": "members are pulled",
    "short-pulse": "the pulse is much shorter than the period",
    "interaction": "members are pressed",
    "light-striker": "the striker is light",
    "hit-mass": "elements share much mass with the striker",
    "near-collapse": "the frame nearly falls",
    "ends": "ends of the column move",
    "sway": "ends of the column sway",
    "fall": "the frame may fall",
    "dead-moments": "dead loads bend the column",
    "restraint": "the frame gives way to the spring",
    "direct-shear": "webs yield in direct shear",
}


def is_judged(model: Model) -> bool:
    """Whether the error of a model is told by the anchor.

    A reference says ``judged: ClassVar[bool] = False``, and so does what holds numbers of tests,
    or a striker of its own: their warnings are all that is said of them.
    """
    return bool(getattr(model, "judged", True))


def advise(model: Model, scenario: Any, response: Response | None = None) -> list[Finding]:
    """Findings about a model in a scenario, each with the model to take instead.

    Those of its domain before it answers, of the anchor also of its error; with a `response` those
    of that, and of its error.
    """
    if response is None:
        findings = _beforehand(model, scenario)
        if model.name == ANCHOR and table_of(scenario) is not None:
            findings = judged(model, scenario, anchor_error(scenario), findings)
        return with_remedies(model, scenario, findings)
    return _advised(model, scenario, response)[0]


def advised(model: Model, scenario: Any, response: Response) -> Response:
    """Put advice and the error to expect (JSON) on a response, and return it."""
    findings, error = _advised(model, scenario, response)
    set_findings(response, findings)
    response.attrs["error"] = json.dumps(error.as_dict())
    if any(each.refusal for each in findings):
        response.attrs["message"] = refusal_message(findings)
    return response


def _advised(
    model: Model, scenario: Any, response: Response
) -> tuple[list[Finding], ExpectedError]:
    findings = findings_of(response)
    error = ExpectedError(ANCHOR, reason=f"{model.name} is not judged by the anchor")
    if is_judged(model) or model.name == REFERENCE:
        error = expected_error(scenario, response)
    if survives(response) is not None:
        findings = judged(model, scenario, error, findings)
    findings = [*findings, *creeping(scenario, response)]
    return with_remedies(model, scenario, findings), error


def judged(
    model: Model, scenario: Any, error: ExpectedError, findings: Iterable[Finding]
) -> list[Finding]:
    """Findings about an answer, its `error` in place of those that it replaces.

    Models that are not judged keep all of theirs.
    """
    kept = list(findings)
    if not is_judged(model) or table_of(scenario) is None:
        return kept
    if error.chance is None:
        return [*kept, finding(UNMEASURED, reason=error.reason)]
    replaced = [each for each in kept if not each.refusal and each.subject in _BECAUSE]
    causes = dict.fromkeys(_BECAUSE[each.subject] for each in replaced)
    return [*(each for each in kept if each not in replaced), *_about(error, ", ".join(causes))]


def _about(error: ExpectedError, causes: str) -> Iterator[Finding]:
    """Warnings of an error, and the `causes` that the domain of the model names."""
    if error.warns:
        parts = ("at-least",) * (error.near_collapse) + ("because",) * bool(causes)
        chance = 100.0 * (error.chance or 0.0)
        name = "error" if error.high is not None else "error-of-collapse"
        yield finding(name, error.chance, parts=parts, error=error, causes=causes, chance=chance)
    if error.near_collapse:
        yield finding(CLOSE, anchor=error.anchor)


def with_remedies(model: Any, scenario: Any, findings: Iterable[Finding]) -> list[Finding]:
    """The findings of a model, those that another model mends with the name of that."""
    completed = []
    for each in findings:
        if each.instead is not None:
            names = better(model.name, scenario)
            each = replace(each, remedy=NONE, instead=names)
            each = each.taking(names) if names else each
            if FINEST in names:
                each = replace(each, remedy=f"{each.remedy}, which takes minutes")
        completed.append(each)
    return completed


@dataclass(frozen=True, slots=True)
class Choice:
    """The model to take for a scenario, `because`, and of the anchor the `error` to expect.

    `reason` says both.
    """

    model: str
    because: str
    error: ExpectedError
    measured: bool = True

    @property
    def reason(self) -> str:
        """Why it is taken, with the error where that was measured for such scenarios."""
        of = "" if self.model == ANCHOR else f"{ANCHOR}: "
        return f"{self.because}: {of}{self.error}" if self.measured else self.because


def choose(scenario: Any) -> Choice:
    """The anchor, where it is warned of the beam that judges; the anchor too if no model will do.

    The solid takes minutes: it is a remedy, no choice.
    """
    error = anchor_error(scenario)
    model, because = ANCHOR, "which comes nearest: no quick model is inside its domain"
    if is_inside(ANCHOR, scenario):
        because = "the anchor of the error model"
    elif is_inside(REFERENCE, scenario):
        model, because = REFERENCE, f"a reference, as {ANCHOR} is warned of here"
    return Choice(model, because, error, table_of(scenario) is not None)


def quick_reference(scenario: Any) -> str:
    """The quickest reference that is inside its domain; empty without one.

    The solid takes minutes, and is none.
    """
    return REFERENCE if is_inside(REFERENCE, scenario) else ""


def better(name: str, scenario: Any) -> tuple[str, ...]:
    """The first model above this one in the order that is inside its domain; empty without."""
    above = ORDER[ORDER.index(name) + 1 :] if name in ORDER else ORDER
    return next(((each,) for each in above if is_inside(each, scenario)), ())


def no_reference(scenario: Any) -> str:
    """Why `quick_reference` names none, in one sentence."""
    return f"no reference inside its domain: {REFERENCE} ({'; '.join(doubts(REFERENCE, scenario))})"


def is_inside(name: str, scenario: Any) -> bool:
    """Whether an installed model answers a scenario inside its domain, and is not warned of."""
    return not doubts(name, scenario)


@lru_cache(maxsize=256)
def doubts(name: str, scenario: Any) -> tuple[str, ...]:
    """Why a model is not inside its domain in a scenario; empty where it is."""
    model = _default_model(name)
    if model is None:
        return ("it is not installed",)
    if scenario.KIND not in model.answers:
        return (f"it does not answer {scenario.KIND}",)
    try:
        findings = _beforehand(model, scenario)
        if name == ANCHOR and table_of(scenario) is not None:
            error = anchor_error(scenario)
            if error.chance is None:
                return (error.reason,)
            findings = judged(model, scenario, error, findings)
    except WorkbenchError as refused:  # it would refuse as it answers
        return (str(refused),)
    return tuple(each.text for each in findings if each.outside or each.refusal)


def _beforehand(model: Model, scenario: Any) -> list[Finding]:
    """Findings known before a model answers, and whether the reference would shear too far.

    A striker that crushes takes the energy that would do it. Of a push also whether the anchor
    leaves out much yielding between hinges.
    """
    findings = findings_before(model, scenario, with_strain_rate(model, scenario)[2])
    if model.name == ANCHOR and scenario.STATIC:
        findings += _spread(scenario)
    if (
        model.name != REFERENCE
        or not isinstance(scenario, ColumnImpact)
        or scenario.striker.crushes
    ):
        return findings
    hit, largest = features(scenario), LARGEST_SHEAR_STRAIN
    if hit[DEMAND] > 1.0 and hit["turned"] > largest:
        findings.append(finding("shears-far", hit["turned"], largest=largest))
    return findings


@lru_cache(maxsize=64)
def _spread(scenario: Any) -> tuple[Finding, ...]:
    """Findings on yielding between hinges, by a run of the anchor."""
    response = make_model(ANCHOR).simulate(scenario)
    return tuple(each for each in findings_of(response) if each.subject == SPREAD)


@lru_cache(maxsize=len(ORDER))
def _default_model(name: str) -> Model | None:
    """The installed model of this name with default options; looking it up takes milliseconds."""
    try:
        return make_model(name)
    except InputError:
        return None


def creeping(scenario: object, response: Response) -> list[Finding]:
    """Return the finding of a column that stays where its static strength carries no axial load.

    Overstress holds a column up only as long as it moves: behind the displacement (m) at which its
    analytic resistance with the static yield stress is lost it creeps on, slowly at first, beyond
    the end of a record. Compared is the displacement that remains, or, where that is not known, the
    last one or the peak.
    """
    if not isinstance(scenario, ColumnImpact) or outcome_of(response) is not Outcome.OK:
        return []
    column = scenario.column
    if column.steel.rate is None or column.axial_load == 0.0:
        return []
    known = (name for name in REMAINING if name in response)
    remaining = float(response[next(known)].values.reshape(-1)[-1])
    static = replace(column, steel=replace(column.steel, rate=None))
    try:
        limit = column_curve(static, None, "analytic").lost_at
    except OutOfDomainError:
        return []
    return [finding("creep", remaining, limit=limit)] if remaining > limit else []
