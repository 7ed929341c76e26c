"""Frames of one force-based element per member with fiber sections (Heng 2017, sections 2.1, 2.2).

`force-based-beam` integrates along the member with Gauss-Lobatto points, ends included;
`fiber-hinge` has fibers at the two ends alone and is elastic between. Derivation:
docs/theory/frame-models.md.
"""

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.arrays import Array
from workbench.fields import Number, checked
from workbench.frames.members import fiber_section
from workbench.frames.superelements import Piece
from workbench.hinges.interaction import polyline
from workbench.models.bar_frames import Cut
from workbench.models.hinged_frames import BarHinges
from workbench.scenarios import Frame
from workbench.structures.bars import Bar, BarElements, Rule, fiber_bars, hinge_rule, lobatto_rule

COMMON = (
    "Plane sections, elastic-perfectly plastic fibers; bending moments exactly linear between the "
    "ends: the axial force does not bend the element itself (option elements).",
    "Joints turn elastically; their strength is that of the member.",
    "No shear yielding, no local buckling; strain rate by one factor.",
)


@dataclass(frozen=True)
class ForceBased(BarHinges):
    """Force-based elements.

    Shared options: `layers` over the depth; `hardening_ratio`, kinematic hardening over the elastic
    modulus; `regularisation` is not used here.
    """

    layers: int = checked(Number(4, 1000, integer=True), 20)
    hardening_ratio: float = checked(Number(1e-9, 0.1), 1e-6)

    second_order: ClassVar[bool] = False
    euler_share: ClassVar[float] = 0.0

    def check(self) -> None:
        """Refuse layers that do not fit."""
        if self.layers % 2:
            raise self.refusal("layers", "must be even", "an odd number loses moment")

    @abstractmethod
    def rule(self, piece: Piece) -> Rule:
        """Points along an element."""

    def curve(self, frame: Frame, piece: Piece, joint_governs: bool) -> Array:
        """The exact one, for telling how near a section is to yield."""
        return polyline("exact", frame.strength_section(piece.member))

    def group(self, frame: Frame, cut: Cut, bars: list[Bar]) -> BarElements:
        """The elements; their elastic stiffness is that of the fibers."""
        sections = [
            fiber_section(frame, piece.member, self.layers, self.hardening_ratio)
            for piece in cut[2]
        ]
        elastic = []
        for bar, section in zip(bars, sections, strict=True):
            axial = float(section.law.elastic_modulus * section.area.sum())
            bending = axial * section.radius_squared
            elastic.append(replace(bar, axial_stiffness=axial, bending_stiffness=bending))
        rules = [self.rule(piece) for piece in cut[2]]
        return fiber_bars(cut[1], elastic, rules, sections, self.first_order)


@dataclass(frozen=True)
class ForceBasedBeam(ForceBased):
    """Force-based fiber element with Gauss-Lobatto points; option: `points` along an element."""

    points: int = checked(Number(3, 20, integer=True), 5)

    name: ClassVar[str] = "force-based-beam"
    version: ClassVar[int] = 6
    sources: ClassVar[tuple[str, ...]] = ("spacone1996", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Gauss-Lobatto points with fibers; without hardening plasticity stays at the end points, "
        "whose weight is then the length of the hinge: forces hold, curvatures mean nothing.",
        *COMMON,
    )

    def rule(self, piece: Piece) -> Rule:
        """Gauss-Lobatto points."""
        return lobatto_rule(self.points)


@dataclass(frozen=True)
class FiberHinge(ForceBased):
    """Fibers at both ends of an element that is elastic between.

    Options: `hinge_length` over the depth of the section.
    """

    hinge_length: float = checked(Number(0.01, 10.0), 1.0)

    name: ClassVar[str] = "fiber-hinge"
    version: ClassVar[int] = 6
    sources: ClassVar[tuple[str, ...]] = ("ngohuu2007", "scott2006", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Fibers over a hinge length (the depth of the section) at both ends; what lies between "
        "never yields.",
        *COMMON,
    )

    def rule(self, piece: Piece) -> Rule:
        """Fibers at both ends, at most an eighth of the length each."""
        return hinge_rule(self.hinge_length * piece.member.section.height / piece.length)
