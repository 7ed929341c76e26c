"""Plastic interaction: super-elliptic N-M surfaces, rules of practice, domains of plates.

A rule gives m = |M|/M_p over n = |N|/N_p: the exact curve of the section, and what practice puts in
its place. Hinges with an option `surface` take it as a convex polyline; those of `four-dof` and of
superelements are super-elliptic, with exponents fitted here (`kernels`). Besides, domains: N-M-V of
webs, and the exact one of N, My and Mz of a section hit from any side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Instance, Number, checked
from workbench.steel.hinges import biaxial_kernels, panel_kernels
from workbench.steel.materials import Steel
from workbench.steel.sections import (
    CircularTube,
    ISection,
    Rectangle,
    RectangularTube,
    Section,
    Shape,
    TurnedISection,
)
from workbench.steel.sections.section import superellipse_radius, where_it_ends

_STRENGTH = Number(0.0, 1e12, "", low_included=False)
_EXPONENT = Number(
    1.0, 20.0, advice="exponents below 1 make the surface non-convex: flow would not be unique"
)
ANGLES = 181  # of the (n, m) plane between 0 and 90 degrees, as in the fit of super-ellipses
_FILLET = 0.2234  # of the root radius: distance of a fillet's centroid from both plates
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
        exponents = fitted_exponents(section, decimals)
        return cls(section.squash_load(steel), section.plastic_moment(steel), *exponents)


def fitted_exponents(section: Section, decimals: int | None = None) -> tuple[float, float]:
    """Exponents of the moment and of the axial force, see `YieldSurface.fit`."""
    alpha, beta = section.interaction_fit()
    if decimals is not None:
        alpha, beta = max(1.0, round(alpha, decimals)), max(1.0, round(beta, decimals))
    return alpha, beta


def _attalla(n: Array) -> Array:
    """Attalla et al. 1994; the left side rises with m everywhere between 0 and 1."""
    of_n = 0.19 * n**6 - 1.40 * n**4 + 2.21 * n**2
    return where_it_ends(
        lambda m: of_n + 0.54 * m**6 - 1.64 * m**4 + 2.10 * m**2 < 1.0, np.ones_like(n)
    )


def _eurocode(section: Section, n: Array) -> Array:
    """(1 - n) / (1 - a/2) up to 1, a the share of the webs up to 1/2.

    About the weak axis 1 up to n = a, from there on 1 - ((n - a) / (1 - a))^2.
    """
    shape = section.shape
    if isinstance(shape, CircularTube):
        advice = "take exact or super-ellipse"
        raise InputError("surface", "eurocode", "has no rule for round tubes here", advice)
    if isinstance(shape, Rectangle):
        return np.asarray(1.0 - n**2)
    if isinstance(shape, TurnedISection):
        a = min(1.0 - shape.plates[0] * section.height / section.area, 0.5)
        return np.asarray(1.0 - (np.maximum(n - a, 0.0) / (1.0 - a)) ** 2)
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


# Share of the area upright that is stiff in shear, by its energy (Cowper for the rectangle): that
# of turned I sections is 0.92 to 0.99 with fillets and 0.89 to 0.91 without.
SHEARED: dict[type[Shape], float] = {Rectangle: 5.0 / 6.0, TurnedISection: 0.9}
SHEAR_DEPTHS = ("centre", "clear")


def has_webs(section: Section) -> bool:
    """Whether a section has plane webs between flanges."""
    return isinstance(section.shape, ISection | RectangularTube)


def has_shear_surface(section: Section) -> bool:
    """Whether the N-M-V domain of a section is known: plates along the shear, or a solid."""
    return has_bar_law(section) or isinstance(section.shape, TurnedISection)


def has_bar_law(section: Section) -> bool:
    """Whether the law of a bar that yields gradually is known: plane webs, or a solid rectangle."""
    return has_webs(section) or isinstance(section.shape, Rectangle)


@dataclass(frozen=True)
class ShearSurface(Declared, table="shear_surface"):
    """Admissible N, M and V of flanges and webs: |M| <= M_c(|N|, |V|), |V| <= V_pl.

    Uniform shear stress in the webs, none in the flanges, von Mises: a lower bound of limit
    analysis, convex, and without shear the exact envelope of the plates. Against the exact set of
    one shear rate per section it lacks up to 0.015 M_p (HEB 220), 0.033 M_p (IPE 300). Root
    fillets carry no shear: they belong to the flanges, as plates that keep the area and the plastic
    modulus of the section (`Section.flange_plates`), within 0.2 % of its exact envelope.

    A solid rectangle has that exact set itself, as uniform shear stress would lack 0.144 M_p. The
    flanges of an I section bent about its weak axis are two of them; the web and the fillets at
    the axis carry axial force alone, which leaves out 0.6 % of the moment (HEB 220).

    Arguments: `section` with webs, or a solid rectangle; `steel`; `depth` of the webs that carries
    shear, between the flanges' centre lines or clear between them. Raises `InputError`.
    """

    section: Section = checked(Instance(Section))
    steel: Steel = checked(Instance(Steel), Steel())
    depth: str = checked(Choice(SHEAR_DEPTHS), "centre")

    def check(self) -> None:
        """Refuse sections of other kinds."""
        if not has_shear_surface(self.section):
            raise self.refusal(
                "section", "must have plane webs or be a solid rectangle or a turned I"
            )

    @cached_property
    def record(self) -> Any:
        """The section as the kernels take it."""
        shape, f_y = self.section.shape, self.steel.yield_stress
        if isinstance(shape, Rectangle | TurnedISection):
            return self._solid(shape)
        upright, flange = shape.plates
        area = upright * (shape.height - (2.0 if self.depth == "clear" else 1.0) * flange)
        b, flange = self.section.flange_plates
        clear, between = shape.height - 2.0 * flange, shape.height - flange
        web = np.zeros(np.shape(f_y), panel_kernels.WEB)
        web["shear"], web["stiffness"] = (
            area * self.steel.shear_yield_stress,
            area * self.steel.shear_modulus,
        )
        web["web_axial"], web["web_moment"] = upright * clear * f_y, upright * clear**2 * f_y / 4.0
        web["flange_axial"], web["flange_moment"] = (
            2.0 * b * flange * f_y,
            b * flange * between * f_y,
        )
        web["half_web"], web["half_height"] = clear / 2.0, shape.height / 2.0
        web["flanges"] = 2.0 * b * f_y
        return web[()]

    def _solid(self, shape: Rectangle | TurnedISection) -> Any:
        """The record of upright rectangles: all web, `SHEARED` of it stiff in shear."""
        area, f_y = shape.height * shape.plates[0], self.steel.yield_stress
        web = np.zeros(np.shape(f_y), panel_kernels.WEB)
        web["shear"] = area * self.steel.shear_yield_stress
        web["stiffness"] = SHEARED[type(shape)] * area * self.steel.shear_modulus
        web["flange_axial"] = (self.section.area - area) * f_y
        web["web_axial"], web["web_moment"] = area * f_y, area * shape.height * f_y / 4.0
        web["half_web"] = web["half_height"] = shape.height / 2.0
        web["solid"] = True
        return web[()]

    @property
    def shear_resistance(self) -> float:
        """Plastic shear resistance V_pl of the webs, in N."""
        return float(self.record["shear"])

    @property
    def squash_load(self) -> float:
        """Plastic axial resistance without shear, in N."""
        load: float = self.record["flange_axial"] + self.record["web_axial"]
        return load

    @property
    def plastic_moment(self) -> float:
        """Plastic moment (N m) of what it is made of, without axial and shear force."""
        moment: float = self.record["flange_moment"] + self.record["web_moment"]
        return moment

    @property
    def flange_mechanism(self) -> float:
        """Work (J) per radian of a panel whose flanges bend as plates at both ends, b t^2 f_y.

        Panels leave it out.
        """
        _, flange = self.section.shape.plates  # none in a solid rectangle
        return float(self.section.shape.width * flange**2 * self.steel.yield_stress)

    @property
    def web_slenderness(self) -> float:
        """Clear height over thickness of one web; 0 of solid rectangles and of flanges."""
        if isinstance(self.section.shape, Rectangle | TurnedISection):
            return 0.0
        upright, flange = self.section.shape.plates
        one = upright / (2.0 if isinstance(self.section.shape, RectangularTube) else 1.0)
        return (self.section.height - 2.0 * flange) / one

    def one_shear_rate(self, shear_share: ArrayLike) -> Array:
        """Exact moment capacity (N m) without axial force beside shares V / V_pl of the clear web.

        The web has one shear rate and plane sections: with the ratio s of the strain rate at its
        edge to the shear rate, V / V_pl = asinh(s) / s and M_w(s) / M_w = sqrt(1 + 1 / s^2) -
        asinh(s) / s^2. The uniform shear stress of the domain is a lower bound of it.
        """
        s = np.geomspace(1e-3, 1e6, 4000)
        share, web = np.arcsinh(s) / s, np.sqrt(1.0 + 1.0 / s**2) - np.arcsinh(s) / s**2
        wanted = np.asarray(shear_share, float)
        left = np.interp(wanted, [0.0, *share[::-1], 1.0], [1.0, *web[::-1], 0.0])
        return np.asarray(self.record["flange_moment"] + self.record["web_moment"] * left)

    def moment_capacity(self, axial_force: ArrayLike, shear_force: ArrayLike) -> Array:
        """M_c (N m) beside axial and shear forces (N) of any shapes that fit; NaN outside."""
        web = self.record
        n, v = np.broadcast_arrays(np.abs(axial_force), np.abs(shear_force) / web["shear"])
        rho = np.sqrt(np.maximum(1.0 - v**2, 0.0))
        moments = np.empty(n.shape)
        for i in np.ndindex(n.shape):
            moments[i] = panel_kernels.moment_capacity(web, n[i], rho[i])[0]
        inside = (v <= 1.0) & (n <= web["flange_axial"] + rho * web["web_axial"])
        return np.where(inside, moments, np.nan)


def rectangles(section: Section) -> Array:
    """Rectangles that a section is the sum of: y, z of the centre, half sides, sign (n, 5), in m.

    A root fillet is a square of its area about its centroid; a hollow section one less another.
    Empty for round tubes.
    """
    shape = section.shape
    if isinstance(shape, Rectangle):
        return np.array([[0.0, 0.0, shape.height / 2.0, shape.width / 2.0, 1.0]])
    if isinstance(shape, RectangularTube):
        outer = np.array([0.0, 0.0, shape.height / 2.0, shape.width / 2.0, 1.0])
        wall = np.array([0.0, 0.0, shape.wall, shape.wall, 2.0])
        return np.stack([outer, outer - wall])
    if not isinstance(shape, ISection):
        return np.empty((0, 5))
    middle, clear = (shape.height - shape.flange) / 2.0, shape.height / 2.0 - shape.flange
    flange = shape.flange / 2.0, shape.width / 2.0, 1.0
    plates = [[side * middle, 0.0, *flange] for side in (1.0, -1.0)]
    plates.append([0.0, 0.0, clear, shape.web / 2.0, 1.0])
    if shape.fillet:
        half = 0.5 * sqrt(1.0 - pi / 4.0) * shape.fillet
        y, z = clear - _FILLET * shape.fillet, shape.web / 2.0 + _FILLET * shape.fillet
        plates += [[a * y, b * z, half, half, 1.0] for a in (1, -1) for b in (1, -1)]
    return np.array(plates)


@dataclass(frozen=True)
class BiaxialSurface(Declared, table="biaxial_surface"):
    """Admissible N, My and Mz of a `section`, all over the plastic ones. Raises `InputError`.

    y runs along the height of a section, z along its width: My bends about the strong axis of an I
    section, Mz about its weak one.

    Convex, since it is the set of all stresses within the yield stress. Rules of practice lie up
    to 27 % outside of it between the planes, and not all of them are convex.
    """

    section: Section = checked(Instance(Section))

    @cached_property
    def record(self) -> Any:
        """The surface as the kernels take it."""
        surface = np.zeros((), biaxial_kernels.SURFACE)
        shape, parts = self.section.shape, rectangles(self.section)
        if isinstance(shape, CircularTube):
            radii = shape.diameter / 2.0 - np.array([0.0, shape.wall])
            signs = np.array([1.0, -1.0])
            area, first = pi * signs @ radii**2, 4.0 / 3.0 * signs @ radii**3
            surface["discs"] = np.stack([pi * signs * radii**2, radii * area**2 / first], 1) / area
            return surface[()]
        count, areas = len(parts), 4.0 * parts[:, 2] * parts[:, 3] * parts[:, 4]
        surface["count"], surface["share"][:count] = count, areas / areas.sum()
        g, H = np.empty(3), np.empty((3, 3))
        for axis, (centre, half) in enumerate((("y", "half_y"), ("z", "half_z")), 1):
            surface[centre][:count] = parts[:, axis - 1]
            surface[half][:count] = parts[:, axis + 1]
            pure = biaxial_kernels.support(surface[()], np.eye(3)[axis], g, H)  # W / A
            surface[centre] /= pure
            surface[half] /= pure
        return surface[()]

    def support(self, flow: ArrayLike) -> tuple[float, Array, Array]:
        """Dissipation of a `flow` times the plastic forces (3,), its gradient and its Hessian."""
        g, H = np.empty(3), np.empty((3, 3))
        return biaxial_kernels.support(self.record, np.array(flow, float), g, H), g, H

    def gauge(self, forces: ArrayLike) -> Array:
        """How far out forces (..., 3) over the plastic ones are: 1 on the surface, 0 without."""
        given, g, H = np.array(forces, float), np.empty(3), np.empty((3, 3))
        gauges, room = np.empty(given.shape[:-1]), np.zeros(1, biaxial_kernels.ROOM)[0]
        for i in np.ndindex(gauges.shape):
            searched = self.record, given[i], given[i].copy(), g, H, room, False
            gauges[i] = biaxial_kernels.gauge(*searched)
        return gauges


surface_in_space = lru_cache(maxsize=256)(BiaxialSurface)
