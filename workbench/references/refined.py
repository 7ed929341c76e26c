"""A reference that answers with its numerical uncertainty: `refine` as a model of a study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from workbench.fields import Choice, Number, check_fields, checked
from workbench.models.base import with_options
from workbench.references.fiber_corotational import FiberCorotational
from workbench.references.fiber_reissner import FiberReissner
from workbench.references.fiber_shear import FiberShear
from workbench.references.refine import refine
from workbench.references.solid import SolidPlaneStress
from workbench.responses import Finding, Response
from workbench.scenarios import Scenario

KINDS: dict[str, type[Any]] = {
    kind.name: kind for kind in (FiberReissner, FiberShear, FiberCorotational, SolidPlaneStress)
}


@dataclass(frozen=True)
class Refined:
    """A reference with a refinement ladder of its own in every answer.

    Options: `kind`, name of the reference; `options` of its coarsest level, pairs of name and
    value; `levels` in space and time. Raises `InputError`.
    """

    kind: str = checked(Choice(tuple(KINDS)), FiberReissner.name)
    options: tuple[tuple[str, Any], ...] = ()
    levels: int = checked(Number(2, 6, integer=True), 3)

    name: ClassVar[str] = "refined-reference"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = FiberReissner.answers
    assumptions: ClassVar[tuple[str, ...]] = (
        "Those of the reference that is refined.",
        "Numerical uncertainty from halving mesh and steps, and fibers and time steps alone.",
    )

    def __post_init__(self) -> None:
        check_fields(self, "option")
        _ = self.coarsest

    @property
    def coarsest(self) -> Any:
        """The reference at its coarsest level."""
        return with_options(KINDS[self.kind], dict(self.options))

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the reference."""
        return tuple(self.coarsest.sources)

    def domain(self, scenario: Scenario) -> list[Finding]:
        """What the reference says about the scenario."""
        return list(self.coarsest.domain(scenario))

    def simulate(self, scenario: Scenario) -> Response:
        """The finest response with `numerical_uncertainty` and `refinement`, see `refine`."""
        return refine(self.coarsest, scenario, levels=self.levels)
