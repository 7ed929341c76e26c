"""The answers of the problems, by an independent integration from event to event."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from workbench.extras.laboratory.impact_systems import frame_problem
from workbench.extras.laboratory.problems import PROBLEMS, bar, cradle, problem
from workbench.extras.laboratory.schemes import scheme
from workbench.extras.laboratory.system import Penalty, springs
from workbench.extras.laboratory.systems import run

TIGHT = {"rtol": 1e-12, "atol": 1e-13, "dense_output": True}


def by_events(slope, start, duration, gap, impact, times) -> np.ndarray:
    """Places at `times`; `gap` of a state ends an interval, `impact` changes the state there."""

    def event(_, y):
        return gap(y)

    event.terminal, event.direction = True, -1
    result, begin, y = np.zeros((times.size, len(start) // 2)), 0.0, np.asarray(start, dtype=float)
    while begin < duration:
        part = solve_ivp(slope, (begin, duration), y, events=event, **TIGHT)
        on = (times >= begin) & (times <= part.t[-1])
        result[on] = part.sol(times[on])[: len(start) // 2].T
        if part.status != 1:
            return result
        begin, y = part.t[-1], impact(part.y[:, -1])
    return result


@pytest.mark.parametrize("law", [(3.0, 7.0), Penalty(3.0), (5.0, 0.0, 100.0)])
def test_forces_of_springs_are_slopes_of_their_energy(law) -> None:
    def at(e: float) -> tuple[float, float, float]:
        system = springs([1.0], [({0: 1.0}, law, 0.0)])
        (force,), ((slope,),) = system.forces(np.array([e]))
        system.commit(np.array([e]))
        return force, slope, system.energy()[0]

    for e in (-0.8, -0.1, 0.3, 1.1):
        force, slope, _ = at(e)
        (f0, _, w0), (f1, _, w1) = at(e - 1e-5), at(e + 1e-5)
        assert (w1 - w0) / 2e-5 == pytest.approx(force, abs=1e-7)
        assert (f1 - f0) / 2e-5 == pytest.approx(slope, abs=1e-6)


def test_the_ball_by_events() -> None:
    times = np.linspace(0.0, 0.72, 200)  # five impacts, before they accumulate
    result = by_events(
        lambda _, y: (y[1], -9.81),
        *((0.3, 0.0), 0.72, lambda y: y[0]),
        lambda y: np.array([0.0, -0.5 * y[1]]),
        times,
    )
    np.testing.assert_allclose(result, problem("ball").answer(times), atol=1e-9)


@pytest.mark.claim("model:impact-exact", "two masses off events, m", "independent code", 0, 1e-11)
def test_two_masses_by_events(claim) -> None:
    def impact(y):
        blow = 1.5 * (y[2] - y[3]) / (1.0 / 1500.0 + 1.0 / 100.0)
        return np.array([y[0], y[1], y[2] - blow / 1500.0, y[3] + blow / 100.0])

    times = np.linspace(0.0, 0.02, 100)
    result = by_events(
        lambda _, y: (y[2], y[3], 0.0, 0.0),
        *((0.0, 0.0, 20.0, 0.0), 0.02, lambda y: y[1] - y[0] + 0.1),
        *(impact, times),
    )
    claim(np.abs(result - problem("two-masses").answer(times)).max())


def test_the_stopped_duffing_oscillator_by_events() -> None:
    times = np.linspace(0.0, 10.0, 1281)
    result = by_events(
        lambda _, y: (y[1], -y[0] - y[0] ** 3),
        *((1.0, 0.0), 10.0, lambda y: y[0] + 0.5),
        lambda y: np.array([-0.5, -0.8 * y[1]]),
        times,
    )
    np.testing.assert_allclose(result, problem("duffing").answer(times), atol=2e-9)


@pytest.mark.parametrize("name", [n for n in PROBLEMS if PROBLEMS[n]().exact is not None])
def test_event_driven_steps_meet_the_exact_answers(name: str) -> None:
    given = problem(name)
    steps = 4 * given.steps
    result = run(
        *(scheme("event-driven").stepper, given.system(), given.law, given.start),
        *(given.duration, given.duration / steps),
    )
    exact = given.answer(result.t)
    assert np.abs(result.q - exact).max() < 1e-5 * np.abs(exact).max()
    if given.impacts is not None:
        assert result.impacts == given.impacts
    if given.conservative:
        assert result.drift < 1e-5


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("coefficients", [(1.0,), (0.0, 1.0), (1.0, 0.0), (0.2, 0.5)])
def test_the_cradle_of_both_laws(law: str, coefficients: tuple[float, ...]) -> None:
    given = cradle(law, coefficients)
    for name in ("event-driven", "moreau-jean"):
        result = run(*(scheme(name).stepper, given.system(), given.law, given.start, 0.4, 0.4 / 64))
        exact = given.answer(result.t)
        np.testing.assert_allclose(result.v[-1], np.diff(exact, axis=0)[-1] * 64 / 0.4, atol=1e-12)


def test_the_struck_frame_is_the_same_for_two_schemes_and_dissipates() -> None:
    """Energy-conserving and event-driven steps share nothing but the forces of the elements."""
    given = frame_problem()
    values = {
        name: run(scheme(name).stepper, given.system(), given.law, given.start, 0.015, step)
        for name, step in (("midpoint", 5e-5), ("event-driven", 2.5e-5))
    }
    mine, other = values["midpoint"].q, values["event-driven"].q[::2]
    assert np.abs(mine - other).max() < 0.01 * np.abs(other).max()
    struck = values["midpoint"].energies[0, 0]
    assert 0.3 * struck < values["midpoint"].energies[-1, 2] < 0.5 * struck
    total = values["midpoint"].energies.sum(axis=1) + np.append(
        0.0, np.cumsum(values["midpoint"].contact_loss)
    )
    assert np.ptp(total) < 1e-8 * struck


def test_a_lumped_bar_rings_where_the_bar_of_dalembert_does_not() -> None:
    """It leaves after 2 L / c, but not as fast as it came: vibration keeps a share."""
    rebounds = []
    for elements in (5, 20):
        given = bar(elements)
        result = run(
            *(scheme("moreau-jean").stepper, given.system(), given.law, given.start, 3.5, 0.0025)
        )
        pushes = result.t[result.impulses[:, 0] > 1e-9]
        assert pushes[-1] - pushes[0] == pytest.approx(2.0, abs=0.25)
        mass = np.diag(given.system().mass)
        rebounds.append(float(result.v[-1] @ mass) / 0.1)
        lost = float(result.contact_loss.sum()) / result.energies[0, 0]
        assert lost == pytest.approx(0.5 / elements, rel=0.05)  # the first mass stops at once
    assert 0.85 < rebounds[0] < rebounds[1] < 1.0


def test_the_soft_impact_is_two_modes_and_a_free_flight() -> None:
    given = problem("soft-impact")
    q = given.answer(np.linspace(0.0, 0.3, 3001))
    half = pi / np.sqrt(3e5 / 1500.0)  # of a vehicle against a wall
    apart = np.flatnonzero(q[1:, 1] - q[1:, 0] > 0.0)[0] * 1e-4
    assert apart == pytest.approx(half, rel=0.15)
    assert np.ptp(np.diff(q[-500:, 0])) < 1e-9
