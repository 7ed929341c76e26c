"""Missiles that crush and the ground near a fault: closed forms, momentum, energy, scipy."""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from workbench.base.errors import InputError
from workbench.scenarios.pulse import missile_of, missile_pulse, near_fault_motion

# nose, cabin, engines and wings, tail: numbers of nothing that flies
AT, MASSES = (0.0, 5.0, 15.0, 30.0, 40.0), (500.0, 3000.0, 8000.0, 500.0, 200.0)
LINER = np.column_stack([AT, MASSES, (1e6, 2e7, 4e7, 5e6, 0.0)])


def test_a_uniform_missile_in_closed_form() -> None:
    """v^2 = v_0^2 + 2 P / mu ln(M / M_0): it stops at x = L (1 - exp(-mu v_0^2 / 2 P))."""
    length, mu, crushing, v0 = 20.0, 1000.0, 1e6, 20.0
    pulse = missile_pulse(np.array([(0.0, mu, crushing), (length, mu, crushing)]), v0)
    stop = length * (1.0 - np.exp(-mu * v0**2 / (2.0 * crushing)))
    assert pulse.whole == pytest.approx(mu * length * v0, rel=1e-14)
    assert pulse.peak == pytest.approx(crushing + mu * v0**2, rel=1e-14)

    def speed(x: float) -> float:
        return sqrt(v0**2 + 2.0 * crushing / mu * log(1.0 - x / length))

    for x in (0.3 * stop, 0.8 * stop):
        at = quad(lambda each: 1.0 / speed(each), 0.0, x, epsabs=1e-13)[0]
        assert pulse.force(at) == pytest.approx(crushing + mu * speed(x) ** 2, rel=2e-5)
    end = quad(lambda s: 2.0 * s / speed(stop - s * s), 0.0, sqrt(stop), epsabs=1e-12)[0]
    assert pulse.end == pytest.approx(end, rel=5e-4)
    limp = missile_pulse(np.array([(0.0, mu, 0.0), (length, mu, 0.0)]), v0)  # a jet of water
    assert (limp.whole, limp.end) == pytest.approx((mu * length * v0, length / v0), rel=1e-12)
    np.testing.assert_allclose(limp.force(np.linspace(0.0, 0.99, 9)), mu * v0**2, rtol=1e-12)


def test_a_missile_of_many_parts_by_scipy() -> None:
    v0 = 103.0
    pulse, (x, mu, crushing) = missile_pulse(LINER, v0), LINER.T
    whole = np.trapezoid(mu, x)
    fine = np.linspace(0.0, x[-1], 40_001)
    dense = np.interp(fine, x, mu)
    gone = np.append(0.0, np.cumsum(0.5 * np.diff(fine) * (dense[1:] + dense[:-1])))

    def motion(_, y):
        return [y[1], -np.interp(y[0], x, crushing) / (whole - np.interp(y[0], fine, gone))]

    until = 0.97 * pulse.end
    hand = solve_ivp(motion, (0.0, until), [0.0, v0], rtol=1e-10, max_step=until / 500)
    force = np.interp(hand.y[0], x, crushing) + np.interp(hand.y[0], x, mu) * hand.y[1] ** 2
    assert np.abs(pulse.force(hand.t) - force).max() < 2.5e-3 * pulse.peak  # measured 1.7e-3
    assert pulse.whole == pytest.approx(whole * v0, rel=1e-13)


