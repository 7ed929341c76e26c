"""Interaction of tension and shear on a stud: laws, and tests under both.

With t and v, tension and shear over their resistances, every law is a curve g(t, v) = 1 with g
homogeneous of degree one, so that g is the utilisation: load over the load that just fails.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.fields import Declared, Number, checked
from workbench.studs.quantities import Array
from workbench.studs.schema import NO_PREDAMAGE


@dataclass(frozen=True)
class PowerInteraction(Declared, table="interaction"):
    """t^p + v^p = 1: p = 5/3 in AISC 360-22 (I8.3c), 1 is linear, 2 a circle (steel, EN 1992-4)."""

    exponent: float = checked(Number(1.0, 100.0), 5.0 / 3.0)

    def utilisation(self, tension: ArrayLike, shear: ArrayLike) -> Array:
        """Utilisation (n,) for tension and shear over their resistances."""
        t, v = _ratios(tension, shear)
        p = self.exponent
        return np.asarray((t**p + v**p) ** (1.0 / p))

    def shear_left(self, tension: ArrayLike) -> Array:
        """Shear ratio (n,) that is left at a tension ratio; 0 beyond the tension resistance."""
        t, _ = _ratios(tension, 0.0)
        return np.asarray(np.maximum(1.0 - t**self.exponent, 0.0) ** (1.0 / self.exponent))


@dataclass(frozen=True)
class TrilinearInteraction(Declared, table="interaction"):
    """t <= 1, v <= 1, t + v <= `limit`: no interaction while one ratio is below `limit` - 1.

    The rule of ACI 318 and the PCI handbook with `limit` 1.2 (recalled, not read again).
    """

    limit: float = checked(Number(1.0, 2.0), 1.2)

    def utilisation(self, tension: ArrayLike, shear: ArrayLike) -> Array:
        """Utilisation (n,) for tension and shear over their resistances."""
        t, v = _ratios(tension, shear)
        return np.asarray(np.maximum(np.maximum(t, v), (t + v) / self.limit))

    def shear_left(self, tension: ArrayLike) -> Array:
        """Shear ratio (n,) that is left at a tension ratio; 0 beyond the tension resistance."""
        t, _ = _ratios(tension, 0.0)
        return np.asarray(np.where(t > 1.0, 0.0, np.clip(self.limit - t, 0.0, 1.0)))


Interaction = PowerInteraction | TrilinearInteraction

INTERACTIONS: dict[str, Interaction] = {
    "five-thirds": PowerInteraction(),
    "linear": PowerInteraction(1.0),
    "trilinear": TrilinearInteraction(),
}


def _ratios(tension: ArrayLike, shear: ArrayLike) -> tuple[Array, Array]:
    t, v = np.asarray(tension, float), np.asarray(shear, float)
    if np.any(t < 0.0) or np.any(v < 0.0):
        advice = "compression needs no interaction: take the tension as 0"
        least = float(min(t.min(), v.min()))
        raise InputError("interaction", least, "ratios must not be negative", advice)
    return t, v


def combined_tests(table: pd.DataFrame) -> pd.DataFrame:
    """Rows (campaign, specimen, tension, shear) of the combined tests of a table; may be empty.

    Both are over the mean resistance of the undamaged pull-outs and push-outs of the same campaign
    and diameter; a combined test without both companions is left out.
    """
    usable = table[(table["use_for_fit"] == 1.0) & (table["predamage"] == NO_PREDAMAGE)]
    both = usable[usable["test"] == "combined"]
    equal = ["campaign", "diameter_mm"]
    result = both[["campaign", "specimen"]].copy()
    for kind, name in (("pull-out", "tension"), ("push-out", "shear")):
        alone = usable[usable["test"] == kind].groupby(equal)[f"{name}_kN"].mean()
        own = alone.reindex(pd.MultiIndex.from_frame(both[equal])).to_numpy(float)
        result[name] = both[f"{name}_kN"].to_numpy(float) / own
    known = np.isfinite(result[["tension", "shear"]].to_numpy(float)).all(axis=1)
    complete: pd.DataFrame = result[known].reset_index(drop=True)
    return complete
