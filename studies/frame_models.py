"""Which frame model for what: an element per member (struck ones more), against fiber frames.

Three frames (a portal, two bays in two storeys, the frame of Heng 2017), each pushed over, led to
and fro, hit, and shaken.
"""

import sys
from dataclasses import replace

import numpy as np

from workbench.cli import main
from workbench.extras.frame_models.fiber_frames import (
    BoundingSurface,
    FiberHinge,
    ForceBasedBeam,
    ModifiedTangentModulus,
)
from workbench.extras.frame_models.hinged_frames import (
    Giberson,
    PlasticHinge,
    QuasiPlasticHinge,
    RefinedPlasticHinge,
)
from workbench.models.references.fiber_beams import FiberCorotational, FiberReissner, FiberShear
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import (
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameScenario,
    FrameStatic,
    FrameStriker,
    Load,
    Node,
    cyclic_path,
    regular_frame,
)
from workbench.steel.sections import find, square
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

COLUMN, BEAM = find("HEB 220"), find("IPE 300")
PORTAL, STOREYS, THESIS = "portal", "two storeys", "thesis frame"
PUSH, CYCLES, HIT, SHAKEN = "pushed over", "to and fro", "hit", "shaken"
DEAD = 3e5  # N on every column head of the first two frames
MASS = 1.5e4  # kg with it


def loaded(frame: Frame, load: float, mass: float) -> Frame:
    """The frame with a dead load (N) and a mass (kg) at every joint above the ground."""

    def heavy(node: Node) -> Node:
        return replace(node, mass=mass) if node.y > 0.0 else node

    loads = tuple(Load(node.name, y=-load) for node in frame.nodes if node.y > 0.0)
    return replace(frame, nodes=tuple(map(heavy, frame.nodes)), loads=loads if load else ())


SQUARE = square(0.2)
FRAMES = {
    PORTAL: loaded(regular_frame((6.0,), (4.0,), COLUMN, BEAM), DEAD, MASS),
    STOREYS: loaded(regular_frame((6.0, 6.0), (4.0, 3.5), COLUMN, BEAM), 0.5 * DEAD, MASS),
    THESIS: regular_frame((3.0,) * 4, (4.0, 4.0), SQUARE, SQUARE),
}
TOP = {PORTAL: "A1", STOREYS: "A2", THESIS: "A2"}
DRIFT = {PORTAL: 0.16, STOREYS: 0.3, THESIS: 0.32}  # m: 4 %
STRUCK = {  # member, height above its foot (m), mass (kg), velocity (m/s), record (s)
    PORTAL: ("A0-A1", 2.0, 1500.0, 12.0, 0.2),
    STOREYS: ("B0-B1", 2.0, 1500.0, 12.0, 0.2),
    THESIS: ("C0-C1", 0.8, 1500.0, 50.0, 0.06),
}
SWING = {PORTAL: 7.0, STOREYS: 5.0, THESIS: 12.0}  # m/s2, amplitude of the ground
PERIOD, STEP, LASTS = 0.6, 0.01, 2.4  # s


def scenario(place: str, event: str) -> FrameScenario:
    """What happens to a frame."""
    frame, top, drift = FRAMES[place], TOP[place], DRIFT[place]
    name = f"{place}, {event}"
    levels = [node for node in frame.nodes if node.name.startswith("A") and node.y > 0.0]
    pattern = tuple(Load(node.name, x=1e3 * node.y) for node in levels)
    if event == PUSH:
        return FrameStatic(name, frame, pattern, top, "x", (drift,))
    if event == CYCLES:
        path = cyclic_path((0.4 * drift, 0.8 * drift))
        return FrameStatic(name, frame, pattern, top, "x", path)
    if event == HIT:
        member, at, mass, velocity, lasts = STRUCK[place]
        struck = FrameStriker(mass, velocity, node="hit")
        return FrameImpact(name, frame.split(member, at, "hit"), struck, lasts)
    times = np.arange(0.0, LASTS, STEP)
    wave = SWING[place] * np.sin(2.0 * np.pi * times / PERIOD) * np.sin(np.pi * times / LASTS)
    frame = loaded(frame, 0.0, 3e4) if place == THESIS else frame
    return FrameGroundMotion(name, frame, tuple(wave), STEP, top, "x", LASTS + PERIOD)


