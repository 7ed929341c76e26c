"""OpenSeesPy for the benchmarks: its time steps, and the column of a scenario.

The column is clamped below and guided above: two force-based co-rotational elements with fiber
sections, in hinges as long as the section is deep around an elastic inside ("hinges"), or at five
Lobatto points each ("fibers", in space where the hit is oblique). The striker sticks to the node
that it hits.
"""

from __future__ import annotations

from math import cos, sin
from time import process_time

import numpy as np

from workbench.extras.exchange.opensees.model import quiet
from workbench.mechanics.structures.space import space_fibers
from workbench.scenarios import ColumnImpact
from workbench.steel.sections.slenderness import torsion_constants

ATTEMPTS = (
    (1, "Newton"),
    (4, "Newton"),
    (16, "KrylovNewton"),
    (64, "Newton"),
    (256, "KrylovNewton"),
    (1024, "Newton"),
)


@quiet()
def peak_of(hit: int, duration: float, steps: float, tolerance: float = 1e-7) -> float:
    """Largest displacement of the node `hit` along x; equal steps, cut where they fail.

    Each is solved until displacements change by no more than a `tolerance` (m). Raises
    `RuntimeError` where no cut helps.
    """
    import openseespy.opensees as ops

    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", tolerance, 25)
    ops.integrator("Newmark", 0.5, 0.25)
    ops.algorithm("Newton")
    ops.analysis("Transient")
    begin, peak = ops.getTime(), 0.0
    for step in range(1, int(steps) + 1):
        for parts, algorithm in ATTEMPTS:  # from where the last attempt has stopped
            ops.algorithm(algorithm)
            rest = begin + step * duration / steps - ops.getTime()
            if ops.analyze(parts, rest / parts) == 0:
                break
        else:
            raise RuntimeError(f"OpenSees does not converge at step {step} of {steps}")
        peak = max(peak, float(ops.nodeDisp(hit, 1)))
    return peak


def column(
    scenario: ColumnImpact, kind: str, steps: float, layers: int = 16
) -> tuple[float, float]:
    """Peak displacement (m) of the impact point, and processor seconds that its steps took.

    `kind` is "hinges" or "fibers". The model is built and loaded before the clock starts.
    """
    import openseespy.opensees as ops

    column, striker, steel = scenario.column, scenario.striker, scenario.column.steel
    properties, section, angle = column.properties, column.strength_section, striker.angle
    spatial = angle != 0.0
    axes, dofs = (3, 6) if spatial else (2, 3)
    ops.wipe()
    ops.model("basic", "-ndm", axes, "-ndf", dofs)
    for node, height in ((1, 0.0), (2, column.length_below), (3, column.length)):
        ops.node(node, 0.0, height, *(axes - 2) * [0.0])
    ops.fix(1, *dofs * [1])
    ops.fix(3, 1, 0, *(dofs - 2) * [1])
    ops.uniaxialMaterial("Steel01", 1, steel.yield_stress, steel.elastic_modulus, 1e-6)
    if spatial:
        fibers = space_fibers(section, layers)
        ops.section("Fiber", 1, "-GJ", steel.shear_modulus * torsion_constants(section)[0])
        ops.geomTransf("Corotational", 1, sin(angle), 0.0, cos(angle))  # towards the width
    else:
        y, area = section.fibers(layers)
        fibers = y, np.zeros(len(y)), area
        ops.section("Fiber", 1)
        ops.geomTransf("Corotational", 1)
    for fiber in zip(*fibers, strict=True):
        ops.fiber(*map(float, fiber), 1)
    if kind == "hinges":
        elastic = steel.elastic_modulus, properties.area, properties.second_moment
        ops.section("Elastic", 2, *elastic)
        depth = column.section.height
        ops.beamIntegration("HingeRadau", 1, 1, depth, 1, depth, 2)
    else:
        ops.beamIntegration("Lobatto", 1, 1, 5)
    mass = properties.mass_per_length
    for tag, ends in ((1, (1, 2)), (2, (2, 3))):
        ops.element("forceBeamColumn", tag, *ends, 1, 1, "-iter", 50, 1e-8, "-mass", mass)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(3, 0.0, -column.axial_load, *(dofs - 2) * [0.0])
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-9, 25)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static")
    if ops.analyze(1) != 0:
        raise RuntimeError("OpenSees does not carry the dead load")
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()
    ops.node(4, *ops.nodeCoord(3))  # takes the displacement that it is built at as unstressed
    ops.fix(4, *dofs * [1])
    ops.uniaxialMaterial("Elastic", 4, column.restraint_stiffness)
    ops.element("zeroLength", 4, 4, 3, "-mat", 4, "-dir", 2)
    attached = 0.5 * mass * column.length
    ops.mass(2, striker.mass, *(dofs - 1) * [0.0])
    velocity = striker.mass * striker.velocity / (striker.mass + attached)
    ops.setNodeVel(2, 1, velocity, "-commit")
    start = process_time()
    peak = peak_of(2, scenario.duration, steps)
    return peak, process_time() - start
