"""Which model for your column: every column model on 320 drawn columns, and where it may be taken.

Section families, length, position, supports, axial load, restraint, striker and speed are drawn by
a Sobol sequence; the beam whose webs yield answers all of them, the struck solid a few, the fiber
beam every fourth. Every fifth column is left out of the rules and checks them.
"""

import sys
from dataclasses import replace
from math import exp, log

import numpy as np
from scipy.stats import qmc

from workbench.cli import main
from workbench.evidence.descriptors import descriptors
from workbench.models.domain import euler_load, shear_demand
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.practice.biggs import Biggs
from workbench.models.practice.catenary import Izzuddin, TrilinearCatenary, YinWang
from workbench.models.practice.hand_estimate import HandEstimate
from workbench.models.practice.hard_impact import HardImpact
from workbench.models.single_dof import SingleDof
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.references.fiber_reissner import FiberReissner
from workbench.references.fiber_shear import FiberShear
from workbench.references.solid import SolidPlaneStress
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.sections import find, rectangular_tube, square
from workbench.study import Case, Figure, Study

FAMILIES = {
    "IPE": ("IPE 200", "IPE 270", "IPE 330", "IPE 400", "IPE 500"),
    "HEA": ("HEA 160", "HEA 220", "HEA 300"),
    "HEB": ("HEB 160", "HEB 200", "HEB 260", "HEB 340"),
}
SECTIONS = (
    *(find(name) for names in FAMILIES.values() for name in names),
    rectangular_tube(0.15, 0.15, 0.008),
    rectangular_tube(0.25, 0.15, 0.01),
    rectangular_tube(0.3, 0.3, 0.012),
    square(0.12),
)
WEB, SOLID, BEAM = "web-yielding beam", "solid", "fiber beam"
REFINED = "web-yielding beam, refined"  # the same with the coarser meshes that tell its error
REDUCED = {
    "4-DOF with panels": FourDofShear(),
    "SDOF with panels": SingleDof(resistance="panel", hit_mass="waves"),
    "energy with panels": EnergyEstimate(resistance="panel", hit_mass="waves"),
    "rigid superelements": RigidSuperelement(),
    "flexible superelements": FlexibleSuperelement(),
    "4-DOF": FourDof(),
    "4-DOF, springs of the thesis": FourDof(rotational_stiffness=6.0),
    "SDOF analytic": SingleDof(),
    "SDOF cubic": SingleDof(resistance="cubic"),
    "SDOF linear N": SingleDof(resistance="linear"),
    "energy estimate": EnergyEstimate(),
    "energy, cubic": EnergyEstimate(resistance="cubic"),
    "tri-linear catenary": TrilinearCatenary(),
    "Yin-Wang": YinWang(),
    "Izzuddin": Izzuddin(),
    "Biggs": Biggs(),
    "hand estimate": HandEstimate(),
    "EN 1991-1-7 hard impact": HardImpact(),
}
models = {
    WEB: FiberShear(levels=1),
    REFINED: FiberShear(levels=2),
    SOLID: SolidPlaneStress(),
    BEAM: FiberReissner(levels=1),
}
models |= REDUCED
COLUMNS, UNSEEN = 320, 5  # of which every so many check the rules that the others make
BEAMS, REFINEMENTS, SOLIDS = 4, 16, 64  # every so many columns have them
PLATES = 3  # every so many columns are without root fillets, as those of the thesis
LEAST, MOST = 0.3, 6e4  # mass of the striker: over the lumped mass, and in kg
PART, DEMAND, TURNED, SHARE = "part", "V/Vpl of the mechanism", "length below in m", "P/Npl"


