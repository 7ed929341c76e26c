"""Where each reduced column model stops being trustworthy.

Section x position of the hit x axial load x velocity, every model against the fiber reference or,
where webs yield in shear, against the fiber beam whose webs do.
"""

import sys
from dataclasses import replace
from itertools import product

from workbench.cli import main
from workbench.models.domain import shear_demand
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.single_dof import SingleDof
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find, square
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

LENGTH = 4.0  # m
SECTIONS = {"IPE 300": find("IPE 300"), "HEB 220": find("HEB 220"), "square 150": square(0.15)}
POSITIONS = (0.15, 0.3, 0.5)  # impact point over length
LOADS = (0.0, 0.15, 0.3)  # axial load over squash load
VELOCITIES = (5.0, 10.0, 20.0)  # m/s
REFERENCE, WEB, PANELS = "fiber beam", "web-yielding beam", "4-DOF with panels"
YIELDS = 0.8  # V/Vpl of the bending mechanism above which the web-yielding beam is asked too

models = {
    REFERENCE: FiberReissner(),
    WEB: FiberShear(),
    PANELS: FourDofShear(),
    "4-DOF": FourDof(),
    "SDOF analytic": SingleDof(resistance="analytic"),
    "SDOF cubic": SingleDof(resistance="cubic"),
    "energy estimate": EnergyEstimate(),
}
REDUCED = tuple(label for label in models if label not in (REFERENCE, WEB))


def impact(section: str, position: float, load: float, velocity: float) -> ColumnImpact:
    """The impact at one point of the sweep."""
    column = Column(
        SECTIONS[section],
        position * LENGTH,
        (1.0 - position) * LENGTH,
        restraint_stiffness=1e7,
    )
    column = replace(column, axial_load=load * column.properties.squash_load)
    # a striker of 15 column masses: heavy against the column, as a vehicle is
    mass = 15.0 * column.properties.mass_per_length * LENGTH
    name = f"{section}, hit at {position:g} L, {load:g} Np, {velocity:g} m/s"
    return ColumnImpact(name, column, Striker(mass, velocity), 0.15)


def demand(scenario: ColumnImpact) -> float:
    """Shear force V/Vpl that the bending mechanism of a case needs."""
    return max(shear_demand(scenario).values())


cases = tuple(
    Case(
        (scenario := impact(section, position, load, velocity)).name,
        scenario,
        models=tuple(models) if demand(scenario) >= YIELDS else (REFERENCE, *REDUCED),
        parameters={
            "section": section,
            "impact point over length": position,
            "axial load over squash load": load,
            "velocity in m/s": velocity,
        },
        quick=section == "HEB 220" and position != 0.3 and load != 0.15,
    )
    for section, position, load, velocity in product(SECTIONS, POSITIONS, LOADS, VELOCITIES)
)


def needing(least: float, most: float) -> tuple[str, ...]:
    """Cases whose bending mechanism needs a shear force V/Vpl in a range."""
    return tuple(case.name for case in cases if least <= demand(case.scenario) < most)


BOUNDS = {label: 0.05 if label.startswith("4-DOF") else 0.10 for label in REDUCED}
gates = tuple(
    Gate(
        model,
        against,
        "peak_displacement",
        "relative_error",
        bound,
        "Wanted for design; the cases beyond it mark where the model stops being trustworthy.",
        "Bound set by this study, not by a standard.",
        names,
    )
    for against, names in (
        (REFERENCE, needing(0.0, YIELDS)),
        (WEB, needing(YIELDS, 1e3)),
    )
    for model, bound in BOUNDS.items()
)

figures = (
    *(
        Figure(
            f"map-{model.replace(' ', '-').lower()}",
            "sweep",
            f"{model}: error of the peak displacement",
            "Relative error against the reference that counts: the web-yielding beam where it is "
            "asked, else the fiber beam. Percentages are those of the worst case of a field.",
            (model,),
            {
                "x": "impact point over length",
                "y": "axial load over squash load",
                "facet": "velocity in m/s",
            },
        )
        for model in REDUCED
    ),
    Figure(
        "cost",
        "cost",
        "Cost against error",
        "Wall time of one run against the error of the peak, over all cases.",
    ),
)

study = Study(
    name="column_sweep",
    title="Where reduced column models stop being trustworthy",
    question=(
        "Over section, position of the hit, axial load and velocity: how large is the error of "
        "each reduced model against distributed plasticity, where webs yield against beams whose "
        "webs do, and where is it out of its domain?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    references=(WEB, REFERENCE),
    groups={
        "V/Vpl below 0.5": needing(0.0, 0.5),
        "V/Vpl 0.5 to 1": needing(0.5, 1.0),
        "V/Vpl above 1": needing(1.0, 1e3),
    },
    gates=gates,
    figures=figures,
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
