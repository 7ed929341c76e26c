"""The fiber element: tangents, energy identity, invariance, return mapping."""

import numpy as np
import pytest
from assembly_cases import full_tangent, random_state
from beam_cases import E_STEEL, KINDS, YIELD, chain, clamp, of_kind, rectangle
from builders import examples
from hypothesis import given
from hypothesis import strategies as st
from section_cases import response

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import (
    FiberBeams,
    LinearHardening,
    gauss_rule,
    radau_rule,
)
from workbench.mechanics.structures.paths import apply_loads, push

SCALE = np.array([1e-3, 1e-3, 6e-3])  # displacements (m) and rotations that make fibers yield


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("weight", [None, 0.5, 0.55, 1.0])
def test_tangent_by_finite_differences(kind, weight):
    rng = np.random.default_rng(5)
    for _ in range(4):
        # hardening makes fibers move off the kink between elastic and plastic
        assembly, _ = of_kind(kind, [0.4, 0.7], hardening=0.02 * E_STEEL)
        x = random_state(assembly, rng, SCALE)
        assembly.assemble(x, weight)
        exact = full_tangent(assembly)
        scale = np.abs(exact).max()
        errors = []
        for j in range(assembly.size):
            step = np.zeros(assembly.size)
            step[j] = 1e-8
            change = assembly.assemble(x + step, weight) - assembly.assemble(x - step, weight)
            errors.append(np.abs(change / 2e-8 - exact[:, j]).max() / scale)
        assert max(errors) < 1e-8  # next to kinks; elsewhere; measured 3.4e-9
        assert np.median(errors) < 1e-8  # measured 9.4e-11


@pytest.mark.parametrize("kind", KINDS)
@examples(60)
@given(
    seed=st.integers(0, 10_000),
    weight=st.sampled_from([0.5, 0.55, 0.8, 1.0]),
    size=st.sampled_from([0.1, 1.0, 30.0]),
)
def test_work_of_the_step_is_stored_or_dissipated(kind, seed, weight, size):
    rng = np.random.default_rng(seed)
    assembly, _ = of_kind(kind, [0.5, 0.3, 0.6])
    end = random_state(assembly, rng, size * SCALE)
    start = assembly.displacement.copy()
    assembly.assemble(start, weight)
    stored = assembly.account(start, weight).stored
    force = assembly.assemble(end, weight)
    taken = assembly.account(end, weight)
    work = force @ (end - start)
    scale = abs(work) + stored + taken.stored + taken.plastic
    assert work == pytest.approx(
        taken.stored - stored + taken.plastic + taken.algorithmic, abs=1e-11 * scale
    )
    assert taken.plastic >= -1e-12 * scale
    assert taken.algorithmic >= 0.0
    assert taken.plastic <= taken.ideal * (1 + 1e-9) + 1e-12 * scale


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_motion_leaves_forces_alone(kind):
    rng = np.random.default_rng(2)
    assembly, beams = of_kind(kind, [0.5, 0.8])
    x = random_state(assembly, rng, SCALE)
    forces = assembly.assemble(x, None).reshape(-1, 3)
    assembly.commit(x)
    local = beams.local_forces.copy()
    turn, shift = 2.3, np.array([4.0, -1.0])
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    moved = x.reshape(-1, 3).copy()
    where = assembly.coordinates + moved[:, :2]
    moved[:, :2] = where @ spin.T + shift - assembly.coordinates
    moved[:, 2] += turn
    turned = assembly.assemble(moved.ravel(), None).reshape(-1, 3)
    assembly.commit(moved.ravel())
    assert beams.local_forces == pytest.approx(local, rel=1e-9, abs=1e-4)
    assert turned[:, :2] == pytest.approx(forces[:, :2] @ spin.T, rel=1e-8, abs=1e-3)
    assert turned[:, 2] == pytest.approx(forces[:, 2], rel=1e-8, abs=1e-3)


def test_turned_structure_gives_turned_forces():
    straight, _ = chain([0.5, 0.7], rectangle())
    turned, _ = chain([0.5, 0.7], rectangle(), angle=1.2)
    x = np.random.default_rng(8).normal(size=(3, 3)) * SCALE
    spin = np.array([[np.cos(1.2), -np.sin(1.2)], [np.sin(1.2), np.cos(1.2)]])
    y = np.concatenate([x[:, :2] @ spin.T, x[:, 2:]], axis=1)
    f = straight.assemble(x.ravel(), None).reshape(3, 3)
    g = turned.assemble(y.ravel(), None).reshape(3, 3)
    assert g[:, :2] == pytest.approx(f[:, :2] @ spin.T, rel=1e-8, abs=1e-3)


