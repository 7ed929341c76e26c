"""Frames of force-based elements of fibers, or of laws of N and M (Heng 2017, 2.1 and 2.2).

`force-based-beam` integrates along the member with Gauss-Lobatto points, ends included;
`fiber-hinge` has fibers at the two ends alone and is elastic between. `bounding-surface` yields by
degrees between two surfaces of N and M (El-Tawil and Deierlein); `modified-tangent-modulus` has
sharp hinges on members that N softens (Ziemian and McGuire). Derivation:
docs/theory/frame-models.md.
"""

from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from typing import ClassVar

import numpy as np

from workbench.base.fields import Choice, Number, checked
from workbench.extras.frame_models import hinge_limits
from workbench.extras.frame_models.bars import (
    BarElements,
    Quadrature,
    fiber_bars,
    hinge_rule,
    lobatto_rule,
)
from workbench.extras.frame_models.hinged_frames import SHEAR_FLEXIBLE, plastic_bars, plastic_end
from workbench.mechanics.frames.members import (
    CALIBRATED,
    LAYERS,
    fiber_overrides,
    fiber_section,
    residual_findings,
)
from workbench.mechanics.frames.structure import Cut
from workbench.mechanics.structures.fibers import PATTERNS, BeamSection
from workbench.mechanics.structures.fibers.section import LinearHardening, yielding_in_bending
from workbench.models.frame_model import ELEMENTS, GEOMETRY, REGULARISATION, TIME_STEP, FrameModel
from workbench.responses import Finding
from workbench.scenarios import Frame, FrameScenario, Member

POINTS = partial(
    checked,
    Number(3, 20, integer=True),
    5,
    help="Gauss-Lobatto points along an element, ends included",
)
LOSES = (
    "the super-ellipse is some percent off the section there, on laden members up to a quarter of "
    "the peak"
)
LAYER_COUNT = partial(checked, LAYERS, 20, help="over the depth")
HARDENING_RATIO = partial(
    checked, Number(1e-9, 0.1), 1e-6, help="kinematic hardening over the elastic modulus"
)
LIMITS = "No shear yielding, no local buckling; strain rate by one factor."
FIBERS = (
    "Plane sections, elastic-perfectly plastic fibers; bending moments exactly linear between the "
    "ends: the axial force does not bend the element itself (option elements).",
    "Joints turn elastically; their strength is that of the member.",
    LIMITS,
)
RESULTANTS = (
    "Moments are exactly linear between the ends of an element; N bends members through their "
    "elements, as many as keep its squash load below 1/16 of the Euler load of one.",
    "Super-elliptic surface of the fully plastic section; joints turn elastically, their strength "
    "is that of the member.",
    LIMITS,
)


def fiber_group(
    model: "ForceBasedBeam | FiberHinge", cut: Cut, rules: list[Quadrature]
) -> BarElements:
    """Elements with fibers at the points of their rules, which give the elastic stiffness too."""
    law, sections, elastic = LinearHardening.of(cut.frame.steel, model.hardening_ratio), [], []
    for piece, bar in zip(cut.pieces, plastic_bars(model, cut), strict=True):
        section = fiber_section(cut.frame, piece.member, model.layers, law)
        axial = float(section.law.elastic_modulus * section.area.sum())
        bending = axial * section.radius_squared
        sections.append(section)
        elastic.append(replace(bar, axial_stiffness=axial, bending_stiffness=bending))
    return fiber_bars(cut.nodes, elastic, rules, sections, model.first_order)


@dataclass(frozen=True)
class ForceBasedBeam(FrameModel):
    """Force-based fiber element with Gauss-Lobatto points; `regularisation` is not used."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
    layers: int = LAYER_COUNT()
    hardening_ratio: float = HARDENING_RATIO()
    points: int = checked(Number(3, 20, integer=True), 5, help="along an element")

    concentrated: ClassVar[bool] = False
    name: ClassVar[str] = "force-based-beam"
    version: ClassVar[int] = 7
    sources: ClassVar[tuple[str, ...]] = ("spacone1996", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Gauss-Lobatto points with fibers; without hardening plasticity stays at the end points, "
        "whose weight is then the length of the hinge: forces hold, curvatures mean nothing.",
        *FIBERS,
    )

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of overrides that fibers leave out."""
        return super().limits(event) + fiber_overrides(event.frame, self.layers)

    def group(self, cut: Cut) -> BarElements:
        """Elements with fibers at Gauss-Lobatto points."""
        return fiber_group(self, cut, [lobatto_rule(self.points)] * len(cut.pieces))


@dataclass(frozen=True)
class FiberHinge(FrameModel):
    """Fibers at both ends of an element that is elastic between; `regularisation` is not used."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
    layers: int = LAYER_COUNT()
    hardening_ratio: float = HARDENING_RATIO()
    hinge_length: float = checked(Number(0.01, 10.0), 1.0, help="over the depth of the section")

    name: ClassVar[str] = "fiber-hinge"
    version: ClassVar[int] = 7
    sources: ClassVar[tuple[str, ...]] = ("ngohuu2007", "scott2006", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Fibers over a hinge length (the depth of the section) at both ends; what lies between "
        "never yields.",
        *FIBERS,
    )

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of overrides that fibers leave out."""
        return super().limits(event) + fiber_overrides(event.frame, self.layers)

    def group(self, cut: Cut) -> BarElements:
        """Elements with fibers at both ends, at most an eighth of the length each."""
        depths = [self.hinge_length * p.member.section.height / p.length for p in cut.pieces]
        return fiber_group(self, cut, [hinge_rule(depth) for depth in depths])


