"""The frame of Heng 2017, section 5.3: peaks of an independent implementation, mesh by mesh."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from reissner_cases import thesis_frame
from threadpoolctl import threadpool_limits

from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.impact import PointMass, impact

STRIKER = PointMass(1500.0, 50.0)
DURATION = 0.031
RESOLVED = {0.4: 0.3720, 0.2: 0.4321}  # with steps of an eighth
DAMPED = {0.1: 0.4599, 0.05: 0.4773, 0.025: 0.4864}  # independent steps, at half a percent below
resolved = partial(impact, halvings=5)


def peak(driver, frame, dof, *more) -> float:
    with threadpool_limits(1, user_api="blas"):
        return max(float(frame.displacement[dof]) for _ in driver(frame, dof, STRIKER, *more))


@pytest.mark.parametrize("size", RESOLVED)
def test_uniform_meshes(size) -> None:
    result = peak(resolved, *thesis_frame(size), [(DURATION, size / 1000.0)], 0.5)
    assert result == pytest.approx(RESOLVED[size], rel=6e-3)  # measured 5.0e-3 at 0.4 m


@pytest.mark.slow
@pytest.mark.parametrize("size", DAMPED)
def test_fine_uniform_meshes(size) -> None:
    """Steps that damp lose half a percent of the peak."""
    result = peak(resolved, *thesis_frame(size), [(DURATION, size / 1000.0)], 0.5)
    assert 1.0 < result / DAMPED[size] < 1.008  # measured 1.006


@pytest.mark.slow
def test_order_and_limit() -> None:
    """First order, as plasticity is sampled inside the elements; 0.495 m within 1 %."""
    peaks = np.array(
        [
            peak(resolved, *thesis_frame(h), [(DURATION, h / 1000.0)], 0.5)
            for h in (0.1, 0.05, 0.025)
        ]
    )
    order = np.log2((peaks[1] - peaks[0]) / (peaks[2] - peaks[1]))
    assert order == pytest.approx(1.0, abs=0.15)
    limit = peaks[2] + (peaks[2] - peaks[1]) / (2.0 ** np.clip(order, 0.8, 1.2) - 1.0)
    assert limit == pytest.approx(0.495, rel=0.01)


def test_explicit_steps_give_the_same_peak() -> None:
    """Central differences do not damp either."""
    explicit = peak(explicit_impact, *thesis_frame(0.4, lumped=True), [(DURATION, 1e-4)])
    implicit = peak(resolved, *thesis_frame(0.4, lumped=True), [(DURATION, 5e-5)], 0.5)
    assert explicit == pytest.approx(implicit, rel=8e-4)  # measured 3.5e-4
