"""How far column models can be trusted where the web may yield in shear: 120 drawn columns.

I sections and hollow sections, hit low or in the middle, slowly or fast, by heavy or light
strikers: every column model against the beam whose webs yield, a subset against the struck solid.
The axes of its maps are the shear force that a plastic mechanism needs over the plastic shear
resistance, V/Vpl, and the largest displacement over the length of the segment below the impact
point, v/La.

The columns are drawn by a Latin hypercube. They were drawn after the first part of the rule "waves"
for the mass at the impact point (webs that slide), and before its second part (supports that feel
the hit late), which was then tried on others: see docs/theory/hit-mass.md. Every fourth column that
is hit hard is hit once more in steel that feels its strain rate.
"""

import sys
from dataclasses import replace
from math import exp, log

import numpy as np
from scipy.stats import qmc

from workbench.cli import main
from workbench.models.domain import euler_load, shear_demand
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.references.solid import SolidPlaneStress
from workbench.models.single_dof import SingleDof
from workbench.models.strain_rate import with_rate
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find, rectangular_tube
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate
from workbench.study.assessment.variations import rate_law

SECTIONS = (
    *(find(name) for name in ("HEB 160", "HEB 220", "HEB 300", "HEA 240")),
    *(find(name) for name in ("IPE 240", "IPE 300", "IPE 400")),
    rectangular_tube(0.2, 0.2, 0.01),
    rectangular_tube(0.25, 0.15, 0.01),
    rectangular_tube(0.3, 0.2, 0.012),
)
WEB, SOLID, BEAM = "web-yielding beam", "solid", "fiber beam"
PANELS, THESIS_MASS = "4-DOF with panels", "4-DOF with panels, thesis' mass"
REDUCED = {
    PANELS: FourDofShear(),
    THESIS_MASS: FourDofShear(hit_mass="thesis"),
    "energy with panels": EnergyEstimate(resistance="panel", hit_mass="waves"),
    "SDOF with panels": SingleDof(resistance="panel", hit_mass="waves"),
    "rigid bars with panels": RigidSuperelement(),
    "flexible bars with panels": FlexibleSuperelement(),
    "4-DOF": FourDof(),
    "SDOF analytic": SingleDof(resistance="analytic"),
    "SDOF cubic": SingleDof(resistance="cubic"),
    "energy estimate": EnergyEstimate(),
}
models = {
    WEB: FiberShear(levels=2),
    SOLID: SolidPlaneStress(),
    BEAM: FiberReissner(levels=2),
    **REDUCED,
}
PLATES = 3  # every so many columns are without root fillets, as those of the thesis
SHORTEST = 1.8  # segment over height of the section; what is shorter is no bar
MASSIVE, SLOW, SOLIDS = 104, 16, 26  # columns hit hard, hit elastically; of the hard hits as solids
RATES = 4  # every so many hard hits are answered in steel that feels its strain rate too
DEMAND, LENGTH = "V/Vpl of the mechanism", "length below the impact point in m"
RATIO, HIT = "striker over lumped mass", "hit"


def column_of(share: np.ndarray, number: int) -> ColumnImpact:
    """The column of a point of the unit cube (8,), at first without a strike to speak of.

    Dimensions: V/Vpl of the segment below, length above, supports, restraint, axial load, and
    three of the strike.
    """
    section = SECTIONS[number % len(SECTIONS)]
    section = section if number % PLATES else section.without_fillets()
    base = "pinned" if share[2] < 0.25 else "clamped"
    head = "pinned" if 0.15 < share[2] < 0.4 else "guided"
    wanted = exp(log(0.2) + share[0] * log(3.5 / 0.2))
    metre = ColumnImpact("1 m", Column(section, 1.0, 1.0, base=base), Striker(1.0, 1.0))
    below = max(shear_demand(metre)["below"] / wanted, SHORTEST * section.height)
    above = max(2.5 + 2.0 * share[1] - below, (1.0 + 0.8 * share[1]) * below)
    column = Column(
        section, below, above, base=base, head=head, restraint_stiffness=10.0 ** (6 + 2 * share[3])
    )
    impact = ColumnImpact("drawn", column, Striker(1.0, 1.0))
    load = min(0.3 * share[4] * column.properties.squash_load, 0.2 * euler_load(impact))
    return replace(impact, column=replace(column, axial_load=load))


def strike(impact: ColumnImpact, share: np.ndarray, number: int, slow: bool) -> Case:
    """The case of a drawn column: a velocity, and a mass that leads to a drawn displacement."""
    column = impact.column
    velocity = 0.5 + 3.5 * share[5] if slow else 5.0 + 20.0 * share[5]
    reach = (0.001 + 0.01 * share[6] if slow else 0.03 + 0.32 * share[6]) * column.length_below
    demand = shear_demand(impact)
    resistance = sum(min(each, 1.0) for each in demand.values())
    resistance *= column.properties.shear_resistance
    lumped = column.properties.impact_mass
    mass = max(2.0 * resistance * reach / velocity**2, 0.3 * lumped)
    duration = min(max(0.02, 6.0 * reach / velocity + 0.02), 0.1)
    name = (
        f"{number:03d} {column.section.name.replace(' without fillets', ', plates')}, "
        f"V/Vpl {demand['below']:.2f}, {velocity:.1f} m/s, {mass:.0f} kg"
    )
    hard = number < MASSIVE
    asked = tuple(label for label in models if label != SOLID or number < SOLIDS)
    return Case(
        name,
        replace(impact, name=name, striker=Striker(mass, velocity), duration=duration),
        models=asked,
        parameters={
            DEMAND: max(demand.values()),
            LENGTH: column.length_below,
            RATIO: mass / lumped,
            HIT: "plastic" if hard else "elastic",
        },
        quick=number in (1, 7, MASSIVE),
    )


