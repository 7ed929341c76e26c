"""Strain rate of the steel as models have it: one factor (level A), or bars that flow (level B).

Level A is for every model that knows no rate. The factor is that of the hinges, or of the sliding
webs, of the struck member while striker and hit mass move at the velocity that they share after the
hit, averaged by work over the bars and over the way in which the striker is slowed down. All
strengths grow alike; stiffness, mass and axial load
stay. Level B (option `rate_level`): bars that flow point by point (`hinges.rate`) stand in
place of hinges on a yield surface. See docs/theory/strain-rate.md.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from workbench.mechanics.frames.column_estimate import column_like
from workbench.mechanics.frames.structure import joint_surface
from workbench.models.domain import mechanism_demand
from workbench.responses import Finding, finding
from workbench.scenarios import ColumnImpact, Frame, FrameImpact
from workbench.steel.hinges import ShearSurface, YieldSurface, has_bar_law
from workbench.steel.hinges.panel_elements import (
    bar_law,
    hinge_overstress,
    overstress_shape,
    panel_law,
    panel_overstress,
)
from workbench.steel.materials import CowperSymonds, Steel

FACTOR, BARS = RATE_LEVELS = ("factor", "bars")


def with_strain_rate(model: Any, scenario: Any) -> tuple[Any, float, list[Finding]]:
    """Return the scenario that a model solves for one whose steel has a rate or hardens.

    With the factor on the yield stress in it, and findings of what the model leaves out. A model
    that knows strain rate or hardening by itself says so: bars do, and its `material` names "rate",
    "hardening"; one that answers with the static strength, "static strength". Statics know no rate.
    """
    steel = steel_of(scenario)
    if steel is None or (steel.rate is None and steel.hardening_modulus is None):
        return scenario, 1.0, []
    bars = getattr(model, "rate_level", FACTOR) == BARS
    known = ("rate", "hardening") if bars else getattr(model, "material", ())
    findings, factor = [], 1.0
    if steel.hardening_modulus is not None and "hardening" not in known:
        share = steel.hardening_modulus / float(np.min(steel.elastic_modulus))  # most of a stack
        findings.append(finding("hardening", share))
        scenario = _of_steel(scenario, hardening_modulus=None)
    if steel.rate is not None and "rate" not in known and not scenario.STATIC:
        column = _struck(scenario)
        if column is None or column.striker.crushes or "static strength" in known:
            findings.append(finding("strain-rate", kind=scenario.KIND))
        else:
            factor = rate_factor(column, getattr(model, "shear_yields", False))
        scenario = stronger(scenario, factor)
    elif hasattr(model, "given"):  # a resistance curve of its own grows, not the steel
        factor = model.given(scenario)[1]
        hit = isinstance(scenario, ColumnImpact) and scenario.striker.crushes
        if hit and steel.rate is not None and factor == 1.0:
            findings.append(finding("strain-rate", kind=scenario.KIND))
    return scenario, factor, findings


def stronger(scenario: Any, factor: float) -> Any:
    """Return the scenario of a steel without rate law and that many times as strong."""
    part = "column" if hasattr(scenario, "column") else "frame"
    scenario = _of_steel(scenario, rate=None)
    changed = {part: getattr(scenario, part).stronger(factor)}
    return scenario.changed(**changed)


def with_rate(scenario: Any, law: CowperSymonds | None) -> Any:
    """Return the scenario of a steel with that rate law."""
    return _of_steel(scenario, rate=law)


def _of_steel(scenario: Any, **changes: Any) -> Any:
    """The scenario with another steel."""
    name = "column" if hasattr(scenario, "column") else "frame"
    part = getattr(scenario, name)
    steel = part.steel.changed(**changes)
    return scenario.changed(**{name: part.changed(steel=steel)})


def steel_of(scenario: Any) -> Steel | None:
    """Return the steel of a column or a frame; None of what has none."""
    part = getattr(scenario, "column", None) or getattr(scenario, "frame", None)
    return getattr(part, "steel", None)


def feels_rate(scenario: Any) -> bool:
    """Whether the steel of a scenario has a rate law."""
    steel = steel_of(scenario)
    return steel is not None and steel.rate is not None


def rate_factor(scenario: ColumnImpact, shear_yields: bool = False) -> float:
    """Mean factor on the yield stress of a struck column whose steel has a rate law.

    Arguments: whether webs slide in the model where their mechanism needs more shear force than
    they carry (`shear_yields`). 1 of a striker that crushes: no collision says how fast it hits.
    """
    column, striker = scenario.column, scenario.striker
    if striker.crushes:
        return 1.0
    law, properties = column.steel.rate, column.properties
    assert law is not None
    velocity = striker.velocity * striker.mass / (striker.mass + properties.impact_mass)
    q, height, section = law.exponent, column.section.height, column.strength_section
    shape, demand = overstress_shape(section, q), mechanism_demand(column)
    weighted = whole = 0.0
    for bar, (length, clamped) in column.bars.items():
        slides: Any = np.logical_and(shear_yields, demand[bar] > 1.0)
        webs = panel_overstress(velocity / length, law)
        webs *= 2.0 * q / (2.0 * q + 1.0)  # its mean over the way, as v grows with (1 - s)^1/2
        inflection = 0.5 * length if clamped else length
        over = hinge_overstress(velocity / length, inflection, height, shape, law)
        over *= (2.0 * q + 2.0) / (2.0 * q + 3.0)
        bent = (2.0 if clamped else 1.0) * properties.plastic_moment / length
        force: Any = np.where(slides, properties.shear_resistance, bent)[()]
        weighted = weighted + force * np.where(slides, webs, over)[()]
        whole = whole + force
    return 1.0 + weighted / whole


def _struck(scenario: Any) -> ColumnImpact | None:
    """The struck column, None where there is none."""
    if isinstance(scenario, ColumnImpact):
        return scenario
    return column_like(scenario) if isinstance(scenario, FrameImpact) else None


def flows(model: Any, steel: Steel) -> bool:
    """Whether the bars of a model flow point by point: of a steel with a rate, or that hardens."""
    return model.rate_level == BARS and bool(steel.rate or steel.hardening_modulus)


def check_bars(model: Any) -> None:
    """Refuse options that bars do not know. Raises `InputError`."""
    if model.rate_level != BARS:
        return
    for name in ("alpha", "beta"):
        if getattr(model, name, None) is not None:
            advice = f"leave {name} out, or take rate_level = {FACTOR}"
            raise model.refusal(name, f"is not known with rate_level = {BARS}", advice)


def laws_of(model: Any, frame: Frame, webs: Mapping[str, ShearSurface | None]) -> dict[str, Any]:
    """The records by which the bars of each member flow, by its name; none where they do not.

    Argument: `webs` of the members that yield in shear, None of others.
    """
    if not flows(model, frame.steel):
        return {}
    laws = {}
    for m in frame.members:
        p, web = frame.properties(m), webs[m.name]
        section, bounds = frame.strength_section(m), (p.squash_load, p.plastic_moment)
        laws[m.name] = panel_law(web) if web else bar_law(section, frame.steel, *bounds)
    return laws


def about_bars(frame: Frame) -> list[Finding]:
    """Refusals of members that cannot flow as bars: their section, joints that are weaker."""
    for member in frame.members:
        section, p = frame.strength_section(member), frame.properties(member)
        if not has_bar_law(section):
            return [finding("no-plane-webs", name=section.name)]
        surface = YieldSurface(p.squash_load, p.plastic_moment)
        for joint in frame.joints_of(member):
            if joint.rotational_stiffness != 0.0 and joint_surface(surface, joint) != surface:
                return [finding("joint-of-bars", name=joint.name, member=member.name)]
    return []
