"""`workbench sample` and `workbench sensitivity`."""

import json
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from builders import UNCERTAIN

from workbench.cli import run
from workbench.models.base import make_model
from workbench.scenarios import load_scenario
from workbench.study.store import locked

TEXT = f"""{UNCERTAIN}mass = 1500.0
velocity = {{ normal = [10.0, 1.0] }}
"""
SDOF = ("--model", "single-dof", "--jobs", "1")


@pytest.fixture
def uncertain_file(tmp_path):
    path = tmp_path / "column.toml"
    path.write_text(TEXT)
    return str(path)


def test_rows_are_the_answers_of_single_calls(uncertain_file, tmp_path, capsys):
    out = tmp_path / "answers.csv"
    arguments = ("--samples", "12", "--out", str(out))
    assert run(["sample", uncertain_file, *SDOF, *arguments]) == 0
    assert "12 samples by single-dof: 12 ok" in capsys.readouterr().out
    table = pd.read_csv(out)
    keys = ["column.axial_load", "steel.yield_stress", "striker.velocity"]
    assert list(table.columns[:3]) == keys
    assert list(table.columns[-2:]) == ["outcome", "failure"]
    row = table.iloc[5]
    single = load_scenario(uncertain_file, [f"{key}={float(row[key])!r}" for key in keys])
    peak = float(make_model("single-dof").simulate(single).peak_displacement)
    assert row["peak_displacement"] == pytest.approx(peak, rel=1e-12)


