"""Frames of elastic beam-columns with plastic hinges at their ends (Heng 2017, section 2.2).

`giberson` knows bending alone: each hinge is a rotational spring, rigid up to the plastic moment
and from there f times as stiff as the end of the beam, 4 EI / L. `plastic-hinge` takes the hinge
from a yield surface of axial force and moment, with normal flow, and lets the axial force bend the
member between its ends. `refined-plastic-hinge` loses stiffness by degrees. Derivation:
docs/theory/frame-models.md.
"""

from dataclasses import dataclass, replace
from math import inf, pi
from typing import ClassVar, NamedTuple, cast

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Choice, Flag, Number, checked
from workbench.mechanics.frames.members import CALIBRATED, fiber_section, shear_stiffness
from workbench.mechanics.frames.structure import (
    FrameStructure,
    Piece,
    cut_members,
    joint_surface,
    series,
)
from workbench.mechanics.structures.bars import (
    NO_INTERACTION,
    Bar,
    BarElements,
    PlasticEnd,
    hinged_bars,
    refined_bars,
)
from workbench.mechanics.structures.fibers.section import spread_of_yield
from workbench.models import hinge_limits
from workbench.models.bar_frames import BarFrames, Cut
from workbench.models.frame_model import as_frame
from workbench.responses import Finding, Response, finding, findings_of, set_findings
from workbench.scenarios import (
    ColumnScenario,
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameScenario,
    FrameStatic,
)
from workbench.steel.hinges import YieldSurface
from workbench.steel.hinges.interaction import RULES, polyline
from workbench.steel.sections.slenderness import rotation_capacity

IMPERFECT = 0.877  # AISC 360, E3: strength of a slender column over its Euler load
NO_MOMENT_LOST = 0.25  # of the squash load, tension of a run; EN 1993-1-1, 6.2.9.1 (4)


class Traits(NamedTuple):
    """Differences between models of plastic ends.

    `interaction`, the rule of N and M; `second_order`, whether N bends a bar between its ends;
    `euler_share` of a pin-ended bar, below which elements keep its squash load (0: any); whether a
    hinge `stretches` plastically as it flows; what dead loads do that the model does not know,
    `loses_moment`, and repeated loading, `in_cycles` ("": nothing).
    """

    interaction: str = "exact"
    second_order: bool = True
    euler_share: float = 0.9
    stretches: bool = True
    loses_moment: str = ""
    in_cycles: str = ""


