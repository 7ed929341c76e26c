"""`workbench new`: templates that the fits accept once they are filled."""

from __future__ import annotations

import json
import runpy
import tomllib
from pathlib import Path

import pytest

from workbench.cli import run
from workbench.scenarios import Pulse
from workbench.studs.schema import TEMPLATES


@pytest.mark.thorough
@pytest.mark.parametrize("kind", TEMPLATES)
def test_a_filled_template_is_fitted(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["new", "studs", "--kind", kind]) == 0
    text = capsys.readouterr().out
    statements = TEMPLATES[kind]
    file = tmp_path / "table.csv"
    printed = (
        statements.verb.removesuffix(" --report FILE.html").replace("FILE.csv", str(file)).split()
    )
    file.write_text(text)
    assert run(printed) == 2  # not filled
    assert "must hold one row or more" in capsys.readouterr().err
    example = [line[1:].strip() for line in text.splitlines() if line.startswith("#     our lab")]
    assert example == list(statements.rows)
    assert run(["new", "studs", "--kind", kind, "--example"]) == 0
    assert capsys.readouterr().out == text + "\n".join(example) + "\n"
    file.write_text(text + "\n".join(example) + "\n")
    assert run(["data", "check", str(file)]) == 0
    assert "0 problems." in capsys.readouterr().out
    one = ["--quantity", "strength"] if "residual" in printed else []
    assert run([*printed, *one, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["rows_left_out"] == []
    for name in (*statements.columns, *statements.more):
        statements.schema.column(name)  # every one exists


def test_a_template_for_something_else_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new", "studs", "--kind", "welds"]) == 2
    assert "--kind = 'welds': must be one of strength" in capsys.readouterr().err
    assert run(["new", "studs", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["template"].endswith("slip_at_max_mm\n")


def test_uncertain_inputs_start_from_a_template(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["new", "uncertain"]) == 0
    file = tmp_path / "uncertain.toml"
    file.write_text(capsys.readouterr().out)
    assert run(["sample", str(file), "--samples", "20", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outcomes"] == {"ok": 20}


def test_a_vehicle_is_printed_as_a_striker(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new", "striker", "urban", "--distance", "3"]) == 0
    text = capsys.readouterr().out
    assert "not verified in print" in text
    striker = tomllib.loads(text)["striker"]
    assert striker["mass"] == 30_000.0
    assert striker["velocity"] == pytest.approx((13.8889**2 - 6.0 * 3.0 / 0.173648) ** 0.5, 1e-5)
    assert run(["new", "striker", "urban", "--distance", "6"]) == 2
    assert "distance = 6.0: must be below 5.583 m" in capsys.readouterr().err


def test_a_missile_is_printed_as_a_pulse(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    file = tmp_path / "missile.csv"
    file.write_text("station_m,mass_kg_per_m,crushing_force_N\n0,100,1e5\n10,300,5e5\n")
    assert run(["new", "missile", str(file), "--velocity", "50"]) == 0
    table = tomllib.loads(capsys.readouterr().out)["pulse"]
    assert table.pop("load") == "point"
    assert Pulse(**table).whole == pytest.approx(2000.0 * 50.0, rel=1e-9)
    assert run(["new", "missile", str(tmp_path / "none.csv"), "--velocity", "50"]) == 2
    assert "missile = " in capsys.readouterr().err
    assert run(["new", "missile", str(file), "--velocity", "0"]) == 2
    assert "velocity = 0.0: must be a number from 0.001" in capsys.readouterr().err


def test_the_ground_near_a_fault_is_printed_as_a_motion(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new", "near-fault", "--amplitude", "1.0", "--frequency", "0.5"]) == 0
    ground = tomllib.loads(capsys.readouterr().out)["ground"]
    assert len(ground["acceleration"]) == 401
    assert ground["time_step"] == pytest.approx(0.01)
    assert run(["new", "near-fault", "--amplitude", "1.0", "--frequency", "0"]) == 2
    assert "frequency = 0.0: must be a number from 0.01" in capsys.readouterr().err


STARTS = {"column": "four-dof", "frame": "rigid-superelement", "pulse": "biggs"}


@pytest.mark.thorough
@pytest.mark.parametrize("kind", STARTS)
def test_a_scenario_to_start_from_runs(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["new", kind]) == 0
    file, picture = tmp_path / f"{kind}.toml", tmp_path / "answer.svg"
    file.write_text(capsys.readouterr().out, encoding="utf-8")
    command = ["simulate", str(file), "--model", STARTS[kind], "--plot", str(picture)]
    assert run(command) == 0
    text = capsys.readouterr().out
    assert f"survives; by {STARTS[kind]}, as asked" in text
    assert "<svg" in picture.read_text(encoding="utf-8")


def test_a_study_to_start_from_can_be_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from workbench.study import cells_of, load_study

    assert run(["new", "study"]) == 0
    file = tmp_path / "mine.py"
    file.write_text(capsys.readouterr().out, encoding="utf-8")
    assert len(cells_of(load_study(str(file)).study)) == 9


def test_a_model_to_start_from_keeps_the_contract(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["new", "model"]) == 0
    file = tmp_path / "my_model.py"
    file.write_text(capsys.readouterr().out, encoding="utf-8")
    runpy.run_path(str(file), run_name="__main__")
    assert "my-spring" in capsys.readouterr().out
