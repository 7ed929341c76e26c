"""How good is the reference? Refinement of the beam of record, other formulations beside it.

The columns of P. Heng's thesis (KTH 2017, figures 5.4, 5.8 and 5.9): the beam of record, an
independent beam, and models in which webs yield in shear, each with coarser meshes behind it.
"""

import sys

from workbench.base.datafiles import data_directory
from workbench.cli import main
from workbench.models.four_dof import FourDof
from workbench.models.published import Published
from workbench.models.references.fiber_beams import FiberCorotational, FiberReissner, FiberShear
from workbench.models.references.solid import SolidPlaneStress
from workbench.scenarios import ColumnPushover, load_scenario
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

published = data_directory() / "published"
eccentric = load_scenario(published / "heng2017_impact_column.toml")
clamped = load_scenario(published / "heng2017_clamped_column.toml")

OWN_BOUND = "Bound set by this study, not by a standard."
REFERENCE, COROTATIONAL = "Reissner beam", "co-rotational beam"
SHEAR, SOLID = "shear-yielding beam", "plane-stress solid"
TL_BEAM = "Heng 2017: TL beam"
FOUR_DOF = "4-DOF"

models = {
    REFERENCE: FiberReissner(layers=40),
    COROTATIONAL: FiberCorotational(),
    SHEAR: FiberShear(smallest_element=0.1, refinement=2),
    SOLID: SolidPlaneStress(refinement=1),
    FOUR_DOF: FourDof(),
    TL_BEAM: Published("heng2017-figure-5-4", "TL beam model"),
}
SHEAR_FREE = (REFERENCE, COROTATIONAL, FOUR_DOF)
IMPACTS = ("10 m/s", "15 m/s", "20 m/s")
CLAMPED, PUSH, SHORT_PUSH = "clamped, 25 m/s", "push to 0.7 m", "push to 0.2 m"

cases = (
    *(
        Case(name, eccentric.at_velocity(velocity), models=(*SHEAR_FREE, SHEAR), quick=quick)
        for name, velocity, quick in zip(IMPACTS[:2], (10.0, 15.0), (False, True), strict=True)
    ),
    Case(IMPACTS[2], eccentric.at_velocity(20.0), models=SHEAR_FREE, quick=False),
    Case(CLAMPED, clamped, models=(*SHEAR_FREE, TL_BEAM), quick=False),
    Case(PUSH, ColumnPushover(PUSH, eccentric.column, 0.7), models=SHEAR_FREE, quick=False),
    Case(
        SHORT_PUSH,
        ColumnPushover(SHORT_PUSH, eccentric.column, 0.2),
        models=(*SHEAR_FREE, SHEAR, SOLID),
    ),
)


def gate(model: str, against: str, quantity: str, bound: float, why: str, *names: str) -> Gate:
    """A bound on a relative error, numerical uncertainty of both sides included."""
    return Gate(model, against, quantity, "relative_error", bound, why, OWN_BOUND, names)


def known(model: str, quantity: str, *names: str) -> Gate:
    """A bound on the numerical uncertainty of a model."""
    why = "A reference is fine when its grid convergence index, all directions included, is so."
    return Gate(model, model, quantity, "relative_uncertainty", 0.015, why, OWN_BOUND, names)


AGREEMENT = (
    "Two formulations that share no element are to agree within their combined numerical "
    "uncertainty; 5 % bounds difference and uncertainty together."
)
gates = (
    known(REFERENCE, "peak_displacement", *IMPACTS, CLAMPED),
    known(REFERENCE, "input_energy", PUSH, SHORT_PUSH),
    gate(COROTATIONAL, REFERENCE, "peak_displacement", 0.05, AGREEMENT, *IMPACTS, CLAMPED),
    gate(COROTATIONAL, REFERENCE, "input_energy", 0.05, AGREEMENT, PUSH),
    gate(
        *(SOLID, SHEAR, "input_energy", 0.10),
        "Work of the push on the plateau of a yielding web: beam and continuum share only the "
        "yield criterion.",
        SHORT_PUSH,
    ),
    gate(
        *(REFERENCE, TL_BEAM, "peak_displacement", 0.05),
        "The published reference, a total-Lagrangian beam, for the same column.",
        CLAMPED,
    ),
)

figures = (
    Figure(
        "convergence",
        "convergence",
        "Convergence under impact",
        "Peak displacement over the size of elements and steps, with the extrapolated value.",
        options={"cases": (*IMPACTS, CLAMPED)},
    ),
    Figure(
        "convergence-static",
        "convergence",
        "Convergence of the static resistance",
        "Work of the push over the size of elements and steps.",
        options={"cases": (PUSH, SHORT_PUSH), "quantity": "input_energy"},
    ),
    Figure(
        "static",
        "force-displacement",
        "Static resistance (thesis figure 5.8)",
        "Shear-free models: two fiber beams and the four-DOF column.",
        SHEAR_FREE,
        {"cases": (PUSH,)},
    ),
    Figure(
        "shear",
        "force-displacement",
        "Where the web yields in shear",
        "The bending mechanism needs 1.8 times the plastic shear resistance of the segment below "
        "the impact point: beam and solid with shear yielding stop at 0.5 MN.",
        (REFERENCE, SHEAR, SOLID),
        {"cases": (SHORT_PUSH,)},
    ),
    Figure(
        "histories",
        "history",
        "Impact histories",
        "The two shear-free beams and the shear-yielding one.",
        (REFERENCE, COROTATIONAL, SHEAR, FOUR_DOF),
        {"cases": (*IMPACTS, CLAMPED)},
    ),
    Figure("cost", "cost", "Cost against error", "Wall time of one answer, all its runs included."),
)

study = Study(
    name="reference_convergence",
    title="How good is the reference?",
    question=(
        "By how much can the fiber beam of record be wrong numerically, does an independent "
        "formulation agree within that, and where does shear yielding end its domain?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=("peak_displacement", "time_of_peak", "residual_displacement", "input_energy"),
    gates=gates,
    figures=figures,
    quick_models=(REFERENCE, FOUR_DOF),
    notes=(
        "The order is one because plasticity is sampled half an element inside the member: the "
        "lever arm of a hinge is wrong by a length proportional to the element. Resistance "
        "converges from above, peaks from below.",
        "Beams and solid carry a numerical uncertainty of their own: meshes and steps doubled "
        "together, more fibers and half the steps alone, combined as a sum.",
        "Perfect plasticity localises: forces and displacements converge, strains in a hinge do "
        "not. Statements of a sequence that does not converge stand among the warnings.",
        "The solid converges where shear governs and drifts where bending does; its two levels "
        "carry a safety factor of 3.",
        "All shear-free models are outside their domain in the 0.8 m segment and are compared "
        "with each other, not with a real column.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
