"""Where member models stop applying: loads, stability, shear, webs; odd input; hits beside."""

from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import lru_cache
from math import sqrt, tan
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.catalogue import load
from workbench.base.codec import set_inputs
from workbench.mechanics.frames.collapse import member_strength
from workbench.mechanics.frames.elastic import ElasticFrame, dead_load_state
from workbench.mechanics.frames.members import SHEAR_LOSS, shear_bound
from workbench.mechanics.frames.members import shear_findings as frame_shear_findings
from workbench.mechanics.frames.structure import dead_loads, free_to_spin
from workbench.responses import Finding, finding
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnScenario,
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameScenario,
    FrameStatic,
    MemberPulse,
    Scenario,
)
from workbench.scenarios.parts import MemberProperties
from workbench.scenarios.pulse import UNIFORM
from workbench.steel.hinges import ShearSurface, has_webs
from workbench.steel.materials import Steel
from workbench.steel.sections import ISection, Section
from workbench.steel.sections.slenderness import plates_of

BUCKLING_WARNING = 2.0  # critical factor below which second-order effects dominate
_ENOUGH = 8  # bars of members that a light striker does not hit: their first modes within 3 %
MUCH_SHARED = 0.08  # of the energy, lost in the first collision with the elements beside it
_SHARE = 0.1  # of the mass, that may be missing
STOCKY = 60.0  # clear height over thickness of a web per epsilon: 72 / eta, eta = 1.2
SLENDER = 0.83 * 86.4 / STOCKY  # of that: chi_w = 0.83 / lambda_w is 1, EN 1993-1-5, table 5.1
FEW_PERCENT, MUCH = 0.01, 0.1  # between the strength of a section and that of a member


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
    elif dead_loads(frame):
        findings += _dead_load_findings(frame)
    elif isinstance(scenario, FrameStatic) and ElasticFrame(frame).is_mechanism:
        findings.append(finding("mechanism"))
    if isinstance(scenario, FrameGroundMotion) and not scenario.load_as_mass:
        findings += _massless_findings(frame)
    return findings + frame_shear_findings(scenario)


def _massless_findings(frame: Frame) -> list[Finding]:
    """Warning of dead loads whose mass no node has, so that the ground does not shake it."""
    masses = {node.name: node.mass for node in frame.nodes}
    missing = sum(max(mass - masses[node], 0.0) for node, mass in frame.load_masses.items())
    there = float(frame.each("mass_per_length") @ frame.lengths) + sum(masses.values())
    if missing <= _SHARE * there:
        return []
    return [finding("mass", missing / there, missing=missing, there=there)]


def _dead_load_findings(frame: Frame) -> list[Finding]:
    """Findings on the elastic frame under its dead loads, springs and locks left out."""
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


def hit_mass_findings(scenario: FrameScenario, parts: Sequence[int], much: float) -> list[Finding]:
    """Warnings of a striker that is light beside the members it hits, or beside their elements.

    Lumped mass of elements takes energy in the first collision, which a beam keeps: `much` of it.
    """
    if not isinstance(scenario, FrameImpact):
        return []
    frame, striker = scenario.frame, scenario.striker
    struck = (frame.ends == frame.number[striker.node]).any(axis=1)
    masses, counts = frame.each("mass_per_length") * frame.lengths, np.asarray(parts)
    shared = float((masses / counts)[struck].sum()) / 3.0
    lost = (1.0 - striker.restitution**2) * shared / (shared + striker.mass)
    share = float(striker.mass / masses[struck].sum())
    fewest = int(counts[~struck].min(initial=_ENOUGH))
    light = []
    if share < 1.0 and fewest < _ENOUGH:
        wanted = max(_ENOUGH, *parts)  # fewer beside the node share more mass with the striker
        light = [finding("light-striker", share, share=share, fewest=fewest, wanted=wanted)]
    if lost <= much or striker.crushes:  # which does not collide at an instant
        return light
    hit = finding("hit-mass", lost, node=striker.node, mass=shared, percent=100.0 * lost)
    return [*light, hit]


