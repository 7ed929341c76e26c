"""Frames with one co-rotational superelement per member (Heng 2017, papers III and IV).

A superelement is a bar between two generalized hinges in one line: all share the axial force N,
and each hinge shares its end moment with the bar. Its local deformations against the chord,
q = (elongation, end rotations), and forces Q = (N, M1, M4) obey

    q = F Q + plastic deformations of both hinges,    (N, M_h) inside the yield surface of hinge h,

with the elastic flexibility F of hinges and bar. A rigid bar (paper IV) puts all elasticity into
the hinges, k_u = 2 EA/L and k_theta = 6 EI/L; a flexible one (paper III) has its own, and hinges
ten times as stiff. Backward Euler in both hinges is the closest-point projection of the elastic
trial forces onto both surfaces in the metric of F: forces are the unknowns, so that the case of
both hinges at their pure axial force, singular in the primal condensation of the papers, is none.

Mass is distributed (linear interpolation of the translations). The rigid bar also has rotary
inertia rho I L of its turning chord, the only inertia that depends on the configuration; the
flexible one has none. Time steps are energy-exact (midpoint of the forces, exact gradients).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from workbench.fields import Choice, Declared, Number, checked
from workbench.frames.answers import Stepping, answer
from workbench.frames.runs import OPEN_LEDGER
from workbench.frames.structure import FrameStructure
from workbench.frames.superelements import (
    HingeSurfaces,
    Piece,
    hinge_ends,
    series,
    stand_superelements,
)
from workbench.frames.timing import Spans, spans_to, time_to_peak, wave_times
from workbench.hinges import YieldSurface
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.responses import Finding, Response
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    Member,
    Scenario,
)
from workbench.structures.impact import INTEGRATORS, MIDPOINT, MOREAU
from workbench.structures.superelements import Superelement, sway_stiffness

PUSH_STEPS = 1000  # load steps over the range of a static path
PEAK_STEPS = 150.0  # time steps up to the expected peak
LEAST_STEPS = 100.0  # of a record
WEIGHT = 0.5  # of the end forces in a time step: conserves energy
INERTIAS = ("nonlinear", "linear", "none")
GEOMETRIES = ("co-rotational", "linear")
COMMON = (
    "All plasticity in hinges at the ends of the elements: an impacted member needs a node where "
    "it is hit.",
    "Elastic-perfectly plastic hinges with associated flow on a super-elliptic N-M surface; joints "
    "weaker than the member interact linearly.",
    "No shear deformation, no shear yielding, no local buckling, no strain-rate effect.",
)


@dataclass(frozen=True)
class _HingedBars(ABC, Declared, table="option"):
    """What both superelements do alike; each says what its bars are and explains the options."""

    alpha: float | None = checked(Number(1.0, 20.0), optional=True)
    beta: float | None = checked(Number(1.0, 20.0), optional=True)
    elements: int = checked(Number(1, 100, integer=True), 1)
    integrator: str = checked(Choice(INTEGRATORS), MIDPOINT)
    time_step: float | None = checked(Number(1e-8, 1.0, "s"), optional=True)
    node_inertia: float = checked(Number(0.0, 1e6, "kg m2"), 0.1)
    regularisation: float = checked(
        Number(0.0, 0.1, advice="a share of the elastic stiffness, 1e-6 by default"), 1e-6
    )
    geometry: str = checked(Choice(GEOMETRIES), "co-rotational")

    name: ClassVar[str]
    version: ClassVar[int]
    answers: ClassVar[tuple[str, ...]] = (
        FrameStatic.KIND,
        FrameImpact.KIND,
        FrameGroundMotion.KIND,
        ColumnImpact.KIND,
        ColumnPushover.KIND,
    )
    assumptions: ClassVar[tuple[str, ...]]
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings common to all member models."""
        return member_findings(scenario)

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a static loading, an impact or a motion of the ground, of a frame or a column."""
        return respond(self, scenario, self._solve)

    def member_surface(self, frame: Frame, member: Member) -> YieldSurface:
        """The yield surface of the hinges of a member, joints of its full strength."""
        return yield_surface(frame, member, self.alpha, self.beta)

    def structure(self, frame: Frame) -> FrameStructure:
        """The frame under its dead loads, ready to be loaded. Raises `SolverError`."""
        return stand_superelements(
            frame,
            self.elements,
            lambda member: self.member_surface(frame, member),
            self._piece,
            regularisation=self.regularisation,
            node_inertia=self.node_inertia,
            first_order=self.geometry == "linear",
        )

    @abstractmethod
    def _piece(self, piece: Piece, surfaces: HingeSurfaces) -> Superelement:
        """The superelement of a piece of a member."""

    def time_spans(self, scenario: FrameImpact) -> Spans:
        """End times and time steps (s) of the parts of the record.

        Steps longer than a wave takes along an element and back make its hinges ring, which
        softens them artificially. Rebounds need half the step.
        """
        duration = scenario.duration
        if self.time_step is not None:
            return [(duration, self.time_step)]
        wave = min(wave_times(scenario.frame))
        peak = time_to_peak(scenario)
        coarsest = min(duration / LEAST_STEPS, 2.0 * wave / self.elements)
        share = 1.0 if scenario.striker.restitution == 0.0 else 0.5
        return spans_to(peak, duration, peak / PEAK_STEPS, coarsest, share)

    def _solve(self, scenario: FrameScenario | ColumnScenario) -> Response:
        stepping = Stepping(
            PUSH_STEPS,
            self.time_spans,
            WEIGHT,
            self.integrator,
            self.time_step,
            largest_error=None if self.integrator == MOREAU else OPEN_LEDGER,
        )
        return answer(scenario, lambda told: self.structure(told.frame), stepping)


@dataclass(frozen=True)
class RigidSuperelement(_HingedBars):
    """Rigid bars between generalized hinges (Heng 2017, paper IV).

    Options: `alpha`, `beta`: exponents of the yield surface of moment and axial force (None:
    fitted to the exact N-M envelope of the section and stated to one decimal);
    `rotational_stiffness`, c of the hinge stiffness c EI/L (6: exact in sway; a member that ends
    in a pin gets half of it at the other end); `axial_stiffness`, c of c EA/L (2: exact);
    `elements` per member; `inertia` of the turning bar, nonlinear, linear (of the initial
    position) or none; `integrator`; `time_step` in s (None: 1/150 of the expected time to the
    peak, four times as long after six such times, at most the time of a wave along an element and
    back, half of that with restitution);
    `node_inertia`, rotary inertia of every node in kg m2: without it the rotation of a joint at
    which all hinges yield is indeterminate; `regularisation`, share of the elastic stiffness
    beside the perfectly plastic hinges; `geometry`, co-rotational or linear (equilibrium of the
    undeformed frame: first-order theory, for comparison).
    """

    rotational_stiffness: float = checked(Number(0.1, 1e6), 6.0)
    axial_stiffness: float = checked(Number(0.1, 1e6), 2.0)
    inertia: str = checked(Choice(INERTIAS), "nonlinear")

    name: ClassVar[str] = "rigid-superelement"
    version: ClassVar[int] = 2
    assumptions: ClassVar[tuple[str, ...]] = (
        "Rigid bars; all flexibility in hinges of 6EI/L: exact in sway, three times too stiff "
        "under uniform bending.",
        *COMMON,
    )

    def check(self) -> None:
        """Refuse a scheme that has no place for the inertia."""
        if self.integrator == MOREAU and self.inertia == "nonlinear":
            text = "has no place for rotary inertia that turns with the bars"
            advice = "take inertia = linear or none, or another integrator"
            raise self.refusal("integrator", text, advice)

    def _piece(self, piece: Piece, surfaces: HingeSurfaces) -> Superelement:
        factor = self.rotational_stiffness / 6.0
        bending = sway_stiffness(piece.length, factor * piece.bending, piece.pins)
        axial = self.axial_stiffness * piece.axial / piece.length
        return Superelement(
            *hinge_ends(piece, surfaces, axial, bending),
            mass_per_length=piece.mass,
            rotary_inertia=piece.rotary,
            rotation_inertia=self.inertia,
        )


@dataclass(frozen=True)
class FlexibleSuperelement(_HingedBars):
    """Elastic beams between generalized hinges (Heng 2017, paper III).

    Options: `alpha`, `beta`: exponents of the yield surface of moment and axial force (None:
    fitted to the exact N-M envelope of the section and stated to one decimal); `hinge_stiffness`,
    n of the hinges' n 2EA/L and n 6EI/L (100 and more: rigid-plastic hinges); `elements` per
    member; `integrator`; `time_step` in s (None: 1/150 of the expected time to the peak, four
    times as long after six such times, at most the time of a wave along an element and back, half
    of that with restitution);
    `node_inertia`, rotary inertia of every node in kg m2; `regularisation`, share of the elastic
    stiffness beside the perfectly plastic hinges; `geometry`, co-rotational or linear (equilibrium
    of the undeformed frame: first-order theory, for comparison).
    """

    hinge_stiffness: float = checked(Number(0.1, 1e9), 10.0)

    name: ClassVar[str] = "flexible-superelement"
    version: ClassVar[int] = 1
    assumptions: ClassVar[tuple[str, ...]] = (
        "Elastic Bernoulli beams, straight against their chord: one element per member leaves out "
        "P-delta inside the member.",
        "No rotary inertia of the beams.",
        *COMMON,
    )

    def _piece(self, piece: Piece, surfaces: HingeSurfaces) -> Superelement:
        n = self.hinge_stiffness
        axial = n * 2.0 * piece.axial / piece.length
        stiffness = n * 6.0 * piece.bending / piece.length
        bending = tuple(series(stiffness, joint.rotational_stiffness) for joint in piece.joints)
        return Superelement(
            *hinge_ends(piece, surfaces, axial, (bending[0], bending[1])),
            axial_stiffness=piece.axial,
            bending_stiffness=piece.bending,
            flexible=True,
            mass_per_length=piece.mass,
        )


def yield_surface(
    frame: Frame, member: Member, alpha: float | None, beta: float | None
) -> YieldSurface:
    """The yield surface of a member; exponents that are None are fitted to its section."""
    properties = frame.properties(member)
    fitted = YieldSurface.fit(frame.strength_section(member), frame.steel, decimals=1)
    return YieldSurface(
        properties.squash_load,
        properties.plastic_moment,
        fitted.alpha if alpha is None else alpha,
        fitted.beta if beta is None else beta,
    )
