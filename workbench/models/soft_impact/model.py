"""The column hit by a striker that is not rigid: the model of Eibl and the CEB.

Comité Euro-International du Béton 1988; Heng 2017, section 3.1, figure 3.1.
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from workbench.errors import SolverError
from workbench.fields import Choice, Number, checked
from workbench.models.base import Answering
from workbench.models.domain import shear_warnings
from workbench.models.hit_mass import HIT_MASS, THESIS, with_hit_mass
from workbench.models.resistance import (
    INTERACTIONS,
    SECTION,
    SHAPES,
    ResistanceCurve,
    column_curve,
    limits,
)
from workbench.models.resistance.panel import PANEL
from workbench.models.single_dof.kernels import COLLAPSE, HISTORIES, RECORD
from workbench.models.soft_impact import kernels
from workbench.responses import Finding, Response, build_response, energy_error
from workbench.responses.histories import NO_PEAK, still_grows
from workbench.scenarios import ColumnImpact

VEHICLE_STIFFNESS = 3.0e5  # N/m, cars, EN 1991-1-7, Annex C
_STEPS_PER_PERIOD = 100  # of the highest frequency of both springs
_FEWEST_STEPS, _MOST_STEPS = 500, 1_000_000
_BALANCE = 1e-3  # of the input energy, which the ledger may be open


@dataclass(frozen=True)
class SoftImpact(Answering):
    """Two masses on two springs: what of the vehicle crushes, and the column.

    Options: `striker_stiffness` in N/m of what crushes (300 kN/m: cars, EN 1991-1-7, Annex C);
    `crush_force` in N at which it flows (None: it stays elastic); `resistance` of the column,
    `rotational_stiffness`, `interaction` and `hit_mass` as in `single-dof`.
    """

    striker_stiffness: float = checked(Number(1.0, 1e12, "N/m"), VEHICLE_STIFFNESS)
    crush_force: float | None = checked(Number(1.0, 1e12, "N"), optional=True)
    resistance: str = checked(Choice(SHAPES), "analytic")
    rotational_stiffness: float | None = checked(Number(0.1, 1e6), optional=True)
    interaction: str = checked(Choice(INTERACTIONS), SECTION)
    hit_mass: str = checked(HIT_MASS, THESIS)

    name: ClassVar[str] = "soft-impact"
    version: ClassVar[int] = 3
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "The striker is a mass behind one spring, linear up to its crush force, that cannot pull; "
        "what it crushes is massless and comes back with the same stiffness.",
        "Restitution is what the spring gives back; that of the scenario has no part in it.",
        "Resistance of the single-DOF column: two rigid bars with plastic hinges, small rotations, "
        "springs of the elastic column; with resistance = panel the "
        "static curve of `four-dof-shear`.",
        "At most one third of the column's mass acts at the hit point; a head mass is left out.",
        "No local buckling, no strain-rate effect.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "ceb1988", "en1991-1-7")

    def curve(self, scenario: ColumnImpact) -> ResistanceCurve:
        """Resistance of the column at its hit point. Raises `OutOfDomainError`."""
        spring = self.rotational_stiffness, self.resistance, self.interaction
        return column_curve(scenario.column, *spring)

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """Findings of all models on a resistance curve, and a restitution that has no part.

        A perfect one is that of an elastic spring. Shear is that of the run, not of a mechanism.
        """
        findings = [
            f for f in limits.curve_findings(scenario, self.resistance) if f.subject != "shear"
        ]
        if self.striker_stiffness == VEHICLE_STIFFNESS:
            text = (
                f"what strikes is taken for a spring of {VEHICLE_STIFFNESS / 1e3:g} kN/m, that of "
                "cars in EN 1991-1-7"
            )
            remedy = "give the striker_stiffness, and the crush_force, of what it is"
            findings.append(Finding("estimate", text, remedy=remedy))
        if 0.0 < scenario.striker.restitution < 1.0:
            text = (
                f"the restitution of {scenario.striker.restitution:g} has no part in an impact "
                "with a spring"
            )
            findings.append(Finding("restitution", text, remedy="a crush_force loses energy"))
        return findings

    def _solve(self, scenario: ColumnImpact) -> Response:
        started = perf_counter()
        scenario = with_hit_mass(scenario, self.hit_mass)
        column, curve = scenario.column, self.curve(scenario)
        mass, striker = column.properties.impact_mass, scenario.striker
        stiffest = curve.unloading_stiffness(limits.reach(column)) + self.striker_stiffness
        frequency = float(np.sqrt(stiffest / mass + self.striker_stiffness / striker.mass))
        steps = scenario.duration * frequency * _STEPS_PER_PERIOD / (2.0 * np.pi)
        count = int(np.clip(np.ceil(steps), _FEWEST_STEPS, _MOST_STEPS))
        step = scenario.duration / count
        if step * frequency > 1.0:
            where = f"steps of {step:.2g} s, at most {_MOST_STEPS:.0e} are kept"
            raise SolverError(where, step * frequency, "a softer striker or a shorter record")
        records = np.zeros(count + 1, RECORD)
        force = np.inf if self.crush_force is None else self.crush_force
        meeting = kernels.Meeting(
            mass, striker.mass, striker.velocity, self.striker_stiffness, force
        )
        status, last, spring, _ = kernels.impact(
            step,
            meeting,
            curve.elastic_limit,
            limits.limit_of(curve, column),
            curve.pieces,
            records,
        )
        if status == COLLAPSE:
            raise limits.collapsed(curve, column, float(records["displacement"][last]), last * step)
        solved = perf_counter() - started
        top = float(records["displacement"].max())
        shear, warnings = limits.reached(curve, column, top)
        values: dict[str, Any] = {
            **{name: records[name] for name in HISTORIES},
            "input_energy": scenario.input_energy,
            "shear_utilisation": shear,
        }
        plastic = spring.v - spring.force / spring.stiffness if spring.yielded else 0.0
        values["residual_displacement"] = plastic
        if shear is not None and self.resistance != PANEL:
            warnings += shear_warnings(column, dict(zip(limits.SEGMENTS, shear, strict=True)))
        if records["percussion"][-1] > 0.0 and records["striker_velocity"][-1] > 0.0:
            values |= dict.fromkeys(("peak_displacement", "time_of_peak", "residual_displacement"))
            if not still_grows(records["displacement"]):
                longer = float(np.pi * np.sqrt(striker.mass / self.striker_stiffness))
                text = f"the striker still moves on and pushes at the end, {scenario.duration:g} s"
                remedy = f"extend time.duration to {longer:.2g} s to find the peak"
                warnings.append(Finding(NO_PEAK, text, remedy=remedy))
        response = build_response(
            values,
            time=np.linspace(0.0, scenario.duration, count + 1),
            segments=limits.SEGMENTS,
            warnings=warnings,
        )
        error = energy_error(response)
        if error is not None and error > _BALANCE:
            raise SolverError("the energy balance", error, f"steps of {step:.2g} s")
        response.attrs["solve_time"] = solved
        return response
