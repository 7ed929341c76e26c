"""Absurd tables: found by `data check`, refused or flagged by the fits, the suspicion named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.cli import run
from workbench.extras.intake.kinds import check_file
from workbench.studs import POINTS, TESTS, fit_load_slip, fit_residual, fit_strength, shipped
from workbench.studs.damaged import damaged_rows
from workbench.studs.plausibility import suspicions
from workbench.studs.schema import from_frame

Maker = Callable[..., pd.DataFrame]


def push_outs(**changes: object) -> pd.DataFrame:
    """Six good push-outs of a 19 mm stud, with some columns changed."""
    loads = [101.3, 108.4, 97.2, 104.9, 110.6, 99.8]
    values = {"campaign": "our lab", "specimen": [f"s{i}" for i in range(6)], "test": "push-out",
            "diameter_mm": 19.0, "height_mm": 100.0, "fcm_MPa": 31.0, "fu_MPa": 470.0,
            "shear_kN": loads, "slip_at_max_mm": [6.1, 7.2, 6.6, 5.9, 7.0, 6.8]}  # fmt: skip
    frame = pd.DataFrame(values)
    return frame.assign(**{k: v(frame) if callable(v) else v for k, v in changes.items()})


DAMAGED = {"predamage": "fatigue", "predamage_measure": "life fraction",
           "predamage_level": [0.1, 0.3, 0.5, 0.6, 0.8, 0.9]}  # fmt: skip
ABSURD: dict[str, tuple[pd.DataFrame, str]] = {
    "good": (push_outs(), ""),
    "kip": (push_outs(shear_kN=lambda t: t["shear_kN"] / 4.448), "kip instead of kN?"),
    "tonnes": (push_outs(shear_kN=lambda t: t["shear_kN"] / 9.807), "tonnes instead of kN?"),
    "loads of two studs": (
        push_outs(shear_kN=lambda t: 1.9 * t["shear_kN"], fu_MPa=np.nan, fcm_MPa=31.0),
        "",  # without the strength of the stud nothing tells
    ),
    "one load of two studs": (
        push_outs(shear_kN=[101.3, 108.4, 97.2, 104.9, 110.6, 1.86 * 470 * 283.53e-3]),
        "shear of our lab s5 is up to 1.86 times the tensile strength of the shank: the load of "
        "two studs entered as one?",
    ),
    "all loads of two studs": (
        push_outs(shear_kN=lambda t: 2.0 * t["shear_kN"]), "loads of two studs, or of the specimen",
    ),
    "a slip of the pen": (
        push_outs(shear_kN=[101.3, 108.4, 97.2, 104.9, 110.6, 19.98]), "outlier: our lab s5, ",
    ),
    "a slip of the pen among companions": (
        push_outs(fcm_MPa=np.nan, fu_MPa=np.nan,
                  shear_kN=[101.3, 108.4, 97.2, 104.9, 110.6, 199.8]),
        "outlier: our lab s5, 200 where the others give 104",
    ),
    "remaining life": (
        push_outs(**DAMAGED, undamaged_shear_kN=160.0,
                  shear_kN=[64.0, 71.0, 96.0, 101.0, 129.0, 143.0]),
        "strength left after fatigue rises with the damage (life fraction) in 6 tests: is the life "
        "that remains given instead of the damage?",
    ),
    "damage": (
        push_outs(**DAMAGED, undamaged_shear_kN=160.0,
                  shear_kN=[143.0, 129.0, 101.0, 96.0, 71.0, 64.0]), "",
    ),
    "no loss": (
        push_outs(**DAMAGED, undamaged_shear_kN=104.0,
                  shear_kN=[103.0, 106.0, 101.0, 105.0, 108.0, 104.0]), "",
    ),
    "loads of the specimen": (
        push_outs(shear_kN=lambda t: 4.0 * t["shear_kN"]),
        "times the tensile strength of the shank; loads are per stud",
    ),
    "slips in metres": (
        push_outs(slip_at_max_mm=lambda t: 1e-3 * t["slip_at_max_mm"]), "is it in metres?",
    ),
    "slips in inches": (
        push_outs(slip_at_max_mm=lambda t: t["slip_at_max_mm"] / 25.4), "are short: inches?",
    ),
    "one strength twice": (push_outs(fcm_MPa=240.0, fu_MPa=240.0), "equals fu_MPa"),
    "ratios of 8": (
        push_outs(**DAMAGED, undamaged_shear_kN=lambda t: t["shear_kN"] / 8.0),
        "is 8 times undamaged_shear_kN",
    ),
    "swapped references": (
        push_outs(**DAMAGED, undamaged_shear_kN=lambda t: t["shear_kN"] / 1.4),
        "1.40 times the shear_kN of undamaged ones (median of 6): columns swapped",
    ),
    "copied column": (
        push_outs(**DAMAGED, undamaged_shear_kN=lambda t: t["shear_kN"]),
        "shear_kN equals undamaged_shear_kN in all 6 damaged rows: one column copied?",
    ),
    "one test under two names": (
        push_outs(shear_kN=[101.3, 108.4, 97.2, 104.9, 110.6, 101.3], slip_at_max_mm=6.1),
        "our lab s0 and our lab s5 hold the same numbers: one test under two names?",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ABSURD)
def test_data_check_names_the_suspicion(name: str, tmp_path: Path) -> None:
    table, words = ABSURD[name]
    file = tmp_path / "lab.csv"
    table.to_csv(file, index=False)
    problems, doubts, _ = check_file(file)
    if not words:
        assert problems == doubts == []
    else:
        assert any(words in text for text in (*problems, *doubts)), (problems, doubts)


@pytest.mark.parametrize(
    "name", ["kip", "slips in inches", "one test under two names", "one load of two studs"]
)
def test_fits_of_strength_warn(name: str) -> None:
    table, text = ABSURD[name]
    fit = fit_strength(from_frame(table, TESTS), "roik-mean")
    assert text in fit.findings[0].text
    assert fit.findings[0].subject == "data"


@pytest.mark.parametrize("name", ["swapped references", "copied column", "remaining life"])
def test_fits_of_what_is_left_warn(name: str) -> None:
    table, text = ABSURD[name]
    assert text in fit_residual(from_frame(table, TESTS)).findings[0].text


def test_the_command_line_tells_problems_from_suspicions(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "lab.csv"
    ABSURD["kip"][0].to_csv(file, index=False)
    assert run(["data", "check", str(file)]) == 0
    text = capsys.readouterr().out
    assert "suspicion: loads of our lab are 0.19" in text
    assert "0 problems, 1 suspicions." in text
    ABSURD["ratios of 8"][0].to_csv(file, index=False)
    assert run(["data", "check", str(file)]) == 1
    assert run(["fit", "residual", str(file)]) == 2
    assert "columns swapped" in capsys.readouterr().err


def test_curves_in_metres_are_flagged() -> None:
    rows = [
        {
            "campaign": "lab",
            "specimen": f"s{i}",
            "slip_mm": 1e-3 * s,
            "load_kN": 100.0 * s / (s + 1),
        }
        for i in range(2)
        for s in (0.5, 1.0, 2.0, 4.0 + i)
    ]
    fit = fit_load_slip(from_frame(pd.DataFrame(rows), POINTS))
    assert "slips of lab, 0.0045 mm at the most, are short: metres?" in fit.findings[0].text


def test_a_companion_is_a_test_for_fits_in_like_concrete() -> None:
    """Undamaged companions that must not be used, or stand in other concrete, are no reference."""
    rows = push_outs(
        predamage=["none"] * 5 + ["fatigue"],
        predamage_measure=[""] * 5 + ["life fraction"],
        predamage_level=[np.nan] * 5 + [0.5],
        shear_kN=[100.0, 104.0, 150.0, 60.0, 102.0, 80.0],
        use_for_fit=[1, 1, 0, 1, 1, 1],
        fcm_MPa=[31.0, 32.0, 31.0, 20.0, 30.0, 31.0],
    )
    (result,) = damaged_rows(from_frame(rows, TESTS), "strength")["ratio"]
    assert result == pytest.approx(80.0 / 102.0)
    absurd = from_frame(rows.assign(shear_kN=[10.0, 10.4, 15.0, 6.0, 10.2, 80.0]), TESTS)
    with pytest.raises(ValueError, match=r"our lab s5 = '7\.84 times the undamaged tests'"):
        damaged_rows(absurd, "strength")


@pytest.mark.thorough
def test_outliers_are_named_and_may_weigh_less(damaged: Maker) -> None:
    table = damaged(4, 6, origin="measured")
    table.loc[3, "shear_kN"] = 140.0
    fit = fit_residual(table)
    (finding,) = [each for each in fit.findings if each.subject == "outlier"]
    assert "outlier: lab 0 s3, 1.4 where the others give" in finding.text
    clean = fit_residual(table.drop(index=3)).left([0.8])[0]
    robust = fit_residual(table, loss="bisquare").left([0.8])[0]
    assert abs(robust - clean) < 0.5 * abs(fit.left([0.8])[0] - clean)


def test_an_outlier_is_told_once() -> None:
    table = from_frame(ABSURD["a slip of the pen"][0], TESTS)
    findings = [
        each for each in fit_strength(table, "aisc360").findings if each.subject == "outlier"
    ]
    assert len(findings) == 1


def test_shipped_tables_look_right() -> None:
    assert suspicions(shipped("stud-push-out")) == []
