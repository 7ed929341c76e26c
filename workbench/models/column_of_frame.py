"""An impacted frame reduced to the column that is hit, as an engineer does it by hand.

Heng 2017, section 5.1, puts a guided head with an axial spring and a dead load in the place of the
rest of the frame. Here the spring is the elastic stiffness that the frame without the column has
between the two ends of it, the dead load is that of the elastic frame, and the mass at the head is
that of what stands on it. What the ends do besides, sway and rotation, is left out; so is the
strength of the frame, unless the restraint may yield.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from workbench.base.errors import InputError, OutOfDomainError
from workbench.base.fields import Choice, checked
from workbench.mechanics.frames.column_estimate import HEADS, ColumnEstimate, estimate_column
from workbench.mechanics.frames.elastic import HEAD_MASSES
from workbench.models.base import Answering
from workbench.models.domain import IMPLAUSIBLE, frame_findings
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.single_dof import SingleDof
from workbench.models.superelements import RigidSuperelement
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    finding,
    outcome_of,
    set_findings,
    warnings_of,
)
from workbench.scenarios import (
    FrameImpact,
    Member,
    Node,
    frame_scenario,
    to_toml,
)
from workbench.scenarios.parts import OVERRIDES

# rigid in shear but for `four-dof-shear`
MODELS: dict[str, Any] = {
    model.name: model
    for model in (
        *(FourDof(), FourDofShear(), SingleDof(), EnergyEstimate()),
        RigidSuperelement(shear="none"),
    )
}
RESTRAINTS = ("elastic", "yielding")
RESTRAINT, ANCHOR = "restraint", "anchor"
LONGEST, SHORTEST = 100.0, 2.0  # m, of the bar that is the restraint
BAR_AREA = 0.01  # m2
PICTURES = ("snapshot_at", "shape_x", "shape_y", "utilisation", "member", "point", "snapshot")


@dataclass(frozen=True)
class ColumnOfFrame(Answering):
    """The impacted column of a frame, the rest of it as a spring, a mass and a dead load."""

    model: str = checked(Choice(tuple(MODELS)), FourDof.name, help="of the column, by its defaults")
    head_mass: str = checked(
        Choice(HEAD_MASSES),
        "column-line",
        help="what moves with the head: half of all members that meet the line of columns above "
        "the struck one, that line whole and the point masses on it; joint: the same of the head "
        "alone; deflected-shape: generalised mass of the frame without the column in the "
        "deflection of its spring",
    )
    head: str = checked(
        Choice(HEADS), "joined", help="joined: guided, unless the column ends in a pin"
    )
    restraint: str = checked(
        Choice(RESTRAINTS),
        "elastic",
        help="yielding: at the force at which the frame without the column collapses "
        "(rigid-superelement only)",
    )

    name: ClassVar[str] = "column-of-frame"
    version: ClassVar[int] = 4
    answers: ClassVar[tuple[str, ...]] = (FrameImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Those of the column model.",
        "Both ends of the struck column are held against sway and, unless pinned, rotation.",
        "The rest of the frame is a spring along the column, a mass at its head and the dead load "
        "of the elastic frame; the spring stays elastic unless the restraint yields.",
        "Nothing of the rest of the frame is reported: the response is that of the column.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    @property
    def crushing(self) -> bool:
        """Whether the model of the column knows a striker that crushes."""
        return bool(getattr(MODELS[self.model], "crushing", False))

    @property
    def unused(self) -> tuple[str, ...]:
        """Strengths of joints, where the restraint stays elastic."""
        return () if self.restraint == "yielding" else ("joint.*_resistance", "joint.plastic_*")

    def check(self) -> None:
        """Refuse a yielding restraint where the model's spring is elastic."""
        if self.restraint == "yielding" and self.model != RigidSuperelement.name:
            text = f"is not known to {self.model}, whose spring is elastic"
            raise self.refusal("restraint", text, f"take model = {RigidSuperelement.name}")

    def domain(self, scenario: FrameImpact) -> list[Finding]:
        """Findings on the dead loads of the frame, on its column, and on effects left out."""
        findings = [f for f in frame_findings(scenario) if f.subject != "shear"]
        try:
            estimate = self.estimate(scenario)
        except OutOfDomainError as error:
            return [*findings, Finding("column", str(error), refusal=True)]
        if self.restraint == "yielding" and estimate.restraint_limit is None:
            findings.append(finding("no-restraint"))
        inner = MODELS[self.model].domain(estimate.column)
        return [*findings, *inner, *estimate.findings()]

    def estimate(self, scenario: FrameImpact) -> ColumnEstimate:
        """The derived column and what is known about it. Raises `OutOfDomainError`."""
        return estimate_column(scenario, self.head_mass, self.head)

    def _solve(self, scenario: FrameImpact) -> Response:
        estimate = self.estimate(scenario)
        model = MODELS[self.model]
        if self.model == RigidSuperelement.name:
            limit = estimate.restraint_limit if self.restraint == "yielding" else None
            response, force = _as_bars(model, estimate, limit)
        else:
            response, column = model.simulate(estimate.column), estimate.column.column
            force = None  # the largest one of the elastic spring at the head, in N
            if "shortening" in response and column.head != "fixed":
                shortening = response["shortening"].values
                force = column.restraint_stiffness * float(np.max(shortening - shortening[0]))
        known = {each.text for each in model.domain(estimate.column)}
        findings = [
            warning
            for warning in warnings_of(response)
            if warning.text not in known and warning.subject != IMPLAUSIBLE
        ]
        if force is not None and self.restraint == "elastic":
            findings += estimate.restraint_findings(force)
        set_findings(response, findings)
        response.attrs["derived_column"] = to_toml(estimate.column)
        return response