@given(
    st.lists(st.tuples(st.floats(0.1, 20.0), st.floats(0.0, 1e4), st.floats(0.0, 1e8)), min_size=2),
    st.floats(1.0, 300.0),
)
def test_momentum_is_kept_to_round_off(parts, velocity) -> None:
    points = np.array(parts)
    points[:, 0] = np.cumsum(points[:, 0]) - points[0, 0]
    points[0, 1] += 1.0
    momentum = np.trapezoid(points[:, 1], points[:, 0]) * velocity
    pulse = missile_pulse(points, velocity)
    assert pulse.whole == pytest.approx(momentum, rel=1e-11)
    assert min(pulse.factors) >= 0.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1,2\n", "m: missile .*must begin with the line station_m,mass_kg_per_m,crushing"),
        ("H0,1,2\n1,2\n", "m, line 3 = '1,2': must be three numbers"),
        ("H0,1,2\n1,-2,3\n", "m, line 3, mass_kg_per_m = -2.0: must be a number from 0"),
        ("H0,1,2\n0,2,3\n", "m, line 3, station_m = 0.0: must be larger"),
        ("H0,1,2\n", "must have 2 to 10000 points, not 1"),
        ("H1,1,2\n2,1,2\n", "missile: must begin at 0 m and have a mass"),
        ("H0,0,2\n2,0,2\n", "missile: must begin at 0 m and have a mass"),
    ],
)
def test_bad_missiles_get_one_clear_message(text, message) -> None:
    text = text.replace("H", "station_m,mass_kg_per_m,crushing_force_N\n")
    with pytest.raises(InputError, match=message.removeprefix("m: ")) as caught:
        missile_pulse(missile_of(text.encode(), "m"), 10.0)
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match=r"velocity = 0\.0"):
        missile_pulse(LINER, 0.0)


@pytest.mark.parametrize("phase", [0.0, 90.0, 137.0])
def test_the_ground_near_a_fault_moves_as_its_formula(phase) -> None:
    amplitude, frequency, cycles = 1.2, 0.8, 2.5
    step, a = near_fault_motion(amplitude, frequency, cycles, phase)
    s = (np.arange(a.size) * step - 0.5 * cycles / frequency) * 2.0 * pi * frequency
    velocity = 0.5 * amplitude * (1.0 + np.cos(s / cycles)) * np.cos(s + np.radians(phase))
    summed = np.append(0.0, np.cumsum(0.5 * step * (a[1:] + a[:-1])))
    assert (a.size - 1) * step == pytest.approx(cycles / frequency)
    np.testing.assert_allclose(summed, velocity, atol=1.5e-4 * amplitude)  # 200 parts of a period
    assert summed[-1] == pytest.approx(0.0, abs=2e-5 * amplitude)  # 0 of whole cycles


def test_an_elastic_mass_on_that_ground_by_scipy() -> None:
    """Its table against the formula itself, as a spectrum has it: relative displacement."""
    step, a = near_fault_motion(1.0, 1.0, 2.0, 90.0)
    time, w = np.arange(a.size) * step, 2.0 * pi * 1.7

    def exact(t: float) -> float:
        """The derivative of the velocity by a complex step."""
        s = 2.0 * pi * (t - 1.0 + 1e-20j)
        v = 0.5 * (1.0 + np.cos(s / 2.0)) * np.cos(s + 0.5 * pi)
        return float(v.imag / 1e-20)

    peaks = []
    for ground in (exact, lambda t: float(np.interp(t, time, a))):
        hand = solve_ivp(
            lambda t, y, ground=ground: [y[1], -w * w * y[0] - ground(t)],
            *((0.0, 2.0), [0.0, 0.0]),
            max_step=0.01,
            rtol=1e-9,
        )
        peaks.append(np.abs(hand.y[0]).max())
    assert peaks[1] == pytest.approx(peaks[0], rel=3e-4)


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ((0.0, 1.0, 2.0, 0.0), r"amplitude = 0\.0: must be a number above 0"),
        ((1.0, 0.0, 2.0, 0.0), r"frequency = 0\.0"),
        ((1.0, 1.0, 1.0, 0.0), r"cycles = 1\.0: must be a number above 1"),
        ((1.0, 1.0, 2.0, 400.0), r"phase = 400\.0"),
    ],
)
def test_bad_motions_get_one_clear_message(given_, message) -> None:
    with pytest.raises(InputError, match=message):
        near_fault_motion(*given_)
