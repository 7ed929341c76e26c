"""Chord geometry: exact discrete gradients, their derivatives, unwrapped rotation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.mechanics.structures import kernels as co

ANGLES = st.floats(-3.0, 3.0)
LENGTHS = st.floats(0.2, 5.0)


def polar(length, angle):
    return length * np.array([np.cos(angle), np.sin(angle)])


def gradients_between(d0, d1, turn):
    return co.step_gradients(*d0, np.hypot(*d0), *d1, np.hypot(*d1), turn)


@given(LENGTHS, LENGTHS, ANGLES, ANGLES)
def test_step_gradients_give_the_changes_exactly(l0, l1, angle, turn):
    d0, d1 = polar(l0, angle), polar(l1, angle + turn)
    rx, ry, gx, gy, *_ = gradients_between(d0, d1, turn)
    change = d1 - d0
    assert rx * change[0] + ry * change[1] == pytest.approx(l1 - l0, abs=1e-12)
    scale = abs(gx) + abs(gy)
    assert gx * change[0] + gy * change[1] == pytest.approx(turn, abs=1e-12 * max(scale, 1.0))


@pytest.mark.parametrize("turn", [0.0, 1e-5, 0.9e-3, 1.1e-3, 0.4, -1.3])
def test_derivatives_of_step_gradients(turn):
    d0 = polar(1.3, 0.7)
    d1 = polar(1.5, 0.7 + turn)
    exact = np.reshape(gradients_between(d0, d1, turn)[4:], (2, 2, 2))
    step = 1e-6
    for j in range(2):
        sides = []
        for sign in (1.0, -1.0):
            moved = d1.copy()
            moved[j] += sign * step
            new_turn = np.arctan2(moved[1], moved[0]) - 0.7
            sides.append(np.reshape(gradients_between(d0, moved, new_turn)[:4], (2, 2)))
        difference = (sides[0] - sides[1]) / (2 * step)
        assert difference == pytest.approx(exact[:, :, j], abs=2e-9)


def test_end_gradients_are_the_limit_of_step_gradients():
    d = polar(0.8, 1.1)
    assert gradients_between(d, d, 0.0)[:4] == pytest.approx(co.end_gradients(*d, 0.8)[:4])
    exact = np.reshape(co.end_gradients(*d, 0.8)[4:], (2, 2, 2))
    for j in range(2):
        step = np.eye(2)[j] * 1e-6
        ahead, behind = d + step, d - step
        difference = np.subtract(
            co.end_gradients(*ahead, np.hypot(*ahead))[:4],
            co.end_gradients(*behind, np.hypot(*behind))[:4],
        )
        assert difference.reshape(2, 2) / 2e-6 == pytest.approx(exact[:, :, j], abs=1e-8)


@given(st.floats(-20.0, 20.0), st.floats(-1.0, 1.0))
def test_chord_rotation_is_unwrapped_by_the_end_rotations(rotation, local):
    d = polar(2.0, 0.3 + rotation)
    start = polar(1.0, 0.3)
    assert co.chord_rotation(*start, *d, rotation + local) == pytest.approx(rotation, abs=1e-12)
