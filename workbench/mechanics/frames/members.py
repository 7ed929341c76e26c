"""Members of a frame: straight lines, fiber sections, plastic shear demand, spread of yield."""

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Number
from workbench.mechanics.structures.fibers import BeamSection, section_fibers
from workbench.mechanics.structures.fibers.section import Law, LinearHardening, ShearYielding
from workbench.responses import Finding, Response, finding
from workbench.scenarios import Frame, FrameImpact, FramePulse, FrameScenario, FrameStatic, Member
from workbench.scenarios.parts import MemberEnd, Node
from workbench.steel.hinges.interaction import SHEARED
from workbench.steel.materials import Steel
from workbench.steel.sections import CircularTube, ISection, Rectangle, Section, TurnedISection

STRAIGHT = 1e-6  # sine of the largest kink
NAMED = 4  # members that a sentence names
SAME = 0.01  # relative difference of an override from what a model makes of it that counts as none
SPREAD, MATTERS = "spread", 0.1  # subject; share of the displacement
BENT, FIBERS, POINTS = np.geomspace(1.0, 20.0, 60), 80, 101  # curvatures over that of first yield


class Chain(NamedTuple):
    """Names of the `members` and `nodes` in their order from one end of the chain to the other.

    `ends`: those of the outermost members.
    """

    members: tuple[str, ...]
    nodes: tuple[str, ...]
    ends: tuple[MemberEnd, ...]


def chains(frame: Frame, kept: Collection[str] = ()) -> list[Chain]:
    """All chains of a frame.

    Two members continue each other at a free node where only they meet, rigidly and in one line.
    Argument: `kept`, names of nodes that end a chain all the same.
    """
    return list(_chains(frame.elastic, frozenset(kept)))


@lru_cache(maxsize=64)
def _chains(frame: Frame, kept: frozenset[str]) -> tuple[Chain, ...]:
    follows: dict[MemberEnd, MemberEnd] = {}
    for node in frame.nodes:
        pair = frame.meeting(node.name)
        if len(pair) == 2 and node.name not in kept and _straight_on(frame, node, pair):
            follows[pair[0]], follows[pair[1]] = pair[1], pair[0]
    lines: list[Chain] = []
    done: set[str] = set()
    for member in frame.members:
        if member.name in done:
            continue
        names, nodes = [member.name], [member.start, member.end]
        outer = []
        for end in member.ends:
            at_start = end.at_start
            while end in follows and follows[end].member.name not in names:
                end = follows[end].other
                names.insert(0 if at_start else len(names), end.member.name)
                nodes.insert(0 if at_start else len(nodes), end.node)
            outer.append(end)
        done.update(names)
        lines.append(Chain(tuple(names), tuple(nodes), tuple(outer)))
    return tuple(lines)


def eventful(scenario: FrameScenario) -> set[str]:
    """Names of the nodes that are loaded, struck or driven, where a hinge may form."""
    nodes = {load.node for load in scenario.frame.loads}
    if isinstance(scenario, FrameStatic):
        return nodes | {scenario.node} | {load.node for load in scenario.loads}
    if isinstance(scenario, FramePulse):
        return nodes | {load.node for load in scenario.loads}
    return nodes | ({scenario.striker.node} if isinstance(scenario, FrameImpact) else set())


def _straight_on(frame: Frame, node: Node, pair: list[MemberEnd]) -> bool:
    """Whether the two members that meet at a node continue each other."""
    if node.resisted or any(end.joint != "rigid" for end in pair):
        return False
    far = [frame.number[end.other.node] for end in pair]
    directions = frame.points[far] - frame.points[frame.number[node.name]]
    first, second = directions / np.linalg.norm(directions, axis=1)[:, None]
    return bool(np.linalg.norm(first + second) < STRAIGHT)


def named(members: Sequence[str]) -> str:
    """Names of members for a sentence, the first few of many."""
    more = f" and {len(members) - NAMED} more" if len(members) > NAMED else ""
    return ("member " if len(members) == 1 else "members ") + ", ".join(members[:NAMED]) + more


