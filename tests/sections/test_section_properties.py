"""Properties that must hold for any section, on random shapes and catalogue profiles."""

import tomllib

import numpy as np
import pytest
import tomli_w
from builders import examples
from hypothesis import given
from hypothesis import strategies as st

from workbench.steel.sections import (
    Section,
    circular_tube,
    find,
    i_section,
    names,
    rectangle,
    rectangular_tube,
    section_from,
    section_value,
)

ANGLES = np.linspace(0.0, np.pi / 2.0, 181)
SIZE = st.floats(0.02, 3.0)
SHARE = st.floats(0.0, 1.0)


def _between(share: float, low: float, high: float) -> float:
    return low + share * (high - low)


@st.composite
def i_sections(draw: st.DrawFn) -> Section:
    """I sections from slender plates to stocky ones, with and without fillets."""
    height, width = draw(SIZE), draw(SIZE)
    flange = _between(draw(SHARE), 0.002, 0.45 * height)
    web = _between(draw(SHARE), 0.002, 0.9 * width)
    room = min(height / 2.0 - flange, (width - web) / 2.0, 1.0)
    fillet = _between(draw(SHARE), 1.001e-4, 0.999 * room) if draw(st.booleans()) else 0.0
    return i_section(height, width, web, flange, fillet if room > 2e-4 else 0.0)


@st.composite
def tubes(draw: st.DrawFn) -> Section:
    """Rectangular and circular tubes, thin and thick."""
    height, width = draw(SIZE), draw(SIZE)
    if draw(st.booleans()):
        return circular_tube(height, _between(draw(SHARE), 0.002, 0.49 * height))
    wall = _between(draw(SHARE), 0.002, 0.49 * min(height, width))
    return rectangular_tube(height, width, wall)


def sections() -> st.SearchStrategy[Section]:
    """Any section that the workbench can describe."""
    solid = st.builds(rectangle, SIZE, SIZE)
    return st.one_of(st.sampled_from(names()).map(find), i_sections(), tubes(), solid)


def brute_force(section: Section, slices: int = 400_000) -> tuple[float, float, float]:
    """Area, second moment and plastic modulus by the midpoint rule over the width."""
    edges = np.linspace(0.0, section.height / 2.0, slices + 1)
    y, step = (edges[1:] + edges[:-1]) / 2.0, edges[1]
    strip = 2.0 * section.width_at(y) * step
    return strip.sum(), (strip * y**2).sum(), (strip * y).sum()


def superellipse(alpha: float, beta: float) -> np.ndarray:
    """Radii at ANGLES by interpolation along the parametrised curve (independent of the fit)."""
    t = np.linspace(0.0, np.pi / 2.0, 20_001)
    n, m = np.sin(t) ** (2.0 / beta), np.cos(t) ** (2.0 / alpha)
    return np.interp(ANGLES, np.arctan2(n, m), np.hypot(n, m))


@examples(60)
@given(sections())
def test_random_shapes_against_brute_force(section: Section) -> None:
    result = (section.area, section.second_moment, section.plastic_section_modulus)
    slices = 40_000
    jumps = section.width / min(section.area / section.height, section.width)
    assert result == pytest.approx(brute_force(section, slices), rel=1e-4 + 8 * jumps / slices)


@examples(100)
@given(sections())
def test_fibers_of_random_shapes(section: Section) -> None:
    errors = []
    for layers in (20, 160):
        y, area = section.fibers(layers)
        assert np.all(area > 0.0)
        assert np.all(np.abs(y) < section.height / 2.0)
        assert area.sum() == pytest.approx(section.area, rel=1e-9)
        assert (np.abs(y) * area).sum() == pytest.approx(section.plastic_section_modulus, rel=1e-9)
        errors.append(1.0 - (y**2 * area).sum() / section.second_moment)
    assert 0.0 < errors[1] < errors[0] / 20.0


@examples(150)
@given(sections())
def test_envelope_is_monotone_convex_and_between_the_bounds(section: Section) -> None:
    n, m = section.interaction_envelope(181)
    assert (n[0], m[0], n[-1], m[-1]) == (0.0, 1.0, 1.0, 0.0)
    assert np.all(np.diff(n) > 0.0)
    assert np.all(np.diff(m) <= 1e-14)
    assert np.all((m >= 1.0 - n - 1e-13) & (m <= 1.0))
    # Convex: every turn goes to the right.
    turn = np.diff(n)[:-1] * np.diff(m)[1:] - np.diff(m)[:-1] * np.diff(n)[1:]
    assert np.all(turn <= 1e-12)
    assert np.arctan2(n, m) == pytest.approx(ANGLES, abs=1e-9)


@examples(25)
@given(sections())
def test_no_neighbour_fits_better(section: Section) -> None:
    n, m = section.interaction_envelope()
    radius = np.hypot(n, m)
    alpha, beta = section.interaction_fit()
    assert alpha >= 1.0
    assert beta >= 1.0
    best = np.sum((superellipse(alpha, beta) - radius) ** 2)
    for da, db in ((0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02), (0.02, -0.02)):
        trial = superellipse(max(1.0, alpha + da), max(1.0, beta + db))
        assert np.sum((trial - radius) ** 2) >= best - 1e-7


@examples(150)
@given(sections())
def test_round_trip_through_toml(section: Section) -> None:
    text = tomli_w.dumps({"section": section_value(section)})
    again = section_from(tomllib.loads(text)["section"], "column.section")
    assert again == section
    assert hash(again) == hash(section)
    assert again.name == section.name
    assert section_value(again) == section_value(section)
