"""Ground motion against closed forms, exact recurrence, the moving frame of reference, balances."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from frame_cases import bar, portal
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from workbench.base.errors import SolverError
from workbench.mechanics.structures import impact
from workbench.mechanics.structures.impact import TimeStep, follow_force, rigid_displacement
from workbench.mechanics.structures.paths import apply_loads
from workbench.scenarios.pulse import line_integral

STIFFNESS = 210e9 * 1e-3 / 2.0  # of the bar, N/m


def oscillator(mass: float = 1000.0, hardening: float = 0.0):
    """A mass on the bar: assembly, dof, circular frequency."""
    rod, dof = bar(hardening)
    rod.add_mass(1, mass)
    value = float(rod.mass_times(np.eye(rod.size)[dof])[dof])
    return rod, dof, np.sqrt(STIFFNESS / value)


def ground_motion(assembly, axis, samples, interval, spans, weight, damping=0.0, **options):
    """Steps on ground that moves along an axis, with these accelerations (m/s2)."""
    velocity = line_integral(interval * np.arange(len(samples)), samples)

    def mean(begin, end):
        return float(velocity(end) - velocity(begin)) / (end - begin)

    driven = assembly.mass_times(rigid_displacement(assembly, axis))
    return follow_force(assembly, -driven, mean, spans, weight, damping, **options)


def follow(rod, dof, samples, interval, duration, step, damping=0.0):
    """Times, relative displacements and steps of a motion along x."""
    time, at, steps = [0.0], [float(rod.displacement[dof])], []
    for taken in ground_motion(
        rod, "x", samples, interval, [(duration, step)], 0.5, damping, tolerance=1e-11
    ):
        time.append(taken.time)
        at.append(float(rod.displacement[dof]))
        steps.append(taken)
    return np.array(time), np.array(at), steps


def balance(steps: list[TimeStep], start: float = 0.0, kinetic: float = 0.0) -> float:
    """Largest error of the ledger over the largest input energy so far."""
    given = np.cumsum([s.input_energy + s.external_work for s in steps])
    gone = np.cumsum([s.energies.plastic + s.energies.algorithmic + s.damped for s in steps])
    held = np.array([s.energies.stored + s.kinetic for s in steps]) - start - kinetic
    scale = np.max(np.abs(np.cumsum([s.input_energy for s in steps])))
    return float(np.max(np.abs(given - gone - held)) / scale)


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@pytest.mark.parametrize("damping", [0.0, 0.2])
def test_a_random_record_against_its_exact_recurrence(damping) -> None:
    """Piecewise linear ground acceleration (Nigam and Jennings 1969); order 2 in the time step."""
    _, _, omega = oscillator()
    interval = 2 * np.pi / omega / 12
    samples = np.random.default_rng(1).normal(size=40)
    rate = damping * omega
    matrix = np.array([[0, 1, 0, 0], [-(omega**2), -rate, -1, 0], [0, 0, 0, 1], [0, 0, 0, 0.0]])
    state, exact = np.zeros(2), [0.0]
    for left, right in pairwise(samples):
        state = (expm(matrix * interval) @ [*state, left, (right - left) / interval])[:2]
        exact.append(float(state[0]))
    errors = []
    for cut in (2, 4, 8, 16):
        rod, dof, _ = oscillator()
        _, at, steps = follow(rod, dof, samples, interval, 39 * interval, interval / cut, rate)
        errors.append(float(np.max(np.abs(at[::cut] - exact)) / np.max(np.abs(exact))))
        assert balance(steps) < 1e-9
    assert orders(errors) == pytest.approx(2.0, abs=0.05)
    assert errors[-1] < 1e-3


def test_a_step_of_the_ground_acceleration() -> None:
    """x = -(a / w2) (1 - cos wt) while it lasts, a free vibration from there afterwards."""
    _, _, omega = oscillator()
    period = 2 * np.pi / omega
    errors = []
    for count in (40, 80, 160, 320):
        rod, dof, _ = oscillator()
        # 101 equal samples: the acceleration drops to zero after 0.7 periods
        time, at, steps = follow(
            rod, dof, np.full(101, 2.0), 0.007 * period, period, period / count
        )
        exact = -2.0 / omega**2 * (1.0 - np.cos(omega * time))
        exact += 2.0 / omega**2 * (1.0 - np.cos(omega * np.maximum(time - 0.7 * period, 0.0)))
        errors.append(float(np.max(np.abs(at - exact))) * omega**2 / 2.0)
        assert balance(steps) < 1e-9
        assert steps[-1].input_energy == 0.0
    assert orders(errors) == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 3.4e-4  # measured 1.7e-4


@pytest.mark.parametrize("ratio", [0.5, 1.7])
def test_a_half_sine_of_the_ground_acceleration(ratio) -> None:
    """Duhamel's integral of a half sine that lasts `ratio` half periods, and what follows."""
    _, _, omega = oscillator()
    forcing = omega / ratio
    end = np.pi / forcing

    def exact(time):
        def sine(t):
            share = forcing / omega
            return np.where(
                t > 0.0, (np.sin(forcing * t) - share * np.sin(omega * t)) / (1 - share**2), 0.0
            )

        return -3.0 / omega**2 * (sine(time) + sine(time - end))

    errors = []
    for count in (25, 50, 100, 200):
        rod, dof, _ = oscillator()
        samples = 3.0 * np.sin(np.pi * np.arange(count + 1) / count)
        time, at, steps = follow(rod, dof, samples, end / count, 2 * end, end / count)
        errors.append(float(np.max(np.abs(at - exact(time)))) * omega**2 / 3.0)
        assert balance(steps) < 1e-9
    assert orders(errors) == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 1e-3