SHEAR_LOSS = 0.05  # of the resistance, by shear yielding
ROUND_OFF = 1e-9
SOLID_BOUND = 0.45  # V/Vpl at which a solid square has lost that, study `shear_domain`


CALIBRATED = 40  # layers of the fibers that hinges and surfaces are calibrated on
# of fibers over the depth of a section
LAYERS = Number(4, 1000, integer=True, even=True, advice="an odd number loses moment")


def fiber_section(
    frame: Frame,
    member: Member,
    layers: int,
    law: Law | None = None,
    pattern: str = "none",
    *,
    sheared: bool = False,
) -> BeamSection:
    """Fibers of a member's strength section, with their law (None: of the steel) and its mass.

    Arguments: `layers` over the depth; `pattern` of residual stresses; whether the section is
    `sheared` elastically, where it does not yield in the fibers along the shear force.
    """
    section, steel = frame.strength_section(member), frame.steel
    fibers, yields = section_fibers(section, layers, pattern), isinstance(law, ShearYielding)
    material = law or LinearHardening.of(steel), frame.properties(member).mass_per_length
    shear = shear_stiffness(section, steel) if sheared and not yields else 0.0
    share, stress = fibers.share if yields else None, steel.yield_stress * fibers.residual
    return BeamSection(fibers.y, fibers.area, *material, shear, share, stress)


def fiber_overrides(frame: Frame, layers: int) -> list[Finding]:
    """Overrides of section values that so many layers of fibers leave out."""

    def values(section: Section, steel: Steel) -> dict[str, float]:
        y, area = section.fibers(layers)
        return {
            "area": np.sum(area),
            "second_moment": np.sum(y**2 * area),
            "plastic_moment": steel.yield_stress * np.sum(np.abs(y) * area),
            "squash_load": steel.yield_stress * np.sum(area),
        }

    return override_findings(frame, values, "fibers come")


def override_findings(
    frame: Frame, values: Callable[[Section, Steel], Mapping[str, float]], shape: str
) -> list[Finding]:
    """Overrides of section values that differ by over 1 % from what a model makes of the section.

    Arguments: these `values`, of the section that gives the strength; `shape`, what of the model
    comes from the section alone.
    """
    members = defaultdict(list)  # by the difference
    for member in frame.members:
        for key, value in values(frame.strength_section(member), frame.steel).items():
            given = getattr(member, key)
            if given is not None and abs(given / value - 1.0) > SAME:
                members[f"{key} = {given:.5g} against {value:.5g}"].append(member.name)
    if not members:
        return []
    texts = [f"{difference} ({named(names)})" for difference, names in members.items()]
    more = f" and {len(texts) - 4} more" if len(texts) > 4 else ""
    return [finding("section", shape=shape, differences=", ".join(texts[:4]) + more)]


def residual_findings(frame: Frame, pattern: str) -> list[Finding]:
    """Refusal of a `pattern` of residual stresses in sections that it is not known of."""
    kinds = ISection | TurnedISection
    others = [m.name for m in frame.members if not isinstance(m.section.shape, kinds)]
    if pattern == "none" or not others:
        return []
    return [finding("residual-stress", pattern=pattern, members=named(others))]


def shear_stiffness(section: Section, steel: Steel) -> float:
    """Elastic shear stiffness of a section in N: G A_v, of upright rectangles a share of it."""
    return SHEARED.get(type(section.shape), 1.0) * steel.shear_modulus * section.shear_area


