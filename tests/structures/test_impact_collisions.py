"""The impact driver: closed forms of collisions, orders, ledgers, direction of the strike."""

from __future__ import annotations

import numpy as np
import pytest
import superelement_cases
from collision import collide
from frame_cases import bar, portal
from hypothesis import given
from hypothesis import strategies as st
from reissner_cases import elastic, straight
from scipy.optimize import brentq
from test_impact_driver import clamped_column

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import LinearHardening, ReissnerBeams
from workbench.mechanics.structures.impact import PointMass, TimeStep, impact
from workbench.mechanics.structures.paths import apply_loads

STIFFNESS = 210e9 * 1e-3 / 2.0  # of the bar, N/m


def free_node(mass: float) -> tuple[PlanarAssembly, int]:
    """A node that only moves across a beam without stiffness or mass to speak of."""
    law = LinearHardening(1e-6, 1e30)
    section = BeamSection(np.array([-0.1, 0.1]), np.full(2, 1e-6), law, 1e-12, 1e-9)
    group = ReissnerBeams([[0, 1]], np.zeros(1, dtype=np.int64), [section])
    beam = PlanarAssembly([[0.0, 0.0], [1.0, 0.0]], [group])
    beam.hold([0, 1, 2, 3, 5])
    beam.add_mass(1, mass)
    return beam, beam.dof(1, "v")


def on_spring(mass: float = 1000.0) -> tuple[PlanarAssembly, int, float]:
    """A mass on an elastic bar: assembly, dof, circular frequency."""
    rod, dof = bar(2.1e9)  # yields far beyond what the tests ask of it
    rod.add_mass(1, mass)
    value = float(rod.mass_times(np.eye(rod.size)[dof])[dof])
    return rod, dof, float(np.sqrt(STIFFNESS / value))


def ledger(steps: list[TimeStep], begin: float) -> np.ndarray:
    """Error of the energy balance after each step, in J; `begin` is the energy at the start."""
    spent = np.cumsum(
        [
            s.energies.plastic + s.energies.algorithmic + s.contact_loss - s.external_work
            for s in steps
        ]
    )
    held = np.array([s.kinetic + s.striker.kinetic_energy + s.energies.stored for s in steps])
    return np.asarray(held + spent - begin)


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_collision_of_two_masses(sign, restitution) -> None:
    beam, dof = free_node(100.0)
    striker = PointMass(1500.0, 20.0, restitution)
    steps = list(impact(beam, dof, striker, [(5e-4, 1e-4)], 0.5, sign=sign))
    expected = collide(100.0, 1500.0, 20.0, restitution)
    assert sign * beam.velocity[dof] == pytest.approx(expected.struck_velocity, rel=1e-8)
    assert steps[-1].striker.velocity == pytest.approx(expected.striker_velocity, rel=1e-8)
    assert steps[0].impulse == pytest.approx(expected.percussion, rel=1e-8)
    assert steps[0].contact_loss == pytest.approx(expected.energy_loss, rel=1e-8, abs=1e-5)
    assert np.max(np.abs(ledger(steps, striker.kinetic_energy))) <= 1e-9 * striker.kinetic_energy
    gap = sign * beam.displacement[dof] - steps[-1].striker.position
    assert gap == pytest.approx(restitution * 20.0 * 4.5e-4 - 0.5e-4 * 20.0, abs=1e-12)


@given(
    st.floats(1.0, 1e4),
    st.floats(1.0, 1e4),
    st.floats(0.1, 50.0),
    st.floats(0.0, 1.0),
    st.sampled_from([-1.0, 1.0]),
    st.floats(0.0, 5e-3),
)
def test_momentum_and_dissipation(mass, struck, speed, restitution, sign, distance) -> None:
    """Whatever the masses and wherever in a step they meet."""
    beam, dof = free_node(struck)
    striker = PointMass(mass, speed, restitution, -distance)
    # long enough to meet: the last of the steps ends after the contact
    span = [(distance / speed + 3e-3, 1e-3)]
    steps = list(impact(beam, dof, striker, span, 0.5, sign=sign))
    momentum = mass * steps[-1].striker.velocity + struck * sign * float(beam.velocity[dof])
    assert momentum == pytest.approx(mass * speed, rel=1e-8)  # measured 3.4e-13
    assert min(s.contact_loss for s in steps) >= -1e-14 * striker.kinetic_energy  # round-off
    assert min(s.impulse for s in steps) >= 0.0
    expected = collide(struck, mass, speed, restitution)
    loss = sum(s.contact_loss for s in steps)
    assert loss == pytest.approx(expected.energy_loss, rel=1e-6, abs=1e-6 * mass * speed**2)
    assert np.max(np.abs(ledger(steps, striker.kinetic_energy))) <= 1e-7 * striker.kinetic_energy


