"""Tests that a loss hides, outliers that hide each other, studs weaker than what they have borne.

Right values by hand: median and standard deviation of the tests without the outliers.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.cli import run
from workbench.studs import TESTS, fit_residual, fit_strength
from workbench.studs.schema import from_frame
from workbench.studs.statistics.mixed import LOSSES

SOUND = [104.5, 106.1, 103.2, 105.0, 104.1]
Capture = pytest.CaptureFixture[str]


def push_outs(loads: list[float], campaign: str = "lab") -> pd.DataFrame:
    rows = {
        "campaign": campaign, "specimen": [f"M{k}" for k in range(len(loads))], "test": "push-out",
        "diameter_mm": 19.0, "height_mm": 100.0, "fcm_MPa": 31.2, "fu_MPa": 472.0,
        "shear_kN": loads,
    }  # fmt: skip
    return from_frame(pd.DataFrame(rows), TESTS)


def told(fit: object, subject: str = "outlier") -> list[str]:
    return [str(each) for each in fit.findings if each.subject == subject]  # type: ignore[attr-defined]


@pytest.mark.parametrize("loss", LOSSES)
def test_two_outliers_do_not_hide_each_other(loss: str) -> None:
    fit = fit_strength(push_outs([*SOUND, 61.0, 60.2]), loss=loss)
    named = " ".join(each for each in told(fit) if each.startswith("outlier"))
    assert [f"M{k}," in named for k in range(7)] == [False] * 5 + [True] * 2
    distance = (np.mean(np.log(SOUND)) - np.log(60.2)) / np.std(np.log(SOUND), ddof=1)
    assert f"({distance / np.sqrt(1.2):.1f} standard deviations)" in named


def test_tests_of_small_weight_are_named_and_the_scatter_is_of_the_others() -> None:
    fit = fit_strength(push_outs([*SOUND, 61.0, 60.2]), loss="bisquare")
    (weights,) = (each for each in told(fit) if "weight" in each and "outlier: " not in each)
    assert "lab M5 (0.00), lab M6 (0.00)" in weights
    assert "those of 5 of 7 tests" in weights
    alone = fit_strength(push_outs(SOUND))
    assert fit.bias == pytest.approx(alone.bias, rel=1e-3)
    assert fit.fitted.sigma.value == pytest.approx(alone.fitted.sigma.value, rel=0.1)
    assert not any("weight to" in each for each in told(fit_strength(push_outs(SOUND))))


@pytest.mark.thorough
@pytest.mark.parametrize("loss", LOSSES)
def test_an_outlier_after_damage_is_named_with_every_loss(loss: str) -> None:
    generator, rows = np.random.default_rng(3), []
    for lab in range(3):
        for level in (0.03, 0.06, 0.1, 0.15, 0.2, 0.25):
            left = 1.0 - 1.1 * level + 0.015 * generator.normal()
            rows.append({
                "campaign": f"K{lab}", "specimen": f"{level:g}", "test": "push-out",
                "diameter_mm": 13, "shear_kN": 66.0 * left, "predamage": "corrosion",
                "predamage_measure": "section loss", "predamage_level": level,
                "undamaged_shear_kN": 66.0,
            })  # fmt: skip
    rows[8]["shear_kN"] = 30.0
    fit = fit_residual(from_frame(pd.DataFrame(rows), TESTS), loss=loss)
    assert any("K1 0.1, 0.455" in each for each in told(fit))
    assert any("17 of 18 tests" in each for each in told(fit)) == (loss != "linear")


def test_clean_tests_are_not_named() -> None:
    assert not told(fit_strength(push_outs(SOUND)))


@pytest.mark.parametrize(
    ("columns", "borne"),
    [
        ({"predamage_peak_kN": 90.0, "predamage_range_kN": 72.0}, 90),
        ({"predamage_range_kN": 176.0}, 88),
    ],
)
def test_no_stud_is_weaker_than_what_it_has_just_borne(
    columns: dict[str, float], borne: int, tmp_path: Path, capsys: Capture
) -> None:
    rows = push_outs([110.0, 105.0, 78.0, 99.0]).assign(
        predamage="fatigue", predamage_cycles=[1e5, 2e5, 9e5, 3e5], predamage_life_cycles=1e6,
        undamaged_shear_kN=120.0, **columns,
    )  # fmt: skip
    file = tmp_path / "lab.csv"
    rows.to_csv(file, index=False)
    assert run(["data", "check", str(file)]) == 1
    words = "line 4, column shear_kN = 78.0: is less than the load that the stud has borne"
    shown = " ".join(capsys.readouterr().out.split())
    assert words in shown
    assert f"have reached {borne} kN" in shown
    arguments = ["fit", "residual", str(file), "--no-mechanical", "--quantity", "strength"]
    assert run(arguments) == 2
    assert "line 4" in capsys.readouterr().err
    rows["shear_kN"] = [110.0, 105.0, 84.0, 99.0]  # both are measured: named only
    rows.to_csv(file, index=False)
    assert run(["data", "check", str(file)]) == 0
    assert run(arguments) == 0
    assert ("had just borne: lab M2" in capsys.readouterr().out) == (borne == 90)


# -- one laboratory, and a scatter between laboratories that is known ---------------------------


ELEVEN = [101.0, 104.2, 98.7, 102.4, 105.9, 99.6, 103.3, 100.8, 97.9, 104.8, 102.0]


def test_one_laboratory_has_a_band_of_its_own() -> None:
    """Student's t: mean -+ t_10 s sqrt(1 + 1/11) of the logarithms, t_10(0.95) = 1.8125."""
    fit = fit_strength(push_outs(ELEVEN))
    logs = np.log(np.array(ELEVEN) * fit.bias / np.exp(np.mean(np.log(ELEVEN))))
    half = 1.8125 * np.std(logs, ddof=1) * np.sqrt(12 / 11)
    own = {name: fit.summary()[name] for name in ("own_low", "own_high", "own_factor")}
    low, high = np.exp(np.mean(logs) - half), np.exp(np.mean(logs) + half)
    assert list(own.values()) == pytest.approx([low, high, low], rel=1e-4)
    assert fit.new_campaign_factor is None
    assert any("of this laboratory alone" in each for each in told(fit, "campaigns"))


def test_a_known_scatter_between_laboratories_speaks_for_others() -> None:
    """Many equal tests: the bias is known to 0.06, as its campaign is, a new test to 0.085."""
    loads = [100.0 * f for f in np.exp(0.001 * np.linspace(-1.0, 1.0, 41))]
    fit = fit_strength(push_outs(loads), known_between=0.06)
    bias = fit.fitted.parameters["bias"]
    assert bias.low is not None
    assert np.log(bias.value / bias.low) == pytest.approx(1.645 * 0.06, rel=0.01)
    assert fit.new_campaign_factor == pytest.approx(
        fit.bias * np.exp(-1.645 * 0.06 * np.sqrt(2.0)), rel=1e-3
    )
    assert fit.summary()["own_factor"] is None
    assert any("is given and not told" in each for each in told(fit, "campaigns"))


def test_the_verb_takes_the_known_scatter(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "lab.csv"
    push_outs(ELEVEN).to_csv(file, index=False)
    arguments = ["fit", "stud-strength", str(file), "--model", "roik-mean"]
    assert run(arguments) == 0
    assert "A new test of this laboratory alone" in capsys.readouterr().out
    assert run([*arguments, "--known-between", "0.06"]) == 0
    assert "A new test of this laboratory alone" not in capsys.readouterr().out
    assert run([*arguments, "--known-between", "6"]) == 2
    assert "--known-between" in capsys.readouterr().err
