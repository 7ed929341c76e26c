"""A cross section: its name, its shape and what follows from them.

**Second part.** Shapes of cross sections in the plane of bending; heights run from the centroid.

All are doubly symmetric, so each states the layers of its upper half only. A shape is a sum of
bands: horizontal slices whose width is a constant plus a circular term. That covers plates, tubes,
discs and root fillets, so that area and moments are closed forms.

**Third part.** Exact plastic interaction of axial force and moment, and its super-elliptic fit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from math import pi, sin
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags
from workbench.base.errors import SolverError
from workbench.base.fields import Choice, Declared, Instance, Number, Text, checked
from workbench.steel.materials import Steel

DIMENSION = Number(0.002, 5.0, "m", advice="lengths are in metres, not millimetres")
FILLET = Number(0.0, 1.0, "m", advice="lengths are in metres, not millimetres")
_SMALLEST_FILLET = 1e-4  # m; smaller ones only cost digits


@dataclass(frozen=True, slots=True)
class Band:
    """A slice of material between the heights `bottom` and `top` above the centroid (m).

    Its width at height y is ``width + arc * sqrt(radius**2 - (y - centre)**2)``.
    """

    bottom: float
    top: float
    width: float
    arc: float = 0.0
    centre: float = 0.0
    radius: float = 0.0

    def cut(self, count: int) -> Layers:
        """The band alone, in `count` equal layers."""
        return Layers((self,), tuple(np.linspace(self.bottom, self.top, count + 1).tolist()))

    def width_at(self, height: ArrayLike) -> Array:
        """Width of the material at a height (m), zero outside the band."""
        y = np.asarray(height, float)
        root = np.sqrt(np.maximum(self.radius**2 - (y - self.centre) ** 2, 0.0))
        inside = (y >= self.bottom) & (y < self.top)
        return np.where(inside, self.width + self.arc * root, 0.0)

    def integrals(self, height: ArrayLike) -> tuple[Array, Array, Array]:
        """Area (m2), first (m3) and second moment (m4) of the part below a height (m).

        Moments are about the centroid of the whole shape, y = 0.
        """
        y = np.clip(np.asarray(height, float), self.bottom, self.top)
        depth, b = y - self.bottom, self.bottom  # factored: thin layers far out keep their digits
        area = self.width * depth
        first = area * (y + b) / 2.0
        second = area * (y**2 + y * b + b**2) / 3.0
        if self.arc:
            c = self.centre
            here = _arc_integrals(y - c, self.radius)
            start = _arc_integrals(np.asarray(self.bottom - c), self.radius)
            f0, f1, f2 = (self.arc * (a - b) for a, b in zip(here, start, strict=True))
            area = area + f0
            first = first + f1 + c * f0
            second = second + f2 + 2.0 * c * f1 + c**2 * f0
        return area, first, second


def _arc_integrals(x: Array, radius: float) -> tuple[Array, Array, Array]:
    """Antiderivatives of x**k sqrt(r**2 - x**2) for k = 0, 1, 2."""
    root = np.sqrt(np.maximum(radius**2 - x**2, 0.0))
    angle = np.arcsin(np.clip(x / radius, -1.0, 1.0))
    f0 = (x * root + radius**2 * angle) / 2.0
    f1 = -(root**3) / 3.0
    f2 = (x * (2.0 * x**2 - radius**2) * root + radius**4 * angle) / 8.0
    return f0, f1, f2


def half_integrals(bands: tuple[Band, ...], height: ArrayLike) -> tuple[Array, Array, Array]:
    """Area, first and second moment of all bands between the centroid and a height (m)."""
    parts = [band.integrals(height) for band in bands]
    area, first, second = (np.sum(terms, axis=0) for terms in zip(*parts, strict=True))
    return area, first, second


@dataclass(frozen=True, slots=True)
class Layers:
    """Bands to be cut into fibers together at the heights `edges` (m, rising)."""

    bands: tuple[Band, ...]
    edges: tuple[float, ...]

    def strips(self) -> tuple[Array, Array]:
        """Centroid height (m) and area (m2) of each layer."""
        area, first, _ = half_integrals(self.bands, np.asarray(self.edges))
        areas = np.diff(area)
        return np.diff(first) / areas, areas


class Shape(Declared, table="section"):
    """A doubly symmetric shape: `height` and `width` in m, and the following."""

    WORD: ClassVar[str]
    height: float
    width: float

    @property
    def plates(self) -> tuple[float, float]:
        """Thickness (m) of what stands upright and of what lies across its end."""
        raise NotImplementedError

    @property
    def turned(self) -> Shape:
        """The shape turned by 90 degrees: bent about its other axis."""
        raise NotImplementedError

    @property
    def shear_area(self) -> float:
        """Area of what stands upright, between the centre lines of what lies across, in m2."""
        upright, across = self.plates
        return upright * (self.height - across)

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """The upper half in groups that are cut into fibers by themselves.

        Plates upright and across are layered separately; those across get 40 % of the layers.
        """
        upright, across = self.plates
        clear, count = self.height / 2.0 - across, max(1, round(0.4 * half_count))
        web, flange = Band(0.0, clear, upright), Band(clear, self.height / 2.0, self.width)
        return web.cut(half_count - count), flange.cut(count)

    @property
    def bands(self) -> tuple[Band, ...]:
        """The bands that the upper half is the sum of."""
        return tuple(band for group in self.layers(2) for band in group.bands)

    @property
    def dimensions(self) -> dict[str, float]:
        """The dimensions by name, in m; those that are zero are left out."""
        return {f.name: size for f in fields(self) if (size := getattr(self, f.name))}

    def describe(self) -> str:
        """Name for sections outside the catalogue, dimensions in millimetres."""
        sizes = " x ".join(f"{1e3 * size:g}" for size in self.dimensions.values())
        return f"{self.WORD} {sizes} mm"

    def _below(self, name: str, limit: float, words: str) -> None:
        if not getattr(self, name) < limit:
            text = f"must be below {words}, {limit:.4g} m"
            raise self.refusal(name, text, "check the order of the dimensions")


@dataclass(frozen=True)
class ISection(Shape):
    """I or H section: `height`, `width`, `web` and `flange` thickness, root `fillet` (m).

    Raises `InputError` if the plates or fillets do not fit.
    """

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)
    web: float = checked(DIMENSION)
    flange: float = checked(DIMENSION)
    fillet: float = checked(FILLET, 0.0)

    WORD: ClassVar[str] = "I"

    def check(self) -> None:
        """Refuse what does not fit into the outline."""
        self._below("flange", self.height / 2.0, "half the height")
        self._below("web", self.width, "the width")
        room = min(self.height / 2.0 - self.flange, (self.width - self.web) / 2.0)
        if self.fillet > room or 0.0 < self.fillet < _SMALLEST_FILLET:
            least = f"must be 0, or at least {_SMALLEST_FILLET:g} m"
            allowed = f"{least} and at most {room:.4g} m to fit between web and flange"
            raise self.refusal("fillet", allowed, "check the root radius")

    @property
    def plates(self) -> tuple[float, float]:
        """Thickness of web and flange."""
        return self.web, self.flange

    @property
    def turned(self) -> TurnedISection:
        """The section bent about its weak axis."""
        return TurnedISection(self.width, self.height, self.web, self.flange, self.fillet)

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Web and flange layered separately, fillet strips on top of the web's."""
        plates = super().layers(half_count)
        if self.fillet == 0.0:
            return plates
        clear, r = self.height / 2.0 - self.flange, self.fillet
        # Width 2 (r - sqrt(r^2 - x^2)), x the distance from the web end of the fillet.
        fillets = Band(clear - r, clear, 2.0 * r, arc=-2.0, centre=clear - r, radius=r)
        return (*plates, fillets.cut(max(1, round(0.2 * half_count))))


