"""Distributed plasticity: which fiber element, how many per member, and at what cost.

Heng 2017, section 2.1, tells three formulations apart: displacements interpolated, forces
interpolated, and mixed ones. Here are the element of cubic displacements with Gauss and with
Lobatto points, the one of a single axial force (the axial force is interpolated, the deflection
stays cubic: mixed), and the force-based one, each with 1 to 16 elements per member.
"""

import sys
from dataclasses import replace

from workbench.cli import main
from workbench.extras.frame_models.fiber_frames import ForceBasedBeam
from workbench.models.base import Model
from workbench.models.references.fiber_beams import FiberCorotational, FiberReissner
from workbench.scenarios import (
    Frame,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    FrameStriker,
    Load,
    Member,
    Node,
    cyclic_path,
    regular_frame,
)
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study

COLUMN, BEAM = find("HEB 220"), find("IPE 300")
HEIGHT = 4.0  # m, of all members: one element is as long in all of them
DEAD, MASS = 3e5, 1.5e4  # N and kg on every head
PUSHED, CATENARY, CYCLES, HIT = (
    "cantilever pushed",
    "clamped beam, catenary",
    "portal to and fro",
    "portal hit",
)
HARDENING = 0.01  # of the elastic modulus: moments rise along a hinge, which gives it a length
REFERENCE = "exact fiber beam"
COUNTS = {"force-based": (1, 2, 4), "cubic": (2, 4, 8, 16)}  # elements per member


def cantilever() -> FrameStatic:
    """A cantilever under a dead load on its head, pushed to a drift of 10 %."""
    nodes = (Node("foot", 0.0, 0.0, support="clamped"), Node("head", 0.0, HEIGHT))
    frame = Frame(
        nodes, (Member("column", "foot", "head", COLUMN),), loads=(Load("head", y=-DEAD),)
    )
    return FrameStatic(PUSHED, frame, (Load("head", x=1e3),), "head", "x", (0.1 * HEIGHT,))


def clamped_beam() -> FrameStatic:
    """A beam clamped at both ends, its middle led down until it hangs like a cable."""
    places = (
        ("left", 0.0, "clamped"),
        ("middle", HEIGHT, "free"),
        ("right", 2 * HEIGHT, "clamped"),
    )
    nodes = tuple(Node(name, x, 0.0, support=support) for name, x, support in places)
    halves = (("left half", "left", "middle"), ("right half", "middle", "right"))
    frame = Frame(nodes, tuple(Member(*half, BEAM) for half in halves))
    return FrameStatic(CATENARY, frame, (Load("middle", y=-1e3),), "middle", "-y", (0.8,))


def portal() -> Frame:
    """A portal with dead loads and masses on both heads."""
    frame = regular_frame((HEIGHT,), (HEIGHT,), COLUMN, BEAM)
    nodes = tuple(replace(node, mass=MASS if node.y else 0.0) for node in frame.nodes)
    loads = tuple(Load(node.name, y=-DEAD) for node in nodes if node.y)
    return replace(frame, nodes=nodes, loads=loads)


def scenarios() -> dict[str, FrameScenario]:
    """The four cases."""
    path = cyclic_path((0.06, 0.12))
    struck = FrameStriker(1500.0, 12.0, node="hit")
    return {
        PUSHED: cantilever(),
        CATENARY: clamped_beam(),
        CYCLES: FrameStatic(CYCLES, portal(), (Load("A1", x=1e3),), "A1", "x", path),
        HIT: FrameImpact(HIT, portal().split("A0-A1", 0.5 * HEIGHT, "hit"), struck, 0.2),
    }


def cubic(element: str, count: int, layers: int = 20) -> FiberCorotational:
    """Elements of cubic deflection, so many per member."""
    size = HEIGHT / count
    return FiberCorotational(
        element=element,
        smallest_element=size,
        largest_element=size,
        refinement=0,
        levels=1,
        layers=layers,
        hardening_ratio=HARDENING,
    )


def force_based(count: int, points: int = 5, layers: int = 20) -> ForceBasedBeam:
    """Force-based elements, so many per member."""
    return ForceBasedBeam(elements=count, points=points, layers=layers, hardening_ratio=HARDENING)


NAMES = {"interpolated": "cubic, Gauss", "lobatto": "cubic, Lobatto", "balanced": "mixed"}
models: dict[str, Model] = {REFERENCE: FiberReissner(hardening_ratio=HARDENING)}
models |= {f"force-based, {count}": force_based(count) for count in COUNTS["force-based"]}
models |= {f"force-based, 2, {points} points": force_based(2, points) for points in (3, 9)}
models |= {
    f"{name}, {count}": cubic(element, count)
    for element, name in NAMES.items()
    for count in COUNTS["cubic"]
}
models |= {
    f"cubic, Gauss, 8, {layers} layers": cubic("interpolated", 8, layers) for layers in (6, 80)
}
cases = tuple(
    Case(name, scenario, figure="cycles" if name == CYCLES else "", quick=name in (PUSHED, HIT))
    for name, scenario in scenarios().items()
)
FAMILIES = ("force-based, 2", "cubic, Gauss, 4", "cubic, Lobatto, 4", "mixed, 4")
figures = (
    Figure(
        "cost",
        "cost",
        "Cost against error",
        "Wall time of one run against the error of the first quantity of the case that a model "
        "answers; the number is that of elements per member.",
        tuple(models),
    ),
    Figure(
        "pushed",
        "force-displacement",
        "Pushed, and hanging",
        "Few elements: too strong where displacements are interpolated.",
        (REFERENCE, *FAMILIES),
        {"cases": (PUSHED, CATENARY)},
    ),
    Figure(
        "cycles",
        "force-displacement",
        "To and fro",
        "Two swings of growing amplitude.",
        (REFERENCE, *FAMILIES),
        {"cases": (CYCLES,)},
    ),
    Figure(
        "hit",
        "history",
        "Hit",
        "Displacement of the impact point.",
        (REFERENCE, *FAMILIES),
        {"cases": (HIT,)},
    ),
)

study = Study(
    name="distributed_plasticity",
    title="Distributed plasticity: which element, how many",
    question=(
        "Force-based, displacement-based or mixed: how many fiber elements per member does each "
        "need to come within 1 and 5 % of a geometrically exact fiber beam, and at what cost?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    groups={"pushed": (PUSHED, CATENARY), "to and fro": (CYCLES,), "hit": (HIT,)},
    quantities=("resistance", "input_energy", "peak_displacement"),
    figures=figures,
    decisive="cost",
    quick_models=(REFERENCE, *FAMILIES),
    notes=(
        f"All elements harden by {HARDENING:g} E. Without hardening a force-based element has a "
        "hinge as long as the weight of its end point, whatever the member is, and forces alone "
        "can be compared.",
        "Shear strain stays elastic in all elements, although the webs of the struck column would "
        "yield: the study compares elements, not columns.",
        "In a plane, fibers are layers; 6, 20 and 80 of them are compared. Shell elements and "
        "frames in space, which section 2.1 names too, are outside the workbench.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
