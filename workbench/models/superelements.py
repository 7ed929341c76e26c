"""Frames with one co-rotational superelement per member (Heng 2017, papers III and IV).

A superelement is a bar between two generalized hinges in one line: all share the axial force N,
and each hinge shares its end moment with the bar. Its local deformations against the chord,
q = (elongation, end rotations), and forces Q = (N, M1, M4) obey

    q = F Q + plastic deformations of both hinges,    (N, M_h) inside the yield surface of hinge h,

with the elastic flexibility F of hinges and bar. A rigid bar (paper IV) puts all elasticity into
the hinges, k_u = 2 EA/L and k_theta = 6 EI/L; a flexible one (paper III) has its own, and hinges
ten times as stiff. Projection, inertia and time steps: docs/theory/superelements.md.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import ceil, inf
from typing import Any, ClassVar, NamedTuple

from workbench.base.errors import OutOfDomainError, SolverError
from workbench.base.fields import Choice, Number, checked
from workbench.mechanics.frames.elastic import wave_times
from workbench.mechanics.frames.members import named, shear_findings
from workbench.mechanics.frames.runs import measure_impact, run_impact
from workbench.mechanics.frames.struck import StruckNumbers, StruckRecord, strike
from workbench.mechanics.frames.structure import (
    Cut,
    FrameStructure,
    HingeSurfaces,
    Piece,
    curvature_shares,
    hinge_ends,
    joint_surface,
    series,
    softened,
)
from workbench.mechanics.impact.pace import Pace
from workbench.mechanics.structures.superelements import Superelement, Superelements, sway_stiffness
from workbench.models.batch import admitted
from workbench.models.domain import DIRECT_SHEAR, given_strength, web_findings, web_of
from workbench.models.frame_model import (
    ELEMENTS,
    GEOMETRY,
    LEAST_STEPS,
    REGULARISATION,
    TIME_STEP,
    Clock,
    FrameModel,
    as_frame,
)
from workbench.models.strain_rate import (
    FACTOR,
    RATE_LEVELS,
    about_bars,
    check_bars,
    flows,
    laws_of,
)
from workbench.responses import Finding, Response, finding
from workbench.scenarios import (
    ColumnImpact,
    ColumnScenario,
    Frame,
    FrameImpact,
    FramePulse,
    FrameScenario,
    Member,
)
from workbench.steel.hinges import ShearSurface, YieldSurface
from workbench.steel.hinges.interaction import fitted_exponents

ACCURACY = 1e-3  # of the peak, with the numbers that follow and the longest step
# errors of a step, see `Pace`; square root of what hinges settle by over the energy brought in
CONTROL = (1e-4, 1.2e-2, 0.01)
FIRST = 0.005  # step after an impact over the time of an axial wave along an element
RECORDS, MOST_STEPS = 20_000, 10_000_000  # of a run, at most
_surface = lru_cache(maxsize=256)(YieldSurface)
INERTIAS = ("nonlinear", "linear", "none")
COMMON = (
    "All plasticity in hinges at the ends of the elements: an impacted member needs a node where "
    "it is hit.",
    "Elastic-perfectly plastic hinges with associated flow on a super-elliptic N-M surface; joints "
    "weaker than the member interact linearly.",
    "Webs of I, box and tube sections deform and yield in shear (option shear = panel), with the "
    "N-M-V domain of the plates at both ends, root fillets in the flanges; beside joints weaker "
    "than the member, and in other sections, members are rigid in shear; with a given strength "
    "their webs are elastic.",
    "No local buckling; strain rate by one factor, or, with rate_level = bars, rate and hardening "
    "at every point of the bars, of flanges and web apart where webs yield.",
)


# options of both models, each declared by a model in a line
EXPONENT = partial(checked, Number(1.0, 20.0), optional=True)
SHEAR = partial(checked, Choice(("panel", "elastic", "none")), "panel")
SHARE = partial(checked, Number(1e-5, 0.1, advice="a share of the peak, 1e-3 by default"), ACCURACY)
RATE_LEVEL = partial(checked, Choice(RATE_LEVELS), FACTOR)


class Webs(NamedTuple):
    """Webs of the members of a frame that yield in shear, by name, and findings about them.

    None of members which are rigid in shear, or given another strength than their web has.
    """

    yielding: dict[str, ShearSurface | None]
    findings: list[Finding]


@lru_cache(maxsize=64)
def webs_of(model: "SuperelementModel", frame: Frame) -> Webs:
    """The webs of a frame, kept for many strikers."""
    webs, given = {}, []
    for m in frame.members:
        web = web_of(frame.strength_section(m), frame.steel) if model.shear_yields else None
        if web is not None and given_strength(web, frame.properties(m)):
            given.append(m.name)
            web = None
        webs[m.name] = web
    findings = about_bars(frame) if flows(model, frame.steel) else []
    if any(webs.values()) and not (model.alpha is None and model.beta is None):
        findings.append(finding("exponents"))
    findings += web_findings(webs)
    if given:
        findings.append(finding("given-strength", members=named(given)))
    return Webs(webs, findings)


def about_webs(
    model: "SuperelementModel", scenario: FrameScenario | ColumnScenario, findings: list[Finding]
) -> list[Finding]:
    """Findings of a domain, of shear only where members are rigid in it, and those of webs."""
    event = as_frame(scenario)
    webs = webs_of(model, event.frame)
    rigid = {name for name, web in webs.yielding.items() if web is None}
    if len(rigid) < len(event.frame.members):
        known = ("shear", DIRECT_SHEAR if getattr(event, "members", ()) else "")
        findings = [finding for finding in findings if finding.subject not in known]
        findings += shear_findings(event, rigid) if rigid else []
    return findings + webs.findings


def ellipse(model: "SuperelementModel", frame: Frame, member: Member) -> YieldSurface:
    """Yield surface of a member which is rigid in shear."""
    properties = frame.properties(member)
    alpha, beta = fitted_exponents(frame.strength_section(member), decimals=1)
    exponents = model.alpha or alpha, model.beta or beta
    return _surface(properties.squash_load, properties.plastic_moment, *exponents)


def pace_of(model: Any, scenario: FrameImpact) -> Pace:
    """How an impact is stepped through: by the error, or with `time_step`."""
    duration, spacing = scenario.duration, (1.0 - 1e-6) * scenario.duration / RECORDS
    waves = zip(wave_times(scenario.frame), model.parts(scenario), strict=True)
    share = model.accuracy / ACCURACY
    first = share * FIRST * min(wave / parts for wave, parts in waves)
    if model.time_step is not None:
        step = duration / ceil(duration / model.time_step - 1e-9)
        return Pace(duration, min(first, step), step, inf, inf, inf, spacing, MOST_STEPS)
    longest = share**0.5 * duration / LEAST_STEPS  # an error of second order
    error, vibration, flow = (share * each for each in CONTROL)
    first = min(first, longest)
    return Pace(duration, first, longest, error, vibration, flow, spacing, MOST_STEPS)


def march(
    model: Any,
    scenario: FrameImpact,
    structure: FrameStructure,
    timed: Callable[[Iterator[Any]], Iterator[Any]],
) -> Response:
    """The response to an impact, its steps `timed`; anew where the peak came in long steps."""
    pace, largest = pace_of(model, scenario), model.largest_error
    return strike(scenario, structure, pace, StruckRecord, run_impact, largest, timed)


@dataclass(frozen=True)
class SuperelementModel(FrameModel):
    """Bars between generalized hinges, with the options of both models."""

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    geometry: str = GEOMETRY()
    alpha: float | None = EXPONENT()
    beta: float | None = EXPONENT()
    shear: str = SHEAR()
    accuracy: float = SHARE()
    rate_level: str = RATE_LEVEL()

    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    @property
    def shear_yields(self) -> bool:
        """Whether webs slide where they carry less than their mechanism needs."""
        return self.shear == "panel"

    def check(self) -> None:
        """Refuse options that viscoplastic bars do not know."""
        check_bars(self)

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings of all member models, of shear only where members are rigid in it."""
        return about_webs(self, scenario, super().domain(scenario))

    def member_surface(self, frame: Frame, member: Member) -> YieldSurface | ShearSurface:
        """The yield surface of the hinges of a member, joints of its full strength."""
        return webs_of(self, frame).yielding[member.name] or ellipse(self, frame, member)

    def numbers(self, scenario: Any) -> dict[str, float] | None:
        """The scalars alone of the response to an impact, see `models.batch`; None of others.

        None as well where it is refused or fails. Raises `CollapseError`.
        """
        struck = scenario.KIND in (FrameImpact.KIND, ColumnImpact.KIND)
        solved = admitted(self, scenario) if struck else None
        if solved is None:
            return None
        event: Any = as_frame(solved)
        pace, largest = pace_of(self, event), self.largest_error
        try:
            standing = self.standing(solved)
            return strike(event, standing, pace, StruckNumbers, measure_impact, largest, iter)
        except (SolverError, OutOfDomainError):
            return None

    def _struck(self, scenario: FrameImpact, structure: FrameStructure, clock: Clock) -> Response:
        return march(self, scenario, structure, clock.timed)

    def group(self, cut: Cut) -> Superelements:
        """The superelements of pieces of members."""
        frame, elements = cut.frame, []
        yielding = webs_of(self, frame).yielding
        laws = laws_of(self, frame, yielding)
        for piece in cut.pieces:
            name, surface = piece.member.name, ellipse(self, frame, piece.member)
            first, last = (joint_surface(surface, joint) for joint in piece.joints)
            whole, law = bool(laws) or first == last == surface, laws.get(name)
            deforms = self.shear in (("panel", "elastic") if whole else ("elastic",))
            web = web_of(piece.section, frame.steel) if deforms else None
            yields = yielding[name] is not None
            elements.append(
                replace(self._bar(piece, (first, last)), web=web, web_yields=yields, law=law)
            )
        return Superelements(
            cut.nodes,
            elements,
            regularisation=self.regularisation,
            first_order=self.first_order,
        )

    @abstractmethod
    def _bar(self, piece: Piece, surfaces: HingeSurfaces) -> Superelement:
        """The superelement of a piece of a member."""


