"""Hard and soft impact by EN 1991-1-7, Annex C: the force of a vehicle that crushes.

Hard impact (C.2.1): a striker of mass m and stiffness k on a rigid structure, m x'' + k x = 0,
pushes with at most F = v (k m)^1/2; held for (m / k)^1/2 it has the momentum m v of the striker.
The structure answers that rectangular pulse, or statically phi F, phi at most 2 (a step on an
elastic structure); or the static force of Table 4.1 for a kind of traffic, whatever the striker.
Soft impact (C.2.2): a plastic structure absorbs a rigid striker, m v^2 / 2 <= F_0 y_0, F_0 its
strength and y_0 the deformation that it can take.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Any, ClassVar

from workbench.base.fields import Choice, Number, checked
from workbench.extras.practice.hand_estimate import mechanism_load
from workbench.models.base import Answering
from workbench.models.resistance import RESISTANCES, column_curve, columns
from workbench.models.resistance.shapes import SECTION
from workbench.models.single_dof.model import Pushed, push
from workbench.responses import Finding, Response, build_response, finding
from workbench.scenarios import ColumnImpact, Pulse
from workbench.scenarios.pulse import FORCES, VEHICLE_STIFFNESS

DYNAMIC, STATIC = "dynamic", "static"
_RIGID = 0.1  # way of the structure over the crush of the striker, up to which it counts as rigid


@dataclass(frozen=True)
class HardImpact(Answering):
    """Force of a striker that crushes on a column, by EN 1991-1-7, Annex C."""

    striker_stiffness: float = checked(
        Number(1.0, 1e12, "N/m"),
        VEHICLE_STIFFNESS,
        help="of what crushes, if the scenario gives none (cars, Annex C)",
    )
    application: str = checked(
        Choice((DYNAMIC, STATIC, *FORCES)),
        DYNAMIC,
        help="of the force: a rectangular pulse on the single-DOF column, static, or the static "
        "force of a kind of traffic (Table 4.1, along the traffic or across)",
    )
    amplification: float = checked(Number(1.0, 2.0), 2.0, help="phi of the static force")
    resistance: str = checked(Choice(RESISTANCES), "analytic", help="as of single-dof")
    deformation_capacity: float | None = checked(
        Number(1e-6, 10.0, "m"), optional=True, help="y_0, to check soft impact"
    )

    name: ClassVar[str] = "en-1991-hard-impact"
    version: ClassVar[int] = 2
    crushing: ClassVar[bool] = True
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    unused: ClassVar[tuple[str, ...]] = ("column.head_mass", "striker.restitution")
    assumptions: ClassVar[tuple[str, ...]] = (
        "All deformation is that of the striker, a linear spring of 300 kN/m unless given; the "
        "force that it makes on a rigid wall acts as a rectangular pulse.",
        "The column answers as the single-DOF column under that force, or statically.",
        "The restitution of the scenario has no part.",
        "Annex C is recalled from the standard and checked against the momentum of the striker.",
        "Forces of a kind of traffic are those of Table 4.1, recalled and not verified in print; "
        "the striker of the scenario has no part in them.",
    )
    sources: ClassVar[tuple[str, ...]] = ("en1991-1-7", "heng2017")

    def stiffness(self, scenario: ColumnImpact) -> float:
        """Stiffness (N/m) of what crushes: of the striker if it has one."""
        return scenario.striker.stiffness or self.striker_stiffness

    def pulse(self, scenario: ColumnImpact) -> Pulse:
        """Force of the hard impact: v (k m)^1/2 for (m / k)^1/2."""
        mass, k = scenario.striker.mass, self.stiffness(scenario)
        force = scenario.striker.velocity * sqrt(k * mass)
        return Pulse("rectangular", force, sqrt(mass / k))

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """Findings of all models on a resistance curve, and the check of soft impact."""
        findings = columns.curve_findings(scenario, self.resistance)
        capacity, needed = self.deformation_capacity, self._soft_deformation(scenario)
        if capacity is not None and needed > capacity:
            findings.append(
                finding("soft-impact", needed / capacity, needed=needed, capacity=capacity)
            )
        if scenario.acceleration:
            findings.append(finding("unused-input", input="gravity"))
        if scenario.striker.crush is not None:
            findings.append(finding("one-stiffness"))
        return findings

    def _soft_deformation(self, scenario: ColumnImpact) -> float:
        """Deformation (m) that soft impact takes, m v^2 / (2 F_0)."""
        return scenario.input_energy / mechanism_load(scenario.column, SECTION)

    def _solve(self, scenario: ColumnImpact) -> Response:
        column, pulse, table = scenario.column, self.pulse(scenario), FORCES.get(self.application)
        curve = column_curve(column, None, self.resistance)
        values: dict[str, Any] = {}
        time = None
        if self.application == DYNAMIC:
            pushed = Pushed(curve, ((0.0, column.properties.impact_mass, 1.0),), 1.0, True)
            time, values = push(pushed, column, pulse, scenario.duration)
            top = float(values["displacement"].max())
        else:
            force = table or self.amplification * pulse.peak
            top = columns.displacement_under(curve, column, force)
            values["peak_displacement"] = top
            values["residual_displacement"] = curve.residual(top)
        values["peak_force"] = table or pulse.peak
        if table is None:
            values["impulse"] = scenario.striker.mass * scenario.striker.velocity
        values["shear_utilisation"], warnings = columns.reached(curve, column, top)
        crush = scenario.striker.velocity * pulse.length if pulse.length else 0.0
        if table is not None:
            warnings.append(finding("table-force", table=table / 1e3, striker=pulse.peak / 1e3))
        elif top <= _RIGID * crush:
            stiffness = self.stiffness(scenario)
            warnings.append(
                finding("striker", crush / top, crush=crush, top=top, stiffness=stiffness)
            )
        else:
            warnings.append(finding("hard-impact", top / crush, crush=crush, top=top))
        response = build_response(values, time=time, segments=columns.SEGMENTS, warnings=warnings)
        soft = self._soft_deformation(scenario)
        rule = {
            "rule.force": (table or pulse.peak, "N", "force of hard impact"),
            "rule.duration": (pulse.length, "s", "duration of hard impact"),
            "rule.soft_deformation": (soft, "m", "deformation that soft impact takes"),
        }
        for name, (value, units, meaning) in rule.items():
            response[name] = ((), value, {"units": units, "long_name": meaning})
        return response
