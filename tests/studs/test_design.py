"""From tests to design values: bands of medians, few tests, interaction, decks."""

from __future__ import annotations

import json
from itertools import pairwise
from math import exp, sqrt
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.studs import fit_residual, fit_strength
from workbench.studs.formulas import SHEAR_MODELS
from workbench.studs.interaction import fit_interaction, log_reach
from workbench.studs.schema import TESTS, from_frame
from workbench.studs.series import evaluate_few, few_tests_factor
from workbench.studs.tables import specimens

Capture = pytest.CaptureFixture[str]


def push_outs(rows: list[dict[str, object]]) -> pd.DataFrame:
    """A table of push-outs of 19 mm studs; names where none are given."""
    values = {"campaign": "lab", "test": "push-out", "diameter_mm": 19.0, "height_mm": 100.0,
            "fcm_MPa": 30.0, "fu_MPa": 470.0}  # fmt: skip
    named = [{"specimen": f"s{i}", **values, **row} for i, row in enumerate(rows)]
    return from_frame(pd.DataFrame(named), TESTS)


def after_fatigue(
    sizes: list[int], quantity: str = "shear", seed: int = 4, sigma: float = 0.05
) -> pd.DataFrame:
    """Tests of campaigns of some sizes after fatigue, 1 - 0.4 D left."""
    generator, rows = np.random.default_rng(seed), []
    columns = {
        "shear": ("shear_kN", "undamaged_shear_kN"),
        "stiffness": ("stiffness_10_40_kN_per_mm", "undamaged_stiffness_kN_per_mm"),
    }
    for j, count in enumerate(sizes):
        effect = 0.05 * generator.normal()
        for level in generator.uniform(0.05, 1.0, count):
            left = 1.0 - 0.4 * level + effect + sigma * generator.normal()
            damage = {"predamage": "fatigue", "predamage_measure": "life fraction",
                      "predamage_level": round(level, 4), "shear_kN": 90.0}  # fmt: skip
            value, whole = columns[quantity]
            rows.append({"campaign": f"lab {j}", **damage, value: 100.0 * left, whole: 100.0})
    return push_outs(rows)


# -- what is left, for design --------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize("quantity", ["strength", "stiffness"])
def test_design_rows_are_fractiles_and_lie_in_order(quantity: str) -> None:
    kind = "shear" if quantity == "strength" else quantity
    fit = fit_residual(after_fatigue([6, 6, 6, 6], kind), quantity)
    rows = fit.design_rows(0.9)
    assert rows["level"].tolist() == pytest.approx([0.25, 0.5, 0.75, fit.levels[1]])
    names = ["characteristic", "low", "median", "high"]
    for smaller, larger in pairwise(names):
        assert (rows[smaller] < rows[larger]).all(), (smaller, larger)
    # 0.1 % of new tests lie far below 5 %: perhaps nothing is left, and then no value is given
    statements = rows[rows["design"].notna()]
    assert (statements["design"] < statements["characteristic"]).all()
    assert (statements["design"] > 0.0).all()
    fractiles = fit.quantiles(rows["level"], (0.05, 0.001))
    assert rows["characteristic"].to_numpy() == pytest.approx(fractiles[0])
    assert statements["design"].to_numpy() == pytest.approx(fractiles[1][rows["design"].notna()])


def test_one_laboratory_moves_with_every_test() -> None:
    alone = fit_residual(after_fatigue([7]))
    assert alone.summary()["foretold"] == "this laboratory alone"
    moved = alone.influence()
    assert moved["without"].min() < moved["value"].iloc[0] < moved["without"].max()


# -- few tests -----------------------------------------------------------------------------------


def test_factors_of_few_tests_are_those_of_table_d3() -> None:
    printed = {0.05: (0.80, 0.90), 0.11: (0.70, 0.80), 0.17: (0.60, 0.70)}
    for variation, (one, more) in printed.items():
        assert few_tests_factor(1, variation) == pytest.approx(one, abs=7e-3)
        assert few_tests_factor(3, variation) == pytest.approx(more, abs=7e-3)
    with pytest.raises(InputError, match="one to three"):
        few_tests_factor(4, 0.1)


