"""Columns in steel that feels the strain rate: reduced models against fibers of the same law.

Sections, steels, supports, place of the hit, axial load, restraint, mass and velocity of the
striker are drawn by a Latin hypercube. The reference is the fiber beam with the rate law in every
fiber; the models have one factor on the yield stress in closed form. Beside them: no rate, the
increase factors of design rules, and a hinge as long as the section is high.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import exp, log
from typing import Any, ClassVar

import numpy as np
from scipy.stats import qmc

from workbench.assessment import Gate
from workbench.cli import main
from workbench.fields import Choice, checked
from workbench.materials import GRADES, MILD_STEEL, Steel
from workbench.models.base import Answering
from workbench.models.domain import euler_load, shear_demand
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof
from workbench.models.single_dof import SingleDof
from workbench.models.strain_rate import stronger
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.references.fiber_reissner import FiberReissner
from workbench.responses import Finding, Response
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.sections import find
from workbench.study import Case, Figure, Study

COLUMNS, SEED = 120, 31
SECTIONS = (
    *("HEA 180", "HEA 240", "HEA 300", "HEB 160", "HEB 220", "HEB 280"),
    *("HEM 200", "IPE 240", "IPE 300", "IPE 360", "IPE 450"),
)
STEELS = (  # mild steel of the literature, and two grades as they are taken by default
    Steel(yield_stress=235e6, rate=MILD_STEEL),
    Steel(yield_stress=GRADES["S355"][0], rate=GRADES["S355"][1]),
    Steel(yield_stress=GRADES["S460"][0], rate=GRADES["S460"][1]),
)
NAMES = ("mild steel", "S355", "S460")
FACTORS = {"static": 1.0, "1.1": 1.1, "1.2": 1.2, "1.3": 1.3}
BEAM, RATIO, BELOW = "fiber beam", "striker over lumped mass", "length below in m"


@dataclass(frozen=True)
class ByRule(Answering):
    """The four-DOF column with a yield stress by a `rule`: a factor, or a hinge of one height."""

    rule: str = checked(Choice((*FACTORS, "height")), "static")

    name: ClassVar[str] = "four-dof-by-rule"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "four-dof with one factor on the yield stress, of a design rule or of a hinge as long as "
        "the section is high at half the velocity after the hit.",
    )
    sources: ClassVar[tuple[str, ...]] = ()
    material: ClassVar[tuple[str, ...]] = ("rate",)

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """Findings of the four-DOF column."""
        return FourDof().domain(scenario)

    def _solve(self, scenario: ColumnImpact) -> Response:
        factor = FACTORS.get(self.rule) or self._of_height(scenario)
        return FourDof()._solve(stronger(scenario, factor))

    def _of_height(self, scenario: ColumnImpact) -> float:
        column, striker = scenario.column, scenario.striker
        shared = striker.mass / (striker.mass + column.properties.impact_mass) * striker.velocity
        rate = 0.25 * shared / min(column.length_below, column.length_above)
        law = column.steel.rate
        return 1.0 if law is None else law.factor(rate)


models: Mapping[str, Any] = {
    BEAM: FiberReissner(levels=2),
    "4-DOF": FourDof(hit_mass="waves"),
    "4-DOF, bars": FourDof(hit_mass="waves", rate_level="bars"),
    "4-DOF, hit mass of the thesis": FourDof(),
    "SDOF": SingleDof(hit_mass="waves"),
    "energy": EnergyEstimate(hit_mass="waves"),
    "flexible superelements": FlexibleSuperelement(shear="none"),
    "rigid superelements": RigidSuperelement(shear="none"),
    "flexible superelements, bars": FlexibleSuperelement(rate_level="bars"),
    "rigid superelements, bars": RigidSuperelement(rate_level="bars"),
    "4-DOF, static": ByRule("static"),
    "4-DOF, 1.1 fy": ByRule("1.1"),
    "4-DOF, 1.2 fy": ByRule("1.2"),
    "4-DOF, 1.3 fy": ByRule("1.3"),
    "4-DOF, hinge of one height": ByRule("height"),
}


def drawn(point: np.ndarray, number: int) -> Case:
    """The case of a point of the unit cube (9,)."""
    u = point.tolist()
    section = find(SECTIONS[int(u[0] * len(SECTIONS))])
    length, place = (12.0 + 17.0 * u[1]) * section.height, 0.15 + 0.35 * u[2]
    steel = STEELS[number % len(STEELS)]
    base = "pinned" if u[3] < 0.2 else "clamped"
    head = "pinned" if 0.1 < u[3] < 0.3 else "guided"
    column = Column(section, place * length, (1.0 - place) * length, steel, base=base, head=head)
    impact = ColumnImpact("drawn", column, Striker(1.0, 1.0))
    load = 0.25 * u[4] * min(column.properties.squash_load, 0.5 * euler_load(impact))
    axial = steel.elastic_modulus * section.area / length
    spring = 0.0 if u[5] < 0.25 else 0.005 * 60.0 ** ((u[5] - 0.25) / 0.75) * axial
    column = replace(column, axial_load=load, restraint_stiffness=spring)
    velocity = 5.0 + 25.0 * u[6]
    lumped = column.properties.impact_mass
    demand = shear_demand(replace(impact, column=column))
    force = sum(demand.values()) * column.properties.shear_resistance
    reach = exp(log(0.05) + u[7] * log(5.0)) * column.length_below
    mass = min(max(3.0 * force * reach / velocity**2, 5.0 * lumped), 47.0 * lumped)
    kind = NAMES[number % len(STEELS)]
    name = f"{number:03d} {section.name}, {kind}, {velocity:.0f} m/s, {mass:.0f} kg"
    duration = 6.0 * (0.5 * mass * velocity**2 / force) / velocity + 0.02
    return Case(
        name,
        ColumnImpact(name, column, Striker(mass, velocity), min(duration, 0.4)),
        parameters={
            "V/Vpl of the mechanism": max(demand.values()),
            BELOW: column.length_below,
            RATIO: mass / lumped,
            "steel": kind,
        },
        quick=number < 3,
    )


points = qmc.LatinHypercube(8, seed=SEED).random(COLUMNS)
cases = tuple(drawn(point, number) for number, point in enumerate(points))
gates = tuple(
    Gate(
        label,
        BEAM,
        "peak_displacement",
        "relative_error",
        bound,
        "What a factor in closed form may add to the error that models have without strain rate.",
        "Bound set by this study, not by a standard.",
    )
    for label, bound in (
        *(("4-DOF", 0.05), ("SDOF", 0.05)),
        *(("flexible superelements", 0.07), ("rigid superelements", 0.07)),
    )
)
study = Study(
    name="rate_columns",
    title="Columns in steel that feels the strain rate",
    question=(
        "How far off is each reduced model, with one factor on the yield stress for the strain "
        "rate, from fibers that follow the law point by point, and how far off are design rules?"
    ),
    cases=cases,
    models=models,
    reference=BEAM,
    groups={
        kind: tuple(case.name for case in cases if case.parameters["steel"] == kind)
        for kind in NAMES
    },
    decisive="errors",
    quantities=("peak_displacement",),
    gates=gates,
    figures=(
        Figure(
            "errors",
            "domain-map",
            "Errors of the peak with rate, without it, and by a rule",
            "Each point is a column; the colour is the class of the error of the peak.",
            ("4-DOF", "SDOF", "flexible superelements", "4-DOF, static", "4-DOF, 1.2 fy"),
            {
                "against": BEAM,
                "x": "striker over lumped mass",
                "over": "length below in m",
                "y": "v/La",
            },
        ),
        Figure(
            "cost",
            "cost",
            "Cost against error",
            "Wall time of one run against the error of the peak, over all columns.",
        ),
    ),
    quick_models=(BEAM, "4-DOF", "SDOF", "4-DOF, static"),
    notes=(
        "The beam knows no shear yielding: this compares hinges with fibers, so superelements run "
        "without panels.",
        "Columns were drawn by a fixed seed after the models were set; none was left out.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
