"""A frame whose bars hang on is no collapse: it is followed until they have turned over."""

from __future__ import annotations

from dataclasses import replace

import pytest

import workbench as wb
from workbench.mechanics.frames.collapse import COLLAPSE_SIDEWAYS
from workbench.models.references.fiber_beams import FiberShear
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import collapse_of, findings_of, survives
from workbench.scenarios import Column, ColumnImpact
from workbench.study.error_model.error_model import anchor_peak, expected_error


def hung(velocity: float, stiffness: float = 448e3) -> ColumnImpact:
    """A UC whose spring takes over from the dead load when both bars have turned far."""
    column = Column(
        "UC 203x203x46",
        1.45,
        2.03,
        base="pinned",
        axial_load=548.4e3,
        restraint_stiffness=stiffness,
    )
    return wb.impact(column, mass=1100, velocity=velocity, duration=0.3)


@pytest.mark.thorough
def test_fibers_whose_bars_hang_on_stand_where_independent_fibers_do() -> None:
    """1.30 m by fibers written outside the project, with elastic webs."""
    answer = FiberShear(levels=1).simulate(hung(16.4))
    assert float(answer["peak_displacement"]) == pytest.approx(1.30, abs=0.02)
    (said,) = (each for each in findings_of(answer) if each.subject == "hangs-on")
    assert "bars hang on" in said.text
    assert said.outside


@pytest.mark.parametrize("model", [FlexibleSuperelement(), RigidSuperelement()])
def test_superelements_hang_on_too_and_fall_without_the_spring(model) -> None:
    stands, falls = (model.simulate(hung(17.2, stiffness)) for stiffness in (448e3, 0.0))
    assert survives(stands)
    assert float(stands["peak_displacement"]) > COLLAPSE_SIDEWAYS * 1.45
    assert "hangs-on" in {each.subject for each in findings_of(stands)}
    # a collapse is told with the first state that was beyond the limit
    collapse = collapse_of(falls)
    assert collapse.displacement == pytest.approx(COLLAPSE_SIDEWAYS * 1.45, rel=0.06)
    assert model.numbers(hung(17.2))["peak_displacement"] == pytest.approx(
        float(stands["peak_displacement"])
    )


def test_a_record_that_ends_as_bars_turn_is_a_collapse() -> None:
    """Beyond the limit and still moving: nothing says that they would hang on."""
    falls = hung(16.4, 0.0)
    collapse = collapse_of(FlexibleSuperelement().simulate(falls))
    short = replace(falls, duration=1.001 * collapse.time)
    answer = FlexibleSuperelement().simulate(short)
    assert collapse_of(answer).time == pytest.approx(collapse.time, rel=1e-2)


def test_an_anchor_that_hangs_on_at_more_velocity_is_close_to_collapse() -> None:
    hit = hung(16.4)
    answer = FlexibleSuperelement().simulate(hit)
    error = expected_error(hit, answer)
    assert anchor_peak(hit) == pytest.approx(float(answer["peak_displacement"]))
    assert error.near_collapse
    assert error.low == -1.0  # up to a collapse
    assert error.collapse > 0.1
