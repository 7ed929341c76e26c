"""The exact plastic envelope and its super-elliptic fit."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from workbench.base.errors import InputError
from workbench.steel.sections import (
    Section,
    circular_tube,
    find,
    i_section,
    plate,
    rectangle,
    rectangular_tube,
    square,
)

ROLLED = find("HEB 220")
PLATES = ROLLED.without_fillets()
ANGLES = np.linspace(0.0, np.pi / 2.0, 181)


def test_straight_lines_enclose_the_area_of_the_envelope() -> None:
    # M falls as 1 - n^2 in a rectangle, area 2/3: (1 + n) / 2 = 2/3
    assert square(0.2).interaction_corner() == pytest.approx(1.0 / 3.0, abs=1e-4)
    n, m = PLATES.interaction_envelope(181)
    corner = PLATES.interaction_corner()
    assert 0.5 * (1.0 + corner) == pytest.approx(np.trapezoid(m, n))


def test_published_ordinates_of_heb_220() -> None:
    # Derived from the closed form of the three-plate section, four decimals.
    n = np.array([0.05, 0.10, 0.1596, 0.20, 0.30, 0.40, 0.50, 0.60, 0.70, 0.80, 0.90])
    m = [0.9936, 0.9744, 0.9349, 0.8978, 0.7933, 0.6866, 0.5777, 0.4665, 0.3532, 0.2377, 0.1199]
    axial, moment = PLATES.interaction_envelope(4001)
    assert np.interp(n, axial, moment) == pytest.approx(m, abs=6e-5)


def test_three_plates_in_closed_form() -> None:
    n, m = PLATES.interaction_envelope(361)
    area, modulus = PLATES.area, PLATES.plastic_section_modulus
    height, width, web, clear = 0.22, 0.22, 9.5e-3, 0.188
    in_web = 1.0 - n**2 * area**2 / (4.0 * web * modulus)
    axis = clear / 2.0 + (n * area - web * clear) / (2.0 * width)
    in_flange = width / modulus * (height**2 / 4.0 - axis**2)
    assert m == pytest.approx(np.where(n <= web * clear / area, in_web, in_flange), abs=1e-13)


def test_closed_forms_of_other_shapes() -> None:
    n, m = rectangle(0.3, 0.1).interaction_envelope(91)
    assert m == pytest.approx(1.0 - n**2, abs=1e-13)
    # Thin circular tube: m = cos(pi n / 2), up to the square of wall over radius.
    n, m = circular_tube(2.0, 0.002).interaction_envelope(91)
    assert m == pytest.approx(np.cos(np.pi * n / 2.0), abs=1e-5)
    # Tube of sharp corners: same widths as an I section whose web is both side walls.
    n, m = rectangular_tube(0.3, 0.2, 0.01).interaction_envelope()
    area, modulus = 0.0096, (0.2 * 0.3**2 - 0.18 * 0.28**2) / 4.0
    side = n < 0.02 * 0.28 / area
    assert np.count_nonzero(side) > 60
    assert m[side] == pytest.approx((1.0 - n**2 * area**2 / (0.08 * modulus))[side], abs=1e-13)


@pytest.mark.parametrize(
    "section",
    [ROLLED, PLATES, find("IPE 600"), circular_tube(0.2, 0.02), rectangular_tube(0.2, 0.1, 0.01)],
    ids=lambda section: section.name,
)
def test_envelope_against_fibers(section: Section) -> None:
    y, area = section.fibers(4000)
    squash, moment = area.sum(), (np.abs(y) * area).sum()
    # Neutral axis behind each strip in turn; everything below it in compression.
    n = (squash - 2.0 * np.cumsum(area)) / squash
    m = -2.0 * np.cumsum(y * area) / moment
    compressed = n <= 0.0
    axial, bending = section.interaction_envelope(2001)
    exact = np.interp(-n[compressed], axial, bending)
    # Fillet strips and web strips overlap in height, which costs part of a strip.
    assert m[compressed] == pytest.approx(exact, abs=1.5e-3)


def superellipse(alpha: float, beta: float) -> np.ndarray:
    """Radii at ANGLES by interpolation along the parametrised curve (independent of the fit)."""
    t = np.linspace(0.0, np.pi / 2.0, 20_001)
    n, m = np.sin(t) ** (2.0 / beta), np.cos(t) ** (2.0 / alpha)
    return np.interp(ANGLES, np.arctan2(n, m), np.hypot(n, m))


@pytest.mark.parametrize(("section", "beta"), [(PLATES, 1.276), (ROLLED, 1.273)])
def test_fit_of_heb_220(section: Section, beta: float) -> None:
    alpha, result = section.interaction_fit()
    assert alpha == 1.0
    assert result == pytest.approx(beta, abs=5e-4)


def test_residual_of_the_fit() -> None:
    n, m = PLATES.interaction_envelope()
    error = superellipse(*PLATES.interaction_fit()) - np.hypot(n, m)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(0.011, abs=7e-5)  # measured 3.1e-5
    assert np.abs(error).max() == pytest.approx(0.028, abs=6e-4)
    equal = least_squares(lambda e: superellipse(e[0], e[0]) - np.hypot(n, m), [1.3]).x[0]
    assert equal == pytest.approx(1.128, abs=3.3e-4)  # measured 1.6e-4


def test_fit_of_both_exponents_is_that_of_another_solver() -> None:
    section = i_section(1.32, 0.12, 0.025, 0.09).about("weak")
    n, m = section.interaction_envelope()
    other = least_squares(lambda e: superellipse(*e) - np.hypot(n, m), [1.4, 2.4])
    assert min(other.x) > 1.4
    assert section.interaction_fit() == pytest.approx(other.x, abs=1e-5)  # measured 5e-6


@pytest.mark.parametrize("section", [square(0.2), plate(0.2, 0.01)])
def test_fit_of_rectangles_is_exact(section: Section) -> None:
    assert section.interaction_fit() == pytest.approx((1.0, 2.0), abs=1e-6)


@pytest.mark.parametrize("points", [2, 0, -1, 10.5, "9", 1_000_000])
def test_bad_point_counts(points: object) -> None:
    with pytest.raises(InputError, match="points"):
        PLATES.interaction_envelope(points)  # type: ignore[arg-type]
