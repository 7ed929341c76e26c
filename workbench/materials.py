"""Structural steel as the models use it."""

from dataclasses import dataclass
from math import sqrt

from workbench.fields import Declared, Number, checked

POISSON_RATIO = 0.3


@dataclass(frozen=True)
class Steel(Declared, table="steel"):
    """Elastic-perfectly plastic structural steel.

    Arguments: `elastic_modulus` in Pa, `yield_stress` in Pa, `density` in kg/m3. Raises
    `InputError` for values that no structural steel has (wrong units are the usual cause).
    """

    elastic_modulus: float = checked(
        Number(1e10, 1e12, "Pa", advice="moduli are in Pa: 210 GPa is 210e9"), 210e9
    )
    yield_stress: float = checked(
        Number(1e7, 3e9, "Pa", advice="stresses are in Pa: 355 MPa is 355e6"), 355e6
    )
    density: float = checked(
        Number(1e3, 3e4, "kg/m3", advice="densities are in kg/m3: steel has 7850"), 7850.0
    )

    @property
    def shear_yield_stress(self) -> float:
        """Von Mises yield stress in pure shear, fy / sqrt(3), in Pa (EN 1993-1-1, 6.2.6)."""
        return self.yield_stress / sqrt(3.0)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus with Poisson's ratio 0.3, in Pa."""
        return self.elastic_modulus / (2.0 * (1.0 + POISSON_RATIO))
