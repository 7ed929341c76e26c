"""Which model to take where one leaves its domain: of more trust, and inside its own domain here.

Models stand in one order, and a remedy only goes up in it, so that no chain of remedies comes back.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import entry_points
from typing import Any

from workbench.errors import WorkbenchError
from workbench.frames.runs import LARGEST_SHEAR_STRAIN
from workbench.models.descriptors import DEMAND, features
from workbench.models.validity import measured_findings
from workbench.responses import Finding
from workbench.scenarios import ColumnImpact

GROUP = "workbench.models"  # of the entry points that offer models
# From the least trusted on; all others stand before them. The first two are asked only by name.
ORDER = (
    *("energy-estimate", "soft-impact"),
    *("four-dof-shear", "plastic-hinge", "rigid-superelement", "flexible-superelement"),
    *("fiber-reissner", "fiber-shear", "solid-plane-stress"),
)
_NO_STRETCH = "fiber-shear"  # follows webs that slide only so far, which its run tells
NONE = "no model of more trust is inside its domain here"


def findings_about(model: Any, scenario: Any) -> list[Finding]:
    """What is known about a model before it answers: its domain, and what studies measured."""
    return [*model.domain(scenario), *measured_findings(model, scenario)]


def advised(model: Any, scenario: Any, findings: Iterable[Finding]) -> list[Finding]:
    """The findings of a model; those that another model mends with the names of such models."""
    told = []
    for finding in findings:
        if finding.instead is not None:
            names = _better(model.name, scenario, finding.instead)
            words = f"take {' or '.join(names)}" if names else NONE
            finding = replace(finding, remedy=words, instead=names)
        told.append(finding)
    return told


def trusted(scenario: Any) -> str:
    """The first model of the order that is inside its domain here; the beam before the solid."""
    return next((n for n in _better("", scenario, ()) if n != ORDER[-1]), _NO_STRETCH)


def _better(name: str, scenario: Any, first: Sequence[str]) -> tuple[str, ...]:
    """The first model above this one that is inside its domain, and the first without a finding."""
    rank = ORDER.index(name) if name in ORDER else -1
    inside: tuple[str, ...] = ()
    for other in dict.fromkeys((*first, *ORDER[2:])):
        if other in ORDER[rank + 1 :] and not (other == _NO_STRETCH and _slides(scenario)):
            findings = _known(other, scenario)
            if findings == []:
                return (*inside, other)
            if findings and not inside and not any(f.outside or f.refusal for f in findings):
                inside = (other,)
    return inside


def _slides(scenario: Any) -> bool:
    """Whether a hit has the energy for webs to slide further than beams that do not stretch."""
    if not isinstance(scenario, ColumnImpact):
        return False
    hit = features(scenario)
    return hit[DEMAND] > 1.0 and hit["turned"] > LARGEST_SHEAR_STRAIN


def _known(name: str, scenario: Any) -> list[Finding] | None:
    """Findings about a model of this name, found once; None if it does not answer."""
    kept, key = scenario.kept, f"findings of {name}"
    if key not in kept:
        model, kept[key] = _made(name), None
        if model is not None and scenario.KIND in model.answers:
            try:
                kept[key] = findings_about(model, scenario)
            except WorkbenchError:  # it would refuse as it answers
                kept[key] = None
    known: list[Finding] | None = kept[key]
    return known


@lru_cache(maxsize=len(ORDER))
def _made(name: str) -> Any:
    """The installed model of this name with its own options, None without one."""
    for point in entry_points(group=GROUP, name=name):
        return point.load()()
    return None
