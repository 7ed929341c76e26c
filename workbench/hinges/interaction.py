"""Plastic interaction of axial force and moment: super-elliptic surfaces, rules of practice.

A rule gives m = |M|/M_p over n = |N|/N_p: the exact curve of the section, and what practice puts in
its place. Hinges take it as a convex polyline.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array, Flags
from workbench.errors import InputError
from workbench.fields import Declared, Number, checked
from workbench.materials import Steel
from workbench.sections import Section
from workbench.sections.envelope import superellipse_radius, where_it_ends
from workbench.sections.shapes import CircularTube, Rectangle

_STRENGTH = Number(0.0, 1e12, "", low_included=False)
_EXPONENT = Number(
    1.0, 20.0, advice="exponents below 1 make the surface non-convex: flow would not be unique"
)
ANGLES = 181  # of the (n, m) plane between 0 and 90 degrees, as in the fit of super-ellipses
_STRAIGHT = 1e-9  # deviation from a straight line that counts as none


@dataclass(frozen=True)
class YieldSurface(Declared, table="yield_surface"):
    """Admissible forces |M/M_p|^alpha + |N/N_p|^beta <= 1 (Heng 2017, eqs 2.16 and 2.18-2.19).

    Arguments: `squash_load` in N and `plastic_moment` in N m, for tension and for positive
    moment; exponents `alpha` (moment) and `beta` (axial force), at least 1;
    `squash_load_compression` and `plastic_moment_negative`, the other bounds of an asymmetric
    surface (None: symmetric); as a sum of convex terms it is convex with any two exponents. The
    exponent gamma of the thesis rescales the plastic multiplier only and is therefore not a
    parameter. Raises `InputError`.
    """

    squash_load: float = checked(_STRENGTH)
    plastic_moment: float = checked(_STRENGTH)
    alpha: float = checked(_EXPONENT, 1.0)
    beta: float = checked(_EXPONENT, 1.0)
    squash_load_compression: float | None = checked(_STRENGTH, optional=True)
    plastic_moment_negative: float | None = checked(_STRENGTH, optional=True)

    @property
    def axial_bounds(self) -> tuple[float, float]:
        """Plastic axial resistance in tension and in compression, in N."""
        return self.squash_load, self.squash_load_compression or self.squash_load

    @property
    def moment_bounds(self) -> tuple[float, float]:
        """Plastic moment for positive and for negative moment, in N m."""
        return self.plastic_moment, self.plastic_moment_negative or self.plastic_moment

    def utilisation(self, axial_force: ArrayLike, moment: ArrayLike) -> Array:
        """Left side of the yield condition: below 1 elastic, 1 on the surface (arrays, N, N m)."""
        force, bending = np.asarray(axial_force, float), np.asarray(moment, float)
        n = np.where(force >= 0.0, force / self.axial_bounds[0], -force / self.axial_bounds[1])
        m = np.where(
            bending >= 0.0, bending / self.moment_bounds[0], -bending / self.moment_bounds[1]
        )
        return np.asarray(m**self.alpha + n**self.beta)

    @classmethod
    def fit(cls, section: Section, steel: Steel, decimals: int | None = None) -> YieldSurface:
        """The surface of a section, exponents fitted to its exact plastic N-M envelope.

        `decimals` rounds the exponents (never below 1): the thesis states them to one decimal.
        """
        alpha, beta = section.interaction_fit()
        if decimals is not None:
            alpha, beta = max(1.0, round(alpha, decimals)), max(1.0, round(beta, decimals))
        return cls(section.squash_load(steel), section.plastic_moment(steel), alpha, beta)


def _attalla(n: Array) -> Array:
    """Attalla et al. 1994; the left side rises with m everywhere between 0 and 1."""
    of_n = 0.19 * n**6 - 1.40 * n**4 + 2.21 * n**2
    return where_it_ends(
        lambda m: of_n + 0.54 * m**6 - 1.64 * m**4 + 2.10 * m**2 < 1.0, np.ones_like(n)
    )


def _eurocode(section: Section, n: Array) -> Array:
    """(1 - n) / (1 - a/2) up to 1, a the share of the webs up to 1/2."""
    shape = section.shape
    if isinstance(shape, CircularTube):
        advice = "take exact or super-ellipse"
        raise InputError("surface", "eurocode", "has no rule for round tubes here", advice)
    if isinstance(shape, Rectangle):
        return np.asarray(1.0 - n**2)
    webs = 1.0 - 2.0 * section.width * shape.plates[1] / section.area
    return np.minimum(1.0, (1.0 - n) / (1.0 - 0.5 * min(webs, 0.5)))


def _super_ellipse(section: Section, n: Array) -> Array:
    alpha, beta = section.interaction_fit()
    return np.asarray((1.0 - n**beta) ** (1.0 / alpha))


@cache
def _envelope(section: Section) -> tuple[Array, Array]:
    return section.interaction_envelope(4 * (ANGLES - 1) + 1)


_RULES: dict[str, Callable[[Section, Array], Array]] = {
    # the fully plastic section, between 721 points of its envelope
    "exact": lambda section, n: np.interp(n, *_envelope(section)),
    # Heng 2017, eq. 2.16, exponents fitted to the exact curve
    "super-ellipse": _super_ellipse,
    # 1.15 n^2 - 0.15 n^6 + m^2 + 3.67 n^2 m^2 = 1 (Orbison, McGuire and Abel 1982)
    "orbison": lambda _, n: np.sqrt((1.0 - 1.15 * n**2 + 0.15 * n**6) / (1.0 + 3.67 * n**2)),
    # 0.19 n^6 + 0.54 m^6 - 1.40 n^4 - 1.64 m^4 + 2.21 n^2 + 2.10 m^2 = 1
    "attalla": lambda _, n: _attalla(n),
    # AISC 360, equations H1-1: n + 8/9 m = 1 from n = 0.2 on, n / 2 + m = 1 below
    "aisc": lambda _, n: np.where(n >= 0.2, 9.0 / 8.0 * (1.0 - n), 1.0 - 0.5 * n),
    "eurocode": _eurocode,  # EN 1993-1-1, 6.2.9.1
    "linear": lambda _, n: 1.0 - n,
}
RULES = tuple(_RULES)


def moment_capacity(rule: str, section: Section, axial: ArrayLike) -> Array:
    """Moment over M_p at axial forces over N_p between 0 and 1. Raises `InputError`."""
    if rule not in _RULES:
        raise InputError("surface", rule, "must be one of " + ", ".join(RULES))
    return np.asarray(_RULES[rule](section, np.clip(np.asarray(axial, dtype=float), 0.0, 1.0)))


def radius(rule: str, section: Section, angle: ArrayLike) -> Array:
    """Distance of the curve from the origin at the angles atan2(n, m) (rad)."""
    turned = np.asarray(angle, dtype=float)
    if rule == "super-ellipse":
        return superellipse_radius(turned, *section.interaction_fit())
    cosine, sine = np.cos(turned), np.sin(turned)

    def inside(r: Array) -> Flags:
        n = r * sine
        return np.asarray((n < 1.0) & (r * cosine < moment_capacity(rule, section, n)))

    return where_it_ends(inside, np.full_like(turned, np.sqrt(2.0)))


def radial_error(rule: str, section: Section) -> tuple[float, float, float]:
    """Least, largest and root-mean-square deviation of the radii from the exact ones."""
    angle = np.linspace(0.0, 0.5 * np.pi, ANGLES)
    error = radius(rule, section, angle) / np.hypot(*section.interaction_envelope(ANGLES)) - 1.0
    return float(error.min()), float(error.max()), float(np.sqrt(np.mean(error**2)))


def polyline(rule: str, section: Section) -> Array:
    """Corners n and m (2, corners) of the curve as a concave polyline from (0, 1) to (1, 0).

    At equal angles, the corners of rules of straight lines among them. Hinges flow normal to it,
    which is unique on convex domains only: the hull takes the place of a curve that is not.
    """
    angle = np.linspace(0.0, 0.5 * np.pi, ANGLES)
    n = radius(rule, section, angle) * np.sin(angle)
    bends = [0.2] if rule == "aisc" else []
    if rule == "eurocode":  # its inclined line goes through (1, 0)
        bends = [1.0 - 0.5 / float(moment_capacity(rule, section, 0.5))]
    n = np.union1d(np.clip(n, 0.0, 1.0), bends)
    m = moment_capacity(rule, section, n)
    n[0], m[0], n[-1], m[-1] = 0.0, 1.0, 1.0, 0.0
    kept: list[tuple[float, float]] = []
    for x, y in zip(n, m, strict=True):
        while len(kept) > 1:
            (x0, y0), (x1, y1) = kept[-2:]
            if (y1 - y0) * (x - x0) > (y - y0) * (x1 - x0) + _STRAIGHT * (x - x0):
                break
            kept.pop()
        kept.append((float(x), float(y)))
    return np.array(kept).T
