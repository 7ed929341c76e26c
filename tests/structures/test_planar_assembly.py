"""Assembly: numbering, band storage, masses, springs, supports."""

import numpy as np
import pytest
from beam_cases import chain, clamp, rectangle

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers.section import FiberBeams
from workbench.mechanics.structures.paths import apply_loads


def dense(assembly, band):
    """Full matrix from flat band storage."""
    width, size = assembly.width, assembly.size
    rows = 3 * width + 1
    full = np.zeros((size, size))
    for j in range(size):
        for i in range(max(0, j - width), min(size, j + width + 1)):
            full[i, j] = band[j * rows + 2 * width + i - j]
    return full


def ladder(rungs: int) -> PlanarAssembly:
    """Two chords with rungs, numbered badly: one chord first, then the other."""
    where = [(0.5 * i, 0.0) for i in range(rungs)] + [(0.5 * i, 1.0) for i in range(rungs)]
    nodes = [(i, i + 1) for i in range(rungs - 1)]
    nodes += [(rungs + i, rungs + i + 1) for i in range(rungs - 1)]
    nodes += [(i, rungs + i) for i in range(rungs)]
    beams = FiberBeams(nodes, np.zeros(len(nodes), int), [rectangle()])
    return PlanarAssembly(where, [beams])


def test_renumbering_narrows_the_band():
    assembly = ladder(20)
    assert assembly.width <= 11  # 62 in the order given
    dofs = np.concatenate([assembly.dofs(range(40), name) for name in ("u", "v", "rotation")])
    assert sorted(dofs) == list(range(120))


def test_chain_keeps_its_order():
    assembly, _ = chain(np.ones(5), rectangle())
    assert assembly.width == 5
    assert assembly.dof(3, "rotation") == 11


def test_band_solution_and_product_are_those_of_the_full_matrix():
    assembly = ladder(6)
    clamp(assembly, 0)
    rng = np.random.default_rng(3)
    assembly.assemble(np.zeros(assembly.size), None)
    full = dense(assembly, assembly.band)
    x = rng.normal(size=assembly.size)
    assert assembly.tangent_times(x) == pytest.approx(full @ x, rel=1e-12)
    free = np.setdiff1d(np.arange(assembly.size), assembly.held)
    solution = assembly.solve(x)
    expected = np.linalg.solve(full[np.ix_(free, free)], x[free])
    assert solution[free] == pytest.approx(expected, rel=1e-8)
    assert np.all(solution[assembly.held] == 0.0)


def test_singular_tangent_gives_no_solution():
    assembly, _ = chain([1.0], rectangle())
    assert assembly.solve(np.ones(6)) is None


@pytest.mark.parametrize("lumped", [False, True])
def test_masses(lumped):
    section = rectangle(mass=100.0)
    assembly, _ = chain([0.5, 1.5], section, angle=0.4, lumped=lumped)
    assembly.add_mass(2, 30.0, rotary=4.0)
    full = dense(assembly, assembly.mass)
    for name in ("u", "v"):
        dofs = assembly.dofs(range(3), name)
        assert full[np.ix_(dofs, dofs)].sum() == pytest.approx(230.0)
    dofs = assembly.dofs(range(3), "rotation")
    assert full[np.ix_(dofs, dofs)].sum() == pytest.approx(200.0 * section.radius_squared + 4.0)
    assert np.allclose(full, np.diag(np.diag(full))) == lumped
    assert np.allclose(full, full.T)
    v = np.random.default_rng(1).normal(size=assembly.size)
    assert assembly.kinetic_energy(v) == pytest.approx(0.5 * v @ full @ v)


def test_consistent_mass_of_a_beam():
    assembly, _ = chain([1.2], rectangle(mass=50.0))
    full = dense(assembly, assembly.mass)
    assert full[0, 0] == pytest.approx(20.0)
    assert full[1, 4] == pytest.approx(10.0)
    assert full[0, 1] == 0.0


