"""Newton's method with line search."""

import numpy as np
import pytest

from workbench.mechanics.structures.equilibrium import newton


def scalar(residual, slope):
    """Newton's callbacks for one equation; the tangent is that of the last evaluation."""
    last = {}

    def evaluate(x):
        last["x"] = float(x[0])
        return np.array([residual(last["x"])])

    def solve(right):
        k = slope(last["x"])
        return None if k == 0.0 else right / k

    return evaluate, solve


def test_line_search_tames_an_overshooting_root():
    evaluate, solve = scalar(np.arctan, lambda x: 1.0 / (1.0 + x**2))
    evaluation = newton(evaluate, lambda r: 1e-12, solve, np.array([20.0]))
    assert evaluation.converged
    assert evaluation.x[0] == pytest.approx(0.0, abs=1e-12)


def test_elastic_plastic_kink_does_not_cycle():
    hard, soft = 1.0, 1e-6

    def force(x):
        return hard * x if abs(x) < 1.0 else np.sign(x) * (1.0 + soft * (abs(x) - 1.0))

    evaluate, solve = scalar(
        lambda x: force(x) + force(x - 1.5) - 0.4, lambda x: 2 * (hard if abs(x) < 1.0 else soft)
    )
    evaluation = newton(evaluate, lambda r: 1e-10, solve, np.array([0.0]))
    assert evaluation.converged
    assert force(evaluation.x[0]) + force(evaluation.x[0] - 1.5) == pytest.approx(0.4, abs=1e-8)


def test_failures_are_told():
    evaluate, solve = scalar(lambda x: x**2 + 1.0, lambda x: 2.0 * x)
    lost = newton(evaluate, lambda r: 1e-9, solve, np.array([1.0]))
    assert not lost.converged
    assert lost.residual > 100.0
    evaluate, solve = scalar(lambda x: 1.0, lambda x: 0.0)
    assert not newton(evaluate, lambda r: 1e-9, solve, np.array([1.0])).converged


def test_allowance_is_fixed_at_the_start():
    seen = []

    def allow(residual):
        seen.append(float(residual[0]))
        return 1e-9

    evaluate, solve = scalar(lambda x: x - 3.0, lambda x: 1.0)
    newton(evaluate, allow, solve, np.array([10.0]))
    assert seen == [7.0]