# -- rigid superelements, whose restraint is a bar that can yield --------------------------------


def _as_bars(
    model: RigidSuperelement, estimate: ColumnEstimate, limit: float | None
) -> tuple[Response, float | None]:
    """The response of the derived column as a frame, and the largest force (N) in its restraint.

    Argument: `limit` of that force (None: it stays elastic). Raises `OutOfDomainError`.
    """
    response = model.simulate(_with_bar(estimate, limit))
    if outcome_of(response) is not Outcome.OK:
        return response, None
    force = None
    if f"{RESTRAINT}:start" in response["hinge"].values:
        force = float(response["axial_force"].sel(hinge=f"{RESTRAINT}:start").max())
    segments = ["below", "above"]
    hinges = [f"{segment}:{end}" for segment in segments for end in ("start", "end")]
    return response.drop_vars(PICTURES).sel(segment=segments, hinge=hinges), force


def _with_bar(estimate: ColumnEstimate, limit: float | None) -> FrameImpact:
    """The frame of the derived column, its spring a light bar from the head to the ground."""
    event = frame_scenario(estimate.column)
    assert isinstance(event, FrameImpact)
    column, frame = estimate.column.column, event.frame
    stiffness = column.restraint_stiffness
    if stiffness == 0.0 or column.head == "fixed":
        return event
    modulus = frame.steel.elastic_modulus
    length = float(np.clip(BAR_AREA * modulus / stiffness, SHORTEST, LONGEST))
    # an axial wave takes as long along the bar as along the shorter segment
    properties = column.properties
    wave = properties.mass_per_length * min(column.length_below, column.length_above) ** 2
    mass = stiffness * wave / (modulus * properties.area * length)
    largest = OVERRIDES["squash_load"].high
    try:
        bar = Member(
            RESTRAINT,
            "head",
            ANCHOR,
            column.section,
            joint_start="pinned",
            joint_end="pinned",
            area=stiffness * length / modulus,
            squash_load=largest if limit is None else min(limit, largest),
            mass_per_length=max(mass, OVERRIDES["mass_per_length"].low),
            axis=column.axis,
        )
    except InputError as error:
        raise OutOfDomainError(f"no bar can stand for the restraint: {error}") from error
    nodes = [replace(n, spring_y=0.0) if n.name == "head" else n for n in frame.nodes]
    nodes.append(Node(ANCHOR, 0.0, column.length + length, support="clamped"))
    members = (*frame.members, bar)
    return replace(event, frame=replace(frame, nodes=tuple(nodes), members=members))
