"""Resistance formulas in shear, and laws of tension with shear."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.studs import INTERACTIONS, SHEAR_MODELS, strength_formula
from workbench.studs.formulas import Formula, characteristic_strength
from workbench.studs.tables import concrete_modulus, specimens

D, H, FC, EC, FU = 0.019, 0.1, 30e6, 32e9, 450e6
AREA = pi * D**2 / 4


def resistance(model: Formula, d: float, h: float, fc: float, ec: float, fu: float) -> float:
    return float(np.minimum(model.steel(d, fu), model.concrete(d, h, fc, ec)))


def test_en1994_by_hand() -> None:
    model = SHEAR_MODELS["en1994"]
    # 0.8 x 450 x 283.53 = 102.07 kN; 0.29 x 361 x sqrt(30 x 32000) = 102.58 kN
    assert model.steel(D, FU) == pytest.approx(102.07e3, rel=7e-6)  # measured 3.4e-6
    assert model.concrete(D, H, FC, EC) == pytest.approx(102.58e3, rel=1e-4)  # measured 5.0e-5
    # measured 3.4e-6
    assert resistance(model, D, H, FC, EC, FU) == pytest.approx(102.07e3, rel=7e-6)


def test_stocky_studs() -> None:
    model = SHEAR_MODELS["en1994"]
    full = model.concrete(D, 4.0 * D, FC, EC)
    assert model.concrete(D, 10.0 * D, FC, EC) == pytest.approx(float(full))
    assert model.concrete(D, 3.0 * D, FC, EC) == pytest.approx(0.8 * float(full))
    assert model.concrete(D, 3.5 * D, FC, EC) == pytest.approx(0.9 * float(full))
    assert np.isnan(model.concrete(D, np.nan, FC, EC))
    assert np.isnan(model.concrete(D, 2.9 * D, FC, EC))  # it starts at 3
    assert SHEAR_MODELS["aisc360"].concrete(D, np.nan, FC, EC) > 0.0


def test_other_models_by_hand() -> None:
    root = sqrt(FC * EC)
    assert resistance(SHEAR_MODELS["roik-mean"], D, H, 20e6, 25e9, FU) == pytest.approx(
        0.374 * D**2 * sqrt(20e6 * 25e9)
    )
    assert resistance(SHEAR_MODELS["roik-mean"], D, H, 90e6, 40e9, FU) == pytest.approx(AREA * FU)
    assert resistance(SHEAR_MODELS["aisc360"], D, H, FC, EC, FU) == pytest.approx(
        min(0.5 * AREA * root, 0.75 * AREA * FU)
    )
    assert resistance(SHEAR_MODELS["ollgaard"], D, H, FC, EC, 1.0) == pytest.approx(
        0.5 * AREA * root
    )


def test_regression_agrees_with_its_simplified_form() -> None:
    for strength in (25e6, 30e6, 35e6):
        modulus = concrete_modulus(strength)
        simple = SHEAR_MODELS["ollgaard"].concrete(D, H, strength, modulus)
        # Q = 1.106 A_s f_c^0.3 E_c^0.44 in kip and inch, Ollgaard et al. 1971
        area, fc, ec = AREA / 0.0254**2, strength / 6.894757e6, float(modulus) / 6.894757e6
        regression = 4448.222 * 1.106 * area * fc**0.3 * ec**0.44
        assert regression == pytest.approx(float(simple), rel=0.06)  # measured 0.049


def test_moduli_and_strengths() -> None:
    assert concrete_modulus(25e6) == pytest.approx(23.665e9)
    assert concrete_modulus(25e6, 2300.0) == pytest.approx(23.715e9, rel=3.3e-5)  # measured 1.6e-5
    assert characteristic_strength(38e6) == pytest.approx(30e6)


def test_an_unknown_formula_is_refused() -> None:
    with pytest.raises(InputError, match="must be one of en1994"):
        strength_formula("en1995")


def test_ranges_of_the_codes_are_told(push_outs: pd.DataFrame) -> None:
    tests = specimens(push_outs[push_outs["use_for_fit"] == 1.0])
    findings = SHEAR_MODELS["en1994"].findings(tests)
    assert any("1 of 26 tests outside d = 16 to 25 mm" in each.text for each in findings)  # P8
    assert any("25 of 26 tests outside f_u up to 500 MPa" in each.text for each in findings)
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
        if model.cone:  # grows by the power 1.5 of the size
            continue
        base = resistance(model, d, 5 * d, fc, 30e9, fu)
        assert resistance(model, scale * d, 5 * scale * d, fc, 30e9, fu) == pytest.approx(
            base * scale**2
        )
        assert resistance(model, d, 5 * d, scale * fc, 30e9, scale * fu) >= base


def test_interaction_curves() -> None:
    tension = np.array([0.1, 0.2, 0.5, 0.7, 1.0, 1.1])
    left = {name: law.shear(tension) for name, law in INTERACTIONS.items()}
    assert left["linear"] == pytest.approx([0.9, 0.8, 0.5, 0.3, 0.0, 0.0])
    assert left["five-thirds"][2] == pytest.approx((1.0 - 0.5 ** (5 / 3)) ** 0.6)
    assert left["trilinear"] == pytest.approx([1.0, 1.0, 0.7, 0.5, 0.2, 0.0])


@given(t=st.floats(0.0, 1.0))
def test_the_linear_law_is_the_safest(t: float) -> None:
    left = {name: float(law.shear(np.array(t))) for name, law in INTERACTIONS.items()}
    assert all(0.0 <= each <= 1.0 for each in left.values())
    assert left["linear"] <= min(left.values()) + 1e-12