def test_equal_masses_exchange_their_velocities_twice() -> None:
    """The striker stops, the mass swings half a period on its spring and sends it back."""
    errors = []
    for count in (100, 200, 400):
        rod, dof, omega = on_spring()
        mass = STIFFNESS / omega**2
        striker = PointMass(mass, 0.1, 1.0)
        period = 2 * np.pi / omega
        steps = list(impact(rod, dof, striker, [(0.7 * period, period / count)], 0.5))
        rebounds = [s.time for s in steps if s.impulse > 0.0]
        assert len(rebounds) == 2
        assert rebounds[1] == pytest.approx(0.5 * period, abs=2.1 * period / count)
        assert abs(np.max(np.abs(ledger(steps, striker.kinetic_energy)))) <= 1e-9
        errors.append(steps[-1].striker.velocity + 0.1)
    # the second meeting falls somewhere into a step
    assert np.max(np.abs(errors)) <= 0.1 * 2 * np.pi / 100
    assert abs(errors[-1]) <= 0.1 * 2 * np.pi / 400


def event_driven(
    given: float, omega: float, striker: PointMass, duration: float
) -> tuple[float, float, int]:
    """Exact motion from hit to hit: end velocities of striker and mass, number of hits."""
    x, v = 0.0, 0.0
    at, speed = 0.0, striker.velocity
    time, hits = 0.0, 0
    while True:
        approach = v - speed
        impulse = (1.0 + striker.restitution) * -approach / (1.0 / given + 1.0 / striker.mass)
        v, speed, hits = v + impulse / given, speed - impulse / striker.mass, hits + 1
        amplitude, phase = np.hypot(x, v / omega), np.arctan2(x, v / omega)

        def gap(t, amplitude=amplitude, phase=phase, at=at, speed=speed):
            return amplitude * np.sin(omega * t + phase) - at - speed * t

        grid = np.linspace(1e-6, duration - time, 20_001)
        below = np.flatnonzero(gap(grid) < 0.0)
        end = duration - time
        if below.size:
            low = grid[below[0] - 1] if below[0] else 0.0
            end = brentq(gap, low, grid[below[0]], xtol=1e-15)
        x = amplitude * np.sin(omega * end + phase)
        v = amplitude * omega * np.cos(omega * end + phase)
        at += speed * end
        time += end
        if not below.size:
            return float(speed), float(v), hits


def test_repeated_impacts_converge_to_the_motion_from_hit_to_hit() -> None:
    """A striker bounces three times on an equal mass on a spring, restitution 1/2."""
    rod, dof, omega = on_spring()
    mass = STIFFNESS / omega**2
    striker = PointMass(mass, 0.1, 0.5)
    duration = 1.1 * 2 * np.pi / omega
    speed, _, hits = event_driven(mass, omega, striker, duration)
    assert hits == 3
    for count in (200, 800, 3200):
        rod, dof, omega = on_spring()
        steps = list(impact(rod, dof, striker, [(duration, duration / count)], 0.5))
        losses = [s.contact_loss for s in steps]
        assert min(losses) >= 0.0
        assert min(s.impulse for s in steps) >= 0.0
        assert np.max(np.abs(ledger(steps, striker.kinetic_energy))) <= 1e-9
        # of first order: where in a step they meet is not resolved
        assert abs(steps[-1].striker.velocity - speed) < 0.1 * omega * duration / count


