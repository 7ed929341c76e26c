"""Frames of force-based elements whose sections are known by N and M alone (Heng 2017, 2.2).

`bounding-surface` yields by degrees between two surfaces (El-Tawil and Deierlein);
`modified-tangent-modulus` has sharp hinges on members that N softens (Ziemian and McGuire).
Derivation: docs/theory/frame-models.md.
"""

from abc import abstractmethod
from dataclasses import dataclass, replace
from math import sqrt
from typing import ClassVar

import numpy as np

from workbench.arrays import Array
from workbench.fields import Choice, Number, checked
from workbench.frames.members import fiber_section, residual_findings
from workbench.frames.superelements import Piece
from workbench.hinges.interaction import polyline
from workbench.models.bar_frames import Cut
from workbench.models.frame_model import as_frame
from workbench.models.hinged_frames import BarHinges
from workbench.responses import Finding
from workbench.scenarios import ColumnScenario, Frame, FrameScenario, Member
from workbench.structures.bars import Bar, BarElements, fiber_bars, lobatto_rule
from workbench.structures.fibers import PATTERNS, BeamSection, section_fibers
from workbench.structures.fibers.section import LinearHardening, yielding_in_bending

LAYERS = 40  # of the fibers that two surfaces are calibrated on
COMMON = (
    "Moments are exactly linear between the ends of an element; N bends members through their "
    "elements, as many as keep its squash load below 1/16 of the Euler load of one.",
    "Super-elliptic surface of the fully plastic section; joints turn elastically, their strength "
    "is that of the member.",
    "No shear yielding, no local buckling; strain rate by one factor.",
)


@dataclass(frozen=True)
class Resultants(BarHinges):
    """Force-based elements, each section of which is a law of N and M.

    Shared options: Gauss-Lobatto `points` along an element, whose ends are among them;
    `regularisation`, share of the elastic stiffness beside the sections.
    """

    points: int = checked(Number(3, 20, integer=True), 5)

    second_order: ClassVar[bool] = False
    euler_share: ClassVar[float] = 1.0 / 16.0
    loses_moment: ClassVar[str] = (
        "the super-ellipse is some percent off the section there, on laden members up to a quarter "
        "of the peak"
    )

    def curve(self, frame: Frame, piece: Piece, joint_governs: bool) -> Array:
        """The super-ellipse."""
        return polyline("super-ellipse", frame.strength_section(piece.member))

    @abstractmethod
    def law(self, frame: Frame, member: Member) -> tuple[float, float, float, bool]:
        """Entries `inner`, `lag`, `minor` and `softens` of RESULTANT."""

    def group(self, frame: Frame, cut: Cut, bars: list[Bar]) -> BarElements:
        """The elements; two fibers each stand for their EA and EI."""
        steel, sections, rows = frame.steel, [], []
        laws = {member.name: self.law(frame, member) for member in frame.members}
        elastic = LinearHardening(steel.elastic_modulus, steel.yield_stress)
        for piece, bar in zip(cut[2], bars, strict=True):
            p = frame.properties(piece.member)
            radius = sqrt(p.second_moment / p.area)
            pair = np.array([-radius, radius]), np.full(2, 0.5 * p.area)
            sections.append(BeamSection(*pair, elastic, piece.mass))
            stiffness = bar.axial_stiffness, bar.bending_stiffness
            exponents = frame.strength_section(piece.member).interaction_fit()
            surface = p.squash_load, p.plastic_moment, *exponents
            rows.append((*stiffness, *surface, self.regularisation, *laws[piece.member.name]))
        rules = [lobatto_rule(self.points)] * len(bars)
        return fiber_bars(cut[1], bars, rules, sections, self.first_order, rows)


@dataclass(frozen=True)
class BoundingSurface(Resultants):
    """Yield surface within a bounding surface, both super-elliptic, smooth between them.

    Options: `inner`, size of the yield surface over that of the bounding one (None: where fibers
    of the section begin to yield in bending, at least a half); `residual_stress` of these fibers.
    """

    inner: float | None = checked(Number(0.5, 1.0), optional=True)
    residual_stress: str = checked(Choice(PATTERNS), "none")

    name: ClassVar[str] = "bounding-surface"
    version: ClassVar[int] = 1
    sources: ClassVar[tuple[str, ...]] = ("eltawil1998", "eltawil2001", "mroz1967", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Sections flow normal to a yield surface that moves within the bounding surface of the "
        "full plastic section; the plastic modulus falls with the square of the distance between "
        "both, calibrated on fibers in bending.",
        *COMMON,
    )

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings of hinges, and residual stresses of sections that they are not known of."""
        frame = as_frame(scenario).frame
        return super().domain(scenario) + residual_findings(frame, self.residual_stress)

    def law(self, frame: Frame, member: Member) -> tuple[float, float, float, bool]:
        """Surfaces of fibers in bending."""
        steel, strips = frame.steel, fiber_section(frame, member, LAYERS, 0.0)
        fibers = section_fibers(frame.strength_section(member), LAYERS, self.residual_stress)
        stress = steel.yield_stress * fibers.residual
        strips = replace(strips, y=fibers.y, area=fibers.area, initial_stress=stress)
        inner, slowness = yielding_in_bending(strips, self.inner)
        return inner, frame.properties(member).plastic_moment * slowness, 0.0, False


@dataclass(frozen=True)
class ModifiedTangentModulus(Resultants):
    """Plastic hinges on members whose modulus falls with the axial force.

    Options: `minor_weight` of the moment beside the axial force, 0.65 for members that bend about
    their minor axis (whose second moment and plastic moment they must state), 0 about the major.
    """

    minor_weight: float = checked(Number(0.0, 1.0), 0.0)

    name: ClassVar[str] = "modified-tangent-modulus"
    version: ClassVar[int] = 1
    sources: ClassVar[tuple[str, ...]] = ("ziemian2002", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Modulus E min(1, (1 + 2p)(1 - p - w m)), p = N/Np, m = M/Mp, for what forces grow by "
        "beyond the largest so far; unloading is elastic.",
        "Perfectly plastic at the full plastic section, with normal flow.",
        *COMMON,
    )

    def law(self, frame: Frame, member: Member) -> tuple[float, float, float, bool]:
        """One surface, and a modulus that falls."""
        return 1.0, 0.0, self.minor_weight, True
