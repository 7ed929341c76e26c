"""Steel laws as frozen values; their parameters and states are the arrays of the kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.structures.uniaxial import _kernels

Array = NDArray[np.float64]


def _positive(owner: object, name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(f"{type(owner).__name__}.{name}", value, "must be a positive number")


def parameters(*values: float) -> Array:
    """Numbers of a law for the kernels, (8,)."""
    return np.array([*values, *[0.0] * (8 - len(values))])


@dataclass(frozen=True)
class CowperSymonds:
    """Rate sensitivity: the stress at plastic strain rate r is fy (1 + (r / D)^(1 / q)).

    Arguments: `reference_rate` D in 1/s, `exponent` q. Source: Cowper and Symonds 1957; values of
    mild steel in Jones 2012, table 8.1.
    """

    reference_rate: float
    exponent: float

    def __post_init__(self) -> None:
        _positive(self, "reference_rate", self.reference_rate)
        if not self.exponent >= 1.0:
            raise InputError("rate.exponent", self.exponent, "must be at least 1")


MILD_STEEL = CowperSymonds(40.4, 5.0)


@dataclass(frozen=True)
class LinearHardening:
    """Elastic, then plastic with linear hardening; without hardening moduli perfectly plastic.

    Arguments in Pa: `elastic_modulus`, `yield_stress`, `kinematic_modulus` (the yield range
    moves), `isotropic_modulus` (it grows); `rate`, sensitivity to the plastic strain rate, or
    None. State of a fiber: plastic strain and its accumulated amount.
    """

    elastic_modulus: float
    yield_stress: float
    kinematic_modulus: float = 0.0
    isotropic_modulus: float = 0.0
    rate: CowperSymonds | None = None

    states: ClassVar[int] = 2

    @property
    def code(self) -> int:
        """Number of the kernel."""
        return _kernels.LINEAR if self.rate is None else _kernels.LINEAR_RATE

    def __post_init__(self) -> None:
        _positive(self, "elastic_modulus", self.elastic_modulus)
        _positive(self, "yield_stress", self.yield_stress)
        for name in ("kinematic_modulus", "isotropic_modulus"):
            if not getattr(self, name) >= 0.0:
                raise InputError(f"law.{name}", getattr(self, name), "must not be negative")

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
class MenegottoPinto:
    """Smooth transition between the elastic and a hardening line, with the Bauschinger effect.

    Arguments: `elastic_modulus` and `yield_stress` in Pa; `hardening_ratio`, slope of the
    hardening line over the elastic modulus; `roundness` R0 of the first loading (large: sharp
    corner) and the factors `softening` and `softening_strain` (cR1, cR2) that lower it after
    reversals. Source: Menegotto and Pinto 1973; parameters after Filippou et al. 1983. A small
    partial unloading is treated as a full reversal, as usual with this law, so that stresses
    afterwards may overshoot the first branch slightly. State of a fiber: nine numbers, the first
    is the plastic strain.
    """

    elastic_modulus: float
    yield_stress: float
    hardening_ratio: float = 0.01
    roundness: float = 20.0
    softening: float = 0.925
    softening_strain: float = 0.15

    code: ClassVar[int] = _kernels.MENEGOTTO_PINTO
    states: ClassVar[int] = 9
    rate: ClassVar[None] = None

    def __post_init__(self) -> None:
        for name in ("elastic_modulus", "yield_stress", "roundness", "softening_strain"):
            _positive(self, name, getattr(self, name))
        if not 0.0 <= self.hardening_ratio < 1.0:
            raise InputError("law.hardening_ratio", self.hardening_ratio, "must be in [0, 1)")
        if not 0.0 <= self.softening < 1.0:
            raise InputError("law.softening", self.softening, "must be in [0, 1)")

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, 0.0, self.yield_stress, self.hardening_ratio
        return parameters(*moduli, self.roundness, self.softening, self.softening_strain)


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

    code: ClassVar[int] = _kernels.SHEARED
    states: ClassVar[int] = 2
    rate: ClassVar[None] = None

    def __post_init__(self) -> None:
        for name in ("elastic_modulus", "shear_modulus", "yield_stress"):
            _positive(self, name, getattr(self, name))
        if not self.kinematic_modulus >= 0.0:
            raise InputError(
                "law.kinematic_modulus", self.kinematic_modulus, "must not be negative"
            )

    def parameters(self) -> Array:
        """Numbers for the kernels, (8,)."""
        moduli = self.elastic_modulus, self.kinematic_modulus
        return parameters(*moduli, self.yield_stress, self.shear_modulus)


UniaxialLaw = LinearHardening | MenegottoPinto