@dataclass(frozen=True)
class RigidSuperelement(SuperelementModel):
    """Rigid bars between generalized hinges (Heng 2017, paper IV).

    Options: `rotational_stiffness`, c of the hinge stiffness c EI/L (6: exact in sway; a member
    that ends in a pin gets half of it at the other end; None: 6 of one element, several are exact
    together); that along the bar is 2 EA/L, exact; `inertia` of the turning bar, nonlinear,
    linear (of the initial position) or none. Of both superelements: `alpha`, `beta`, exponents of
    the yield surface of moment and axial force (None: fitted to the exact N-M envelope of the
    section and stated to one decimal); `shear`, panel: webs yield, elastic: they only deform, none:
    members are rigid in shear; `accuracy` that steps by error aim at, as a share of the peak;
    `rate_level` as of `four-dof`; `time_step` None: by the error, of frames that peak after several
    rebounds up to 0.6 % off the peak, of columns whose light striker is thrown off mostly 1 %, a
    few 7 %.
    """

    rotational_stiffness: float | None = checked(Number(0.1, 1e6), optional=True)
    inertia: str = checked(Choice(INERTIAS), "nonlinear")

    name: ClassVar[str] = "rigid-superelement"
    version: ClassVar[int] = 20
    least_parts: ClassVar[int] = 2
    far_parts: ClassVar[int] = 1  # with two rigid bars two of 34 frames were 11 and 18 % low
    assumptions: ClassVar[tuple[str, ...]] = (
        "Rigid bars; all flexibility in hinges of 6EI/L: exact in sway, three times too stiff "
        "under uniform bending.",
        *COMMON,
    )

    def _bar(self, piece: Piece, surfaces: HingeSurfaces) -> Superelement:
        if piece.parts == 1 or self.rotational_stiffness is not None:
            factor = (self.rotational_stiffness or 6.0) / 6.0
            bending = sway_stiffness(piece.length, factor * piece.bending, piece.pins)
        else:
            whole = piece.parts * piece.length
            turned = piece.bending / (whole * curvature_shares(piece.parts)[piece.index])
            first, last = (series(*pair) for pair in zip(turned, piece.pins, strict=True))
            bending = first, last
        axial = 2.0 * piece.axial / piece.length
        return Superelement(
            *hinge_ends(piece, surfaces, axial, bending),
            mass_per_length=piece.properties.mass_per_length,
            rotary_inertia=piece.properties.rotary_inertia,
            rotation_inertia=self.inertia,
        )


