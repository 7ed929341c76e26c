"""Meshes of frames for fiber beams: graded at the ends of every member, uniform if asked for."""

from __future__ import annotations

from itertools import pairwise
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.frames.chains import chains, named
from workbench.frames.timing import time_to_peak, wave_times
from workbench.responses import Finding
from workbench.scenarios import Frame, FrameImpact, FrameScenario, FrameStatic, Joint
from workbench.structures.meshing import graded_lengths, halved

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
LARGEST_SHARE = 1.0 / 40.0  # of the longest member; travelling hinges pass through inner elements
LARGEST_IN_DYNAMICS = 0.06  # of the longest member
LARGEST_EXCESS = 0.025  # of the resistance, by sampling plasticity inside the member
PEAK_STEPS = 200.0  # time steps up to the expected peak, at least
WAVE_STEPS = 30.0  # time steps while an axial wave passes the longest member, at least
LEAST_STEPS = 200.0  # time steps of a record, at least
FIRST_SPAN, LATER = 6.0, 4.0  # beyond so many times to the peak, so many times longer steps


class FrameMesh(NamedTuple):
    """Elements of all members, one member after the other, each from its start to its end.

    `coordinates` (nodes, 2) in m, those of the frame's nodes first; `nodes` (elements, 2);
    `member` (elements,), number of the member; `first` (members + 1,), where its elements start;
    `lengths` (elements,) in m; `joints`, those that turn: number of the member, whether at its
    start, node of the frame, and the node of the member that is tied to it.
    """

    coordinates: Array
    nodes: Indices
    member: Indices
    first: Indices
    lengths: Array
    joints: tuple[tuple[int, bool, int, int], ...]

    @property
    def ties(self) -> tuple[tuple[int, int], ...]:
        """Pairs (node of the frame, node of a member) that share translations only."""
        return tuple((master, slave) for _, _, master, slave in self.joints)


def turns(joint: Joint) -> bool:
    """Whether a joint lets its member turn against the node, elastically or plastically."""
    given = (joint.rotational_stiffness, joint.plastic_moment, joint.plastic_moment_negative)
    return any(value is not None for value in given)


def mesh_frame(frame: Frame, lengths: list[Array]) -> FrameMesh:
    """Cut the members into elements of the given lengths (m), in the order of the members."""
    number = {node.name: i for i, node in enumerate(frame.nodes)}
    points = [[node.x, node.y] for node in frame.nodes]
    nodes: list[tuple[int, int]] = []
    joints: list[tuple[int, bool, int, int]] = []
    for index, (member, parts) in enumerate(zip(frame.members, lengths, strict=True)):
        ends = [number[member.start], number[member.end]]
        from_, to = np.array(points[ends[0]]), np.array(points[ends[1]])
        for side, joint in enumerate((member.joint_start, member.joint_end)):
            if turns(frame.joint(joint)):
                joints.append((index, side == 0, ends[side], len(points)))
                points.append(list(points[ends[side]]))
                ends[side] = len(points) - 1
        inner = range(len(points), len(points) + len(parts) - 1)
        shares = np.cumsum(parts[:-1]) / np.sum(parts)
        points.extend((from_ + share * (to - from_)).tolist() for share in shares)
        line = [ends[0], *inner, ends[1]]
        nodes.extend(pairwise(line))
    counts = [len(parts) for parts in lengths]
    return FrameMesh(
        np.array(points),
        np.array(nodes, dtype=np.int64),
        np.repeat(np.arange(len(counts)), counts),
        np.concatenate([[0], np.cumsum(counts)]),
        np.concatenate(lengths),
        tuple(joints),
    )


def member_lengths(
    scenario: FrameScenario,
    smallest: float | None,
    largest: float | None,
    refinement: int,
    share: float,
    depth: float,
    growth: float = 1.5,
    static_share: float = LARGEST_SHARE,
) -> list[Array]:
    """Element lengths (m) of every member.

    Arguments: lengths of the `smallest` element, at both ends of every member, and of the
    `largest` in m (None: a `share` of the shorter member at the struck or driven node, but not
    below `depth` times the depth of the section; 1/40 of the longest member in dynamics,
    `static_share` of it in statics); how often all are halved (negative: doubled); `growth` of
    neighbouring elements.
    Where both lengths are equal the mesh is uniform.
    """
    frame = scenario.frame
    spans = [frame.length(member) for member in frame.members]
    bound = static_share if isinstance(scenario, FrameStatic) else LARGEST_SHARE
    largest = largest or bound * max(spans)
    uniform = smallest == largest
    wanted = smallest or min(share * _shorter(scenario), largest)
    coarser = 2.0 ** max(-refinement, 0)
    result = []
    for member, span in zip(frame.members, spans, strict=True):
        least = wanted if smallest else max(wanted, depth * member.section.height)
        if uniform:
            count = ceil(span / (coarser * wanted) - 1e-9)
            lengths = np.full(count, span / count)
        else:
            ends, inner = coarser * least, coarser * max(largest, least)
            lengths = graded_lengths(span, ends, inner, growth)
        result.append(halved(lengths, max(refinement, 0)))
    return result


