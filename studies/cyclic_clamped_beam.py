"""A clamped beam under cyclic load: pinching, cyclic softening and the roundness of the hinges.

After the example of Heng 2017, paper III: both ends are held against rotation and sliding, so that
catenary action builds up with the amplitude, and axial force and moment share the hinges. The
printed summary gives no numbers; the section and lengths are those of the thesis' clamped column.
Amplitudes reach a tenth of the span: at a fortieth axial forces stay too small to be seen.
"""

import sys

from workbench.cli import main
from workbench.models.references.fiber_beams import FiberReissner
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import Frame, FrameStatic, Load, Member, Node, cyclic_path
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

SECTION = find("HEB 220")
HALF = 2.0  # m
beam = Frame(
    nodes=(
        Node("left", 0.0, 0.0, support="clamped"),
        Node("middle", HALF, 0.0),
        Node("right", 2.0 * HALF, 0.0, support="clamped"),
    ),
    members=(
        Member("left half", "left", "middle", SECTION),
        Member("right half", "middle", "right", SECTION),
    ),
    fillets=False,
)


def cycles(name: str, path: tuple[float, ...]) -> FrameStatic:
    """The middle led through `path` (m), downwards positive."""
    return FrameStatic(name, beam, (Load("middle", y=-1e3),), "middle", "-y", path)


OWN_BOUND = "Bound set by this study, not by a standard."
REFERENCE = "fiber beam"
FITTED, LINEAR, ROUND = "flexible, fitted surface", "flexible, 1 / 1", "flexible, 2 / 2"
BOX, RIGID = "flexible, no interaction (20 / 20)", "rigid, fitted surface"
CONSTANT, INCREASING = "constant amplitude", "increasing amplitude"

models = {
    REFERENCE: FiberReissner(),
    FITTED: FlexibleSuperelement(shear="none"),
    LINEAR: FlexibleSuperelement(alpha=1.0, beta=1.0, shear="none"),
    ROUND: FlexibleSuperelement(alpha=2.0, beta=2.0, shear="none"),
    BOX: FlexibleSuperelement(alpha=20.0, beta=20.0, shear="none"),
    RIGID: RigidSuperelement(shear="none"),
}
cases = (
    Case(CONSTANT, cycles(CONSTANT, cyclic_path((0.3,), 3))),
    Case(INCREASING, cycles(INCREASING, cyclic_path((0.1, 0.2, 0.3, 0.4), 1))),
)
gates = (
    *(
        Gate(
            model,
            REFERENCE,
            "input_energy",
            "relative_error",
            0.10,
            "Work put into the beam, nearly all of it dissipated: what a cyclic model is for.",
            OWN_BOUND,
        )
        for model in (FITTED, RIGID)
    ),
    Gate(
        FITTED,
        REFERENCE,
        "resistance",
        "relative_error",
        0.10,
        "Largest force on the beam, reached in the first cycle of the largest amplitude.",
        OWN_BOUND,
    ),
)
figures = (
    Figure(
        "beam",
        "structure",
        "The beam",
        "HEB 220, clamped at both ends and held against sliding, led up and down at mid-span.",
        options={"case": CONSTANT},
    ),
    Figure(
        "constant",
        "force-displacement",
        "Cycles of constant amplitude",
        "Catenary tension adds to the force towards each reversal. On the way back the stretched "
        "beam is too long for its span: tension goes, compression comes, and near the straight "
        "position only the bending mechanism is left (pinching). Later loops repeat the first.",
        (REFERENCE, FITTED),
        {"cases": (CONSTANT,)},
    ),
    Figure(
        "increasing",
        "force-displacement",
        "Cycles of increasing amplitude",
        "Catenary action grows with the amplitude; the waist of the loops stays the same.",
        (REFERENCE, FITTED),
        {"cases": (INCREASING,)},
    ),
    Figure(
        "roundness",
        "force-displacement",
        "Roundness of the yield surface",
        "Exponents of moment and axial force: the rounder the surface, the larger the force. "
        "Without interaction the catenary force comes on top of the full moment, and the second "
        "loop is softer than the first: compression of the stretched beam takes what tension gave.",
        (LINEAR, FITTED, ROUND, BOX),
        {"cases": (CONSTANT,)},
    ),
    Figure(
        "deformed",
        "deformed",
        "Deformed beam",
        "Shape and state of the hinges: on the way out, on the way to the other side, at the end.",
        (REFERENCE, FITTED),
        {"cases": (CONSTANT,), "instants": (320.0, 960.0, "end")},
    ),
    Figure(
        "interaction",
        "interaction",
        "Path of axial force and moment",
        "The hinges run along the yield surface of their member: from bending into tension, and "
        "through compression back to bending.",
        (FITTED, ROUND),
        {"case": CONSTANT, "hinges": ("left half:start", "left half:end")},
    ),
    Figure("cost", "cost", "Cost against error", "Wall time of one run against its error."),
)

study = Study(
    name="cyclic_clamped_beam",
    title="Clamped beam under cyclic load with catenary action",
    question=(
        "Do superelements with generalized hinges follow pinching, cyclic softening and energy "
        "dissipation of a clamped beam, and what does the roundness of the yield surface do?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=("input_energy", "resistance"),
    gates=gates,
    figures=figures,
    quick_models=(REFERENCE, FITTED, RIGID),
    notes=(
        "Elastic-perfectly plastic steel without Bauschinger effect, local buckling or fracture: "
        "softening here is geometry and axial force, not damage. With hinges that share axial "
        "force and moment there is next to none: loops of one amplitude lie on each other.",
        "No published numbers exist for this example in the printed summary; the fiber beam is "
        "the only measure.",
        "A box-shaped surface (20 / 20) stands for hinges without interaction of axial force and "
        "moment.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
