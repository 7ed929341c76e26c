"""Rules of plastic interaction of axial force and moment, in n = |N|/N_p and m = |M|/M_p.

The exact curve of the section beside what practice puts in its place. A rule is its moment
capacity m(n); hinges take it as a convex polyline.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array, Flags
from workbench.errors import InputError
from workbench.sections import Section
from workbench.sections.envelope import superellipse_radius, where_it_ends
from workbench.sections.shapes import CircularTube, Rectangle

ANGLES = 181  # of the (n, m) plane between 0 and 90 degrees, as in the fit of super-ellipses
_STRAIGHT = 1e-9  # deviation from a straight line that counts as none


def _exact(section: Section, n: Array) -> Array:
    """The fully plastic section, between 721 points of its envelope."""
    return np.interp(n, *_envelope(section))


def _super_ellipse(section: Section, n: Array) -> Array:
    """Heng 2017, eq. 2.16, exponents fitted to the exact curve."""
    alpha, beta = section.interaction_fit()
    return np.asarray((1.0 - n**beta) ** (1.0 / alpha))


def _orbison(section: Section, n: Array) -> Array:
    """1.15 n^2 - 0.15 n^6 + m^2 + 3.67 n^2 m^2 = 1 (Orbison, McGuire and Abel 1982)."""
    return np.sqrt((1.0 - 1.15 * n**2 + 0.15 * n**6) / (1.0 + 3.67 * n**2))


def _attalla(section: Section, n: Array) -> Array:
    """0.19 n^6 + 0.54 m^6 - 1.40 n^4 - 1.64 m^4 + 2.21 n^2 + 2.10 m^2 = 1 (Attalla et al. 1994).

    The left side rises with m everywhere between 0 and 1.
    """
    of_n = 0.19 * n**6 - 1.40 * n**4 + 2.21 * n**2
    return where_it_ends(
        lambda m: of_n + 0.54 * m**6 - 1.64 * m**4 + 2.10 * m**2 < 1.0, np.ones_like(n)
    )


def _aisc(section: Section, n: Array) -> Array:
    """AISC 360, equations H1-1: n + 8/9 m = 1 from n = 0.2 on, n / 2 + m = 1 below."""
    return np.where(n >= 0.2, 9.0 / 8.0 * (1.0 - n), 1.0 - 0.5 * n)


def _eurocode(section: Section, n: Array) -> Array:
    """EN 1993-1-1, 6.2.9.1: (1 - n) / (1 - a/2) up to 1, a the share of the webs up to 1/2."""
    shape = section.shape
    if isinstance(shape, CircularTube):
        advice = "take exact or super-ellipse"
        raise InputError("surface", "eurocode", "has no rule for round tubes here", advice)
    if isinstance(shape, Rectangle):
        return np.asarray(1.0 - n**2)
    webs = 1.0 - 2.0 * section.width * shape.plates[1] / section.area
    return np.minimum(1.0, (1.0 - n) / (1.0 - 0.5 * min(webs, 0.5)))


def _linear(section: Section, n: Array) -> Array:
    """A straight line, m + n = 1."""
    return 1.0 - n


@cache
def _envelope(section: Section) -> tuple[Array, Array]:
    return section.interaction_envelope(4 * (ANGLES - 1) + 1)


_RULES: dict[str, Callable[[Section, Array], Array]] = {
    "exact": _exact,
    "super-ellipse": _super_ellipse,
    "orbison": _orbison,
    "attalla": _attalla,
    "aisc": _aisc,
    "eurocode": _eurocode,
    "linear": _linear,
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
