"""Load-slip laws of a stud under first loading: Ollgaard, bilinear, rational with softening.

A law gives the load over its largest value, q = Q / Q_max, as a function of the slip. Units: SI.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, OutOfDomainError
from workbench.fields import Declared, Number, checked
from workbench.studs.quantities import Array


class LoadSlipLaw(Protocol):
    """What the other modules ask of a law."""

    name: ClassVar[str]

    def ratio(self, slip: ArrayLike) -> Array:
        """Load over the largest load (n,) at slips (m) that are not negative."""
        ...

    def slip_at(self, ratio: float) -> float:
        """Slip (m) of the ascending branch at a load ratio below 1."""
        ...


@dataclass(frozen=True)
class OllgaardLaw(Declared, table="law"):
    """q = (1 - exp(-`rate` s))^`exponent`, `rate` in 1/m.

    The published parameters are 18 per inch (708.7 per m) and 0.4 (Ollgaard, Slutter and Fisher
    1971, recalled, not read again). With an exponent below 1 the tangent at zero is infinite:
    use a chord stiffness.
    """

    rate: float = checked(Number(1.0, 1e6, "1/m"), 18.0 / 0.0254)
    exponent: float = checked(Number(0.01, 20.0), 0.4)
    name: ClassVar[str] = "ollgaard"

    def ratio(self, slip: ArrayLike) -> Array:
        """Load over the largest load at slips (m)."""
        return np.asarray((-np.expm1(-self.rate * _slips(slip))) ** self.exponent)

    def slip_at(self, ratio: float) -> float:
        """Slip (m) at a load ratio below 1."""
        share = _below_one(ratio) ** (1.0 / self.exponent)
        return float(-np.log1p(-share) / self.rate)


@dataclass(frozen=True)
class BilinearLaw(Declared, table="law"):
    """Linear to `yield_slip`, constant to `slip_capacity` (m), no load beyond.

    The defaults, 0.5 and 6 mm, are those in use with the mean values of Roik.
    """

    yield_slip: float = checked(Number(0.0, 0.1, "m", low_included=False), 0.5e-3)
    slip_capacity: float = checked(Number(0.0, 0.5, "m", low_included=False), 6.0e-3)
    name: ClassVar[str] = "bilinear"

    def check(self) -> None:
        """Refuse what the fields cannot be together."""
        if self.slip_capacity < self.yield_slip:
            raise InputError(
                "law.slip_capacity", self.slip_capacity, f"must reach {self.yield_slip:g} m"
            )

    def ratio(self, slip: ArrayLike) -> Array:
        """Load over the largest load at slips (m)."""
        s = _slips(slip)
        return np.asarray(np.where(s <= self.slip_capacity, np.minimum(s / self.yield_slip, 1), 0))

    def slip_at(self, ratio: float) -> float:
        """Slip (m) at a load ratio below 1."""
        return _below_one(ratio) * self.yield_slip


@dataclass(frozen=True)
class RationalLaw(Declared, table="law"):
    """q = (k x + (D - 1) x^2) / (1 + (k - 2) x + D x^2), x = slip over `peak_slip` (m).

    `stiffness_ratio` k is the initial tangent over the secant to the peak; `softening` D in 0..1
    shapes the falling branch (1: slowest fall, 0: a parabola at k = 2). Sargin's form, which has
    its only maximum, 1, at the peak. Source: Sargin 1971.
    """

    peak_slip: float = checked(Number(1e-5, 0.1, "m"), 6.0e-3)
    stiffness_ratio: float = checked(Number(1.0, 1e3), 5.0)
    softening: float = checked(Number(0.0, 1.0), 0.5)
    name: ClassVar[str] = "rational"

    def ratio(self, slip: ArrayLike) -> Array:
        """Load over the largest load at slips (m), not below zero."""
        x = _slips(slip) / self.peak_slip
        k, d = self.stiffness_ratio, self.softening
        numerator = k * x + (d - 1.0) * x * x
        return np.asarray(np.maximum(numerator, 0.0) / (1.0 + (k - 2.0) * x + d * x * x))

    def slip_at(self, ratio: float) -> float:
        """Slip (m) of the ascending branch at a load ratio below 1."""
        q = _below_one(ratio)
        k, d = self.stiffness_ratio, self.softening
        # (d - 1 - q d) x^2 + (k - q (k - 2)) x - q = 0: the smaller positive root
        a, b = d - 1.0 - q * d, k - q * (k - 2.0)
        root = np.sqrt(b * b + 4.0 * a * q)
        return float(2.0 * q / (b + root) * self.peak_slip)


Law = OllgaardLaw | BilinearLaw | RationalLaw
LAWS: dict[str, type[Law]] = {law.name: law for law in (OllgaardLaw, BilinearLaw, RationalLaw)}


def law_kind(name: str) -> type[Law]:
    """The law of this name. Raises `InputError`."""
    if name not in LAWS:
        raise InputError("law", name, "must be one of " + ", ".join(LAWS))
    return LAWS[name]


def _slips(slip: ArrayLike) -> Array:
    s = np.asarray(slip, float)
    if np.any(s < 0.0):
        raise OutOfDomainError(
            f"a load-slip law of first loading has no load for the slip {float(np.min(s)):g} m: "
            "reversed loading is outside its assumptions"
        )
    return s


def _below_one(ratio: float) -> float:
    if not 0.0 <= ratio < 1.0:
        raise InputError("ratio", ratio, "must lie from 0 to below 1")
    return ratio
