"""Inputs have physical lower bounds, and what lies below them ends a march all the same."""

from __future__ import annotations

import pytest
from builders import portal

from workbench.base.errors import InputError
from workbench.models.base import make_model
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, FrameGroundMotion, Striker
from workbench.scenarios.pulse import velocity_after

COLUMN = Column("HEB 220", 0.8, 3.2, axial_load=5e5, restraint_stiffness=1e7)
HIT = ColumnImpact("hit", COLUMN, Striker(1500.0, 8.0))
TINY = 1e-300


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Striker(TINY, 8.0), r"striker.mass = 1e-300: .* from 0\.001 to"),
        (lambda: Striker(1500.0, TINY), r"striker.velocity = 1e-300: .* from 1e-06 to 300 m/s"),
        (lambda: Striker(1500.0, 8.0, crush=((0, 0), (1, TINY))), "must rise somewhere by 1 N/m"),
        (lambda: ColumnPushover("push", COLUMN, TINY), r"displacement = 1e-300: .* from 1e-06"),
        (
            lambda: FrameGroundMotion("shake", portal(), (0.0, TINY), 0.01, "A1"),
            "must reach 1e-06 m/s2",
        ),
        (lambda: velocity_after(TINY, 1.0), r"velocity = 1e-300: .* from 0\.001"),
        (lambda: velocity_after(20.0, 1.0, TINY), r"deceleration = 1e-300"),
        (lambda: velocity_after(20.0, 1.0, 4.0, TINY), r"angle = 1e-300"),
    ],
)
def test_what_is_not_physical_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("name", ["single-dof", "four-dof", "energy-estimate"])
def test_the_least_strike_is_answered(name):
    response = make_model(name).simulate(HIT.changed(striker=Striker(1e-3, 1e-3)))
    assert 0.0 < float(response.peak_displacement) < 1e-9


@pytest.mark.parametrize(("name", "most"), [("single-dof", 4_000_000), ("four-dof", 1_000_000)])
def test_collisions_without_end_are_steps_as_well(name, most):
    """An impulse that underflows changes no velocity: the bodies collide for ever."""
    striker = HIT.striker.unchecked(mass=TINY, velocity=TINY)
    response = make_model(name).simulate(HIT.unchecked(striker=striker))
    assert outcome_of(response) is Outcome.NOT_CONVERGED
    assert f"time 0 s: residual 0; tried {most} steps" in response.attrs["message"]
