"""Reference: co-rotational beam with fiber sections, static and under impact.

Heng 2017, section 2.1: plasticity is distributed along the member (two points per element) and
across it (fibers), rotations are large, steel is elastic-perfectly plastic. With refinement,
plasticity localises in single elements: forces and displacements converge to those of hinges of
zero length, strains do not.

**Second part.** Reference of record: geometrically exact fiber beam, static and under impact.

Reissner 1972 and Simo 1985: finite stretch, shear and rotation, one point per linear element,
fibers across the section. The element samples plasticity half its length inside the member, so
that resistance converges from above at first order in the length of the smallest element. The
mesh grows fast from a very small element at every hinge: that error is then small, and a hinge
that the hardening spreads over millimetres is resolved.

**Third part.** Reference whose webs yield in shear: where beam theory without shear yielding ends.

The geometrically exact fiber beam, with fibers along the shear force (webs,
solid sections) that yield under normal and shear stress together, sigma^2 + 3 tau^2 = fy^2, with
the rate law of the steel on the right where it has one.
"""

from dataclasses import dataclass, replace
from math import sqrt
from typing import ClassVar

import numpy as np

from workbench.base.errors import CrumpledError
from workbench.base.fields import Choice, Flag, Number, checked
from workbench.mechanics.frames.members import residual_findings
from workbench.mechanics.structures.fibers import PATTERNS, lobatto
from workbench.mechanics.structures.fibers.section import (
    FiberBeams,
    Law,
    LinearHardening,
    MenegottoPinto,
    Points,
    ReissnerBeams,
    ShearYielding,
    radau_rule,
)
from workbench.models.base import respond
from workbench.models.domain import DIRECT_SHEAR, shear_demand, web_findings, web_of
from workbench.models.frame_model import COLUMNS, as_frame
from workbench.models.references.fiber import (
    BALANCED_RULE,
    CLASSICAL_RULE,
    CLASSICAL_STATIC_RULE,
    REISSNER_GIVEN,
    REISSNER_RULE,
    SHEAR_RULE,
    FiberReference,
    FrameMesh,
    MeshRule,
)
from workbench.models.references.refine import COARSEST, LEVELS, MESHES, REFINEMENT, refined
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    finding,
    findings_of,
    outcome_of,
    set_findings,
)
from workbench.scenarios import (
    ColumnScenario,
    Frame,
    FrameScenario,
    FrameStatic,
    MemberPulse,
    Scenario,
)
from workbench.scenarios.pulse import UNIFORM
from workbench.steel.materials import Steel

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

    def fibers(self, frame: Frame, mesh: FrameMesh) -> FiberBeams:
        """Co-rotational beams, balanced or classical."""
        balanced = self.element == BALANCED
        rule = radau_rule(mesh.upper) if balanced else None
        if self.element == LOBATTO:
            rule = Points(*lobatto(4))
        given = mesh.nodes, mesh.member, self.sections(frame)
        return FiberBeams(*given, rule, balanced=balanced)


LAWS = ("linear", "menegotto-pinto")
BEAMS = ("reissner1972", "simo1985", "simo-tarnow-doblare1995")  # sources


