"""Members of a frame: straight lines of them, fiber sections, plastic shear demand."""

from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np

from workbench.materials import Steel
from workbench.responses import Finding, finding
from workbench.scenarios import Frame, FrameImpact, FramePulse, FrameScenario, FrameStatic, Member
from workbench.sections import CircularTube, ISection, Rectangle, Section
from workbench.structures.fibers.section import BeamSection, LinearHardening

STRAIGHT = 1e-6  # sine of the largest kink
NAMED = 4  # members that a sentence names

End = tuple[str, bool]  # name of a member, and whether it is its start


class Chain(NamedTuple):
    """Names of the `members` and `nodes` in their order from one end of the chain to the other.

    `ends`: the outermost members, and whether that end is the member's own start.
    """

    members: tuple[str, ...]
    nodes: tuple[str, ...]
    ends: tuple[End, End]

    def joints(self, frame: Frame) -> tuple[str, str]:
        """Names of the joints at both ends."""
        first, last = (_joint(frame, end) for end in self.ends)
        return first, last


def chains(frame: Frame, kept: Collection[str] = ()) -> list[Chain]:
    """All chains of a frame.

    Two members continue each other at a free node where only they meet, rigidly and in one line.
    Argument: `kept`, names of nodes that end a chain all the same.
    """
    ends: dict[str, list[End]] = {}
    for member in frame.members:
        ends.setdefault(member.start, []).append((member.name, True))
        ends.setdefault(member.end, []).append((member.name, False))
    follows: dict[End, End] = {}
    for node in frame.nodes:
        pair = ends.get(node.name, [])
        if len(pair) == 2 and node.name not in kept and _straight_on(frame, node.name, pair):
            follows[pair[0]], follows[pair[1]] = pair[1], pair[0]
    lines: list[Chain] = []
    done: set[str] = set()
    for member in frame.members:
        if member.name in done:
            continue
        names, nodes = [member.name], [member.start, member.end]
        outer = {True: (member.name, True), False: (member.name, False)}
        for at_start, end in outer.items():
            while end in follows and follows[end][0] not in names:
                name, came_in = follows[end]
                end = (name, not came_in)
                names.insert(0 if at_start else len(names), name)
                far = frame.member(name)
                nodes.insert(0 if at_start else len(nodes), far.end if came_in else far.start)
            outer[at_start] = end
        done.update(names)
        lines.append(Chain(tuple(names), tuple(nodes), (outer[True], outer[False])))
    return lines


def eventful(scenario: FrameScenario) -> set[str]:
    """Names of the nodes that are loaded, struck or driven, where a hinge may form."""
    nodes = {load.node for load in scenario.frame.loads}
    if isinstance(scenario, FrameStatic):
        return nodes | {scenario.node} | {load.node for load in scenario.loads}
    if isinstance(scenario, FramePulse):
        return nodes | {load.node for load in scenario.loads}
    return nodes | ({scenario.striker.node} if isinstance(scenario, FrameImpact) else set())


def _joint(frame: Frame, end: End) -> str:
    member = frame.member(end[0])
    return member.joint_start if end[1] else member.joint_end


def _straight_on(frame: Frame, node: str, pair: list[End]) -> bool:
    """Whether the two members that meet at a node continue each other."""
    at = frame.node(node)
    if at.held or max(at.spring_x, at.spring_y, at.spring_rotation) > 0.0 or at.locked != "none":
        return False
    directions = []
    for name, starts_here in pair:
        member = frame.member(name)
        if _joint(frame, (name, starts_here)) != "rigid":
            return False
        far = frame.node(member.end if starts_here else member.start)
        direction = np.array([far.x - at.x, far.y - at.y])
        directions.append(direction / np.hypot(*direction))
    (ax, ay), (bx, by) = directions
    return bool(ax * bx + ay * by < 0.0 and abs(ax * by - ay * bx) < STRAIGHT)


def named(members: Sequence[str]) -> str:
    """Names of members for a sentence, the first few of many."""
    more = f" and {len(members) - NAMED} more" if len(members) > NAMED else ""
    return ("member " if len(members) == 1 else "members ") + ", ".join(members[:NAMED]) + more


SHEAR_LOSS = 0.05  # of the resistance, by shear yielding
ROUND_OFF = 1e-9
SOLID_BOUND = 0.45  # V/Vpl at which a solid square has lost that, study `shear_domain`


def fiber_section(frame: Frame, member: Member, layers: int, hardening_ratio: float) -> BeamSection:
    """Fibers of a member's strength section, rigid in shear, with its material and mass.

    Arguments: `layers` over the depth; kinematic hardening over the elastic modulus.
    """
    steel = frame.steel
    y, area = frame.strength_section(member).fibers(layers)
    modulus = steel.elastic_modulus
    hardening = steel.hardening_modulus or hardening_ratio * modulus
    law = LinearHardening(modulus, steel.yield_stress, hardening, rate=steel.rate)
    return BeamSection(y, area, law, frame.properties(member).mass_per_length)


def residual_findings(frame: Frame, pattern: str) -> list[Finding]:
    """Refusal of a `pattern` of residual stresses in sections that it is not known of."""
    others = [m.name for m in frame.members if not isinstance(m.section.shape, ISection)]
    if pattern == "none" or not others:
        return []
    return [finding("residual-stress", pattern=pattern, members=named(others))]


