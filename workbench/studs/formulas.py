"""Strength of headed studs in shear and in tension: formulas as ``formulas.toml`` declares them.

Also a usual stud by the formula of a code, as a designer asks for it: both terms, what governs; and
the fit of the factors of a formula itself, c_s and c_c, within bounds.
Check a code before relying on a number. Units: SI, of factors N, mm and MPa.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from workbench.base.errors import InputError
from workbench.base.fields import Choice
from workbench.responses import Finding, finding
from workbench.studs.fit_protocol import Fitted, fitted
from workbench.studs.statistics.mixed import Prediction, fit_robust, problem
from workbench.studs.tables import (
    Array,
    Specimens,
    concrete_modulus,
    embedment_of,
    shank_area,
    specimens,
    undamaged_headed_studs,
)

LEAST_SLENDERNESS = 3.0  # height over diameter, EN 1994-1-1, 6.6.3.1
STRENGTH_MARGIN = 8e6  # Pa, mean less characteristic concrete strength, EN 1992-1-1 table 3.1
MOST_IN_DECKS = 450e6  # Pa, of f_u in ribs across the beam, EN 1994-1-1, 6.6.4.2
_ROUND = 1e-9  # bounds are quoted to few digits
INF = np.inf


class FormulaBound(NamedTuple):
    """A bound of a formula: of a quantity of tests (`over` another), `where` they stand."""

    of: str
    words: str
    low: float = 0.0
    high: float = INF
    over: str = ""
    where: str = ""

    def beyond(self, tests: Specimens) -> int:
        """How many tests are beyond it; one that does not tell the quantity is not."""
        values = tests.quantity(self.of) / (tests.quantity(self.over) if self.over else 1.0)
        out = (values < self.low * (1.0 - _ROUND)) | (values > self.high * (1.0 + _ROUND))
        return int(np.sum(out & tests.where(self.where)))


@dataclass(frozen=True, slots=True)
class Formula:
    """A formula of strength per stud: the smallest of its terms.

    Its fields are explained in ``formulas.toml``; an infinite factor means no such term.
    `deck_rule` for profiled decks: ``en1994``, ``aisc360`` or none; `load`, shear or tension.
    """

    name: str
    label: str
    title: str
    source: str
    keys: tuple[str, ...]
    steel_factor: float = INF
    concrete_factor: float = INF
    product: str = "d² √(f_c E_c)"
    note: str = ""
    powers: tuple[float, float, float, float] = (2.0, 0.0, 0.5, 0.5)
    over_area: bool = False
    head_factor: float = INF
    reduces_stocky: bool = False
    cone: bool = False
    pry_depth: float = 0.0
    characteristic: bool = False
    deck_rule: str = ""
    load: str = "shear"
    limits: tuple[FormulaBound, ...] = ()

    @property
    def formula(self) -> str:
        """The formula in symbols: d, h, h_ef, A_s of the shank, A_h of the head, f_u, f_c, E_c."""
        terms = {
            " A_s f_u": self.steel_factor,
            f" {self.product}": self.concrete_factor,
            " A_h f_c": self.head_factor,
        }
        words = [f"{factor:g}{rest}" for rest, factor in terms.items() if np.isfinite(factor)]
        return "P = " + (f"min({'; '.join(words)})" if words[1:] else words[0]) + self.note

    def steel(self, diameter: ArrayLike, ultimate_strength: ArrayLike) -> Array:
        """Steel term (n,) in N for diameters (m) and tensile strengths (Pa)."""
        if np.isinf(self.steel_factor):
            return np.full(np.broadcast(diameter, ultimate_strength).shape, INF)
        return np.asarray(self.steel_factor * shank_area(diameter) * np.asarray(ultimate_strength))

    def concrete(
        self,
        diameter: ArrayLike,
        height: ArrayLike,
        strength: ArrayLike,
        modulus: ArrayLike,
        embedment: ArrayLike | None = None,
    ) -> Array:
        """Concrete term (n,) in N for diameters and heights (m), strength and modulus (Pa).

        `embedment` in m (None: that of a usual head). NaN for studs below h/d = 3 where the formula
        has no value.
        """
        d, h = np.asarray(diameter, float), np.asarray(height, float)
        depth = embedment_of(d, h) if embedment is None else np.asarray(embedment, float)
        if np.isinf(self.concrete_factor):
            return np.full(np.broadcast(d, strength).shape, INF)
        term = self.concrete_factor * self._stockiness(d, h)
        sizes = (1e3 * d, 1e3 * depth, 1e-6 * np.asarray(strength), 1e-6 * np.asarray(modulus))
        for base, power in zip(sizes, self.powers, strict=True):
            if power:
                term = term * base**power
        twice = 1.0 + (depth >= self.pry_depth * (1.0 - _ROUND)) * bool(self.pry_depth)
        return np.asarray(term * twice * (0.25 * np.pi if self.over_area else 1.0))

    def _stockiness(self, diameter: Array, height: Array) -> Array:
        slenderness = height / diameter if self.reduces_stocky else np.full(diameter.shape, 9.0)
        stocky = slenderness < LEAST_SLENDERNESS
        # np.minimum keeps NaN: without a height there is no value, rather than alpha = 1
        return np.where(stocky, np.nan, np.minimum(0.2 * (slenderness + 1.0), 1.0))

    def of(self, tests: Specimens) -> Array:
        """Strength (n,) of tested specimens with their mean material values, in N.

        NaN where a value that the formula needs was not reported.
        """
        return np.minimum(*self.terms(tests))

    def terms(self, tests: Specimens) -> tuple[Array, Array]:
        """Steel and concrete term (n,) each of tested specimens, in N."""
        d, strength, ultimate = tests.diameter, tests.concrete_strength, tests.ultimate_strength
        sizes = (d, tests.height, strength, tests.concrete_modulus, tests.embedment)
        concrete = self.concrete(*sizes)
        if self.cone:  # EN 1992-4, 7.2.1.4: area of the cone, and edges that disturb it
            free = np.fmin(tests.free_width / (3.0 * tests.embedment), 1.0)
            concrete = concrete * free * (0.7 + 0.3 * free)
        if np.isfinite(self.head_factor):
            head = shank_area(tests.head_diameter) - tests.area
            concrete = np.minimum(concrete, self.head_factor * head * strength)
        decks = tests.decks
        if decks is None:
            return self.steel(d, ultimate), concrete
        if self.deck_rule == "en1994":
            across = decks.profiled & ~decks.parallel
            capped = np.where(across, np.minimum(ultimate, MOST_IN_DECKS), ultimate)
            reduction = decks.reduction_en1994(tests.height, d)
            return self.steel(d, capped) * reduction, concrete * reduction
        steel = self.steel(d, ultimate)
        if self.deck_rule == "aisc360":
            return steel * decks.reduction_aisc360(), concrete
        reduction = np.where(decks.profiled, np.nan, 1.0)
        return steel * reduction, concrete * reduction

    def findings(self, tests: Specimens) -> list[Finding]:
        """Tests outside the range that the code states; empty when all are in."""
        counts = {limit.words: limit.beyond(tests) for limit in self.limits}
        how: dict[str, Any] = {"tests": len(tests), "title": self.title}
        return [finding("stud-outside", words=w, count=n, **how) for w, n in counts.items() if n]

    def scaled(self, **factors: float) -> Formula:
        """Formula with another factor ``steel``, ``concrete`` or both (a fitted form)."""
        changes: dict[str, Any] = {f"{name}_factor": value for name, value in factors.items()}
        return replace(self, **changes)


def _declared(load: str) -> dict[str, Formula]:
    declared = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    limits = {name: FormulaBound(**each) for name, each in declared["limits"].items()}
    formulas = {}
    for name, each in declared[load].items():
        fields = {k: tuple(v) if isinstance(v, list) else v for k, v in each.items()}
        fields["limits"] = tuple(limits[limit] for limit in each.get("limits", ()))
        formulas[name] = Formula(**{**fields, "name": name, "load": load})
    return formulas


SHEAR_MODELS, TENSION_MODELS = _declared("shear"), _declared("tension")
FORMULAS = SHEAR_MODELS | TENSION_MODELS


def strength_formula(name: str) -> Formula:
    """The formula of this name, of shear or tension. Raises `InputError`."""
    Choice(tuple(FORMULAS)).check("model", name)
    return FORMULAS[name]


def characteristic_strength(mean_strength: ArrayLike) -> Array:
    """Characteristic concrete strength f_ck = f_cm - 8 MPa, in Pa (EN 1992-1-1, table 3.1)."""
    return np.asarray(np.asarray(mean_strength, float) - STRENGTH_MARGIN)


DIAMETER, HEIGHT, CONCRETE, STEEL = 0.019, 0.1, 30e6, 450e6  # m; characteristic, specified, in Pa
_MEAN, _CODES = "roik-mean", ("roik-mean", "en1994", "aisc360")
_PARTIAL = {"en1994": 1.25}  # gamma_V of EN 1994-1-1, 6.6.3.1


def usual_stud(model: Formula) -> dict[str, float | None] | None:
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
    steel, moduli = float(model.steel(DIAMETER, STEEL)), (modulus, concrete_modulus(mean))
    terms = [float(model.concrete(DIAMETER, HEIGHT, strength, each)) for each in moduli]
    return {
        **{"diameter": DIAMETER, "height": HEIGHT, "ultimate_strength": STEEL},
        **{"concrete_strength": strength, "concrete_modulus": modulus},
        **{"steel_term": steel, "concrete_term": terms[0], "other_concrete_term": terms[1]},
        **{"resistance": min(steel, terms[0]), "partial_factor": _PARTIAL.get(model.name)},
    }


# -- fit of the factors: one is only seen by tests that its term, the smaller of the two, governs


FACTORS = {"steel": (0.1, 5.0), "concrete": (0.02, 200.0)}  # bounds that no sensible fit reaches


def fit_factors(
    table: pd.DataFrame,
    model: str | Formula = "roik-mean",
    factors: Sequence[str] = ("concrete",),
    *,
    loss: str = "linear",
    confidence: float = 0.9,
    slab: str = "solid",
) -> Fitted:
    """Fit factors of a formula, `scaled` by them, to the undamaged headed studs of a table.

    Arguments: `model`, name or `Formula`, gives the start and the factors that are held;
    `factors` out of ``steel`` and ``concrete``; the rest as in `fit_strength`. Raises `InputError`
    for a factor whose term governs no test.
    """
    chosen = strength_formula(model) if isinstance(model, str) else model
    for name in factors:
        Choice(tuple(FACTORS)).check("factors", name)
        if name == "steel" and np.isinf(chosen.steel_factor):
            raise InputError("factors", name, f"{chosen.title} has no steel term")
    if np.isinf(chosen.concrete_factor) or np.isfinite(chosen.head_factor):
        raise InputError("factors", chosen.name, "must have one term of concrete to fit factors")
    rows = undamaged_headed_studs(table, slab, chosen.load)
    rows = rows[np.isfinite(chosen.of(specimens(rows)))].reset_index(drop=True)
    tests = specimens(rows)
    names, predict = tuple(factors), prediction(tests, chosen, tuple(factors))
    start = np.log([getattr(chosen, f"{name}_factor") for name in names])
    low, high = np.log([FACTORS[name] for name in names]).T
    load = np.log(tests.quantity(chosen.load))
    given = problem(load, tests.campaign, predict, names, start, lower=low, upper=high)
    try:
        estimate = fit_robust(given, loss)
    except InputError as error:
        if error.field not in factors or not isinstance(error.value, float):
            raise
        value = float(np.exp(error.value))  # what is fitted is the logarithm
        raise InputError(error.field, value, error.allowed, error.advice) from error
    return fitted(estimate, factors, confidence=confidence)


def prediction(tests: Specimens, model: Formula, factors: tuple[str, ...]) -> Prediction:
    """Logarithm of the resistance as a function of the logarithms of `factors`."""
    # terms for a factor of 1, so that a prediction costs a minimum of two arrays
    steel, concrete = (np.log(term) for term in model.scaled(steel=1.0, concrete=1.0).terms(tests))
    fixed = {"steel": np.log(model.steel_factor), "concrete": np.log(model.concrete_factor)}

    def predict(theta: Array) -> Array:
        now = {**fixed, **dict(zip(factors, theta, strict=True))}
        return np.asarray(np.minimum(now["steel"] + steel, now["concrete"] + concrete))

    return predict
