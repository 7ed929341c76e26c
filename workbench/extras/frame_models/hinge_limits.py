"""Limits of hinges: catenary action, axial forces, cycles, wear, plates that buckle."""

from dataclasses import replace
from typing import Any

import numpy as np

from workbench.base.arrays import Array
from workbench.extras.frame_models.bars import PlasticEnd
from workbench.mechanics.frames.elastic import dead_load_state
from workbench.mechanics.frames.members import named, shear_demand
from workbench.responses import Finding, finding
from workbench.scenarios import (
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    Member,
)
from workbench.steel.sections import CircularTube, ISection
from workbench.steel.sections.slenderness import (
    TESTED,
    lateral_torsional,
    plate_classes,
    shares_by_class,
    tested_ratios,
)

CATENARY = 0.5  # Mp / Npl, from where hinges are drawn out
AXIAL_SHARE = 0.15  # of the squash load; EN 1993-1-1, 6.2.9.1: an I section then loses some moment


def catenary_reach(scenario: FrameImpact) -> float:
    """Displacement that takes the energy of a hit, over Mp / Npl of the struck member.

    By the mechanism of the struck members between their joints; from about 1 on the axial force
    of a member that is held carries as much as its moments do.
    """
    frame, demand = scenario.frame, shear_demand(scenario)
    struck = [end.member for end in frame.meeting(scenario.striker.node)]
    force = sum(demand[m.name] * frame.properties(m).shear_resistance for m in struck)
    whole = frame.properties(struck[0])
    return scenario.input_energy * whole.squash_load / max(force * whole.plastic_moment, 1e-300)


def catenary_findings(event: FrameScenario) -> list[Finding]:
    """Warning of hits into catenary action, for hinges that do not stretch as they flow."""
    if not isinstance(event, FrameImpact) or (reach := catenary_reach(event)) <= CATENARY:
        return []
    return [finding("catenary", reach, reach=reach)]


def cycle_findings(event: FrameScenario, effect: str) -> list[Finding]:
    """Warning of repeated loading, which has an `effect` on hinges."""
    cyclic = isinstance(event, FrameStatic) and len(event.path) > 1
    shaken = isinstance(event, FrameGroundMotion)
    return [finding("cycles", effect=effect)] if cyclic or shaken else []


def axial_findings(frame: Frame, effect: str) -> list[Finding]:
    """Warning of dead loads that are a share of a squash load that has an `effect` on hinges."""
    shares = np.abs(dead_load_state(frame).axial) / frame.each("squash_load")
    worst = int(shares.argmax())
    if shares[worst] <= AXIAL_SHARE:
        return []
    share, member = float(shares[worst]), frame.members[worst].name
    return [finding("interaction", share, effect=effect, share=share, member=member)]


def wear_findings(event: FrameScenario, known: bool) -> list[Finding]:
    """Of hinges that wear: hits that draw them out; unless it is `known`, their capacity.

    Refusal of members whose rotation capacity is not tested, warning of those outside the tests.
    """
    findings, frame = [], event.frame
    if isinstance(event, FrameImpact) and (reach := catenary_reach(event)) > CATENARY:
        findings.append(finding("wear-in-catenary", reach, reach=reach))
    if known:
        return findings
    unknown = [m.name for m in frame.members if not isinstance(m.section.shape, ISection)]
    if unknown:
        return [*findings, finding("wear-unknown", members=named(unknown))]
    outside = [
        (member.name, f"{name} = {value:.3g} ({low:g} to {high:g})")
        for member in frame.members
        for (name, value), (low, high) in zip(
            tested_ratios(member.section, frame.steel).items(), TESTED.values(), strict=True
        )
        if not low <= value <= high
    ]
    if outside:
        names, ratios = (list(dict.fromkeys(each)) for each in zip(*outside, strict=True))
        findings.append(finding("wear-range", members=named(names), ratios=", ".join(ratios)))
    return findings


def class_findings(frame: Frame) -> list[Finding]:
    """Warnings of members of class 3 and 4, refusal of circular tubes of class 4."""
    findings, classes = [], {m: plate_classes(m.section, frame.steel) for m in frame.members}
    round_ones = [m for m in classes if isinstance(m.section.shape, CircularTube)]
    if thin := [m.name for m in round_ones if max(classes[m]) == 4]:
        return [finding("local-buckling-round", members=named(thin))]
    slender = [m for m in classes if max(classes[m]) > 2]
    if slender:
        shares = [strength_shares(frame, member) for member in slender]
        axial, moment = (min(each) for each in zip(*shares, strict=True))
        names = named([m.name for m in slender])
        findings.append(finding("local-buckling", moment, members=names, axial=axial))
    return findings


def strength_shares(frame: Frame, member: Member) -> tuple[float, float]:
    """Shares of squash load in compression and plastic moment that a member's plates leave."""
    return shares_by_class(member.section, frame.strength_section(member), frame.steel)


def buckled_end(end: PlasticEnd, frame: Frame, member: Member) -> PlasticEnd:
    """The end of a member, with no more strength than its plates leave."""
    (axial, moment), whole = strength_shares(frame, member), frame.properties(member)
    compression = min(end.axial[1], axial * whole.squash_load)
    first, last = (min(each, moment * whole.plastic_moment) for each in end.moments)
    return replace(end, axial=(end.axial[0], compression), moments=(first, last))


def lateral_findings(frame: Frame, moments: Array, length: float, by_class: bool) -> list[Finding]:
    """The I section worst off in lateral-torsional buckling.

    Arguments: `moments` (hinges, steps) of a run in N m; `length` in m between lateral restraints;
    whether the moment that resists is that `by_class`.
    """
    rows = []
    largest = np.abs(moments).reshape(len(frame.members), -1).max(axis=1)
    for member, moment in zip(frame.members, largest, strict=True):
        if isinstance(member.section.shape, ISection) and moment > 0.0:
            resists = frame.properties(member).plastic_moment
            resists *= strength_shares(frame, member)[1] if by_class else 1.0
            chi = lateral_torsional(member.section.shape, frame.steel, length, resists)
            rows.append((float(moment / chi.resistance), member.name, chi))
    if not rows:
        return []
    number, name, chi = max(rows, key=lambda row: row[0])
    key, critical = "torsional" if number > 1.0 else "check", chi.critical / 1e3
    values: dict[str, Any] = {"length": length, "chi": chi.factor, "critical": critical}
    return [finding(f"lateral-{key}", number, member=name, **values)]
