"""Advice on a scenario: what was measured of a model, and which model to take where it warns.

Models stand in one order of trust. A remedy only goes up in it, so that no chain of remedies comes
back, and ends at a model that is inside its own domain here.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import Any

from workbench.errors import InputError, WorkbenchError
from workbench.evidence.descriptors import DEMAND, features
from workbench.evidence.measured import measured_findings
from workbench.frames.column_estimate import ON_FRAME
from workbench.frames.runs import LARGEST_SHEAR_STRAIN
from workbench.models.base import Model
from workbench.models.column_of_frame import ColumnOfFrame
from workbench.registry import make_model
from workbench.responses import (
    Finding,
    Response,
    findings_of,
    outcome_of,
    refusal_message,
    set_findings,
)
from workbench.scenarios import ColumnImpact

# From the least trusted on; all others stand before them. The first two are only taken by name.
ORDER = (
    *("energy-estimate", "soft-impact"),
    *("four-dof-shear", "plastic-hinge", "rigid-superelement", "flexible-superelement"),
    *("fiber-reissner", "fiber-shear", "solid-plane-stress"),
)
_NO_STRETCH = "fiber-shear"  # follows large shear deformation only so far, which its run reports
NONE = "no model of more trust is inside its domain here"


def findings_about(model: Any, scenario: Any) -> list[Finding]:
    """What is known about a model before it answers: its domain, and what studies measured."""
    return [*model.domain(scenario), *measured_findings(model, scenario)]


def advise(model: Model, scenario: Any, response: Response | None = None) -> list[Finding]:
    """Findings about a model in a scenario, each with the model to take instead.

    Those of its `response`, or of its domain before it answers, and what studies measured.
    """
    if response is None:
        findings = findings_about(model, scenario)
    else:
        findings = findings_of(response)
        if outcome_of(response).is_answer:
            findings += measured_findings(model, scenario, response)
    return with_remedies(model, scenario, findings)


def advised(model: Model, scenario: Any, response: Response) -> Response:
    """The same response, which now carries the advice on it."""
    findings = advise(model, scenario, response)
    set_findings(response, findings)
    if any(finding.refusal for finding in findings):
        response.attrs["message"] = refusal_message(findings)
    return response


def with_remedies(model: Any, scenario: Any, findings: Iterable[Finding]) -> list[Finding]:
    """The findings of a model, those that another model mends with the names of such models."""
    completed = []
    for finding in findings:
        if finding.instead is not None:
            first = ON_FRAME if isinstance(model, ColumnOfFrame) else finding.instead
            names = _better(model.name, scenario, tuple(first))
            finding = replace(finding, remedy=NONE, instead=names)
            finding = finding.taking(names) if names else finding
        completed.append(finding)
    return completed


def trusted(scenario: Any) -> str:
    """The first model of the order that is inside its domain here; the beam before the solid."""
    return next((n for n in _better("", scenario, ()) if n != ORDER[-1]), _NO_STRETCH)


def _better(name: str, scenario: Any, first: tuple[str, ...]) -> tuple[str, ...]:
    """The first model above this one that is inside its domain, and the first without a finding."""
    rank = ORDER.index(name) if name in ORDER else -1
    inside: tuple[str, ...] = ()
    for other in dict.fromkeys((*first, *ORDER[2:])):
        if other in ORDER[rank + 1 :] and not (other == _NO_STRETCH and _shears_far(scenario)):
            findings = _findings_of_model(other, scenario)
            if findings == ():
                return (*inside, other)
            if findings and not inside and not any(f.outside or f.refusal for f in findings):
                inside = (other,)
    return inside


def _shears_far(scenario: Any) -> bool:
    """Whether a hit has the energy for larger plastic shear deformation than beams can follow."""
    if not isinstance(scenario, ColumnImpact):
        return False
    hit = features(scenario)
    return hit[DEMAND] > 1.0 and hit["turned"] > LARGEST_SHEAR_STRAIN


@lru_cache(maxsize=64)  # one case is asked for by all: five models take 0.8, not 1.4 ms
def _findings_of_model(name: str, scenario: Any) -> tuple[Finding, ...] | None:
    """Findings about a model of this name; None if it does not answer."""
    model = _default_model(name)
    if model is None or scenario.KIND not in model.answers:
        return None
    try:
        return tuple(findings_about(model, scenario))
    except WorkbenchError:  # it would refuse as it answers
        return None


@lru_cache(maxsize=len(ORDER))
def _default_model(name: str) -> Model | None:
    """The installed model of this name with default options; looking it up takes milliseconds."""
    try:
        return make_model(name)
    except InputError:
        return None
