"""Reference of record: geometrically exact fiber beam, static and under impact.

Reissner 1972 and Simo 1985: finite stretch, shear and rotation, one point per linear element,
fibers across the section. The element samples plasticity half its length inside the member, so
that resistance converges from above at first order in the length of the smallest element. The
mesh grows fast from a very small element at every hinge: that error is then small, and a hinge
that the hardening spreads over millimetres is resolved.
"""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.base.fields import Choice, Number, checked
from workbench.mechanics.frames.members import residual_findings, shear_stiffness
from workbench.mechanics.structures.fibers import PATTERNS, BeamSection, section_fibers
from workbench.mechanics.structures.fibers.beams import ReissnerBeams
from workbench.mechanics.structures.fibers.section import (
    LinearHardening,
    MenegottoPinto,
    ShearYielding,
    UniaxialLaw,
)
from workbench.models.frame_model import COLUMNS, as_frame
from workbench.models.references.fiber import FiberReference
from workbench.models.references.fiber_mesh import (
    REISSNER_GIVEN,
    REISSNER_RULE,
    FrameMesh,
    MeshRule,
)
from workbench.models.references.refine import LEVELS, MESHES
from workbench.responses import Finding, finding
from workbench.scenarios import ColumnScenario, Frame, FrameScenario, Member
from workbench.steel.materials import Steel

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
    beams: ClassVar[type[ReissnerBeams]] = ReissnerBeams

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

    def elements(self, frame: Frame, mesh: FrameMesh) -> ReissnerBeams:
        """Geometrically exact beams."""
        sections = [self.section(frame, member) for member in frame.members]
        return self.beams(mesh.nodes, mesh.member, sections)

    def section(self, frame: Frame, member: Member) -> BeamSection:
        """The fibers of a member's strength section, their law and its mass.

        Shear yields in the fibers along the shear force, or strains the shear area elastically.
        """
        section, steel = frame.strength_section(member), frame.steel
        fibers = section_fibers(section, self.layers, self.residual_stress)
        return BeamSection(
            fibers.y,
            fibers.area,
            self.law(steel),
            frame.properties(member).mass_per_length,
            shear_stiffness=0.0 if self.shear_yields else shear_stiffness(section, steel),
            shear_share=fibers.share if self.shear_yields else None,
            initial_stress=steel.yield_stress * fibers.residual,
        )

    @abstractmethod
    def law(self, steel: Steel) -> UniaxialLaw | ShearYielding:
        """The law of the fibers."""


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

    def law(self, steel: Steel) -> UniaxialLaw:
        """The law of the fibers."""
        modulus = steel.elastic_modulus
        if self.steel_law == "menegotto-pinto":
            return MenegottoPinto(modulus, steel.yield_stress, self.hardening_ratio)
        hardening = steel.hardening_modulus or self.hardening_ratio * modulus
        isotropic = self.isotropic_ratio * modulus
        return LinearHardening(modulus, steel.yield_stress, hardening, isotropic, steel.rate)
