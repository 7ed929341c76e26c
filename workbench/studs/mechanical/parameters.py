"""A stud and the concrete around it, for the mechanical model; the studs of a table of tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from typing import NamedTuple

import numpy as np
import pandas as pd

from workbench.base.errors import InputError
from workbench.base.fields import Declared, Number, checked
from workbench.studs.formulas import SHEAR_MODELS
from workbench.studs.quantities import (
    HEAD_DIAMETER,
    HEAD_HEIGHT,
    Array,
    concrete_modulus,
    specimens,
)
from workbench.studs.schema import HEADED, USUAL

LENGTH = Number(1e-3, 1.0, "m", advice="lengths are in metres")
STRESS = Number(1e6, 3e9, "Pa", advice="stresses are in Pa: 30 MPa is 30e6")
STEEL_MODULUS, SHEAR_MODULUS, DENSITY = 210e9, 81e9, 7850.0
COLLAR_DIAMETER, COLLAR_HEIGHT = 1.25, 0.27  # usual, ISO 13918, as shares of the diameter
LEAST_SLENDERNESS = 4.0 - 1e-9  # height over diameter: a stockier stud may pry out
YIELD_SHARE = 0.8  # of the tensile strength, where the yield stress was not measured


@dataclass(frozen=True)
class Stud(Declared, table="stud"):
    """A headed stud in a solid slab.

    Arguments: `diameter` and `height` in m; mean `concrete_strength` and `concrete_modulus`,
    `ultimate_strength` in Pa; `yield_stress` (None: 0.8 of the ultimate strength) in Pa; sizes of
    head and weld collar in m (None: usual proportions of ISO 13918).
    """

    diameter: float = checked(LENGTH)
    height: float = checked(LENGTH)
    concrete_strength: float = checked(STRESS)
    concrete_modulus: float = checked(Number(3e9, 9e10, "Pa"))
    ultimate_strength: float = checked(STRESS)
    yield_stress: float | None = checked(STRESS, optional=True)
    head_diameter: float | None = checked(LENGTH, optional=True)
    head_height: float | None = checked(LENGTH, optional=True)
    collar_diameter: float | None = checked(LENGTH, optional=True)
    collar_height: float | None = checked(Number(0.0, 0.05, "m"), optional=True)

    def check(self) -> None:
        """Refuse what the fields cannot be together."""
        for name, share in (
            ("head_diameter", HEAD_DIAMETER), ("head_height", HEAD_HEIGHT),
            ("collar_diameter", COLLAR_DIAMETER), ("collar_height", COLLAR_HEIGHT),
        ):  # fmt: skip
            if getattr(self, name) is None:
                object.__setattr__(self, name, share * self.diameter)
        if self.yield_stress is None:
            object.__setattr__(self, "yield_stress", YIELD_SHARE * self.ultimate_strength)
        if not self.head_diameter > self.diameter:  # type: ignore[operator]
            raise self.refusal("head_diameter", "must exceed the diameter")
        if self.height < LEAST_SLENDERNESS * self.diameter:
            reason = f"must be {LEAST_SLENDERNESS:g} diameters or more"
            raise self.refusal("height", reason, "stockier studs may pry out: no model of that")
        if self.embedment < 2.0 * self.diameter:
            raise self.refusal("height", "must leave an embedment of two diameters or more")

    @classmethod
    def of_concrete(
        cls, diameter: float, height: float, concrete_strength: float, ultimate_strength: float
    ) -> Stud:
        """A stud in concrete of 4733 sqrt(fc) MPa modulus (ACI 318); arguments in m and Pa."""
        modulus = float(concrete_modulus(concrete_strength))
        return cls(diameter, height, concrete_strength, modulus, ultimate_strength)

    @property
    def title(self) -> str:
        """Its sizes and strengths in words."""
        size = f"{1e3 * self.diameter:.4g} x {1e3 * self.height:.4g} mm"
        strengths = (self.concrete_strength / 1e6, self.ultimate_strength / 1e6)
        return f"{size}, f_c {strengths[0]:.3g} MPa, f_u {strengths[1]:.3g} MPa"

    @property
    def area(self) -> float:
        """Area of the shank in m2."""
        return 0.25 * pi * self.diameter**2

    @property
    def head_area(self) -> float:
        """Area of the head that presses on the concrete, in m2."""
        return 0.25 * pi * (float(self.head_diameter or 0.0) ** 2 - self.diameter**2)

    @property
    def embedment(self) -> float:
        """Effective embedment, from the slab's surface to the underside of the head, in m."""
        return self.height - float(self.head_height or 0.0)

    @property
    def tensile_strength(self) -> float:
        """Tensile strength of the shank, A_s f_u, in N."""
        return self.area * self.ultimate_strength

    @property
    def shear_strength(self) -> float:
        """Plastic shear strength of the shank, A_s f_u / sqrt(3), in N (von Mises)."""
        return self.tensile_strength / sqrt(3.0)

    @property
    def largest_shear(self) -> float:
        """Largest shear of a push-out, in N, whatever the bearing of the shank gives.

        The tensile strength of the shank, and the concrete term of the mean form of EN 1994-1-1
        (splitting and crushing of the slab, which no part of the mechanism knows).
        """
        sizes = (self.diameter, self.height, self.concrete_strength, self.concrete_modulus)
        return min(self.tensile_strength, float(SHEAR_MODELS["roik-mean"].concrete(*sizes)))


