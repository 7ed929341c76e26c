"""Collision of two free masses: conservation laws and Newton's law."""

from __future__ import annotations

import pytest
from collision import collide
from hypothesis import given
from hypothesis import strategies as st

from workbench.mechanics.impact import contact_loss, explicit_percussion

MASS = st.floats(0.1, 1e5)


@given(MASS, MASS, st.floats(0.1, 100.0), st.floats(0.0, 1.0))
def test_momentum_energy_and_restitution(struck, striker, velocity, restitution) -> None:
    after = collide(struck, striker, velocity, restitution)
    momentum = struck * after.struck_velocity + striker * after.striker_velocity
    assert momentum == pytest.approx(striker * velocity, rel=1e-9)
    kinetic = 0.5 * (struck * after.struck_velocity**2 + striker * after.striker_velocity**2)
    before = 0.5 * striker * velocity**2
    assert kinetic + after.energy_loss == pytest.approx(before, rel=1e-9)
    separation = after.struck_velocity - after.striker_velocity
    assert separation == pytest.approx(restitution * velocity, abs=1e-9 * velocity)


@pytest.mark.parametrize(
    ("restitution", "velocity", "percussion", "loss"),
    [(0.0, 18.75, 1875.0, 18750.0), (0.5, 28.125, 2812.5, 14062.5), (1.0, 37.5, 3750.0, 0.0)],
)
def test_a_lorry_mass_hits_100_kg(restitution, velocity, percussion, loss) -> None:
    after = collide(100.0, 1500.0, 20.0, restitution)
    assert after.struck_velocity == pytest.approx(velocity, rel=1e-12)
    assert after.percussion == pytest.approx(percussion, rel=1e-12)
    assert after.energy_loss == pytest.approx(loss, abs=1e-9)


@given(MASS, MASS, st.floats(-10.0, 10.0), st.floats(-10.0, 10.0), st.floats(0.0, 1.0))
def test_the_explicit_law_never_creates_energy(mass, striker, start, pull, restitution) -> None:
    free = start - abs(pull)
    percussion = explicit_percussion(free, start, restitution, mass, striker)
    assert percussion >= 0.0
    end = free + percussion * (1.0 / mass + 1.0 / striker)
    assert contact_loss(percussion, start, end) >= -1e-9 * percussion * (1 + abs(start))
