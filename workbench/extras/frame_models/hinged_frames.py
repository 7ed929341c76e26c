"""Frames of elastic beam-columns with plastic hinges at their ends (Heng 2017, section 2.2).

`giberson` knows bending alone: each hinge is a rotational spring, rigid up to the plastic moment
and from there f times as stiff as the end of the beam, 4 EI / L. `plastic-hinge` takes the hinge
from a yield surface of axial force and moment, with normal flow, and lets the axial force bend the
member between its ends. `refined-plastic-hinge` loses stiffness by degrees. Derivation:
docs/theory/frame-models.md.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any, ClassVar, TypeAlias, cast

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Choice, Flag, Number, checked
from workbench.extras.frame_models import hinge_limits
from workbench.extras.frame_models.bars import (
    NO_INTERACTION,
    Bar,
    BarElements,
    PlasticEnd,
    hinged_bars,
    refined_bars,
)
from workbench.mechanics.frames.members import CALIBRATED, fiber_section, shear_stiffness
from workbench.mechanics.frames.structure import Cut, FrameStructure, Piece, joint_surface, series
from workbench.mechanics.structures.fibers.section import spread_of_yield
from workbench.models.frame_model import (
    ELEMENTS,
    GEOMETRY,
    REGULARISATION,
    TIME_STEP,
    FrameModel,
    as_frame,
)
from workbench.responses import Finding, Response, findings_of, set_findings
from workbench.scenarios import ColumnScenario, FrameScenario
from workbench.steel.hinges import YieldSurface
from workbench.steel.hinges.interaction import RULES, polyline
from workbench.steel.sections.slenderness import rotation_capacity

IMPERFECT = 0.877  # AISC 360, E3: strength of a slender column over its Euler load
STRAIGHT = np.array([[0.0, 1.0], [1.0, 0.0]])  # share of the moment that is left over |N|
Ends = Callable[[Piece, int], PlasticEnd]

# options of several models, each declared by a model in a line
SHEAR_FLEXIBLE = partial(checked, Flag(), True, help="elastic shear strain of members")
SURFACE = partial(checked, Choice(RULES), "exact", help="rule of N-M interaction")
DEGRADATION = partial(
    checked,
    Choice(("none", "energy")),
    "none",
    help="loss of strength and stiffness by the energy that a hinge dissipates in bending, all "
    "of it at M_p times rotation_capacity",
)
ROTATION_CAPACITY = partial(
    checked, Number(1e-3, 1e3, "rad"), optional=True, help="None: that of tests of I sections"
)


def plastic_end(
    piece: Piece, side: int, rule: str = "exact", of_joint: Array | None = None
) -> PlasticEnd:
    """The weaker of member and joint at one end of a piece, `side` 0 or 1.

    N and M interact by a `rule`, or by the curve `of_joint` where that is the weaker one.
    """
    joint = piece.joints[side]
    surface = YieldSurface(piece.properties.squash_load, piece.properties.plastic_moment)
    weaker = joint_surface(surface, joint)
    curve = polyline(rule, piece.section)
    if of_joint is not None and weaker != surface:
        curve = of_joint
    spring = series(joint.rotational_stiffness)
    return PlasticEnd(weaker.axial_bounds, weaker.moment_bounds, curve, spring)


def plastic_bars(
    model: Any, cut: Cut, end: Ends = plastic_end, second_order: bool = False
) -> list[Bar]:
    """Beam-columns with a plastic `end` at either end of every piece.

    Arguments: the `model`, of whose options they are; whether N bends a bar between its ends
    (`second_order`).
    """
    bars = []
    for piece in cut.pieces:
        shear = shear_stiffness(piece.section, cut.frame.steel) if model.shear_flexible else inf
        soft = 1.0 / series(*(joint.axial_stiffness for joint in piece.joints))
        elastic = piece.axial, piece.bending, piece.properties.mass_per_length, shear, soft
        bent = second_order and not model.first_order
        bars.append(Bar(end(piece, 0), end(piece, 1), *elastic, bent))
    return bars


def hinged_group(model: Any, cut: Cut, end: Ends, second_order: bool = True) -> BarElements:
    """Bars with hinges of zero length, see `plastic_bars`."""
    bars = plastic_bars(model, cut, end, second_order)
    return hinged_bars(cut.nodes, bars, model.regularisation, model.first_order)


@dataclass(frozen=True)
class Giberson(FrameModel):
    """Giberson's one-component beam: two rotational springs on an elastic beam."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
    ratio: float = checked(
        Number(0.0, 10.0), 0.0, help="f of a spring that flows, over 4 EI/L; 0: perfectly plastic"
    )

    name: ClassVar[str] = "giberson"
    version: ClassVar[int] = 5
    unused: ClassVar[tuple[str, ...]] = ("joint.*_resistance",)
    sources: ClassVar[tuple[str, ...]] = ("giberson1967", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Elastic beam between two rotational springs: rigid up to the plastic moment, then of "
        "kinematic hardening f 4EI/L.",
        "No interaction: the axial force is elastic without bound and takes no moment away, so "
        "that catenary action never yields.",
        "Chords move and turn by any amount; the axial force does not bend the beam between its "
        "ends.",
    )

    def group(self, cut: Cut) -> BarElements:
        """Bars with springs at their ends."""
        return hinged_group(self, cut, self._end, second_order=False)

    def _end(self, piece: Piece, side: int) -> PlasticEnd:
        """A spring that flows has the stiffness f 4 EI / L (Heng 2017, equations 2.4, 2.5)."""
        stiffness = self.ratio * 4.0 * piece.bending / (piece.parts * piece.length)
        end = plastic_end(piece, side)
        return replace(end, curve=NO_INTERACTION, hardening=stiffness)

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of catenary action and of axial forces, which hinges do not know."""
        effect = "hinges without N-M interaction overestimate its resistance by nearly that share"
        known = hinge_limits.catenary_findings(event)
        return super().limits(event) + known + hinge_limits.axial_findings(event.frame, effect)


Wearing: TypeAlias = "PlasticHinge | QuasiPlasticHinge"


def worn_end(model: Wearing, piece: Piece, side: int) -> PlasticEnd:
    """The end of a piece by the rule of the model, straight for a weaker joint, which may wear."""
    end = plastic_end(piece, side, model.surface, STRAIGHT)
    if model.degradation == "none":
        return end
    rotation = model.rotation_capacity or rotation_capacity(piece.member.section, piece.frame.steel)
    sway = piece.parts * piece.length / (6.0 * piece.bending)  # of a member in double curvature
    return replace(end, rotation=rotation, softness=sway)


def wear_sources(model: Wearing) -> tuple[str, ...]:
    """Bibliography keys of a model and of wear."""
    return *model.papers, *(("rahnama1993", "lignos2011") if model.degradation != "none" else ())


def check_wear(model: Wearing) -> None:
    """Refuse a capacity that nothing spends. Raises `InputError`."""
    if model.rotation_capacity is not None and model.degradation == "none":
        raise model.refusal("rotation_capacity", "has no effect without degradation = energy")


def wear_findings(model: Wearing, event: FrameScenario) -> list[Finding]:
    """Findings of hinges that wear, if they do."""
    known = model.rotation_capacity is not None
    return hinge_limits.wear_findings(event, known) if model.degradation != "none" else []


def with_wear(model: Wearing, response: Response, structure: FrameStructure) -> Response:
    """The response with the least share of its strength that a hinge has left."""
    if model.degradation != "none":
        left = cast(BarElements, structure.members.elements).strength_left
        response.attrs["least_strength"] = float(left.min())
    return response


@dataclass(frozen=True)
class PlasticHinge(FrameModel):
    """Plastic hinges on a yield surface: elastic and geometric less plastic reduction matrix."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
    surface: str = SURFACE()
    degradation: str = DEGRADATION()
    rotation_capacity: float | None = ROTATION_CAPACITY()

    name: ClassVar[str] = "plastic-hinge"
    version: ClassVar[int] = 6
    papers: ClassVar[tuple[str, ...]] = ("orbison1982", "heng2017")
    euler_share: ClassVar[float] = 0.9
    assumptions: ClassVar[tuple[str, ...]] = (
        "Elastic up to the full plastic section, perfectly plastic hinges of zero length at the "
        "ends: yielding does not spread, and nothing softens before.",
        "Normal flow on the chosen surface (its convex hull); joints weaker than the member "
        "interact linearly.",
        "Exact stability functions between the ends, with the shortening by bending.",
        "No shear yielding, no local buckling; strain rate by one factor.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model and of the options that are on."""
        return wear_sources(self)

    def check(self) -> None:
        """Refuse a capacity that nothing spends."""
        check_wear(self)

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of hinges that wear."""
        return super().limits(event) + wear_findings(self, event)

    def group(self, cut: Cut) -> BarElements:
        """Bars with hinges at their ends."""
        return hinged_group(self, cut, partial(worn_end, self))

    def run(self, scenario: FrameScenario, structure: FrameStructure) -> Response:
        """Run as in `FrameModel`; adds the least share of its strength that a hinge has left."""
        return with_wear(self, super().run(scenario, structure), structure)


@dataclass(frozen=True)
class QuasiPlasticHinge(FrameModel):
    """Quasi-plastic hinges: plastic rotations of spreading yield, calibrated on fibers."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
    surface: str = SURFACE()
    degradation: str = DEGRADATION()
    rotation_capacity: float | None = ROTATION_CAPACITY()

    concentrated: ClassVar[bool] = False
    euler_share: ClassVar[float] = 0.9
    name: ClassVar[str] = "quasi-plastic-hinge"
    version: ClassVar[int] = 7
    papers: ClassVar[tuple[str, ...]] = ("attalla1994", "heng2017")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Hinges yield first where the outermost fiber does and harden to the full section as the "
        "plastic zone of a linear moment with its zero half-way spreads; flow normal to the "
        "surface reached.",
        "Isotropic: after a reversal an end is elastic up to the moment that it has reached.",
        "No residual stress, no shear yielding, no local buckling; strain rate by one factor.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the model and of the options that are on."""
        return wear_sources(self)

    def check(self) -> None:
        """Refuse a capacity that nothing spends."""
        check_wear(self)

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of repeated loading and of hinges that wear."""
        effect = "after the first full hinge of an end its yielding is sudden, as in the plastic "
        cycles = hinge_limits.cycle_findings(event, effect + "hinge")
        return super().limits(event) + cycles + wear_findings(self, event)

    def group(self, cut: Cut) -> BarElements:
        """Bars with hinges at their ends."""
        return hinged_group(self, cut, self._end)

    def _end(self, piece: Piece, side: int) -> PlasticEnd:
        frame = piece.frame
        section = fiber_section(frame, piece.member, CALIBRATED)
        first, rotation, hardened = spread_of_yield(section)
        strain = frame.steel.yield_stress / frame.steel.elastic_modulus
        turn = 0.5 * piece.parts * piece.length * strain / float(np.max(section.y))
        spread = np.stack([turn * rotation, hardened])
        return replace(worn_end(self, piece, side), first_yield=first, spread=spread)

    def run(self, scenario: FrameScenario, structure: FrameStructure) -> Response:
        """Run as in `FrameModel`; adds the least share of its strength that a hinge has left."""
        return with_wear(self, super().run(scenario, structure), structure)


@dataclass(frozen=True)
class RefinedPlasticHinge(FrameModel):
    """Refined plastic hinges: stability functions, tangent modulus, stiffness lost by degrees."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    shear_flexible: bool = SHEAR_FLEXIBLE()
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

    def group(self, cut: Cut) -> BarElements:
        """Bars that soften by degrees; their stability functions hold beyond the load of a bar."""
        reduction, double = IMPERFECT if self.imperfect else 1.0, self.modulus == "double"
        bars = plastic_bars(self, cut, self._end, second_order=True)
        numbers = reduction, double, self.regularisation, self.first_order
        return refined_bars(cut.nodes, bars, *numbers)

    def limits(self, event: FrameScenario) -> list[Finding]:
        """Also of axial forces and cycles, which hinges know less of, and of plates that buckle."""
        loses = "hinges then soften from small moments on, and give way too much"
        softens = (
            "hinges soften anew in every half-cycle above half the strength, also where a section "
            "would stay elastic"
        )
        return [
            *super().limits(event),
            *hinge_limits.catenary_findings(event),
            *hinge_limits.axial_findings(event.frame, loses),
            *hinge_limits.cycle_findings(event, softens),
            *(hinge_limits.class_findings(event.frame) if self.local_buckling else []),
        ]

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

    def _end(self, piece: Piece, side: int) -> PlasticEnd:
        end = plastic_end(piece, side, "aisc")  # H1-1, for members and joints
        if self.local_buckling:
            return hinge_limits.buckled_end(end, piece.frame, piece.member)
        return end
