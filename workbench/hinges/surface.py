"""Super-elliptic yield surfaces in the plane of axial force and moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.fields import Declared, Number, checked
from workbench.materials import Steel
from workbench.sections import Section

_STRENGTH = Number(0.0, 1e12, "", low_included=False)
_EXPONENT = Number(
    1.0, 20.0, advice="exponents below 1 make the surface non-convex: flow would not be unique"
)


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