def test_order_two_while_the_contact_stays_closed() -> None:
    """Striker and mass move as one on the spring, x = V / W sin W t, until the turning point."""
    errors = []
    for count in (10, 20, 40, 80):
        rod, dof, omega = on_spring()
        mass = STIFFNESS / omega**2
        rod.velocity[dof] = 0.1
        striker = PointMass(2.0 * mass, 0.1)
        joint = omega / np.sqrt(3.0)
        span = 0.4 * np.pi / joint
        *_, last = impact(rod, dof, striker, [(span, span / count)], 0.5, tolerance=1e-12)
        exact = 0.1 / joint * np.sin(0.4 * np.pi)
        errors.append(float(rod.displacement[dof]) - exact)
        assert last.contact_loss == pytest.approx(0.0, abs=1e-12)
    assert orders(errors) == pytest.approx(2.0, abs=0.05)


def test_order_after_a_plastic_collision_at_the_start() -> None:
    """Velocity constraints lose half a step at the jump."""
    errors = []
    for count in (20, 40, 80, 160):
        rod, dof, omega = on_spring()
        mass = STIFFNESS / omega**2
        striker = PointMass(2.0 * mass, 0.1)
        joint = omega / np.sqrt(3.0)
        span = 0.4 * np.pi / joint
        list(impact(rod, dof, striker, [(span, span / count)], 0.5))
        exact = 0.2 / 3.0 / joint * np.sin(0.4 * np.pi)
        errors.append(float(rod.displacement[dof]) - exact)
    assert orders(errors) == pytest.approx(1.0, abs=0.15)


def test_order_two_without_contact() -> None:
    """A cantilever with heavy nodes swings far out: its tip turns by more than 1 rad."""
    away = PointMass(1.0, 0.0, position=-1e9)
    ends = []
    for count in (50, 100, 200, 400):
        beam = straight(1.0, 2, elastic(0.1))
        beam.hold(range(3))
        for node in (1, 2):
            beam.add_mass(node, 5.0, 0.5)
        tip = beam.dof(2, "v")
        beam.velocity[tip] = 0.7
        span = [(2.0, 2.0 / count)]
        list(impact(beam, tip, away, span, 0.5, 1e-11))
        ends.append(float(beam.displacement[tip]))
    assert abs(beam.displacement[beam.dof(2, "rotation")]) > 1.0
    assert orders(list(np.diff(ends))) == pytest.approx(2.0, abs=0.1)


def hit_column(step: float, restitution: float) -> tuple[float, float, float]:
    """Peak, relative ledger error and largest overlap of an elastic-plastic column."""
    column, dof = clamped_column(0.5, lumped=False)
    striker = PointMass(1500.0, 8.0, restitution)
    steps, at, gaps = [], [], []
    for taken in impact(column, dof, striker, [(0.02, step)], 0.5):
        steps.append(taken)
        at.append(float(column.displacement[dof]))
        gaps.append(at[-1] - taken.striker.position)
    assert min(s.energies.plastic for s in steps) >= 0.0
    assert min(s.contact_loss for s in steps) >= -1e-9 * striker.kinetic_energy
    error = np.max(np.abs(ledger(steps, striker.kinetic_energy))) / striker.kinetic_energy
    return max(at), float(error), -min(gaps)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_column_keeps_its_energy_at_every_step(restitution) -> None:
    fine, coarse = (hit_column(step, restitution) for step in (2e-5, 1e-4))
    assert coarse[0] == pytest.approx(fine[0], rel=0.02)
    assert coarse[1] < 1e-8
    assert coarse[2] > 3e-4  # half a step of the strike, 4e-4 m


def struck_portal(step: float, mirrored: bool = False) -> np.ndarray:
    """History of the struck knee, along the strike; from the right if mirrored."""
    frame, names = portal(2)
    frame.load[frame.dof(names["crown"], "v")] = -1e5
    apply_loads(frame)
    knee, sign = ("knee-right", -1.0) if mirrored else ("knee-left", 1.0)
    dof = frame.dof(names[knee], "u")
    start = float(frame.displacement[dof])
    assert abs(start) > 1e-6  # the dead load spreads the knees; the strike begins where they are
    striker = PointMass(4000.0, 12.0)
    at = []
    record = impact(frame, dof, striker, [(0.12, step)], 0.5, sign=sign)
    for taken in record:
        if not at:
            assert taken.impulse > 0.0
        at.append(sign * (float(frame.displacement[dof]) - start))
    return np.array(at)


