"""Columns hit from every side: eight sections, five directions, three heights, two speeds.

Reduced models against fiber beams in space, a subset against shells that may buckle and twist and
against fibers on two finer meshes, which say what the mesh is good for.
Plane models answer along the web and, bent about the weak axis, along the flanges; between the two
they refuse, so that the study also says how far a hit goes that nobody meant to be off the web.

Masses are such that the mechanism about the strong axis takes the energy over a twentieth of the
shorter segment: the same striker then hits from all sides.
"""

import sys
from itertools import product
from math import radians

from workbench.cli import main
from workbench.models.four_dof import FourDof
from workbench.models.references.fiber_space import FiberSpace
from workbench.models.references.shell import Shell
from workbench.models.seven_dof import SevenDof
from workbench.models.superelement_space import SuperelementSpace
from workbench.models.superelements import RigidSuperelement
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

SECTIONS = (
    *("HEB 220", "HEB 300", "HEA 200", "UC 254x254x107", "IPE 240", "IPE 300"),
    *("SHS 200x10", "RHS 300x200x10"),
)
OPEN = SECTIONS[:6]
DEGREES = (0.0, 5.0, 20.0, 45.0, 90.0)
HEIGHTS, SPEEDS = (0.25, 0.35, 0.5), (6.0, 14.0)  # over the length of 4 m; m/s
LENGTH, REACH, PRESSED = 4.0, 0.05, 0.1  # m; over the shorter segment; share of the squash load
FIBERS, FINER, SHELL = "fibers in space", "finer fibers in space", "shells"
ANGLE, SHOWN, BELOW = (
    "degrees off the web",
    "degrees off the web, 1 for none",
    "length below the impact point in m",
)
models = {
    FIBERS: FiberSpace(refinement=0, levels=1),
    FINER: FiberSpace(levels=2),
    SHELL: Shell(levels=1),
    "seven-dof": SevenDof(),
    "superelements in space": SuperelementSpace(),
    "4-DOF": FourDof(),
    "rigid bars": RigidSuperelement(shear="none"),
}
# sections of which shells and fibers on two meshes are hit, low and fast: a minute each
STRUCK = ("HEB 220", "IPE 300", "SHS 200x10")


def hit(name: str, angle: float, height: float, speed: float) -> Case:
    """One column, hit at an angle (degrees) at a height (over its length) and a speed (m/s)."""
    below = height * LENGTH
    column = Column(find(name), below, LENGTH - below, restraint_stiffness=5e6)
    column = column.changed(axial_load=PRESSED * column.properties.squash_load)
    resistance = 2.0 * column.properties.plastic_moment * LENGTH / (below * (LENGTH - below))
    mass = 2.0 * resistance * REACH * below / speed**2
    plane = angle in (0.0, 90.0)
    if angle == 90.0:
        column = column.changed(axis="weak")
    striker = Striker(mass, speed, angle=0.0 if plane else radians(angle))
    title = f"{name}, {angle:g} degrees, {below:g} m, {speed:g} m/s"
    costly = name in STRUCK and height == HEIGHTS[0] and speed == SPEEDS[1]
    quick = name == "HEB 220" and height == HEIGHTS[1] and speed == SPEEDS[0] and angle < 90.0
    left_out = ("4-DOF", "rigid bars") * (not plane) + (SHELL,) * (not costly)
    left_out += (FINER,) * (not (costly or quick))
    return Case(
        title,
        ColumnImpact(title, column, striker, 0.1),
        models=tuple(m for m in models if m not in left_out),
        parameters={ANGLE: angle, SHOWN: max(angle, 1.0), BELOW: below},
        quick=quick,
    )


cases = tuple(
    hit(name, angle, height, speed)
    for name, height, speed, angle in product(SECTIONS, HEIGHTS, SPEEDS, DEGREES)
)


def at(*angles: float) -> tuple[str, ...]:
    """Names of the cases hit at these angles (degrees)."""
    return tuple(case.name for case in cases if case.parameters[ANGLE] in angles)


EVERY = tuple(case.name for case in cases)
CHECKED, SHELLS = (
    tuple(case.name for case in cases if judge in case.models) for judge in (FINER, SHELL)
)
_BASIS = "Bound set by this study, not by a standard."
gates = (
    Gate(
        "seven-dof",
        FINER,
        "peak_displacement",
        "relative_error",
        0.05,
        "Two rigid bars with hinges in space against beams whose sections they are.",
        _BASIS,
        CHECKED,
    ),
    Gate(
        "superelements in space",
        FINER,
        "peak_displacement",
        "relative_error",
        0.05,
        "Elastic bars with hinges in space against beams whose sections they are.",
        _BASIS,
        CHECKED,
    ),
    Gate(
        "4-DOF",
        FINER,
        "peak_displacement",
        "relative_error",
        0.05,
        "The plane model along the web and about the weak axis.",
        _BASIS,
        tuple(name for name in CHECKED if name in at(0.0, 90.0)),
    ),
    Gate(
        "seven-dof",
        SHELL,
        "peak_displacement",
        "relative_error",
        0.10,
        "Shells shear their web, buckle and twist; hinges do none of it.",
        _BASIS,
        SHELLS,
    ),
)
figures = (
    Figure(
        "angles",
        "domain-map",
        "Where seven-dof stays within 5 and 10 % of fibers in space",
        "Each point is a column; the colour is the class of the error of the peak displacement "
        "along the hit.",
        ("seven-dof",),
        {"cases": EVERY, "against": FIBERS, "x": SHOWN, "over": BELOW, "y": "v/La"},
    ),
    Figure(
        "deformed",
        "deformed",
        "Where an oblique hit takes a column",
        "Across, along the hit, and sideways, along the face of the striker.",
        (FIBERS,),
        {
            "cases": tuple(
                case.name for case in cases if case.quick and case.parameters[ANGLE] == 45
            )
        },
    ),
    Figure(
        "cost",
        "cost",
        "Cost against error",
        "Wall time of one run against the error of the peak, over all columns.",
    ),
)

study = Study(
    name="directions",
    title="Columns hit from every side",
    question=(
        "How far do hits go that are not along the web, how far can a reduced model of them be "
        "trusted, and at what cost?"
    ),
    cases=cases,
    models=models,
    reference=FIBERS,
    references=(SHELL, FINER, FIBERS),
    groups={f"{angle:g} degrees": at(angle) for angle in DEGREES},
    decisive="angles",
    quantities=("peak_displacement", "residual_displacement"),
    gates=gates,
    figures=figures,
    quick_models=(FIBERS, FINER, "seven-dof", "4-DOF"),
    notes=(
        "Neither hinges nor fibers in space shear their web; shells do, buckle and twist.",
        "The face of the striker lets the column slide along it, which is the safe bound.",
        "The fibers that answer every column have one mesh, without an uncertainty of its own: "
        "within 1.1 % of those on two finer ones, by which gates judge.",
        "Shells report the way of the striker: flanges fold under it, walls of tubes dent.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
