"""How well column models predict impacts on steel columns and beams that were measured.

All impact tests of the data catalogue, those that `workbench data add` has brought in, against each
column model: bias, scatter and coverage over tests. No measured impact with all inputs could be
found under an open licence; until the catalogue holds one, SYNTHETIC rows show the form, and no
model is judged by them.
"""

import sys

from workbench.cli import main
from workbench.extras.intake.impact_tests import impact_tests
from workbench.extras.intake.impact_tests.measured import Measured
from workbench.extras.intake.impact_tests.propagated import over_inputs
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.single_dof import SingleDof
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

everything = impact_tests()
tests = [test for test in everything if not test.synthetic] or list(everything)
MADE = any(test.synthetic for test in tests)
TESTS = "SYNTHETIC rows" if MADE else "tests"
WEB, BEAM = "web-yielding beam", "fiber beam"
PANELS, FOUR_DOF, ENERGY = "4-DOF with panels", "4-DOF", "energy estimate"
SDOF, RIGID = "SDOF analytic", "rigid bars with panels"
answering = {
    WEB: FiberShear(levels=2),
    BEAM: FiberReissner(levels=2),
    PANELS: FourDofShear(),
    FOUR_DOF: FourDof(),
    RIGID: RigidSuperelement(),
    "flexible bars with panels": FlexibleSuperelement(),
    SDOF: SingleDof(),
    "SDOF with panels": SingleDof(resistance="panel", hit_mass="waves"),
    ENERGY: EnergyEstimate(),
    "energy with panels": EnergyEstimate(resistance="panel", hit_mass="waves"),
}
models = {TESTS: Measured(), **over_inputs(answering)}
SHOWN = (WEB, BEAM, PANELS, FOUR_DOF, SDOF, ENERGY)
QUICK = 2  # tests of each campaign in the quick form

campaigns: dict[str, list[str]] = {}
for test in tests:
    campaigns.setdefault(test.campaign, []).append(test.name)
cases = tuple(
    Case(test.name, test.scenario, quick=test.name in campaigns[test.campaign][:QUICK])
    for test in tests
)

WHY = (
    "A peak is to be predicted within 15 %, about what the input of a test leaves open: the rate "
    "of loading, the supports, the yield stress along the member."
)
gates = tuple(
    Gate(model, TESTS, "peak_displacement", "relative_error", 0.15, WHY, "Bound set by this study.")
    for model in (WEB, BEAM, PANELS, FOUR_DOF, ENERGY)
)

CAPTION = (
    "Measured up, predicted across, with the half-widths of both (predicted: numerical, and inputs "
    "that a test leaves open): below the line a model predicts too much. Dotted: 20 % off."
)
MADE_OF = (
    (f"The SYNTHETIC rows are answers of {WEB} with noise: that it agrees with them is built in.",)
    if MADE
    else ()
)
figures = (
    Figure("tests", "tests", "Measured against predicted peaks", CAPTION, SHOWN),
    Figure(
        *("residuals", "tests", "Measured against predicted permanent displacements", CAPTION),
        *(SHOWN, {"quantity": "residual_displacement"}),
    ),
)

study = Study(
    name="impact_tests",
    title="Impacts on steel columns and beams: tests against models",
    question=(
        "How well do column models predict the largest and the permanent displacement of members "
        "that were struck in a laboratory, and do their stated intervals hold the tests?"
    ),
    cases=cases,
    models=models,
    reference=TESTS,
    groups={campaign: tuple(names) for campaign, names in campaigns.items()},
    quantities=("peak_displacement", "residual_displacement"),
    gates=gates,
    figures=figures,
    decisive="tests",
    quick_models=(TESTS, WEB, PANELS, FOUR_DOF, ENERGY),
    notes=(
        "Models take the measured static yield stress; none knows strain rate, local buckling or a "
        "soft striker. Bias over real tests holds what they leave out.",
        "Tests of one scenario count as one, with their mean.",
        *MADE_OF,
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