def test_a_strike_from_the_other_side_is_the_mirror_image() -> None:
    left, right = (struck_portal(1e-3, mirrored) for mirrored in (False, True))
    np.testing.assert_allclose(right, left, rtol=0.0, atol=1.1e-8 * left.max())  # measured 5.3e-9


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_explicit_strike_along_the_negative_direction(sign) -> None:
    ends = []
    for driver, more in ((explicit_impact, (5e-5,)), (impact, (0.5,))):
        frame, names = portal(2, lumped=True)
        frame.add_mass(names["knee-left"], 0.0, 10.0)
        dof = frame.dof(names["crown"], "v")
        step = 1e-4 if driver is explicit_impact else 2e-5
        *_, last = driver(frame, dof, PointMass(500.0, 8.0), [(0.02, step)], *more, sign=sign)
        ends.append((sign * float(frame.displacement[dof]), last.striker.velocity))
    assert ends[0][0] > 0.02
    assert ends[0][0] == pytest.approx(ends[1][0], rel=1.3e-3)  # measured 6.4e-4
    assert ends[0][1] == pytest.approx(ends[1][1], abs=0.09)  # measured 0.044


@pytest.mark.thorough
def test_the_ledger_closes_over_ten_thousand_steps() -> None:
    """A striker bounces on a yielding cantilever: 1e-6 of the impact energy, to the end."""
    law = LinearHardening(210e9, 355e6, 1e-6 * 210e9)
    depth = 0.2 * ((np.arange(6) + 0.5) / 6 - 0.5)
    section = BeamSection(depth, np.full(6, 0.04 / 6), law, 314.0, 2.7e9)
    group = ReissnerBeams([[0, 1], [1, 2]], np.zeros(2, dtype=np.int64), [section])
    beam = PlanarAssembly([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [group])
    beam.hold(range(3))
    beam.add_mass(2, 300.0)
    tip = beam.dof(2, "v")
    beam.load[tip] = -5e4  # towards the striker, again and again
    apply_loads(beam)
    begin = beam.stored
    striker = PointMass(1000.0, 12.0, 0.6)
    brought = striker.kinetic_energy
    steps = list(impact(beam, tip, striker, [(1.0, 1e-4)], 0.5))
    assert len(steps) >= 10_000
    assert sum(s.impulse > 0.0 for s in steps) >= 8
    assert sum(s.energies.plastic for s in steps) > 0.3 * brought
    assert np.max(np.abs(ledger(steps, brought + begin))) <= 1e-6 * brought
    assert min(s.energies.plastic for s in steps) >= 0.0
    assert min(s.contact_loss for s in steps) >= -1e-9 * brought


def rigid_bars(inertia: str) -> tuple[PlanarAssembly, int]:
    """Four rigid superelements in a row, clamped at both ends, with some inertia at the joints."""
    column, _ = superelement_cases.chain([1.0] * 4, mass=71.4, inertia=inertia)
    column.hold([column.dof(node, c) for node in (0, 4) for c in ("u", "v", "rotation")])
    for node in range(5):
        column.add_mass(node, 0.0, 0.1)
    return column, column.dof(1, "v")


@pytest.mark.parametrize("inertia", ["none", "linear", "nonlinear"])
def test_rigid_superelements(inertia) -> None:
    """Rotary inertia that turns with the bars keeps velocities of its own."""
    column, dof = rigid_bars(inertia)
    striker = PointMass(500.0, 10.0)
    steps = list(impact(column, dof, striker, [(0.02, 1e-4)], 0.5))
    error = np.max(np.abs(ledger(steps, striker.kinetic_energy))) / striker.kinetic_energy
    assert error < 1e-8
    reference, dof = rigid_bars(inertia)
    list(impact(reference, dof, striker, [(0.02, 2e-5)], 0.5))
    assert column.displacement[dof] == pytest.approx(reference.displacement[dof], rel=0.03)
