"""The end of the shear-free domain: where a ratio leaves its band for good."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.report.figures.values import crossing


def test_the_bound_is_interpolated_and_final() -> None:
    x = np.array([0.5, 1.0, 1.5, 2.0])
    assert crossing(x, np.array([1.0, 1.0, 0.9, 0.8]), 0.05) == pytest.approx(1.25)
    assert crossing(x, np.array([1.06, 1.0, 0.9, 0.8]), 0.05) == pytest.approx(1.25)
    assert crossing(x, np.ones(4), 0.05) == np.inf
    assert crossing(x, np.full(4, 0.9), 0.05) is None
