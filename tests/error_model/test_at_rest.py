"""Columns that their strain rate holds up only as long as they move."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.models.base import make_model
from workbench.responses import outcome_of
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.materials import MILD_STEEL, Steel
from workbench.steel.sections import find
from workbench.study.error_model.error_model import advise

COLUMN = Column(
    *(find("HEB 220"), 1.75, 1.75, Steel(rate=MILD_STEEL)),
    **{"base": "clamped", "head": "guided", "axial_load": 8e5},
)

BARS = {"rate_level": "bars"}


def hit(velocity: float, duration: float = 0.4, column: Column = COLUMN) -> ColumnImpact:
    return ColumnImpact("creep", column, Striker(1500.0, velocity), duration=duration)


def subjects(name: str, scenario: ColumnImpact, **options: object) -> list[str]:
    model = make_model(name, options)
    response = model.simulate(scenario)
    assert outcome_of(response) == "ok"
    return [each.subject for each in advise(model, scenario, response)]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "options"),
    [*((name, {}) for name in ("single-dof", "energy-estimate", "four-dof")), ("four-dof", BARS)],
)  # fmt: skip
def test_survival_near_collapse_is_judged_at_rest(name: str, options: dict[str, object]) -> None:
    assert "creep" in subjects(name, hit(29.0), **options)
    assert "creep" not in subjects(name, hit(22.0), **options)


def test_nothing_creeps_without_a_rate_or_an_axial_load() -> None:
    static = replace(COLUMN, steel=Steel())
    assert "creep" not in subjects("single-dof", hit(12.0, column=static))
    assert "creep" not in subjects("single-dof", hit(30.0, column=replace(COLUMN, axial_load=0.0)))


@pytest.mark.slow
def test_fibers_creep_to_collapse_long_after_the_hit() -> None:
    """At 30 m/s the fiber beam stands still at 0.2 s, and lies on the ground at 1.9 s."""
    fibers = make_model("fiber-reissner", {"levels": 1})
    short, long = (fibers.simulate(hit(30.0, duration)) for duration in (0.4, 3.0))
    assert outcome_of(short) == "ok"
    assert float(np.ptp(short["displacement"].values[-20:])) < 0.02
    assert outcome_of(long) == "collapse"
    assert outcome_of(fibers.simulate(hit(27.0, 3.0))) == "ok"