DIRECT_SHEAR, IMPLAUSIBLE, ECCENTRIC = "direct-shear", "plausibility", "eccentricity"  # subjects
LEAST_LOAD = 1e-3  # of the squash load, below which loads look like kN
_LEAST_PULSE = 5e-3  # of the plastic shear resistance
_LEAST_MASS = 0.01  # of the steel, below which masses look like t
_SI = {"kN": "N", "t": "kg"}
_FAST, _VEHICLE = 60.0, 500.0  # m/s and kg: beyond both a velocity looks like km/h
_STUB = 2.0  # length of a segment over the height of its section
FOLDS_FROM = {"strong": 10.0, "weak": 14.0}  # outstand over thickness and epsilon, by axis
FOLDS = -0.31, 1.96, 0.023  # ln of the way of shells over that of fibers: 1, P/Npl, outstand
FOLDS_MUCH = 1.10
_EULER_WARNING = 0.5  # share of the Euler load above which second-order effects dominate


def euler_load(column_scenario: ColumnScenario) -> float:
    """Elastic critical load of the whole column in the plane of the impact, in N."""
    column = column_scenario.column
    return column.euler_load(column.axis)


def buckles(scenario: ColumnScenario) -> Any:
    """Whether the axial load reaches the Euler load; flags of a stack."""
    return scenario.column.axial_load >= euler_load(scenario)


def shear_demand(scenario: ColumnScenario) -> dict[str, float]:
    """Shear force of the bending mechanism over the plastic shear resistance, per segment.

    A segment with plastic hinges at both ends carries V = 2 M / length, with one at the hit
    point only (pinned end) V = M / length; M is the plastic moment without axial force. Under a
    line load half of what stands on the segment comes on top, q the line load of the mechanism.
    """
    uniform = isinstance(scenario, MemberPulse) and scenario.load == UNIFORM
    return dict(mechanism_demand(scenario.column, uniform=uniform))


def mechanism_demand(column: Column, *, uniform: bool = False) -> Mapping[str, float]:
    """Mechanism demand of a column under a `uniform` load, or a force at its impact point."""
    name = f"demand of a {'line' if uniform else 'point'} load"
    if name not in column.kept:
        column.kept[name] = _demand(column, uniform)
    demand: dict[str, float] = column.kept[name]
    return demand


def _demand(column: Column, uniform: bool) -> dict[str, float]:
    properties = column.properties
    below, above = ((2.0 if clamped else 1.0) / length for length, clamped in column.bars.values())
    ratio = properties.plastic_moment / properties.shear_resistance
    if uniform:
        line = 2.0 * (below + above) / column.length  # q over M, by virtual work
        below += 0.5 * line * column.length_below
        above += 0.5 * line * column.length_above
    return {"below": below * ratio, "above": above * ratio}


def member_findings(scenario: ColumnScenario | FrameScenario) -> list[Finding]:
    """Domain findings that all member models without shear yielding share.

    Of a frame see `frame_findings`; of a column:
    Refusal: axial load above the Euler load. Warnings: axial load above half of it; a segment
    whose bending mechanism needs more shear force than models without shear yielding allow.
    """
    if not isinstance(scenario, ColumnScenario):
        return frame_findings(scenario)
    return buckling_findings(scenario) + shear_findings(scenario)


def buckling_findings(scenario: ColumnScenario) -> list[Finding]:
    """Refusal of an axial load above the Euler load, warning of one above half of it.

    And of one that buckles the column out of the plane of the impact before it is hit.
    """
    findings, column = [], scenario.column
    load, critical = column.axial_load, column.euler_load(column.axis)
    weak = column.euler_load("weak")
    if column.axis == "strong" and weak <= load < critical:
        findings.append(finding("euler-weak", load / weak, load=load / 1e3, critical=weak / 1e3))
    if load >= critical:
        findings.append(
            finding("euler-reached", load / critical, load=load / 1e3, critical=critical / 1e3)
        )
    elif load > _EULER_WARNING * critical:
        findings.append(finding("euler-near", load / critical))
    if flange_outstand(column.section, column.steel) > FOLDS_FROM[column.axis]:
        findings += folding_findings(column)
    return findings


