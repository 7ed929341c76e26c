"""The impacted frame of P. Heng's thesis (KTH 2017, figures 5.13 and 5.14).

Four bays, two storeys, all members squares of 0.2 m; 1500 kg at 50 m/s hit the middle column 0.8 m
above its clamped base. Superelements against fiber frames on the published meshes and on finer
ones, and against the reading of the published curve.
"""

import sys
from dataclasses import replace

from workbench.base.datafiles import data_directory
from workbench.cli import main
from workbench.models.published import Published
from workbench.models.references.fiber_beams import FiberReissner
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import load_scenario
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

impact = load_scenario(data_directory() / "published" / "heng2017_frame.toml")
impact = replace(impact, duration=0.06)

OWN_BOUND = "Bound set by this study, not by a standard."
FIGURE_5_14 = "heng2017-figure-5-14"
REFERENCE = "fiber frame"
RIGID, LINEAR, NONE = (
    "rigid, nonlinear inertia",
    "rigid, linear inertia",
    "rigid, no rotary inertia",
)
FLEXIBLE, HALVES, STRAIGHT = "flexible", "rigid, two per member", "rigid, 1 / 1"
PUBLISHED, PUBLISHED_LINEAR = "Heng 2017: nonlinear inertia", "Heng 2017: linear inertia"
SIZES = {
    "320 elements": 0.2,
    "640 elements": 0.1,
    "1280 elements": 0.05,
    "2560 elements": 0.025,
}


def uniform(size: float) -> FiberReissner:
    """Elements of one size (m), with steps in proportion."""
    return FiberReissner(
        smallest_element=size, largest_element=size, time_step=size / 1000.0, levels=1
    )


BAR = RigidSuperelement(elements=1, rotational_stiffness=6.0)  # as in the thesis
models = {
    REFERENCE: FiberReissner(),
    RIGID: BAR,
    LINEAR: replace(BAR, inertia="linear"),
    NONE: replace(BAR, inertia="none"),
    FLEXIBLE: FlexibleSuperelement(elements=1),
    HALVES: replace(BAR, elements=2),
    STRAIGHT: replace(BAR, alpha=1.0, beta=1.0),
    **{label: uniform(size) for label, size in SIZES.items()},
    PUBLISHED: Published(FIGURE_5_14, "new formulation, nonlinear mass"),
    PUBLISHED_LINEAR: Published(FIGURE_5_14, "new formulation, linear mass"),
}
CASE = "50 m/s"
cases = (Case(CASE, impact),)


def gate(model: str, against: str, quantity: str, bound: float, why: str) -> Gate:
    """A bound on a relative error, uncertainties of both sides included."""
    return Gate(model, against, quantity, "relative_error", bound, why, OWN_BOUND)


FITNESS = (
    "The thesis states differences of about 1 percent to its own reference; its meshes are 3 to "
    "7 percent from their limit, so that 5 percent is asked for here."
)
gates = (
    gate(RIGID, REFERENCE, "peak_displacement", 0.05, FITNESS),
    gate(FLEXIBLE, REFERENCE, "peak_displacement", 0.05, FITNESS),
    gate(
        *(RIGID, PUBLISHED, "peak_displacement", 0.10),
        "The published curve can be read to 4 percent only: an inset from 0.46 to 0.5 m.",
    ),
    gate(
        *(LINEAR, RIGID, "peak_displacement", 0.005),
        "Linear and nonlinear rotary inertia give almost the same response (thesis, figure 5.14).",
    ),
)
figures = (
    Figure(
        "frame",
        "structure",
        "The frame (thesis figure 5.13)",
        "All members squares of 0.2 m; clamped bases and the density are inferred.",
        options={"case": CASE},
    ),
    Figure(
        "figure-5-14",
        "history",
        "Displacement of the impact point (thesis figure 5.14)",
        "Superelements with one element per member over the fiber frame.",
        (REFERENCE, RIGID, LINEAR, FLEXIBLE),
        {"cases": (CASE,)},
    ),
    Figure(
        "peaks",
        "peaks",
        "Peak displacements",
        "Above: peaks, the band is the uncertainty of the fiber frame. Below: deviations.",
        (REFERENCE, RIGID, LINEAR, NONE, FLEXIBLE, HALVES, STRAIGHT, PUBLISHED),
        {"cases": (CASE,)},
    ),
    Figure(
        "meshes",
        "meshes",
        "The published meshes",
        "The thesis compares with 640 and 1280 elements of one size: both are below the converged "
        "peak, by more than the difference that they were to measure.",
        (REFERENCE, *SIZES),
        {"sizes": SIZES},
    ),
    Figure(
        "convergence",
        "convergence",
        "Convergence of the fiber frame",
        "Meshes graded at every possible hinge.",
        (REFERENCE,),
        {"cases": (CASE,)},
    ),
    Figure(
        "deformed",
        "deformed",
        "Deformed frame",
        "Shapes and states of the hinges.",
        (REFERENCE, RIGID),
        {"cases": (CASE,)},
    ),
    Figure(
        "interaction",
        "interaction",
        "Path of axial force and moment",
        "Hinges of the struck column leave bending for tension and return. On the straight surface "
        "(1 / 1) tension costs more moment: the column goes further and pulls nearly twice as hard "
        "at the frame.",
        (RIGID, FLEXIBLE, STRAIGHT),
        {"case": CASE, "hinges": ("C0-C1/1:start", "C0-C1/1:end", "C0-C1/2:end")},
    ),
    Figure(
        "energy",
        "energy",
        "Energy ledger",
        "Where the energy of the striker goes.",
        (REFERENCE, RIGID, FLEXIBLE),
        {"case": CASE},
    ),
    Figure("cost", "cost", "Cost against error", "Wall time of one run against its error."),
)

study = Study(
    name="thesis_frame_impact",
    title="Impacted frame: superelements against distributed plasticity",
    question=(
        "How well do frames of one rigid or flexible superelement per member (Heng 2017, papers "
        "III and IV) predict the peak displacement of an impacted frame, and at what cost?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=(
        *("peak_displacement", "time_of_peak", "residual_displacement", "largest_drift"),
        *("largest_plastic_rotation", "largest_compression", "largest_tension"),
    ),
    groups={"column of a frame, 50 m/s": (CASE,)},
    gates=gates,
    figures=figures,
    quick_models=(REFERENCE, RIGID, LINEAR, FLEXIBLE, PUBLISHED),
    notes=(
        "The hit is placed 0.8 m above the base of the middle column: of all columns and heights "
        "drawn in the thesis only this one gives the published curve.",
        "No number is printed in figure 5.14; 0.48 m is the middle of its inset and 0.02 m its "
        "half-width.",
        "The loss at the first impact depends on the model: rigid bars move with the striker at "
        "once and lose a fifth of its energy in the first step, a fine mesh loses it later, in "
        "travelling hinges. Early velocities differ for that reason; peaks do not.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
