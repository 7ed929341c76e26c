"""Frames of a few bars per member, plastic at their ends: options, steps, structure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.arrays import Array
from workbench.fields import Choice, Number, checked
from workbench.frames.elastic import Spans, spans_to, time_to_peak, wave_times
from workbench.frames.runs import OPEN_LEDGER
from workbench.frames.structure import FrameStructure, stand_frame
from workbench.frames.superelements import (
    FEWEST_LOADED,
    Piece,
    SuperelementMembers,
    joint_inertias,
    struck_parts,
)
from workbench.models.domain import hit_mass_findings
from workbench.models.frame_model import FrameModel, as_frame
from workbench.responses import Finding, finding
from workbench.scenarios import ColumnScenario, Frame, FrameImpact, FramePulse, FrameScenario
from workbench.structures.elements import HingedElements
from workbench.structures.impact import INTEGRATORS, MIDPOINT, MOREAU

PEAK_STEPS = 150.0  # time steps up to the expected peak
LEAST_STEPS = 100.0  # of a record
WEIGHT = 0.5  # of the end forces in a time step: conserves energy
GEOMETRIES = ("co-rotational", "linear")
Cut = tuple[Array, list[tuple[int, int]], list[Piece]]  # see `cut_members`


@dataclass(frozen=True)
class BarFrames(FrameModel):
    """Frames of a few bars per member.

    Shared options: `elements` per member (None: one, of loaded members more, see `struck_parts`);
    `integrator`; `time_step` in s (None: 1/150 of the expected time to the peak, four times as long
    after six such times, at most the time of a wave along an element and back, half of that with
    restitution); `node_inertia`, rotary inertia of every node in kg m2 (None: that of half a
    section depth of the heaviest bar there): without it the rotation of a joint at which all
    hinges yield is indeterminate; `regularisation`, share of the elastic stiffness beside the
    perfectly plastic hinges; `geometry`, co-rotational or linear (equilibrium of the undeformed
    frame: first-order theory, for comparison).
    """

    elements: int | None = checked(Number(1, 100, integer=True), optional=True)
    integrator: str = checked(Choice(INTEGRATORS), MIDPOINT)
    time_step: float | None = checked(Number(1e-8, 1.0, "s"), optional=True)
    node_inertia: float | None = checked(Number(0.0, 1e6, "kg m2"), optional=True)
    regularisation: float = checked(
        Number(0.0, 0.1, advice="a share of the elastic stiffness, 1e-6 by default"), 1e-6
    )
    geometry: str = checked(Choice(GEOMETRIES), "co-rotational")

    least_parts: ClassVar[int] = 1  # of a struck member, and what their number is a multiple of
    far_parts: ClassVar[int] = 2  # of members far from the struck one; of one, mass is at the ends

    @property
    def scheme(self) -> tuple[float | None, str]:
        """Forces of the middle of a time step, which conserve energy, and the integrator."""
        return WEIGHT, self.integrator

    @property
    def crushing(self) -> bool:
        """Whether its steps know a striker that crushes."""
        return self.integrator == MIDPOINT

    @property
    def largest_error(self) -> float | None:
        """That of the energy ledger, which is open by design with Moreau's time stepping."""
        return None if self.integrator == MOREAU else OPEN_LEDGER

    @property
    def first_order(self) -> bool:
        """Whether equilibrium is that of the undeformed structure."""
        return self.geometry == "linear"

    def domain(self, scenario: FrameScenario | ColumnScenario) -> list[Finding]:
        """Findings of all member models, and too few elements under a striker or a line load."""
        event = as_frame(scenario)
        parts = self.parts(event)
        findings = super().domain(scenario) + hit_mass_findings(event, parts)
        if not isinstance(event, FramePulse) or not event.members:
            return findings
        names = [member.name for member in event.frame.members]
        fewest = min(parts[names.index(name)] for name in event.members)
        if fewest < FEWEST_LOADED:
            findings.append(finding("line-load", fewest, fewest=fewest, wanted=FEWEST_LOADED))
        return findings

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
        if self.node_inertia is not None:
            inertia = np.full(len(coordinates), self.node_inertia)
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
        waves = np.array(wave_times(scenario.frame)) / self.parts(scenario)
        peak = time_to_peak(scenario)
        coarsest = min(duration / LEAST_STEPS, 2.0 * float(waves.min()))
        share = 0.5 if scenario.striker.rebounds else 1.0
        return spans_to(peak, duration, peak / PEAK_STEPS, coarsest, share)
