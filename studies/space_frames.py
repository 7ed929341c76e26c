"""Frames in space: a corner column hit from the side, and what its plane frame alone would say.

Superelements in space against fiber beams in space on one bay by one bay; three storeys of two by
two bays; and one plane frame that is hit off its plane, which leans.
"""

import sys
from dataclasses import replace
from math import radians

from workbench.cli import main
from workbench.models.references.fiber_space import FiberSpace
from workbench.models.superelement_space import SuperelementSpace
from workbench.models.superelements import FlexibleSuperelement
from workbench.scenarios import Frame, FrameImpact, FrameStriker, Load, regular_frame
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

SPACE, FIBERS, PLANE = "superelements in space", "fibers in space", "plane superelements"
ANGLE = "degrees off x"
MASS, SPEED = 1500.0, 12.0  # kg, m/s
models = {
    FIBERS: FiberSpace(smallest_element=0.1, largest_element=0.6, layers=8, levels=2),
    SPACE: SuperelementSpace(),
    PLANE: FlexibleSuperelement(shear="none"),
}


def frame(
    bays: tuple[float, ...], depths: tuple[float, ...], storeys: tuple[float, ...], load: float
) -> Frame:
    """Columns HEB 220 whose webs lie along x, beams IPE 300, a dead load (N) on every joint.

    The corner column A is hit at mid-height of its storey.
    """
    bare = regular_frame(bays, storeys, find("HEB 220"), find("IPE 300"), depths=depths)
    corner = "Aa" if depths else "A"
    loads = tuple(Load(node.name, y=-load) for node in bare.nodes if node.y > 0.0)
    return replace(bare, loads=loads).split(f"{corner}0-{corner}1", 1.75, "hit")


def hit(what: str, struck: Frame, angle: float, *shown: str, quick: bool = False) -> Case:
    """A hit at an angle (degrees) off x towards z."""
    striker = FrameStriker(MASS, SPEED, node="hit", angle=radians(angle))
    name = f"{what}, {angle:g} degrees"
    event = FrameImpact(name, struck, striker, 0.12)
    return Case(name, event, models=shown, parameters={ANGLE: angle}, quick=quick)


BAY = frame((5.0,), (5.0,), (3.5,), 2e5)
HOUSE = frame((6.0, 6.0), (5.0, 5.0), (3.5, 3.0, 3.0), 6e4)
PORTAL = frame((5.0,), (), (3.5,), 2e5)
ONE, MANY, ALONE = "one bay", "two by two bays", "plane frame"
cases = (
    *(hit(ONE, BAY, angle, FIBERS, SPACE, quick=angle == 30.0) for angle in (0.0, 30.0, 90.0)),
    *(hit(MANY, HOUSE, angle, SPACE) for angle in (0.0, 30.0, 60.0, 90.0)),
    hit(ALONE, PORTAL, 0.0, SPACE, PLANE),
    hit(ALONE, PORTAL, 5.0, SPACE),
    hit(ALONE, PORTAL, 10.0, SPACE),
)
study = Study(
    name="space_frames",
    title="Frames in space, a corner column hit from the side",
    question="How far does a corner column of a frame go that is hit off the web of the column?",
    cases=cases,
    models=models,
    reference=FIBERS,
    references=(FIBERS, SPACE),
    decisive="peaks",
    quantities=("peak_displacement",),
    gates=(
        Gate(
            SPACE,
            FIBERS,
            "peak_displacement",
            "relative_error",
            0.05,
            "Bars between hinges against beams whose sections they are.",
            "Bound set by this study, not by a standard.",
            tuple(case.name for case in cases if FIBERS in case.models),
        ),
    ),
    figures=(
        Figure(
            "frames",
            "structure",
            "The frames",
            "Webs of the columns lie along x; the corner column at the back on the left is hit.",
            options={"cases": (cases[1].name, cases[4].name)},
        ),
        Figure(
            "peaks",
            "peaks",
            "Peaks along the hit",
            "Off the web a column goes further; a frame without bays along z leans as a whole.",
        ),
        Figure(
            "deformed",
            "deformed",
            "Deformed shapes",
            "Displacements of the corner column at the peak.",
            (SPACE,),
            {"cases": (cases[1].name, cases[4].name)},
        ),
    ),
    notes=("Meshes of fibers are coarse: at half the size of elements peaks rise by 1 to 2 %.",),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
