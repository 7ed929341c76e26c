"""A column of a frame is gone: static push-down, the factor 2, and the sudden removal.

EN 1991-1-7, 3.3, asks what happens when a column is notionally removed. Two bays of 6 m, two
storeys of 3.5 m, columns HEB 200, beams IPE 300; the middle column of the ground floor is taken
away. Before, it carries R, here a force on the joint above it; suddenly it carries nothing.

`python studies/column_removal.py factors` prints the table of `docs/theory/frames.md`.
"""

import sys

import numpy as np

from workbench.cli import main
from workbench.extras.frame_models.hinged_frames import PlasticHinge
from workbench.models.references.fiber_beams import FiberReissner
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import Frame, FramePulse, FrameStatic, Load, Member, Node, Pulse
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

SPAN, HEIGHT, STOREYS, GRAVITY = 6.0, 3.5, 2, 9.81
COLUMN, BEAM = find("HEB 200"), find("IPE 300")
ABOVE, DOWN = "B1", "-y"  # joint above the column that is gone
FAR, DURATION = 0.6, 1.2  # m of the push-down, s of the record


def frame(mass: float) -> Frame:
    """The frame without the column, which R still stands for, by the `mass` (kg) of a floor bay."""
    nodes, members, loads = [], [], []
    for storey in range(STOREYS + 1):
        for row, name in enumerate("ABC"):
            if (storey, name) == (0, "B"):
                continue
            joint, share = f"{name}{storey}", mass * (1.0 if name == "B" else 0.5)
            support = "free" if storey else "clamped"
            at = row * SPAN, storey * HEIGHT
            nodes.append(Node(joint, *at, support, mass=share if storey else 0.0))
            if not storey:
                continue
            held = STOREYS * mass * GRAVITY if joint == ABOVE else 0.0
            loads.append(Load(joint, y=held - share * GRAVITY))
            if joint != ABOVE:
                members.append(Member(f"column {joint}", f"{name}{storey - 1}", joint, COLUMN))
            if name != "A":
                left = f"{'AB'[row - 1]}{storey}"
                members.append(Member(f"beam {joint}", left, joint, BEAM))
    return Frame(tuple(nodes), tuple(members), loads=tuple(loads))


def removal(mass: float, share: float = 1.0) -> tuple[FrameStatic, FramePulse]:
    """The column is taken away slowly, or at once; only a `share` of R for elastic checks."""
    held, size = STOREYS * mass * GRAVITY * share, f"{mass / 1e3:g} t"
    pattern = (Load(ABOVE, y=-held),)
    path = (FAR * share,)
    slow = FrameStatic(f"{size}, slowly", frame(mass), pattern, ABOVE, DOWN, path)
    gone = Pulse("rectangular", held, 100.0)
    one = (Load(ABOVE, y=-1.0),)
    sudden = FramePulse(f"{size}, suddenly", frame(mass), gone, ABOVE, DOWN, one, duration=DURATION)
    return slow, sudden


def pseudo_static(displacement: np.ndarray, factor: np.ndarray) -> float:
    """Displacement (m) to which R falls at once: its work is that of the static curve (NaN: none).

    `factor`, static load over R along the `displacement`; Izzuddin and others 2008.
    """
    steps = np.diff(displacement) * 0.5 * (factor[1:] + factor[:-1])
    spare = np.concatenate([[0.0], np.cumsum(steps)]) - displacement
    meets = np.flatnonzero((spare[1:] >= 0.0) & (spare[:-1] < 0.0))
    if not len(meets):
        return float("nan")
    n = meets[0]
    part = spare[n] / (spare[n] - spare[n + 1])
    return float(displacement[n] + part * (displacement[n + 1] - displacement[n]))


MASSES = (3e3, 6e3, 8e3, 1e4, 1.2e4, 1.4e4)
FLEXIBLE, RIGID, HINGE, FIBER = "flexible", "rigid", "plastic hinge", "fiber beam"
models = {
    FIBER: FiberReissner(),
    FLEXIBLE: FlexibleSuperelement(elements=4),
    RIGID: RigidSuperelement(elements=4),
    HINGE: PlasticHinge(elements=4),
}


def factors() -> None:
    """Print per mass and model: static at R and 2 R, energy, history, and the factor it takes."""
    for mass in MASSES:
        for name in (FLEXIBLE, RIGID, HINGE):
            slow, sudden = (models[name].simulate(each) for each in removal(mass))
            way, factor = slow["displacement"].values, slow["load_factor"].values
            top = float(sudden["peak_displacement"]) if "peak_displacement" in sudden else np.nan
            once, twice = (
                np.interp(f, factor, way) if factor.max() > f else np.nan for f in (1.0, 2.0)
            )
            needed = np.interp(top, way, factor)
            row = (once, twice, pseudo_static(way, factor), top)
            print(f"{mass / 1e3:g} t {name}:", *(f"{1e3 * v:.1f}" for v in row), f"{needed:.3f}")


cases = tuple(
    Case(each.name, each, quick=mass == 8e3) for mass in MASSES[::2] for each in removal(mass)
)
gates = tuple(
    Gate(
        name,
        FIBER,
        quantity,
        "relative_error",
        0.10,
        "Resistance and peak of the removal within this bound of distributed plasticity.",
        "Bound set by this study, not by a standard.",
        tuple(each.name for each in cases[start::2]),
    )
    for name in (FLEXIBLE, RIGID)
    for start, quantity in enumerate(("resistance", "peak_displacement"))
)
study = Study(
    name="column_removal",
    title="A frame whose middle column is gone",
    question="Does the frame stand when a column is taken away, and what says the factor 2?",
    cases=cases,
    models=models,
    reference=FIBER,
    quantities=("resistance", "peak_displacement"),
    gates=gates,
    figures=(
        Figure("frame", "structure", "The frame", "Without the middle column of the ground floor."),
        Figure(
            "push-down",
            "force-displacement",
            "Push-down of the joint above the column that is gone",
            "1 is the force that it carried.",
            (FIBER, FLEXIBLE, RIGID),
            {"cases": tuple(each.name for each in cases[::2])},
        ),
        Figure(
            "sudden",
            "history",
            "Sudden removal",
            "Displacement of the joint above.",
            options={"cases": tuple(each.name for each in cases[1::2])},
        ),
    ),
)

if __name__ == "__main__":
    if sys.argv[1:] == ["factors"]:
        factors()
    else:
        main(["run", __file__, *sys.argv[1:]])
