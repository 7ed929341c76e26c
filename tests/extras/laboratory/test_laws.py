"""Contact laws: one impact, simultaneous impacts of a cradle."""

from __future__ import annotations

import numpy as np
import pytest
from collision import collide

from workbench.base.errors import InputError
from workbench.extras.laboratory.complementarity import Restitution, percussions
from workbench.extras.laboratory.system import Penalty

CRADLE = np.array([[2.0, -1.0], [-1.0, 2.0]])  # three balls of 1 kg
NORMALS = np.array([[-1.0, 0.0], [1.0, -1.0], [0.0, 1.0]])


def impulses(law: str, e: tuple[float, ...], G: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Of a simultaneous impact."""
    each = Restitution(e, law).each(before.size)
    result, residual = percussions(G, before, before, each, law == "poisson")
    assert residual < 1e-12
    return result


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_one_contact_is_the_collision_of_two_masses(law: str, e: float) -> None:
    expected = collide(100.0, 1500.0, 20.0, e)
    G = np.array([[1.0 / 100.0 + 1.0 / 1500.0]])
    start = np.array([-20.0])
    result = impulses(law, e, G, start)
    assert result[0] == pytest.approx(expected.percussion, rel=1e-13)
    assert (start + G @ result)[0] == pytest.approx(20.0 * e, abs=1e-12)


def test_a_closed_contact_that_separates_reverses_elastically() -> None:
    """Pressed together while it opens: any less restitution would create energy."""
    start, free = np.array([1.0]), np.array([-2.0])
    result, _ = percussions(np.eye(1), free, start, np.array([0.2]), False)
    assert (free + result)[0] == pytest.approx(-1.0)


def cradle(law: str, first: float, second: float) -> np.ndarray:
    """Velocities of three touching balls after the first arrives at 1 m/s."""
    before = np.array([-1.0, 0.0])
    result = impulses(law, (first, second), CRADLE, before)
    return np.array([1.0, 0.0, 0.0]) + NORMALS @ result


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_laws_agree_on_a_cradle_of_equal_coefficients(e: float) -> None:
    expected = np.array([1.0 - 2.0 * e, 1.0 + e, 1.0 + e]) / 3.0
    for law in ("newton", "poisson"):
        np.testing.assert_allclose(cradle(law, e, e), expected, atol=1e-14)


def test_newton_and_poisson_differ_on_a_cradle_of_two_coefficients() -> None:
    # Newton: only the contact that closes rebounds, whatever the other one's coefficient is
    np.testing.assert_allclose(cradle("newton", 0.0, 1.0), np.full(3, 1.0 / 3.0), atol=1e-14)
    np.testing.assert_allclose(cradle("newton", 1.0, 0.0), [-1 / 3, 2 / 3, 2 / 3], atol=1e-14)
    # Poisson: compression 2/3 and 1/3; the second gives 1/3 back, which throws the middle ball
    # onto the first: one more sixth there
    np.testing.assert_allclose(cradle("poisson", 0.0, 1.0), [1 / 6, 1 / 6, 2 / 3], atol=1e-14)
    # P = 4/3 and 1/3 press the middle ball into the last: one more third there
    np.testing.assert_allclose(cradle("poisson", 1.0, 0.0), [-1 / 3, 2 / 3, 2 / 3], atol=1e-14)
    for e in np.random.default_rng(0).uniform(0.0, 1.0, (20, 2)):
        for law in ("newton", "poisson"):
            after = cradle(law, *e)
            assert after.sum() == pytest.approx(1.0, rel=1e-13)
            assert (after**2).sum() <= 1.0 + 1e-13
            assert np.diff(after).min() >= -1e-13


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Restitution(1.1), r"restitution.coefficients.*from 0 to 1"),
        (lambda: Restitution((0.5, -0.1)), r"restitution.coefficients.1 = -0.1"),
        (lambda: Restitution(0.5, "hertz"), "newton, poisson"),
        (lambda: Restitution((0.5, 0.5)).each(3), "one number or 3"),
        (lambda: Penalty(0.0), "penalty.stiffness"),
    ],
)
def test_bad_laws_get_one_clear_message(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
