"""Portal frames pushed sideways: second-order effect, N-M interaction, semi-rigid joints.

Questions of Heng 2017, paper III, on a frame of this workbench: HEB 220 columns of 4 m, an IPE 300
beam of 8 m and dead loads on both column heads.
"""

import sys

from workbench.cli import main
from workbench.models.references.fiber_beams import FiberReissner
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import Frame, FrameStatic, Joint, Load, Member, Node
from workbench.steel.materials import Steel
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

HEIGHT, SPAN, PUSH = 4.0, 8.0, 0.3  # m
COLUMN, BEAM, STEEL = find("HEB 220"), find("IPE 300"), Steel()
SQUASH = COLUMN.squash_load(STEEL)
BENDING = STEEL.elastic_modulus * BEAM.second_moment / SPAN
STRENGTH = BEAM.plastic_moment(STEEL)
SEMI_RIGID = Joint("semi-rigid", rotational_stiffness=5.0 * BENDING, plastic_moment=0.5 * STRENGTH)


def portal(name: str, axial: float, joint: str) -> FrameStatic:
    """The portal with a share `axial` of the squash load on each column, pushed at its corner."""
    load = axial * SQUASH
    nodes = (
        Node("base left", 0.0, 0.0, support="clamped"),
        Node("corner left", 0.0, HEIGHT),
        Node("corner right", SPAN, HEIGHT),
        Node("base right", SPAN, 0.0, support="clamped"),
    )
    members = (
        Member("column left", "base left", "corner left", COLUMN),
        Member("beam", "corner left", "corner right", BEAM, joint_start=joint, joint_end=joint),
        Member("column right", "base right", "corner right", COLUMN),
    )
    dead = (Load("corner left", y=-load), Load("corner right", y=-load)) if load else ()
    joints = (SEMI_RIGID,) if joint == SEMI_RIGID.name else ()
    frame = Frame(nodes, members, loads=dead, joints=joints)
    push = (Load("corner left", x=1e3),)
    return FrameStatic(name, frame, push, "corner left", "x", (PUSH,))


OWN_BOUND = "Bound set by this study, not by a standard."
REFERENCE = "fiber frame"
FLEXIBLE, RIGID, ALONE = "flexible", "rigid", "flexible, no interaction (20 / 20)"
FIRST_ORDER = "flexible, first order"
STIFF, LIGHT, HEAVY = "rigid joints", "rigid joints, 0.1 Np", "rigid joints, 0.3 Np"
SOFT, PINNED = "semi-rigid joints, 0.1 Np", "pinned joints, 0.1 Np"

models = {
    REFERENCE: FiberReissner(),
    FLEXIBLE: FlexibleSuperelement(shear="none"),
    RIGID: RigidSuperelement(shear="none"),
    ALONE: FlexibleSuperelement(alpha=20.0, beta=20.0, shear="none"),
    FIRST_ORDER: FlexibleSuperelement(geometry="linear", shear="none"),
}
cases = tuple(
    Case(name, portal(name, axial, joint))
    for name, axial, joint in (
        (STIFF, 0.0, "rigid"),
        (LIGHT, 0.1, "rigid"),
        (HEAVY, 0.3, "rigid"),
        (SOFT, 0.1, SEMI_RIGID.name),
        (PINNED, 0.1, "pinned"),
    )
)
gates = tuple(
    Gate(
        model,
        REFERENCE,
        quantity,
        "relative_error",
        0.05,
        "Resistance and work of the push within this bound of distributed plasticity.",
        OWN_BOUND,
    )
    for model in (FLEXIBLE, RIGID)
    for quantity in ("resistance", "input_energy")
)
figures = (
    Figure(
        "frame",
        "structure",
        "The frame",
        "Columns HEB 220, beam IPE 300; dead loads on the column heads.",
        options={"case": SOFT},
    ),
    Figure(
        "second-order",
        "force-displacement",
        "Second-order effect",
        "Dead loads tilt with the frame: the resistance falls after the mechanism has formed. "
        "A first-order analysis does not see it.",
        (REFERENCE, FLEXIBLE, FIRST_ORDER),
        {"cases": (STIFF, LIGHT, HEAVY)},
    ),
    Figure(
        "interaction-effect",
        "force-displacement",
        "Interaction of axial force and moment",
        "Small for light columns, large for heavily loaded ones.",
        (REFERENCE, FLEXIBLE, ALONE),
        {"cases": (LIGHT, HEAVY)},
    ),
    Figure(
        "joints",
        "force-displacement",
        "Joints between beam and columns",
        "Semi-rigid: 5 EI/L of the beam and half its plastic moment.",
        (REFERENCE, FLEXIBLE, RIGID),
        {"cases": (LIGHT, SOFT, PINNED)},
    ),
    Figure(
        "hinges",
        "interaction",
        "Path of axial force and moment",
        "Feet of the columns and ends of the beam under the heavier dead loads. Sway loads one "
        "column and unloads the other; the surface takes moment from both.",
        (FLEXIBLE, ALONE),
        {
            "case": HEAVY,
            "hinges": ("column left:start", "column right:start", "beam:start", "beam:end"),
        },
    ),
    Figure(
        "deformed",
        "deformed",
        "Deformed frame",
        "Shape and state of the hinges at the end of the push.",
        (REFERENCE, FLEXIBLE),
        {"cases": (LIGHT,)},
    ),
    Figure("cost", "cost", "Cost against error", "Wall time of one run against its error."),
)

study = Study(
    name="portal_frames",
    title="Portal frames: second-order effect, N-M interaction and semi-rigid joints",
    question=(
        "How well does one superelement per member give resistance and ductile work of a portal "
        "frame, and which of geometry, axial force and joints matters?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    groups={"rigid joints": (STIFF, LIGHT, HEAVY), "semi-rigid": (SOFT,), "pinned": (PINNED,)},
    decisive="second-order",
    quantities=("resistance", "input_energy", "largest_plastic_rotation", "largest_compression"),
    gates=gates,
    figures=figures,
    quick_models=(REFERENCE, FLEXIBLE, RIGID),
    notes=(
        "The frame is one of this workbench: the printed summary of the thesis gives no numbers "
        "for its portal frames.",
        "A box-shaped surface (20 / 20) stands for hinges without interaction of axial force and "
        "moment.",
        "0.1 Np: each column carries a tenth of its squash load as dead load.",
        "A rigid bar between two springs is exact in sway. A column under a beam on pinned joints "
        "is a cantilever: its spring at the foot is half as stiff.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