def drawn(point: np.ndarray, number: int) -> Case:
    """The column and the strike of a point of the unit cube (10,).

    A velocity, and the mass that would push the mechanism to a drawn part of the shorter segment:
    from elastic hits to collapse, within what strikers weigh.
    """
    u = point.tolist()
    section = SECTIONS[int(u[0] * len(SECTIONS))]
    section = section if number % PLATES else section.without_fillets()
    length, position = 2.5 + 4.5 * u[1], 0.1 + 0.8 * u[2]
    below, above = (max(part * length, 1.8 * section.height) for part in (position, 1.0 - position))
    base = "pinned" if u[3] < 0.25 else "clamped"
    head = "guided" if u[4] < 0.6 else "pinned" if u[4] < 0.85 else "fixed"
    spring = 0.0 if u[5] < 0.2 else 10.0 ** (5.0 + 5.0 * (u[5] - 0.2))
    column = Column(section, below, above, base=base, head=head, restraint_stiffness=spring)
    impact = ColumnImpact("drawn", column, Striker(1.0, 1.0))
    share = 0.0 if u[6] < 0.2 else 0.5 * (u[6] - 0.2)
    load = min(share * column.properties.squash_load, 0.6 * euler_load(impact))
    impact = replace(impact, column=replace(column, axial_load=load))
    velocity = exp(log(0.7) + u[7] * log(25.0 / 0.7))
    reach = exp(log(0.002) + u[8] * log(1.0 / 0.002)) * min(below, above)
    resistance = sum(min(each, 1.0) for each in shear_demand(impact).values())
    resistance *= column.properties.shear_resistance
    mass = 2.0 * resistance * reach / velocity**2
    mass = min(max(mass, LEAST * column.properties.impact_mass), MOST)
    travelled = 0.5 * mass * velocity**2 / resistance
    duration = 5.0 * travelled / velocity + 0.02  # 2.5 times what a constant force takes
    name = f"{number:03d} {section.name.replace(' without fillets', ', plates')}, "
    name += f"{below:.2f} + {above:.2f} m, {velocity:.1f} m/s, {mass:.0f} kg"
    impact = replace(impact, name=name, striker=Striker(mass, velocity), duration=duration)
    asked = {WEB: True, SOLID: number % SOLIDS == SOLIDS // 2, BEAM: number % BEAMS == 0}
    asked[REFINED] = number % REFINEMENTS == 5
    told = descriptors(impact)
    return Case(
        name,
        impact,
        models=tuple(label for label in models if asked.get(label, True)),
        parameters={
            PART: "unseen" if number % UNSEEN == UNSEEN - 1 else "rules",
            DEMAND: told["shear_demand"],
            TURNED: below,
            SHARE: told["axial_over_squash"],
            "energy over elastic": told["energy_over_elastic"],
            "striker over lumped mass": told["striker_over_lumped"],
        },
        quick=number in range(5, COLUMNS, 32),  # of those whose numerical error is known
    )


points = qmc.Sobol(10, seed=14).random(512)[:COLUMNS]
cases = tuple(drawn(point, number) for number, point in enumerate(points))


def between(name: str, least: float, most: float) -> tuple[str, ...]:
    """Cases with a parameter in a range."""
    return tuple(case.name for case in cases if least <= case.parameters[name] < most)


mild = set(between("energy over elastic", 0.0, 5.0))
groups = {
    "hits that hardly yield": tuple(case.name for case in cases if case.name in mild),
    **{
        title: tuple(name for name in between(DEMAND, *edges) if name not in mild)
        for title, edges in {
            "V/Vpl below 0.5": (0.0, 0.5),
            "V/Vpl 0.5 to 1": (0.5, 1.0),
            "V/Vpl above 1": (1.0, 1e9),
        }.items()
    },
}
figures = (
    Figure(
        "map",
        "domain-map",
        "Where each model stays within 5 and 10 %",
        "Each point is a column; the colour is the class of the error of the peak displacement. "
        "Open points carry a warning of the model about its domain.",
        tuple(REDUCED)[:9],
        {"against": WEB, "x": DEMAND, "over": TURNED, "y": "v/La"},
    ),
    Figure(
        "cost",
        "cost",
        "Cost against error",
        "Wall time of one run against the error of the peak, over all columns.",
        (WEB, *REDUCED),
    ),
)

study = Study(
    name="which_model",
    title="Which model for which column",
    question=(
        "Over section families, length, position, supports, axial load, restraint, striker and "
        "speed: which column model comes within 10 % of the best reference, where, and at what "
        "cost; which one misses a collapse, or sees one that is none?"
    ),
    cases=cases,
    models=models,
    reference=WEB,
    references=(SOLID, REFINED, WEB, BEAM),
    groups=groups,
    decisive="map",
    quantities=("peak_displacement", "residual_displacement", "time_of_peak", "peak_force"),
    figures=figures,
    notes=(
        "Columns are drawn by a scrambled Sobol sequence with a fixed seed, none left out "
        f"afterwards; every {UNSEEN}th checks the rules that the others make. Every {PLATES}rd is "
        "of plates, without root fillets.",
        "The struck solid is the reference where the study has one, else the beam whose webs "
        "yield, on one mesh; its numerical error is told by every 16th column.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
