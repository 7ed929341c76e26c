"""Resistance formulas in shear, tension, both, and in profiled deck."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.errors import InputError, OutOfDomainError
from workbench.studs import SHEAR_MODELS, Deck, design_resistance, shear_model
from workbench.studs.quantities import concrete_modulus, specimens
from workbench.studs.shear import aisc360, characteristic_strength
from workbench.studs.tension import (
    CONE_MEAN,
    INTERACTIONS,
    Cone,
    PowerInteraction,
    TrilinearInteraction,
    pull_through_resistance,
    steel_resistance,
    tension_resistance,
)

D, H, FC, EC, FU = 0.019, 0.1, 30e6, 32e9, 450e6
AREA = pi * D**2 / 4


def test_en1994_by_hand() -> None:
    model = SHEAR_MODELS["en1994"]
    # 0.8 x 450 x 283.53 = 102.07 kN; 0.29 x 361 x sqrt(30 x 32000) = 102.58 kN
    assert model.steel(D, FU) == pytest.approx(102.07e3, rel=1e-4)
    assert model.concrete(D, H, FC, EC) == pytest.approx(102.58e3, rel=1e-4)
    assert model.resistance(D, H, FC, EC, FU) == pytest.approx(102.07e3, rel=1e-4)
    assert design_resistance(model, D, H, FC, EC, FU) == pytest.approx(81.66e3, rel=1e-4)


def test_stocky_studs() -> None:
    model = SHEAR_MODELS["en1994"]
    full = model.concrete(D, 4.0 * D, FC, EC)
    assert model.concrete(D, 10.0 * D, FC, EC) == pytest.approx(float(full))
    assert model.concrete(D, 3.0 * D, FC, EC) == pytest.approx(0.8 * float(full))
    assert model.concrete(D, 3.5 * D, FC, EC) == pytest.approx(0.9 * float(full))
    assert np.isnan(model.concrete(D, np.nan, FC, EC))
    with pytest.raises(OutOfDomainError, match=r"starts at 3"):
        model.concrete(D, 2.9 * D, FC, EC)
    assert SHEAR_MODELS["aisc360"].concrete(D, np.nan, FC, EC) > 0.0


def test_other_models_by_hand() -> None:
    root = sqrt(FC * EC)
    assert SHEAR_MODELS["roik-mean"].resistance(D, H, 20e6, 25e9, FU) == pytest.approx(
        0.374 * D**2 * sqrt(20e6 * 25e9)
    )
    assert SHEAR_MODELS["roik-mean"].resistance(D, H, 90e6, 40e9, FU) == pytest.approx(AREA * FU)
    assert SHEAR_MODELS["aisc360"].resistance(D, H, FC, EC, FU) == pytest.approx(
        min(0.5 * AREA * root, 0.75 * AREA * FU)
    )
    assert aisc360(0.85, 0.6).resistance(D, H, FC, EC, FU) == pytest.approx(0.51 * AREA * FU)
    assert SHEAR_MODELS["ollgaard"].resistance(D, H, FC, EC, 1.0) == pytest.approx(
        0.5 * AREA * root
    )


def test_regression_agrees_with_its_simplified_form() -> None:
    for strength in (25e6, 30e6, 35e6):
        modulus = concrete_modulus(strength)
        simple = SHEAR_MODELS["ollgaard"].concrete(D, H, strength, modulus)
        # Q = 1.106 A_s f_c^0.3 E_c^0.44 in kip and inch, Ollgaard et al. 1971
        area, fc, ec = AREA / 0.0254**2, strength / 6.894757e6, float(modulus) / 6.894757e6
        regression = 4448.222 * 1.106 * area * fc**0.3 * ec**0.44
        assert regression == pytest.approx(float(simple), rel=0.06)


def test_moduli_and_strengths() -> None:
    assert concrete_modulus(25e6) == pytest.approx(23.665e9)
    assert concrete_modulus(25e6, 2300.0) == pytest.approx(23.715e9, rel=1e-3)
    assert characteristic_strength(38e6) == pytest.approx(30e6)


def test_only_characteristic_models_have_a_design_value() -> None:
    with pytest.raises(InputError, match="gives mean values"):
        design_resistance(SHEAR_MODELS["roik-mean"], D, H, FC, EC, FU)
    with pytest.raises(InputError, match="must be one of en1994"):
        shear_model("en1995")


def test_ranges_of_the_codes_are_told(push_outs: pd.DataFrame) -> None:
    tests = specimens(push_outs[push_outs["use_for_fit"] == 1.0])
    found = SHEAR_MODELS["en1994"].findings(tests)
    assert any("1 of 26 tests outside d = 16 to 25 mm" in each.text for each in found)  # P8
    assert any("25 of 26 tests outside f_u up to 500 MPa" in each.text for each in found)
    (aisc,) = SHEAR_MODELS["aisc360"].findings(tests)
    assert aisc.text == (
        "1 of 26 tests outside h/d from 5 of AISC 360-22, solid slab (Rg = 1, Rp = 0.75)"
    )


@given(
    d=st.floats(0.012, 0.03), fc=st.floats(10e6, 100e6), fu=st.floats(300e6, 700e6),
    scale=st.floats(1.01, 3.0),
)  # fmt: skip
def test_resistances_grow_with_strength_and_by_the_square_of_size(
    d: float, fc: float, fu: float, scale: float
) -> None:
    for model in SHEAR_MODELS.values():
        base = model.resistance(d, 5 * d, fc, 30e9, fu)
        assert model.resistance(scale * d, 5 * scale * d, fc, 30e9, fu) == pytest.approx(
            float(base) * scale**2
        )
        assert model.resistance(d, 5 * d, scale * fc, 30e9, scale * fu) >= base


def test_deck_of_en1994() -> None:
    deck = Deck(depth=0.06, width=0.081, studs_per_rib=1, thickness=1.0e-3)
    # 0.7 x 81/60 x (95/60 - 1) = 0.5513
    assert deck.reduction_en1994(0.095, 0.019) == pytest.approx(0.55125)
    assert deck.reduction_en1994(0.15, 0.019) == pytest.approx(0.85)
    assert Deck(0.06, 0.081, studs_per_rib=2).reduction_en1994(0.095, 0.019) == pytest.approx(
        0.55125 / sqrt(2.0)
    )
    assert Deck(0.06, 0.081, welded_through=False).reduction_en1994(0.15, 0.022) == 0.75
    assert Deck(0.06, 0.081, studs_per_rib=2, thickness=1.25e-3).reduction_en1994(0.2, 0.019) == 0.8
    parallel = Deck(0.05, 0.1, direction="parallel")
    assert parallel.reduction_en1994(0.1, 0.019) == 1.0
    assert Deck(0.05, 0.05, direction="parallel").reduction_en1994(0.1, 0.019) == pytest.approx(0.6)
    # beyond h_p + 75 mm the height does not count
    assert Deck(0.05, 0.03, direction="parallel").reduction_en1994(0.3, 0.019) == pytest.approx(
        0.6 * 0.6 * 1.5
    )


@pytest.mark.parametrize(
    ("deck", "height", "diameter", "message"),
    [
        (Deck(0.06, 0.05), 0.1, 0.019, "at least as wide as deep"),
        (Deck(0.1, 0.12), 0.2, 0.019, "end at decks of 0.085 m"),
        (Deck(0.06, 0.08), 0.05, 0.019, "does not rise"),
        (Deck(0.06, 0.08, studs_per_rib=3), 0.1, 0.019, "one or two studs"),
        (Deck(0.06, 0.08), 0.1, 0.022, "studs of 20 mm welded through"),
    ],
)
def test_decks_outside_the_rule(deck: Deck, height: float, diameter: float, message: str) -> None:
    with pytest.raises(OutOfDomainError, match=message):
        deck.reduction_en1994(height, diameter)


def test_deck_of_aisc360() -> None:
    assert Deck(0.06, 0.08).factors_aisc360() == (1.0, 0.75)
    assert Deck(0.06, 0.08, studs_per_rib=2, middle_distance=0.03).factors_aisc360() == (0.85, 0.6)
    assert Deck(0.06, 0.08, studs_per_rib=3).factors_aisc360() == (0.7, 0.75)
    assert Deck(0.06, 0.1, direction="parallel").factors_aisc360() == (1.0, 0.75)
    assert Deck(0.06, 0.08, direction="parallel").factors_aisc360() == (0.85, 0.75)
    with pytest.raises(InputError, match=r"deck\.direction"):
        Deck(0.06, 0.08, direction="across")


def test_tension_modes_by_hand() -> None:
    assert steel_resistance(D, FU) == pytest.approx(127.59e3, rel=1e-4)
    # 12.7 x sqrt(30) x 90^1.5 = 59.39 kN
    assert Cone(0.09).resistance(FC) == pytest.approx(59.39e3, rel=1e-4)
    assert Cone(0.09, cracked=True).resistance(FC) / Cone(0.09).resistance(FC) == pytest.approx(
        8.9 / 12.7
    )
    assert Cone(0.09).resistance(FC, CONE_MEAN) > Cone(0.09).resistance(FC)
    # 10.5 x pi/4 (32^2 - 19^2) x 30 = 164.0 kN
    assert pull_through_resistance(D, 0.032, FC) == pytest.approx(164.03e3, rel=1e-4)
    modes = tension_resistance(D, 0.032, Cone(0.09), FC, FU)
    assert modes["governing"] == modes["cone"] < modes["steel"] < modes["pull-through"]


def test_cones_near_edges() -> None:
    wide = Cone(0.06)
    assert Cone(0.06, edge_distance=1.0, width=1.0).resistance(FC) == pytest.approx(
        wide.resistance(FC)
    )
    cut = Cone(0.06, edge_distance=0.04, width=0.08)
    assert cut.area_ratio == pytest.approx(80.0 / 180.0)
    assert cut.edge_factor == pytest.approx(0.7 + 0.3 * 40.0 / 90.0)


def test_interaction_curves() -> None:
    assert INTERACTIONS["linear"].shear_left(0.3) == pytest.approx(0.7)
    assert INTERACTIONS["five-thirds"].shear_left(0.5) == pytest.approx(
        (1.0 - 0.5 ** (5 / 3)) ** 0.6
    )
    trilinear = INTERACTIONS["trilinear"]
    assert trilinear.shear_left([0.1, 0.2, 0.7, 1.0, 1.1]).tolist() == pytest.approx(
        [1.0, 1.0, 0.5, 0.2, 0.0]
    )
    with pytest.raises(InputError, match="must not be negative"):
        trilinear.utilisation(-0.1, 0.5)
    with pytest.raises(InputError, match=r"interaction\.exponent"):
        PowerInteraction(0.5)


@given(t=st.floats(0.0, 2.0), v=st.floats(0.0, 2.0), scale=st.floats(0.1, 10.0))
def test_utilisation_is_homogeneous_and_one_on_the_curve(t: float, v: float, scale: float) -> None:
    for law in (*INTERACTIONS.values(), PowerInteraction(2.0), TrilinearInteraction(1.4)):
        used = law.utilisation(t, v)
        assert law.utilisation(scale * t, scale * v) == pytest.approx(float(used) * scale)
        assert used >= max(t, v) - 1e-12
        if t < 1.0:
            left = law.shear_left(t)
            assert law.utilisation(t, left) == pytest.approx(1.0)
    ordered = [float(INTERACTIONS[n].utilisation(t, v)) for n in ("trilinear", "linear")]
    assert ordered[0] <= ordered[1] + 1e-12
    assert float(INTERACTIONS["five-thirds"].utilisation(t, v)) <= ordered[1] + 1e-12
