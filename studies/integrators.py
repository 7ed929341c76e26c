"""Every integrator of impact on problems with known answers: which to trust for which."""

import sys

from workbench.cli import main
from workbench.extras.laboratory.models import ImpactExact, ImpactIntegrator, problem_of
from workbench.extras.laboratory.scenario import PROBLEMS, ImpactProblem
from workbench.extras.laboratory.schemes import CLASSICAL, ELASTIC, LAW, SCHEMES
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

EXACT = "exact"
QUICK = ("ball", "two-masses", "cradle", "oscillator", "grazing")
QUICK_LADDER = 6

cases = tuple(
    Case(name, ImpactProblem(problem_of(name).title, name), quick=name in QUICK)
    for name in PROBLEMS
)
models = {EXACT: ImpactExact(2 ** (QUICK_LADDER - 1))} | {
    name: ImpactIntegrator(name, QUICK_LADDER) for name in SCHEMES
}

CERTIFIED = (
    "Located events and fourth order between them leave less than a hundredth of a percent, "
    "through accumulating impacts too."
)
COMMITTED = "Plastic flow is committed step by step: first order, where impacts are located too."
STEPPED = "First order through impacts, at the finest step of the ladder."
TIGHT = "The second constraint closes every gap at the end of every step."
KEPT = "Discrete gradients and elastic impacts: energy is kept to round-off."
ONCE = "First order through elastic impacts, the only ones that the scheme knows."
SPRUNG = "The spring of the contact does the work that it stores: energy is kept to round-off."
SEEN = "No impact of a smooth answer is stepped over or invented."
IMPULSES = tuple(n for n, s in SCHEMES.items() if s.restitution == LAW and n != "event-driven")
REBOUND = tuple(n for n, s in SCHEMES.items() if s.restitution == ELASTIC)
PLASTIC = ("column", "frame")
ONE_BY_ONE = "ggl-studer", "cradle"  # a gap that is just closed is not seen: no impacts at once
HIT = tuple(name for name in PROBLEMS if name not in ("ball-elastic", "grazing"))


def gate(model: str, quantity: str, bound: float, why: str, *names: str) -> Gate:
    """A bound on how far an integrator is from the exact answer."""
    return Gate(
        model, EXACT, quantity, "difference", bound, why, "docs/theory/integrators.md", names
    )


gates = (
    gate(
        "event-driven",
        "relative_error",
        1e-4,
        CERTIFIED,
        *(n for n in PROBLEMS if n not in PLASTIC),
    ),
    gate("event-driven", "relative_error", 5e-3, COMMITTED, *PLASTIC),
    *(
        gate(name, "relative_error", 0.05, STEPPED, *(n for n in HIT if (name, n) != ONE_BY_ONE))
        for name in IMPULSES
    ),
    *(gate(name, "relative_error", 0.05, ONCE, "oscillator") for name in REBOUND),
    gate("ggl", "largest_penetration", 1e-10, TIGHT),
    gate("ggl-split", "largest_penetration", 1e-10, TIGHT),
    gate("midpoint", "energy_drift", 1e-9, KEPT, "ball-elastic", "cradle", "oscillator"),
    gate("newmark-penalty", "energy_drift", 1e-9, SPRUNG, "ball-elastic", "cradle", "oscillator"),
    gate("event-driven", "missed_impacts", 0.5, SEEN, "table", "two-masses", "oscillator"),
    gate("event-driven", "spurious_impacts", 0.5, SEEN, "table", "oscillator", "grazing"),
)

figures = (
    Figure(
        "precision",
        "work-precision",
        "Error against work",
        "Largest error of the places over the largest place, against the evaluations of the forces "
        "that a run takes; every line is a ladder of halved steps. Down and left is better.",
        tuple(SCHEMES),
        {"cases": PROBLEMS, "summary": True},
    ),
    Figure(
        "time",
        "work-precision",
        "Error against time",
        "The same against time in plain Python: the time of an evaluation in the finest run, with "
        "all that a step does beside it, times the evaluations of each run.",
        tuple(SCHEMES),
        {"cases": PROBLEMS, "time": True},
    ),
    Figure(
        "records",
        "place",
        "What the finest runs answer",
        "Place of the last unknown (of column and frame: the striker) in the finest runs, and the "
        "exact one. What leaves the axes is cut.",
        (*CLASSICAL, "moreau-jean", "midpoint", "event-driven"),
        {"cases": ("ball", "table", "bar", "column", "frame"), "summary": True},
    ),
)

study = Study(
    name="integrators",
    title="Time integrators of impact on problems with known answers",
    question=(
        "Which time integration scheme should one trust for which problem of impact, and what does "
        "an accurate answer cost?"
    ),
    cases=cases,
    models=models,
    reference=EXACT,
    quantities=("relative_error", "energy_drift", "largest_penetration"),
    gates=gates,
    figures=figures,
    notes=(
        "Newmark's rule with contact at the end position multiplies the energy of one impact by a "
        "number between 0 and 9 that depends on where in its step the body arrives, 3.37 in the "
        "mean (derived in `docs/theory/integrators.md`, measured by a test): repeated impacts blow "
        "up. HHT- and generalized-alpha damp what the grid puts in, and do not converge either. "
        "Restitution is unknown to all three. On the column of the thesis the striker bounces in "
        "every other step, and the peak is off by half and more at any step.",
        "Impulses between velocities (Moreau-Jean, the midpoint schemes, generalized-alpha with "
        "velocities updated at impact, central differences) misplace an impact by up to a step: "
        "first order, however smooth the motion between.",
        "`newmark-rates` and `newmark-penalty` (after Zolghadr Jahromi and Izzuddin) know elastic "
        "impacts alone: where restitution is below 1 they answer another problem. The contact of "
        "`ggl-studer` oscillates while it lasts, at amplitudes of the square of the step.",
        "Time is that of plain Python, of the finest run; compiled steppers of the models take the "
        "same steps (tests hold them to 1e-10).",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