def rated(case: Case) -> Case:
    """The case with the rate law of the grade, by reduced models and the beam whose webs yield."""
    name = f"{case.name}, with rate"
    scenario = replace(with_rate(case.scenario, rate_law(case.scenario)), name=name)
    return replace(case, name=name, scenario=scenario, models=(WEB, *REDUCED), quick=False)


points = qmc.LatinHypercube(8, seed=2026).random(MASSIVE + SLOW)
cases = tuple(
    strike(column_of(share, number), share, number, number >= MASSIVE)
    for number, share in enumerate(points)
)
twins = tuple(map(rated, cases[:MASSIVE:RATES]))
DRAWN, RATED = (tuple(case.name for case in some) for some in (cases, twins))


def hit_hard(least: float, most: float) -> tuple[str, ...]:
    """Cases with plastic hits and a shear demand of the mechanism in a range."""
    hard = (case for case in cases if case.parameters[HIT] == "plastic")
    return tuple(case.name for case in hard if least <= case.parameters[DEMAND] < most)


STRUCK = tuple(case.name for case in cases[:SOLIDS])

gates = (
    *(
        Gate(
            label,
            SOLID,
            "peak_displacement",
            "relative_error",
            0.10,
            "Wanted for design; the columns beyond it mark where a model stops being trustworthy.",
            "Bound set by this study, not by a standard.",
            STRUCK,
        )
        for label in (PANELS, "energy with panels", "4-DOF", WEB, BEAM)
    ),
    *(
        Gate(
            label,
            WEB,
            "peak_displacement",
            "relative_error",
            0.10,
            "Over all columns, those without a struck solid among them.",
            "Bound set by this study, not by a standard.",
            DRAWN,
        )
        for label in (PANELS, THESIS_MASS, "4-DOF", BEAM)
    ),
    Gate(
        PANELS,
        WEB,
        "peak_displacement",
        "relative_error",
        0.10,
        "One factor on the yield stress against the rate law in every fiber.",
        "Bound set by this study, not by a standard.",
        RATED,
    ),
)


def domain_map(key: str, against: str, shown: tuple[str, ...], title: str) -> Figure:
    """A map of the errors over V/Vpl and v/La."""
    return Figure(
        key,
        "domain-map",
        title,
        "Each point is a column; the colour is the class of the error of the peak displacement. "
        "Open points carry a warning of the model about its domain.",
        shown,
        {"cases": DRAWN, "against": against, "x": DEMAND, "over": LENGTH, "y": "v/La"},
    )


figures = (
    domain_map(
        "map-solid",
        SOLID,
        (PANELS, "energy with panels", "4-DOF", "SDOF analytic", WEB, BEAM),
        "Where each model stays within 5 and 10 % of the struck solid",
    ),
    domain_map(
        "map-web",
        WEB,
        (PANELS, THESIS_MASS, "rigid bars with panels", "4-DOF", "SDOF analytic", BEAM),
        "The same against the beam whose webs yield, over all columns",
    ),
    Figure(
        "mass",
        "domain-map",
        "What the mass at the impact point does",
        "Errors over the mass of the striker by the lumped one of the thesis; light strikers left.",
        (PANELS, THESIS_MASS),
        {"cases": DRAWN, "against": WEB, "x": RATIO, "over": LENGTH, "y": "v/La"},
    ),
    Figure(
        "cost",
        "cost",
        "Cost against error",
        "Wall time of one run against the error of the peak, over all columns.",
    ),
)

study = Study(
    name="shear_columns",
    title="Columns whose webs may yield in shear",
    question=(
        "Over sections, supports, places, speeds and strikers: within what shear demand and what "
        "displacement does each column model stay within 5 and 10 % of a beam whose webs yield, "
        "and of a struck solid?"
    ),
    cases=(*cases, *twins),
    models=models,
    reference=WEB,
    references=(SOLID, WEB, BEAM),
    groups={
        "V/Vpl below 0.5": hit_hard(0.0, 0.5),
        "V/Vpl 0.5 to 1": hit_hard(0.5, 1.0),
        "V/Vpl above 1": hit_hard(1.0, 1e3),
        "elastic hits": tuple(case.name for case in cases if case.parameters[HIT] == "elastic"),
        "with strain rate": RATED,
    },
    decisive="map-solid",
    quantities=("peak_displacement", "residual_displacement"),
    gates=gates,
    figures=figures,
    quick_models=(WEB, SOLID, PANELS, "4-DOF"),
    notes=(
        "The struck solid is the reference where the study has one; the beam slides without "
        "stretching, and is outside its domain where it warns of a mean shear strain above 0.15.",
        "Columns are drawn by a Latin hypercube with a fixed seed, none left out afterwards; every "
        f"{PLATES}rd is of plates, without root fillets.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
