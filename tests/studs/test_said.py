"""What a fit says of a table is true of it: moduli, decks, roles, exponents, what was computed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from workbench.cli import run
from workbench.extras.intake.kinds import check_file
from workbench.studs import TESTS, evaluate_d8, examine, fit_strength
from workbench.studs.schema import from_frame
from workbench.studs.tables import specimens

USUAL = {"campaign": "lab", "test": "push-out", "diameter_mm": 19.0, "height_mm": 100.0}
USUAL |= {"fcm_MPa": 31.2, "fu_MPa": 472.0}


def frame(loads: list[float], **columns: Any) -> pd.DataFrame:
    names = [f"A{i}" for i in range(len(loads))]
    return pd.DataFrame({"specimen": names, "shear_kN": loads}).assign(**{**USUAL, **columns})


def texts(table: pd.DataFrame, model: str = "roik-mean", **how: Any) -> str:
    fit = fit_strength(from_frame(table, TESTS), model, **how)
    return "\n".join(each.text for each in fit.findings)


# by hand: 0.043 w^1.5 sqrt(fc) of ACI 318 against 22 (fc/10)^0.3 (w/2200)^2 of EN 1992-1-1, 11.3.2
@pytest.mark.parametrize(
    ("columns", "words"),
    [
        # 17.38 and 20.06 GPa; 14.46 and 17.55 GPa
        (
            {"fcm_MPa": 28.0, "density_kg_per_m3": 1800.0},
            "(w/2200)^2 GPa of EN 1992-1-1 is 15 % mo",
        ),
        (
            {"fcm_MPa": 20.6843, "density_kg_per_m3": 1762.03},
            "computed as 0.043 w^1.5 sqrt(fc) MPa (ACI 318), not measured; "
            "22 (fc/10)^0.3 (w/2200)^2 GPa of EN 1992-1-1 is 21 % more and would raise",
        ),
        # 66.94 and 54.04 GPa
        ({"fcm_MPa": 200.0}, "22 (fc/10)^0.3 GPa of EN 1992-1-1 is 19 % less and would lower"),
        (
            {"fcm_MPa": [20.0, 30.0, 40.0]},
            "in 3 tests the modulus of concrete is computed as 4733 sqrt(fc) MPa (ACI 318)",
        ),
        ({"fcm_MPa": [20.0, 40.0, 200.0]}, "is 19 % less to 28 % more and would change"),
    ],
)
def test_the_modulus_that_was_taken_is_the_one_that_is_named(
    columns: dict[str, Any], words: str
) -> None:
    assert words in texts(frame([104.5, 109.8, 101.9], **columns))


def test_light_and_normal_concrete_are_told_apart() -> None:
    said = texts(frame([104.5, 109.8, 101.9], density_kg_per_m3=[1800.0, 2400.0, 2350.0]))
    assert "in 1 tests the modulus of concrete is computed as 0.043 w^1.5 sqrt(fc)" in said
    assert "in 2 tests the modulus of concrete is computed as 4733 sqrt(fc)" in said


def test_what_is_assumed_of_decks_is_what_the_rule_uses() -> None:
    deck = {"slab": "deck transverse", "deck_depth_mm": 60.0, "deck_width_mm": 120.0}
    table = frame([86.0, 84.0, 88.0], **deck)
    european, american = (texts(table, name, slab="deck") for name in ("en1994", "aisc360"))
    assert "deck_thickness_mm of 3 tests" in european
    assert "AISC" not in european
    assert "deck_stud_position_mm of 3 tests: weak (AISC R_p 0.6)" in american
    assert "deck_thickness_mm" not in american
    filled = table.assign(deck_thickness_mm=0.9, studs_per_rib=1, deck_fixing="welded through")
    assert "not told, so assumed" not in texts(filled, "en1994", slab="deck")


def test_d8_is_of_the_formula_with_the_exponents_that_are_fitted() -> None:
    """b and V_delta by hand, of the formula times (d / d_0)^c with the c of the same table."""
    diameters = np.repeat([13.0, 16.0, 19.0, 22.0], 3)
    load = 0.075 * diameters**2.5 * np.tile([1.0, 1.04, 0.97], 4)
    table = frame(load.tolist(), diameter_mm=diameters, height_mm=5.0 * diameters)
    bare = fit_strength(from_frame(table, TESTS), "roik-mean")
    fit = fit_strength(from_frame(table, TESTS), "roik-mean", trends=("diameter",))
    exponent = fit.fitted.parameters["diameter"].value
    assert exponent == pytest.approx(0.5, abs=0.02)  # the formula has d^2
    middle = np.exp(np.mean(np.log(diameters)))
    predicted = fit.model.of(specimens(fit.kept)) * (diameters / middle) ** exponent
    b = np.sum(1e3 * load * predicted) / np.sum(predicted**2)
    scatter = np.std(np.log(1e3 * load / (b * predicted)), ddof=1)
    assert fit.d8.b == pytest.approx(b, rel=1e-12)
    assert fit.d8.V_delta == pytest.approx(np.sqrt(np.expm1(scatter**2)), rel=1e-12)
    assert fit.d8.V_delta < 0.35 * bare.d8.V_delta
    assert fit.d8.r_m == pytest.approx(bare.d8.r_m, rel=1e-12)  # at the middle of the tests
    assert fit.d8.r_nominal == pytest.approx(bare.d8.r_nominal, rel=1e-12)  # that of the code
    # V_rt: the exponent of the diameter is that of the formula and the fitted one
    more = (2.0 + exponent) ** 2 - 2.0**2
    assert fit.d8.V_rt**2 - bare.d8.V_rt**2 == pytest.approx(0.01**2 * more, rel=1e-3)


def test_without_a_factor_in_the_standard_there_is_no_design_value(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    few = evaluate_d8([10.0, 11.0, 10.5], [10.0, 10.0, 10.0])
    assert (few.k_dn, few.r_d, few.gamma_m, few.gamma_m_star) == (None, None, None, None)
    assert few.r_k > 0.0
    assert evaluate_d8([10.0, 11.0, 10.5, 10.2], [10.0] * 4).r_d is not None
    file = tmp_path / "lab.csv"
    frame([104.5, 109.8, 101.9]).to_csv(file, index=False)
    assert run(["fit", "stud-strength", str(file), "--model", "roik-mean", "--json"]) == 0
    (d8,) = json.loads(capsys.readouterr().out)["results"]["d8"]
    assert (d8["r_d"], d8["gamma_m"], d8["k_dn"]) == (None, None, None)


@pytest.mark.parametrize("role", ["validate", "verify"])
def test_rows_that_may_not_be_fitted_are_counted_and_the_way_is_named(
    role: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "lab.csv"
    frame([104.5, 109.8, 101.9], role=role).to_csv(file, index=False)
    assert run(["fit", "stud-strength", str(file)]) == 2
    error = capsys.readouterr().err
    assert f"table = '3 rows': none may be fitted: their role is {role} in 3" in error
    assert 'the role "calibrate"' in error
    assert "()" not in error


def test_the_shear_of_a_stud_is_computed_from_the_load_of_the_specimen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = frame([104.5, 109.8, 101.9]).drop(columns="shear_kN")
    table = table.assign(n_studs=8, total_load_kN=[836.0, 878.4, 815.2])
    file = tmp_path / "lab.csv"
    table.to_csv(file, index=False)
    found = examine(file, TESTS)
    assert found.accept()["shear_kN"].tolist() == pytest.approx([104.5, 109.8, 101.9], rel=1e-12)
    assert found.notes == ("shear_kN is computed as total_load_kN / n_studs in 3 rows",)
    assert run(["fit", "stud-strength", str(file), "--model", "roik-mean"]) == 0
    assert "lab.csv: shear_kN is computed as total_load_kN / n_studs" in capsys.readouterr().out
    table.drop(columns="n_studs").to_csv(file, index=False)
    assert run(["fit", "stud-strength", str(file)]) == 2
    assert "or total_load_kN with n_studs" in capsys.readouterr().err


def test_a_column_that_is_assumed_is_named(tmp_path: Path) -> None:
    file = tmp_path / "lab.csv"
    frame([104.5, 109.8, 101.9]).drop(columns="fcm_MPa").to_csv(file, index=False)
    words = "fcm_MPa (30) is in no row: models that need it assume this"
    assert check_file(file) == ([], [], [words])
    frame([104.5, 109.8, 101.9]).to_csv(file, index=False)
    assert check_file(file) == ([], [], [])


def test_one_campaign_is_called_one() -> None:
    from workbench.responses import finding

    assert finding("stud-few-combined-campaigns", campaigns=1).text.startswith("fewer than 3 camp")
    assert finding("stud-one-damaged-campaign").text.startswith("one campaign does not tell")


def test_no_column_is_read_that_nothing_uses() -> None:
    assert not {"strength_over_nominal", "nominal_model"} & set(TESTS.names)


def test_warnings_of_some_formulas_name_them_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "lab.csv"
    sizes = {"diameter_mm": [19.0, 19.0, 25.4, 25.4], "height_mm": [60.0, 60.0, 60.0, 60.0]}
    frame([104.5, 109.8, 151.9, 149.0], **sizes).to_csv(file, index=False)
    assert run(["fit", "stud-strength", str(file)]) == 0
    shown = capsys.readouterr().out.splitlines()
    warnings = [line[:90] for line in shown if line.startswith("warning: ")]
    heads = [line for line in shown if line.startswith("Of ") and line.endswith(" alone:")]
    assert heads
    assert len(set(heads)) == len(heads)
    assert len(set(warnings)) == len(warnings)
    assert not any("EN 1994-1-1; " in line for line in warnings)