def test_few_tests_of_a_table() -> None:
    damage = {"predamage": "pull-out", "predamage_measure": "load ratio", "predamage_level": 0.5,
              "undamaged_shear_kN": 100.0}  # fmt: skip
    loads = {"a": (100.0, 110.0), "b": (80.0, 110.0), "c": (1.0, 1.01, 0.99, 1.02)}
    rows = [{"campaign": c, "shear_kN": 100.0 * x if c == "c" else x}
            for c, each in loads.items() for x in each]  # fmt: skip
    rows.append({"campaign": "a", "shear_kN": 80.0, **damage})
    first, apart, many, left = evaluate_few(push_outs(rows), 0.11)
    eta = exp(-0.22 - 0.5 * 0.11**2)
    assert first.characteristic == pytest.approx(eta * 105e3, rel=1e-4)
    assert apart.characteristic is None
    assert "within 10 %" in apart.refusal
    assert "D.8.2" in many.refusal
    assert (left.kind, left.tests) == ("strength left", 1)
    assert left.characteristic == pytest.approx(0.8 * 0.9 * exp(-2.31 * 0.11 - 0.5 * 0.11**2))


def test_few_tests_on_the_command_line(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "lab.csv"
    push_outs([{"shear_kN": 100.0}]).to_csv(file, index=False)
    assert run(["fit", "few-tests", str(file)]) == 2
    assert "--known-variation" in capsys.readouterr().err
    assert run(["fit", "few-tests", str(file), "--known-variation", "0.11", "--json"]) == 0
    (group,) = json.loads(capsys.readouterr().out)["results"]["groups"]
    assert group["characteristic"] == pytest.approx(69.4e3, rel=1e-3)


# -- tension with shear --------------------------------------------------------------------------


def combined(exponent: float, sigma: float, campaigns: int = 3, seed: int = 5) -> pd.DataFrame:
    generator, rows = np.random.default_rng(seed), []
    for j in range(campaigns):
        name = {"campaign": f"lab {j}"}
        rows += [{**name, "shear_kN": 100.0}] * 3
        rows += [{**name, "test": "pull-out", "tension_kN": 80.0}] * 3
        for angle in (0.25, 0.6, 0.9, 1.3):
            r = exp(float(log_reach(np.array(angle), exponent))) * exp(sigma * generator.normal())
            loads = {"shear_kN": 100.0 * r * np.sin(angle), "tension_kN": 80.0 * r * np.cos(angle)}
            rows.append({**name, "test": "combined", **loads})
    return push_outs(rows)


@pytest.mark.parametrize("exponent", [1.0, 5.0 / 3.0, 4.0])
def test_the_exponent_is_found_again(exponent: float) -> None:
    fit = fit_interaction(combined(exponent, 0.0))
    assert fit.exponent == pytest.approx(exponent, rel=1e-4)
    values = {1.0: "linear", 5.0 / 3.0: "five-thirds"}.get(exponent)
    medians = {name: judged.summary["test_over_prediction"] for name, judged in fit.laws}
    if values:
        assert medians[values] == pytest.approx(1.0, abs=1e-3)
    noisy = fit_interaction(combined(exponent, 0.04))
    interval = noisy.fitted.parameters["exponent"]
    assert interval.low is not None
    assert interval.high is not None
    assert interval.low < exponent < interval.high
    scipy_free = noisy.rows["shear"] ** noisy.exponent + noisy.rows["tension"] ** noisy.exponent
    assert np.log(scipy_free).mean() == pytest.approx(0.0, abs=0.05)


def test_interaction_on_the_command_line(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "lab.csv"
    combined(1.8, 0.04).to_csv(file, index=False)
    assert run(["fit", "interaction", str(file), "--validate", "lab 2"]) == 0
    text = capsys.readouterr().out
    assert "8 combined tests of lab 0, lab 1: fitted to combined tests of two campaigns" in text
    assert "five-thirds" in text
    assert "Unseen tests" in text
    assert run(["fit", "interaction"]) == 2
    error = capsys.readouterr().err
    assert "combined tests of tension and shear: two or more are needed" in error


def test_companions_stand_in_like_concrete() -> None:
    table = combined(1.8, 0.0, 1)
    table.loc[table["test"] == "combined", "fcm_MPa"] = 45.0
    with pytest.raises(InputError, match="0 usable"):
        fit_interaction(table)


# -- profiled decks ------------------------------------------------------------------------------


def in_deck(**changes: object) -> pd.DataFrame:
    deck = {"slab": "deck transverse", "deck_depth_mm": 55.0, "deck_width_mm": 110.0,
            "deck_thickness_mm": 1.2, "studs_per_rib": 1.0, "shear_kN": 80.0}  # fmt: skip
    return push_outs([{**deck, **changes}])


@pytest.mark.parametrize(
    ("changes", "k", "steel"),
    [
        ({}, 1.0, 0.8),  # 0.7 x 2 x (100 / 55 - 1) = 1.15, limit 1.0; AISC 1.0 x 0.6 / 0.75
        ({"deck_thickness_mm": 0.9}, 0.85, 0.8),
        ({"studs_per_rib": 2.0, "deck_width_mm": 90.0}, 0.7 / sqrt(2) * 90 / 55 * (45 / 55), 0.68),
        ({"deck_fixing": "holes"}, 0.75, 0.8),
        ({"deck_stud_position_mm": 60.0}, 1.0, 1.0),
        ({"slab": "deck parallel", "deck_width_mm": 60.0}, 0.6 * 60 / 55 * (100 / 55 - 1), 0.85),
        ({"studs_per_rib": 3.0}, None, 0.7 * 0.8),
        ({"deck_width_mm": 50.0}, None, 0.8),
        ({"deck_depth_mm": 90.0, "deck_width_mm": 150.0}, None, 0.8),
        ({"deck_depth_mm": np.nan}, None, None),
    ],
)
def test_reductions_of_decks(
    changes: dict[str, object], k: float | None, steel: float | None
) -> None:
    tests = specimens(in_deck(**changes))
    area, concrete = 0.25 * np.pi * 0.019**2, sqrt(30e6 * 4733e6 * sqrt(30.0))
    terms = np.array([0.8 * area * 470e6, 0.29 * 0.019**2 * concrete])
    expected = np.nan if k is None else k * terms.min()
    result = SHEAR_MODELS["en1994"].of(tests)[0]
    assert result == pytest.approx(expected, rel=1e-6, nan_ok=True)
    expected = np.nan if steel is None else min(steel * 0.75 * area * 470e6, 0.5 * area * concrete)
    assert SHEAR_MODELS["aisc360"].of(tests)[0] == pytest.approx(expected, rel=1e-6, nan_ok=True)
    assert np.isnan(SHEAR_MODELS["ollgaard"].of(tests)[0])  # no rule for decks


def test_decks_are_fitted_apart_from_solid_slabs(tmp_path: Path, capsys: Capture) -> None:
    decks = [in_deck(specimen=f"d{i}", shear_kN=70.0 + 3.0 * i) for i in range(4)]
    solid = push_outs([{"specimen": f"p{i}", "shear_kN": 110.0 + i} for i in range(4)])
    table = pd.concat([*decks, solid], ignore_index=True)
    fit_, apart = (fit_strength(table, "en1994", slab=slab) for slab in ("deck", "solid"))
    assert set(fit_.rows["specimen"]) == {"d0", "d1", "d2", "d3"}
    assert set(apart.rows["specimen"]) == {"p0", "p1", "p2", "p3"}
    tests = specimens(pd.concat(decks))
    assert fit_.d8.r_m == pytest.approx(float(np.mean(SHEAR_MODELS["en1994"].of(tests))), rel=1e-6)
    file = tmp_path / "lab.csv"
    pd.concat(decks).to_csv(file, index=False)
    assert run(["fit", "stud-strength", str(file)]) == 2
    assert "--slab deck" in capsys.readouterr().err
    arguments = ["--slab", "deck", "--model", "en1994", "--factor", "concrete"]
    assert run(["fit", "stud-strength", str(file), *arguments]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "not told, so assumed: deck_fixing of 4 tests: welded through" in text
