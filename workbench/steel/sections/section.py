"""A cross section: its name, its shape and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.base.fields import Declared, Instance, Number, Text, checked
from workbench.steel.materials import Steel
from workbench.steel.sections.envelope import corner_share, envelope, fit_superellipse
from workbench.steel.sections.shapes import ISection, Shape, half_integrals

_LAYERS = Number(4, 10_000, integer=True)
_POINTS = Number(3, 100_000, integer=True)


@dataclass(frozen=True)
class Section(Declared, table="section"):
    """A doubly symmetric cross section bent about its strong axis; equal by its shape."""

    name: str = checked(Text(), compare=False, help="a label that takes no part in comparisons")
    shape: Shape = checked(Instance(Shape, "use find(name) or a constructor such as i_section"))

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
        """Second moment of area I about the strong axis, in m4."""
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

        I: t_w (h - t_f), the web between the flange centre lines; rectangle: A; rectangular
        tube: 2 t (h - t); circular tube: 2 A / pi. EN 1993-1-1, 6.2.6(3) allows more for rolled
        I sections, A - 2 b t_f + (t_w + 2 r) t_f, as it counts the fillets and the parts of the
        flanges between them; the smaller web area matches what a plane-stress web can carry.
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
        if count % 2:
            advice = "a layer on the centroid adds nothing to the moment: W_pl is lost"
            raise InputError("layers", layers, "must be even", advice)
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
        if not isinstance(shape, ISection) or shape.fillet == 0.0:
            return None
        plates = ISection(shape.height, shape.width, shape.web, shape.flange)
        return Section(f"{self.name} without fillets", plates)

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
