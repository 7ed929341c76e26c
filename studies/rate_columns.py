"""Columns in steel that feels the strain rate: reduced models against fibers of the same law.

Sections, steels, supports, place of the hit, axial load, restraint, mass and velocity of the
striker are drawn by a Latin hypercube. The reference is the fiber beam with the rate law in every
fiber; the models have one factor on the yield stress in closed form. Beside them: no rate, the
increase factors of design rules, and a hinge as long as the section is high. Columns whose webs
yield are answered again by models with panels and a beam whose webs yield at the rate. What stands
behind all of it, a hinge that turns at a constant rate, is compared by itself: closed form, fibers,
solid.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import exp, log
from typing import Any, ClassVar

import numpy as np
from scipy.integrate import solve_ivp
from scipy.stats import qmc

from workbench.base.fields import Choice, checked
from workbench.cli import main
from workbench.models.base import Answering
from workbench.models.domain import euler_load, shear_demand
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.references.solid import SolidPlaneStress
from workbench.models.single_dof import SingleDof
from workbench.models.strain_rate import stronger
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.hinges.panel_elements import overstress_shape, rotation_rate
from workbench.steel.materials import GRADES, MILD_STEEL, CowperSymonds, Steel
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

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
WEB, SOLID, CLOSED = "web-yielding beam", "solid", "hinge in closed form"
TURNING, BAR, RATES = 0.5, 3.0, (0.5, 2.0, 8.0)  # hinges at a constant rate: rad/s, m, rad/s
DEMAND, PANELS = "V/Vpl of the mechanism", "4-DOF with panels"
BARS_PANELS = "flexible superelements with panels"
FLOWING = tuple(f"{label}, bars" for label in (PANELS, BARS_PANELS))  # level B
STATIC = "4-DOF, static"
RULED = {  # that a rule is asked of
    "four-dof": FourDof(),
    "single-dof": SingleDof(),
    "flexible-superelement": FlexibleSuperelement(shear="none"),
}


@dataclass(frozen=True)
class ByRule(Answering):
    """A `model` with a yield stress by a `rule`: a factor, or a hinge of one height."""

    rule: str = checked(Choice((*FACTORS, "height")), "static")
    model: str = checked(Choice(tuple(RULED)), "four-dof")

    name: ClassVar[str] = "yield-stress-by-rule"
    version: ClassVar[int] = 2
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "A model with one factor on the yield stress, of a design rule or of a hinge as long as "
        "the section is high at half the velocity after the hit.",
    )
    sources: ClassVar[tuple[str, ...]] = ()
    material: ClassVar[tuple[str, ...]] = ("rate",)

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """No findings but those that come with the answer of the model."""
        return []

    def _solve(self, scenario: ColumnImpact) -> Response:
        factor = FACTORS.get(self.rule) or self._of_height(scenario)
        return RULED[self.model].simulate(stronger(scenario, factor))

    def _of_height(self, scenario: ColumnImpact) -> float:
        column, striker = scenario.column, scenario.striker
        shared = striker.mass / (striker.mass + column.properties.impact_mass) * striker.velocity
        rate = 0.25 * shared / min(column.length_below, column.length_above)
        law = column.steel.rate
        return 1.0 if law is None else law.factor(rate)


@dataclass(frozen=True)
class ClosedHinge(Answering):
    """Two elastic bars without mass between clamped ends, their hinges in closed form.

    The impact point moves at the velocity of the striker, which must be heavy.
    """

    name: ClassVar[str] = "closed-form-hinge"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Springs in series with the rotation rate of hinges along straight moment diagrams; small "
        "displacements, no mass.",
    )
    sources: ClassVar[tuple[str, ...]] = ()
    material: ClassVar[tuple[str, ...]] = ("rate",)

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """No findings: the study asks it where it is exact."""
        return []

    def _solve(self, scenario: ColumnImpact) -> Response:
        column, velocity = scenario.column, scenario.striker.velocity
        steel, section, length = column.steel, column.section, column.length_below
        strength = 4.0 * column.properties.plastic_moment / length
        bending = length**3 / (12.0 * steel.elastic_modulus * section.second_moment)
        stiffness = 2.0 / (bending + length / (steel.shear_modulus * section.shear_area))
        law = steel.rate
        assert law is not None
        shape = overstress_shape(section, law.exponent)

        def change(_: float, force: np.ndarray) -> list[float]:
            over = max(float(force[0]) / strength - 1.0, 0.0)
            turned = rotation_rate(over, 0.5 * length, section.height, shape, law)
            return [stiffness * (velocity - length * turned)]

        times = np.linspace(0.0, scenario.duration, 801)
        force = solve_ivp(change, times[[0, -1]], [0.0], "LSODA", times, rtol=1e-8).y[0]
        values = {"displacement": velocity * times, "impulse": np.trapezoid(force, times)}
        return build_response(values, time=times)


models: Mapping[str, Any] = {
    BEAM: FiberReissner(levels=2),
    WEB: FiberShear(levels=2),
    SOLID: SolidPlaneStress(),
    CLOSED: ClosedHinge(),
    "4-DOF": FourDof(hit_mass="waves"),
    "4-DOF, bars": FourDof(hit_mass="waves", rate_level="bars"),
    "4-DOF, hit mass of the thesis": FourDof(),
    "SDOF": SingleDof(hit_mass="waves"),
    "energy": EnergyEstimate(hit_mass="waves"),
    "flexible superelements": FlexibleSuperelement(shear="none"),
    "rigid superelements": RigidSuperelement(shear="none"),
    "flexible superelements, bars": FlexibleSuperelement(rate_level="bars", shear="elastic"),
    "rigid superelements, bars": RigidSuperelement(rate_level="bars", shear="elastic"),
    PANELS: FourDofShear(),
    BARS_PANELS: FlexibleSuperelement(),
    FLOWING[0]: FourDofShear(rate_level="bars"),
    FLOWING[1]: FlexibleSuperelement(rate_level="bars"),
    STATIC: ByRule("static"),
    "SDOF, static": ByRule("static", "single-dof"),
    "flexible superelements, static": ByRule("static", "flexible-superelement"),
    "4-DOF, 1.1 fy": ByRule("1.1"),
    "4-DOF, 1.2 fy": ByRule("1.2"),
    "4-DOF, 1.3 fy": ByRule("1.3"),
    "4-DOF, hinge of one height": ByRule("height"),
}
# asked where webs yield, or of a hinge alone
APART = (WEB, SOLID, CLOSED, PANELS, BARS_PANELS, *FLOWING)
BENDING = tuple(label for label in models if label not in APART)


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
        models=BENDING,
        parameters={
            DEMAND: max(demand.values()),
            BELOW: column.length_below,
            RATIO: mass / lumped,
            "steel": kind,
        },
        quick=number < 3,
    )


points = qmc.LatinHypercube(8, seed=SEED).random(COLUMNS)
drawn_cases = tuple(drawn(point, number) for number, point in enumerate(points))
sheared = tuple(  # once more, by models and a beam whose webs yield
    replace(case, name=f"{case.name}, web", models=(WEB, PANELS, BARS_PANELS, *FLOWING))
    for case in drawn_cases
    if case.parameters[DEMAND] > 1.0
)


def hinge(rate: float) -> Case:
    """Four hinges of an HEB 220 of S355 that turn at a constant rate (rad/s).

    The law knows rates over D alone: all of them turn at `TURNING`, slow enough for masses to
    matter little, and D is that of S355 over `rate` / `TURNING`.
    """
    law = GRADES["S355"][1]
    slower = CowperSymonds(law.reference_rate * TURNING / rate, law.exponent)
    section = find("HEB 220").without_fillets()
    column = Column(section, BAR, BAR, Steel(rate=slower), base="clamped", head="guided")
    name = f"hinges at {rate:g} rad/s"
    impact = ColumnImpact(name, column, Striker(1e6, TURNING * BAR), 0.035 / TURNING)
    asked = (BEAM, SOLID, CLOSED, "4-DOF", "4-DOF, bars", STATIC)
    return Case(name, impact, models=asked, quick=rate == RATES[1])


hinges = tuple(hinge(rate) for rate in RATES)
cases = (*drawn_cases, *sheared, *hinges)
DRAWN, SHEARED, HINGES = (
    tuple(case.name for case in some) for some in (drawn_cases, sheared, hinges)
)
OWN_BOUND = "Bound set by this study, not by a standard."


def peak_gate(label: str, against: str, bound: float, of: tuple[str, ...]) -> Gate:
    """A model is to meet the peak of a reference with the same law within a bound."""
    return Gate(
        label,
        against,
        "peak_displacement",
        "relative_error",
        bound,
        "What a factor in closed form may add to the error that models have without strain rate.",
        OWN_BOUND,
        of,
    )


def hinge_gate(label: str, against: str, bound: float) -> Gate:
    """The moment of hinges at a constant rate, by the impulse that they take."""
    return Gate(
        label,
        against,
        "impulse",
        "relative_error",
        bound,
        "Plane sections make a short hinge 1.5 to 2.5 % too strong; fibers have them too.",
        OWN_BOUND,
        HINGES,
    )


gates = (
    *(peak_gate(label, BEAM, 0.05, DRAWN) for label in ("4-DOF", "4-DOF, bars", "SDOF")),
    *(
        peak_gate(f"{bars} superelements{level}", BEAM, 0.07, DRAWN)
        for bars in ("flexible", "rigid")
        for level in ("", ", bars")
    ),
    *(peak_gate(label, WEB, 0.10, SHEARED) for label in (PANELS, BARS_PANELS, *FLOWING)),
    *(hinge_gate(label, BEAM, 0.02) for label in (CLOSED, "4-DOF, bars")),
    hinge_gate(CLOSED, SOLID, 0.05),
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
    references=(BEAM, WEB),
    groups={
        **{
            kind: tuple(case.name for case in drawn_cases if case.parameters["steel"] == kind)
            for kind in NAMES
        },
        "webs that yield": SHEARED,
    },
    decisive="errors",
    quantities=("peak_displacement", "impulse"),
    gates=gates,
    figures=(
        Figure(
            "errors",
            "domain-map",
            "Errors of the peak with rate, without it, and by a rule",
            "Each point is a column; the colour is the class of the error of the peak.",
            ("4-DOF", "SDOF", "flexible superelements", STATIC, "4-DOF, 1.2 fy"),
            {"cases": DRAWN, "against": BEAM, "x": RATIO, "over": BELOW, "y": "v/La"},
        ),
        Figure(
            "hinge",
            "peaks",
            "A hinge that turns at a constant rate, without a length of its own",
            "Impulse that four hinges of an HEB 220 of S355 take while they turn by 0.035 rad: "
            "closed form along a straight moment diagram, fibers, plane stress. One factor (4-DOF) "
            "has the mean over a way on which the striker slows down, 12/13 of the overstress.",
            (BEAM, SOLID, CLOSED, "4-DOF, bars", "4-DOF", STATIC),
            {"cases": HINGES, "quantity": "impulse", "against": BEAM},
        ),
        Figure(
            "cost",
            "cost",
            "Cost against error",
            "Wall time of one run against the error of the peak, over all columns.",
        ),
    ),
    quick_models=(BEAM, "4-DOF", "SDOF", STATIC, CLOSED, WEB, PANELS),
    notes=(
        "The fiber beam knows no shear yielding: this compares hinges with fibers, so "
        "superelements run without panels, or with webs that stay elastic. Webs that yield are "
        "compared with the web-yielding beam.",
        "Columns were drawn by a fixed seed after the models were set; none was left out.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
