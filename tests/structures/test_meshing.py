"""Graded meshes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.mechanics.structures.assembly import graded_lengths, halved


@given(st.floats(0.1, 20.0), st.floats(0.002, 0.5), st.floats(0.01, 10.0))
def test_mesh_fills_the_segment_and_is_symmetric(length, smallest, largest):
    lengths = graded_lengths(length, smallest, max(largest, smallest))
    assert len(lengths) >= 4
    assert lengths.sum() == pytest.approx(length, rel=1e-12)
    assert lengths == pytest.approx(lengths[::-1], rel=1e-6)
    assert lengths.min() > 0.0
    # elements fit only approximately, but never above the sizes asked for by more than rounding
    assert lengths.max() <= 1.25 * max(largest, smallest)
    assert min(lengths[0], lengths[-1]) <= 1.001 * smallest


def test_growth_and_cap():
    lengths = graded_lengths(10.0, 0.01, 0.3)
    growth = lengths[1:12] / lengths[:11]
    assert growth.max() < 1.55
    assert growth[:4] == pytest.approx(1.5, abs=0.03)
    assert lengths.max() == pytest.approx(0.3, rel=0.03)  # measured 0.014
    assert lengths[0] == pytest.approx(0.01, rel=0.034)  # measured 0.017


def test_halving_is_nested():
    lengths = graded_lengths(3.0, 0.1, 0.4)
    fine = halved(lengths, 2)
    assert len(fine) == 4 * len(lengths)
    assert fine.reshape(-1, 4).sum(axis=1) == pytest.approx(lengths)
    assert np.array_equal(halved(lengths, 0), lengths)