def resultant_group(model: "BoundingSurface | ModifiedTangentModulus", cut: Cut) -> BarElements:
    """Elements whose sections are a law of N and M; two fibers each stand for their EA and EI."""
    steel, sections, rows = cut.frame.steel, [], []
    bars = plastic_bars(model, cut, partial(plastic_end, rule="super-ellipse"))
    laws = {member.name: model.law(cut.frame, member) for member in cut.frame.members}
    elastic = LinearHardening(steel.elastic_modulus, steel.yield_stress)
    for piece, bar in zip(cut.pieces, bars, strict=True):
        p = piece.properties
        radius = sqrt(p.second_moment / p.area)
        pair = np.array([-radius, radius]), np.full(2, 0.5 * p.area)
        sections.append(BeamSection(*pair, elastic, p.mass_per_length))
        stiffness = bar.axial_stiffness, bar.bending_stiffness
        exponents = piece.section.interaction_fit()
        surface = p.squash_load, p.plastic_moment, *exponents
        rows.append((*stiffness, *surface, model.regularisation, *laws[piece.member.name]))
    rules = [lobatto_rule(model.points)] * len(bars)
    return fiber_bars(cut.nodes, bars, rules, sections, model.first_order, rows)


@dataclass(frozen=True)
class BoundingSurface(FrameModel):
    """Yield surface within a bounding surface, both super-elliptic, smooth between them."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
    points: int = POINTS()
    inner: float | None = checked(
        Number(0.5, 1.0),
        optional=True,
        help="size of the yield surface over that of the bounding one (None: where fibers of the "
        "section begin to yield in bending, at least a half)",
    )
    residual_stress: str = checked(Choice(PATTERNS), "none", help="of these fibers")

    concentrated: ClassVar[bool] = False
    name: ClassVar[str] = "bounding-surface"
    version: ClassVar[int] = 2
    euler_share: ClassVar[float] = 1.0 / 16.0
    sources: ClassVar[tuple[str, ...]] = ("eltawil1998", "eltawil2001", "mroz1967", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Sections flow normal to a yield surface that moves within the bounding surface of the "
        "full plastic section; the plastic modulus falls with the square of the distance between "
        "both, calibrated on fibers in bending.",
        *RESULTANTS,
    )

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of axial forces, and residual stresses of sections that they are not known of."""
        axial = hinge_limits.axial_findings(event.frame, LOSES)
        residual = residual_findings(event.frame, self.residual_stress)
        return super().limits(event) + axial + residual

    def group(self, cut: Cut) -> BarElements:
        """Elements with laws of N and M at Gauss-Lobatto points."""
        return resultant_group(self, cut)

    def law(self, frame: Frame, member: Member) -> tuple[float, float, float, bool]:
        """Surfaces of fibers in bending: `inner`, `lag`, `minor`, `softens` of RESULTANT."""
        strips = fiber_section(frame, member, CALIBRATED, pattern=self.residual_stress)
        inner, slowness = yielding_in_bending(strips, self.inner)
        return inner, frame.properties(member).plastic_moment * slowness, 0.0, False


@dataclass(frozen=True)
class ModifiedTangentModulus(FrameModel):
    """Plastic hinges on members whose modulus falls with the axial force."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
    points: int = POINTS()
    minor_weight: float = checked(
        Number(0.0, 1.0),
        0.0,
        help="of the moment beside the axial force: 0 for members that bend about their major "
        "axis, 0.65 about the minor one (whose second moment and plastic moment they must state)",
    )

    concentrated: ClassVar[bool] = False
    name: ClassVar[str] = "modified-tangent-modulus"
    version: ClassVar[int] = 2
    euler_share: ClassVar[float] = 1.0 / 16.0
    sources: ClassVar[tuple[str, ...]] = ("ziemian2002", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Modulus E min(1, (1 + 2p)(1 - p - w m)), p = N/Np, m = M/Mp, for what forces grow by "
        "beyond the largest so far; unloading is elastic.",
        "Perfectly plastic at the full plastic section, with normal flow.",
        *RESULTANTS,
    )

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of axial forces, at which the super-ellipse is off the section."""
        return super().limits(event) + hinge_limits.axial_findings(event.frame, LOSES)

    def group(self, cut: Cut) -> BarElements:
        """Elements with laws of N and M at Gauss-Lobatto points."""
        return resultant_group(self, cut)

    def law(self, frame: Frame, member: Member) -> tuple[float, float, float, bool]:
        """One surface, and a modulus that falls: entries as of `BoundingSurface`."""
        return 1.0, 0.0, self.minor_weight, True
