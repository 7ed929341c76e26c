"""The column of a scenario in OpenSeesPy: displacement-based co-rotational fiber elements.

The same nodes, fibers, two Legendre points, steps and nodal masses as the classical element of
`fiber-corotational`, or of `fiber-space` where the hit is oblique. A restitution of 0 is modelled
by a striker that sticks to the node that it has hit; histories are comparable as long as the
contact lasts.
"""

from __future__ import annotations

import numpy as np
import pytest

from workbench.mechanics.structures.space import space_fibers
from workbench.scenarios import Column, ColumnImpact
from workbench.steel.sections.slenderness import torsion_constants

ops = pytest.importorskip(
    "openseespy.opensees",
    reason="OpenSeesPy is not installed: pip install 'steel-impact-workbench[opensees]'",
    exc_type=ImportError,
)
STRIKE, AXIS, TURN = 1, 2, 3
SPRING, PUSH, STRIKER = 9001, 2, 9002
CONTACT = 1e12  # N/m: the striker bounces on 1e10, peaks are 0.5 % larger; 1e14 is within 0.1 %
BEFORE_PEAK = 0.01  # s, within which a wave may turn the struck node back


def stand(column: Column, lengths: np.ndarray, hardening: float, layers: int = 20) -> int:
    """Build the column under its axial load; return the number of its head.

    Arguments: element `lengths` (m) from the base; kinematic `hardening` modulus over the elastic
    one (Steel01 takes the slope of the hardening line, E H / (E + H)).
    """
    heights = np.concatenate([[0.0], np.cumsum(lengths)])
    head = len(heights)
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for number, height in enumerate(heights, 1):
        ops.node(number, 0.0, float(height))
    ops.fix(1, 1, 1, int(column.base == "clamped"))
    ops.fix(head, 1, int(column.head == "fixed"), int(column.head != "pinned"))
    _steel(column, hardening)
    y, area = column.strength_section.fibers(layers)
    ops.section("Fiber", 1)
    for height, part in zip(y, area, strict=True):
        ops.fiber(float(height), 0.0, float(part), 1)
    ops.geomTransf("Corotational", 1)
    _elements_and_load(column, lengths, float(np.sum(y**2 * area) / np.sum(area)), 1)
    return head


def stand_in_space(
    scenario: ColumnImpact, lengths: np.ndarray, hardening: float, layers: int
) -> int:
    """Build the column with its section turned away from the strike; return the head's number.

    Arguments as for `stand`. Both axes have the same ends; base and head hold the twist, as in
    `fiber-space`; torsion is elastic, by St Venant.
    """
    column, angle = scenario.column, scenario.striker.angle
    assert column.axis == "strong"
    assert column.ends_about("weak") == column.ends_about("strong")
    heights = np.concatenate([[0.0], np.cumsum(lengths)])
    head = len(heights)
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for number, height in enumerate(heights, 1):
        ops.node(number, 0.0, float(height), 0.0)
    turns = int(column.base == "clamped")
    ops.fix(1, 1, 1, 1, turns, 1, turns)
    turns = int(column.head != "pinned")
    ops.fix(head, 1, int(column.head == "fixed"), 1, turns, 1, turns)
    _steel(column, hardening)
    section = column.strength_section
    fibers = space_fibers(section, layers)
    ops.section("Fiber", 1, "-GJ", column.steel.shear_modulus * torsion_constants(section)[0])
    for y, z, area in zip(*fibers, strict=True):
        ops.fiber(float(y), float(z), float(area), 1)
    ops.geomTransf("Corotational", 1, np.sin(angle), 0.0, np.cos(angle))  # towards the width
    radius_squared = float(np.sum(fibers.y**2 * fibers.area) / np.sum(fibers.area))
    _elements_and_load(column, lengths, radius_squared, 3)
    return head


def _steel(column: Column, hardening: float) -> None:
    steel, ratio = column.steel, hardening / (1.0 + hardening)
    ops.uniaxialMaterial("Steel01", 1, steel.yield_stress, steel.elastic_modulus, ratio)


