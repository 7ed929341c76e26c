"""Which model for your column: every column model on 900 drawn columns, and its errors.

Sections, steel, length, position, supports, axial load, restraint, masses, speed and restitution
are drawn by a Sobol sequence, stratified by the mass ratio and the shear demand; the beam whose
webs yield answers all of them, the struck solid a few, the fiber beam every fifth. The peaks are
the data of the error model. Every 30th column is hit once more in steel that feels its strain rate;
those are no data.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import exp, log

import numpy as np
from scipy.stats import qmc

from workbench.cli import main
from workbench.extras.practice.biggs import Biggs
from workbench.extras.practice.catenary import Izzuddin, TrilinearCatenary, YinWang
from workbench.extras.practice.hand_estimate import HandEstimate
from workbench.extras.practice.hard_impact import HardImpact
from workbench.models.domain import euler_load, shear_demand
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.references.solid import SolidPlaneStress
from workbench.models.single_dof import SingleDof
from workbench.models.strain_rate import with_rate
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.materials import Steel
from workbench.steel.sections import Section, find, rectangular_tube, square
from workbench.study import Case, Figure, Study
from workbench.study.assessment.variations import rate_law
from workbench.study.error_model.error_table import DEMAND as SHEAR
from workbench.study.error_model.error_table import STRIKER, features

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
COARSE = "solid, coarse"  # elements twice as large: peaks within 1 % of the solid, at a tenth
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
    COARSE: SolidPlaneStress(refinement=-1, levels=1),
    BEAM: FiberReissner(levels=1),
}
models |= REDUCED
BEAMS, COARSES, REFINEMENTS, SOLIDS = 5, 11, 16, 64  # every so many columns have them
RATES = 30  # every so many columns are hit once more in steel that feels its strain rate
PLATES = 4  # every so many columns are without root fillets, as those of the thesis
LEAST, MOST = 0.3, 6e4  # mass of the striker: over the lumped mass, and in kg
STEELS = (355e6, 355e6, 235e6, 275e6, 460e6)  # yield stress, Pa
RATIOS, DEMANDS = (0.6, 5.0), (0.5, 1.0)  # ends of the cells that the draw is stratified by
QUOTAS = np.array([[75, 85, 110], [80, 85, 110], [135, 110, 110]])  # columns a cell
DEMAND, TURNED, SHARE = "V/Vpl of the mechanism", "length below in m", "P/Npl"


def drawn(
    point: np.ndarray,
    number: int,
    light: bool,
    sections: Sequence[Section] = SECTIONS,
    shares: tuple[float, float] = (-0.1, 0.4),
) -> ColumnImpact:
    """The column and the strike of a point of the unit cube (14,).

    Its section is one of `sections`, its share of the squash load lies between those, none below 0.

    A velocity, and the mass that would push the mechanism to a drawn part of the shorter segment:
    from elastic hits to collapse, within what strikers weigh. The mass of a `light` striker is
    drawn by itself, as such strikers are rare.
    """
    u = point.tolist()
    section = sections[int(u[0] * len(sections))]
    section = section if number % PLATES else section.without_fillets()
    length, position = 2.5 + 4.5 * u[1], 0.1 + 0.8 * u[2]
    below, above = (max(part * length, 1.8 * section.height) for part in (position, 1.0 - position))
    base = "pinned" if u[3] < 0.25 else "clamped"
    head = "guided" if u[4] < 0.6 else "pinned" if u[4] < 0.85 else "fixed"
    spring = 0.0 if u[5] < 0.2 else 10.0 ** (5.0 + 5.0 * (u[5] - 0.2))
    steel = Steel(yield_stress=STEELS[int(u[10] * len(STEELS))])
    axis = "strong" if section == section.about("strong") else "weak"
    ends = {"base": base, "head": head, "restraint_stiffness": spring}
    column = Column(section, below, above, steel, axis=axis, **ends)
    impact = ColumnImpact("drawn", column, Striker(1.0, 1.0))
    share = max(shares[0] + u[6] * (shares[1] - shares[0]), 0.0)
    load = min(share * column.properties.squash_load, 0.6 * euler_load(impact))
    column = replace(column, axial_load=load)
    impact = replace(impact, column=column)
    least, most = (2.0, 30.0) if light else (0.7, 25.0)
    velocity = exp(log(least) + u[7] * log(most / least))
    reach = exp(log(0.002) + u[8] * log(1.0 / 0.002)) * min(below, above)
    resistance = sum(min(each, 1.0) for each in shear_demand(impact).values())
    resistance *= column.properties.shear_resistance
    lumped = column.properties.impact_mass
    mass = min(max(2.0 * resistance * reach / velocity**2, LEAST * lumped), MOST)
    mass = LEAST * (RATIOS[0] / LEAST) ** u[13] * lumped if light else mass
    travelled = 0.5 * mass * velocity**2 / resistance
    duration = 5.0 * travelled / velocity + 0.02  # 2.5 times what a constant force takes
    bounce = 0.0 if u[11] < 0.6 else 2.5 * (u[11] - 0.6)
    head_mass = 0.0 if u[12] < 0.6 else mass * 10.0 ** (5.0 * (u[12] - 0.6) - 1.0)
    column = replace(column, head_mass=head_mass)
    return ColumnImpact("drawn", column, Striker(mass, velocity, bounce), duration)


def stratified(seed: int, quotas: np.ndarray) -> Iterator[tuple[ColumnImpact, int]]:
    """Columns of a Sobol sequence until each cell of mass ratio and V/Vpl holds its quota.

    Half of the points are drawn with light strikers. Raises `RuntimeError` if a cell stays open.
    """
    left, number = quotas.copy(), 0
    for index, point in enumerate(qmc.Sobol(14, seed=seed).random(2**14)):
        impact = drawn(point, number, bool(index % 2))
        values = features(impact)
        cell = (
            int(np.searchsorted(RATIOS, values[STRIKER], "right")),
            int(np.searchsorted(DEMANDS, values[SHEAR], "right")),
        )
        if left[cell] > 0:
            left[cell] -= 1
            yield impact, number
            number += 1
        if not left.any():
            return
    raise RuntimeError(f"cells of the draw stay open: {left.tolist()}")


def case_of(impact: ColumnImpact, number: int) -> Case:
    """The case of a drawn column: its name, the references that it has, and its parameters."""
    column, striker = impact.column, impact.striker
    name = f"{number:04d} {column.section.name.replace(' without fillets', ', plates')}, "
    name += f"{column.length_below:.2f} + {column.length_above:.2f} m, "
    name += f"{striker.velocity:.1f} m/s, {striker.mass:.0f} kg"
    values = features(impact)
    present = {SOLID: number % SOLIDS == SOLIDS // 2, BEAM: number % BEAMS == 0}
    light = values[STRIKER] < RATIOS[0]  # twice as many: there the beam is least sure
    present[COARSE] = number % COARSES == 5 or (light and number % COARSES == 6)
    present[REFINED] = number % REFINEMENTS == 5
    return Case(
        name,
        replace(impact, name=name),
        models=tuple(label for label in models if present.get(label, True)),
        parameters={
            DEMAND: values[SHEAR],
            TURNED: column.length_below,
            SHARE: values["axial_over_squash"],
            "energy over elastic": values["energy_over_elastic"],
            "striker over lumped mass": values[STRIKER],
        },
        quick=number in range(5, 320, 32),  # of those whose numerical error is known
    )


def rated(case: Case) -> Case:
    """The case with the rate law of the grade, by reduced models and the beam whose webs yield."""
    name = f"{case.name}, with rate"
    scenario = replace(with_rate(case.scenario, rate_law(case.scenario)), name=name)
    return replace(case, name=name, scenario=scenario, models=(WEB, *REDUCED), quick=False)


cases = tuple(case_of(impact, number) for impact, number in stratified(14, QUOTAS))
DRAWN = tuple(case.name for case in cases)


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
twins = tuple(map(rated, cases[::RATES]))
groups["with strain rate"] = tuple(case.name for case in twins)
figures = (
    Figure(
        "chooser",
        "chooser",
        "Error against cost",
        "Nine of ten errors of the peak lie below a mark. Black marks are ways to choose among "
        "models; the reference counts as right.",
        tuple(REDUCED),
    ),
    Figure(
        "map",
        "domain-map",
        "Where each model stays within 5 and 10 %",
        "Each point is a column; the colour is the class of the error of the peak displacement. "
        "Open points carry a warning of the model about its domain.",
        tuple(REDUCED)[:9],
        {"cases": DRAWN, "against": WEB, "x": DEMAND, "over": TURNED, "y": "v/La"},
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
    cases=(*cases, *twins),
    models=models,
    reference=WEB,
    references=(SOLID, COARSE, REFINED, WEB, BEAM),
    groups=groups,
    decisive="chooser",
    quantities=("peak_displacement", "residual_displacement", "time_of_peak", "peak_force"),
    figures=figures,
    notes=(
        f"Every {RATES}th column is hit once more in steel with the rate law of its grade, by one "
        "factor on the yield stress in reduced models, in every fiber in the web-yielding beam. "
        "The error model and the ways to choose are of the static yield stress.",
        "What is said of a column comes from the other columns of its cell (cross-validation).",
        "Columns are drawn by a scrambled Sobol sequence with a fixed seed until each of nine "
        "cells of mass ratio and V/Vpl holds its quota, none left out afterwards; every "
        f"{PLATES}th is of plates, without root fillets.",
        "The struck solid is the reference where the study has one, else the beam whose webs "
        "yield, on one mesh; its numerical error is told by every 16th column.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