@dataclass(frozen=True)
class TurnedISection(Shape):
    """I or H section bent about its weak axis: both flanges stand upright in the plane of bending.

    `height` is the width of the flanges, `width` the height of the section; other arguments as
    those of `ISection`, which checks them.
    """

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)
    web: float = checked(DIMENSION)
    flange: float = checked(DIMENSION)
    fillet: float = checked(FILLET, 0.0)

    WORD: ClassVar[str] = "I about the weak axis"

    @property
    def plates(self) -> tuple[float, float]:
        """Thickness of both flanges; the web lies on the axis, at no end of them."""
        return 2.0 * self.flange, 0.0

    @property
    def turned(self) -> ISection:
        """The section bent about its strong axis."""
        return ISection(self.width, self.height, self.web, self.flange, self.fillet)

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Flanges first, then the web as one layer, then the fillets at its faces."""
        core = Band(0.0, self.web / 2.0, self.width - 2.0 * self.flange)
        plates = Band(0.0, self.height / 2.0, 2.0 * self.flange).cut(half_count), core.cut(1)
        if self.fillet == 0.0:
            return plates
        r, end = self.fillet, self.web / 2.0 + self.fillet
        # Width 2 (r - sqrt(r^2 - x^2)), x the distance from the end of the fillet.
        fillets = Band(self.web / 2.0, end, 2.0 * r, arc=-2.0, centre=end, radius=r)
        return (*plates, fillets.cut(max(1, round(0.2 * half_count))))


@dataclass(frozen=True)
class Rectangle(Shape):
    """Solid rectangle, plate or square: `height` in the plane of bending and `width` (m)."""

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)

    WORD: ClassVar[str] = "rectangle"

    @property
    def plates(self) -> tuple[float, float]:
        """The whole width; nothing lies across."""
        return self.width, 0.0

    @property
    def turned(self) -> Rectangle:
        """The rectangle with its sides exchanged."""
        return Rectangle(self.width, self.height)

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Equal layers."""
        return (Band(0.0, self.height / 2.0, self.width).cut(half_count),)