@dataclass(frozen=True)
class FlexibleSuperelement(SuperelementModel):
    """Elastic beams between generalized hinges (Heng 2017, paper III).

    Options: `hinge_stiffness`, n of the hinges' n 2EA/L and n 6EI/L (100: nearly rigid-plastic);
    the others as of `rigid-superelement`.
    """

    hinge_stiffness: float = checked(Number(0.1, 1e9), 10.0)

    name: ClassVar[str] = "flexible-superelement"
    version: ClassVar[int] = 19
    assumptions: ClassVar[tuple[str, ...]] = (
        "Elastic Bernoulli beams without rotary inertia, straight against their chord: one element "
        "per member leaves out P-delta inside the member.",
        *COMMON,
    )

    def run(self, scenario: FrameScenario, structure: FrameStructure) -> Response:
        """Run as in `FrameModel`; members left elastic by a pulse gain flexibility of hinges."""
        response, n = super().run(scenario, structure), self.hinge_stiffness
        return softened(response, n) if isinstance(scenario, FramePulse) else response

    def _bar(self, piece: Piece, surfaces: HingeSurfaces) -> Superelement:
        n = self.hinge_stiffness
        axial = n * 2.0 * piece.axial / piece.length
        stiffness = n * 6.0 * piece.bending / piece.length
        bending = tuple(series(stiffness, joint.rotational_stiffness) for joint in piece.joints)
        return Superelement(
            *hinge_ends(piece, surfaces, axial, (bending[0], bending[1])),
            axial_stiffness=piece.axial,
            bending_stiffness=piece.bending,
            flexible=True,
            mass_per_length=piece.properties.mass_per_length,
        )