@dataclass(frozen=True)
class BarHinges(BarFrames):
    """Beam-columns with plastic ends."""

    shear_flexible: bool = checked(Flag(), True, help="elastic shear strain of members")

    traits: ClassVar[Traits] = Traits()

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings of all member models, and of events that a model is not made for."""
        event, findings, traits = as_frame(scenario), [], self.traits
        if isinstance(event, FrameImpact) and not traits.stretches:
            reach = hinge_limits.catenary_reach(event)
            if reach > hinge_limits.CATENARY:
                findings.append(finding("catenary", reach, reach=reach))
        if traits.loses_moment:
            findings += hinge_limits.axial_findings(event.frame, traits.loses_moment)
        cyclic = isinstance(event, FrameStatic) and len(event.path) > 1
        if traits.in_cycles and (cyclic or isinstance(event, FrameGroundMotion)):
            findings.append(finding("cycles", effect=traits.in_cycles))
        return super().domain(scenario) + findings

    def settled(self, scenario: FrameImpact, response: Response) -> set[str]:
        """Also catenary action, which joints that give way may have kept from any member."""
        squash = np.repeat(scenario.frame.each("squash_load"), 2)
        tension = response["axial_force"].values / squash[:, None]
        pulled = float(np.max(tension)) > NO_MOMENT_LOST
        return super().settled(scenario, response) | (set() if pulled else {"catenary"})

    def parts(self, scenario: FrameScenario) -> list[int]:
        """Bars per member: `elements`, and more where the squash load nears the Euler load."""
        frame, counts = scenario.frame, super().parts(scenario)
        if not self.traits.euler_share:
            return counts
        euler = self.traits.euler_share * pi**2 * frame.steel.elastic_modulus  # times I / L^2
        slenderness = frame.each("squash_load") / (euler * frame.each("second_moment"))
        fewest = np.ceil(frame.lengths * np.sqrt(slenderness)).astype(int)
        return [max(pair) for pair in zip(counts, fewest.tolist(), strict=True)]

    def structure(self, scenario: FrameScenario | ColumnScenario) -> FrameStructure:
        """The frame, or the column as one, under its dead loads. Raises `SolverError`."""
        event = as_frame(scenario)
        frame, parts = event.frame, self.parts(event)
        cut = cut_members(frame, parts)
        group = self.group(frame, cut, [self._bar(frame, piece) for piece in cut[2]])
        return self.stand(frame, cut, group, parts)

    def _bar(self, frame: Frame, piece: Piece) -> Bar:
        section = frame.strength_section(piece.member)
        return Bar(
            self._end(frame, piece, 0),
            self._end(frame, piece, 1),
            *(piece.axial, piece.bending, piece.mass),
            shear_stiffness(section, frame.steel) if self.shear_flexible else inf,
            1.0 / series(*(joint.axial_stiffness for joint in piece.joints)),
            self.traits.second_order and not self.first_order,
        )

    def _end(self, frame: Frame, piece: Piece, side: int) -> PlasticEnd:
        properties, joint = frame.properties(piece.member), piece.joints[side]
        surface = YieldSurface(properties.squash_load, properties.plastic_moment)
        weaker = joint_surface(surface, joint)
        curve, spring = self.curve(frame, piece, weaker != surface), joint.rotational_stiffness
        return PlasticEnd(weaker.axial_bounds, weaker.moment_bounds, curve, series(spring))

    def curve(self, frame: Frame, piece: Piece, joint_governs: bool) -> Array:
        """Share of the moment left over |N| over its resistance (2, corners)."""
        return polyline(self.traits.interaction, frame.strength_section(piece.member))

    def group(self, frame: Frame, cut: Cut, bars: list[Bar]) -> BarElements:
        """The elements."""
        return hinged_bars(cut[1], bars, self.regularisation, self.first_order)


@dataclass(frozen=True)
class Giberson(BarHinges):
    """Giberson's one-component beam: two rotational springs on an elastic beam."""

    ratio: float = checked(
        Number(0.0, 10.0), 0.0, help="f of a spring that flows, over 4 EI/L; 0: perfectly plastic"
    )

    name: ClassVar[str] = "giberson"
    version: ClassVar[int] = 5
    unused: ClassVar[tuple[str, ...]] = ("joint.*_resistance",)
    sources: ClassVar[tuple[str, ...]] = ("giberson1967", "heng2017")
    traits: ClassVar[Traits] = Traits(
        second_order=False,
        euler_share=0.0,
        stretches=False,
        loses_moment="hinges without N-M interaction overestimate its resistance by nearly that "
        "share",
    )
    assumptions: ClassVar[tuple[str, ...]] = (
        "Elastic beam between two rotational springs: rigid up to the plastic moment, then of "
        "kinematic hardening f 4EI/L.",
        "No interaction: the axial force is elastic without bound and takes no moment away, so "
        "that catenary action never yields.",
        "Chords move and turn by any amount; the axial force does not bend the beam between its "
        "ends.",
    )

    def curve(self, frame: Frame, piece: Piece, joint_governs: bool) -> Array:
        """All of the moment, whatever N is."""
        return NO_INTERACTION

    def _end(self, frame: Frame, piece: Piece, side: int) -> PlasticEnd:
        """A spring that flows has the stiffness f 4 EI / L (Heng 2017, equations 2.4, 2.5)."""
        stiffness = self.ratio * 4.0 * piece.bending / (piece.parts * piece.length)
        return replace(super()._end(frame, piece, side), hardening=stiffness)


@dataclass(frozen=True)
class PlasticHinge(BarHinges):
    """Plastic hinges on a yield surface: elastic and geometric less plastic reduction matrix."""

    surface: str = checked(Choice(RULES), "exact", help="rule of N-M interaction")
    degradation: str = checked(
        Choice(("none", "energy")),
        "none",
        help="loss of strength and stiffness by the energy that a hinge dissipates in bending, all "
        "of it at M_p times rotation_capacity",
    )
    rotation_capacity: float | None = checked(
        Number(1e-3, 1e3, "rad"), optional=True, help="None: that of tests of I sections"
    )

    name: ClassVar[str] = "plastic-hinge"
    version: ClassVar[int] = 5
    papers: ClassVar[tuple[str, ...]] = ("orbison1982", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Elastic up to the full plastic section, perfectly plastic hinges of zero length at the "
        "ends: yielding does not spread, and nothing softens before.",
        "Normal flow on the chosen surface (its convex hull); joints weaker than the member "
        "interact linearly.",
        "Exact stability functions between the ends, with the shortening by bending.",
        "No shear yielding, no local buckling; strain rate by one factor.",
    )

    def curve(self, frame: Frame, piece: Piece, joint_governs: bool) -> Array:
        """The rule for the section, a straight line for a weaker joint."""
        if joint_governs:
            return np.array([[0.0, 1.0], [1.0, 0.0]])
        return polyline(self.surface, frame.strength_section(piece.member))

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model and of the options that are on."""
        wear = ("rahnama1993", "lignos2011") if self.degradation != "none" else ()
        return (*self.papers, *wear)

    def check(self) -> None:
        """Refuse a capacity that nothing spends."""
        if self.rotation_capacity is not None and self.degradation == "none":
            raise self.refusal("rotation_capacity", "has no effect without degradation = energy")

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Also of hinges that wear."""
        known = self.rotation_capacity is not None
        wears = self.degradation != "none"
        return super().domain(scenario) + (
            hinge_limits.wear_findings(as_frame(scenario), known) if wears else []
        )

    def _end(self, frame: Frame, piece: Piece, side: int) -> PlasticEnd:
        end = super()._end(frame, piece, side)
        if self.degradation == "none":
            return end
        rotation = self.rotation_capacity or rotation_capacity(piece.member.section, frame.steel)
        sway = piece.parts * piece.length / (6.0 * piece.bending)  # of a member in double curvature
        return replace(end, rotation=rotation, softness=sway)

    def run(self, scenario: FrameScenario, structure: FrameStructure) -> Response:
        """Run as in `FrameModel`; adds the least share of its strength that a hinge has left."""
        response = super().run(scenario, structure)
        if self.degradation != "none":
            left = cast(BarElements, structure.members.elements).strength_left
            response.attrs["least_strength"] = float(left.min())
        return response


