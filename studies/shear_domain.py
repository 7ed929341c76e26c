"""Where models without shear yielding end: static resistance against V/Vpl.

Columns of 6 m hit at various distances from their clamped base, pushed by a twentieth of the
shorter segment: shear-yielding beam and plane-stress solid over the shear-free beam.
"""

import sys

from workbench.cli import main
from workbench.models.four_dof import FourDofShear
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.references.solid import SolidPlaneStress
from workbench.scenarios import Column, ColumnPushover
from workbench.steel.sections import Section, find, square
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

LENGTH = 6.0  # m
PUSH = 0.05  # of the shorter segment: the same rotation everywhere, the mechanism has formed
SECTIONS = {"HEB 220": find("HEB 220"), "IPE 300": find("IPE 300"), "square 200": square(0.2)}
WEBBED = ("HEB 220", "IPE 300")
POSITIONS = {  # m; V/Vpl of the bending mechanism is 0.5 to 2.4, 0.5 to 2 and 0.1 to 1.2
    "HEB 220": (0.6, 0.8, 1.0, 1.2, 1.4, 1.7, 2.1, 2.8),
    "IPE 300": (0.5, 0.65, 0.8, 1.0, 1.2, 1.4, 1.7, 2.1),
    "square 200": (0.15, 0.2, 0.25, 0.3, 0.4, 0.6, 1.0, 2.0),
}
REFERENCE = "shear-free beam"
YIELDING = ("shear-yielding beam", "plane-stress solid")
PANELS = "4-DOF with panels"  # of sections with webs

HARDENING = 1e-5  # over E: carries a mechanism without restraint along, below 0.3 % of the force

models = {
    REFERENCE: FiberReissner(hardening_ratio=HARDENING),
    YIELDING[0]: FiberShear(hardening_ratio=HARDENING),
    YIELDING[1]: SolidPlaneStress(hardening_ratio=HARDENING),
    PANELS: FourDofShear(),
}


def push(name: str, section: Section, below: float) -> ColumnPushover:
    """A column without axial load or restraint: bending and shear alone."""
    column = Column(section, below, LENGTH - below, fillets=False)
    return ColumnPushover(f"{name}, hit at {below:g} m", column, PUSH * below)


cases = tuple(
    Case(
        (scenario := push(name, section, below)).name,
        scenario,
        figure="domain",
        models=(REFERENCE, *YIELDING, *((PANELS,) if name in WEBBED else ())),
        parameters={"section": name, "length below in m": below},
        quick=below in POSITIONS[name][1::3],
    )
    for name, section in SECTIONS.items()
    for below in POSITIONS[name]
)

gates = (
    Gate(
        YIELDING[0],
        REFERENCE,
        "input_energy",
        "relative_error",
        0.05,
        "Without shear yielding a model is to be off by less than 5 %; the cases that fail mark "
        "the end of its domain and are the answer of this study, not a defect.",
        "Bound set by this study, not by a standard.",
    ),
)

figures = (
    Figure(
        "surfaces",
        "shear-surfaces",
        "What shear leaves of the plastic moment",
        "Without axial force. Panels take a uniform shear stress in the web, a lower bound; the "
        "rule of EN 1993-1-1 is not convex at half of the shear resistance, and the additive form "
        "forgets the flanges.",
    ),
    Figure(
        "domain",
        "shear-domain",
        "End of the shear-free domain",
        "Force at a push of a twentieth of the shorter segment, over that of the shear-free beam, "
        "against the shear force that the latter reaches. Grey: within 5 %.",
        (REFERENCE, *YIELDING, PANELS),
        {"group": "section"},
    ),
    Figure(
        "curves",
        "force-displacement",
        "Force against displacement",
        "The bending mechanism is cut off by the plastic shear resistance where V/Vpl passes one.",
        (REFERENCE, *YIELDING),
        {"cases": tuple(case.name for case in cases if case.quick)},
    ),
)

study = Study(
    name="shear_domain",
    title="Where models without shear yielding end",
    question=(
        "Up to which shear force, over the plastic shear resistance, does a model without shear "
        "yielding give the static resistance of a column within 5 %?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=("input_energy",),
    gates=gates,
    figures=figures,
    notes=(
        "Shear yielding in the beam acts in the web between the flanges, elastic shear strain "
        "included; the solid also has transverse stress at the held sections and in the kinks, "
        "which stiffens the shortest segments and makes slender ones depend on the mesh.",
        "Models without shear yielding warn above the V/Vpl at which it takes 5 % of the "
        "resistance: from the share of the webs in the plastic modulus after EN 1993-1-1, 6.2.8, "
        "for sections with webs, and 0.45 from this study for solid ones.",
        "Segments shorter than about two depths are no beams; they are shown because the solid "
        "answers there too.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
