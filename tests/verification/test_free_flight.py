"""A flexible beam that flies, turns and vibrates freely: what conserving steps conserve."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from verification_cases import FORMULATIONS, NEVER, along, orders, steel_chain

from workbench.mechanics.structures.impact import PointMass, impact

LENGTH, ELEMENTS = 4.0, 8
FAR = PointMass(1.0, 0.0, position=-1e9)


class Drift(NamedTuple):
    """Largest drift of energy, linear and angular momentum over their first values.

    `bent`, largest elastic share of the energy; `speed` in m/s; `travelled` distance in m.
    """

    energy: float
    linear: float
    angular: float
    bent: float
    speed: float
    travelled: float


def fly(kind: str, dt: float, steps: int) -> Drift:
    """Squares of 0.2 m without yielding, thrown, turned and bent, by steps that conserve energy."""
    beam = steel_chain(kind, along(LENGTH, ELEMENTS), yield_stress=NEVER)
    u, v, turn = (beam.dofs(range(ELEMENTS + 1), name) for name in ("u", "v", "rotation"))
    at = beam.coordinates[:, 0] - 0.5 * LENGTH
    beam.velocity[u] = 3.0
    beam.velocity[v] = 12.0 * at + 8.0 * np.cos(at) ** 2
    beam.velocity[turn] = 12.0

    def momenta() -> np.ndarray:
        p = beam.mass_times(beam.velocity)
        x = beam.coordinates[:, 0] + beam.displacement[u]
        y = beam.coordinates[:, 1] + beam.displacement[v]
        return np.array([p[u].sum(), p[v].sum(), np.sum(x * p[v] - y * p[u] + p[turn])])

    first, energy = momenta(), beam.kinetic_energy()
    speed = float(np.max(np.abs(beam.velocity)))
    linear = angular = lost = bent = 0.0
    middle = int(v[ELEMENTS // 2])
    for step in impact(beam, middle, FAR, [(steps * dt, dt)], 0.5, tolerance=1e-12):
        change = momenta() - first
        linear = max(linear, float(np.hypot(*change[:2]) / np.hypot(*first[:2])))
        angular = max(angular, abs(change[2] / first[2]))
        lost = max(lost, abs(beam.kinetic_energy() + step.energies.stored - energy) / energy)
        bent = max(bent, step.energies.stored / energy)
    travelled = float(np.max(np.abs(beam.displacement)))
    return Drift(lost, linear, angular, bent, speed, travelled)


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_a_thousand_steps(kind) -> None:
    """Energy 2e-9, linear momentum to rounding, angular momentum 1e-8.

    A velocity is 2 dx / dt less the one before, so that the rounding of x enters it with 2 / dt in
    every step. Over a thousand steps this adds up like a random walk: 2e-12 here, not 1e-12.
    """
    dt, steps = 1e-4, 1000
    drift = fly(kind, dt, steps)
    assert drift.bent > 0.01
    assert drift.energy <= 2e-9
    rounding = np.finfo(float).eps * drift.travelled * 2.0 / dt / drift.speed * np.sqrt(steps)
    assert rounding < 1e-10
    assert drift.linear <= rounding
    assert drift.linear <= 1e-11
    assert drift.angular <= 1e-8


@pytest.mark.parametrize("kind", FORMULATIONS)
def test_angular_momentum_drifts_at_second_order(kind) -> None:
    drifts = [fly(kind, 0.08 / steps, steps).angular for steps in (100, 200, 400, 800)]
    assert orders(drifts) == pytest.approx(2.0, abs=0.1)
    assert drifts[-1] <= 1e-8
