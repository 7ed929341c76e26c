"""Damage as laboratories measure it: cycles, S-N lives, levels beyond one, missing companions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.studs import TESTS, fit_residual
from workbench.studs.damaged import (
    Grade,
    damage_of,
    damaged_rows,
    fatigue_life,
    predicted_references,
)
from workbench.studs.schema import examine, from_frame

Capture = pytest.CaptureFixture[str]


def cycled(**columns: object) -> pd.DataFrame:
    """Four tests after fatigue with 1 to 4 hundred thousand cycles."""
    values = {
        "campaign": "lab", "specimen": list("abcd"), "test": "push-out", "diameter_mm": 19.0,
        "shear_kN": [99.0, 96.0, 93.0, 90.0], "undamaged_shear_kN": 100.0, "predamage": "fatigue",
        "predamage_cycles": [1e5, 2e5, 3e5, 4e5], **columns,
    }  # fmt: skip
    return from_frame(pd.DataFrame(values), TESTS)


def test_the_line_of_the_code_is_met() -> None:
    area = 0.25 * np.pi * 19.0**2
    assert fatigue_life(90e-3 * area, 19.0) == pytest.approx(2e6)
    assert fatigue_life(99e-3 * area, 19.0) == pytest.approx(2e6 / 1.1**8)


def test_the_share_of_the_life_is_computed() -> None:
    reference_case = damage_of(cycled(predamage_life_cycles=1e6, predamage_range_kN=30.0))
    assert reference_case["level"].tolist() == pytest.approx([0.1, 0.2, 0.3, 0.4])
    assert set(reference_case["measure"]) == {"life fraction"}
    line = damage_of(cycled(predamage_range_kN=30.0))
    assert set(line["measure"]) == {"S-N life fraction"}
    assert line["level"].to_numpy() == pytest.approx(
        np.array([1e5, 2e5, 3e5, 4e5]) / fatigue_life(30.0, 19.0)
    )
    given = {"predamage_level": 0.3, "predamage_measure": "life fraction"}
    assert (damage_of(cycled(**given, predamage_range_kN=30.0))["level"] == 0.3).all()


def test_lives_by_the_code_are_not_mixed_with_measured_ones() -> None:
    life = [1e6, 1e6, np.nan, np.nan]
    table = cycled(predamage_life_cycles=life, predamage_range_kN=30.0)
    with pytest.raises(InputError, match="different kinds of damage"):
        damaged_rows(table, "strength")
    rows = damaged_rows(table, "strength", measure="S-N life fraction")
    assert rows["specimen"].tolist() == ["c", "d"]


def test_a_fit_says_what_speaks_against_the_measure() -> None:
    fit = fit_residual(cycled(predamage_range_kN=30.0, predamage_peak_kN=[60, 60, 80, 90]))
    assert fit.measure == "S-N life fraction"
    texts = [str(finding) for finding in fit.findings]
    assert any("characteristic life of EN 1994-1-1" in text for text in texts)
    assert any("2 of 4 tests were cycled above 0.75" in text for text in texts)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"predamage_cycles": ""}, "predamage_level.*or predamage_cycles with"),
        ({"predamage_range_kN": 90, "predamage_peak_kN": 40}, "more than from -40 to 40 kN"),
        ({"predamage_level": 0.5, "predamage_measure": "life fraction",
          "predamage_life_cycles": 1e6}, "is not predamage_cycles over predamage_life_cycles"),
        ({"predamage_level": 1.2, "predamage_measure": "section loss"}, "is no section loss"),
        ({"predamage_level": 40, "predamage_measure": "other"}, "40 % is 0.4"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(columns: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        cycled(**columns)


def beyond(most: float, campaigns: int = 3) -> pd.DataFrame:
    """Studs driven to `most` times the slip at their largest load; nothing is lost up to 0.4."""
    generator, rows = np.random.default_rng(4), []
    for lab in range(campaigns):
        for k, level in enumerate(np.linspace(0.1, most, 9)):
            left = 1.0 - 0.5 * max(level - 0.4, 0.0) + 0.01 * generator.normal()
            rows.append((f"lab {lab}", f"s{k}", 100.0 * left, level))
    frame = pd.DataFrame(rows, columns=["campaign", "specimen", "shear_kN", "predamage_level"])
    values = {"test": "push-out", "diameter_mm": 19.0, "undamaged_shear_kN": 100.0,
            "predamage": "push-out", "predamage_measure": "displacement ratio"}  # fmt: skip
    return from_frame(frame.assign(**values), TESTS)


@pytest.mark.thorough
def test_a_threshold_is_found_and_levels_beyond_one_are_fitted() -> None:
    fit = fit_residual(beyond(1.5))
    assert fit.relation.name == "threshold"
    assert fit.parameters["t"] == pytest.approx(0.4, abs=0.03)
    assert fit.averaged[0].weight > 0.9
    curve = fit.tables(0.9)["curve"]
    assert curve["level"].iloc[-1] == pytest.approx(1.5)
    assert not curve["extrapolated"].any()
    at = np.array([0.3, 1.4])
    assert fit.left(at) == pytest.approx([1.0, 0.5], abs=0.02)
    low, high = fit.band(at)
    assert np.all((low < [1.0, 0.5]) & (high > [1.0, 0.5]))
    assert "damage up to 1.5" in fit.holds


@pytest.mark.thorough
def test_a_threshold_is_no_free_lunch() -> None:
    """Where the loss begins at once the linear relation keeps weight and median and band agree."""
    rows = beyond(1.0)
    left = 100.0 * (1.0 - 0.5 * rows["predamage_level"])
    noise = np.random.default_rng(2).normal(size=len(rows))
    fit = fit_residual(rows.assign(shear_kN=left + noise))
    assert {each.relation.name for each in fit.averaged} > {"linear"}
    assert fit.left(np.array([0.1, 0.5])) == pytest.approx([0.95, 0.75], abs=0.02)


LONE = """campaign,specimen,test,diameter_mm,height_mm,fcm_MPa,fu_MPa,shear_kN,predamage,\
predamage_measure,predamage_level
lab,u1,push-out,19,100,30,450,110,none,,
lab,u2,push-out,19,100,30,450,114,none,,
lab,u3,push-out,19,100,30,450,112,none,,
lab,d1,push-out,16,90,30,450,78,pull-out,load ratio,0.3
lab,d2,push-out,22,110,30,450,135,pull-out,load ratio,0.6
lab,d3,push-out,25,120,30,450,140,pull-out,load ratio,0.9
"""


def test_single_damaged_designs_may_be_held_against_a_formula(tmp_path: Path) -> None:
    file = tmp_path / "lone.csv"
    file.write_text(LONE)
    table = examine(file, TESTS).accept()
    assert damaged_rows(table, "strength").empty  # each of its own diameter
    filled = predicted_references(table)
    rows = damaged_rows(filled, "strength")
    assert rows["specimen"].tolist() == ["d1", "d2", "d3"]
    assert set(rows["undamaged_basis"]) == {"predicted"}
    # the mean form of EN 1994-1-1 (concrete governs), scaled to the undamaged tests
    expected = 112.0 * (np.array([16.0, 22.0, 25.0]) / 19.0) ** 2
    assert rows["undamaged_shear_kN"].to_numpy() == pytest.approx(expected, rel=1e-9)
    fit = fit_residual(filled)
    assert fit.grade is Grade.PREDICTED
    assert any("3 of 3 tests are compared with a predicted" in str(f) for f in fit.findings)
    with pytest.raises(InputError, match="must be 3 or more to predict references"):
        predicted_references(table[table["specimen"] != "u1"])


def test_tests_of_one_quantity_are_fitted_without_the_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "strength.csv"
    cycled(predamage_life_cycles=1e6).to_csv(file, index=False)
    assert run(["fit", "residual", str(file), "--no-mechanical"]) == 0
    text = capsys.readouterr().out
    assert "4 tests after pre-damage" in text
    assert "not fitted: stiffness: table = '4 rows': holds no test after pre-damage" in text
    mixed = cycled(predamage_life_cycles=[1e6, 1e6, np.nan, np.nan], predamage_range_kN=30.0)
    mixed.to_csv(file, index=False)
    assert run(["fit", "residual", str(file), "--no-mechanical"]) == 2
    assert "different kinds of damage" in capsys.readouterr().err


def test_tests_left_out_for_want_of_a_companion_are_named() -> None:
    lone = cycled(undamaged_shear_kN=[100, 100, 100, np.nan], predamage_life_cycles=1e6)
    fit = fit_residual(lone)
    assert len(fit.rows) == 3
    assert any("1 damaged tests left out" in str(finding) for finding in fit.findings)


def test_a_load_range_of_the_whole_specimen_is_refused(tmp_path: Path, capsys: Capture) -> None:
    """Eight studs: no stud is weaker than half the range that it has borne."""
    file = tmp_path / "lab.csv"
    cycled(predamage_range_kN=30.0).assign(predamage_range_kN=480.0).to_csv(file, index=False)
    arguments = ["fit", "residual", str(file), "--no-mechanical", "--quantity", "strength"]
    assert run(arguments) == 2
    error = capsys.readouterr().err
    assert "lab.csv, line 2, column shear_kN" in error
    assert "its cycles have reached 240 kN: is one of them of the whole specimen?" in error
    with pytest.raises(InputError, match="must be at most 10"):  # 1e6 lives by the S-N line
        fit_residual(cycled(predamage_range_kN=175.0))
    long = cycled(predamage_life_cycles=1e4)
    with pytest.raises(InputError, match="must be at most 3"):
        fit_residual(long)
