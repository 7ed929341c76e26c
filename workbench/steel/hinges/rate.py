"""Strain rate in yielding: a plastic hinge in closed form, and bars that flow at their points.

Along a straight moment diagram from mu M_p to zero over a distance L, only the sections with more
than M_p flow, each at the rate of its overstress (Cowper and Symonds). The integral of their
curvature rates is the rotation rate of the hinge, which has no length of its own: a faster hinge is
longer. Viscoplastic bars have the gauge of an envelope, overstress, hardening, points, of plates
with the area and the plastic modulus of the section: root fillets are in the flanges, as
`Section.flange_plates` has them, so that N_p and M_p are met. Derivation and checks:
docs/theory/strain-rate.md.
"""

from functools import lru_cache
from math import inf, sqrt
from typing import Any

import numpy as np

from workbench.base.arrays import Array
from workbench.steel.hinges.flow_kernels import LAW, MOST
from workbench.steel.hinges.interaction import ShearSurface
from workbench.steel.materials import CowperSymonds, Steel
from workbench.steel.sections import Rectangle, Section

_ITERATIONS, _LAYERS = 60, 400
_POINTS = MOST // 2  # of each end; with rate, which smooths where flow begins, half of them
_SHEARED = 8  # of each end, of bars whose web yields in shear


@lru_cache(maxsize=256)
def overstress_shape(section: Section, exponent: float) -> float:
    """Overstress moment over that of a section whose fibers all have the rate of its edge.

    c = (2 / h)^(1/q) / W_pl integral |y|^(1 + 1/q) dA; 10/11 of a rectangle with q = 5.
    """
    heights, areas = section.fibers(_LAYERS)
    relative = np.abs(heights) / (0.5 * section.height)
    return float(np.sum(areas * relative ** (1.0 + 1.0 / exponent)) / np.sum(areas * relative))


def rotation_rate(
    overstress: float, length: float, height: float, shape: float, law: CowperSymonds
) -> float:
    """Rotation rate (rad/s) of a hinge whose moment is (1 + `overstress`) M_p.

    Arguments: `length` (m) from the hinge to the zero of moment, `height` of the section (m),
    `shape` of its overstress.
    """
    q, D = law.exponent, law.reference_rate
    share = overstress ** (q + 1.0) / ((q + 1.0) * (1.0 + overstress))
    return float(2.0 * D * length / (height * shape**q) * share)


def hinge_overstress(
    rate: float, length: float, height: float, shape: float, law: CowperSymonds
) -> float:
    """Inverse of `rotation_rate`: mu - 1 at a rotation rate (rad/s)."""
    q, D = law.exponent, law.reference_rate
    with np.errstate(divide="ignore", invalid="ignore"):
        wanted: Any = np.log((q + 1.0) * shape**q * height * rate / (2.0 * D * length))
        logarithm, open_ = wanted / (q + 1.0), True
        for _ in range(_ITERATIONS):  # Newton in ln x: rising, concave, slope between q and q + 1
            x = np.exp(logarithm)
            change = ((q + 1.0) * logarithm - np.log1p(x) - wanted) / (q + 1.0 - x / (1.0 + x))
            logarithm = logarithm - np.where(open_, change, 0.0)[()]
            open_ = np.logical_and(open_, abs(change) > 1e-14 * np.maximum(1.0, abs(logarithm)))
            if not np.any(open_):
                break
        whole: Any = np.where(wanted > -np.inf, np.exp(logarithm), 0.0)
    over: float = whole[()]
    return over


def panel_overstress(rate: float, law: CowperSymonds) -> float:
    """V / V_pl - 1 of a web at the plastic shear strain rate (1/s), uniform along its bar."""
    return law.factor(rate / sqrt(3.0)) - 1.0


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
    c, points = 0.0, _POINTS
    if steel.rate is not None:
        q, points = steel.rate.exponent, _POINTS // 2
        law["reference"], law["exponent"] = steel.rate.reference_rate, q
        c = overstress_shape(section, q) * (0.5 * height * lever) ** (1.0 / q)
    growth = section.second_moment * A / W**2
    law["whole"] = 1.0, 1.0, c, _hardening(steel) * growth
    _spread(law, points)
    return law


def panel_law(surface: ShearSurface) -> Any:
    """The record of a bar whose web yields in shear: flanges and web flow at rates of their own.

    Overstress and hardening are exact in a web that slides and in flanges that bend.
    """
    plates, steel = surface.record, surface.steel
    N = plates["flange_axial"] + plates["web_axial"]
    M = plates["flange_moment"] + plates["web_moment"]
    law = bar_law(surface.section, steel, N, M)
    law["shear"], law["half_web"] = plates["shear"], plates["half_web"] * N / M
    law["spread"] = N**2 / (2.0 * plates["flanges"] * M)
    e, a, sliding = plates["half_height"], plates["half_web"], plates["web_axial"]
    sliding /= sqrt(3.0) * plates["shear"]
    bent = 4.0 / 3.0 * (e**3 - a**3) * (e - a) / (e**2 - a**2) ** 2  # I A / W^2 of both flanges
    flanges = web = 0.0
    if steel.rate is not None:
        p = 1.0 / steel.rate.exponent
        flanges = 2.0 * (e ** (2.0 + p) - a ** (2.0 + p)) / ((2.0 + p) * (e**2 - a**2))
        flanges, web = flanges * (2.0 / (e + a)) ** p, sliding**p
    H = _hardening(steel)
    law["flanges"] = plates["flange_axial"] / N, plates["flange_moment"] / M, flanges, H * bent
    law["web"] = plates["web_axial"] / N, plates["web_moment"] / M, web, H * sliding
    _spread(law, _SHEARED)
    return law


def _hardening(steel: Steel) -> float:
    """Hardening modulus over the yield stress."""
    return (steel.hardening_modulus or 0.0) / steel.yield_stress


def _plates(section: Section) -> tuple[float, tuple[float, float]]:
    """Thickness of the webs; width and thickness of the flanges, none of a rectangle (m)."""
    if isinstance(section.shape, Rectangle):
        return section.width, (0.0, 0.0)
    return section.shape.plates[0], section.flange_plates


def _spread(law: Any, points: int) -> None:
    """Write the points of each end and their weights."""
    law["points"] = 2 * points
    law["place"][: 2 * points], law["weight"][: 2 * points] = _quadrature(points)


@lru_cache(maxsize=4)
def _quadrature(count: int) -> tuple[Array, Array]:
    """Places and weights on a bar, `count` points t of Gauss from each end with xi = t^3 / 2."""
    t, weight = np.polynomial.legendre.leggauss(count)
    t, weight = 0.5 * (t + 1.0), 0.5 * weight
    place, weight = 0.5 * t**3, 1.5 * t**2 * weight
    return np.concatenate([place, 1.0 - place]), np.concatenate([weight, weight])
