"""Input that is possible and of an unlikely size, as of a number in another unit: warnings."""

from collections.abc import Iterator
from typing import Any

from workbench.responses import Finding
from workbench.scenarios import FrameStatic, Scenario

SUBJECT = "plausibility"
LEAST_LOAD = 1e-3  # of the squash load, below which loads look like kN
_LEAST_PULSE = 5e-3  # of the plastic shear resistance
_LEAST_MASS = 0.01  # of the steel, below which masses look like t
_SI = {"kN": "N", "t": "kg"}
_FAST, _VEHICLE = 60.0, 500.0  # m/s and kg: beyond both a velocity looks like km/h


def implausible(scenario: Scenario) -> list[Finding]:
    """Warnings of loads, masses and velocities that look like those of another unit."""
    findings = []
    for path, value, whole, least, unit in _sizes(scenario):
        if 0.0 < abs(value) < least * whole:
            si = _SI[unit]
            text = f"{path} = {value:g} {si} is small beside the {whole:.3g} {si} of the structure"
            remedy = f"give it in {si} if it is meant in {unit}"
            findings.append(Finding(SUBJECT, text, remedy=remedy, number=abs(value) / whole))
    striker = getattr(scenario, "striker", None)
    if striker is not None and striker.velocity > _FAST and striker.mass >= _VEHICLE:
        text = f"striker.velocity = {striker.velocity:g} m/s is {3.6 * striker.velocity:.0f} km/h"
        remedy = "give it in m/s if it is meant in km/h"
        findings.append(Finding(SUBJECT, text, remedy=remedy, number=striker.velocity))
    return findings


def _sizes(scenario: Any) -> Iterator[tuple[str, float, float, float, str]]:
    """Numbers of a scenario by their paths, what to compare with, the least share, the unit."""
    if hasattr(scenario, "column"):
        column, own = scenario.column, scenario.column.properties
        steel = own.mass_per_length * column.length
        yield "column.axial_load", column.axial_load, own.squash_load, LEAST_LOAD, "kN"
        yield "column.head_mass", column.head_mass, steel, _LEAST_MASS, "t"
        if hasattr(scenario, "pulse"):
            force = scenario.pulse.peak * scenario.whole
            yield "force of the pulse", force, own.shear_resistance, _LEAST_PULSE, "kN"
    elif hasattr(scenario, "frame"):
        frame = scenario.frame
        each = {member: frame.properties(member) for member in frame.members}
        steel = sum(own.mass_per_length * frame.length(member) for member, own in each.items())
        if not isinstance(scenario, FrameStatic):
            squash = max(own.squash_load for own in each.values())
            load = max((abs(f) for at in frame.loads for f in (at.x, at.y)), default=0.0)
            yield "largest dead load", load, squash, LEAST_LOAD, "kN"
        yield "largest mass of a node", max(n.mass for n in frame.nodes), steel, _LEAST_MASS, "t"
    if hasattr(scenario, "striker"):
        yield "striker.mass", scenario.striker.mass, steel, _LEAST_MASS, "t"