@lru_cache(maxsize=64)
def flange_outstand(section: Section, steel: Steel) -> float:
    """Outstand of the flanges of an I section over thickness and epsilon; 0 of other sections."""
    if not isinstance(section.about("strong").shape, ISection):
        return 0.0
    plates = plates_of(section)
    return plates.flange / plates.flange_thickness / sqrt(235e6 / steel.yield_stress)


def folding_findings(column: Column) -> list[Finding]:
    """Warning of slender flanges, with which shells go more than 10 % farther than hinges.

    A rule fitted to the data set `slender-shells`, see docs/theory/shell.md.
    """
    outstand = flange_outstand(column.section, column.steel)
    pressed = column.axial_load / column.properties.squash_load
    constant, by_load, by_plate = FOLDS
    farther = np.exp(constant + by_load * pressed + by_plate * outstand)
    if farther <= FOLDS_MUCH:
        return []
    return [finding("flanges-fold", farther, outstand=outstand, pressed=pressed)]


def shear_findings(scenario: ColumnScenario) -> list[Finding]:
    """Warnings of segments whose bending mechanism needs more shear than the webs carry.

    And of pulses whose largest force, half of it on either side, is more than that.
    """
    findings = []
    if isinstance(scenario, MemberPulse):
        findings += direct_shear(scenario)
    return findings + shear_warnings(scenario.column, shear_demand(scenario), "mechanism")


def shear_warnings(
    column: Column, ratios: Mapping[str, float], source: str = "run"
) -> list[Finding]:
    """Warnings of V/Vpl of segments, which a mechanism needs or a run has reached (`source`)."""
    findings, bound = [], shear_bound(column.strength_section)
    for segment, ratio in ratios.items():
        if ratio > bound:
            name = f"{source}-shear-{'near' if ratio <= 1.0 else 'beyond'}"
            loss = 100 * SHEAR_LOSS
            findings.append(finding(name, ratio, segment=segment, bound=bound, loss=loss))
    return findings


def direct_shear(scenario: MemberPulse) -> list[Finding]:
    """Warning of a pulse whose largest force, half of it on either side, is more than webs carry.

    The first moments know no supports: a force at a point sends half of itself each way.
    """
    half = 0.5 * scenario.pulse.peak * scenario.whole
    direct = half / scenario.column.properties.shear_resistance
    if direct <= 1.0:
        return []
    place = "ends" if scenario.load == UNIFORM else "force"
    return [finding(f"direct-shear-at-{place}", direct)]


def count_finding(duration: float, step: float, most: int) -> list[Finding]:
    """Refusal of a record of `duration` (s) in more time steps of `step` (s) than are kept."""
    count, name = duration / step, "more-steps-than-kept"
    if count <= most:
        return []
    return [finding(name, count, step=step, count=count, duration=duration, most=most)]


def stub_findings(surface: ShearSurface, lengths: Mapping[str, float]) -> list[Finding]:
    """Warnings of segments too short to be bars; `lengths` of the panels (m) by name.

    In the study `shear_columns` panels lie within 5 % of a struck solid from two heights of the
    section on, and up to 18 % off below.
    """
    findings = []
    for name, length in lengths.items():
        heights = length / surface.section.height
        if heights < _STUB:
            flanges = surface.flange_mechanism / length / surface.shear_resistance
            findings.append(finding("stub", heights, segment=name, least=_STUB, flanges=flanges))
    return findings


@lru_cache(maxsize=64)
def web_of(section: Section, steel: Steel) -> ShearSurface | None:
    """The web of a section that yields in shear, if it has one."""
    return ShearSurface(section, steel) if has_webs(section) else None


