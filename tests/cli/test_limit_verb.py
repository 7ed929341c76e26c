"""`workbench limit` on the command line."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from workbench.cli import run
from workbench.scenarios import ColumnImpact, load_scenario, to_toml
from workbench.study.error_model.error_model import choose


@pytest.fixture
def car(parked: ColumnImpact, tmp_path: Path) -> str:
    path = tmp_path / "car.toml"
    path.write_text(to_toml(parked))
    return str(path)


def test_limits_of_two_models(car: str, capsys: pytest.CaptureFixture[str]) -> None:
    models = ["--model", "four-dof", "--model", "energy-estimate"]
    arguments = ["limit", car, "--over", "striker.velocity", *models]
    assert run([*arguments, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["over"], answer["range"]) == ("striker.velocity", [1.0, 60.0])
    bars, energy = answer["limits"]
    assert (bars["model"], energy["model"]) == ("four-dof", "energy-estimate")
    assert bars["collapses_at"] == pytest.approx(energy["collapses_at"], rel=0.02)
    values = [trial["value"] for trial in bars["trials"]]
    assert values == sorted(values)
    fallen = [trial for trial in bars["trials"] if trial["survives"] is False]
    assert fallen[0]["collapse"]["mechanism"] == "geometry"
    assert run(arguments) == 0
    text = capsys.readouterr().out
    assert bars["collapses_at"] == pytest.approx(9.527, rel=2e-3)  # steps of 20 microseconds
    value = f"{bars['collapses_at']:g}"
    for words in ("survives at", "collapses at", value, "geometry (below) at 0.54"):
        assert words in text


def test_the_limit_warns_as_a_run_there_does(car: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["limit", car, "--model", "four-dof", "--json"]) == 0
    (answer,) = json.loads(capsys.readouterr().out)["limits"]
    value = f"striker.velocity={answer['survives_at']!r}"
    run(
        [
            "simulate",
            car,
            "--model",
            "four-dof",
            "--set",
            value,
            "--set",
            "time.duration=0.4",
            "--json",
        ]
    )
    there = json.loads(capsys.readouterr().out)["warnings"]
    findings = {w["subject"] for w in answer["warnings"]}
    assert {w["subject"] for w in there} <= {*findings, "close-to-collapse", "off-web"}
    assert "error-not-measured" in findings  # webs slide further than the reference follows
    assert "warnings" not in answer["trials"][0]
    assert run(["limit", car, "--model", "four-dof"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    for warning in answer["warnings"]:
        assert f"warning of four-dof there ({warning['subject']})" in text


def test_the_model_by_default_is_that_of_the_remedies(
    car: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["limit", car, "--tolerance", "0.2", "--json"]) == 0
    (answer,) = json.loads(capsys.readouterr().out)["limits"]
    assert answer["model"] == choose(load_scenario(car)).model != "four-dof"
    findings = {w["subject"] for w in answer["warnings"]}
    assert not findings & {"shear", "measured"}


@pytest.mark.thorough
def test_other_keys_need_a_range(car: str, capsys: pytest.CaptureFixture[str]) -> None:
    heavy = ["limit", car, "--over", "striker.mass", "--from", "100", "--to", "4000"]
    assert run([*heavy, "--set", "striker.velocity=8", "--tolerance", "0.05"]) == 0
    assert "turns from survival to collapse" in capsys.readouterr().out
    assert run([*heavy[:-1], "200"]) == 0
    assert "no collapse up to 200 kg" in capsys.readouterr().out


def test_numbers_are_read_and_written_with_their_unit(
    car: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file may say km/h: a bare number beside it would be read as that."""
    ends = ["--from", "18 km/h", "--to", "10.8", "--tolerance", "0.5"]
    assert run(["limit", car, "--model", "energy-estimate", *ends, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert (content["range"], content["unit"]) == ([5.0, 10.8], "m/s")
    assert run(["limit", car, "--model", "energy-estimate", *ends]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "limit of striker.velocity in m/s" in text
    assert "5 m/s (18 km/h)" in text


def test_what_stays_open_is_status_1(car: str, capsys: pytest.CaptureFixture[str]) -> None:
    heavy = ["--set", "column.axial_load=2e6", "--set", "column.length_above=12"]
    assert run(["limit", car, *heavy]) == 1
    text = " ".join(capsys.readouterr().out.split())
    assert "no collapse found; not known at 1, 8.375" in text
    assert "Euler load" in text
    both = ["--model", "energy-estimate", "--model", "measured", "--from", "2", "--to", "4"]
    assert run(["limit", car, *both]) == 1  # one says where, of the other nothing is known
    text = " ".join(capsys.readouterr().out.split())
    assert "no collapse up to 4" in text
    assert "no test of this scenario" in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--over", "striker.speed", "--from", "1", "--to", "2"], "striker.speed: unknown key"),
        (["--over", "striker.mass"], "--from, --to: must both be given for striker.mass"),
        (["--over", "name", "--from", "1", "--to", "2"], "name = 1.0"),
        (["--over", "striker.velocity=5"], "must be a key with a number"),
        (["--over", "time.duration"], "must be a key with a number"),
        (["--from", "-1"], "striker.velocity = -1.0: must be a number from 1e-06"),
        (["--to", "1"], "--to = 1.0: must be another value than --from"),
        (["--from", "18 kg"], "striker.velocity = '18 kg': must be a number from 1e-06"),
        (["--over", "name", "--from", "a", "--to", "b"], "name = 'a': must be a number"),
        (["--tolerance", "2"], "--tolerance = 2.0: must be a number"),
        (["--model", "four-dofs"], "did you mean four-dof?"),
        (["--option", "gamma=1"], "option.gamma: unknown key"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    arguments: list[str], message: str, car: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["limit", car, *arguments]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert (captured.out, captured.err.count("\n")) == ("", 1)


@pytest.mark.thorough
def test_advice_names_the_model_before_anything_is_run(
    car: str, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = ["--set", "striker.velocity=4"]
    assert run(["advise", car, *slow, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["model"] == choose(load_scenario(car, slow[1:])).model
    error = content["error"]
    assert error["anchor"] == "flexible-superelement"
    assert error["low"] < error["expected"] < error["high"]
    assert "shear" in {finding["subject"] for finding in content["findings"]["four-dof"]}
    assert all(finding["remedy"] for finding in content["findings"]["four-dof"])
    assert run(["simulate", car, *slow, "--json"]) == 0  # without a model: that of the advice
    answer = json.loads(capsys.readouterr().out)
    assert answer["model"] == content["model"]
    assert answer["error"] == error
    peak = answer["peak_displacement"]
    assert content["peak_displacement"] == pytest.approx(peak / (1.0 + error["expected"]))
    for verb in ("advise", "simulate"):
        assert run([verb, car, *slow]) == 0
        text = " ".join(capsys.readouterr().out.split())
        assert re.search(r"expect [+-]\d+ %, 90 %: [+-]\d+ to [+-]\d+ %", text)
    assert run(["advise", car, *slow]) == 0
    text = capsys.readouterr().out
    assert f"take {content['model']}, the anchor" in text
    assert "outside its domain" in text
