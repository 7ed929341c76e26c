"""Shear resistance of headed studs: EN 1994, AISC 360, Ollgaard, Roik; reduction in profiled deck.

All forms are the smaller of a steel term, c_s A_s f_u, and a concrete term, c_c times sqrt(f_c
E_c) over d^2 or A_s. They differ in their factors, and in whether material values are
characteristic or mean. Deck rules of EN 1994-1-1 and AISC 360 as recalled and not read again: check
the code before relying on a number. Units: SI.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, OutOfDomainError
from workbench.fields import Choice, Declared, Flag, Number, checked
from workbench.responses import Finding
from workbench.studs.quantities import Array, Specimens, shank_area

LEAST_SLENDERNESS = 3.0  # height over diameter, EN 1994-1-1, 6.6.3.1
EN1994_PARTIAL_FACTOR = 1.25
STRENGTH_MARGIN = 8e6  # Pa, mean less characteristic concrete strength, EN 1992-1-1 table 3.1


class Level(StrEnum):
    """What a strength value stands for."""

    MEAN = "mean"
    CHARACTERISTIC = "characteristic"
    NOMINAL = "nominal"


@dataclass(frozen=True, slots=True)
class ShearModel:
    """A formula of shear resistance: min(c_s A_s f_u, c_c alpha X sqrt(f_c E_c)).

    `steel_factor` c_s (infinite: no steel term); `concrete_factor` c_c; `over_area`, X is A_s,
    otherwise d^2; `reduces_stocky`, alpha = 0.2 (h/d + 1) for 3 <= h/d < 4 (EN 1994); `level` of
    the value with the material values meant for it; `source`.
    """

    name: str
    title: str
    steel_factor: float
    concrete_factor: float
    over_area: bool
    reduces_stocky: bool
    level: Level
    source: str

    def steel(self, diameter: ArrayLike, ultimate_strength: ArrayLike) -> Array:
        """Steel term (n,) in N for diameters (m) and tensile strengths (Pa)."""
        if np.isinf(self.steel_factor):
            return np.full(np.broadcast(diameter, ultimate_strength).shape, np.inf)
        return np.asarray(
            self.steel_factor * shank_area(diameter) * np.asarray(ultimate_strength, float)
        )

    def concrete(
        self, diameter: ArrayLike, height: ArrayLike, strength: ArrayLike, modulus: ArrayLike
    ) -> Array:
        """Concrete term (n,) in N for diameters and heights (m), strength and modulus (Pa).

        Raises `OutOfDomainError` for studs below h/d = 3 where the formula has no value.
        """
        d = np.asarray(diameter, float)
        size = shank_area(d) if self.over_area else d * d
        factor = self.concrete_factor * self._stockiness(d, np.asarray(height, float))
        product = np.asarray(strength, float) * np.asarray(modulus, float)
        return np.asarray(factor * size * np.sqrt(product))

    def _stockiness(self, diameter: Array, height: Array) -> Array:
        if not self.reduces_stocky:
            return np.ones(np.broadcast(diameter, height).shape)
        slenderness = height / diameter
        if np.any(slenderness < LEAST_SLENDERNESS):
            raise OutOfDomainError(
                f"{self.title} has no value for a stud of height over diameter "
                f"{np.nanmin(slenderness):.3g}: it starts at {LEAST_SLENDERNESS:g}"
            )
        # np.minimum keeps NaN: without a height there is no value, rather than alpha = 1
        return np.minimum(0.2 * (slenderness + 1.0), 1.0)

    def resistance(
        self,
        diameter: ArrayLike,
        height: ArrayLike,
        strength: ArrayLike,
        modulus: ArrayLike,
        ultimate_strength: ArrayLike,
    ) -> Array:
        """Resistance (n,) in N; arguments as in `steel` and `concrete`."""
        return np.minimum(
            self.steel(diameter, ultimate_strength),
            self.concrete(diameter, height, strength, modulus),
        )

    def of(self, tests: Specimens) -> Array:
        """Resistance (n,) of tested specimens with their mean material values, in N.

        NaN where a value that the formula needs was not reported.
        """
        return np.minimum(*self.terms(tests))

    def terms(self, tests: Specimens) -> tuple[Array, Array]:
        """Steel and concrete term (n,) each of tested specimens, in N."""
        d, strength = tests.diameter, tests.concrete_strength
        concrete = self.concrete(d, tests.height, strength, tests.concrete_modulus)
        return self.steel(d, tests.ultimate_strength), concrete

    def findings(self, tests: Specimens) -> list[Finding]:
        """Tests outside the range that the code states; empty when all are in."""
        result = []
        for quantity, low, high, words in _RANGES.get(self.name, ()):
            values = getattr(tests, quantity)
            outside = int(np.sum((values < low) | (values > high)))
            if outside:
                text = f"{outside} of {len(tests)} tests outside {words} of {self.title}"
                result.append(Finding("range", text))
        return result

    def scaled(self, *, steel: float | None = None, concrete: float | None = None) -> ShearModel:
        """The same formula with other factors (a fitted form of it)."""
        return replace(
            self,
            steel_factor=self.steel_factor if steel is None else steel,
            concrete_factor=self.concrete_factor if concrete is None else concrete,
        )


_ROUND = 1e-9  # bounds are quoted to few digits
_RANGES = {
    "en1994": (
        ("diameter", 0.016 - _ROUND, 0.025 + _ROUND, "d = 16 to 25 mm"),
        ("ultimate_strength", 0.0, 500e6 * (1 + _ROUND), "f_u up to 500 MPa"),
        ("density", 1750.0 - _ROUND, np.inf, "densities from 1750 kg/m3"),
    ),
    "aisc360": (("slenderness", 5.0 - _ROUND, np.inf, "h/d from 5"),),
}

_EN_SOURCE = "EN 1994-1-1:2004, 6.6.3.1 (secondary transcriptions)"
SHEAR_MODELS: dict[str, ShearModel] = {
    model.name: model
    for model in (
        ShearModel("en1994", "EN 1994-1-1", 0.8, 0.29, False, True, Level.CHARACTERISTIC,
                   _EN_SOURCE),
        ShearModel("roik-mean", "Roik, mean values (the mean form of EN 1994-1-1)", 1.0, 0.374,
                   False, True, Level.MEAN, "Roik et al., mean values behind EN 1994-1-1 "
                   "(secondary transcription; another one prints 0.372)"),
        ShearModel("aisc360", "AISC 360-22, solid slab (Rg = 1, Rp = 0.75)", 0.75, 0.5, True,
                   False, Level.NOMINAL, "AISC 360-22, I8.2a"),
        ShearModel("ollgaard", "Ollgaard, Slutter and Fisher 1971", np.inf, 0.5, True, False,
                   Level.MEAN, "Ollgaard, Slutter and Fisher 1971, simplified form (recalled)"),
    )
}  # fmt: skip


def aisc360(group_factor: float = 1.0, position_factor: float = 0.75) -> ShearModel:
    """AISC 360-22 with the factors R_g and R_p of a deck (`Deck.factors_aisc360`)."""
    return SHEAR_MODELS["aisc360"].scaled(steel=group_factor * position_factor)


def shear_model(name: str) -> ShearModel:
    """The shear model of this name. Raises `InputError`."""
    Choice(tuple(SHEAR_MODELS)).check("model", name)
    return SHEAR_MODELS[name]


def design_resistance(
    model: ShearModel,
    diameter: ArrayLike,
    height: ArrayLike,
    strength: ArrayLike,
    modulus: ArrayLike,
    ultimate_strength: ArrayLike,
    partial_factor: float = EN1994_PARTIAL_FACTOR,
) -> Array:
    """Design value in N: the characteristic resistance over the partial factor.

    Arguments as in `ShearModel.resistance`, with characteristic material values. Raises
    `InputError` for a model of mean values, whose design value is a matter of EN 1990 D.8.
    """
    if model.level is not Level.CHARACTERISTIC:
        reason = f"gives {model.level} values, not characteristic ones"
        raise InputError("model", model.name, reason, "use `evaluate_d8` for a design value")
    value = model.resistance(diameter, height, strength, modulus, ultimate_strength)
    return np.asarray(value / partial_factor)


def characteristic_strength(mean_strength: ArrayLike) -> Array:
    """Characteristic concrete strength f_ck = f_cm - 8 MPa, in Pa (EN 1992-1-1, table 3.1)."""
    return np.asarray(np.asarray(mean_strength, float) - STRENGTH_MARGIN)


_LENGTH = Number(1e-4, 1.0, "m", advice="lengths are in metres")
DEEPEST_DECK = 0.085  # m, EN 1994-1-1, 6.6.4.2
# upper limits of k_t, EN 1994-1-1 table 6.2: (studs per rib, thin deck): (welded through, holes)
_LIMITS = {
    (1, True): (0.85, 0.75),
    (1, False): (1.0, 0.75),
    (2, True): (0.70, 0.60),
    (2, False): (0.80, 0.60),
}
_THIN = 1.0e-3  # m


@dataclass(frozen=True)
class Deck(Declared, table="deck"):
    """Profiled deck around a stud.

    Arguments: `depth` h_p of the deck and mean `width` b_0 of the rib in m; `direction` of the
    ribs to the beam; `studs_per_rib`; `thickness` of the sheet in m; `welded_through` the sheet
    or through holes; `middle_distance`, from the middle of the rib to the stud on its loaded side
    (AISC's e_mid-ht) in m.
    """

    depth: float = checked(_LENGTH)
    width: float = checked(_LENGTH)
    direction: str = checked(Choice(("transverse", "parallel")), "transverse")
    studs_per_rib: int = checked(Number(1, 4, integer=True), 1)
    thickness: float = checked(_LENGTH, 1.0e-3)
    welded_through: bool = checked(Flag(), True)
    middle_distance: float = checked(Number(0.0, 0.5, "m"), 0.051)

    def reduction_en1994(self, height: float, diameter: float) -> float:
        """Factor k_l or k_t on the resistance in a solid slab (EN 1994-1-1, 6.6.4).

        Arguments: `height` and `diameter` of the stud, in m. Raises `OutOfDomainError` outside
        the range of the rule.
        """
        if self.width < self.depth and self.direction == "transverse":
            raise OutOfDomainError("k_t needs ribs at least as wide as deep (6.6.4.2)")
        if self.depth > DEEPEST_DECK:
            raise OutOfDomainError(f"k_t and k_l end at decks of {DEEPEST_DECK:g} m depth")
        if height <= self.depth:
            raise OutOfDomainError("the stud does not rise above the deck")
        if self.direction == "parallel":
            tall = min(height, self.depth + 0.075)
            return min(0.6 * self.width / self.depth * (tall / self.depth - 1.0), 1.0)
        if self.studs_per_rib > 2:
            raise OutOfDomainError("k_t knows one or two studs per rib")
        largest = 0.020 if self.welded_through else 0.022
        if diameter > largest + 1e-9:
            raise OutOfDomainError(
                f"k_t ends at studs of {1e3 * largest:g} mm "
                f"{'welded through the deck' if self.welded_through else 'in holes'}"
            )
        slope = 0.7 / sqrt(self.studs_per_rib) * self.width / self.depth
        limits = _LIMITS[self.studs_per_rib, self.thickness <= _THIN + 1e-12]
        limit = limits[0] if self.welded_through else limits[1]
        return min(slope * (height / self.depth - 1.0), limit)

    def factors_aisc360(self) -> tuple[float, float]:
        """Group and position factors (R_g, R_p) of AISC 360-22, I8.2a, on the steel term.

        A solid slab has (1, 0.75).
        """
        if self.direction == "parallel":
            return (1.0 if self.width >= 1.5 * self.depth else 0.85), 0.75
        group = {1: 1.0, 2: 0.85}.get(self.studs_per_rib, 0.7)
        return group, (0.75 if self.middle_distance >= 0.0508 - 1e-9 else 0.6)