def web_findings(webs: Mapping[str, ShearSurface | None]) -> list[Finding]:
    """Of webs that yield in shear, by names of their members: whether they buckle before.

    EN 1993-1-5, 5.1: from a clear height over thickness of 72 epsilon / eta on, eta 1.2, buckling
    takes of the strength, first what hardening adds to f_y / sqrt 3: a warning. From chi_w = 1 on
    (table 5.1) it takes of that, which is all that models have: a refusal.
    """
    alike: dict[ShearSurface, list[str]] = {}
    for name, web in webs.items():
        if web is not None and web_slenderness(web) > 1.0:
            alike.setdefault(web, []).append(name)
    findings = []
    for web, names in alike.items():
        more = f" (and {len(names) - 1} alike)" if len(names) > 1 else ""
        slenderness, member = web_slenderness(web), f"member {names[0]}{more}"
        key = "shear-buckling" if slenderness > SLENDER else "slender-web"
        findings.append(finding(key, slenderness, member=member, limit=SLENDER))
    return findings


def panel_findings(surface: ShearSurface, properties: MemberProperties) -> list[Finding]:
    """Where panels stop applying to a column: web buckling, strength that is not the section's.

    A plastic moment or squash load more than 10 % off the section's is a refusal, above 1 % off a
    warning. For the webs see `web_findings`.
    """
    findings, ratio = web_findings({"column": surface}), strength_ratio(surface, properties)
    if given_strength(surface, properties):
        far = abs(ratio - 1.0) > MUCH
        findings.append(finding("plates", ratio, refusal=far, member="the column"))
    return findings


def panel_refused(surface: ShearSurface, properties: MemberProperties) -> Any:
    """Whether there is a refusal among `panel_findings`; flags of a stack."""
    far = abs(strength_ratio(surface, properties) - 1.0) > MUCH
    return (web_slenderness(surface) > SLENDER) | far


def web_slenderness(surface: ShearSurface) -> Any:
    """Slenderness of the webs over the bound 72 epsilon / eta."""
    return surface.web_slenderness / (STOCKY * np.sqrt(235e6 / surface.steel.yield_stress))


def given_strength(surface: ShearSurface, properties: MemberProperties) -> bool:
    """Whether a member is given another strength than its plates have."""
    return bool(abs(strength_ratio(surface, properties) - 1.0) > FEW_PERCENT)


def strength_ratio(surface: ShearSurface, properties: MemberProperties) -> Any:
    """Strength of the plates over that of the member.

    Moment or axial force, whichever is farther from 1.
    """
    moment = surface.plastic_moment / properties.plastic_moment
    axial = surface.squash_load / properties.squash_load
    ratio: Any = np.where(abs(axial - 1.0) > abs(moment - 1.0), axial, moment)[()]
    return ratio


def implausible(scenario: Scenario) -> list[Finding]:
    """Warnings of loads, masses and velocities that look like those of another unit."""
    findings = []
    for path, value, whole, least, unit in _sizes(scenario):
        if 0.0 < abs(value) < least * whole:
            values: dict[str, Any] = {"path": path, "value": value, "si": _SI[unit]}
            values |= {"whole": whole, "unit": unit}
            findings.append(finding("small-for-unit", abs(value) / whole, **values))
    striker = getattr(scenario, "striker", None)
    if striker is not None and striker.velocity > _FAST and striker.mass >= _VEHICLE:
        findings.append(finding("fast-vehicle", striker.velocity, speed=3.6 * striker.velocity))
    return findings


def unused_inputs(model: Any, scenario: Any) -> list[Finding]:
    """Warnings of inputs that a scenario sets away from their default and the model does not use.

    Its `unused` names them without names of parts, such as ``node.mass`` or ``column.*``; a model
    without it uses all. What is static has no use for masses, whatever the model.
    """
    findings = []
    for pattern in getattr(model, "unused", ()):
        for path, each in set_inputs(scenario).items():
            weighs = scenario.STATIC and each.unit.startswith("kg")
            if fnmatchcase(path, pattern) and not weighs:
                findings.append(finding("unused-input", input=each))
    return findings


