"""Where member models stop applying: stability of the column and plastic shear demand."""

from collections.abc import Mapping
from functools import lru_cache
from math import pi, sqrt

from workbench.frames.findings import frame_findings
from workbench.frames.shear import SHEAR_LOSS, shear_bound
from workbench.hinges import ShearSurface
from workbench.responses import Finding
from workbench.scenarios import Column, ColumnImpact, ColumnScenario, FrameScenario, MemberPulse
from workbench.scenarios.parts import MemberProperties
from workbench.scenarios.pulse import UNIFORM

RESTITUTION, DIRECT_SHEAR = "restitution", "direct-shear"  # subjects
HEAVY = 5.0  # striker over lumped mass; above, restitution moves the peak of masses by some percent
NEEDED = "a plastic mechanism of the segment {} the hit point needs V/Vpl = {:.2f}"
REACHED = "the segment {} the hit point reaches V/Vpl = {:.2f}"
_STOCKY = 60.0  # clear height over thickness of a web per epsilon: 72 / eta, eta = 1.2
_FEW_PERCENT, _MUCH = 0.01, 0.1  # between the strength of a section and that of a member
_STUB = 2.0  # length of a segment over the height of its section
_EULER_WARNING = 0.5  # share of the Euler load above which second-order effects dominate


def euler_load(column_scenario: ColumnScenario) -> float:
    """Elastic critical load of the whole column in the plane of the impact, in N."""
    column = column_scenario.column
    bending = column.steel.elastic_modulus * column.properties.second_moment
    buckling_length = column.effective_length_factor() * column.length
    return pi**2 * bending / buckling_length**2


def shear_demand(scenario: ColumnScenario) -> dict[str, float]:
    """Shear force of the bending mechanism over the plastic shear resistance, per segment.

    A segment with plastic hinges at both ends carries V = 2 M / length, with one at the hit
    point only (pinned end) V = M / length; M is the plastic moment without axial force. Under a
    line load half of what stands on the segment comes on top, q the line load of the mechanism.
    """
    uniform = isinstance(scenario, MemberPulse) and scenario.load == UNIFORM
    return dict(mechanism_demand(scenario.column, uniform=uniform))


@lru_cache(maxsize=256)
def mechanism_demand(column: Column, *, uniform: bool = False) -> Mapping[str, float]:
    """The same of a column under a `uniform` load, or a force at the hit point."""
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
    """Refusal of an axial load above the Euler load, warning of one above half of it."""
    findings = []
    load, critical = scenario.column.axial_load, euler_load(scenario)
    if load >= critical:
        text = (
            f"axial load {load / 1e3:.4g} kN reaches the Euler load {critical / 1e3:.4g} kN "
            "of the column: it buckles before it is hit"
        )
        findings.append(Finding("buckling", text, True, number=load / critical, instead=()))
    elif load > _EULER_WARNING * critical:
        text = (
            f"axial load is {load / critical:.2f} of the Euler load: second-order bending "
            "between the hinges, which rigid-bar models lack, matters"
        )
        findings.append(Finding("buckling", text, number=load / critical, instead=()))
    return findings


def shear_findings(scenario: ColumnScenario) -> list[Finding]:
    """Warnings of segments whose bending mechanism needs more shear than the webs carry.

    And of pulses whose largest force, half of it on either side, is more than that.
    """
    findings = []
    if isinstance(scenario, MemberPulse):
        findings += direct_shear(scenario)
    return findings + shear_warnings(scenario.column, shear_demand(scenario), NEEDED)


def shear_warnings(
    column: Column, ratios: Mapping[str, float], words: str = REACHED
) -> list[Finding]:
    """Warnings of V/Vpl of segments, `words` that say of each whence it comes."""
    findings, bound = [], shear_bound(column.strength_section)
    for segment, ratio in ratios.items():
        needs = words.format(segment, ratio)
        if bound < ratio <= 1.0:
            text = (
                f"{needs}: above {bound:.2f} shear yielding takes more than "
                f"{100 * SHEAR_LOSS:g} % of the resistance of this section, which models without "
                "it leave out"
            )
            findings.append(Finding("shear", text, number=ratio, instead=()))
        elif ratio > 1.0:
            text = (
                f"{needs}: its web yields in shear before, so that every model without shear "
                "yielding overestimates the plastic resistance"
            )
            findings.append(Finding("shear", text, number=ratio, instead=()))
    return findings


