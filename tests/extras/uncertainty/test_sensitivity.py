"""Sobol indices against exact values, with and without missing answers."""

import numpy as np
import pytest
from scipy.special import ndtr

from workbench.base.errors import InputError
from workbench.extras.uncertainty.inputs import sobol_scores
from workbench.extras.uncertainty.sensitivity import sobol_indices

ROWS = 1024
# Ishigami and Homma (1990), a = 7, b = 0.1: exact
FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)


def ishigami(u):
    x = np.pi * (2.0 * u - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def answers(function, dimension, seed=1, rows=ROWS):
    u = ndtr(sobol_scores(2 * dimension, rows, (seed,)))
    A, B = u[:, :dimension], u[:, dimension:]
    mixed = [np.where(np.arange(dimension) == i, B, A) for i in range(dimension)]
    return function(A), function(B), np.array([function(each) for each in mixed])


def holds(indices, first, total, slack=0.0):
    pairs = [*zip(indices.first, first, strict=True), *zip(indices.total, total, strict=True)]
    return [index.low - slack <= exact <= index.high + slack for index, exact in pairs]


def test_ishigami_is_inside_its_intervals():
    indices = sobol_indices(*answers(ishigami, 3))
    assert all(holds(indices, FIRST, TOTAL))
    assert indices.rows == (ROWS,) * 3
    assert max(i.high - i.low for i in (*indices.first, *indices.total)) < 0.2


def test_linear_model_has_the_shares_of_its_variance():
    weights = np.array([1.0, 2.0, 3.0])
    indices = sobol_indices(*answers(lambda u: u @ weights, 3))
    exact = tuple(weights**2 / (weights**2).sum())
    assert all(holds(indices, exact, exact))


def test_missing_answers_at_random_leave_the_indices():
    random = np.random.default_rng(3)

    def failing(u):
        return np.where(random.random(len(u)) < 0.05, np.nan, ishigami(u))

    indices = sobol_indices(*answers(failing, 3))
    assert sum(holds(indices, FIRST, TOTAL)) >= 5
    assert all(holds(indices, FIRST, TOTAL, slack=0.02))
    assert all(ROWS * 0.85 < rows < ROWS * 0.95 for rows in indices.rows)


def test_missing_answers_in_a_corner_are_shown_by_their_own_indices():
    # missing where u1 > 0.8 and u2 > 0.75: S = 0.211, 0.158, 0; T = 0.842, 0.789, 0 (exact)
    def missing(u):
        return ((u[:, 0] > 0.8) & (u[:, 1] > 0.75)).astype(float)

    indices = sobol_indices(*answers(missing, 3, rows=4096))
    assert all(holds(indices, (0.2105, 0.1579, 0.0), (0.8421, 0.7895, 0.0), slack=0.01))


def test_too_little_is_refused():
    few = np.full(200, np.nan)
    few[:20] = np.arange(20)
    with pytest.raises(InputError, match="answers"):
        sobol_indices(few, few, np.array([few]))
    same = np.ones(200)
    with pytest.raises(InputError, match="answers"):
        sobol_indices(same, same, np.array([same]))