def _sizes(scenario: Any) -> Iterator[tuple[str, float, float, float, str]]:
    """Numbers of a scenario by their paths, what to compare with, the least share, the unit."""
    if hasattr(scenario, "column"):
        column, properties = scenario.column, scenario.column.properties
        steel = properties.mass_per_length * column.length
        yield "column.axial_load", column.axial_load, properties.squash_load, LEAST_LOAD, "kN"
        yield "column.head_mass", column.head_mass, steel, _LEAST_MASS, "t"
        if hasattr(scenario, "pulse"):
            force = scenario.pulse.peak * scenario.whole
            yield "force of the pulse", force, properties.shear_resistance, _LEAST_PULSE, "kN"
    elif hasattr(scenario, "frame"):
        frame = scenario.frame
        steel = float(frame.each("mass_per_length") @ frame.lengths)
        if not isinstance(scenario, FrameStatic):
            squash = float(frame.each("squash_load").max())
            load = max((abs(f) for at in frame.loads for f in (at.x, at.y)), default=0.0)
            yield "largest dead load", load, squash, LEAST_LOAD, "kN"
        yield "largest mass of a node", max(n.mass for n in frame.nodes), steel, _LEAST_MASS, "t"
    if hasattr(scenario, "striker"):
        yield "striker.mass", scenario.striker.mass, steel, _LEAST_MASS, "t"


PAIRS_BESIDE, MESH = "eccentric-hits", -1  # the mesh that answered all pairs
EDGE, FACE = "eccentric_edge_m", "eccentric_face_m"  # of the struck flange; of the striker
BESIDE, PRESSED = "eccentricity_over_half_width", "axial_over_squash"
FEATURES_BESIDE = {
    BESIDE: "eccentricity over half the width of the flange",
    "ln_mechanism_over_flange": "ln of the resistance of the mechanism over f_y t_f squared",
    "ln_way_over_half_width": "ln of the way that the mechanism needs over half the width",
}
LEVELS = 0.05, 0.5, 0.95  # lower end, middle and upper end of the interval


class FactorLine(NamedTuple):
    """Coefficients of a line (1 + features), sorted rests (pairs,), bounds of what was drawn.

    Shells answered drawn pairs of hits along the web, through the shear centre and on the flange
    beside it. The ln of what is struck over the axis of the centred hit is linear in numbers known
    before a run; each rest is to a line without its own pair. See docs/theory/shell.md.
    """

    coefficients: Array
    rests: Array
    least: dict[str, float]
    most: dict[str, float]


def features_beside(scenario: ColumnImpact) -> dict[str, Any]:
    """The numbers that a factor hangs on, by the names of `FEATURES_BESIDE`, and P/Npl."""
    column, striker = scenario.column, scenario.striker
    properties, shape = column.properties, column.section.shape
    assert isinstance(shape, ISection)
    half, lumped = 0.5 * shape.width, properties.impact_mass / striker.mass
    resistance = sum(mechanism_demand(column).values()) * properties.shear_resistance
    local = column.steel.yield_stress * shape.flange**2
    way = scenario.input_energy / (1.0 + lumped) / resistance
    values = abs(striker.eccentricity) / half, np.log(resistance / local), np.log(way / half)
    pressed = column.axial_load / properties.squash_load
    return dict(zip(FEATURES_BESIDE, values, strict=True)) | {PRESSED: pressed}


@lru_cache(maxsize=2)
def factor_line(target: str) -> FactorLine:
    """The line of a `target`, `EDGE` or `FACE`, by least squares over the drawn pairs."""
    pairs = load(PAIRS_BESIDE)
    pairs = pairs[(pairs["refinement"] == MESH) & (pairs["centred_outcome"] == "ok")]
    pairs = pairs[pairs["eccentric_outcome"] == "ok"]
    given = np.column_stack([np.ones(len(pairs)), pairs[list(FEATURES_BESIDE)]])
    ratios = np.log((pairs[target] / pairs["centred_axis_m"]).to_numpy())
    inverse = np.linalg.pinv(given)
    own = np.einsum("ij,ji->i", given, inverse)
    rests = (ratios - given @ inverse @ ratios) / (1.0 - own)
    drawn = pairs[[*FEATURES_BESIDE, PRESSED]]  # from the shear centre to the edge, from no load on
    least, most = {**drawn.min(), BESIDE: 0.0, PRESSED: 0.0}, {**drawn.max(), BESIDE: 1.0}
    return FactorLine(inverse @ ratios, np.sort(rests), least, most)


