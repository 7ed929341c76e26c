"""Vogel's calibration frames: ultimate load factors of all frame models, against plastic zones.

Vogel 1985: a portal and six storeys, E = 205 GPa, fy = 235 MPa, residual stress of rolled sections
(ECCS), columns out of plumb, all loads in proportion. By plastic zones 1.022 and 1.11. The data are
those that papers on frames repeat; the source itself was not at hand. Beam loads act at 16 points
per beam. A load factor is the resistance over the resultant of the loads, `LOADS`.
"""

import sys
from dataclasses import replace
from math import hypot

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
from workbench.scenarios import Frame, FrameStatic, Load, Member, Node, regular_frame
from workbench.steel.materials import Steel
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.assessment import Gate

STEEL = Steel(elastic_modulus=205e9, yield_stress=235e6)
PORTAL, STOREYS = "portal", "six storeys"
PLASTIC_ZONES = {PORTAL: 1.022, STOREYS: 1.11}
TILT = {PORTAL: 1.0 / 400.0, STOREYS: 1.0 / 450.0}
POINTS = 16  # parts of a beam, between which its load acts
BAY, STOREY = 6.0, 3.75  # m
FLOOR, ROOF = 49.1e3, 31.7e3  # N/m
WIND, WIND_ROOF = 20.44e3, 10.23e3  # N
BEAMS = ("IPE 400", "IPE 360", "IPE 330", "IPE 300", "IPE 300", "IPE 240")  # from below
OUTER = ("HEB 220",) * 4 + ("HEB 160",) * 2
INNER = ("HEB 260",) * 2 + ("HEB 240",) * 2 + ("HEB 200",) * 2


def portal(tilt: float = TILT[PORTAL], sway: float = 0.06) -> FrameStatic:
    """HEB 300 and HEB 340, 4 m wide, 5 m high, 2800 kN on each column, 35 kN sideways."""
    frame = regular_frame((4.0,), (5.0,), find("HEB 300"), find("HEB 340"), steel=STEEL)
    nodes = tuple(replace(node, x=node.x + tilt * node.y) for node in frame.nodes)
    loads = (Load("A1", x=35e3, y=-2.8e6), Load("B1", y=-2.8e6))
    return FrameStatic(PORTAL, replace(frame, nodes=nodes), loads, "A1", "x", (sway,))


def six_storeys(
    tilt: float = TILT[STOREYS], points: int = POINTS, sway: float = 0.4
) -> FrameStatic:
    """Two bays of 6 m, storeys of 3.75 m, loads on all beams, wind from the left."""
    nodes, members, splits = [], [], []
    loads: dict[str, Load] = {}
    for level in range(7):
        for i, axis in enumerate("ABC"):
            at = i * BAY + tilt * level * STOREY
            support = "free" if level else "clamped"
            nodes.append(Node(f"{axis}{level}", at, level * STOREY, support))
            if level:
                column = find((INNER if axis == "B" else OUTER)[level - 1])
                ends = f"{axis}{level - 1}", f"{axis}{level}"
                members.append(Member("-".join(ends), *ends, column))
        for a, b in ("AB", "BC") if level else ():
            start, end = f"{a}{level}", f"{b}{level}"
            members.append(Member(f"{start}-{end}", start, end, find(BEAMS[level - 1])))
            inner = [f"{start}.{i}" for i in range(1, points)]
            for i, name in enumerate(inner):
                part = f"{start}-{end}" + "/2" * i
                splits.append((part, BAY / points, name))
            share = (ROOF if level == 6 else FLOOR) * BAY / points
            for name in (start, *inner, end):
                half = 0.5 if name in (start, end) else 1.0
                load = loads.get(name, Load(name))
                loads[name] = replace(load, y=load.y - half * share)
        if level:
            name = f"A{level}"
            loads[name] = replace(loads[name], x=WIND_ROOF if level == 6 else WIND)
    frame = Frame(tuple(nodes), tuple(members), (), (), STEEL).split_all(splits)
    return FrameStatic(STOREYS, frame, tuple(loads.values()), "A6", "x", (sway,))