def test_free_vibration_decays_with_mass_proportional_damping() -> None:
    """x = v / w_d exp(-c t / 2) sin w_d t with the ground at rest."""
    rod, dof, omega = oscillator()
    rod.velocity[dof] = 0.1
    rate = 0.1 * omega
    damped = np.sqrt(omega**2 - 0.25 * rate**2)
    period = 2 * np.pi / damped
    kinetic = rod.kinetic_energy()
    lost = 0.0
    for step in ground_motion(rod, "x", [0.0, 0.0], 1.0, [(3 * period, period / 400)], 0.5, rate):
        exact = 0.1 / damped * np.exp(-0.5 * rate * step.time) * np.sin(damped * step.time)
        assert float(rod.displacement[dof]) == pytest.approx(exact, abs=2e-3 * 0.1 / damped)
        assert step.damped >= 0.0
        lost += step.damped
    assert lost + step.kinetic + step.energies.stored == pytest.approx(kinetic, rel=1e-10)


def test_a_yielding_oscillator_follows_an_independent_integration() -> None:
    """Elastic, perfectly plastic: central differences with a thousand steps a period."""
    rod, dof, omega = oscillator()
    period = 2 * np.pi / omega
    interval, strength = period / 20, 355e3
    samples = 6.0 * strength / 1000.0 * np.random.default_rng(3).uniform(-1.0, 1.0, 60)
    time, at, steps = follow(rod, dof, samples, interval, 60 * interval, period / 200)
    fine = period / 4000
    mass = STIFFNESS / omega**2
    x = v = force = 0.0
    seen = []
    for i in range(60 * 200):
        a = float(np.interp(i * fine, np.arange(60) * interval, samples, right=0.0))
        v += fine * (-a - force / mass) * (0.5 if i == 0 else 1.0)
        x += fine * v
        force = float(np.clip(force + STIFFNESS * fine * v, -strength, strength))
        seen.append(x)
    expected = np.interp(time, fine * (1 + np.arange(len(seen))), seen)
    largest = np.max(np.abs(expected))
    assert largest > 3.0 * strength / STIFFNESS
    np.testing.assert_allclose(at, expected, rtol=0.0, atol=9e-4 * largest)  # measured 4.6e-4
    assert min(s.energies.plastic for s in steps) >= 0.0
    assert balance(steps) < 1e-9


