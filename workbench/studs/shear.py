"""Shear resistance of headed studs: EN 1994, AISC 360, Ollgaard, Roik; decks by `deck`.

Also a usual stud by the formula of a code, as a designer asks for it: both terms, what governs.

All forms are the smaller of a steel term, c_s A_s f_u, and a concrete term, c_c times sqrt(f_c
E_c) over d^2 or A_s. They differ in their factors, and in whether material values are
characteristic or mean. Check the code before relying on a number. Units: SI.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import OutOfDomainError
from workbench.fields import Choice
from workbench.responses import Finding
from workbench.studs.quantities import Array, Specimens, concrete_modulus, shank_area

LEAST_SLENDERNESS = 3.0  # height over diameter, EN 1994-1-1, 6.6.3.1
STRENGTH_MARGIN = 8e6  # Pa, mean less characteristic concrete strength, EN 1992-1-1 table 3.1


@dataclass(frozen=True, slots=True)
class ShearModel:
    """A formula of shear resistance: min(c_s A_s f_u, c_c alpha X sqrt(f_c E_c)).

    `steel_factor` c_s (infinite: no steel term); `concrete_factor` c_c; `over_area`, X is A_s,
    otherwise d^2; `reduces_stocky`, alpha = 0.2 (h/d + 1) for 3 <= h/d < 4 (EN 1994);
    `deck_rule` of its code for profiled decks, ``en1994``, ``aisc360`` or none; `characteristic`,
    whether the value is one with the material values meant for it; `source`.
    """

    name: str
    title: str
    steel_factor: float
    concrete_factor: float
    over_area: bool
    reduces_stocky: bool
    characteristic: bool
    source: str
    deck_rule: str = ""

    @property
    def formula(self) -> str:
        """The formula in symbols: d, h, A_s of the shank, f_u, f_c, E_c."""
        alpha = " α" if self.reduces_stocky else ""
        size = "A_s" if self.over_area else "d²"
        concrete = f"{self.concrete_factor:g}{alpha} {size} √(f_c E_c)"
        whole = concrete
        if not np.isinf(self.steel_factor):
            whole = f"min({self.steel_factor:g} A_s f_u; {concrete})"
        return f"P = {whole}" + (", α = 0.2 (h/d + 1) ≤ 1" if alpha else "")

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
        # a stocky stud has no value, and takes none from the others
        outside = self.reduces_stocky & (tests.slenderness < LEAST_SLENDERNESS)
        height = np.where(outside, np.nan, tests.height)
        concrete = self.concrete(d, height, strength, tests.concrete_modulus)
        steel = self.steel(d, tests.ultimate_strength)
        decks = tests.decks
        if decks is None:
            return steel, concrete
        if self.deck_rule == "aisc360":
            return steel * decks.reduction_aisc360(), concrete
        if self.deck_rule == "en1994":
            reduction = decks.reduction_en1994(tests.height, d)
        else:
            reduction = np.where(decks.profiled, np.nan, 1.0)
        return steel * reduction, concrete * reduction

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

    def scaled(self, **factors: float) -> ShearModel:
        """The same formula with another factor ``steel``, ``concrete`` or both (a fitted form)."""
        changes: dict[str, Any] = {f"{name}_factor": value for name, value in factors.items()}
        return replace(self, **changes)


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
        ShearModel("en1994", "EN 1994-1-1", 0.8, 0.29, False, True, True, _EN_SOURCE,
                   "en1994"),
        ShearModel("roik-mean", "Roik, mean values (the mean form of EN 1994-1-1)", 1.0, 0.374,
                   False, True, False, "Roik et al., mean values behind EN 1994-1-1 "
                   "(secondary transcription; another one prints 0.372)", "en1994"),
        ShearModel("aisc360", "AISC 360-22, solid slab (Rg = 1, Rp = 0.75)", 0.75, 0.5, True,
                   False, False, "AISC 360-22, I8.2a", "aisc360"),
        ShearModel("ollgaard", "Ollgaard, Slutter and Fisher 1971", np.inf, 0.5, True, False,
                   False, "Ollgaard, Slutter and Fisher 1971, simplified form (recalled)"),
    )
}  # fmt: skip


def shear_model(name: str) -> ShearModel:
    """The shear model of this name. Raises `InputError`."""
    Choice(tuple(SHEAR_MODELS)).check("model", name)
    return SHEAR_MODELS[name]


def characteristic_strength(mean_strength: ArrayLike) -> Array:
    """Characteristic concrete strength f_ck = f_cm - 8 MPa, in Pa (EN 1992-1-1, table 3.1)."""
    return np.asarray(np.asarray(mean_strength, float) - STRENGTH_MARGIN)


DIAMETER, HEIGHT, CONCRETE, STEEL = 0.019, 0.1, 30e6, 450e6  # m; characteristic, specified, in Pa
_MEAN, _CODES = "roik-mean", ("roik-mean", "en1994", "aisc360")
_PARTIAL = {"en1994": 1.25}  # gamma_V of EN 1994-1-1, 6.6.3.1


def usual_stud(model: ShearModel) -> dict[str, float | None] | None:
    """The usual stud by a formula that a code has; None for others.

    Sizes in m; `concrete_strength`, as the formula means it, `concrete_modulus`, that of the code
    (EN 1992-1-1, table 3.1, or 4733 sqrt(f_c) of ACI 318), `ultimate_strength` in Pa; both terms,
    the smaller one, `resistance`, and `other_concrete_term`, with the modulus that fits take, in N;
    `partial_factor` of the code (None: it has none for the stud alone).
    """
    if model.name not in _CODES:
        return None
    mean = CONCRETE + STRENGTH_MARGIN
    strength = mean if model.name == _MEAN else CONCRETE
    european = 22e9 * (mean / 10e6) ** 0.3
    modulus = float(concrete_modulus(CONCRETE)) if model.name == "aisc360" else european
    steel = float(model.steel(DIAMETER, STEEL))
    concrete, other = (
        float(model.concrete(DIAMETER, HEIGHT, strength, each))
        for each in (modulus, concrete_modulus(mean))
    )
    return {
        "diameter": DIAMETER,
        "height": HEIGHT,
        "concrete_strength": strength,
        "concrete_modulus": modulus,
        "ultimate_strength": STEEL,
        "steel_term": steel,
        "concrete_term": concrete,
        "resistance": min(steel, concrete),
        "other_concrete_term": other,
        "partial_factor": _PARTIAL.get(model.name),
    }
