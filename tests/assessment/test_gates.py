"""Verdicts at and around the bound."""

from __future__ import annotations

import pytest

from workbench.assessment import Gate, Verdict, judge


@pytest.mark.parametrize(
    ("value", "uncertainty", "verdict"),
    [
        (0.03, 0.01, Verdict.PASS),
        (-0.03, 0.01, Verdict.PASS),
        (0.045, 0.01, Verdict.INCONCLUSIVE),
        (-0.055, 0.01, Verdict.INCONCLUSIVE),
        (0.07, 0.01, Verdict.FAIL),
        (-0.07, 0.01, Verdict.FAIL),
        (0.01, None, Verdict.INCONCLUSIVE),
        (0.07, None, Verdict.FAIL),
        (0.05, 0.0, Verdict.PASS),
    ],
)
def test_judge(value, uncertainty, verdict):
    assert judge(value, uncertainty, 0.05) is verdict


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (-0.04, 0.02, Verdict.PASS),  # the half-width alone would reach beyond the bound
        (-0.06, 0.02, Verdict.INCONCLUSIVE),
        (-0.02, 0.06, Verdict.INCONCLUSIVE),
        (0.06, 0.09, Verdict.FAIL),
        (-0.09, -0.06, Verdict.FAIL),
    ],
)
def test_the_ends_of_a_skewed_interval_count_where_they_are_known(low, high, verdict):
    assert judge(0.01, 0.05, 0.05, low, high) is verdict


def test_a_gate_names_what_it_asks():
    gate = Gate("four-dof", "reference", "impulse", "relative_error", 0.05, "why", "heng2017")
    assert gate.name == "four-dof against reference: relative_error of impulse"