def _elements_and_load(
    column: Column, lengths: np.ndarray, radius_squared: float, turns: int
) -> None:
    """Elements, masses of nodes, axial load and spring of the head; `turns`, rotations of a node.

    The rotary inertia is the same about every axis.
    """
    head = len(lengths) + 1
    ops.beamIntegration("Legendre", 1, 1, 2)
    for number in range(1, head):
        ops.element("dispBeamColumn", number, number, number + 1, 1, 1)
    tributary = 0.5 * (np.append(lengths, 0.0) + np.append(0.0, lengths))
    axes = 3 if turns == 3 else 2
    for number, value in enumerate(column.properties.mass_per_length * tributary, 1):
        given = float(value) + (column.head_mass if number == head else 0.0)
        ops.mass(number, *axes * [given], *turns * [float(value) * radius_squared])
    ops.timeSeries("Linear", 1)
    if column.axial_load:
        ops.pattern("Plain", 1, 1)
        ops.load(head, 0.0, -column.axial_load, *(axes + turns - 2) * [0.0])
        _analysis("Static", ("LoadControl", 0.2))
        assert ops.analyze(5) == 0
        ops.loadConst("-time", 0.0)
    if column.head != "fixed" and column.restraint_stiffness > 0.0:
        # a zero-length element takes the displacement that it is built at as its unstressed one
        ops.node(SPRING, *ops.nodeCoord(head))
        ops.fix(SPRING, *(axes + turns) * [1])
        ops.uniaxialMaterial("Elastic", SPRING, column.restraint_stiffness)
        ops.element("zeroLength", SPRING, SPRING, head, "-mat", SPRING, "-dir", AXIS)


def _analysis(kind: str, integrator: tuple[object, ...]) -> None:
    ops.wipeAnalysis()
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    if kind == "Static":
        ops.test("NormUnbalance", 1e-2, 60)
    else:  # in J: forces of elements of millimetres round off at up to 100 N
        ops.test("EnergyIncr", 1e-8, 25)
    ops.algorithm("Newton")
    ops.integrator(*integrator)
    ops.analysis(kind)


def push(hit: int, path: np.ndarray) -> np.ndarray:
    """Forces (steps,) at the node `hit` when it is led along the equidistant `path` (m)."""
    ops.timeSeries("Linear", PUSH)
    ops.pattern("Plain", PUSH, PUSH)
    ops.load(hit, 1.0, 0.0, 0.0)
    _analysis("Static", ("DisplacementControl", hit, STRIKE, float(path[0])))
    forces = []
    for target in path:
        for parts in (1, 10, 100):  # from where the last attempt has stopped
            rest = float(target) - ops.nodeDisp(hit, STRIKE)
            ops.integrator("DisplacementControl", hit, STRIKE, rest / parts)
            if ops.analyze(parts) == 0:
                break
        else:
            raise AssertionError("OpenSees does not converge")
        forces.append(ops.getLoadFactor(PUSH))
    return np.array(forces)


def hit_by(scenario: ColumnImpact, hit: int, dt: float, count: int) -> np.ndarray:
    """Displacements (count,) of the node `hit` under a striker that sticks, composite steps.

    Trapezoidal rule, then backward difference: Newmark's average rings, its peaks scatter by 1 %.
    """
    striker = scenario.striker
    given = ops.nodeMass(hit)
    momentum = striker.mass * striker.velocity
    ops.mass(hit, given[0] + striker.mass, given[1], given[2])
    ops.setNodeVel(hit, STRIKE, momentum / (given[0] + striker.mass), "-commit")
    _analysis("Transient", ("TRBDF2",))
    begin = ops.getTime()
    values = []
    for number in range(1, count + 1):
        _advance(begin + number * dt)
        values.append(ops.nodeDisp(hit, STRIKE))
    return np.array(values)


def peak_under(scenario: ColumnImpact, hit: int, dt: float) -> float:
    """Largest displacement (m) of the node `hit` under a striker that may lift off.

    It pushes through a stiff spring without tension.
    """
    striker = scenario.striker
    ops.node(STRIKER, *ops.nodeCoord(hit))
    beside = len(ops.nodeMass(hit)) - 1  # what the striker does not do
    ops.fix(STRIKER, 0, *beside * [1])
    ops.mass(STRIKER, striker.mass, *beside * [0.0])
    ops.uniaxialMaterial("ENT", STRIKER, CONTACT)
    ops.element("zeroLength", STRIKER, STRIKER, hit, "-mat", STRIKER, "-dir", STRIKE)
    ops.setNodeDisp(STRIKER, STRIKE, ops.nodeDisp(hit, STRIKE), "-commit")
    ops.setNodeVel(STRIKER, STRIKE, striker.velocity, "-commit")
    _analysis("Transient", ("TRBDF2",))
    begin = ops.getTime()
    peak = 0.0
    for number in range(1, round(scenario.duration / dt) + 1):
        _advance(begin + number * dt)
        peak = max(peak, ops.nodeDisp(hit, STRIKE))
        if number * dt > BEFORE_PEAK and ops.nodeDisp(hit, STRIKE) < 0.98 * peak:
            return peak
    raise AssertionError("the record ends before the peak is passed")


def _advance(time: float) -> None:
    """Go on to a time (s), in shorter steps where one fails."""
    for parts in (1, 10, 100):  # from where the last attempt has stopped
        if ops.analyze(parts, (time - ops.getTime()) / parts) == 0:
            return
    raise AssertionError("OpenSees does not converge")
