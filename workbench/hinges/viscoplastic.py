"""A section as viscoplastic bars have it: gauge of its envelope, overstress, hardening, points.

Plates with the area and the plastic modulus of the section: root fillets are in the flanges, as
`Section.flange_plates` has them, so that N_p and M_p are met. Derivation:
docs/theory/strain-rate.md.
"""

from functools import lru_cache
from math import inf
from typing import Any

import numpy as np

from workbench.arrays import Array
from workbench.hinges.rate import overstress_shape
from workbench.hinges.viscoplastic_kernels import LAW, MOST
from workbench.materials import Steel
from workbench.sections import Rectangle, Section

_POINTS = MOST // 2  # of each end; with rate, which smooths where flow begins, half of them


def bar_law(section: Section, steel: Steel, squash_load: float, plastic_moment: float) -> Any:
    """The record (`LAW`) of a bar of a section with plane webs, or of a solid rectangle.

    Arguments: `squash_load` (N) and `plastic_moment` (N m), to which the envelope is stretched if
    they are not those of the section.
    """
    law = np.zeros(1, LAW)[0]
    A, W, height = section.area, section.plastic_section_modulus, section.height
    web, (b, flange) = _plates(section)
    clear, lever = height - 2.0 * flange, A / W
    law["strength"] = squash_load, plastic_moment, plastic_moment
    share = web * clear / A
    law["web_share"], law["web_curve"] = inf, web * clear**2 / W / share**2
    if b > 0.0:
        law["web_share"] = share
        y = 0.5 * clear - 0.5 * web * clear / b
        between = 0.25 * height**2 - y**2
        law["flange_moment"], law["flange_curve"] = b * between / W, between * lever**2
        law["flange_lever"] = y * lever
    points = _POINTS
    if steel.rate is not None:
        q, points = steel.rate.exponent, _POINTS // 2
        law["reference"], law["exponent"] = steel.rate.reference_rate, q
        law["overstress"] = overstress_shape(section, q) * (0.5 * height * lever) ** (1.0 / q)
    growth = section.second_moment * A / W**2
    law["hardening"] = (steel.hardening_modulus or 0.0) / steel.yield_stress * growth
    law["points"] = 2 * points
    law["place"][: 2 * points], law["weight"][: 2 * points] = _quadrature(points)
    return law


def _plates(section: Section) -> tuple[float, tuple[float, float]]:
    """Thickness of the webs; width and thickness of the flanges, none of a rectangle (m)."""
    if isinstance(section.shape, Rectangle):
        return section.width, (0.0, 0.0)
    return section.shape.plates[0], section.flange_plates


@lru_cache(maxsize=4)
def _quadrature(count: int) -> tuple[Array, Array]:
    """Places and weights on a bar, `count` points t of Gauss from each end with xi = t^3 / 2."""
    t, weight = np.polynomial.legendre.leggauss(count)
    t, weight = 0.5 * (t + 1.0), 0.5 * weight
    place, weight = 0.5 * t**3, 1.5 * t**2 * weight
    return np.concatenate([place, 1.0 - place]), np.concatenate([weight, weight])