def shear_stiffness(section: Section, steel: Steel) -> float:
    """Elastic shear stiffness of a section in N: G A_v, with 5/6 of A for a rectangle."""
    share = 5.0 / 6.0 if isinstance(section.shape, Rectangle) else 1.0
    return share * steel.shear_modulus * section.shear_area


@lru_cache(maxsize=256)
def shear_bound(section: Section) -> float:
    """V/Vpl from which shear yielding takes more than 5 % of a member's resistance.

    Sections with webs: the strength of the webs falls by (2 V/Vpl - 1)^2 (EN 1993-1-1, 6.2.8),
    so that the bound depends on their share in the plastic modulus: 0.85 for HEB 220, 0.73 for
    IPE 300. Beams and solids in the study `shear_domain` reach 5 % there or up to 8 % later.
    Sections without flanges yield in shear at mid-height long before that rule says so: the bound
    is what the study found for a square, also for circular tubes, which it does not hold.
    """
    shape = section.shape
    if isinstance(shape, (Rectangle, CircularTube)):
        return SOLID_BOUND
    web = shape.bands[0]
    share = web.width * web.top**2 / section.plastic_section_modulus
    return min(0.5 * (1.0 + sqrt(SHEAR_LOSS / share)), 1.0)


def shear_demand(scenario: FrameScenario) -> dict[str, float]:
    """Shear force of a bending mechanism over the plastic shear resistance, per member.

    An upper bound for members without loads between their ends: plastic moments (without axial
    force) at both ends over the length, zero at pins; under a line load twice the sum of these and
    of two in the span over the length. Members that continue each other without a load or striker
    between them count as one.
    """
    frame, demand = scenario.frame, {}
    pressed = scenario.members if isinstance(scenario, FramePulse) else ()
    heavy = {node.name for node in frame.nodes if node.mass > 0.0}
    for chain in chains(frame, eventful(scenario) | heavy):
        length = sum(frame.length(name) for name in chain.members)
        moment = sum(_end_moment(frame, frame.member(name), start) for name, start in chain.ends)
        if set(chain.members) & set(pressed):
            moment = 2.0 * (moment + 2.0 * frame.properties(chain.members[0]).plastic_moment)
        for name in chain.members:
            demand[name] = moment / length / frame.properties(name).shear_resistance
    return demand


def _end_moment(frame: Frame, member: Member, at_start: bool) -> float:
    """Largest moment that the end of a member can carry, in N m."""
    joint = frame.joint(member.joint_start if at_start else member.joint_end)
    node = frame.node(member.start if at_start else member.end)
    others = [m for m in frame.members if m is not member and node.name in (m.start, m.end)]
    free = not others and "rotation" not in node.held and node.spring_rotation == 0.0
    if joint.rotational_stiffness == 0.0 or free:
        return 0.0
    moment = frame.properties(member).plastic_moment
    given = [joint.plastic_moment, joint.plastic_moment_negative]
    return min(moment, max((m for m in given if m is not None), default=moment))


def shear_findings(
    scenario: FrameScenario, members: Collection[str] | None = None
) -> list[Finding]:
    """Members (None: all) in which lack of shear yielding may overestimate the resistance."""
    demand = shear_demand(scenario)
    if members is not None:
        demand = {name: share for name, share in demand.items() if name in members}
    return _ratio_findings("shear", scenario.frame, demand, "a plastic mechanism needs up to")


def shear_reached(scenario: FrameScenario, reached: Mapping[str, float]) -> list[Finding]:
    """Members whose shear force, mean along them, has `reached` more than they carry.

    Arguments: V/Vpl by member, as a run without shear yielding found it. The mean is that of the
    end moments, so that no more counts than a mechanism needs, see `shear_demand`: what a run has
    beyond it is rotary inertia in the first waves. Of 34 frames (`fiber-reissner` against
    `fiber-shear`) all ten that were more than 7 % off passed the bounds, and three others.
    """
    demand = shear_demand(scenario)
    needed = {name: min(share, demand[name]) for name, share in reached.items()}
    source = "the mean along the member reaches"
    return _ratio_findings("shear-reached", scenario.frame, needed, source)


def _ratio_findings(
    subject: str, frame: Frame, ratios: Mapping[str, float], source: str
) -> list[Finding]:
    """Findings of V/Vpl by member, `source` in words: above one, and above the bound."""
    worst = [name for name in ratios if ratios[name] > SOLID_BOUND]  # which is the least of all
    worst.sort(key=lambda name: -ratios[name])
    bounds = {name: shear_bound(frame.strength_section(name)) for name in worst}
    findings = []
    above = [name for name in worst if ratios[name] > 1.0 + ROUND_OFF]
    near = [name for name in worst if bounds[name] < ratios[name] <= 1.0 + ROUND_OFF]
    least = min((bounds[name] for name in near), default=1.0)
    for key, names in (("webs-yield", above), ("webs-weaken", near)):
        if names:
            ratio = ratios[names[0]]
            loss, where = 100 * SHEAR_LOSS, named(names)
            findings.append(
                finding(key, ratio, subject, source=source, members=where, least=least, loss=loss)
            )
    return findings
