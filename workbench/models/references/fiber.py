"""Fiber references, common parts: options, mesh, time steps, findings, runs and refinement.

A column is the frame of its two members. Each reference adds its elements and their section.
"""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from workbench.base.arrays import Array
from workbench.base.fields import Number, checked
from workbench.mechanics.frames.elastic import Spans, line_wave_times, spans_to, time_to_peak
from workbench.mechanics.frames.members import LAYERS, check_layers, fiber_overrides
from workbench.mechanics.frames.structure import FrameStructure, stand_frame
from workbench.mechanics.structures.fibers import FiberElements
from workbench.models.base import respond
from workbench.models.frame_model import FrameModel, as_frame
from workbench.models.references.fiber_mesh import (
    FiberMembers,
    FrameMesh,
    MeshRule,
    joint_springs,
    member_lengths,
    mesh_findings,
    mesh_frame,
)
from workbench.models.references.refine import (
    HALVED_STEPS,
    LEVELS,
    MESHES,
    REFINEMENT,
    check_levels,
    refined,
)
from workbench.responses import Finding, Response, finding
from workbench.scenarios import (
    ColumnImpact,
    ColumnScenario,
    Frame,
    FrameImpact,
    FrameScenario,
    Scenario,
)

PEAK_STEPS = 130.0  # time steps up to the expected peak, at least
WAVE_STEPS = 20.0  # time steps while an axial wave passes the longest member, at least
LONE_STEPS = 10.0  # where no other member is: it does as well within 0.1 % of the peak
LEAST_STEPS = 200.0  # time steps of a record, at least


@dataclass(frozen=True)
class FiberReference(FrameModel):
    """Frames of fiber elements with a refinement ladder."""

    smallest_element: float | None = checked(
        Number(1e-4, 10.0, "m"), optional=True, help="at both ends of every member (None: by rule)"
    )
    largest_element: float | None = checked(
        Number(1e-4, 100.0, "m"), optional=True, help="None: by rule"
    )
    layers: int = checked(LAYERS, 20, help="over the depth, an even number")
    time_step: float | None = checked(
        Number(1e-8, 1e-2, "s"),
        optional=True,
        help="None: 1/20 of the time of an axial wave along the longest member, 1/10 in a single "
        "one, at first at most 1/130 of the expected time to the peak",
    )
    refinement: int = checked(
        REFINEMENT, 0, help="how often all elements and steps are halved (negative: doubled)"
    )
    step_refinement: int = checked(REFINEMENT, 0, help=HALVED_STEPS)
    levels: int = checked(LEVELS, 3, help=MESHES)
    weight: float = checked(
        Number(0.5, 1.0, advice="1/2 conserves energy, 1 dissipates most"),
        0.5,
        help="of the end stresses in a time step; more than 1/2 damps waves",
    )
    hardening_ratio: float = checked(
        Number(0.0, 0.1), 1e-6, help="regularising hardening over the elastic modulus"
    )

    judged: ClassVar[bool] = False
    unused: ClassVar[tuple[str, ...]] = ("joint.axial_stiffness", "joint.*_resistance")
    collision_halvings: ClassVar[int] = 5
    longer: ClassVar[float] = 1.0  # steps, where less is left of the waves
    largest_error: ClassVar[float | None] = None  # refinement measures it
    shear_yields: ClassVar[bool] = False

    def check(self) -> None:
        """Refuse layers and levels that do not fit."""
        check_layers(self)
        check_levels(self.refinement, self.levels)

    @abstractmethod
    def mesh_rule(self, scenario: FrameScenario) -> MeshRule:
        """Sizes of elements where no option gives them."""

    @property
    @abstractmethod
    def sampled(self) -> float:
        """Where an element samples plasticity, from its end next to a hinge and over its length."""

    @abstractmethod
    def elements(self, frame: Frame, mesh: FrameMesh) -> FiberElements:
        """The elements of a mesh."""

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings common to all member models, and what fibers or mesh do not follow."""
        event = as_frame(scenario)
        followed = ("buckling", "shear") if self.shear_yields else ("buckling",)
        return [
            *(f for f in super().domain(scenario) if f.refusal or f.subject not in followed),
            *joint_findings(event.frame),
            *fiber_overrides(event.frame, self.layers),
            *mesh_findings(event, self.lengths(event), self.sampled),
        ]

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a scenario of a column or a frame, with numerical uncertainty."""
        return respond(self, scenario, lambda given: refined(self, given, self.solve))

    def lengths(self, scenario: ColumnScenario | FrameScenario) -> list[Array]:
        """Element lengths (m) of every member; of a column below and above the hit point."""
        event = as_frame(scenario)
        sizes = self.smallest_element, self.largest_element, self.refinement
        return member_lengths(event, self.mesh_rule(event), *sizes)

    def time_spans(self, scenario: ColumnImpact | FrameImpact) -> Spans:
        """End times and time steps (s) of the parts of the record, refinement applied."""
        event = as_frame(scenario)
        assert isinstance(event, FrameImpact)
        share = 0.5**self.halvings
        if self.time_step is not None:
            return [(event.duration, self.time_step * share)]
        waves = line_wave_times(event.frame)
        wave_steps = WAVE_STEPS if len(waves) > 1 else LONE_STEPS
        coarsest = min(self.longer * max(waves) / wave_steps, event.duration / LEAST_STEPS)
        peak = time_to_peak(event, shear_flexible=True)
        return spans_to(peak, event.duration, self.longer * peak / PEAK_STEPS, coarsest, share)

    def structure(self, scenario: ColumnScenario | FrameScenario) -> FrameStructure:
        """The frame, or the column as one, under its dead loads. Raises `SolverError`."""
        frame = as_frame(scenario).frame
        mesh = self.placed(mesh_frame(frame, self.lengths(scenario)))
        beams = self.elements(frame, mesh)
        springs = joint_springs(frame, mesh)
        members = FiberMembers(frame, mesh, beams, springs, self.sampled, self.shear_yields)
        groups = [beams] if springs is None else [beams, springs]
        return stand_frame(frame, mesh.coordinates, groups, members, ties=mesh.ties)

    def placed(self, mesh: FrameMesh) -> FrameMesh:
        """The mesh with its nodes where they are before any load."""
        return mesh

    @property
    def halvings(self) -> int:
        """How often the steps are halved."""
        return self.refinement + self.step_refinement


def joint_findings(frame: Frame) -> list[Finding]:
    """Findings on joints: strengths that a rotational spring at a fiber member leaves out."""
    used = {m.joint_start for m in frame.members} | {m.joint_end for m in frame.members}
    strengths = {j.name: (j.plastic_moment, j.plastic_moment_negative) for j in frame.joints}
    names = [name for name, each in strengths.items() if name in used and any(each)]
    return [finding("joint-moments", names=", ".join(names))] if names else []
