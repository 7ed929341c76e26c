"""Area, moments, strengths and fibers: closed forms, published numbers, brute force."""

import pickle
from math import pi

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.steel.materials import Steel
from workbench.steel.sections import (
    CircularTube,
    Section,
    circular_tube,
    find,
    i_section,
    rectangle,
    rectangular_tube,
    square,
    square_tube,
)

STEEL = Steel()
PLATES = find("HEB 220").without_fillets()
SAMPLES = [
    find("HEB 220"),
    PLATES,
    find("IPE 80"),
    square(0.2),
    rectangular_tube(0.3, 0.2, 0.01),
    circular_tube(0.2, 0.01),
]
each = pytest.mark.parametrize("section", SAMPLES, ids=lambda section: section.name)


def brute_force(section: Section, slices: int = 400_000) -> tuple[float, float, float]:
    """Area, second moment and plastic modulus by the midpoint rule over the width."""
    edges = np.linspace(0.0, section.height / 2.0, slices + 1)
    y, step = (edges[1:] + edges[:-1]) / 2.0, edges[1]
    strip = 2.0 * section.width_at(y) * step
    return strip.sum(), (strip * y**2).sum(), (strip * y).sum()


def test_plates_of_heb_220_as_in_the_thesis() -> None:
    # Heng 2017, section 5.2: M_p = 284.72 kNm and N_p = 3133.23 kN.
    assert PLATES.area == pytest.approx(8.826e-3, rel=1e-12)
    assert PLATES.second_moment == pytest.approx(7.8655e-5, rel=5e-6)
    assert PLATES.squash_load(STEEL) == pytest.approx(3_133_230, abs=0.032)  # measured: round-off
    assert PLATES.plastic_moment(STEEL) == pytest.approx(284_718, abs=0.4)  # measured 0.19
    assert PLATES.plastic_section_modulus == pytest.approx(802_022e-9, rel=1e-9)


def test_rolled_heb_220() -> None:
    section = find("HEB 220")
    assert section.area == pytest.approx(9.104e-3, rel=3e-5)  # measured 1.4e-5
    assert section.second_moment == pytest.approx(8.091e-5, rel=9e-6)  # measured 4.3e-6
    assert section.squash_load(STEEL) == pytest.approx(3.232e6, rel=2.3e-5)  # measured 1.1e-5
    assert section.plastic_moment(STEEL) == pytest.approx(2.936e5, rel=1.3e-5)  # measured 6.2e-6
    # rho A L / 3 of the 4 m column, Heng 2017.
    assert 7850 * section.area * 4 / 3 == pytest.approx(95.25, rel=6e-4)


def test_closed_forms() -> None:
    h, b, t = 0.3, 0.2, 0.01
    solid, tube = rectangle(h, b), rectangular_tube(h, b, t)
    assert solid.area == pytest.approx(b * h, rel=1e-14)
    assert solid.second_moment == pytest.approx(b * h**3 / 12, rel=1e-14)
    assert solid.elastic_section_modulus == pytest.approx(b * h**2 / 6, rel=1e-14)
    assert solid.plastic_section_modulus == pytest.approx(b * h**2 / 4, rel=1e-14)
    hi, bi = h - 2 * t, b - 2 * t
    assert tube.area == pytest.approx(b * h - bi * hi, rel=1e-13)
    assert tube.second_moment == pytest.approx((b * h**3 - bi * hi**3) / 12, rel=1e-13)
    assert tube.plastic_section_modulus == pytest.approx((b * h**2 - bi * hi**2) / 4, rel=1e-13)
    d, di = 0.2, 0.18
    ring = circular_tube(d, t)
    assert ring.area == pytest.approx(pi / 4 * (d**2 - di**2), rel=1e-13)
    assert ring.second_moment == pytest.approx(pi / 64 * (d**4 - di**4), rel=1e-13)
    assert ring.plastic_section_modulus == pytest.approx((d**3 - di**3) / 6, rel=1e-13)
    r = 0.018
    fillets = find("HEB 220").area - PLATES.area
    assert fillets == pytest.approx((4 - pi) * r**2, rel=1e-12)


@pytest.mark.parametrize(
    ("section", "expected"),
    [
        (PLATES, 9.5e-3 * 0.204),
        (find("HEB 220"), 9.5e-3 * 0.204),
        (square(0.2), 0.04),
        (rectangular_tube(0.3, 0.2, 0.01), 2 * 0.01 * 0.29),
        (circular_tube(0.2, 0.01), 2 * pi / 4 * (0.2**2 - 0.18**2) / pi),
    ],
)
def test_shear_area(section: Section, expected: float) -> None:
    assert section.shear_area == pytest.approx(expected, rel=1e-12)
    assert section.shear_resistance(STEEL) == pytest.approx(expected * 355e6 / 3**0.5, rel=1e-12)


