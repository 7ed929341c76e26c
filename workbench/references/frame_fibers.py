"""Fiber references on frames: the group of elements of each kind, the run, what fibers leave out.

A reference answers a frame with `run_fiber_frame` and tells its limits with `fiber_findings`; both
take the lengths of the elements from `frame_mesh.member_lengths`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from workbench.errors import OutOfDomainError
from workbench.frames.chains import named
from workbench.frames.drives import (
    explicit_steps,
    ground_steps,
    impact_steps,
    static_steps,
)
from workbench.frames.findings import frame_findings
from workbench.frames.runs import run_ground_motion, run_impact, run_static
from workbench.frames.structure import FrameStructure
from workbench.references.column_beams import fiber_section
from workbench.references.fiber_reissner_column import reissner_section
from workbench.references.frame_beams import fiber_frame
from workbench.references.frame_mesh import (
    joint_findings,
    mesh_findings,
    mesh_frame,
    time_spans,
)
from workbench.responses import Finding, Response
from workbench.scenarios import (
    Column,
    Frame,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    Member,
)
from workbench.sections.shapes import ISection
from workbench.structures.assembly import ElementGroup
from workbench.structures.fiber_beams import FiberBeams, radau_rule
from workbench.structures.reissner_beams import ReissnerBeams
from workbench.structures.uniaxial import UniaxialLaw

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
PUSH_STEPS = 1000  # load steps over the range of a static path, before refinement
LEAST_YIELD_RATIO = 0.995
GAUSS = 0.5 - 0.5 / np.sqrt(3.0)


def run_fiber_frame(
    scenario: FrameScenario,
    build: Callable[[], FrameStructure],
    time_step: float | None,
    halvings: int,
    weight: float | None,
) -> Response:
    """Build a frame of fiber beams and follow its event.

    Arguments: `build` gives the frame under its dead loads; `time_step` in s (None: by rule);
    `halvings` of time and load steps; `weight` of the end stresses in a time step (None:
    explicit). Raises `SolverError`, `OutOfDomainError`.
    """
    with threadpool_limits(1, user_api="blas"):  # band solves are far too small for threads
        structure = build()
        if isinstance(scenario, FrameStatic):
            parts = round(PUSH_STEPS * 2.0**halvings)
            return run_static(scenario, structure, static_steps(scenario, structure, parts))
        if isinstance(scenario, FrameImpact):
            spans = time_spans(scenario, time_step, halvings)
            if weight is None:
                steps = explicit_steps(scenario, structure, spans)
            else:
                steps = impact_steps(scenario, structure, spans, weight)
            return run_impact(
                scenario,
                structure,
                steps,
                largest_error=None,
                least_yield_ratio=LEAST_YIELD_RATIO,
            )
        if weight is None:
            raise OutOfDomainError("explicit steps are known for impacts only: take implicit ones")
        shaken = ground_steps(scenario, structure, time_step, weight, halvings)
        return run_ground_motion(scenario, structure, shaken, least_yield_ratio=LEAST_YIELD_RATIO)


def reissner_frame(
    frame: Frame,
    lengths: list[Array],
    law: UniaxialLaw,
    layers: int,
    pattern: str = "none",
    peak: float | None = None,
    *,
    forms: bool = False,
    lumped: bool = False,
) -> FrameStructure:
    """The frame as geometrically exact beams under its dead loads.

    Arguments: element `lengths` (m) of every member; `law` of the steel; `layers` over the depth;
    `pattern` and `peak` of residual stresses; assembly by scikit-fem `forms`; `lumped` mass.
    Raises `InputError`, `SolverError`.
    """
    sections = [
        reissner_section(as_column(frame, member), law, layers, pattern, peak)
        for member in frame.members
    ]

    def build(nodes: Indices, member: Indices) -> tuple[ReissnerBeams, ElementGroup]:
        beams = ReissnerBeams(nodes, member, sections)
        if forms:
            from workbench.references.reissner_forms import ReissnerForms

            return beams, ReissnerForms(beams)
        return beams, beams

    return fiber_frame(frame, mesh_frame(frame, lengths), build, sampled=0.5, lumped=lumped)


def corotational_frame(
    frame: Frame,
    lengths: list[Array],
    layers: int,
    hardening_ratio: float,
    *,
    shear_flexible: bool = True,
    balanced: bool = False,
    lumped: bool = False,
) -> FrameStructure:
    """The frame as co-rotational fiber beams under its dead loads.

    Arguments: element `lengths` (m) of every member; `layers` over the depth; `hardening_ratio`
    of the regularising hardening modulus to the elastic one; elastic shear strain if
    `shear_flexible`; `balanced` elements instead of the classical ones; `lumped` mass. Raises
    `SolverError`.
    """
    sections = [
        fiber_section(as_column(frame, member), layers, hardening_ratio, shear_flexible)
        for member in frame.members
    ]
    upper = [np.cumsum(part) - 0.5 * part > 0.5 * np.sum(part) for part in lengths]

    def build(nodes: Indices, member: Indices) -> tuple[FiberBeams, FiberBeams]:
        rule = radau_rule(np.concatenate(upper)) if balanced else None
        beams = FiberBeams(nodes, member, sections, rule, balanced=balanced)
        return beams, beams

    sampled = 0.0 if balanced else GAUSS
    return fiber_frame(frame, mesh_frame(frame, lengths), build, sampled=sampled, lumped=lumped)


def as_column(frame: Frame, member: Member) -> Column:
    """A column with the section, steel and overrides of a member: what its fibers follow from."""
    half = max(0.5 * frame.length(member), member.section.height)
    return Column(
        member.section,
        half,
        half,
        frame.steel,
        fillets=frame.fillets,
        area=member.area,
        second_moment=member.second_moment,
        plastic_moment=member.plastic_moment,
        squash_load=member.squash_load,
        mass_per_length=member.mass_per_length,
    )


def fiber_findings(
    scenario: FrameScenario, lengths: list[Array], layers: int, sampled: float
) -> list[Finding]:
    """Findings of all frame models, and what fibers leave out or the mesh does not resolve.

    Arguments: element `lengths` (m) of every member; `layers` over the depth; `sampled`, where an
    element samples plasticity, from its end next to a hinge and over its length.
    """
    return [
        *frame_findings(scenario),
        *joint_findings(scenario.frame),
        *_override_findings(scenario.frame, layers),
        *mesh_findings(scenario, lengths, sampled),
    ]


def reissner_findings(frame: Frame, pattern: str, crookedness: float) -> list[Finding]:
    """Refusals of options of the geometrically exact beam that a frame does not know.

    Arguments: `pattern` of residual stresses; `crookedness`, an initial bow over the length.
    """
    findings = []
    others = [m.name for m in frame.members if not isinstance(m.section.shape, ISection)]
    if pattern != "none" and others:
        text = (
            f"option.residual_stress = {pattern}: patterns are known for I sections only, not for "
            f"{named(others)}; use none"
        )
        findings.append(Finding("residual-stress", text, refusal=True))
    if crookedness != 0.0:
        text = (
            f"option.out_of_straightness = {crookedness:g}: bows are known for columns only; put "
            "nodes where a member is crooked"
        )
        findings.append(Finding("out-of-straightness", text, refusal=True))
    return findings


def _override_findings(frame: Frame, layers: int) -> list[Finding]:
    """Overrides of section values that differ from those of the fibers by over 1 %."""
    stress = frame.steel.yield_stress
    differing = []
    for member in frame.members:
        given = {
            key: getattr(member, key)
            for key in ("area", "second_moment", "plastic_moment", "squash_load")
            if getattr(member, key) is not None
        }
        if not given:
            continue
        y, area = frame.strength_section(member).fibers(layers)
        values = {
            "area": np.sum(area),
            "second_moment": np.sum(y**2 * area),
            "plastic_moment": stress * np.sum(np.abs(y) * area),
            "squash_load": stress * np.sum(area),
        }
        differing += [
            f"member.{member.name}.{key} = {value:.5g} against {values[key]:.5g}"
            for key, value in given.items()
            if abs(value / values[key] - 1.0) > 0.01
        ]
    if not differing:
        return []
    more = f" and {len(differing) - 4} more" if len(differing) > 4 else ""
    text = "fibers come from the section alone and leave overrides out: "
    return [Finding("section", text + ", ".join(differing[:4]) + more)]