def test_without_a_file_the_quantiles_are_all(uncertain_file, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    assert run(["sample", uncertain_file, "--samples", "12", "--jobs", "1"]) == 0
    assert "12 samples by four-dof: 12 ok" in capsys.readouterr().out
    assert sorted(tmp_path.rglob("*")) == before


SMALL_CHUNKS = """
import sys
from workbench.cli import run
from workbench.extras.uncertainty import chunks
chunks.STACKED = chunks.ALONE = 100
sys.exit(run(sys.argv[1:]))
"""


@pytest.mark.thorough
def test_a_killed_run_goes_on_where_it_was(uncertain_file, tmp_path, monkeypatch):
    whole, out = tmp_path / "whole.csv", tmp_path / "answers.csv"
    asked = ["sample", uncertain_file, *SDOF, "--samples", "3000"]
    command = [sys.executable, "-c", SMALL_CHUNKS, *asked, "--out", str(out)]
    killed = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    begin = time.monotonic()
    while not list(tmp_path.glob(".answers.csv.chunks/*.nc")):
        assert killed.poll() is None
        assert time.monotonic() < begin + 120.0
        time.sleep(0.002)
    killed.kill()
    killed.wait()
    assert not out.exists()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "of 30 chunks are there already" in done.stderr
    monkeypatch.setattr("workbench.extras.uncertainty.chunks.STACKED", 100)
    assert run([*asked, "--out", str(whole)]) == 0
    assert out.read_bytes() == whole.read_bytes()
    assert not list(tmp_path.glob(".*chunks*"))


def test_two_at_once_are_told_apart(uncertain_file, tmp_path, capsys):
    out = tmp_path / "answers.csv"
    folder = tmp_path / ".answers.csv.chunks"
    folder.mkdir()
    asked = ["sample", uncertain_file, *SDOF, "--samples", "12", "--out", str(out)]
    with locked(folder / ".lock"):  # as the other one holds it
        assert run(asked) == 2
    assert "is in use by another run; wait until it is over" in capsys.readouterr().err
    assert run(asked) == 0
    assert not folder.exists()


def test_chunks_of_another_question_are_not_taken(uncertain_file, tmp_path, capsys):
    stale = tmp_path / ".answers.csv.chunks"
    stale.mkdir()
    (stale / "0123456789abcdef-0-12-0123456789abcdef.nc").write_text("of another model")
    out = str(tmp_path / "answers.csv")
    assert run(["sample", uncertain_file, *SDOF, "--samples", "12", "--out", out]) == 0
    assert "there already" not in capsys.readouterr().err
    assert not stale.exists()


def test_parts_of_a_sequence_are_the_whole(uncertain_file, tmp_path):
    whole, part = tmp_path / "whole.nc", tmp_path / "part.nc"
    assert run(["sample", uncertain_file, *SDOF, "--samples", "20", "--out", str(whole)]) == 0
    parts = ("--samples", "7", "--first", "13", "--out", str(part))
    assert run(["sample", uncertain_file, *SDOF, *parts]) == 0
    with xr.open_dataset(whole) as all_, xr.open_dataset(part) as last:
        assert np.array_equal(all_.peak_displacement[13:], last.peak_displacement)


def test_collapse_and_failure_stand_in_their_row(uncertain_file, tmp_path):
    out = tmp_path / "answers.csv"
    loaded = ("--set", "column.axial_load={ uniform = [1.0e6, 5.0e6] }")
    status = run(["sample", uncertain_file, *SDOF, *loaded, "--samples", "16", "--out", str(out)])
    table = pd.read_csv(out, keep_default_na=False)
    ok = table["outcome"] == "ok"
    assert 0 < ok.sum() < 16
    assert all(table["failure"][~ok] != "")
    assert all(table["peak_displacement"][~ok] == "")
    assert "invalid-input" in set(table["outcome"])  # above the squash load
    assert status == 1


def test_velocity_decides_the_peak(uncertain_file, capsys):
    arguments = ("--samples", "128", "--json")
    assert run(["sensitivity", uncertain_file, *SDOF, *arguments]) == 0
    rows = {r["input"]: r for r in json.loads(capsys.readouterr().out)["indices"]}
    # d ln peak / d ln v = 1.8 at a cov of 0.1, and some -0.9 of the yield stress at 0.07
    assert rows["striker.velocity"]["total"]["value"] > 0.7
    assert 0.02 < rows["steel.yield_stress"]["total"]["value"] < 0.3
    assert run(["sensitivity", uncertain_file, *SDOF, "--samples", "64"]) == 0
    assert "striker.velocity" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("sample", "--samples", "0", "--out", "a.csv"), "--samples"),
        (("sample", "--out", "a.docx"), "--out"),
        (("sample", "--out", "a.csv", "--seed", "-1"), "--seed"),
        (("sample", "--out", "a.csv", "--first", "-1"), "--first"),
        (("sample", "--slice", "1/2"), "--out"),
        (("sensitivity", "--samples", "5"), "--samples"),
        (("sensitivity", "--samples", "64", "--quantity", "colour"), "--quantity"),
        (
            (
                "sensitivity",
                "--set",
                'correlation.pairs=[["column.axial_load", "striker.velocity", 0.5]]',
            ),
            "correlation",
        ),
    ],
)
def test_wrong_options_of_samples_are_one_line(uncertain_file, capsys, arguments, message):
    verb, *rest = arguments
    assert run([verb, uncertain_file, *SDOF, *rest]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_certain_scenarios_have_no_samples(tmp_path, capsys):
    assert run(["new", "column"]) == 0
    path = tmp_path / "plain.toml"
    path.write_text(capsys.readouterr().out)
    assert run(["sensitivity", str(path), *SDOF]) == 2
    assert "no uncertain input" in capsys.readouterr().err


@pytest.mark.parametrize(("most", "indexed"), [(1.1e6, False), (1.6e6, True)])
def test_missing_answers_have_indices_where_there_are_enough(uncertain_file, capsys, most, indexed):
    loaded = f"column.axial_load={{ uniform = [2.0e5, {most}] }}"
    arguments = ("--set", loaded, "--samples", "256", "--json")
    assert run(["sensitivity", uncertain_file, *SDOF, *arguments]) == 0
    content = json.loads(capsys.readouterr().out)
    assert 0.0 < content["missing_share"] < 1.0
    assert all(("first_missing" in row) == indexed for row in content["indices"])