def test_springs_are_unstressed_where_they_are_put():
    assembly, _ = chain([1.0], rectangle())
    dof = assembly.dof(1, "u")
    shifted = np.zeros(6)
    shifted[[0, 3]] = 0.2
    assembly.assemble(shifted, None)
    assembly.commit(shifted)
    assembly.add_spring(dof, 1e6)
    # measured: round-off
    assert assembly.assemble(shifted, None)[dof] == pytest.approx(0.0, abs=1e-8)
    further = shifted + 0.1 * (np.arange(6) % 3 == 0)
    # measured: round-off
    assert assembly.assemble(further, None)[dof] == pytest.approx(1e5, rel=1e-8)
    # measured: round-off
    assert assembly.assemble(further, 0.5)[dof] == pytest.approx(0.5e5, rel=1e-8)
    # measured: round-off
    assert assembly.account(further, 0.5).stored == pytest.approx(0.5e6 * 0.01, rel=1e-8)


def test_held_dofs_can_be_released():
    assembly, _ = chain([1.0], rectangle())
    clamp(assembly, 0)
    assembly.hold([4])
    assert list(assembly.held) == [0, 1, 2, 4]
    assembly.release([1, 4])
    assert list(assembly.held) == [0, 2]


def tied_ladder() -> tuple[PlanarAssembly, list[tuple[int, int]]]:
    """The ladder with every rung on tied nodes of its own, so that its ends are pinned."""
    rungs, where = 6, [(0.5 * i, 0.5 * y) for y in (0, 2) for i in range(6)]
    ties = [(i, 12 + i) for i in range(12)]
    nodes = [(i, i + 1) for i in range(rungs - 1)]
    nodes += [(rungs + i, rungs + i + 1) for i in range(rungs - 1)]
    nodes += [(12 + i, 18 + i) for i in range(rungs)]
    beams = FiberBeams(nodes, np.zeros(len(nodes), int), [rectangle(mass=100.0)])
    return PlanarAssembly(where * 2, [beams], ties=ties), ties


def test_tied_nodes_share_translations_and_turn_by_themselves():
    assembly, ties = tied_ladder()
    for master, slave in ties:
        for name in ("u", "v"):
            assert assembly.dof(slave, name) == assembly.dof(master, name)
        assert assembly.dof(slave, "rotation") != assembly.dof(master, "rotation")
    used = {assembly.dof(i, name) for i in range(24) for name in ("u", "v", "rotation")}
    assert len(used) == 48
    unused = sorted(set(range(assembly.size)) - used)
    assert list(assembly.held) == unused
    assembly.release(range(assembly.size))
    assert list(assembly.held) == unused
    assert assembly.width <= 16


def test_tied_nodes_stay_solvable_and_have_all_the_mass():
    assembly, _ = tied_ladder()
    clamp(assembly, 0)
    rng = np.random.default_rng(4)
    x = 1e-4 * rng.normal(size=assembly.size)
    x[assembly.held] = 0.0
    force = assembly.assemble(x, None)
    full = dense(assembly, assembly.band)
    assert np.allclose(full, full.T, rtol=1e-9, atol=1e-3)
    free = np.setdiff1d(np.arange(assembly.size), assembly.held)
    solution = assembly.solve(force)
    assert solution[free] == pytest.approx(np.linalg.solve(full[np.ix_(free, free)], force[free]))
    mass = dense(assembly, assembly.mass)
    u = assembly.dofs(range(12), "u")
    assert mass[np.ix_(u, u)].sum() == pytest.approx(100.0 * (2 * 2.5 + 6 * 1.0))


def test_pinned_rungs_carry_no_moment():
    """A load on the upper chord reaches the lower one through the rungs as axial forces only."""
    assembly, _ = tied_ladder()
    for node in (0, 6):
        clamp(assembly, node)
    assembly.load[assembly.dof(11, "v")] = -100.0
    apply_loads(assembly)
    local = assembly.groups[0].local_forces
    assert np.abs(local[10:, 1:]).max() < 1e-8  # measured: round-off
    assert local[15, 0] == pytest.approx(-50.0, rel=0.04)  # measured 0.018
