"""Reference of record: geometrically exact fiber beam, static and under impact.

Reissner 1972 and Simo 1985: finite stretch, shear and rotation, one point per linear element,
fibers across the section. The element samples plasticity half its length inside the member, so
that resistance converges from above at first order in the length of the smallest element. The
mesh grows fast from a very small element at every hinge: that error is then small, and a hinge
that the hardening spreads over millimetres is resolved.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.fields import Choice, Flag, Number, check_fields, checked
from workbench.frames.structure import FrameStructure
from workbench.materials import Steel
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.references.column_beams import ColumnBeams
from workbench.references.column_rules import (
    check_layers,
    column_mesh,
    mesh_findings,
    section_findings,
    time_spans,
)
from workbench.references.column_runs import run_column
from workbench.references.fiber_reissner_column import reissner_column, reissner_section
from workbench.references.frame_fibers import (
    fiber_findings,
    reissner_findings,
    reissner_frame,
    run_fiber_frame,
)
from workbench.references.frame_mesh import member_lengths
from workbench.references.refine import LEVELS, REFINEMENT, check_levels, refined
from workbench.responses import Finding, Response
from workbench.scenarios import (
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    FrameGroundMotion,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    Scenario,
)
from workbench.sections.shapes import ISection
from workbench.structures.reissner_beams.fibers import PATTERNS
from workbench.structures.uniaxial import (
    MILD_STEEL,
    CowperSymonds,
    LinearHardening,
    MenegottoPinto,
    UniaxialLaw,
)

Array = NDArray[np.float64]
SMALLEST_SHARE = 1.0 / 256.0  # of the shorter segment: peaks within 1 % of the converged ones
SMALLEST_DEPTH = 0.01  # of the depth
GROWTH, MILD_GROWTH = 2.0, 1.5  # of neighbouring elements, by rule and from a given size on
MIDDLE = 0.5  # of an element: where it samples plasticity
LAWS = ("linear", "menegotto-pinto")
FRAMES = (FrameImpact, FrameStatic, FrameGroundMotion)


@dataclass(frozen=True)
class FiberReissner:
    """Geometrically exact fiber beam.

    Mesh and steps: `smallest_element` in m, at both ends of both segments (None: 1/256 of the
    shorter segment, but not below 1/100 of the depth); `largest_element` in m (None: 1/40 of the
    length); `layers` over the depth of the section; `time_step` in s
    (None: 1/15 of the time of an axial wave along the column, and at first at most 1/200 of the
    expected time to the peak; a bound and the interval of records if explicit); `refinement`, how
    often all elements and steps are halved (negative: doubled); `step_refinement`, how often the
    steps alone are halved further; `levels`, meshes behind an answer, each with twice the elements
    and steps of the next finer one (1: that of `refinement` alone, the numerical uncertainty is
    then unknown).
    Solution: `formulation`, compiled kernel or scikit-fem forms (the same response, slowly);
    `integrator`, implicit with energy-exact steps or explicit central differences with lumped
    mass; `weight` of the end stresses in an implicit step (1/2 conserves energy, but does not
    converge on fine plastic meshes).
    Steel: `steel_law`, linear hardening or Menegotto-Pinto; `hardening_ratio`, kinematic hardening
    modulus (or slope of the hardening line) over the elastic one, by default regularisation only:
    perfect plasticity has no limit of the mesh at large rotations, as a hinge has no length;
    `isotropic_ratio`, isotropic hardening modulus over the elastic one; `rate_sensitive`: yield
    stress after Cowper and Symonds with `rate_reference` in 1/s and `rate_exponent`;
    `residual_stress`, pattern in an I section, with `residual_ratio` of its peak to the yield
    stress (None: 0.5 for profiles up to 1.2 times as high as wide, else 0.3);
    `out_of_straightness`, amplitude of a half sine along the strike over the length.
    """

    smallest_element: float | None = checked(Number(1e-4, 10.0, "m"), optional=True)
    largest_element: float | None = checked(Number(1e-4, 100.0, "m"), optional=True)
    layers: int = checked(Number(4, 1000, integer=True), 20)
    time_step: float | None = checked(Number(1e-8, 1e-2, "s"), optional=True)
    refinement: int = checked(REFINEMENT, 0)
    step_refinement: int = checked(REFINEMENT, 0)
    levels: int = checked(LEVELS, 4)
    formulation: str = checked(Choice(("kernel", "forms")), "kernel")
    integrator: str = checked(Choice(("implicit", "explicit")), "implicit")
    weight: float = checked(
        Number(0.5, 1.0, advice="1/2 conserves energy, 1 dissipates most"), 0.55
    )
    steel_law: str = checked(Choice(LAWS), "linear")
    hardening_ratio: float = checked(Number(0.0, 0.1), 1e-6)
    isotropic_ratio: float = checked(Number(0.0, 0.1), 0.0)
    rate_sensitive: bool = checked(Flag(), False)
    rate_reference: float = checked(Number(1e-3, 1e9, "1/s"), MILD_STEEL.reference_rate)
    rate_exponent: float = checked(Number(1.0, 50.0), MILD_STEEL.exponent)
    residual_stress: str = checked(Choice(PATTERNS), "none")
    residual_ratio: float | None = checked(Number(0.0, 1.0), optional=True)
    out_of_straightness: float = checked(
        Number(-0.02, 0.02, advice="amplitude over length: 1/1000 is 0.001"), 0.0
    )

    name: ClassVar[str] = "fiber-reissner"
    version: ClassVar[int] = 3
    answers: ClassVar[tuple[str, ...]] = (
        ColumnImpact.KIND,
        ColumnPushover.KIND,
        FrameImpact.KIND,
        FrameStatic.KIND,
        FrameGroundMotion.KIND,
    )
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections that may stretch, shear and turn by any amount.",
        "Plasticity of the fibers from normal stress alone; shear strain stays elastic.",
        "Elastic stiffness and strength are both those of the fibers (column.fillets applies to "
        "both); the mass is that of the rolled profile, distributed along the member.",
        "Point contact; no local denting, no local buckling, no fracture; rate sensitivity, "
        "hardening, residual stress and crookedness are options that are off by default.",
        "Elastic-perfectly plastic up to a hardening of 1e-6 E, which gives a hinge a length; "
        "without it forces at hinge rotations beyond 0.3 depend on the mesh.",
    )

    def __post_init__(self) -> None:
        check_fields(self, "option")
        check_layers(self.layers)
        check_levels(self.refinement, self.levels)
        if self.steel_law == "menegotto-pinto":
            for name in ("rate_sensitive", "isotropic_ratio"):
                if getattr(self, name):
                    raise InputError(
                        f"option.{name}",
                        getattr(self, name),
                        "is not known with steel_law = menegotto-pinto",
                        "use steel_law = linear",
                    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the beam and of the options that are on."""
        keys = ["reissner1972", "simo1985", "simo-tarnow-doblare1995", "heng2017"]
        if self.rate_sensitive:
            keys.append("cowper-symonds1957")
        if self.steel_law == "menegotto-pinto":
            keys.append("menegotto-pinto1973")
        if self.residual_stress != "none":
            keys.append("eccs1984")
        return tuple(keys)

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings common to all member models, and what the fibers cannot follow."""
        if isinstance(scenario, FRAMES):
            return [
                *fiber_findings(scenario, self.frame_mesh(scenario), self.layers, MIDDLE),
                *reissner_findings(scenario.frame, self.residual_stress, self.out_of_straightness),
            ]
        y, area = scenario.column.strength_section.fibers(self.layers)
        findings = member_findings(scenario) + section_findings(scenario.column, y, area)
        findings += mesh_findings(scenario, *self.mesh(scenario))
        return findings + pattern_findings(scenario, self.residual_stress)

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a scenario of a column or a frame, with numerical uncertainty."""
        return respond(self, scenario, lambda given: refined(self, given, self._solve))

    def mesh(self, scenario: ColumnScenario) -> tuple[Array, Array]:
        """Element lengths (m) below and above the hit point."""
        return column_mesh(
            scenario,
            self.smallest_element,
            self.largest_element,
            self.refinement,
            SMALLEST_SHARE,
            SMALLEST_DEPTH,
            self._growth,
        )

    def frame_mesh(self, scenario: FrameScenario) -> list[Array]:
        """Element lengths (m) of every member of a frame."""
        return member_lengths(
            scenario,
            self.smallest_element,
            self.largest_element,
            self.refinement,
            SMALLEST_SHARE,
            SMALLEST_DEPTH,
            self._growth,
        )

    def law(self, steel: Steel) -> UniaxialLaw:
        """The law of the fibers."""
        modulus = steel.elastic_modulus
        if self.steel_law == "menegotto-pinto":
            return MenegottoPinto(modulus, steel.yield_stress, self.hardening_ratio)
        rate = CowperSymonds(self.rate_reference, self.rate_exponent)
        return LinearHardening(
            modulus,
            steel.yield_stress,
            self.hardening_ratio * modulus,
            self.isotropic_ratio * modulus,
            rate if self.rate_sensitive else None,
        )

    def beams(self, scenario: ColumnScenario) -> ColumnBeams:
        """The column under its axial load, ready to be hit or pushed. Raises `SolverError`."""
        section = reissner_section(
            scenario.column,
            self.law(scenario.column.steel),
            self.layers,
            self.residual_stress,
            self.residual_ratio,
        )
        return reissner_column(
            scenario.column,
            section,
            *self.mesh(scenario),
            crookedness=self.out_of_straightness,
            forms=self.formulation == "forms",
            lumped=self.integrator == "explicit",
        )

    def frame(self, scenario: FrameScenario) -> FrameStructure:
        """The frame under its dead loads, ready for its event. Raises `SolverError`."""
        return reissner_frame(
            scenario.frame,
            self.frame_mesh(scenario),
            self.law(scenario.frame.steel),
            self.layers,
            self.residual_stress,
            self.residual_ratio,
            forms=self.formulation == "forms",
            lumped=self.integrator == "explicit",
        )

    def time_spans(self, scenario: ColumnImpact) -> list[tuple[float, float]]:
        """End times and time steps (s) of the parts of the record, refinement applied."""
        return time_spans(scenario, self.time_step, self._halvings)

    def _solve(self, scenario: ColumnScenario | FrameScenario) -> Response:
        weight = self.weight if self.integrator == "implicit" else None
        if isinstance(scenario, FRAMES):
            build = partial(self.frame, scenario)
            return run_fiber_frame(scenario, build, self.time_step, self._halvings, weight)
        return run_column(scenario, self.beams, self.time_spans, self._halvings, weight)

    @property
    def _growth(self) -> float:
        """Ratio of neighbouring elements: fast from the very small elements of the rule only."""
        return GROWTH if self.smallest_element is None else MILD_GROWTH

    @property
    def _halvings(self) -> int:
        """How often the steps are halved."""
        return self.refinement + self.step_refinement


def pattern_findings(scenario: ColumnScenario, pattern: str) -> list[Finding]:
    """Refusal of residual stresses in a section without a known pattern."""
    if pattern == "none" or isinstance(scenario.column.section.shape, ISection):
        return []
    text = f"option.residual_stress = {pattern}: patterns are known for I sections only, use none"
    return [Finding("residual-stress", text, refusal=True)]
