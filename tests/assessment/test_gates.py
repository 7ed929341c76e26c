"""Verdicts at and around the bound."""

from __future__ import annotations

import pytest

from workbench.study.assessment import Gate, Verdict, judge
from workbench.study.assessment.gates import CaseVerdict, GateVerdict

GATE = Gate("four-dof", "reference", "impulse", "relative_error", 0.05, "why", "heng2017")


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
    assert GATE.name == "four-dof against reference: relative_error of impulse"


@pytest.mark.parametrize(
    ("cases", "verdict"),
    [
        ("pass pass", "pass"),
        ("pass fail", "fail"),
        ("refused fail unanswered", "fail"),
        ("pass inconclusive", "inconclusive"),
        ("pass refused", "inconclusive"),
        ("pass unanswered", "inconclusive"),
        ("", "inconclusive"),
    ],
)
def test_nothing_passes_but_what_passes_in_every_case_asked(cases, verdict):
    cases = tuple(CaseVerdict(c, Verdict(c), None, None, "") for c in cases.split())
    assert GateVerdict(1, GATE, cases).verdict.value == verdict


def of(name, value, verdict=Verdict.PASS, width=0.01, **more):
    """A case with a half-width of 0.01 or another."""
    return CaseVerdict(name, verdict, value, None if value is None else width, "", **more)


@pytest.mark.parametrize(
    "cases",
    [
        (of("small", 0.02), of("far", -0.03)),
        (of("larger", 0.03), of("far", 0.02, width=0.025)),  # less sure, so that it reaches farther
        (of("larger", -0.03), of("far", -0.02, width=0.025)),
        (of("far", 0.01, low=-0.04, high=0.02), of("half-width", 0.02)),  # skewed
        (of("far", 0.01, low=-0.01, high=0.04), of("other side", 0.01, low=-0.03, high=0.02)),
        (of("far", 0.01), of("both fall", None, collapsed=("four-dof", "reference"))),
        (of("beyond", 9.0, Verdict.FAIL), of("far", None, Verdict.FAIL, collapsed=("four-dof",))),
        (of("passes", 0.9), of("far", 0.06, Verdict.FAIL)),
    ],
)
def test_the_critical_case_is_the_one_that_reaches_farthest(cases):
    for order in (cases, cases[::-1]):
        assert GateVerdict(1, GATE, order).critical.case == "far"