@dataclass(frozen=True)
class Surroundings(Declared, table="surroundings"):
    """Parameters of the concrete around a stud.

    Calibrated on push-out tests (`calibrate`): `bearing_factor`, bearing strength of concrete over
    its cylinder strength; `foundation_factor`, foundation modulus per length over the modulus of
    concrete; `slide_capacity`, shear slide at rupture over the diameter.
    Assumed: `friction` between flange and slab; `head_factor`, pressure under the head over
    cylinder strength at pull-through; `cone_factor`, mean factor of the cone; `cone_peak` and
    `cone_end`, opening of the cone at its peak and at nearly zero load over the embedment;
    `cone_loss`, share of bearing strength and stiffness (shank, collar, head) that a fully formed
    cone takes away; `rupture_strain`, mean axial plastic strain at rupture.
    """

    bearing_factor: float = checked(Number(0.5, 40.0), 6.0)
    foundation_factor: float = checked(Number(0.01, 10.0), 0.5)
    slide_capacity: float = checked(Number(0.01, 2.0), 0.3)
    friction: float = checked(Number(0.0, 1.0), 0.4)
    head_factor: float = checked(Number(2.0, 40.0), 12.0)
    cone_factor: float = checked(Number(5.0, 30.0), 16.8)
    cone_peak: float = checked(Number(1e-4, 0.05), 0.005)
    cone_end: float = checked(Number(1e-3, 0.5), 0.06)
    cone_loss: float = checked(Number(0.0, 1.0), 0.5)
    rupture_strain: float = checked(Number(0.01, 0.5), 0.12)

    def check(self) -> None:
        """Refuse what the fields cannot be together."""
        if self.cone_end <= self.cone_peak:
            raise self.refusal("cone_end", "must exceed cone_peak")


NEEDED = ("diameter", "height", "concrete_strength", "concrete_modulus", "ultimate_strength")


def stud_of(row: pd.Series) -> Stud:
    """The stud of a row of a table of tests. Raises `InputError` for missing values."""
    test = specimens(pd.DataFrame([row]))
    values = {name: float(getattr(test, name)[0]) for name in NEEDED}
    for name, value in values.items():
        if not np.isfinite(value):
            where = f"{row['campaign']} {row['specimen']}"
            raise InputError(f"{where}: {name}", None, "must be known for the mechanical model")
    sizes = ("head_diameter", "collar_diameter", "collar_height")
    optional = {"yield_stress": 1e6 * row["fy_MPa"], **{n: 1e-3 * row[f"{n}_mm"] for n in sizes}}
    return Stud(**values, **{n: float(v) for n, v in optional.items() if np.isfinite(v)})


# by how much (a share) the studs of a table may differ in the columns of `USUAL` and still are one
ALIKE = np.array([0.02, 0.02, 0.1, 0.1])


class TableStud(NamedTuple):
    """A `stud` of a table, in how many `tests`, and what is `assumed` of it (words)."""

    stud: Stud
    tests: int
    assumed: str


def studs_of(
    table: pd.DataFrame, given: Mapping[str, float | None]
) -> tuple[list[TableStud], list[str]]:
    """The different headed studs of a table with their mean values, that of most tests first.

    And why the model refuses others. Raises `InputError` where it refuses all.
    Arguments: `given`, values by column (those of `USUAL`, None: not given) that count instead of
    those of the table. What neither tells is taken from `USUAL`, and said to be assumed.
    """
    stated = {name: value for name, value in given.items() if value is not None}
    rows = table[table["connector"] == HEADED].reindex(columns=list(USUAL)).astype(float)
    rows = (rows if len(rows) else pd.DataFrame([dict.fromkeys(USUAL, np.nan)])).assign(**stated)
    known = rows.dropna(subset=[name for name in USUAL if rows[name].notna().any()])
    known = rows if known.empty else known
    assumed = [f"{name} {USUAL[name]:g}" for name in USUAL if known[name].isna().any()]
    groups: list[list[Array]] = []
    for values in known.fillna(USUAL).to_numpy(float):
        same = (g for g in groups if np.all(np.abs(values / g[0] - 1.0) <= ALIKE))
        if (group := next(same, None)) is None:
            groups.append(group := [])
        group.append(values)
    groups.sort(key=len, reverse=True)
    means = [np.mean(group, axis=0) * (1e-3, 1e-3, 1e6, 1e6) for group in groups]
    studs, refused = [], []
    for mean, group in zip(means, groups, strict=True):
        try:
            stud = Stud.of_concrete(*mean.tolist())
        except InputError as error:
            refused.append(error)
        else:
            studs.append(TableStud(stud, len(group) if len(table) else 0, ", ".join(assumed)))
    if not studs:
        raise refused[0]
    return studs, [str(error) for error in refused]
