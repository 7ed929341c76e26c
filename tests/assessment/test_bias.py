"""Bias and scatter: recovered from samples that are drawn with known ones."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.study.assessment import bias_and_scatter


def test_a_constant_ratio_is_the_bias():
    data = np.array([1.0, 2.0, 5.0])
    result = bias_and_scatter(1.1 * data, data)
    assert result.bias == pytest.approx(1.1)
    assert result.low == pytest.approx(1.1)
    assert result.model_scatter == pytest.approx(0.0, abs=1e-12)


def test_known_bias_and_scatter_are_recovered():
    random = np.random.default_rng(1)
    truth = random.uniform(1.0, 10.0, 200_000)
    # expected ratio 0.9, model scatter 0.2
    model = truth * 0.9 * np.exp(0.2 * random.standard_normal(len(truth)) - 0.5 * 0.2**2)
    result = bias_and_scatter(model, truth)
    assert result.bias == pytest.approx(0.9, rel=1.4e-3)  # measured 7.3e-4
    assert result.model_scatter == pytest.approx(0.2, rel=4.5e-3)  # measured 0.0022


def test_the_interval_covers_as_often_as_it_says():
    random = np.random.default_rng(7)
    covered = 0
    for _ in range(600):
        ratio = np.exp(0.15 * random.standard_normal(8))
        result = bias_and_scatter(ratio, np.ones(8))
        assert result.low is not None
        assert result.high is not None
        covered += result.low <= np.exp(0.5 * 0.15**2) <= result.high
    assert covered / 600 == pytest.approx(0.95, abs=0.023)  # measured 0.938


def test_one_pair_has_no_interval():
    result = bias_and_scatter([1.2], [1.0])
    assert (result.bias, result.low, result.model_scatter) == (pytest.approx(1.2), None, None)


@pytest.mark.parametrize("pair", [([1.0], [1.0, 2.0]), ([], []), ([-1.0], [1.0]), ([1.0], [0.0])])
def test_unusable_pairs_are_refused(pair):
    with pytest.raises(InputError, match="model, data"):
        bias_and_scatter(*pair)
