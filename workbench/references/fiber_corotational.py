"""Reference: co-rotational beam with fiber sections, static and under impact.

Heng 2017, chapter 5: plasticity is distributed along the member (two points per element) and
across it (fibers), rotations are large, steel is elastic-perfectly plastic. With refinement,
plasticity localises in single elements: forces and displacements converge to those of hinges of
zero length, strains do not.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from workbench.fields import Choice, Flag, Number, check_fields, checked
from workbench.frames.structure import FrameStructure
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.references.column_beams import ColumnBeams, build_column, fiber_section
from workbench.references.column_rules import (
    CUBIC_STATIC_SHARE,
    check_layers,
    column_mesh,
    mesh_findings,
    section_findings,
    time_spans,
)
from workbench.references.column_runs import run_column
from workbench.references.frame_fibers import corotational_frame, fiber_findings, run_fiber_frame
from workbench.references.frame_mesh import member_lengths
from workbench.references.refine import LEVELS, REFINEMENT, check_levels, refined
from workbench.responses import Finding, Response
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    FrameGroundMotion,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    Scenario,
)

Array = NDArray[np.float64]
ELEMENTS = ("interpolated", "balanced")
# Smallest element over the shorter segment and over the depth (hinges need room); statics has no
# inertia to carry an element over the loss of stiffness when its hinge crumples.
SMALLEST = {  # by element and whether the event is static
    ("interpolated", False): (1.0 / 32.0, 0.1),
    ("interpolated", True): (1.0 / 16.0, 0.2),
    ("balanced", False): (1.0 / 12.0, 0.3),
    ("balanced", True): (1.0 / 12.0, 0.3),
}
FRAMES = (FrameImpact, FrameStatic, FrameGroundMotion)
# Distance of the sampled section from the hinge over the element: Gauss, or Radau on the hinge.
SAMPLED = {"interpolated": 0.5 - 0.5 / sqrt(3.0), "balanced": 0.0}


@dataclass(frozen=True)
class FiberCorotational:
    """Co-rotational fiber beam.

    Its options: `element`, interpolated (the classical element with two Gauss points and linear
    axial displacement) or balanced (one axial force per element, plasticity sampled at the end
    that is nearer to a potential hinge: hardly depends on the mesh, but stretches hinges along the
    member only); `smallest_element` in m, at both ends of both segments (None: 1/32 of the
    shorter segment, 1/16 in statics, 1/12 for balanced elements, but not below 0.1, 0.2 and 0.3
    of the depth);
    `largest_element` in m (None: 1/40 of the length under impact, 1/8 in statics); `layers` over
    the depth of the section; `weight` of the end stresses in a time step (1/2 conserves energy,
    but does not converge on fine plastic meshes); `hardening_ratio`, the regularising hardening
    over the elastic modulus; `time_step` in s (None: 1/15 of the time of an axial wave along the
    column, and at first at most 1/200 of the expected time to the peak); `refinement`, how often
    all these elements and steps are halved (-1: doubled); `step_refinement`, how often the steps
    alone are halved further; `levels`, meshes behind an answer, each with twice the elements and
    steps of the next finer one (1: that of `refinement` alone, the numerical uncertainty is then
    unknown); `shear_flexible`: elastic shear strain (False: Bernoulli's beam without any);
    `integrator`, implicit with energy-exact steps or explicit central differences with lumped
    mass.
    """

    element: str = checked(Choice(ELEMENTS), "interpolated")
    smallest_element: float | None = checked(Number(1e-4, 10.0, "m"), optional=True)
    largest_element: float | None = checked(Number(1e-4, 100.0, "m"), optional=True)
    layers: int = checked(Number(4, 1000, integer=True), 20)
    weight: float = checked(
        Number(0.5, 1.0, advice="1/2 conserves energy, 1 dissipates most"), 0.55
    )
    hardening_ratio: float = checked(Number(1e-9, 0.1), 1e-6)
    time_step: float | None = checked(Number(1e-8, 1e-2, "s"), optional=True)
    refinement: int = checked(REFINEMENT, 1)
    step_refinement: int = checked(REFINEMENT, 0)
    levels: int = checked(LEVELS, 3)
    shear_flexible: bool = checked(Flag(), True)
    integrator: str = checked(Choice(("implicit", "explicit")), "implicit")

    name: ClassVar[str] = "fiber-corotational"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (
        ColumnImpact.KIND,
        ColumnPushover.KIND,
        FrameImpact.KIND,
        FrameStatic.KIND,
        FrameGroundMotion.KIND,
    )
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections; cubic deflection between nodes; large displacements and rotations.",
        "Elastic-perfectly plastic fibers, plasticity from normal stress alone.",
        "Elastic shear strain of the shear area (option shear_flexible), no shear yielding.",
        "Elastic stiffness and strength are both those of the fibers (column.fillets applies to "
        "both); the mass is that of the rolled profile, distributed along the member.",
        "Point contact; no local denting, no local buckling, no strain-rate effect, no fracture.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def __post_init__(self) -> None:
        check_fields(self, "option")
        check_layers(self.layers)
        check_levels(self.refinement, self.levels)

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings common to all member models, and overrides that fibers cannot follow."""
        if isinstance(scenario, FRAMES):
            lengths = self.frame_mesh(scenario)
            return fiber_findings(scenario, lengths, self.layers, SAMPLED[self.element])
        y, area = scenario.column.strength_section.fibers(self.layers)
        return [
            *member_findings(scenario),
            *section_findings(scenario.column, y, area),
            *mesh_findings(scenario, *self.mesh(scenario), SAMPLED[self.element]),
        ]

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a scenario of a column or a frame, with numerical uncertainty."""
        return respond(self, scenario, lambda given: refined(self, given, self._solve))

    def mesh(self, scenario: ColumnScenario) -> tuple[Array, Array]:
        """Element lengths (m) below and above the hit point."""
        return column_mesh(
            scenario,
            self.smallest_element,
            self.largest_element,
            self.refinement,
            *SMALLEST[self.element, isinstance(scenario, ColumnPushover)],
            static_share=CUBIC_STATIC_SHARE,
        )

    def frame_mesh(self, scenario: FrameScenario) -> list[Array]:
        """Element lengths (m) of every member of a frame."""
        return member_lengths(
            scenario,
            self.smallest_element,
            self.largest_element,
            self.refinement,
            *SMALLEST[self.element, isinstance(scenario, FrameStatic)],
            static_share=CUBIC_STATIC_SHARE,
        )

    def time_spans(self, scenario: ColumnImpact) -> list[tuple[float, float]]:
        """End times and time steps (s) of the parts of the record, refinement applied."""
        return time_spans(scenario, self.time_step, self._halvings, self.shear_flexible)

    def beams(self, scenario: ColumnScenario) -> ColumnBeams:
        """The column under its axial load, ready to be hit or pushed. Raises `SolverError`."""
        section = fiber_section(
            scenario.column, self.layers, self.hardening_ratio, self.shear_flexible
        )
        return build_column(
            scenario.column,
            section,
            *self.mesh(scenario),
            balanced=self.element == "balanced",
            lumped=self.integrator == "explicit",
        )

    def frame(self, scenario: FrameScenario) -> FrameStructure:
        """The frame under its dead loads, ready for its event. Raises `SolverError`."""
        return corotational_frame(
            scenario.frame,
            self.frame_mesh(scenario),
            self.layers,
            self.hardening_ratio,
            shear_flexible=self.shear_flexible,
            balanced=self.element == "balanced",
            lumped=self.integrator == "explicit",
        )

    def _solve(self, scenario: ColumnScenario | FrameScenario) -> Response:
        weight = self.weight if self.integrator == "implicit" else None
        if isinstance(scenario, FRAMES):
            build = partial(self.frame, scenario)
            return run_fiber_frame(scenario, build, self.time_step, self._halvings, weight)
        return run_column(scenario, self.beams, self.time_spans, self._halvings, weight)

    @property
    def _halvings(self) -> int:
        """How often the steps are halved."""
        return self.refinement + self.step_refinement