def resultant(push: FrameStatic) -> float:
    """Of all loads of a pattern, in N."""
    return hypot(sum(load.x for load in push.loads), sum(load.y for load in push.loads))


FRAMES = {PORTAL: portal, STOREYS: six_storeys}
LOADS = {name: resultant(frame()) for name, frame in FRAMES.items()}  # N
PLUMB = {name: f"{name}, plumb" for name in FRAMES}
MESH = {"smallest_element": 0.01, "largest_element": 0.25, "levels": 1}
REFERENCE = "fibers with residual stress"
REFINED = "refined plastic hinge"
models = {
    REFERENCE: FiberReissner(residual_stress="triangular", **MESH | {"levels": 2}),
    "fibers": FiberReissner(**MESH),
    "fibers that yield in shear": FiberShear(residual_stress="triangular", **MESH),
    "cubic fiber beam": FiberCorotational(smallest_element=0.1, largest_element=0.25, levels=1),
    "force-based beam": ForceBasedBeam(elements=2),
    "fiber hinge": FiberHinge(elements=2),
    "bounding surface": BoundingSurface(),
    "bounding surface, residual stress": BoundingSurface(residual_stress="triangular"),
    "modified tangent modulus": ModifiedTangentModulus(),
    "plastic hinge, exact": PlasticHinge(),
    "plastic hinge, super-ellipse": PlasticHinge(surface="super-ellipse"),
    "quasi-plastic hinge": QuasiPlasticHinge(),
    REFINED: RefinedPlasticHinge(),
    "rigid superelement": RigidSuperelement(shear="none"),
    "flexible superelement": FlexibleSuperelement(shear="none"),
    "Giberson": Giberson(),
}
cases = (
    *(Case(name, frame(), quick=name == PORTAL) for name, frame in FRAMES.items()),
    *(
        Case(PLUMB[name], frame(0.0), models=(REFERENCE, REFINED), quick=False)
        for name, frame in FRAMES.items()
    ),
)
gates = tuple(
    Gate(
        *(label, REFERENCE, "resistance", "relative_error", 0.05),
        "Ultimate load within this bound of distributed plasticity with residual stress.",
        "Bound set by this study, not by a standard.",
        cases=(PORTAL,),
    )
    for label in ("bounding surface", "modified tangent modulus", "plastic hinge, exact")
)
figures = (
    Figure(
        "push",
        "force-displacement",
        "All loads in proportion",
        "Resultant of the loads over the sway of the top.",
        tuple(label for label in models if label != "Giberson"),
        {"cases": tuple(FRAMES)},
    ),
    Figure("cost", "cost", "Cost against error", "Wall time of one run against its error."),
    Figure(
        "frame",
        "structure",
        "Six storeys",
        "HEB columns and IPE beams; loads act at 16 points per beam.",
        options={"case": STOREYS},
    ),
)

study = Study(
    name="vogel_frames",
    title="Vogel's calibration frames: load factors of all frame models",
    question="How far from plastic zones are the ultimate loads that frame models find?",
    cases=cases,
    models=models,
    reference=REFERENCE,
    references=(REFERENCE,),
    groups={name: (name,) for name in FRAMES},
    quantities=("resistance",),
    gates=gates,
    figures=figures,
    decisive="push",
    quick_models=(REFERENCE, "bounding surface", "modified tangent modulus"),
    notes=(
        "Load factors are resistances over "
        + " and ".join(f"{load / 1e6:.4f} MN ({name})" for name, load in LOADS.items())
        + f"; by plastic zones {PLASTIC_ZONES[PORTAL]:g} and {PLASTIC_ZONES[STOREYS]:g}.",
        "The column curve of refined plastic hinges stands for columns out of plumb: theirs is the "
        "plumb frame. Sections with root fillets.",
        "Warnings of shear on six storeys are of an upper bound, plastic moments at both ends of "
        "pieces of beams between loads; fibers whose webs yield have 1.5 % less resistance there.",
    ),
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
