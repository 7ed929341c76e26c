"""How impacts are stepped through: the next step, meetings inside steps, late peaks."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.mechanics.impact.pace import Pace, contact_time, growth, late_peak, next_step_size

PACE = Pace(1.0, 1e-5, 1e-2, 1e-3, 1e-2, 0.1, 1e-4, 10_000)


def test_a_step_ends_at_the_end_or_the_next_impact() -> None:
    assert next_step_size(PACE, 0.995, 1e-2, 1.0, 1.0) == pytest.approx(0.005)
    assert next_step_size(PACE, 0.5, 1e-2, 0.004, -2.0) == pytest.approx(
        0.002
    )  # the gap closes there
    assert next_step_size(PACE, 0.5, 1e-2, 0.004, 2.0) == 1e-2
    assert next_step_size(PACE, 0.5, 1e-2, 1e-9, -2.0) == PACE.first
    equal = PACE._replace(error=np.inf)
    assert next_step_size(equal, 0.503, 1.0, 1.0, 1.0) == pytest.approx(
        0.007
    )  # to the next multiple


@pytest.mark.parametrize(("start", "end"), [(-1.0, -1.0), (-1.0, -3.0), (0.5, -3.0), (-2.0, -1.0)])
def test_the_gap_closes_where_its_parabola_crosses_zero(start: float, end: float) -> None:
    gap, dt = 0.05, 0.1
    when = contact_time(gap, start, end, dt, 1e-12)
    assert 0.0 < when < dt
    left = gap + start * when + 0.5 * (end - start) / dt * when**2
    assert left == pytest.approx(0.0, abs=1e-12 if end <= start else 0.03)  # before the least gap
    assert contact_time(gap, start, 1.0, dt, 1e-12) == np.inf
    assert contact_time(0.3, start, end, dt, 1e-12) == np.inf


def test_steps_grow_with_the_root_of_the_error_allowed() -> None:
    assert growth(PACE, 0.12, 1.0, 1.0, 0.0) == pytest.approx(0.9 * 1.44**0.5)
    assert growth(PACE, 0.12, 1.0, 2.0, 0.0) == pytest.approx(0.45 * 1.44**0.5)
    assert growth(PACE, 0.12, 1.0, 1.0, 0.9) == pytest.approx(0.1)  # what hinges flow decides


def test_a_rise_during_a_later_hit_is_no_late_peak() -> None:
    """The striker pushes again, in short steps: what rises then is found as it is."""
    time = np.linspace(0.0, 1.0, 101)
    wave = np.sin(3.0 * np.pi * time) + time  # least at 0.5, largest at 0.85
    rising, free = np.gradient(wave, time), np.zeros(101)
    last = float(time[np.flatnonzero(wave >= 0.99 * wave.max())[-1]])
    assert late_peak(PACE, 0.3, time, wave, rising, free) == last
    hit = np.where((time > 0.45) & (time < 0.95), 1.0, 0.0)
    assert late_peak(PACE, 0.3, time, wave, rising, hit) == 0.0
    assert late_peak(PACE, 0.95, time, wave, rising, free) == 0.0
