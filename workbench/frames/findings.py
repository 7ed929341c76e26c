"""Where models of frames stop applying: dead loads, buckling, plastic shear demand."""

from collections.abc import Sequence

from workbench.frames.collapse_load import member_strength
from workbench.frames.elastic import ElasticFrame, dead_load_state
from workbench.frames.shear import shear_findings
from workbench.frames.structure import free_to_spin
from workbench.responses import Finding, finding
from workbench.scenarios import (
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameScenario,
    FrameStatic,
)

BUCKLING_WARNING = 2.0  # critical factor below which second-order effects dominate
_ENOUGH = 8  # bars of members that a light striker does not hit: their first modes within 3 %
_MUCH_SHARED = 0.08  # of the energy, lost in the first collision with the elements beside it
_SHARE = 0.1  # of the mass, that may be missing


def frame_findings(scenario: FrameScenario) -> list[Finding]:
    """Domain findings that all models of frames without shear deformation share.

    Refusals: dead loads that the frame cannot carry (squash, buckling, mechanism), a moment on a
    node where only pins meet. Warnings: dead loads above half the buckling load, or without mass
    where the ground moves; a mechanism that no dead load meets; members whose bending mechanism
    needs more shear force than models without shear yielding allow.
    """
    frame = scenario.frame
    findings = []
    spinning = {frame.nodes[number].name for number in free_to_spin(frame)}
    pattern = scenario.loads if isinstance(scenario, FrameStatic | FramePulse) else ()
    twisted = [p.node for p in (*frame.loads, *pattern) if p.moment and p.node in spinning]
    if twisted:
        findings.append(finding("moment-on-pins", node=twisted[0]))
    elif frame.loads:
        findings += _dead_load_findings(frame)
    elif isinstance(scenario, FrameStatic) and ElasticFrame(frame).is_mechanism:
        findings.append(finding("mechanism"))
    if isinstance(scenario, FrameGroundMotion) and not scenario.load_as_mass:
        findings += _massless_findings(frame)
    return findings + shear_findings(scenario)


def _massless_findings(frame: Frame) -> list[Finding]:
    """Warning of dead loads whose mass no node has, so that the ground does not shake it."""
    masses = {node.name: node.mass for node in frame.nodes}
    missing = sum(max(mass - masses[node], 0.0) for node, mass in frame.load_masses.items())
    steel = sum(frame.properties(m).mass_per_length * frame.length(m) for m in frame.members)
    there = steel + sum(masses.values())
    if missing <= _SHARE * there:
        return []
    return [finding("mass", missing / there, missing=missing, there=there)]


def _dead_load_findings(frame: Frame) -> list[Finding]:
    """What the dead loads do to the elastic frame, springs and locks left out."""
    state = dead_load_state(frame)
    if state.factor is None:
        return [finding("mechanism-under-dead-loads")]
    findings = []
    for member, force in zip(frame.members, state.axial, strict=True):
        squash = member_strength(frame, member)[int(force < 0.0)]
        if abs(force) >= squash:
            ratio = float(abs(force) / squash)
            values = {"force": force / 1e3, "resistance": squash / 1e3}
            findings.append(finding("squash", ratio, member=member.name, **values))
    if state.factor <= 1.0:
        findings.append(finding("buckles", state.factor, factor=state.factor))
    elif state.factor < BUCKLING_WARNING:
        findings.append(finding("buckling", state.factor, share=1.0 / state.factor))
    return findings


def hit_mass_findings(scenario: FrameScenario, parts: Sequence[int]) -> list[Finding]:
    """Warnings of a striker that is light beside the members it hits, or beside their elements.

    Lumped mass of elements takes energy in the first collision, which a beam keeps.
    """
    if not isinstance(scenario, FrameImpact):
        return []
    frame, striker = scenario.frame, scenario.striker
    struck = [(n, m) for n, m in enumerate(frame.members) if striker.node in (m.start, m.end)]
    steel = {n: frame.properties(m).mass_per_length * frame.length(m) for n, m in struck}
    shared = sum(mass / parts[number] / 3.0 for number, mass in steel.items())
    lost = (1.0 - striker.restitution**2) * shared / (shared + striker.mass)
    share = striker.mass / sum(steel.values())
    fewest = min((each for n, each in enumerate(parts) if n not in steel), default=_ENOUGH)
    light = []
    if share < 1.0 and fewest < _ENOUGH:
        wanted = _ENOUGH
        light = [finding("light-striker", share, share=share, fewest=fewest, wanted=wanted)]
    if lost <= _MUCH_SHARED:
        return light
    hit = finding("hit-mass", lost, node=striker.node, mass=shared, percent=100.0 * lost)
    return [*light, hit]