def _shorter(scenario: FrameScenario) -> float:
    """Length of the shortest member at the struck or driven node, in m."""
    frame = scenario.frame
    node = scenario.striker.node if isinstance(scenario, FrameImpact) else scenario.node
    there = [m for m in frame.members if node in (m.start, m.end)]
    return min(frame.length(member) for member in there)


def mesh_findings(
    scenario: FrameScenario, lengths: list[Array], sampled: float = 0.5
) -> list[Finding]:
    """Meshes for which the result is known to be off by several percent.

    Arguments: element `lengths` (m) of every member; `sampled`, where an element samples
    plasticity, from its end next to a hinge and over its length.
    """
    frame, findings = scenario.frame, []
    parts = {m.name: p for m, p in zip(frame.members, lengths, strict=True)}
    excess = {}
    for names in chains(frame, _kept(scenario)):
        whole = sum(float(np.sum(parts[name])) for name in names)
        excess[names[0]] = sampled * (parts[names[0]][0] + parts[names[-1]][-1]) / whole
    above = [name for name in excess if excess[name] > LARGEST_EXCESS]
    if above:
        text = (
            f"elements next to the hinges overestimate the resistance of {named(above)} by up to "
            f"{100 * max(excess.values()):.0f} %: refine"
        )
        findings.append(Finding("mesh", text))
    longest = max(float(part.max()) for part in lengths)
    limit = LARGEST_IN_DYNAMICS * max(frame.length(member) for member in frame.members)
    if not isinstance(scenario, FrameStatic) and longest > limit:
        text = (
            f"elements of {longest:.3g} m inside the members are too long for travelling plastic "
            "hinges, peaks may be several percent off: reduce largest_element"
        )
        findings.append(Finding("mesh", text))
    return findings


def _kept(scenario: FrameScenario) -> set[str]:
    kept = {load.node for load in scenario.frame.loads}
    if isinstance(scenario, FrameStatic):
        return kept | {scenario.node} | {load.node for load in scenario.loads}
    return kept | ({scenario.striker.node} if isinstance(scenario, FrameImpact) else set())


def joint_findings(frame: Frame) -> list[Finding]:
    """What a rotational spring at the end of a fiber member leaves out of a joint."""
    used = {m.joint_start for m in frame.members} | {m.joint_end for m in frame.members}
    joints = [joint for joint in frame.joints if joint.name in used]
    strong = [
        j.name
        for j in joints
        if j.plastic_moment is not None or j.plastic_moment_negative is not None
    ]
    axial = [
        j.name
        for j in joints
        if not (j.axial_stiffness is j.tension_resistance is j.compression_resistance is None)
    ]
    findings = []
    if strong:
        text = (
            f"joints {', '.join(strong)} are rotational springs here: their plastic moment does "
            "not depend on the axial force, which overestimates them in catenary action"
        )
        findings.append(Finding("joints", text))
    if axial:
        text = (
            f"joints {', '.join(axial)} are rigid along the member here: axial stiffness and "
            "axial resistances of joints are left out"
        )
        findings.append(Finding("joints", text))
    return findings


def time_spans(
    scenario: FrameImpact, time_step: float | None, halvings: int
) -> list[tuple[float, float]]:
    """End times and time steps (s) of the parts of the record, after so many `halvings`.

    Argument: `time_step` in s (None: from the time of an axial wave and the time to the peak).
    """
    duration, finer = scenario.duration, 2.0**halvings
    if time_step is not None:
        return [(duration, time_step / finer)]
    coarsest = min(max(wave_times(scenario.frame)) / WAVE_STEPS, duration / LEAST_STEPS)
    peak = time_to_peak(scenario)
    first = min(coarsest, peak / PEAK_STEPS)
    later = min(coarsest, LATER * first)
    return [(min(FIRST_SPAN * peak, duration), first / finer), (duration, later / finer)]
