"""Rules of practice for axial force and both moments beside the exact domain of a section."""

import numpy as np
import pytest

from workbench.extras.practice.biaxial import contains, cut, octant, radii, rules_of, separable
from workbench.steel.hinges.interaction import radius
from workbench.steel.sections import Section, find, section_from

HEB, IPE = (find(name).without_fillets() for name in ("HEB 220", "IPE 300"))
SHS = section_from({"height": 0.2, "width": 0.2, "wall": 0.01})
CHS = section_from({"diameter": 0.2191, "wall": 0.01})


@pytest.mark.parametrize(
    ("section", "rule", "low", "high"),  # radial errors of the specification, percent
    [
        (HEB, "eurocode", -7.8, 1.5),
        (HEB, "super-ellipsoid", -7.4, 13.3),
        (IPE, "eurocode", -7.7, 4.4),
        (IPE, "super-ellipsoid", -8.0, 13.3),
        (SHS, "orbison", -6.3, 23.5),
        (CHS, "orbison", -9.9, 19.3),
    ],
)
def test_rules_are_as_far_off_as_another_program_has_them(
    section: Section, rule: str, low: float, high: float
) -> None:
    rays = octant()
    off = 100.0 * (radii(rule, section, rays) / radii("exact", section, rays) - 1.0)
    assert off.min() == pytest.approx(low, abs=1.0)
    assert off.max() == pytest.approx(high, abs=1.0)


def test_without_the_weak_moment_a_cut_is_that_of_the_plane() -> None:
    for rule in ("exact", "orbison", "eurocode"):
        angle = np.linspace(0.05, 1.5, 9)
        rays = np.stack([np.sin(angle), np.cos(angle), np.zeros(9)], axis=-1)
        assert radii(rule, HEB, rays) == pytest.approx(radius(rule, HEB, angle), rel=1e-4)


def test_the_exact_surface_is_convex_and_two_rules_are_not() -> None:
    rays, drawn = octant(), np.random.default_rng(5)
    pairs = drawn.integers(0, len(rays), (2, 4000))
    for rule, convex in (("exact", True), ("orbison", False), ("eurocode", False)):
        points = 0.999999 * radii(rule, HEB, rays)[:, None] * rays
        middle = 0.5 * (points[pairs[0]] + points[pairs[1]])
        assert contains(rule, HEB, middle).all() == convex


def test_cuts_and_rules_of_sections() -> None:
    strong, weak = cut("exact", HEB, 0.5)
    assert weak[-1] == pytest.approx(0.851429, abs=1e-6)  # closed form about the weak axis
    assert (np.diff(strong) < 0.0).all()
    assert min(separable(HEB)) >= 1.0
    assert "eurocode" not in rules_of(section_from({"side": 0.2}))
