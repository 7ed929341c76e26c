"""Two masses, a mass on a spring, and the balances of a whole column."""

from __future__ import annotations

import numpy as np
import pytest
from verification_cases import AREA, E, hold, orders, steel_chain

from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.impact import PointMass, impact
from workbench.models.references.fiber_beams import FiberCorotational, FiberReissner

LENGTH, NODE = 2.0, 100.0


def bar(lumped: bool = False):
    """A bar that holds a point mass of 100 kg, by a spring EA / L; its own mass is inside."""
    beam = steel_chain("reissner", [[0.0, 0.0], [LENGTH, 0.0]], yield_stress=1e30, lumped=lumped)
    hold(beam, 0)
    hold(beam, 1, "v", "rotation")
    beam.add_mass(1, NODE)
    dof = beam.dof(1, "u")
    return beam, dof, float(beam.mass_times(np.eye(beam.size)[dof])[dof])


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("scheme", ["implicit", "explicit"])
def test_two_masses(restitution, scheme) -> None:
    """Momentum, Newton's law and the loss m1 m2 (1 - e^2) v^2 / 2 (m1 + m2)."""
    beam, dof, given = bar(lumped=True)
    striker = PointMass(1500.0, 20.0, restitution)
    dt = 1e-9  # so short that the spring does not take part
    if scheme == "implicit":
        step = next(impact(beam, dof, striker, [(dt, dt)], 0.5))
    else:
        step = next(explicit_impact(beam, dof, striker, [(dt, dt)]))
    common = 1500.0 * 20.0 / (1500.0 + given)
    struck = common + restitution * 1500.0 * 20.0 / (1500.0 + given)
    assert beam.velocity[dof] == pytest.approx(struck, rel=1e-8)  # measured 5.1e-12
    assert step.impulse == pytest.approx(given * struck, rel=1e-8)  # measured 2.0e-12
    left = common - restitution * given * 20.0 / (1500.0 + given)
    assert step.striker.velocity == pytest.approx(left, rel=1e-8)  # measured 1.5e-12
    loss = 0.5 * 1500.0 * given / (1500.0 + given) * 20.0**2 * (1.0 - restitution**2)
    assert step.contact_loss == pytest.approx(loss, rel=1e-4, abs=1e-6)


def test_joint_motion_after_a_plastic_collision_is_of_first_order() -> None:
    """Both masses swing on the spring: x = V / omega sin(omega t)."""
    errors = []
    for count in (20, 40, 80, 160):
        beam, dof, given = bar()
        striker = PointMass(1500.0, 1.0)
        omega = np.sqrt(E * AREA.sum() / LENGTH / (1500.0 + given))
        duration = 0.4 * np.pi / omega
        *_, last = impact(beam, dof, striker, [(duration, duration / count)], 0.5)
        common = 1500.0 / (1500.0 + given)
        exact = common * np.cos(0.4 * np.pi)
        errors.append(last.striker.velocity / exact - 1.0)
    # the first step holds the collision, so that half a step of the swing is lost
    assert orders(errors) == pytest.approx(1.0, abs=1.8e-3)  # measured 9.0e-4
    half_step = 0.5 * 0.4 * np.pi / 160 * np.tan(0.4 * np.pi)
    assert errors[-1] == pytest.approx(half_step, rel=8e-4)  # measured 3.5e-4


@pytest.mark.thorough
@pytest.mark.parametrize(
    "model",
    [FiberReissner(levels=1, refinement=-1), FiberCorotational(levels=1, refinement=-1)],
    ids=lambda model: model.name,
)
def test_energy_and_momentum_of_a_column(thesis_impact, model) -> None:
    """The ledger closes to 1e-8 of the impact energy, and the impulse is the striker's loss."""
    response = model.simulate(thesis_impact)
    assert response.attrs["outcome"] == "ok"
    energy = thesis_impact.input_energy
    assert np.abs(response["balance_error"].values).max() <= 1e-8 * energy
    lost = 1500.0 * (15.0 - response["striker_velocity"].values[-1])
    assert float(response["impulse"]) == pytest.approx(lost, rel=1e-9)
    assert np.min(response["percussion"].values) >= 0.0
    assert np.min(np.diff(response["dissipated"].values)) >= -1e-9 * energy
