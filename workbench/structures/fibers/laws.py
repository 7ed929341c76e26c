"""Steel laws of fibers as frozen values; their parameters and states are arrays of the kernels."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.arrays import Array
from workbench.fields import Declared, Number, checked
from workbench.structures.fibers import kernels

_MODULUS = Number(0.0, 1e30, "Pa", low_included=False)
_HARDENING = Number(0.0, 1e30, "Pa")
_ABOVE_ZERO = Number(0.0, 1e30, low_included=False)
_SHARE = Number(0.0, 0.9999)


def parameters(*values: float) -> Array:
    """Numbers of a law for the kernels, (8,)."""
    return np.array([*values, *[0.0] * (8 - len(values))])


@dataclass(frozen=True)
class CowperSymonds(Declared, table="rate"):
    """Rate sensitivity: the stress at plastic strain rate r is fy (1 + (r / D)^(1 / q)).

    Arguments: `reference_rate` D in 1/s, `exponent` q. Source: Cowper and Symonds 1957; values of
    mild steel in Jones 2012, table 8.1.
    """

    reference_rate: float = checked(_ABOVE_ZERO)
    exponent: float = checked(Number(1.0, 1e6))


MILD_STEEL = CowperSymonds(40.4, 5.0)


@dataclass(frozen=True)
class LinearHardening(Declared, table="law"):
    """Elastic, then plastic with linear hardening; without hardening moduli perfectly plastic.

    Arguments in Pa: `elastic_modulus`, `yield_stress`, `kinematic_modulus` (the yield range
    moves), `isotropic_modulus` (it grows); `rate`, sensitivity to the plastic strain rate, or
    None. State of a fiber: plastic strain and its accumulated amount.
    """

    elastic_modulus: float = checked(_MODULUS)
    yield_stress: float = checked(_MODULUS)
    kinematic_modulus: float = checked(_HARDENING, 0.0)
    isotropic_modulus: float = checked(_HARDENING, 0.0)
    rate: CowperSymonds | None = None

    states: ClassVar[int] = 2

    @property
    def code(self) -> int:
        """Number of the kernel."""
        return kernels.LINEAR if self.rate is None else kernels.LINEAR_RATE

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        rate = self.rate or CowperSymonds(1.0, 1.0)  # without a rate not read
        return parameters(
            self.elastic_modulus,
            self.kinematic_modulus,
            self.yield_stress,
            self.isotropic_modulus,
            rate.reference_rate,
            rate.exponent,
        )


@dataclass(frozen=True)
class MenegottoPinto(Declared, table="law"):
    """Smooth transition between the elastic and a hardening line, with the Bauschinger effect.

    Arguments: `elastic_modulus` and `yield_stress` in Pa; `hardening_ratio`, slope of the
    hardening line over the elastic modulus; `roundness` R0 of the first loading (large: sharp
    corner) and the factors `softening` and `softening_strain` (cR1, cR2) that lower it after
    reversals. Source: Menegotto and Pinto 1973; parameters after Filippou et al. 1983. A small
    partial unloading is treated as a full reversal, as usual with this law, so that stresses
    afterwards may overshoot the first branch slightly. State of a fiber: ten numbers, the first
    is the plastic strain.
    """

    elastic_modulus: float = checked(_MODULUS)
    yield_stress: float = checked(_MODULUS)
    hardening_ratio: float = checked(_SHARE, 0.01)
    roundness: float = checked(_ABOVE_ZERO, 20.0)
    softening: float = checked(_SHARE, 0.925)
    softening_strain: float = checked(_ABOVE_ZERO, 0.15)

    code: ClassVar[int] = kernels.MENEGOTTO_PINTO
    states: ClassVar[int] = 10
    rate: ClassVar[None] = None

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, 0.0, self.yield_stress, self.hardening_ratio
        return parameters(*moduli, self.roundness, self.softening, self.softening_strain)


@dataclass(frozen=True)
class ShearYielding(Declared, table="law"):
    """Elastic-plastic fiber that yields at sigma^2 + 3 tau^2 = fy^2, with associated flow.

    Arguments in Pa: `elastic_modulus`, `shear_modulus`, `yield_stress`, and the very small
    `kinematic_modulus` that only regularises (the centre of the yield ellipse moves by H eps_p
    and H gamma_p / 3). State of a fiber: plastic strain and plastic shear strain. A fiber
    without shear strain follows the perfectly plastic uniaxial law.
    """

    elastic_modulus: float = checked(_MODULUS)
    shear_modulus: float = checked(_MODULUS)
    yield_stress: float = checked(_MODULUS)
    kinematic_modulus: float = checked(_HARDENING, 0.0)

    code: ClassVar[int] = kernels.SHEARED
    states: ClassVar[int] = 2
    rate: ClassVar[None] = None

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, self.kinematic_modulus
        return parameters(*moduli, self.yield_stress, self.shear_modulus)


UniaxialLaw = LinearHardening | MenegottoPinto
