"""Shapes of cross sections, bent about the strong axis; heights run from the centroid.

All are doubly symmetric, so each states the layers of its upper half only. A shape is a sum of
bands: horizontal slices whose width is a constant plus a circular term. That covers plates, tubes,
discs and root fillets, so that area and moments are closed forms.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi, sin
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.fields import Declared, Number, checked

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
class Rectangle(Shape):
    """Solid rectangle, plate or square: `height` in the plane of bending and `width` (m)."""

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)

    WORD: ClassVar[str] = "rectangle"

    @property
    def plates(self) -> tuple[float, float]:
        """The whole width; nothing lies across."""
        return self.width, 0.0

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
