"""Explicit impact driver: stability limit, collisions, ledger, agreement with the implicit one."""

from __future__ import annotations

import numpy as np
import pytest
from collision import collide
from reissner_cases import SIDE, E, G, elastic, square, straight

from workbench.base.errors import SolverError
from workbench.mechanics.structures import explicit
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.explicit import explicit_impact, stable_step
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import FiberBeams, LinearHardening
from workbench.mechanics.structures.impact import PointMass, impact

SPAN = 3.0


def clamped(elements: int, section=None, lumped: bool = True):
    """A beam clamped at both ends, and the dof in its middle."""
    assembly = straight(SPAN, elements, section or square(), lumped=lumped)
    held = ("u", "v", "rotation")
    assembly.hold([assembly.dof(node, c) for node in (0, elements) for c in held])
    return assembly, assembly.dof(elements // 2, "v")


def test_stable_step_of_a_bar_is_the_time_of_a_wave_through_an_element() -> None:
    """Axial modes of n lumped elements, one end fixed: omega_max = (2 c / h) cos(pi / 4n)."""
    elements = 8
    assembly = straight(2.0, elements, elastic(0.1), lumped=True)
    assembly.hold(range(3))
    nodes = range(elements + 1)
    assembly.hold([*assembly.dofs(nodes, "v"), *assembly.dofs(nodes, "rotation")])
    speed = np.sqrt(1.0 / 0.1**2 / 1.0)
    expected = 0.25 / speed / np.cos(np.pi / (4 * elements))
    assert stable_step(assembly) == pytest.approx(expected, rel=1e-8)  # measured: round-off


def test_stable_step_of_a_beam_is_near_that_of_its_waves() -> None:
    assembly, _ = clamped(30)
    speed = np.sqrt(E * SIDE**2 / 314.0)
    assert 0.5 < stable_step(assembly) * speed / (SPAN / 30) < 1.05


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_collision_with_a_free_node(restitution) -> None:
    assembly = straight(1.0, 1, elastic(0.1, bending=1e-4), lumped=True)
    assembly.add_mass(1, 99.5)
    dof = assembly.dof(1, "v")
    assembly.hold(np.setdiff1d(np.arange(6), [dof]))
    striker = PointMass(1500.0, 20.0, restitution)
    step = next(explicit_impact(assembly, dof, striker, [(1e-6, 1e-6)]))
    expected = collide(100.0, 1500.0, 20.0, restitution)
    assert assembly.velocity[dof] == pytest.approx(expected.struck_velocity, rel=1e-8)
    assert step.striker.velocity == pytest.approx(expected.striker_velocity, rel=1e-8)
    assert step.impulse == pytest.approx(expected.percussion, rel=1e-8)
    assert step.contact_loss == pytest.approx(expected.energy_loss, abs=1e-5)


def run(driver, assembly, dof, striker, interval, *more) -> tuple[float, float]:
    """Largest displacement of the hit dof, and largest error of the balance."""
    peak = worst = spent = 0.0
    brought = striker.kinetic_energy
    for step in driver(assembly, dof, striker, [(0.025, interval)], *more):
        energies = step.energies
        spent += energies.plastic + energies.algorithmic + step.contact_loss - step.external_work
        total = step.kinetic + step.striker.kinetic_energy + energies.stored + spent
        worst = max(worst, abs(total - brought) / brought)
        peak = max(peak, float(assembly.displacement[dof]))
    return peak, worst


@pytest.mark.thorough
@pytest.mark.parametrize("restitution", [0.0, 0.7])
def test_both_integrators_agree_and_balance(restitution) -> None:
    striker = PointMass(5000.0, 5.0, restitution)
    exact, error = run(explicit_impact, *clamped(24), striker, 1e-4)
    assert error < 4.1e-7  # measured 2.0e-7
    # steps as short as the explicit ones: the implicit scheme damps what they do not resolve
    implicit, error = run(impact, *clamped(24), striker, 1e-5, 0.55)
    assert error < 1e-8
    assert implicit == pytest.approx(exact, rel=6e-3)


def test_order_of_the_explicit_scheme_is_two_without_contact() -> None:
    """Elastic vibration from an initial velocity; the striker stays away."""
    away = PointMass(1.0, 0.0, position=-1e9)
    ends = []
    for cut in (4.0, 8.0, 16.0, 32.0):
        assembly, dof = clamped(6, elastic(0.3))
        at = assembly.coordinates[:, 0] / SPAN
        assembly.velocity[assembly.dofs(range(7), "v")] = 0.3 * np.sin(np.pi * at) ** 2
        step = 0.9 * stable_step(assembly) / cut
        list(explicit_impact(assembly, dof, away, [(1.0, 1.0)], step))
        ends.append(float(assembly.displacement[dof]))
    change = np.abs(np.diff(ends))
    # measured 0.0085
    np.testing.assert_allclose(np.log2(change[:-1] / change[1:]), 2.0, atol=0.017)
    assert change[-1] < 2e-3 * abs(ends[-1])


def test_groups_without_a_force_only_path_work_too() -> None:
    """Co-rotational beams in the explicit driver agree with those in the implicit one."""
    y = (np.arange(10) - 4.5) / 10 * SIDE
    law = LinearHardening(E, 355e6, 1e-6 * E)
    section = BeamSection(y, np.full(10, SIDE**2 / 10), law, 314.0, G * SIDE**2)
    nodes = np.stack([np.arange(24), np.arange(1, 25)], axis=1)
    x = np.linspace(0.0, SPAN, 25)
    peaks = []
    for driver, more in ((explicit_impact, (1e-4,)), (impact, (1e-5, 0.55))):
        beams = FiberBeams(nodes, np.zeros(24, dtype=np.int64), [section])
        assembly = PlanarAssembly(np.stack([x, 0.0 * x], axis=1), [beams], lumped=True)
        held = ("u", "v", "rotation")
        assembly.hold([assembly.dof(node, c) for node in (0, 24) for c in held])
        peak, error = run(driver, assembly, assembly.dof(12, "v"), PointMass(5000.0, 5.0), *more)
        assert error < 3.4e-7  # measured 1.7e-7
        peaks.append(peak)
    assert peaks[1] == pytest.approx(peaks[0], rel=1.3e-3)  # measured 6.4e-4


def test_steps_never_exceed_the_stability_limit() -> None:
    assembly, dof = clamped(12)
    limit = stable_step(assembly)
    striker = PointMass(500.0, 15.0)
    first = next(explicit_impact(assembly, dof, striker, [(1e-2, 1e-3)], step=1.0))
    assert first.length / first.evaluations <= explicit.SAFETY * limit * (1.0 + 1e-12)


def test_a_lost_balance_is_reported(monkeypatch) -> None:
    monkeypatch.setattr(explicit, "SAFETY", 3.0)
    assembly, dof = clamped(12, elastic(0.1, bending=1e6))
    with pytest.raises(SolverError, match="balance is lost"):
        list(explicit_impact(assembly, dof, PointMass(500.0, 15.0), [(1e-2, 1e-4)]))


def test_consistent_mass_is_refused() -> None:
    assembly, dof = clamped(12, lumped=False)
    with pytest.raises(ValueError, match="lumped"):
        next(explicit_impact(assembly, dof, PointMass(500.0, 15.0), [(1e-2, 1e-4)]))


def test_records_of_too_many_steps_are_refused_at_once() -> None:
    assembly, dof = clamped(8)
    steps = explicit_impact(assembly, dof, PointMass(1500.0, 20.0), [(1e4, 1.0)])
    with pytest.raises(SolverError, match=r"time 0 s.*tried 2000000 of .* steps"):
        next(steps)