def test_a_portal_with_dead_loads_balances_and_drifts() -> None:
    """Plastic frame, damping and weight 0.55: every term of the ledger takes part."""
    frame, names = portal(3)
    frame.load[frame.dof(names["crown"], "v")] = -3e5
    frame.add_mass(names["crown"], 3e4)
    apply_loads(frame)
    start = frame.stored
    samples = 12.0 * np.sin(2 * np.pi * np.arange(101) / 50)
    steps = list(ground_motion(frame, "x", samples, 0.02, [(2.5, 5e-3)], 0.55, 0.5))
    assert balance(steps, start) < 1e-8
    assert sum(s.energies.plastic for s in steps) > 0.1 * sum(s.input_energy for s in steps)
    assert min(s.energies.plastic for s in steps) >= 0.0
    assert min(s.damped for s in steps) >= 0.0
    assert min(s.energies.algorithmic for s in steps) >= 0.0
    assert sum(s.external_work for s in steps) != 0.0
    assert steps[-1].time == pytest.approx(2.5)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_ground_moves_with_the_supports(axis) -> None:
    """r . M r is all of the mass; a constant acceleration ends at the deflection under -M r a."""
    frame, names = portal(3)
    frame.add_mass(names["knee-right"], 500.0)
    along = rigid_displacement(frame, axis)
    total = 314.0 * (4.0 + 6.0 + 4.0) + 500.0
    assert along @ frame.mass_times(along) == pytest.approx(total, rel=1e-12)
    frame.assemble(frame.displacement, None)
    static = frame.solve(-1e-3 * frame.mass_times(along))
    dof = frame.dof(names["crown"], "uv"["xy".index(axis)])
    seen = []
    for _ in ground_motion(frame, axis, [1e-3, 1e-3], 5.0, [(5.0, 4e-3)], 0.5, 3.0):
        seen.append(float(frame.displacement[dof]))
    assert seen[-1] == pytest.approx(static[dof], rel=2.1e-3)  # measured 0.001
    assert np.max(np.abs(seen)) > 1.3 * abs(static[dof])  # it has swung on the way


@given(
    st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=8),
    st.floats(0.0, 3.0),
    st.floats(1e-3, 3.0),
)
def test_the_velocity_of_the_ground_is_the_integral_of_straight_lines(samples, begin, length):
    velocity = line_integral(0.4 * np.arange(len(samples)), samples)
    last = 0.4 * (len(samples) - 1)
    knots = np.unique(np.clip([begin, begin + length, *(0.4 * np.arange(9))], begin, None))
    knots = knots[(knots <= min(begin + length, last))]
    values = np.interp(knots, 0.4 * np.arange(len(samples)), samples)
    integral = float(np.trapezoid(values, knots)) if len(knots) > 1 else 0.0
    gained = float(velocity(begin + length) - velocity(begin))
    assert gained == pytest.approx(integral, abs=1e-9)


def test_failures_are_named() -> None:
    rod, dof, _ = oscillator()
    rod.solve = lambda right: None
    with pytest.raises(SolverError, match=r"time 0 s: .*line search, steps down to"):
        follow(rod, dof, [1.0, 1.0], 1.0, 1.0, 0.1)


def test_steps_have_a_limit_before_and_on_the_way(monkeypatch) -> None:
    """A step that is never solved in one piece is halved, and counts as often as it is tried."""
    rod, _, _ = oscillator()
    with pytest.raises(SolverError, match=r"time 0 s: residual 0; tried 2000000 of 1e\+09 steps"):
        next(ground_motion(rod, "x", (1.0, 1.0), 1.0, [(1.0, 1e-9)], 0.5))
    monkeypatch.setattr(impact, "MOST_STEPS", 20)
    tried = []

    def short_ones_alone(begin: float, length: float):
        tried.append(begin)
        if length > 0.02:
            return None, 1, 7.0
        return TimeStep(length, None, 0.0, 0.0), 1, 1e-9

    with pytest.raises(SolverError, match="tried 20 of 21 steps") as error:
        list(impact.march([(1.0, 0.1)], short_ones_alone, ""))
    assert error.value.step == f"time {tried[-1]:.6g} s"
