"""Tension resistance of headed studs: steel, concrete cone, pull-through; tension with shear.

Cone and head after the concrete capacity design method of EN 1992-4 (characteristic 12.7 as quoted
in a public design repository; the other factors recalled, not read again). With t and v, tension
and shear over their resistances, every interaction law is a curve g(t, v) = 1 with g homogeneous of
degree one, so that g is the utilisation: load over the load that just fails. Units: SI.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.fields import Declared, Flag, Number, checked
from workbench.studs.quantities import Array, shank_area
from workbench.studs.schema import NO_PREDAMAGE

# factor k of N = k sqrt(f_c) h_ef^1.5 in N and mm, for cast-in headed studs
CONE_MEAN = 16.8
CONE_CHARACTERISTIC = {"uncracked": 12.7, "cracked": 8.9}
# factor k of N = k A_h f_c for the pressure under the head
HEAD_CHARACTERISTIC = {"uncracked": 10.5, "cracked": 7.5}
EDGE_DISTANCE = 1.5  # characteristic edge distance over embedment
SPACING = 3.0  # characteristic spacing over embedment
_LENGTH = Number(1e-3, 10.0, "m", advice="lengths are in metres")


@dataclass(frozen=True)
class Cone(Declared, table="cone"):
    """Concrete cone of one stud in the middle of a block.

    Arguments: `embedment` h_ef and smallest `edge_distance` in m (None: far from edges); `width`
    of the block in m where it cuts the cone on two sides (None: wide); `cracked` concrete.
    """

    embedment: float = checked(_LENGTH)
    edge_distance: float | None = checked(_LENGTH, optional=True)
    width: float | None = checked(_LENGTH, optional=True)
    cracked: bool = checked(Flag(), False)

    @property
    def area_ratio(self) -> float:
        """Projected area over that of a full cone, A_c,N / A0_c,N, for a stud between two edges."""
        if self.width is None:
            return 1.0
        return min(self.width / (SPACING * self.embedment), 1.0)

    @property
    def edge_factor(self) -> float:
        """psi_s = 0.7 + 0.3 c / (1.5 h_ef), at most 1."""
        if self.edge_distance is None:
            return 1.0
        return min(0.7 + 0.3 * self.edge_distance / (EDGE_DISTANCE * self.embedment), 1.0)

    def resistance(self, strength: float, factor: float | None = None) -> float:
        """Cone resistance in N for a cylinder strength in Pa.

        `factor` k in N^0.5 / mm^0.5 (None: the characteristic one of EN 1992-4; `CONE_MEAN` for a
        mean value).
        """
        if factor is None:
            factor = CONE_CHARACTERISTIC["cracked" if self.cracked else "uncracked"]
        basic = factor * np.sqrt(strength / 1e6) * (1e3 * self.embedment) ** 1.5
        return float(basic * self.area_ratio * self.edge_factor)


def steel_resistance(diameter: ArrayLike, ultimate_strength: ArrayLike) -> Array:
    """Tension resistance A_s f_u of the shank in N (AISC 360-22, I8.3b; EN 1992-4, 7.2.1.3)."""
    return np.asarray(shank_area(diameter) * np.asarray(ultimate_strength, float))


def head_area(diameter: float, head_diameter: float) -> float:
    """Area of the head that presses on the concrete, in m2, for diameters in m."""
    return 0.25 * pi * (head_diameter**2 - diameter**2)


def pull_through_resistance(
    diameter: float, head_diameter: float, strength: float, *, cracked: bool = False
) -> float:
    """Resistance to pulling the head through the concrete, k A_h f_c, in N (EN 1992-4, 7.2.1.5).

    Arguments: `diameter` and `head_diameter` in m, cylinder `strength` in Pa.
    """
    factor = HEAD_CHARACTERISTIC["cracked" if cracked else "uncracked"]
    return factor * head_area(diameter, head_diameter) * strength


def tension_resistance(
    diameter: float, head_diameter: float, cone: Cone, strength: float, ultimate_strength: float
) -> dict[str, float]:
    """Resistances of the three modes in N, and under ``governing`` the smallest of them.

    Arguments: `diameter`, `head_diameter` in m; `cone`; characteristic concrete `strength` and
    `ultimate_strength` of the stud in Pa.
    """
    modes = {
        "steel": float(steel_resistance(diameter, ultimate_strength)),
        "cone": cone.resistance(strength),
        "pull-through": pull_through_resistance(
            diameter, head_diameter, strength, cracked=cone.cracked
        ),
    }
    return {**modes, "governing": min(modes.values())}


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
