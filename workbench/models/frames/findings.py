"""Where models of frames stop applying: dead loads, buckling, plastic shear demand."""

from __future__ import annotations

from collections.abc import Iterable

from workbench.models.domain import SHEAR_LOSS, shear_bound
from workbench.models.frames.chains import chains
from workbench.models.frames.elastic import ElasticFrame
from workbench.models.frames.stability import dead_load_state
from workbench.models.frames.structure import free_to_spin
from workbench.responses import Finding
from workbench.scenarios import Frame, FrameImpact, FrameScenario, FrameStatic, Member

BUCKLING_WARNING = 2.0  # critical factor below which second-order effects dominate
NAMED = 4  # members that a sentence names


def frame_findings(scenario: FrameScenario) -> list[Finding]:
    """Domain findings that all models of frames without shear deformation share.

    Refusals: dead loads that the frame cannot carry (squash, buckling, mechanism), a moment on a
    node where only pins meet. Warnings: dead loads above half the buckling load; a mechanism that
    no dead load meets; members whose bending mechanism needs more shear force than models without
    shear yielding allow.
    """
    frame = scenario.frame
    findings = []
    spinning = {frame.nodes[number].name for number in free_to_spin(frame)}
    pattern = scenario.loads if isinstance(scenario, FrameStatic) else ()
    twisted = [p.node for p in (*frame.loads, *pattern) if p.moment and p.node in spinning]
    if twisted:
        text = f"a moment acts on node {twisted[0]}, where only pins meet: nothing resists it"
        findings.append(Finding("mechanism", text, refusal=True))
    elif frame.loads:
        findings += _dead_load_findings(frame)
    elif isinstance(scenario, FrameStatic) and ElasticFrame(frame).is_mechanism:
        text = (
            "for small displacements the frame is a mechanism: something moves without resistance "
            "until its shape has changed"
        )
        findings.append(Finding("mechanism", text))
    return findings + _shear_findings(scenario)


def _dead_load_findings(frame: Frame) -> list[Finding]:
    """What the dead loads do to the elastic frame, springs and locks left out."""
    state = dead_load_state(frame)
    if state.factor is None:
        text = "under its dead loads the frame is a mechanism: it moves without resistance"
        return [Finding("mechanism", text, refusal=True)]
    findings = []
    for member, force in zip(frame.members, state.axial, strict=True):
        squash = axial_resistance(frame, member, compression=bool(force < 0.0))
        if abs(force) >= squash:
            text = (
                f"dead loads bring {force / 1e3:.4g} kN (tension positive) into member "
                f"{member.name}, which resists {squash / 1e3:.4g} kN"
            )
            findings.append(Finding("squash", text, refusal=True))
    if state.factor <= 1.0:
        text = f"the frame buckles elastically under {state.factor:.3g} of its dead loads"
        findings.append(Finding("buckling", text, refusal=True))
    elif state.factor < BUCKLING_WARNING:
        text = (
            f"dead loads are {1.0 / state.factor:.2f} of those under which the elastic frame "
            "buckles: second-order bending between the hinges, which rigid bars lack, matters"
        )
        findings.append(Finding("buckling", text))
    return findings


def axial_resistance(frame: Frame, member: Member, *, compression: bool) -> float:
    """Plastic axial resistance of a member and its joints, in N."""
    least = frame.properties(member).squash_load
    for name in (member.joint_start, member.joint_end):
        joint = frame.joint(name)
        given = joint.compression_resistance if compression else joint.tension_resistance
        least = min(least, least if given is None else given)
    return least


def shear_demand(scenario: FrameScenario) -> dict[str, float]:
    """Shear force of a bending mechanism over the plastic shear resistance, per member.

    An upper bound for members without loads between their ends: plastic moments (without axial
    force) at both ends over the length, zero at pins. Members that continue each other without a
    load or striker between them count as one.
    """
    frame = scenario.frame
    kept = {load.node for load in frame.loads}
    kept |= {node.name for node in frame.nodes if node.mass > 0.0}
    if isinstance(scenario, FrameStatic):
        kept |= {scenario.node} | {load.node for load in scenario.loads}
    elif isinstance(scenario, FrameImpact):
        kept.add(scenario.striker.node)
    demand = {}
    for names in chains(frame, kept):
        members = [frame.member(name) for name in names]
        length = sum(frame.length(member) for member in members)
        outer = [*_outer(frame, members)]
        moment = sum(_end_moment(frame, member, at_start) for member, at_start in outer)
        for member in members:
            demand[member.name] = moment / length / frame.properties(member).shear_resistance
    return demand


def _outer(frame: Frame, members: list[Member]) -> Iterable[tuple[Member, bool]]:
    """The two ends of a chain: member, and whether it is its start."""
    first, last = members[0], members[-1]
    if first is last:
        return ((first, True), (first, False))
    inner = {members[1].start, members[1].end}
    before = {members[-2].start, members[-2].end}
    return ((first, first.start not in inner), (last, last.start not in before))


def _end_moment(frame: Frame, member: Member, at_start: bool) -> float:
    """Largest moment that the end of a member can carry, in N m."""
    joint = frame.joint(member.joint_start if at_start else member.joint_end)
    node = frame.node(member.start if at_start else member.end)
    others = [m for m in frame.members if m is not member and node.name in (m.start, m.end)]
    free = not others and "rotation" not in node.held and node.spring_rotation == 0.0
    if joint.rotational_stiffness == 0.0 or free:
        return 0.0
    own = frame.properties(member).plastic_moment
    given = [joint.plastic_moment, joint.plastic_moment_negative]
    return min(own, max((m for m in given if m is not None), default=own))


def _shear_findings(scenario: FrameScenario) -> list[Finding]:
    """Members in which models without shear yielding may overestimate the resistance."""
    frame, demand = scenario.frame, shear_demand(scenario)
    bounds = {name: shear_bound(frame.strength_section(name)) for name in demand}
    worst = sorted(demand, key=lambda name: -demand[name])
    findings = []
    above = [name for name in worst if demand[name] > 1.0]
    if above:
        text = (
            f"a plastic mechanism needs up to V/Vpl = {demand[above[0]]:.2f} in {named(above)}: "
            "webs yield in shear before, so that every model without shear yielding overestimates "
            "the plastic resistance"
        )
        findings.append(Finding("shear", text))
    near = [name for name in worst if bounds[name] < demand[name] <= 1.0]
    if near:
        least = min(bounds[name] for name in near)
        text = (
            f"a plastic mechanism needs up to V/Vpl = {demand[near[0]]:.2f} in {named(near)}: "
            f"above {least:.2f} shear yielding takes more than {100 * SHEAR_LOSS:g} % of the "
            "resistance, which models without it leave out"
        )
        findings.append(Finding("shear", text))
    return findings


def named(members: list[str]) -> str:
    """Names of members for a sentence, the first few of many."""
    more = f" and {len(members) - NAMED} more" if len(members) > NAMED else ""
    return ("member " if len(members) == 1 else "members ") + ", ".join(members[:NAMED]) + more
