"""A study of this package: from which velocity on is a clamped bar a rigid-plastic one."""

import workbench as wb
from rigid_plastic_beam.model import RigidPlasticBeam
from workbench.steel.sections import rectangle

VELOCITIES = 4.0, 8.0, 12.0, 16.0  # m/s
FAST = "12 m/s", "16 m/s"  # 15 and more times the energy that the bar can store

bar = wb.Column(rectangle(0.05, 0.1), length_below=1.0, length_above=1.0, head="fixed")
hit = wb.impact(bar, mass="500 kg", velocity=16.0)
study = wb.Study(
    name="rigid_plastic_beam",
    title="A clamped bar, rigid and perfectly plastic",
    question="From which velocity on is a clamped bar a rigid-plastic one?",
    cases=tuple(
        wb.Case(f"{v:g} m/s", hit.at_velocity(v), parameters={"velocity (m/s)": v}, quick=v == 16.0)
        for v in VELOCITIES
    ),
    models={
        "fibers": wb.make_model("fiber-reissner", {"refinement": -1}),
        "rigid": RigidPlasticBeam(),
        "single-dof": wb.make_model("single-dof"),
    },
    reference="fibers",
    quantities=("peak_displacement",),
    gates=(
        wb.Gate(
            model="rigid",
            against="fibers",
            quantity="peak_displacement",
            metric="relative_error",
            bound=0.10,
            rationale="Wanted for a first estimate of fast hits.",
            source="Bound set by this study.",
            cases=FAST,
        ),
    ),
    figures=(wb.Figure("peaks", "sweep", "Peaks", "Over the velocity of the striker."),),
)
