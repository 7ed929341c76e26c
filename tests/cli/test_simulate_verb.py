"""`workbench simulate` answers: a sentence, five rows, several models in one table, a picture."""

from __future__ import annotations

import json
import re
import time
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
import pytest

from workbench.api.accessor import time_of
from workbench.cli import run
from workbench.cli.output import at_work
from workbench.cli.simulate import timed
from workbench.models.four_dof import FourDof
from workbench.scenarios import load_scenario

COLUMN = """
kind = "column-impact"
column = { section = "HEB 220", length_below = "2 m", length_above = 2.0 }
striker = { mass = "1.5 t", velocity = "18 km/h" }
"""


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "column.toml"
    path.write_text(COLUMN)
    return str(path)


@pytest.mark.thorough
def test_without_a_model_the_advice_answers_beside_a_reference(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["simulate", file, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["model"] == "flexible-superelement"
    assert content["reference"]["model"] == "fiber-shear"
    peak, error = 1e3 * content["peak_displacement"], content["error"]
    least, most = peak / (1.0 + error["high"]), peak / (1.0 + error["low"])
    sentence = content["headline"].replace("\u00a0", " ")
    assert sentence.startswith(f"{peak:.1f} mm, 90 %: {least:.1f} to {most:.1f}; survives; by flex")
    assert sentence.endswith("the anchor of the error model")
    reference = 1e3 * content["reference"]["peak_displacement"]
    assert least < reference < most
    assert run(["simulate", file]) == 0
    lines = capsys.readouterr().out.replace("\u00a0", " ").splitlines()
    assert any("error of the largest contact force was not measured" in line for line in lines)
    assert lines[0] == f"column-impact: {sentence}"
    assert [line[:2] for line in lines[1:7]] == ["  "] * 5 + ["Er"]  # five rows, the error
    assert "by fiber-shear, a reference" in lines[2]
    assert f"ok, {reference:.4g}" in lines[2]


def test_without_a_reference_inside_its_domain_the_answer_says_why(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its webs would slide further than the reference follows, which is no clean one then."""
    far = ["--set", "striker.velocity=12", "--set", "column.length_below=0.4"]
    assert run(["simulate", file, *far, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["reference"] is None
    (note,) = (each for each in content["notes"] if each.startswith("no reference"))
    pattern = r"no reference inside its domain: fiber-shear \(.* mean shear strain of 0\.\d+, above"
    assert re.match(pattern, note)
    assert run(["advise", file, *far, "--json"]) == 0
    findings = json.loads(capsys.readouterr().out)["findings"]["fiber-shear"]
    assert "shear-strain" in {each["subject"] for each in findings}


def test_the_rate_law_stands_in_the_short_answer(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    law = ["--set", "steel.rate=S355", "--model", "four-dof"]
    assert run(["simulate", file, *law, "--json"]) == 0
    factor = json.loads(capsys.readouterr().out)["rate_factor"]
    assert factor > 1.0
    assert run(["simulate", file, *law]) == 0
    assert f"{factor:.3g} times the static one by strain rate" in capsys.readouterr().out


def test_the_headline_says_what_was_not_measured_and_what_is_expected(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    light = ["--set", "striker.mass=3", "--model", "four-dof"]
    assert run(["simulate", file, *light, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["headline"].endswith("; outside what was measured")
    low = ["--set", "column.length_below=0.8", "--set", "striker.velocity=8", "--model", "four-dof"]
    assert run(["simulate", file, *low, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    error, peak = content["error"], 1e3 * content["peak_displacement"]
    assert not error["low"] <= 0.0 <= error["high"]
    text = f"; expected {peak / (1.0 + error['expected']):.1f}, 90 %: "
    assert text in content["headline"].replace("\u00a0", " ")


def test_all_numbers_with_full(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", file, "--model", "four-dof", "--full"]) == 0
    full = capsys.readouterr().out
    assert run(["simulate", file, "--model", "four-dof"]) == 0
    short = capsys.readouterr().out
    assert "wall time" in full
    assert "wall time" not in short
    left = re.search(r"(\d+) more numbers with --full", short)
    assert left is not None
    assert full.count("\n  ") == 5 + int(left[1])


def test_several_models_stand_in_one_table(
    file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "both.png"
    command = ["simulate", file, "--model", "four-dof", "--model", "energy-estimate"]
    assert run([*command, "--json"]) == 0
    first, second = json.loads(capsys.readouterr().out)["models"]
    assert (first["model"], second["model"]) == ("four-dof", "energy-estimate")
    assert run([*command, "--plot", str(picture)]) == 0
    text = capsys.readouterr().out.replace("\u00a0", " ")
    for each in (first, second):
        peak = f"{1e3 * each['peak_displacement']:.3g} mm"
        assert re.search(rf"(?m)^{each['model']} +survives +{re.escape(peak)}", text)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("again_below", "wall_time"), [(1e9, r"[\d.]+\s(µs|ms|s)"), (0.0, "compiled")]
)
def test_a_wall_time_holds_no_compilation(
    again_below: float,
    wall_time: str,
    file: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    class Compiling(FourDof):
        def simulate(self, scenario: Any) -> Any:
            numba.njit(lambda x: x + 1.0)(len(calls))
            calls.append(scenario)
            return super().simulate(scenario)

    calls: list[Any] = []
    monkeypatch.setattr("workbench.base.compiled.TIMED_AGAIN_BELOW", again_below)
    response = timed(load_scenario(file), Compiling())
    assert len(calls) == (2 if again_below else 1)
    assert re.fullmatch(wall_time, time_of(response).text)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--plot", "a.gif"], "--plot = 'a.gif': must end in png or svg or pdf"),
        (["--model", "four-dof", "--model", "biggs", "--out", "a.nc"], "must be one for --out"),
        (["--model", "four-dfo"], "did you mean four-dof?; `workbench models` lists all"),
        (["--model", "four-dof", "--model", "biggs", "--option", "beta=1.3"], "option.beta"),
        (["--set", "striker.velocity=18 kg"], 'or with a unit in quotes, such as "90 km/h"'),
        (["--set", "striker.velocty=18"], "unknown key; did you mean velocity? Known are"),
    ],
)
def test_bad_input_is_one_line(
    file: str, more: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["simulate", file, *more]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert (captured.out, captured.err.count("\n")) == ("", 1)


def test_long_work_says_so_ever_more_rarely(capsys: pytest.CaptureFixture[str]) -> None:
    with at_work("a model", seconds=0.2) as say:
        say("3 m/s: survives")
        time.sleep(0.6)
    with at_work("another", seconds=5.0):
        pass
    captured = capsys.readouterr()
    assert captured.err == "workbench: a model for 0.2 s, 3 m/s: survives\n"  # nothing compiles
    assert captured.out == ""


def test_compiling_is_said_while_it_lasts(capsys: pytest.CaptureFixture[str]) -> None:
    def compiled() -> None:
        """Stands for the compiler: by its module the frame is known."""
        with at_work("a model", seconds=0.2):
            time.sleep(0.5)

    compiler = FunctionType(compiled.__code__, {**globals(), "__name__": "numba.core.compiler"})
    compiler()
    assert "; the first run of a model compiles it" in capsys.readouterr().err
