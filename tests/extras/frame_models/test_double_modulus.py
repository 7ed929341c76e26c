"""Double modulus of refined hinges: an ideal I section, loads of Engesser and Shanley."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq
from superelement_cases import EA, EI, NP
from test_refined_bars import law, refined

from workbench.extras.frame_models.bars import beam_kernels

RADIUS = sqrt(EI / EA)


def flange_share(tangent: float, shortening: float, bending: float) -> float:
    """Bending stiffness over E I of two flanges under an axial force that adds `shortening` to E A.

    Each has its modulus by the sign of its own strain, which is sought.
    """

    def stresses(middle: float) -> np.ndarray:
        strains = np.array([middle + bending, middle - bending])
        return np.where(strains > 0.0, tangent, 1.0) * strains

    far = (abs(shortening) + abs(bending)) / tangent * 2.0
    middle = brentq(lambda e: stresses(e).mean() - shortening, -far, far, xtol=1e-18, rtol=1e-14)
    first, last = stresses(middle)
    return float(0.5 * (first - last) / bending)


def test_flanges_of_an_ideal_section_are_met() -> None:
    rng, most = np.random.default_rng(3), 0.0
    for _ in range(500):
        tangent, shortening = rng.uniform(0.01, 1.0), rng.uniform(-2.0, 2.0)
        expected = flange_share(tangent, shortening, 1.0)
        most = max(most, abs(beam_kernels.both_moduli(tangent, shortening, 1.0) - expected))
    assert most < 1e-9
    assert beam_kernels.both_moduli(0.4, 0.0, 1.0) == pytest.approx(2.0 * 0.4 / 1.4)  # Engesser
    assert beam_kernels.both_moduli(0.4, 0.4, 1.0) == pytest.approx(0.4)  # Shanley


def bent(length: float, n: float, radius: float, growth: float) -> float:
    """Stiffness (N m/rad) of a pin-ended bar under n of the squash load as its ends turn alike.

    `growth`, elastic shortening that comes with it over the strain of the flanges.
    """
    tables, turn = refined(length, moment=1e9), 1e-7  # ends elastic
    start = np.array([-n * NP * length / EA, 0.0, 0.0])
    change = np.array([-growth * RADIUS * 2.0 * turn, turn, -turn])
    out = law(tables._replace(radius=np.array([radius])), start, start + change)
    return float(out[1] / turn)


@pytest.mark.parametrize("n", [0.5, 0.7, 0.9])
def test_critical_loads_of_engesser_and_shanley(n: float) -> None:
    """At n of the squash load a column of the slenderness sqrt(E_r / E / n) buckles."""
    tangent = -2.7243 * n * np.log(n)
    shares = {"tangent": tangent, "double": 2.0 * tangent / (1.0 + tangent)}
    for name, share in shares.items():
        radius = RADIUS if name == "double" else 0.0
        exact = sqrt(share / n)

        def stiffness(slenderness: float, radius: float = radius) -> float:
            return bent(slenderness * pi * sqrt(EI / NP), n, radius, 0.0)

        result = brentq(stiffness, 0.7 * exact, 1.3 * exact)
        assert result == pytest.approx(exact, rel=1e-6), name
    # both flanges compressed further: the tangent modulus, whichever is asked for
    grown = 1.01 * tangent
    assert bent(1.0, n, RADIUS, grown) == pytest.approx(bent(1.0, n, 0.0, grown), rel=1e-9)
    assert bent(1.0, n, RADIUS, 0.9 * tangent) > 1.0001 * bent(1.0, n, 0.0, 0.9 * tangent)


def test_a_column_that_is_relieved_is_elastic() -> None:
    elastic, tangent = (bent(1.0, 0.8, radius, -1.01) for radius in (RADIUS, 0.0))
    bar = refined(1.0).rows[0]
    near, far, _ = beam_kernels.stiffness(bar, -0.8 * NP, 1.0)
    assert elastic == pytest.approx(near - far, rel=1e-3)
    assert tangent < 0.6 * elastic