@dataclass(frozen=True)
class ExactBeams(FiberReference):
    """Geometrically exact beams: one point per element, residual stress, crooked columns.

    By rule the largest element is 1/40 of the longest member, in dynamics at most half the depth.
    """

    residual_stress: str = checked(Choice(PATTERNS), "none", help="pattern in an I section")
    out_of_straightness: float = checked(
        Number(-0.02, 0.02, advice="amplitude over length: 1/1000 is 0.001"),
        0.0,
        help="amplitude of a half sine of a column along the strike over its length",
    )

    sampled: ClassVar[float] = 0.5

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings common to all fiber references, and refusals of options."""
        findings = super().domain(scenario)
        findings += residual_findings(as_frame(scenario).frame, self.residual_stress)
        if self.out_of_straightness != 0.0 and not isinstance(scenario, COLUMNS):
            findings.append(finding("out-of-straightness", amplitude=self.out_of_straightness))
        return findings

    def placed(self, mesh: FrameMesh) -> FrameMesh:
        """The mesh with a half sine along the strike over the length of a column."""
        if self.out_of_straightness == 0.0:
            return mesh
        heights = mesh.coordinates[:, 1]
        length = heights.max()
        bow = self.out_of_straightness * length * np.sin(np.pi * heights / length)
        return mesh._replace(coordinates=np.stack([bow, heights], axis=1))

    def fibers(self, frame: Frame, mesh: FrameMesh) -> ReissnerBeams:
        """Geometrically exact beams."""
        return ReissnerBeams(mesh.nodes, mesh.member, self.sections(frame))


@dataclass(frozen=True)
class FiberReissner(ExactBeams):
    """Geometrically exact fiber beam.

    By rule the smallest element is 1/256 of the shorter member that is hit, but not below 1/100 of
    the depth. `hardening_ratio` is regularisation by default: perfect plasticity has no limit of
    the mesh at large rotations, as a hinge has no length. A hardening modulus of the steel takes
    its place.
    """

    levels: int = checked(LEVELS, 4, help=MESHES)
    steel_law: str = checked(Choice(LAWS), "linear")
    isotropic_ratio: float = checked(
        Number(0.0, 0.1), 0.0, help="isotropic hardening modulus over the elastic one"
    )

    name: ClassVar[str] = "fiber-reissner"
    version: ClassVar[int] = 9
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections that may stretch, shear and turn by any amount.",
        "Plasticity of the fibers from normal stress alone; shear strain stays elastic.",
        "Elastic stiffness and strength are both those of the fibers (column.fillets applies to "
        "both); the mass is that of the rolled profile, distributed along the member.",
        "Point contact; no local denting, no local buckling, no fracture; strain rate and "
        "hardening as the steel has them; residual stress and crookedness are options.",
        "Elastic-perfectly plastic up to a hardening of 1e-6 E, which gives a hinge a length; "
        "without it forces at hinge rotations beyond 0.3 depend on the mesh.",
    )

    def check(self) -> None:
        """Refuse options that do not go together."""
        super().check()
        if self.steel_law == "menegotto-pinto" and self.isotropic_ratio:
            text = "is not known with steel_law = menegotto-pinto"
            raise self.refusal("isotropic_ratio", text, "use steel_law = linear")

    @property
    def material(self) -> tuple[str, ...]:
        """Properties of the steel that the fibers follow beside its static strength."""
        linear = self.steel_law == "linear"
        return ("rate", "hardening") if linear else ("static strength",)

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the beam and of the options that are on."""
        law = ("menegotto-pinto1973",) if self.steel_law == "menegotto-pinto" else ()
        return (*BEAMS, "heng2017", *law, *(["eccs1984"] if self.residual_stress != "none" else []))

    def mesh_rule(self, scenario: FrameScenario) -> MeshRule:
        """Elements grow fast from the very small ones of the rule only."""
        return REISSNER_RULE if self.smallest_element is None else REISSNER_GIVEN

    def law(self, steel: Steel) -> Law:
        """The law of the fibers."""
        if self.steel_law == "linear":
            return LinearHardening.of(steel, self.hardening_ratio, self.isotropic_ratio)
        return MenegottoPinto(steel.elastic_modulus, steel.yield_stress, self.hardening_ratio)


@dataclass(frozen=True)
class FiberShear(ExactBeams):
    """Geometrically exact fiber beam with shear yielding.

    By rule the smallest element is 1/64 of the shorter member that is hit, but not below 1/20 of
    the depth; time steps are twice as long as of other references.
    """

    name: ClassVar[str] = "fiber-shear"
    material: ClassVar[tuple[str, ...]] = ("rate", "hardening")
    version: ClassVar[int] = 8
    shear_yields: ClassVar[bool] = True
    longer: ClassVar[float] = 2.0  # webs that yield take the waves out
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections that may stretch, shear and turn by any amount; one shear strain per "
        "section.",
        "Webs and solid sections yield under normal and shear stress together, flanges and "
        "fillets carry no shear; the elastic shear stiffness is that of the same fibers.",
        "Plastic shear does not stretch the member: above a mean shear strain of 0.3 the "
        "catenary action of a real member is missed.",
        "The mass is that of the rolled profile, distributed along the member.",
        "Point contact; no local denting, no web buckling, no fracture; strain rate and hardening "
        "as the steel has them, one law for both stresses of a fiber.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the beam and of the options that are on."""
        return (
            *BEAMS,
            "simo-hughes1998",
            *(["eccs1984"] if self.residual_stress != "none" else []),
        )

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings of all fibers; webs that buckle; pulses that webs decide, clear of flanges here.

        At the ends of a line load all webs that yield slide alike, see docs/theory/shear-panel.md.
        """
        frame = as_frame(scenario).frame
        webs = {m.name: web_of(frame.strength_section(m), frame.steel) for m in frame.members}
        findings = super().domain(scenario) + web_findings(webs)
        if isinstance(scenario, MemberPulse):
            if scenario.load == UNIFORM:
                findings = [each for each in findings if each.subject != DIRECT_SHEAR]
            needed = max(shear_demand(scenario).values())
            if needed > 1.0 and all(each.subject != DIRECT_SHEAR for each in findings):
                findings.append(finding("clear-web", needed, needed=needed))
        return findings

    def mesh_rule(self, scenario: FrameScenario) -> MeshRule:
        """Sizes of elements where no option gives them."""
        return SHEAR_RULE

    def law(self, steel: Steel) -> ShearYielding:
        """Fibers along the shear force yield under sigma^2 + 3 tau^2."""
        moduli = steel.elastic_modulus, steel.shear_modulus
        hardening = steel.hardening_modulus or self.hardening_ratio * steel.elastic_modulus
        return ShearYielding(*moduli, steel.yield_stress, hardening, steel.rate)