def test_section_response_at_first_and_full_yield():
    section, rest = rectangle(layers=40, hardening=0.0), np.zeros((2, 40))
    (n, _, m, c0, _, _, _, _, c2), new = response(section, 0.0, 1e-3, rest)
    assert n == pytest.approx(0.0, abs=1e-8)  # measured 1.8e-11
    assert m == pytest.approx(E_STEEL * np.sum(section.y**2 * section.area) * 1e-3)
    assert c0 == pytest.approx(E_STEEL * 0.04)
    assert m / 1e-3 == pytest.approx(c2)
    assert not new.any()
    (n, _, m, *_), _ = response(section, 0.0, 1e3, rest)
    assert m == pytest.approx(YIELD * 0.2**3 / 4.0, rel=1e-9)  # even layers: no loss
    # M = Mp (1 - n^2) where the neutral axis shifts by n h / 2
    (n, _, m, *_), _ = response(section, 0.02 * 1e3, 1e3, rest)
    assert n / (YIELD * 0.04) == pytest.approx(0.2)
    assert m == pytest.approx(YIELD * 0.002 * (1 - 0.2**2), rel=1e-9)


def test_return_mapping_starts_from_the_committed_state():
    hardening = 0.01 * E_STEEL
    fiber = BeamSection(np.zeros(1), np.ones(1), LinearHardening(E_STEEL, YIELD, hardening), 0.0)
    old = np.array([[0.004], [0.0]])
    (n, _, _, c0, *_), new = response(fiber, 0.010, 0.0, old)
    trial = E_STEEL * 0.006 - hardening * 0.004
    flow = (trial - YIELD) / (E_STEEL + hardening)
    assert new[0] == pytest.approx(0.004 + flow)
    assert n == pytest.approx(E_STEEL * (0.010 - new[0, 0]))
    assert n == pytest.approx(YIELD + hardening * new[0, 0])
    assert c0 == pytest.approx(E_STEEL * hardening / (E_STEEL + hardening))
    assert old[0, 0] == 0.004


@pytest.mark.parametrize("rule", [gauss_rule(3), radau_rule([False, True, False])])
def test_rules_integrate_the_elastic_stiffness(rule):
    for power, exact in enumerate((1.0, 1.0 / 2.0, 1.0 / 3.0)):
        assert np.sum(rule.weights * rule.xi**power, axis=-1) == pytest.approx(exact)


def test_balanced_elements_have_one_axial_force():
    """At the sampled end N and M lie on the exact curve; linear axial displacement oversteps it."""
    over = {}
    for kind, end in (("balanced", False), ("interpolated", True)):
        section = rectangle(layers=200, hardening=1e-8 * E_STEEL)
        rule = radau_rule([False])  # M1 is the moment of the section at end 1
        beams = FiberBeams([[0, 1]], [0], [section], rule, balanced=not end)
        assembly = PlanarAssembly([[0.0, 0.0], [0.5, 0.0]], [beams])
        clamp(assembly, 0)
        assembly.hold([assembly.dof(1, "rotation")])
        assembly.load[assembly.dof(1, "u")] = -0.4 * YIELD * 0.04
        apply_loads(assembly)
        for _ in push(assembly, assembly.dof(1, "v"), np.linspace(0.0, 0.02, 21)[1:]):
            pass
        force, moment, _ = np.abs(beams.local_forces[0]) / YIELD / [0.04, 0.002, 0.002]
        over[kind] = moment / (1.0 - force**2) - 1.0
    assert over["balanced"] == pytest.approx(0.0, abs=1e-3)
    assert over["interpolated"] > 0.01
    with pytest.raises(ValueError, match="two points"):
        FiberBeams([[0, 1]], [0], [rectangle()], gauss_rule(3), balanced=True)


def test_sections_of_different_kind_in_one_group():
    slim, stout = rectangle(layers=10, height=0.1, mass=50.0), rectangle(layers=30)
    mixed = FiberBeams([[0, 1], [1, 2]], [0, 1], [slim, stout])
    assembly = PlanarAssembly([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [mixed])
    stretch = np.array([0.0, 0, 0, 1e-4, 0, 0, 3e-4, 0, 0])
    force = assembly.assemble(stretch, None)
    assert force[0] == pytest.approx(-E_STEEL * 0.02 * 1e-4, rel=1e-8)  # measured 1.1e-13
    assert force[6] == pytest.approx(E_STEEL * 0.04 * 2e-4, rel=1e-8)  # measured 1.1e-13
    assert mixed.masses()[0] == pytest.approx([50.0, 314.0])
