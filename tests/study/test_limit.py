"""Critical values: bracketed, bisected, and never taken from a failure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import pytest
from toy_models import Troubled

from workbench.base.errors import SolverError
from workbench.models.four_dof import FourDof
from workbench.responses import Response, survives
from workbench.scenarios import ColumnImpact
from workbench.study.limit import PARTS, find_limit


@dataclass(frozen=True)
class Gap(Troubled):
    """Collapses above 18 m/s; without convergence in a band."""

    low: float = 17.0
    high: float = 17.9

    name: ClassVar[str] = "toy-gap"

    def _solve(self, scenario: ColumnImpact) -> Response:
        if self.low < scenario.striker.velocity < self.high:
            raise SolverError("t = 0.01 s", 0.5, "everything")
        return super()._solve(scenario)


def test_the_bracket_is_as_narrow_as_asked(thesis_impact: ColumnImpact) -> None:
    model = Troubled("collapse", above=18.0)
    limit = find_limit(model, thesis_impact.at_velocity, (1.0, 60.0), 0.005)
    assert limit.settled
    assert limit.survives_at <= 18.0 < limit.collapses_at
    assert limit.collapses_at - limit.survives_at <= 0.005 * limit.collapses_at
    values = [trial.value for trial in limit.trials]
    assert len(values) == len(set(values)) <= 4 + 8
    assert max(values) == 1.0 + 59.0 * 3 / PARTS  # nothing is asked above the first collapse
    for trial in limit.trials:
        assert trial.survives is (trial.value <= 18.0)
        assert (trial.outcome, trial.collapse is None) == (
            ("ok", True) if trial.survives else ("collapse", False)
        )


@pytest.mark.parametrize(
    ("above", "bracket", "tried"), [(99.0, (60.0, None), PARTS + 1), (0.0, (None, 1.0), 1)]
)
def test_a_range_on_one_side_is_said_so(thesis_impact, above, bracket, tried) -> None:
    model = Troubled("collapse", above=above)
    limit = find_limit(model, thesis_impact.at_velocity, (1.0, 60.0), 0.005)
    assert (limit.survives_at, limit.collapses_at) == bracket
    assert limit.settled
    assert len(limit.trials) == tried


def test_failures_are_taken_for_neither(thesis_impact: ColumnImpact) -> None:
    beside = find_limit(Gap("collapse", above=18.0), thesis_impact.at_velocity, (1.0, 60.0), 0.005)
    assert beside.settled
    assert beside.survives_at > 17.9
    across = find_limit(
        Gap("collapse", above=18.0, high=19.0), thesis_impact.at_velocity, (1.0, 60.0), 0.005
    )
    assert not across.settled
    assert 16.8 < across.survives_at <= 17.0
    assert 19.0 <= across.collapses_at < 19.2
    assert len(across.trials) < 25
    assert {trial.outcome for trial in across.undecided} == {"not-converged"}
    assert all(17.0 < trial.value < 19.0 for trial in across.undecided)
    silent = find_limit(Troubled("refuse"), thesis_impact.at_velocity, (1.0, 60.0), 0.005)
    assert (silent.survives_at, silent.collapses_at, silent.settled) == (None, None, False)
    assert len(silent.undecided) == PARTS + 1
    late = find_limit(
        Gap("collapse", above=18.0, low=0.0, high=12.0), thesis_impact.at_velocity, (1.0, 60.0), 0.1
    )
    assert late.survives_at > 12.0


def test_the_limit_of_the_car_park_column_is_that_of_single_runs(parked: ColumnImpact) -> None:
    """Records that end while it still sinks are followed on."""
    limit = find_limit(FourDof(), parked.at_velocity, (1.0, 60.0), 0.005)
    assert limit.settled
    assert (limit.survives_at, limit.collapses_at) == pytest.approx((9.50, 9.53), rel=1e-3)
    longer = replace(parked, duration=0.4)
    assert survives(FourDof().simulate(longer.at_velocity(limit.survives_at))) is True
    assert survives(FourDof().simulate(longer.at_velocity(limit.collapses_at))) is False
    assert parked.duration == 0.1 < max(trial.duration for trial in limit.trials)


def test_the_end_that_survives_may_be_the_upper_one(parked: ColumnImpact) -> None:
    def at_load(load: float) -> ColumnImpact:
        return replace(parked, column=replace(parked.column, restraint_stiffness=load))

    limit = find_limit(FourDof(), at_load, (1e8, 0.0), 0.1)
    assert limit.settled
    assert limit.survives_at > limit.collapses_at >= 0.0


def test_a_limit_at_zero_is_found_in_few_trials(thesis_impact: ColumnImpact) -> None:
    def at(value: float) -> ColumnImpact:
        return thesis_impact.at_velocity(10.0 if value <= 0.0 else 20.0)

    limit = find_limit(Troubled("collapse", above=15.0), at, (0.0, 1.0), 0.005)
    assert (limit.survives_at, limit.settled) == (0.0, True)
    assert len(limit.trials) < 25
