"""Reference: co-rotational beam with fiber sections, static and under impact.

Heng 2017, section 2.1: plasticity is distributed along the member (two points per element) and
across it (fibers), rotations are large, steel is elastic-perfectly plastic. With refinement,
plasticity localises in single elements: forces and displacements converge to those of hinges of
zero length, strains do not.
"""

from dataclasses import dataclass, replace
from math import sqrt
from typing import ClassVar

from workbench.base.errors import CrumpledError
from workbench.base.fields import Choice, Flag, Number, checked
from workbench.mechanics.frames.members import fiber_section, shear_stiffness
from workbench.mechanics.structures.fibers import BeamSection, lobatto
from workbench.mechanics.structures.fibers.beams import FiberBeams, Points, radau_rule
from workbench.models.base import respond
from workbench.models.references.fiber import FiberReference
from workbench.models.references.fiber_mesh import (
    BALANCED_RULE,
    CLASSICAL_RULE,
    CLASSICAL_STATIC_RULE,
    FrameMesh,
    MeshRule,
)
from workbench.models.references.refine import COARSEST, REFINEMENT, refined
from workbench.responses import Outcome, Response, finding, findings_of, outcome_of, set_findings
from workbench.scenarios import ColumnScenario, Frame, FrameScenario, FrameStatic, Member, Scenario

_RETRIES = 2  # meshes of twice the element size each, after one that crumples
INTERPOLATED, BALANCED, LOBATTO = ELEMENTS = ("interpolated", "balanced", "lobatto")
# Distance of the sampled section from the hinge over the element: Gauss, or Radau on the hinge.
# Lobatto points lie on it, but end moments are means over all points: measured on a cantilever.
SAMPLED = {INTERPOLATED: 0.5 - 0.5 / sqrt(3.0), BALANCED: 0.0, LOBATTO: 0.32}


@dataclass(frozen=True)
class FiberCorotational(FiberReference):
    """Co-rotational fiber beam.

    By rule the smallest element is 1/32 of the shorter member that is hit, 1/16 in statics, 1/12 of
    balanced elements, but not below 0.1, 0.2 and 0.3 of the depth; the largest one 1/40 of the
    longest member in dynamics, 1/8 in statics.
    """

    hardening_ratio: float = checked(
        Number(1e-9, 0.1), 1e-6, help="regularising hardening over the elastic modulus"
    )
    refinement: int = checked(REFINEMENT, 1, help="how often all elements and steps are halved")
    element: str = checked(
        Choice(ELEMENTS),
        INTERPOLATED,
        help="interpolated: the classical one, two Gauss points and linear axial displacement; "
        "balanced: one axial force, plasticity sampled at the end nearer to a potential hinge "
        "(hardly depends on the mesh, but stretches hinges along the member only); lobatto: the "
        "classical one with four Gauss-Lobatto points, as in programs of practice",
    )
    shear_flexible: bool = checked(Flag(), True, help="elastic shear strain; false: Bernoulli's")

    name: ClassVar[str] = "fiber-corotational"
    version: ClassVar[int] = 7
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections; cubic deflection between nodes; large displacements and rotations.",
        "Elastic-perfectly plastic fibers, plasticity from normal stress alone.",
        "Elastic shear strain of the shear area (option shear_flexible), no shear yielding.",
        "Elastic stiffness and strength are both those of the fibers (column.fillets applies to "
        "both); the mass is that of the rolled profile, distributed along the member.",
        "Point contact; no local denting, no local buckling, no fracture; strain rate and "
        "hardening as the steel has them.",
    )
    material: ClassVar[tuple[str, ...]] = ("rate", "hardening")
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a scenario; a mesh whose element crumples is followed by coarser ones."""
        coarser: list[FiberCorotational] = []

        def solve(given: ColumnScenario | FrameScenario) -> Response:
            model = self
            while True:
                try:
                    return refined(model, given, model.solve)
                except CrumpledError:
                    if len(coarser) == _RETRIES or model.refinement == COARSEST:
                        raise
                    levels = max(1, model.levels - 1)
                    model = replace(model, refinement=model.refinement - 1, levels=levels)
                    coarser.append(model)

        response = respond(self, scenario, solve)
        if coarser and outcome_of(response) is not Outcome.OUT_OF_DOMAIN:
            taken, times = coarser[-1].refinement, 2 ** len(coarser)
            doubt = finding("crumpled", wanted=self.refinement, taken=taken, times=times)
            set_findings(response, [doubt, *findings_of(response)])
        return response

    def mesh_rule(self, scenario: FrameScenario) -> MeshRule:
        """Sizes of elements where no option gives them."""
        if self.element == BALANCED:
            return BALANCED_RULE
        static = isinstance(scenario, FrameStatic)
        return CLASSICAL_STATIC_RULE if static else CLASSICAL_RULE

    @property
    def sampled(self) -> float:
        """Where an element samples plasticity, from its end next to a hinge and over its length."""
        return SAMPLED[self.element]

    def elements(self, frame: Frame, mesh: FrameMesh) -> FiberBeams:
        """Co-rotational beams, balanced or classical."""
        balanced = self.element == BALANCED
        sections = [self.section(frame, member) for member in frame.members]
        rule = radau_rule(mesh.upper) if balanced else None
        if self.element == LOBATTO:
            rule = Points(*lobatto(4))
        return FiberBeams(mesh.nodes, mesh.member, sections, rule, balanced=balanced)

    def section(self, frame: Frame, member: Member) -> BeamSection:
        """The fibers of a member's strength section with its material and mass."""
        section = fiber_section(frame, member, self.layers, self.hardening_ratio)
        if not self.shear_flexible:
            return section
        shape = frame.strength_section(member)
        return replace(section, shear_stiffness=shear_stiffness(shape, frame.steel))
