"""The von Mises law of a fiber with normal and shear stress, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.structures.uniaxial import _kernels as codes
from workbench.structures.uniaxial.laws import parameters

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ShearYielding:
    """Elastic-plastic fiber that yields at sigma^2 + 3 tau^2 = fy^2, with associated flow.

    Arguments in Pa: `elastic_modulus`, `shear_modulus`, `yield_stress`, and the very small
    `kinematic_modulus` that only regularises (the centre of the yield ellipse moves by H eps_p
    and H gamma_p / 3). State of a fiber: plastic strain and plastic shear strain. A fiber
    without shear strain follows the perfectly plastic uniaxial law.
    """

    elastic_modulus: float
    shear_modulus: float
    yield_stress: float
    kinematic_modulus: float = 0.0

    code: ClassVar[int] = codes.SHEARED
    states: ClassVar[int] = 2
    rate: ClassVar[None] = None

    def __post_init__(self) -> None:
        for name in ("elastic_modulus", "shear_modulus", "yield_stress"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"law.{name}", getattr(self, name), "must be a positive number")
        if not self.kinematic_modulus >= 0.0:
            raise InputError(
                "law.kinematic_modulus", self.kinematic_modulus, "must not be negative"
            )

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, self.kinematic_modulus
        return parameters(*moduli, self.yield_stress, self.shear_modulus)