@dataclass(frozen=True)
class QuasiPlasticHinge(PlasticHinge):
    """Quasi-plastic hinges: plastic rotations of spreading yield, calibrated on fibers."""

    concentrated: ClassVar[bool] = False
    name: ClassVar[str] = "quasi-plastic-hinge"
    version: ClassVar[int] = 6
    papers: ClassVar[tuple[str, ...]] = ("attalla1994", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Hinges yield first where the outermost fiber does and harden to the full section as the "
        "plastic zone of a linear moment with its zero half-way spreads; flow normal to the "
        "surface reached.",
        "Isotropic: after a reversal an end is elastic up to the moment that it has reached.",
        "No residual stress, no shear yielding, no local buckling; strain rate by one factor.",
    )
    traits: ClassVar[Traits] = Traits(
        in_cycles="after the first full hinge of an end its yielding is sudden, as in the plastic "
        "hinge"
    )

    def _end(self, frame: Frame, piece: Piece, side: int) -> PlasticEnd:
        section = fiber_section(frame, piece.member, CALIBRATED, 0.0)
        first, rotation, hardened = spread_of_yield(section)
        end = super()._end(frame, piece, side)
        strain = frame.steel.yield_stress / frame.steel.elastic_modulus
        turn = 0.5 * piece.parts * piece.length * strain / float(np.max(section.y))
        return replace(end, first_yield=first, spread=np.stack([turn * rotation, hardened]))


@dataclass(frozen=True)
class RefinedPlasticHinge(BarHinges):
    """Refined plastic hinges: stability functions, tangent modulus, stiffness lost by degrees."""

    imperfect: bool = checked(
        Flag(), False, help="0.877 E: the tangent modulus is that of the AISC column curve"
    )
    modulus: str = checked(
        Choice(("tangent", "double")), "tangent", help="double where the strain of a flange falls"
    )
    local_buckling: bool = checked(Flag(), False, help="strength by the classes of EN 1993-1-1")
    unbraced_length: float | None = checked(
        Number(0.01, 1e3, "m"),
        optional=True,
        help="between lateral restraints, to check lateral-torsional buckling (None: unchecked)",
    )

    concentrated: ClassVar[bool] = False
    name: ClassVar[str] = "refined-plastic-hinge"
    version: ClassVar[int] = 7
    traits: ClassVar[Traits] = Traits(
        interaction="aisc",  # H1-1, for members and joints
        euler_share=0.0,  # stability functions hold beyond the load of a bar
        stretches=False,
        in_cycles="hinges soften anew in every half-cycle above half the strength, also where a "
        "section would stay elastic",
        loses_moment="hinges then soften from small moments on, and give way too much",
    )
    assumptions: ClassVar[tuple[str, ...]] = (
        "Hinges soften by degrees from a force state of 1/2 on, phi = 4 alpha (1 - alpha), to full "
        "hinges on the AISC surface; an end whose force state falls is elastic.",
        "Residual stress and crookedness through a tangent modulus that depends on the "
        "compression alone.",
        "Moments return to the surface without normal flow: in catenary action the axial force "
        "wins and moments vanish.",
        "No shear yielding; local buckling by class alone, if asked; strain rate by one factor.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model and of the options that are on."""
        keys = ["liew1993", "heng2017", *(["engesser1895"] if self.modulus == "double" else [])]
        keys += ["en1993-1-1"] if self.local_buckling or self.unbraced_length else []
        return (*keys, *(["en1993-1-5"] if self.local_buckling else []))

    def group(self, frame: Frame, cut: Cut, bars: list[Bar]) -> BarElements:
        """The elements."""
        reduction, double = IMPERFECT if self.imperfect else 1.0, self.modulus == "double"
        return refined_bars(cut[1], bars, reduction, double, self.regularisation, self.first_order)

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Also of plates that buckle."""
        more = hinge_limits.class_findings(as_frame(scenario).frame) if self.local_buckling else []
        return super().domain(scenario) + more

    def solve(self, scenario: FrameScenario | ColumnScenario) -> Response:
        """Also check members against lateral-torsional buckling under the moments of the run."""
        response = super().solve(scenario)
        if self.unbraced_length:
            frame, moments = as_frame(scenario).frame, response["moment"].values
            lateral = hinge_limits.lateral_findings(
                frame, moments, self.unbraced_length, self.local_buckling
            )
            set_findings(response, [*findings_of(response), *lateral])
        return response

    def _end(self, frame: Frame, piece: Piece, side: int) -> PlasticEnd:
        end = super()._end(frame, piece, side)
        if self.local_buckling:
            return hinge_limits.buckled_end(end, frame, piece.member)
        return end
