"""Area and moments of the upper half of a doubly symmetric shape, in closed form.

A shape is a sum of bands: horizontal slices whose width is a constant plus a circular term.
That covers plates, tubes, discs and root fillets, so that nothing is integrated numerically.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array


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
