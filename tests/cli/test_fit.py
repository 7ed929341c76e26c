"""`workbench fit`: what a laboratory gets from its own tables and from the shipped ones."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.studs import SHEAR_MODELS, read_tests
from workbench.studs.fit_protocol import plain
from workbench.studs.laboratory import fit_question
from workbench.studs.questions import StrengthQuestion

HEADER = "campaign,specimen,test,diameter_mm,height_mm,slab,fcm_MPa,fu_MPa,shear_kN"


def laboratory(path: Path, campaigns: int = 4, tests: int = 6, bias: float = 1.1) -> Path:
    """A table of a laboratory: studs of three sizes around the mean form of EN 1994-1-1."""
    generator = np.random.default_rng(5)
    lines = [HEADER]
    for j in range(campaigns):
        effect = 0.05 * generator.normal()
        for i in range(tests):
            d, fc = generator.choice([16.0, 19.0, 22.0]), round(generator.uniform(25, 45), 1)
            load = 0.374 * d**2 * np.sqrt(fc * 4733 * np.sqrt(fc)) / 1e3
            load = min(load, 470 * np.pi * d**2 / 4e3)
            load *= bias * np.exp(effect + 0.04 * generator.normal())
            lines.append(f"lab {j},s{i},push-out,{d},120,solid,{fc},470,{load:.2f}")
    path.write_text("\n".join(lines) + "\n")
    return path


def equal_tests(path: Path, campaign: str = "our lab") -> Path:
    """Three nominally equal push-outs."""
    loads = {"A1": 100, "A2": 105, "A3": 95}
    rows = [f"{campaign},{name},push-out,19,100,solid,31.2,472,{p}" for name, p in loads.items()]
    path.write_text("\n".join([HEADER, *rows]) + "\n")
    return path


def damaged(path: Path, kind: str, measure: str, origin: str = "synthetic", labs: int = 4) -> Path:
    """Tests after pre-damage that lose half of their strength in proportion to it."""
    generator = np.random.default_rng(3)
    lines = [
        "campaign,specimen,test,origin,diameter_mm,shear_kN,undamaged_shear_kN,predamage,"
        "predamage_measure,predamage_level"
    ]
    for j in range(labs):
        effect = 2.0 * generator.normal()
        for i in range(6):
            level = 0.15 * i + 0.1
            left = 100.0 * (1.0 - 0.5 * level) + effect + generator.normal()
            lines.append(
                f"lab {j},d{i},push-out,{origin},19,{left:.2f},100,{kind},{measure},{level}"
            )
    path.write_text("\n".join(lines) + "\n")
    return path


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert run(["fit", *arguments, "--json"]) == 0
    result: dict[str, Any] = json.loads(capsys.readouterr().out)
    return result


def table(text: dict[str, Any], name: str, of: str = "") -> list[dict[str, Any]]:
    """Rows of a table of an answer, those of one fit where it is named."""
    return [row for row in text["results"][name] if not of or row["of"] == of]


# -- strength -------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_shipped_tests_without_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    result = answer(capsys, "stud-strength")
    assert result["tables"] == ["shipped"]
    fits = {fit["model"]: fit for fit in table(result, "fit")}
    assert set(fits) == set(SHEAR_MODELS)
    assert fits["en1994"]["bias"] == pytest.approx(1.496, abs=0.001)
    (d8,) = table(result, "d8", SHEAR_MODELS["roik-mean"].label)
    assert d8["gamma_m_star"] == pytest.approx(1.06, abs=0.01)
    assert all("P_Rk" not in each and each["refusal"] for each in table(result, "series"))
    assert run(["fit", "stud-strength"]) == 0
    text = capsys.readouterr().out
    assert "26 tests of lehigh279, provines2019 (shipped tables)" in text
    assert "24 of 26 tests exceed the tensile strength of their shank" in text
    assert "none of the 14 groups of nominally equal tests has three" in text
    assert "(the largest has 2)" in text


def test_a_laboratory_brings_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = laboratory(tmp_path / "lab.csv")
    result = answer(capsys, "stud-strength", str(file), "--model", "roik-mean",
                   "--trend", "diameter", "--validate", "lab 3")  # fmt: skip
    (fit,) = table(result, "fit")
    assert fit["campaigns"] == "lab 0, lab 1, lab 2"
    assert fit["bias"] == pytest.approx(1.1, abs=0.1)
    assert fit["new_campaign_factor"] < 1.05
    plain, corrected = table(result, "judgement")
    assert plain["tests"] == 6
    assert corrected["test_over_prediction"] == pytest.approx(1.0, abs=0.12)
    arguments = ["fit", "stud-strength", str(file), "--model", "roik-mean", "--factor", "concrete"]
    assert run([*arguments, "--validate", "lab 3", "--trend", "diameter"]) == 0
    text = capsys.readouterr().out
    for part in ("Unseen tests of lab 3", "Fitted factors", "Exponents that the formulas miss"):
        assert part in text


def test_a_series_is_evaluated_by_annex_b(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = equal_tests(tmp_path / "series.csv")
    points = tmp_path / "points.csv"
    lines = ["campaign,specimen,slip_mm,load_kN"]
    for name, top, end in (("A1", 100, 60), ("A2", 105, 65), ("A3", 95, 75)):
        lines += [f"our lab,{name},0,0", f"our lab,{name},4,{top}", f"our lab,{name},12,{end}"]
    points.write_text("\n".join(lines) + "\n")
    result = answer(capsys, "stud-strength", str(file), "--points", str(points))
    (series,) = table(result, "series")
    assert series["P_Rk"] == pytest.approx(85.5e3)
    assert series["P_Rd"] == pytest.approx(450 / 472 * 85.5e3 / 1.25)
    assert series["slip_capacity"] == pytest.approx(6.21e-3)
    assert series["ductile"] == "ductile"
    assert run(["fit", "stud-strength", str(file)]) == 0
    text = capsys.readouterr().out
    assert "3 tests: EN 1990 has no factor of the design value for fewer than 4" in text


def test_own_and_shipped_tests_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = equal_tests(tmp_path / "series.csv")
    result = answer(capsys, "stud-strength", str(file), "--with-shipped", "--model", "roik-mean",
                   "--calibrate", "provines2019", "--validate", "our lab")  # fmt: skip
    assert [fit["campaigns"] for fit in table(result, "fit")] == ["provines2019"]
    assert {row["campaigns"] for row in table(result, "judgement")} == {"our lab"}


def test_validation_on_calibration_rows_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["fit", "stud-strength", "--calibrate", "lehigh279", "--validate", "lehigh279"]
    assert run(arguments) == 2
    assert "a fit is not validated by its own rows" in capsys.readouterr().err
    # the same rows under another name
    from workbench.studs import shipped

    table = shipped("stud-push-out")
    columns = ["campaign", "specimen", "test", "diameter_mm", "height_mm", "fcm_MPa", "fu_MPa",
               "shear_kN", "slip_at_max_mm"]  # fmt: skip
    copied = table[table["campaign"] == "provines2019"][columns].assign(campaign="our lab")
    file = tmp_path / "copied.csv"
    copied.to_csv(file, index=False)
    arguments = ["fit", "stud-strength", str(file), "--with-shipped"]
    assert run([*arguments, "--calibrate", "provines2019", "--validate", "our lab"]) == 2
    assert "equals a row of the fit under other names" in capsys.readouterr().err


def test_bad_rows_may_be_left_out_and_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = laboratory(tmp_path / "lab.csv")
    file.write_text(file.read_text() + "lab 0,bad,push-out,19,100,solid,30,450,-5\n")
    assert run(["fit", "stud-strength", str(file)]) == 2
    capsys.readouterr()
    result = answer(capsys, "stud-strength", str(file), "--keep-good", "--model", "ollgaard")
    (left_out,) = result["rows_left_out"]
    assert "lab.csv, line 26, column shear_kN = -5.0" in left_out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stud-strength", "--model", "en1995"], "must be one of en1994, roik-mean"),
        (["stud-strength", "--trend", "colour"], "must be one of diameter"),
        (["stud-strength", "--factor", "weld", "--model", "en1994"], "one of steel, concrete"),
        (["stud-strength", "--loss", "cubic"], "must be one of linear, huber, bisquare"),
        (["stud-strength", "--confidence", "90"], "--confidence = 90.0: must be a number from 0.5"),
        (["stud-strength", "--validate", "lehigh"], "did you mean lehigh279?"),
        (["stud-strength", "--variation", "colour=0.1"], "must name one of diameter"),
        (["stud-strength", "--variation", "diameter"], "must look like concrete_strength=0.15"),
        (["load-slip", "--law", "cubic"], "must be one of ollgaard, bilinear, rational"),
        (["residual", "--quantity", "colour"], "must be one of strength, stiffness, both"),
        (["residual", "--no-mechanical"], "holds no test after pre-damage"),
        (["residual", "--predamage", "fatigue"], "holds no test after pre-damage fatigue"),
        (["stud-colour"], "No such command 'stud-colour'"),
    ],
)
def test_bad_options_are_one_line_and_status_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["fit", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert message in captured.err


def test_an_option_is_one_declaration(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By its flag, by ``--set`` and from Python: the same answer, and the same refusal."""
    file = laboratory(tmp_path / "lab.csv")
    flags = ["--model", "roik-mean", "--loss", "huber", "--specified-fu", "500"]
    first = answer(capsys, "stud-strength", str(file), *flags)
    pairs = ["--set", "model=roik-mean", "--set", "loss=huber", "--set", "specified=500"]
    assert answer(capsys, "stud-strength", str(file), *pairs) == first
    assert first["options"] == {"model": ["roik-mean"], "loss": "huber", "specified": 500.0}
    question = StrengthQuestion(model=("roik-mean",), loss="huber", specified=500.0)
    assert plain(fit_question(question, read_tests(file))) == first["results"]
    with pytest.raises(InputError, match="loss = 'cubic': must be one of linear, huber, bisquare"):
        StrengthQuestion(loss="cubic")
    assert run(["fit", "stud-strength", "--set", "los=huber"]) == 2
    assert "did you mean loss?" in capsys.readouterr().err
    assert run(["fit", "residual", "--set", "mechanical=no"]) == 2
    assert "must be true or false" in capsys.readouterr().err