REFERENCE, WEB = "fiber frame", "web-yielding frame"
RIGID, FLEXIBLE = "rigid superelement", "flexible superelement"
GIBERSON, HINGE, AISC = "Giberson", "plastic hinge, exact", "plastic hinge, AISC"
QUASI, REFINED, FORCE, FIBER = (
    "quasi-plastic hinge",
    "refined hinge, AISC",
    "force-based fibers",
    "fiber hinge",
)
BOUNDING, TANGENT = "bounding surface", "modified tangent modulus"
CUBIC = "displacement-based fibers, 4 per member"
models = {
    WEB: FiberShear(),
    REFERENCE: FiberReissner(),
    GIBERSON: Giberson(),
    HINGE: PlasticHinge(),
    AISC: PlasticHinge(surface="aisc"),
    QUASI: QuasiPlasticHinge(),
    REFINED: RefinedPlasticHinge(),
    RIGID: RigidSuperelement(shear="none"),
    FLEXIBLE: FlexibleSuperelement(shear="none"),
    FIBER: FiberHinge(),
    FORCE: ForceBasedBeam(),
    BOUNDING: BoundingSurface(),
    TANGENT: ModifiedTangentModulus(),
    CUBIC: FiberCorotational(
        element="lobatto", smallest_element=1.0, largest_element=1.0, refinement=0, levels=1
    ),
}
EVENTS = (PUSH, CYCLES, HIT, SHAKEN)
cases = tuple(
    Case(
        f"{place}, {event}",
        scenario(place, event),
        models=tuple(label for label in models if label != WEB or event == HIT),
        figure=event,
        quick=place == PORTAL,
    )
    for place in FRAMES
    for event in EVENTS
)


def of(event: str) -> tuple[str, ...]:
    """Names of the cases with an event."""
    return tuple(case.name for case in cases if case.name.endswith(event))


BOUND = "Bound set by this study, not by a standard."
QUANTITY = {
    PUSH: "resistance",
    CYCLES: "input_energy",
    HIT: "peak_displacement",
    SHAKEN: "peak_displacement",
}
gates = tuple(
    Gate(
        *(label, REFERENCE, QUANTITY[event], "relative_error", 0.05),
        f"Frames that are {event}: within this bound of distributed plasticity.",
        BOUND,
        cases=of(event),
    )
    for label in (HINGE, FORCE, BOUNDING, FLEXIBLE)
    for event in EVENTS
)
ALL = tuple(models)
figures = (
    Figure(
        "push",
        "force-displacement",
        "Push-over",
        "Loads in proportion to the height; dead loads tilt with the frame.",
        ALL,
        {"cases": of(PUSH)},
    ),
    Figure(
        "cycles",
        "force-displacement",
        "To and fro",
        "Two swings of growing amplitude.",
        (REFERENCE, HINGE, REFINED, FORCE, BOUNDING),
        {"cases": of(CYCLES)},
    ),
    Figure(
        "hit",
        "history",
        "Hit",
        "Displacement of the impact point. Models whose axial force never yields, or yields "
        "without elongation, part from the others in catenary action.",
        ALL,
        {"cases": of(HIT)},
    ),
    Figure(
        "shaken",
        "history",
        "Shaken",
        "Displacement of the top relative to the ground.",
        (REFERENCE, GIBERSON, HINGE, REFINED, FORCE),
        {"cases": of(SHAKEN)},
    ),
    Figure("cost", "cost", "Cost against error", "Wall time of one run against its error."),
    Figure(
        "rules",
        "yield-surfaces",
        "Rules of interaction",
        "What stands for the exact plastic section, and how far its radius is off.",
        options={"cases": of(PUSH)[1:]},
    ),
    Figure(
        "frame",
        "structure",
        "The frame in two storeys",
        "HEB 220 and IPE 300, dead loads and masses on every joint.",
        options={"case": f"{STOREYS}, {HIT}"},
    ),
)

study = Study(
    name="frame_models",
    title="Which frame model: hinges, fiber hinges, fibers",
    question=(
        "Which of the frame models of practice should answer a push-over, cycles, an impact or an "
        "earthquake, what error is to be expected, and what does it cost?"
    ),
    cases=cases,
    models=models,
    reference=REFERENCE,
    references=(WEB, REFERENCE),
    groups={event: of(event) for event in EVENTS},
    quantities=("resistance", "input_energy", "peak_displacement", "residual_displacement"),
    gates=gates,
    figures=figures,
    decisive="push",
    quick_models=(WEB, REFERENCE, GIBERSON, HINGE, REFINED, FLEXIBLE, FIBER, FORCE),
    notes=(
        "No model here yields in shear: the gates ask what lumping bending and axial plasticity "
        "costs. The web-yielding frame, with which hits are compared on the first page, does.",
        f"Ground: a sine of {PERIOD:g} s that swells and fades within {LASTS:g} s, strong enough "
        "to make every frame yield; it stands for no earthquake.",
        f"Dead loads: {DEAD / 1e3:g} kN on each column of the portal, half of it on every joint of "
        "the two storeys, none on the frame of the "
        "thesis, which gets 30 t on every joint where it is shaken.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
