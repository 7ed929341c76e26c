"""When the stiffness of the vehicle matters: strikers that give way against a rigid one.

The column of the thesis, struck by masses from half to nine times that of the car in it, at 5 to
20 m/s, behind springs from a car (300 kN/m) to nearly rigid. One model differs from the other in
the spring alone: the SDOF column with restitution 1 is the limit of the rigid striker.
"""

import sys
from itertools import product

from workbench.cli import main
from workbench.models.single_dof import SingleDof
from workbench.models.soft_impact import SoftImpact
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

MASSES = (500.0, 1000.0, 1500.0, 2500.0, 4500.0)  # kg
VELOCITIES = (5.0, 10.0, 15.0, 20.0)  # m/s
STIFFNESSES = {"car": 3e5, "1 MN/m": 1e6, "3 MN/m": 3e6, "10 MN/m": 1e7, "100 MN/m": 1e8}  # N/m
RIGID, CRUSHING = "rigid striker", "car that crushes at 300 kN"
COLUMN = Column(find("HEB 220"), 0.8, 3.2, axial_load=0.5e6, restraint_stiffness=1e7, fillets=False)

models = {
    RIGID: SingleDof(resistance="panel"),
    **{
        f"striker of {name}": SoftImpact(striker_stiffness=stiffness, resistance="panel")
        for name, stiffness in STIFFNESSES.items()
    },
    CRUSHING: SoftImpact(striker_stiffness=STIFFNESSES["car"], crush_force=3e5, resistance="panel"),
}
cases = tuple(
    Case(
        f"{mass:g} kg at {velocity:g} m/s",
        ColumnImpact(
            f"{mass:g} kg at {velocity:g} m/s", COLUMN, Striker(mass, velocity, 1.0), duration=0.4
        ),
        parameters={
            "striker over impact mass": round(mass / COLUMN.properties.impact_mass, 1),
            "velocity in m/s": velocity,
        },
        quick=mass in MASSES[::2],
    )
    for mass, velocity in product(MASSES, VELOCITIES)
)
STIFFEST = f"striker of {list(STIFFNESSES)[-1]}"
gates = (
    Gate(
        STIFFEST,
        RIGID,
        "peak_displacement",
        "relative_error",
        0.05,
        "From this stiffness on the rigid striker stands for the vehicle.",
        "Bound set by this study, not by a standard.",
    ),
)
figures = tuple(
    Figure(
        f"map-{label.split()[-1].replace('/', '-')}-{number}",
        "sweep",
        f"{label}: peak displacement against that of a rigid one",
        "Relative difference of the peaks. A striker that gives way below the resistance of the "
        "column, some 550 kN, leaves it elastic.",
        (label,),
        {"x": "striker over impact mass", "y": "velocity in m/s"},
    )
    for number, label in enumerate(models)
    if label != RIGID
)
study = Study(
    name="soft_impact",
    title="When the stiffness of the vehicle matters",
    question=(
        "From which stiffness on may a vehicle be taken as rigid when it strikes a steel column?"
    ),
    cases=cases,
    models=models,
    reference=RIGID,
    groups={
        f"{velocity:g} m/s": tuple(
            case.name for case in cases if case.scenario.striker.velocity == velocity
        )
        for velocity in VELOCITIES
    },
    quantities=("peak_displacement", "peak_force"),
    gates=gates,
    figures=figures,
    decisive=figures[2].key,
    notes=(
        "The rigid striker is no truth here but the other model: differences are what its "
        "rigidity does, not errors. Both share the resistance of the column, whose web yields in "
        "shear, and its mass.",
        "300 kN/m is what EN 1991-1-7, Annex C, gives for cars; frames and loads of lorries do "
        "not crush like that.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