@dataclass(frozen=True)
class RectangularTube(Shape):
    """Rectangular hollow section with sharp corners: `height`, `width`, `wall` (m).

    Raises `InputError` if the walls fill the tube.
    """

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)
    wall: float = checked(DIMENSION)

    WORD: ClassVar[str] = "tube"

    def check(self) -> None:
        """Refuse what does not fit into the outline."""
        least = min(self.height, self.width)
        self._below("wall", least / 2.0, "half the smaller side")

    @property
    def plates(self) -> tuple[float, float]:
        """Thickness of both walls that stand upright, and of one across."""
        return 2.0 * self.wall, self.wall

    @property
    def turned(self) -> RectangularTube:
        """The tube with its sides exchanged."""
        return RectangularTube(self.width, self.height, self.wall)


@dataclass(frozen=True)
class CircularTube(Shape):
    """Circular hollow section: outer `diameter` and `wall` thickness (m).

    Raises `InputError` if the wall fills the tube.
    """

    diameter: float = checked(DIMENSION)
    wall: float = checked(DIMENSION)

    WORD: ClassVar[str] = "tube, circular,"

    def check(self) -> None:
        """Refuse what does not fit into the outline."""
        self._below("wall", self.diameter / 2.0, "half the diameter")

    @property
    def height(self) -> float:  # type: ignore[override]
        """The diameter, in m."""
        return self.diameter

    width = height

    @property
    def plates(self) -> tuple[float, float]:
        """Thickness of both walls that stand upright, and of one across."""
        return 2.0 * self.wall, self.wall  # the shear area of a thin tube, 2 A / pi

    @property
    def turned(self) -> CircularTube:
        """The tube itself: all its axes are alike."""
        return self

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Outer disc less inner disc; each layer subtends the same angle of the outer circle."""
        outer = self.diameter / 2.0
        inner = outer - self.wall
        bands = (
            Band(0.0, outer, 0.0, arc=2.0, radius=outer),
            Band(0.0, inner, 0.0, arc=-2.0, radius=inner),
        )
        angles = (pi / 2.0 * i / half_count for i in range(half_count + 1))
        return (Layers(bands, tuple(outer * sin(angle) for angle in angles)),)


_LARGEST_EXPONENT, _MOST_STEPS = 20.0, 100


def envelope(shape: Shape, points: int) -> tuple[Array, Array]:
    """Axial force N/N_p and moment M/M_p of the fully plastic section, [points] each.

    The neutral axis moves from the centroid (pure bending) to the edge (pure axial force); the
    stress resultants are closed forms of its height. The points lie at equal angles
    atan2(n, m), each found by bisection to machine precision.
    """
    half, bands = shape.height / 2.0, shape.bands
    whole_area, whole_first, _ = half_integrals(bands, half)

    def resultants(axis: Array) -> tuple[Array, Array]:
        area, first, _ = half_integrals(bands, axis)
        return area / whole_area, 1.0 - first / whole_first

    angle = np.linspace(0.0, np.pi / 2.0, points)

    def too_low(axis: Array) -> Flags:
        n, m = resultants(axis)
        return n * np.cos(angle) < m * np.sin(angle)

    n, m = resultants(where_it_ends(too_low, np.full(points, half)))
    n[0], m[0], n[-1], m[-1] = 0.0, 1.0, 1.0, 0.0
    return n, m


def superellipse_radius(angle: Array, alpha: float, beta: float) -> Array:
    """Radius of |m|^alpha + |n|^beta = 1 at the angles atan2(n, m) in [0, pi/2]."""
    cosine, sine = np.cos(angle), np.sin(angle)

    def inside(radius: Array) -> Flags:
        return np.asarray((radius * cosine) ** alpha + (radius * sine) ** beta < 1.0)

    return where_it_ends(inside, np.full_like(angle, np.sqrt(2.0)))


def where_it_ends(below: Callable[[Array], Flags], high: Array) -> Array:
    """Return the ends of `below` between 0 and `high`, to the last bit, by bisection."""
    low = np.zeros_like(high)
    for _ in range(60):
        middle = (low + high) / 2.0
        left = below(middle)
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    return (low + high) / 2.0


@cache
def corner_share(shape: Shape, points: int = 181) -> float:
    """Axial force over N_p up to which a surface of straight lines keeps the plastic moment.

    The line falls from there to (N_p, 0), and the surface encloses the area A of the exact
    envelope: (1 + n) / 2 = A. It is within 0.06 M_p of that of I sections.
    """
    n, m = envelope(shape, points)
    return max(2.0 * float(np.trapezoid(m, n)) - 1.0, 0.0)


@cache
def fit_superellipse(shape: Shape, points: int = 181) -> tuple[float, float]:
    """Exponents (alpha of the moment, beta of the axial force) that fit the exact envelope.

    Least squares of the radii at equally spaced angles of the (n, m) plane, both exponents kept
    at 1 or above (below 1 the surface is not convex). Raises `SolverError`.
    """
    n, m = envelope(shape, points)
    angle = np.linspace(0.0, np.pi / 2.0, points)
    exponents = np.array([1.2, 1.6])
    for _ in range(_MOST_STEPS):  # of Gauss and Newton: scipy.optimize takes longer to import
        radius = superellipse_radius(angle, *exponents)
        sides = np.maximum(radius * (np.cos(angle), np.sin(angle)), 1e-99)
        powers = sides ** exponents[:, None]
        slopes = -radius * powers * np.log(sides) / (exponents @ powers)
        off = np.hypot(n, m) - radius
        free = np.clip(exponents + slopes @ off, 1.0, _LARGEST_EXPONENT) != exponents
        step = np.linalg.lstsq((slopes * free[:, None]).T, off)[0]
        last, exponents = exponents, np.clip(exponents + step, 1.0, _LARGEST_EXPONENT)
        if np.abs(exponents - last).max() < 1e-12:
            return float(exponents[0]), float(exponents[1])
    raise SolverError("super-elliptic fit", float(np.abs(off).max()), "steps of Gauss and Newton")


AXES = ("strong", "weak")
_WEAK = ", weak axis"  # in the name of a turned section
_ODD = "a layer on the centroid adds nothing to the moment: W_pl is lost"
_LAYERS = Number(4, 10_000, integer=True, even=True, advice=_ODD)
_POINTS = Number(3, 100_000, integer=True)


@dataclass(frozen=True)
class Section(Declared, table="section"):
    """A doubly symmetric cross section in its plane of bending; equal by its shape.

    `axis`: whether the `shape` is as named (strong) or turned by 90 degrees (weak).
    """

    name: str = checked(Text(), compare=False, help="a label that takes no part in comparisons")
    shape: Shape = checked(Instance(Shape, "use find(name) or a constructor such as i_section"))
    axis: str = checked(Choice(AXES), "strong", compare=False)

    def about(self, axis: str) -> Section:
        """Return the section bent about its strong or weak axis, which its name then says."""
        return self if axis == self.axis else self._turned

    @cached_property
    def _turned(self) -> Section:
        if self.axis == "strong":
            return Section(self.name + _WEAK, self.shape.turned, "weak")
        return Section(self.name.removesuffix(_WEAK), self.shape.turned)

    @property
    def height(self) -> float:
        """Overall height in the plane of bending, in m."""
        return self.shape.height

    @property
    def width(self) -> float:
        """Overall width, in m."""
        return self.shape.width

    @cached_property
    def _whole(self) -> tuple[float, float, float]:
        area, first, second = half_integrals(self.shape.bands, self.height / 2.0)
        return 2.0 * float(area), 2.0 * float(first), 2.0 * float(second)

    @property
    def area(self) -> float:
        """Area A, in m2."""
        return self._whole[0]

    @property
    def second_moment(self) -> float:
        """Second moment of area I about the axis of bending, in m4."""
        return self._whole[2]

    @property
    def elastic_section_modulus(self) -> float:
        """Elastic section modulus I / (h/2), in m3."""
        return self.second_moment / (self.height / 2.0)

    @property
    def plastic_section_modulus(self) -> float:
        """Plastic section modulus, in m3."""
        return self._whole[1]

    @property
    def shear_area(self) -> float:
        """Area that carries plastic shear in the plane of bending, in m2.

        I: t_w (h - t_f), the web between the flange centre lines; about the weak axis 2 b t_f;
        rectangle: A; rectangular tube: 2 t (h - t); circular tube: 2 A / pi. EN 1993-1-1, 6.2.6(3)
        allows more for rolled I sections, A - 2 b t_f + (t_w + 2 r) t_f, as it counts the fillets
        and the parts of the flanges between them; the smaller web area matches what a plane-stress
        web can carry.
        """
        return self.shape.shear_area

    def squash_load(self, steel: Steel) -> float:
        """Plastic axial resistance A f_y, in N."""
        return self.area * steel.yield_stress

    def plastic_moment(self, steel: Steel) -> float:
        """Plastic moment W_pl f_y without axial force, in N m."""
        return self.plastic_section_modulus * steel.yield_stress

    def shear_resistance(self, steel: Steel) -> float:
        """Plastic shear resistance A_v f_y / sqrt(3), in N."""
        return self.shear_area * steel.shear_yield_stress

    def width_at(self, height: ArrayLike) -> Array:
        """Width of the material (m) at heights above the centroid (m)."""
        y = np.abs(np.asarray(height, float))
        width: Array = np.sum([band.width_at(y) for band in self.shape.bands], axis=0)
        return width

    def fibers(self, layers: int = 20) -> tuple[Array, Array]:
        """Cut the section into strips: their heights (m, rising) and areas (m2), [n] each.

        `layers`, an even number from 4, counts equal layers over the whole depth; an I section
        or rectangular tube spends 40 % of them on its flanges (20: 4, 12, 4), and no layer
        straddles two plates. Root fillets add strips of their own. Area and plastic modulus are
        exact; the second moment lacks that of the strips about their own centroids (0.25 % of a
        rectangle in 20 layers). Raises `InputError`.
        """
        count = _LAYERS.check("layers", layers)
        groups = [group.strips() for group in self.shape.layers(int(count) // 2)]
        y, area = (np.concatenate(parts) for parts in zip(*groups, strict=True))
        order = np.argsort(y, kind="stable")
        y, area = y[order], area[order]
        return np.concatenate((-y[::-1], y)), np.concatenate((area[::-1], area))

    def interaction_envelope(self, points: int = 181) -> tuple[Array, Array]:
        """Exact plastic envelope: N/N_p rising from 0 to 1 and M/M_p, [points] each.

        The points lie at equal angles atan2(N/N_p, M/M_p). Raises `InputError`.
        """
        return envelope(self.shape, int(_POINTS.check("points", points)))

    def interaction_fit(self) -> tuple[float, float]:
        """Exponents (alpha, beta) of |m|^alpha + |n|^beta = 1 fitted to the exact envelope.

        Least squares of the radii at 181 equal angles, both at least 1. Raises `SolverError`.
        """
        return fit_superellipse(self.shape)

    def interaction_corner(self) -> float:
        """Share of N_p up to which a surface of straight lines leaves the plastic moment whole.

        Of the one with the area of the exact envelope.
        """
        return corner_share(self.shape)

    def without_fillets(self) -> Section:
        """Return the section as plates only; itself if it has no fillets."""
        return self._plates or self

    @cached_property
    def _plates(self) -> Section | None:
        shape = self.shape
        if not isinstance(shape, ISection | TurnedISection) or shape.fillet == 0.0:
            return None
        return Section(f"{self.name} without fillets", replace(shape, fillet=0.0), self.axis)

    @property
    def flange_plates(self) -> tuple[float, float]:
        """Width and thickness (m) of plates that stand for the flanges with their root fillets.

        With a web through the whole height between them, they have the area and the plastic
        modulus of the section.
        """
        upright, flange = self.shape.plates
        if self._plates is None:
            return self.width, flange
        beside = self.area - upright * self.height  # of the web, on both sides
        first = self.plastic_section_modulus - upright * self.height**2 / 4.0
        thickness = self.height - 2.0 * first / beside
        return upright + 0.5 * beside / thickness, thickness