# -- load-slip ------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_load_slip_of_shipped_curves(capsys: pytest.CaptureFixture[str]) -> None:
    result = answer(capsys, "load-slip", "--validate", "lehigh279")
    laws = {fit["law"]: fit for fit in table(result, "fit")}
    assert set(laws) == {"ollgaard", "bilinear", "rational"}
    assert laws["ollgaard"]["curves"] == 22
    assert [row["curves"] for row in table(result, "judgement", "ollgaard")] == [2]
    grid = table(result, "grid", "ollgaard")
    assert all(row["low"] <= row["median"] <= row["high"] for row in grid)
    assert run(["fit", "load-slip", "--law", "ollgaard", "--validate", "lehigh279"]) == 0
    text = capsys.readouterr().out
    assert "Unseen curves:" in text
    assert "hardly more points than parameters" in text


# -- residual capacity ----------------------------------------------------------------------------


@pytest.mark.thorough
def test_the_grade_stands_first_until_tests_are_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No test after pre-damage, then synthetic, then measured ones: one path, other words."""
    assert run(["fit", "residual", "--quantity", "strength"]) == 0
    text = capsys.readouterr().out
    grade = "mechanical prediction, not validated by tests after pre-damage"
    assert f"GRADE: {grade}" in text
    assert "the table holds no test after pre-damage" in text
    synthetic = damaged(tmp_path / "synthetic.csv", "pull-out", "displacement ratio")
    result = answer(capsys, "residual", str(synthetic), "--quantity", "strength")
    (fit,) = table(result, "fit")
    assert fit["grade"] == "exercise on synthetic rows: shows the method, is no evidence"
    assert {score["name"] for score in table(result, "scores")} >= {"linear", "mechanical"}
    assert fit["tests"] == 24
    measured = damaged(tmp_path / "measured.csv", "fatigue", "life fraction", "measured")
    result = answer(capsys, "residual", str(measured), "--quantity", "strength",
                   "--validate", "lab 3")  # fmt: skip
    (fit,) = table(result, "fit")
    assert fit["grade"].endswith("cross-validated over campaigns")
    weights = {score["name"]: score["weight"] for score in table(result, "scores")}
    assert weights["linear"] + weights["power"] + weights["threshold"] > 0.9  # all hold the truth
    assert table(result, "parameters")[0]["value"] == pytest.approx(0.5, abs=0.05)
    assert "for damage up to 0.85 of studs 19 mm, as tested" in fit["holds"]
    curve = table(result, "curve")
    assert curve[30]["left"] == pytest.approx(1.0 - 0.5 * 0.75, abs=0.03)
    beyond = [row for row in curve if row["extrapolated"]]
    assert [row["level"] for row in beyond] == [pytest.approx(k / 40) for k in range(35, 41)]
    assert [row["low"] for row in beyond] == [None] * 6
    assert [row["tests"] for row in table(result, "judgement")] == [6]
    assert run(["fit", "residual", str(measured), "--quantity", "strength"]) == 0
    text = capsys.readouterr().out
    assert "24 tests after pre-damage" in text
    assert "root mean square of what is left out, by campaign" in text


@pytest.mark.thorough
def test_damaged_tests_without_a_reference_are_said_to_be_useless(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = damaged(tmp_path / "a.csv", "pull-out", "displacement ratio", "measured", 1)
    lines = [",".join(line.split(",")[:6] + line.split(",")[7:])
             for line in file.read_text().splitlines()]  # fmt: skip
    file.write_text("\n".join(lines) + "\n")
    assert run(["fit", "residual", str(file), "--quantity", "strength"]) == 0
    text = capsys.readouterr().out
    assert (
        "6 tests after pre-damage say nothing about the strength: give undamaged_shear_kN" in text
    )


def test_data_check_reads_every_row_of_the_tables_of_studs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from dataclasses import dataclass

    from workbench.studs import tables

    bad = laboratory(tmp_path / "lab.csv")
    bad.write_text(bad.read_text() + "lab 0,bad,push-out,19,100,solid,30,450,-5\n")

    @dataclass
    class Entry:
        path: Path

    monkeypatch.setattr(tables, "SHIPPED", {"stud-push-out": tables.SHIPPED["stud-push-out"]})
    monkeypatch.setattr(tables, "dataset", lambda name: Entry(bad))
    assert run(["data", "check"]) == 1
    text = capsys.readouterr().out
    assert "dataset stud-push-out: lab.csv, line 26, column shear_kN = -5.0" in text


def test_data_check_reads_files_of_ones_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good, bad, curve = (tmp_path / name for name in ("good.csv", "bad.csv", "curve.csv"))
    laboratory(good)
    bad.write_text(laboratory(bad).read_text() + "lab 0,bad,push-out,19,100,solid,30,450,-5\n")
    curve.write_text("campaign,specimen,slip_mm,load_kN\nlab,A,0.1,30\n")
    assert run(["data", "check", str(good), str(curve)]) == 0
    assert capsys.readouterr().out.count("0 problems.") == 2
    assert run(["data", "check", str(bad)]) == 1
    assert "bad.csv, line 26, column shear_kN = -5.0" in capsys.readouterr().out
    assert run(["data", "check", str(tmp_path / "none.csv")]) == 2
    assert "No such file" in capsys.readouterr().err


def test_the_role_of_a_row_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = laboratory(tmp_path / "lab.csv")
    lines = file.read_text().splitlines()
    roles = [
        "role",
        *("validate" if line.startswith("lab 3") else "calibrate" for line in lines[1:]),
    ]
    file.write_text("\n".join(f"{a},{b}" for a, b in zip(lines, roles, strict=True)) + "\n")
    result = answer(capsys, "stud-strength", str(file), "--model", "roik-mean")
    assert result["validate"] == ["lab 3"]
    assert [fit["campaigns"] for fit in table(result, "fit")] == ["lab 0, lab 1, lab 2"]
    assert {row["campaigns"] for row in table(result, "judgement")} == {"lab 3"}
    arguments = ["fit", "stud-strength", str(file), "--calibrate", "lab 3"]
    assert run(arguments) == 2
    assert "has no row whose role is calibrate" in capsys.readouterr().err


def test_formulas_that_the_table_cannot_feed_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = laboratory(tmp_path / "lab.csv").read_text().splitlines()
    file = tmp_path / "without_fu.csv"
    short = [",".join(line.split(",")[:7] + line.split(",")[8:]) for line in lines]
    file.write_text("\n".join(short) + "\n")
    result = answer(capsys, "stud-strength", str(file))
    assert [fit["model"] for fit in table(result, "fit")] == ["ollgaard"]
    assert {row["of"] for row in table(result, "not_fitted")} == set(SHEAR_MODELS) - {"ollgaard"}
    (refused,) = table(result, "not_fitted", "en1994")
    assert "fill diameter_mm, height_mm, fcm_MPa and fu_MPa" in refused["why"]
    assert run(["fit", "stud-strength", str(file)]) == 0
    assert "not fitted: en1994: table" in capsys.readouterr().out
    assert run(["fit", "stud-strength", str(file), "--model", "en1994"]) == 2


SOLVERS = """
import sys
from workbench.cli import run
calls = (
    ["stud-strength", "--model", "en1994"],
    ["load-slip", "--law", "bilinear"],
    ["residual", sys.argv[1], "--quantity", "strength"],
)
floors = ("workbench.mechanics.frames", "workbench.mechanics.structures", "workbench.steel.hinges")
for call in calls:
    status = run(["fit", *call])
    print(status, [name for name in sys.modules if name.startswith(floors)], file=sys.stderr)
"""


@pytest.mark.thorough
def test_a_fit_of_studs_imports_no_frame_solver(tmp_path: Path) -> None:
    """The mechanical model, which is made of them, is read where it is asked to predict alone."""
    file = damaged(tmp_path / "lab.csv", "fatigue", "life fraction", "measured")
    call = [sys.executable, "-c", SOLVERS, str(file)]
    done = subprocess.run(call, capture_output=True, text=True)
    assert [line for line in done.stderr.splitlines() if line.endswith("]")] == ["0 []"] * 3
