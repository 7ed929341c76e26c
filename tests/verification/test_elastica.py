"""Large deflection of a cantilever under a tip force, in closed form (Bisshopp, Drucker 1945)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc
from verification_cases import FORMULATIONS, along, hold, orders, slender_chain

from workbench.mechanics.structures.paths import apply_loads


def elastica(force: float) -> tuple[float, float]:
    """Deflection and shortening of a cantilever of unit length with EI = 1 and a tip force."""

    def phase(m: float) -> float:
        return float(np.arcsin(1.0 / np.sqrt(2.0 * m)))

    def excess(m: float) -> float:
        return float(ellipk(m) - ellipkinc(phase(m), m) - np.sqrt(force))

    m = brentq(excess, 0.5 + 1e-12, 1.0 - 1e-12, xtol=1e-15)
    deflection = 1.0 - 2.0 / np.sqrt(force) * (ellipe(m) - ellipeinc(phase(m), m))
    shortening = 1.0 - np.sqrt(2.0 * (2.0 * m - 1.0) / force)
    return float(deflection), float(shortening)


def test_closed_form_against_the_published_table() -> None:
    """Mattiasson 1981: 0.30172, 0.05643 for 1 and 0.81061, 0.55500 for 10."""
    assert elastica(1.0) == pytest.approx((0.30172, 0.05643), abs=6e-6)
    assert elastica(10.0) == pytest.approx((0.81061, 0.55500), abs=6e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", FORMULATIONS)
@pytest.mark.parametrize("force", [1.0, 5.0, 10.0])
def test_elastic_elements_are_of_second_order(kind, force) -> None:
    errors = []
    for elements in (4, 8, 16, 32):
        beam = slender_chain(kind, along(1.0, elements), radius=1e-4)
        hold(beam, 0)
        beam.load[beam.dof(elements, "v")] = force
        apply_loads(beam, steps=20, tolerance=1e-12)
        tip = beam.displacement[[beam.dof(elements, "v"), beam.dof(elements, "u")]]
        errors.append(np.hypot(*(tip * [1.0, -1.0] - elastica(force))))
    assert orders(errors) == pytest.approx(2.0, abs=0.15)  # measured 0.147, on four elements
    assert errors[-1] <= 2.3e-4  # measured 1.1e-4
