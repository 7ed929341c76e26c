"""The closed form of a hinge at a strain rate, against quadrature and constants of motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.steel.hinges.panel_elements import (
    hinge_overstress,
    overstress_shape,
    panel_overstress,
    rotation_rate,
)
from workbench.steel.materials import MILD_STEEL, CowperSymonds
from workbench.steel.sections import find
from workbench.steel.sections.reading import square

HEB = find("HEB 220")


def test_the_shape_of_the_overstress() -> None:
    """Exact of a rectangle: 10/11 with q = 5; of plates by their integrals."""
    assert overstress_shape(square(0.1), 5.0) == pytest.approx(10.0 / 11.0, rel=1e-5)
    plates = HEB.without_fillets()
    assert overstress_shape(plates, 5.0) == pytest.approx(0.97434, abs=2e-5)
    assert overstress_shape(find("IPE 300").without_fillets(), 5.0) == pytest.approx(
        0.9706, abs=1e-4
    )


@pytest.mark.parametrize(
    ("length", "factors"),
    [
        (1.0, (1.4682, 1.5983, 1.7664)),
        (2.0, (1.4145, 1.5291, 1.6769)),
        (4.0, (1.3672, 1.4682, 1.5983)),
    ],
)
def test_the_moment_at_a_rotation_rate(length: float, factors: tuple[float, ...]) -> None:
    """HEB 220 in mild steel at 0.5, 2 and 8 rad/s."""
    shape = overstress_shape(HEB.without_fillets(), 5.0)
    for rate, factor in zip((0.5, 2.0, 8.0), factors, strict=True):
        over = hinge_overstress(rate, length, HEB.height, shape, MILD_STEEL)
        assert 1.0 + over == pytest.approx(factor, abs=6e-5)


@given(st.floats(1e-4, 3.0), st.floats(0.1, 10.0), st.floats(1.0, 12.0), st.floats(1.0, 1e6))
def test_the_hinge_is_the_integral_of_its_sections(over, length, exponent, reference) -> None:
    """Of curvature rates 2 D / h (excess / c)^q along a straight moment diagram."""
    law, height, shape = CowperSymonds(reference, exponent), 0.3, 0.95
    nodes, weights = np.polynomial.legendre.leggauss(40)
    zone = over / (1.0 + over) * length  # where the moment is above the plastic one
    x = 0.5 * zone * (nodes + 1.0)
    excess = (1.0 + over) * (1.0 - x / length) - 1.0
    curvatures = 2.0 * reference / height * (np.maximum(excess, 0.0) / shape) ** exponent
    rate = rotation_rate(over, length, height, shape, law)
    assert rate == pytest.approx(float(0.5 * zone * weights @ curvatures), rel=1e-6)
    if rate > 1e-250:
        assert hinge_overstress(rate, length, height, shape, law) == pytest.approx(over, rel=1e-9)


def test_a_web_has_the_rate_of_its_bar() -> None:
    assert panel_overstress(np.sqrt(3.0) * 40.4, MILD_STEEL) == pytest.approx(1.0)
    assert panel_overstress(0.0, MILD_STEEL) == hinge_overstress(0, 1, 0.2, 1, MILD_STEEL) == 0.0