def test_short_segment_of_the_thesis_column_overloads_its_web() -> None:
    # Both ends of the 0.8 m segment plastic: V = 2 M_p / 0.8, about 1.8 times V_pl.
    demand = 2 * PLATES.plastic_moment(STEEL) / 0.8
    # measured 0.008
    assert demand / PLATES.shear_resistance(STEEL) == pytest.approx(1.8, abs=0.017)


@each
def test_integrals_against_brute_force(section: Section) -> None:
    result = (section.area, section.second_moment, section.plastic_section_modulus)
    assert result == pytest.approx(brute_force(section), rel=2e-5)


@each
def test_fibers_keep_area_and_plastic_modulus(section: Section) -> None:
    for layers in (4, 10, 20, 200):
        y, area = section.fibers(layers)
        assert y.shape == area.shape
        assert np.all(area > 0.0)
        assert np.all(np.diff(y) >= 0.0)
        assert np.array_equal(y, -y[::-1])
        assert np.array_equal(area, area[::-1])
        assert area.sum() == pytest.approx(section.area, rel=1e-12)
        assert (np.abs(y) * area).sum() == pytest.approx(section.plastic_section_modulus, rel=1e-12)


@each
def test_second_moment_of_fibers_converges_quadratically_from_below(section: Section) -> None:
    lost = []
    for layers in (20, 40, 80):
        y, area = section.fibers(layers)
        lost.append(1.0 - (y**2 * area).sum() / section.second_moment)
    assert 0.0 < lost[0] < 2.6e-3
    assert lost[0] / lost[1] == pytest.approx(4.0, abs=0.042)  # measured 0.021
    assert lost[1] / lost[2] == pytest.approx(4.0, abs=0.011)  # measured 0.0055


def test_twenty_layers_of_a_rectangle_lose_a_quarter_percent() -> None:
    section = square(0.2)
    y, area = section.fibers()
    assert len(y) == 20
    assert area == pytest.approx(np.full(20, 0.04 / 20), rel=1e-12)
    assert (y**2 * area).sum() / section.second_moment == pytest.approx(1 - 1 / 400, rel=1e-10)


def test_plates_are_layered_separately() -> None:
    y, area = PLATES.fibers(20)
    web = np.abs(y) < 0.094
    assert len(y) == 20
    assert np.count_nonzero(web) == 12
    assert area[web].sum() == pytest.approx(9.5e-3 * 0.188, rel=1e-12)
    assert area[y > 0.094].sum() == pytest.approx(0.22 * 0.016, rel=1e-12)
    rolled, _ = find("HEB 220").fibers(20)
    assert len(rolled) == 24  # two strips in each of the two fillet pairs
    tube, _ = rectangular_tube(0.3, 0.2, 0.01).fibers(20)
    assert np.count_nonzero(np.abs(tube) > 0.14) == 8


@pytest.mark.parametrize("layers", [7, 2, 0, -4, 20.5, "20", True, 100_000, float("nan")])
def test_bad_layer_counts(layers: object) -> None:
    with pytest.raises(InputError, match="layers"):
        square(0.2).fibers(layers)  # type: ignore[arg-type]


def test_without_fillets() -> None:
    assert PLATES.shape == i_section(0.22, 0.22, 9.5e-3, 0.016).shape
    assert PLATES.name == "HEB 220 without fillets"
    assert PLATES.without_fillets() is PLATES
    tube = square_tube(0.2, 0.01)
    assert tube.without_fillets() is tube


@each
def test_sections_are_values(section: Section) -> None:
    section.interaction_fit()  # caches must not disturb what follows
    copy = pickle.loads(pickle.dumps(section))
    assert copy == section
    assert hash(copy) == hash(section)
    assert copy.name == section.name
    assert copy.interaction_fit() == section.interaction_fit()
    assert section != square(0.1)
    with pytest.raises(AttributeError):
        section.name = "other"  # type: ignore[misc]


def test_the_name_is_only_a_label() -> None:
    assert Section("mine", CircularTube(0.2, 0.01)) == circular_tube(0.2, 0.01)
    assert find("HEB 220") == i_section(0.22, 0.22, 0.0095, 0.016, 0.018)


def test_bad_construction() -> None:
    with pytest.raises(InputError, match=r"section\.shape"):
        Section("HEB 220", "HEB 220")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"section\.name"):
        Section("", CircularTube(0.2, 0.01))
