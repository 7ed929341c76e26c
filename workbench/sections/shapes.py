"""Shapes of cross sections, bent about the strong axis; heights run from the centroid.

All are doubly symmetric, so each states the bands of its upper half only.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sin

from workbench.errors import InputError
from workbench.fields import Number, check_fields, checked
from workbench.sections.bands import Band, Layers, equal_layers

DIMENSION = Number(0.002, 5.0, "m", advice="lengths are in metres, not millimetres")
FILLET = Number(0.0, 1.0, "m", advice="lengths are in metres, not millimetres")
_SMALLEST_FILLET = 1e-4  # m; smaller ones only cost digits


@dataclass(frozen=True)
class ISection:
    """I or H section: `height`, `width`, `web` and `flange` thickness, root `fillet` (m).

    Raises `InputError` if the plates or fillets do not fit.
    """

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)
    web: float = checked(DIMENSION)
    flange: float = checked(DIMENSION)
    fillet: float = checked(FILLET, 0.0)

    def __post_init__(self) -> None:
        check_fields(self, "section")
        _below("flange", self.flange, self.height / 2.0, "half the height")
        _below("web", self.web, self.width, "the width")
        room = min(self.height / 2.0 - self.flange, (self.width - self.web) / 2.0)
        if self.fillet > room or 0.0 < self.fillet < _SMALLEST_FILLET:
            least = f"must be 0, or at least {_SMALLEST_FILLET:g} m"
            allowed = f"{least} and at most {room:.4g} m to fit between web and flange"
            raise InputError("section.fillet", self.fillet, allowed, "check the root radius")

    @property
    def bands(self) -> tuple[Band, ...]:
        """Web, flange and the two fillets of the upper half."""
        clear = self.height / 2.0 - self.flange
        plates = (Band(0.0, clear, self.web), Band(clear, self.height / 2.0, self.width))
        return plates + self._fillets()

    def _fillets(self) -> tuple[Band, ...]:
        if self.fillet == 0.0:
            return ()
        clear = self.height / 2.0 - self.flange
        r = self.fillet
        # Width 2 (r - sqrt(r^2 - x^2)), x the distance from the web end of the fillet.
        return (Band(clear - r, clear, 2.0 * r, arc=-2.0, centre=clear - r, radius=r),)

    @property
    def shear_area(self) -> float:
        """Area of the web between the flange centre lines, in m2."""
        return self.web * (self.height - self.flange)

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Web and flange layered separately, fillet strips on top of the web's (upper half)."""
        flange = max(1, round(0.4 * half_count))
        clear, top = self.height / 2.0 - self.flange, self.height / 2.0
        web_band, flange_band = self.bands[:2]
        result = [
            Layers((web_band,), equal_layers(0.0, clear, half_count - flange)),
            Layers((flange_band,), equal_layers(clear, top, flange)),
        ]
        if fillets := self._fillets():
            strips = max(1, round(0.2 * half_count))
            result.append(Layers(fillets, equal_layers(clear - self.fillet, clear, strips)))
        return tuple(result)

    def describe(self) -> str:
        """Name for sections outside the catalogue, dimensions in millimetres."""
        sizes = [self.height, self.width, self.web, self.flange]
        return "I " + _millimetres(*sizes, *([self.fillet] if self.fillet else []))


@dataclass(frozen=True)
class Rectangle:
    """Solid rectangle, plate or square: `height` in the plane of bending and `width` (m)."""

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)

    def __post_init__(self) -> None:
        check_fields(self, "section")

    @property
    def bands(self) -> tuple[Band, ...]:
        """The upper half."""
        return (Band(0.0, self.height / 2.0, self.width),)

    @property
    def shear_area(self) -> float:
        """The whole area, in m2."""
        return self.height * self.width

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Equal layers."""
        return (Layers(self.bands, equal_layers(0.0, self.height / 2.0, half_count)),)

    def describe(self) -> str:
        """Name for sections outside the catalogue, dimensions in millimetres."""
        return "rectangle " + _millimetres(self.height, self.width)


@dataclass(frozen=True)
class RectangularTube:
    """Rectangular hollow section with sharp corners: `height`, `width`, `wall` (m).

    Raises `InputError` if the walls fill the tube.
    """

    height: float = checked(DIMENSION)
    width: float = checked(DIMENSION)
    wall: float = checked(DIMENSION)

    def __post_init__(self) -> None:
        check_fields(self, "section")
        least = min(self.height, self.width)
        _below("wall", self.wall, least / 2.0, "half the smaller side")

    @property
    def bands(self) -> tuple[Band, ...]:
        """The two side walls and the upper wall."""
        clear = self.height / 2.0 - self.wall
        return (
            Band(0.0, clear, 2.0 * self.wall),
            Band(clear, self.height / 2.0, self.width),
        )

    @property
    def shear_area(self) -> float:
        """The two side walls between the centre lines of the others, in m2."""
        return 2.0 * self.wall * (self.height - self.wall)

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Side walls and upper wall layered separately (upper half)."""
        across = max(1, round(0.4 * half_count))
        clear, top = self.height / 2.0 - self.wall, self.height / 2.0
        sides, upper = self.bands
        return (
            Layers((sides,), equal_layers(0.0, clear, half_count - across)),
            Layers((upper,), equal_layers(clear, top, across)),
        )

    def describe(self) -> str:
        """Name for sections outside the catalogue, dimensions in millimetres."""
        return "tube " + _millimetres(self.height, self.width, self.wall)


@dataclass(frozen=True)
class CircularTube:
    """Circular hollow section: outer `diameter` and `wall` thickness (m).

    Raises `InputError` if the wall fills the tube.
    """

    diameter: float = checked(DIMENSION)
    wall: float = checked(DIMENSION)

    def __post_init__(self) -> None:
        check_fields(self, "section")
        _below("wall", self.wall, self.diameter / 2.0, "half the diameter")

    @property
    def height(self) -> float:
        """The diameter, in m."""
        return self.diameter

    @property
    def width(self) -> float:
        """The diameter, in m."""
        return self.diameter

    @property
    def bands(self) -> tuple[Band, ...]:
        """Outer disc less inner disc (upper half)."""
        outer = self.diameter / 2.0
        inner = outer - self.wall
        return (
            Band(0.0, outer, 0.0, arc=2.0, radius=outer),
            Band(0.0, inner, 0.0, arc=-2.0, radius=inner),
        )

    @property
    def shear_area(self) -> float:
        """2 A / pi, in m2 (thin circular tube)."""
        return 2.0 * self.wall * (self.diameter - self.wall)

    def layers(self, half_count: int) -> tuple[Layers, ...]:
        """Horizontal layers that each subtend the same angle of the outer circle."""
        outer = self.diameter / 2.0
        angles = (pi / 2.0 * i / half_count for i in range(half_count + 1))
        return (Layers(self.bands, tuple(outer * sin(angle) for angle in angles)),)

    def describe(self) -> str:
        """Name for sections outside the catalogue, dimensions in millimetres."""
        return "tube, circular, " + _millimetres(self.diameter, self.wall)


Shape = ISection | Rectangle | RectangularTube | CircularTube


def _below(name: str, value: float, limit: float, words: str) -> None:
    if not value < limit:
        allowed = f"must be below {words}, {limit:.4g} m"
        raise InputError(f"section.{name}", value, allowed, "check the order of the dimensions")


def _millimetres(*sizes: float) -> str:
    return " x ".join(f"{1e3 * size:g}" for size in sizes) + " mm"