def eccentric_finding(name: str, scenario: Any, beside: float) -> Finding:
    """Finding of a model by this name, which knows no hit `beside` (m) the shear centre.

    The factors with which it answers where such hits were drawn, else its refusal.
    """
    if why := undrawn(scenario):
        return finding("eccentricity", beside, name=name, why=why)
    values = factor_values(scenario, EDGE) | factor_values(scenario, FACE)
    return finding("eccentric-factor", beside, name=name, **values)


def oblique_findings(scenario: Any) -> list[Finding]:
    """Note of an oblique hit of an I section whose line meets the flange beside the web.

    How far the striker goes as it folds that flange, as drawn along the web. A line that passes
    beside the flange meets the edges of both, of which the nearer one folds.
    """
    column, striker = getattr(scenario, "column", None), scenario.striker
    shape = None if column is None else column.section.shape
    if not isinstance(shape, ISection) or striker.eccentricity or not striker.angle:
        return []
    beside = 0.5 * (shape.height - shape.flange) * tan(striker.angle)
    half = 0.5 * shape.width
    along = striker.changed(angle=0.0, eccentricity=min(beside, half))
    along, more = scenario.changed(striker=along), min(1.0, half / beside)
    if undrawn(along):
        return []
    values = factor_values(along, FACE, more)
    if more == 1.0:
        return [finding("oblique-flange", beside, **values)]
    if values["face_factor"] <= FOLDS_MUCH:
        return []
    return [finding("oblique-edge", beside - half, nearer=50.0 * (1.0 + more), **values)]


def undrawn(scenario: Any) -> str:
    """Why no shells were drawn of such a hit; empty where they were, in the range of all."""
    struck, striker = isinstance(scenario, ColumnImpact), scenario.striker
    along = struck and isinstance(scenario.column.section.shape, ISection) and not striker.crushes
    if not along or np.any(striker.angle):
        return "shells were drawn of I sections that a rigid striker hits along the web"
    values, known = features_beside(scenario), factor_line(EDGE)
    if np.ndim(sum(values.values())):
        return "rows of a stack are asked one by one"
    for name, words in {**FEATURES_BESIDE, PRESSED: "axial load over squash load"}.items():
        least, most = known.least[name], known.most[name]
        if not least <= values[name] <= most:
            return f"{words} is {values[name]:.3g}, in drawn shells {least:.3g} to {most:.3g}"
    return ""


def log_factors(scenario: ColumnImpact, target: str) -> Array:
    """Sorted ln of what is struck over the axis of the hit through the shear centre: (pairs,).

    The expected one with the rest of every drawn pair.
    """
    known, values = factor_line(target), features_beside(scenario)
    given = np.array([1.0, *(values[name] for name in FEATURES_BESIDE)])
    return np.asarray(known.coefficients @ given + known.rests)


def factor(scenario: ColumnImpact, target: str, more: float = 1.0) -> tuple[float, float, float]:
    """Lower end, middle and upper end of 90 % of the factor of a `target`.

    One flange takes `more` of the force than the other, as a share of all: ln of the middle counts
    so often, its scatter whole.
    """
    logs = log_factors(scenario, target)
    ends = np.quantile(logs - (1.0 - more) * np.median(logs), LEVELS, method="weibull")
    low, middle, high = map(float, np.exp(ends))
    return low, middle, high


def factor_values(scenario: ColumnImpact, target: str, more: float = 1.0) -> dict[str, Any]:
    """The `factor` of a `target` with its ends, by their names in sentences and responses."""
    name = "edge_factor" if target == EDGE else "face_factor"
    ends = f"{name}_low", name, f"{name}_high"
    return dict(zip(ends, factor(scenario, target, more), strict=True))
