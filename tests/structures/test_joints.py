"""Rotational springs between tied nodes: closed forms, yielding, energies, tangents."""

from math import inf

import numpy as np
import pytest
from assembly_cases import full_tangent
from beam_cases import E_STEEL, clamp, rectangle

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.elements import JointSprings
from workbench.mechanics.structures.fibers.section import FiberBeams
from workbench.mechanics.structures.paths import apply_loads, push

SLIM = rectangle(yield_stress=1e12)
BENDING = E_STEEL * float(np.sum(SLIM.y**2 * SLIM.area))
LENGTH = 2.0


def jointed(
    spring: tuple[float, float, float], parts: int = 4
) -> tuple[PlanarAssembly, JointSprings]:
    """A cantilever along x whose foot, node 0, is joined to the clamp, node `parts` + 1."""
    x = np.append(np.linspace(0.0, LENGTH, parts + 1), 0.0)
    nodes = np.stack([np.arange(parts), np.arange(1, parts + 1)], axis=1)
    beams = FiberBeams(nodes, np.zeros(parts, int), [SLIM])
    joints = JointSprings([[parts + 1, 0]], [spring])
    where = np.stack([x, np.zeros_like(x)], axis=1)
    assembly = PlanarAssembly(where, [beams, joints], ties=[(parts + 1, 0)])
    clamp(assembly, parts + 1)
    return assembly, joints


def test_semi_rigid_cantilever():
    """v = F L^3 / 3EI + F L^2 / k; a positive moment is the member's."""
    assembly, joints = jointed((2.0 * BENDING / LENGTH, inf, inf))
    tip = assembly.dof(4, "v")
    assembly.load[tip] = -1000.0
    apply_loads(assembly)
    expected = -1000.0 * (LENGTH**3 / (3 * BENDING) + LENGTH**3 / (2.0 * BENDING))
    assert assembly.displacement[tip] == pytest.approx(expected, rel=2.1e-8)  # measured 1.0e-8
    # a load downwards stretches the fibers above, on the left along x
    assert joints.moments == pytest.approx([-2000.0], rel=1e-6)
    assert joints.rotations == pytest.approx(-2000.0 * LENGTH / (2.0 * BENDING), rel=1e-6)
    assert assembly.displacement[assembly.dof(0, "rotation")] == pytest.approx(joints.rotations[0])
    assert np.all(assembly.displacement[[assembly.dof(0, "u"), assembly.dof(0, "v")]] == 0.0)


def test_pin_makes_the_propped_beam_simply_supported():
    """48 EI / L^3 between a pin to the ground and a roller."""
    assembly, joints = jointed((0.0, inf, inf))
    assembly.hold([assembly.dof(4, "v")])
    middle = assembly.dof(2, "v")
    step = next(push(assembly, middle, np.array([1e-5])))
    # measured 9.3e-11
    assert step.factor == pytest.approx(48 * BENDING / LENGTH**3 * 1e-5, rel=1e-8)
    assert joints.moments == pytest.approx([0.0])
    assert joints.plastic == pytest.approx(joints.rotations)
    assert joints.plastic[0] == pytest.approx(3e-5 / LENGTH, rel=1e-8)  # measured 1.8e-11
    assert joints.utilisation() == pytest.approx([0.0])


def test_partial_strength_joint_yields_at_its_own_moment_on_either_side():
    """Cyclic: F L = -300 and +200 kN m, elastic between; dissipation is the plastic work."""
    spring = (2.0 * BENDING / LENGTH, 3e5, 2e5)
    assembly, joints = jointed(spring)
    tip = assembly.dof(4, "v")
    path = np.concatenate([np.linspace(0, 0.05, 11)[1:], np.linspace(0.05, -0.05, 21)[1:]])
    steps = list(push(assembly, tip, path))
    force = np.array([step.factor for step in steps])
    assert force[9] == pytest.approx(150e3, rel=7e-4)  # measured 3.2e-4
    assert force[-1] == pytest.approx(-100e3, rel=7e-4)  # measured 3.1e-4
    assert joints.moments == pytest.approx([-2e5])
    assert joints.utilisation() == pytest.approx([1.0])
    assert joints.plastic[0] < 0.0
    dissipated = sum(step.energies.plastic for step in steps)
    work = np.trapezoid(np.append(0.0, force), np.append(0.0, path))
    # measured 3.8e-8
    assert dissipated == pytest.approx(work - steps[-1].energies.stored, rel=8e-8)


@pytest.mark.parametrize("weight", [None, 0.5, 0.8])
def test_tangent_and_energies_of_a_step(weight):
    rng = np.random.default_rng(6)
    for size in (0.1, 1.0, 30.0):
        assembly, _ = jointed((1e7, 3e5, 2e5))
        base, end = size * 0.01 * rng.normal(size=(2, assembly.size))
        assembly.assemble(base, None)
        stored = assembly.account(base, 0.5).stored
        assembly.commit(base)
        force = assembly.assemble(end, weight)
        exact = full_tangent(assembly)
        if weight is not None:
            taken = assembly.account(end, weight)
            change = taken.stored - stored + taken.plastic + taken.algorithmic
            assert force @ (end - base) == pytest.approx(change, rel=1e-11)
            assert taken.algorithmic >= 0.0
        for dof in (assembly.dof(0, "rotation"), assembly.dof(5, "rotation")):
            step = np.zeros(assembly.size)
            step[dof] = 1e-8
            change = assembly.assemble(end + step, weight) - assembly.assemble(end - step, weight)
            assert change / 2e-8 == pytest.approx(exact[:, dof], abs=1e-6 * np.abs(exact).max())


def test_springs_at_two_places_are_refused():
    joints = JointSprings([[0, 1]], [(1.0, inf, inf)])
    with pytest.raises(ValueError, match="one place"):
        PlanarAssembly([[0.0, 0.0], [1.0, 0.0]], [joints])
