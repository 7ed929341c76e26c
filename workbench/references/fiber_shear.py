"""Reference whose webs yield in shear: where beam theory without shear yielding ends.

The geometrically exact fiber beam of `fiber_reissner`, with fibers along the shear force (webs,
solid sections) that yield under normal and shear stress together, sigma^2 + 3 tau^2 = fy^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from workbench.fields import Choice, Number, check_fields, checked
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.references.column_beams import ColumnBeams
from workbench.references.column_rules import (
    check_layers,
    column_mesh,
    mesh_findings,
    section_findings,
    time_spans,
)
from workbench.references.column_runs import run_column
from workbench.references.fiber_reissner import pattern_findings
from workbench.references.fiber_reissner_column import reissner_column, shear_section
from workbench.references.refine import LEVELS, REFINEMENT, check_levels, refined
from workbench.responses import Finding, Response
from workbench.scenarios import ColumnImpact, ColumnPushover, ColumnScenario, Scenario
from workbench.structures.reissner_beams.fibers import PATTERNS

Array = NDArray[np.float64]
SMALLEST_SHARE = 1.0 / 64.0  # of the shorter segment
SMALLEST_DEPTH = 0.05  # of the depth


@dataclass(frozen=True)
class FiberShear:
    """Geometrically exact fiber beam with shear yielding.

    Its options are those of `FiberReissner`, without the choice of steel laws:
    `smallest_element` (None: 1/64 of the shorter segment, but not below 1/20 of the depth) and
    `largest_element` in m, `layers` over the depth, `time_step` in s,
    `refinement`, `step_refinement` (of the steps alone), `levels`, meshes behind an answer,
    `integrator`, `weight` of the end stresses, `hardening_ratio` that only regularises,
    `residual_stress` with `residual_ratio`, `out_of_straightness`.
    """

    smallest_element: float | None = checked(Number(1e-4, 10.0, "m"), optional=True)
    largest_element: float | None = checked(Number(1e-4, 100.0, "m"), optional=True)
    layers: int = checked(Number(4, 1000, integer=True), 20)
    time_step: float | None = checked(Number(1e-8, 1e-2, "s"), optional=True)
    refinement: int = checked(REFINEMENT, 0)
    step_refinement: int = checked(REFINEMENT, 0)
    levels: int = checked(LEVELS, 3)
    integrator: str = checked(Choice(("implicit", "explicit")), "implicit")
    weight: float = checked(
        Number(0.5, 1.0, advice="1/2 conserves energy, 1 dissipates most"), 0.55
    )
    hardening_ratio: float = checked(Number(0.0, 0.1), 1e-6)
    residual_stress: str = checked(Choice(PATTERNS), "none")
    residual_ratio: float | None = checked(Number(0.0, 1.0), optional=True)
    out_of_straightness: float = checked(
        Number(-0.02, 0.02, advice="amplitude over length: 1/1000 is 0.001"), 0.0
    )

    name: ClassVar[str] = "fiber-shear"
    version: ClassVar[int] = 2
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, ColumnPushover.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections that may stretch, shear and turn by any amount; one shear strain per "
        "section.",
        "Webs and solid sections yield under normal and shear stress together, flanges and "
        "fillets carry no shear; the elastic shear stiffness is that of the same fibers.",
        "Sections slide without stretching the member: above a mean shear strain of 0.3 the "
        "catenary action of a real member is missed.",
        "The mass is that of the rolled profile, distributed along the member.",
        "Point contact; no local denting, no web buckling, no strain-rate effect, no fracture.",
    )

    def __post_init__(self) -> None:
        check_fields(self, "option")
        check_layers(self.layers)
        check_levels(self.refinement, self.levels)

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the beam and of the options that are on."""
        keys = ("reissner1972", "simo1985", "simo-tarnow-doblare1995", "simo-hughes1998")
        return keys if self.residual_stress == "none" else (*keys, "eccs1984")

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Findings common to all member models but shear, and what fibers cannot follow."""
        y, area = scenario.column.strength_section.fibers(self.layers)
        common = [f for f in member_findings(scenario) if f.subject != "shear"]
        findings = common + section_findings(scenario.column, y, area)
        findings += mesh_findings(scenario, *self.mesh(scenario))
        return findings + pattern_findings(scenario, self.residual_stress)

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a column pushover or a column impact, with numerical uncertainty."""
        return respond(self, scenario, lambda given: refined(self, given, self._solve))

    def mesh(self, scenario: ColumnScenario) -> tuple[Array, Array]:
        """Element lengths (m) below and above the hit point."""
        return column_mesh(
            scenario,
            self.smallest_element,
            self.largest_element,
            self.refinement,
            SMALLEST_SHARE,
            SMALLEST_DEPTH,
        )

    def beams(self, scenario: ColumnScenario) -> ColumnBeams:
        """The column under its axial load, ready to be hit or pushed. Raises `SolverError`."""
        section = shear_section(
            scenario.column,
            self.layers,
            self.hardening_ratio,
            self.residual_stress,
            self.residual_ratio,
        )
        return reissner_column(
            scenario.column,
            section,
            *self.mesh(scenario),
            crookedness=self.out_of_straightness,
            lumped=self.integrator == "explicit",
        )

    def time_spans(self, scenario: ColumnImpact) -> list[tuple[float, float]]:
        """End times and time steps (s) of the parts of the record, refinement applied."""
        return time_spans(scenario, self.time_step, self._halvings)

    def _solve(self, scenario: ColumnScenario) -> Response:
        weight = self.weight if self.integrator == "implicit" else None
        return run_column(scenario, self.beams, self.time_spans, self._halvings, weight)

    @property
    def _halvings(self) -> int:
        """How often the steps are halved."""
        return self.refinement + self.step_refinement