def direct_shear(scenario: MemberPulse) -> list[Finding]:
    """Warning of a pulse whose largest force, half of it on either side, is more than webs carry.

    The first moments know no supports: a force at a point sends half of itself each way.
    """
    half = 0.5 * scenario.pulse.peak * scenario.whole
    direct = half / scenario.column.properties.shear_resistance
    if direct <= 1.0:
        return []
    text = (
        f"half of the largest force of the pulse is {direct:.2f} Vpl: webs yield in direct shear "
        "before the member bends, "
    )
    if scenario.load == UNIFORM:
        text += "at its ends, where fiber-shear has the clear web alone, less than a solid"
    else:
        text += (
            "beside the force, where only the bending of flanges keeps the slide from one section: "
            "fiber-shear has none and goes further with every finer mesh, panels slide over their "
            "whole length"
        )
    return [Finding(DIRECT_SHEAR, text, number=direct, instead=())]


def step_finding(step: float, stable: float) -> list[Finding]:
    """Refusal of an explicit time step above 0.3 of the stability limit `stable` (both in s)."""
    limit = 0.3 * stable
    if step <= limit:
        return []
    text = (
        f"option.time_step = {step:g} s is above 0.3 of the stability limit of the explicit "
        f"scheme, {limit:.3g} s: reduce it"
    )
    return [Finding("time-step", text, refusal=True)]


def bounce_findings(scenario: ColumnImpact) -> list[Finding]:
    """Warning of a light striker that bounces off a lumped mass.

    After a collision with restitution e striker M and mass m keep e^2 m / M more energy than after
    one without, relative to what that leaves; a beam sends most of it off in waves. What it does
    to the peak was measured, see docs/theory/which-model.md.
    """
    striker = scenario.striker
    more = striker.restitution**2 * scenario.column.properties.impact_mass / striker.mass
    if more <= 1.0 / HEAVY:
        return []
    text = (
        f"with restitution {striker.restitution:g} a lumped mass takes up (1 + e) of the momentum "
        f"at once and keeps {100.0 * more:.0f} % more energy than without; the struck part of a "
        "beam is light and waves take the energy along it: the peak grows too much, by about a "
        "third of that share, up to all of it"
    )
    return [Finding(RESTITUTION, text, number=more, instead=())]


def count_finding(duration: float, step: float, most: int) -> list[Finding]:
    """Refusal of a record of `duration` (s) in more time steps of `step` (s) than fit in memory."""
    steps = duration / step
    if steps <= most:
        return []
    text = (
        f"the record of {duration:g} s has {steps:.3g} time steps of {step:.2g} s, which resolve "
        f"its highest frequency or are asked for; at most {most:.0e} fit in memory"
    )
    remedy = (
        "take a column.head_mass of 0 kg or of some size, a softer column.restraint_stiffness, a "
        "shorter time.duration or a longer option time_step"
    )
    return [Finding("steps", text, refusal=True, remedy=remedy, number=steps)]


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
            text = (
                f"the segment {name} the hit point is {heights:.2f} heights of the section long: "
                f"below {_STUB:g} a solid, whose ends stay plane and whose flanges carry "
                f"{flanges:.2f} of V_pl by themselves, differs by up to 18 %"
            )
            findings.append(Finding("stub", text, number=heights, instead=()))
    return findings


def panel_findings(
    surface: ShearSurface, properties: MemberProperties, subject: str
) -> list[Finding]:
    """Where a panel stops applying to a member: web buckling, strength that is not the section's.

    `subject`, by which the member is called. Refusals: a web slender enough to buckle in shear
    (EN 1993-1-5, 5.1: clear height over thickness above 72 epsilon / eta, eta 1.2); a plastic
    moment or squash load more than 10 % off the section's. Above 1 % off it is a warning.
    """
    findings = []
    epsilon = sqrt(235e6 / surface.steel.yield_stress)
    slenderness = surface.web_slenderness / (_STOCKY * epsilon)
    if slenderness > 1.0:
        text = (
            f"the web of {subject} is {slenderness:.2f} times as slender as 72 epsilon / eta: it "
            "buckles in shear before it yields"
        )
        findings.append(
            Finding("shear-buckling", text, refusal=True, number=slenderness, instead=())
        )
    pairs = (
        surface.plastic_moment / properties.plastic_moment,
        surface.squash_load / properties.squash_load,
    )
    ratio = max(pairs, key=lambda share: abs(share - 1.0))
    if abs(ratio - 1.0) > _FEW_PERCENT:
        text = (
            f"the section of {subject} has {ratio:.3f} of the plastic moment or squash load given "
            "for it, which panels leave out"
        )
        far = abs(ratio - 1.0) > _MUCH
        findings.append(Finding("plates", text, far, number=ratio, instead=()))
    return findings