@lru_cache(maxsize=256)
def shear_bound(section: Section) -> float:
    """V/Vpl from which shear yielding takes more than 5 % of a member's resistance.

    Sections with webs: the strength of the webs falls by (2 V/Vpl - 1)^2 (EN 1993-1-1, 6.2.8),
    so that the bound depends on their share in the plastic modulus: 0.85 for HEB 220, 0.73 for
    IPE 300. Beams and solids in the study `shear_domain` reach 5 % there or up to 8 % later.
    Sections without flanges yield in shear at mid-height long before that rule says so: the bound
    is what the study found for a square, also for circular tubes, which it does not hold, and for
    I sections bent about the weak axis.
    """
    shape = section.shape
    if isinstance(shape, (Rectangle, CircularTube, TurnedISection)):
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
    lines = np.hypot(*frame.line_loads.T).tolist()
    number = {member.name: i for i, member in enumerate(frame.members)}
    for chain in chains(frame, eventful(scenario) | heavy):
        length = sum(frame.length(name) for name in chain.members)
        moment = sum(_end_moment(frame, end) for end in chain.ends)
        if set(chain.members) & set(pressed):
            moment = 2.0 * (moment + 2.0 * frame.properties(chain.members[0]).plastic_moment)
        dead = 0.5 * sum(lines[number[name]] * frame.length(name) for name in chain.members)
        for name in chain.members:
            demand[name] = (moment / length + dead) / frame.properties(name).shear_resistance
    return demand


def _end_moment(frame: Frame, end: MemberEnd) -> float:
    """Largest moment that the end of a member can carry, in N m."""
    joint, alone = frame.joint(end.joint), len(frame.meeting(end.node)) == 1
    free = alone and "rotation" not in frame.node(end.node).resisted
    if joint.rotational_stiffness == 0.0 or free:
        return 0.0
    moment = frame.properties(end.member).plastic_moment
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


def spread_findings(scenario: Any, response: Response) -> list[Finding]:
    """Warning of yield between hinges, which they leave out, at the largest displacement of a push.

    By virtual work with the moments of the run as virtual ones, linear between the ends of members,
    on curvatures of sections without axial force: what those add to the displacement of elastic
    bending and hinges at the same load, or take of the force at the same displacement.
    """
    frame, row = scenario.frame, int(np.abs(response["displacement"].values).argmax())
    moments, turned = (
        response[name].values[:, row].reshape(-1, 2) for name in ("moment", "plastic_rotation")
    )
    shares, zones = np.linspace(0.5, 1.0, 101), {}
    hinges, elastic, extra = float(np.abs(moments * turned).sum()), 0.0, np.zeros(len(shares))
    for member, (first, last) in zip(frame.members, moments, strict=True):
        whole = frame.properties(member)
        bent = np.abs(np.linspace(first, last, POINTS)) / whole.plastic_moment
        moment, plastic = _beyond_elastic(frame.strength_section(member))
        unit = frame.length(member) * whole.plastic_moment**2
        unit /= frame.steel.elastic_modulus * whole.second_moment
        elastic += unit * float(np.mean(bent**2))
        curvatures = np.interp(np.outer(shares, bent), moment, plastic)
        extra += unit * (np.mean(bent * curvatures, axis=1) - (1.0 - shares) * np.mean(bent**2))
        zones[member.name] = float(np.mean(bent > moment[0]))
    if scenario.control == "load":
        key, share = SPREAD, float(extra[-1]) / max(elastic + hinges, 1e-300)
    else:  # hinges that turn stand for as much that yields between them
        kept = float(shares[extra <= hinges].max(initial=shares[0]))
        key, share = "spread-of-force", 1.0 - kept
    if share <= MATTERS:
        return []
    member = max(zones, key=lambda name: zones[name])
    values = {"zone": zones[member], "member": member, "percent": 100.0 * share, "limit": MATTERS}
    return [finding(key, share, **values)]


@lru_cache(maxsize=256)
def _beyond_elastic(section: Section) -> tuple[Array, Array]:
    """Moments and plastic curvatures times EI, over the plastic moment, from first yield on."""
    y, area = section.fibers(FIBERS)
    stress = np.clip(BENT[:, None] * y * 2.0 / section.height, -1.0, 1.0)
    moment = stress @ (y * area) / float(np.abs(y) @ area)
    return moment, BENT * moment[0] - moment
