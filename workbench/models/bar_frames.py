"""Frames of a few bars per member, plastic at their ends: options, steps, structure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from workbench.base.arrays import Array
from workbench.base.fields import Choice, Number, checked
from workbench.mechanics.frames.elastic import Spans, spans_to, time_to_peak, wave_times
from workbench.mechanics.frames.members import spread_findings
from workbench.mechanics.frames.structure import (
    FEWEST_LOADED,
    FrameStructure,
    Piece,
    SuperelementMembers,
    joint_inertias,
    stand_frame,
    struck_parts,
)
from workbench.mechanics.structures.elements import HingedElements
from workbench.models.domain import hit_mass_findings
from workbench.models.frame_model import FrameModel, as_frame
from workbench.responses import Finding, Response, finding, findings_of, set_findings
from workbench.scenarios import ColumnScenario, Frame, FrameImpact, FramePulse, FrameScenario

PEAK_STEPS = 150.0  # time steps up to the expected peak
LEAST_STEPS = 100.0  # of a record
GEOMETRIES = ("co-rotational", "linear")
Cut = tuple[Array, list[tuple[int, int]], list[Piece]]  # see `cut_members`


@dataclass(frozen=True)
class BarFrames(FrameModel):
    """Frames of a few bars per member."""

    elements: int | None = checked(
        Number(1, 100, integer=True), optional=True, help="per member (None: one, of loaded more)"
    )
    time_step: float | None = checked(
        Number(1e-8, 1.0, "s"),
        optional=True,
        help="None: 1/150 of the expected time to the peak, four times as long after six such "
        "times, at most the time of a wave along an element and back, half of that with "
        "restitution; of superelements by the error",
    )
    regularisation: float = checked(
        Number(0.0, 0.1, advice="a share of the elastic stiffness, 1e-6 by default"),
        1e-6,
        help="share of the elastic stiffness beside perfectly plastic hinges",
    )
    geometry: str = checked(
        Choice(GEOMETRIES),
        "co-rotational",
        help="linear: equilibrium of the undeformed frame, first-order theory for comparison",
    )

    least_parts: ClassVar[int] = 1  # of a struck member, and what their number is a multiple of
    concentrated: ClassVar[bool] = True  # yielding: none between hinges
    far_parts: ClassVar[int] = 2  # of members far from the struck one; of one, mass is at the ends

    @property
    def first_order(self) -> bool:
        """Whether equilibrium is that of the undeformed structure."""
        return self.geometry == "linear"

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings of all member models, and too few elements under a striker or a line load."""
        event = as_frame(scenario)
        parts = self.parts(event)
        findings = super().domain(scenario) + hit_mass_findings(event, parts)
        if isinstance(event, FramePulse) and event.members:
            pairs = zip(event.frame.members, parts, strict=True)
            fewest = min(count for member, count in pairs if member.name in event.members)
            if fewest < FEWEST_LOADED:
                findings.append(finding("line-load", fewest, fewest=fewest, wanted=FEWEST_LOADED))
        return findings

    def run(self, scenario: FrameScenario, structure: FrameStructure) -> Response:
        """Run as in `FrameModel`; of a push also find the yielding that it leaves out."""
        response = super().run(scenario, structure)
        if scenario.STATIC and self.concentrated:
            set_findings(response, [*findings_of(response), *spread_findings(scenario, response)])
        return response

    def parts(self, scenario: FrameScenario) -> list[int]:
        """Elements of every member."""
        if self.elements is None:
            return list(struck_parts(scenario, self.least_parts, self.far_parts))
        return [self.elements] * len(scenario.frame.members)

    def stand(
        self, frame: Frame, cut: Cut, group: HingedElements, parts: Sequence[int]
    ) -> FrameStructure:
        """The frame of a `group`, its members `cut` in so many parts, under its dead loads."""
        coordinates, nodes, pieces = cut
        inertia = joint_inertias(nodes, pieces)
        members = SuperelementMembers(group, coordinates, parts)
        return stand_frame(frame, coordinates, [group], members, rotary_inertia=inertia)

    def time_spans(self, scenario: FrameImpact) -> Spans:
        """End times and time steps (s) of the parts of the record.

        Steps longer than a wave takes along an element and back make its hinges ring, which
        softens them artificially. Rebounds need half the step.
        """
        duration = scenario.duration
        if self.time_step is not None:
            return [(duration, self.time_step)]
        waves = wave_times(scenario.frame) / self.parts(scenario)
        peak = time_to_peak(scenario)
        coarsest = min(duration / LEAST_STEPS, 2.0 * float(waves.min()))
        share = 0.5 if scenario.striker.rebounds else 1.0
        return spans_to(peak, duration, peak / PEAK_STEPS, coarsest, share)
