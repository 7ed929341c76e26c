"""The package of `docs/examples`: installed as any other, asked by the command line, tested."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from workbench.cli import run

EXAMPLE = Path(__file__).parents[3] / "docs" / "examples" / "rigid-plastic-beam"
NAME = "rigid-plastic-beam"
COMMAND = "from workbench.cli import main; main()"
SCENARIO = """
kind = "column-impact"
name = "bar"
[column]
section = {height = 0.05, width = 0.1}
length_below = 1.0
length_above = 1.0
head = "fixed"
[striker]
mass = 500.0
velocity = 16.0
"""


def test_the_template_and_the_package_enter_by_one_door(capsys) -> None:
    assert run(["new", "model"]) == 0
    template = capsys.readouterr().out
    group = '[project.entry-points."workbench.models"]'
    assert group in template
    assert f"docs/examples/{EXAMPLE.name}" in template
    assert group in (EXAMPLE / "pyproject.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def call(tmp_path_factory: pytest.TempPathFactory):
    """Calls of Python where the package is installed, in a folder with its tests."""
    pytest.importorskip("hatchling", reason="builds the package: pip install hatchling editables")
    folder = tmp_path_factory.mktemp("plug-in")
    source, target = folder / "source", folder / "installed"
    shutil.copytree(EXAMPLE, source, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "bar.toml").write_text(SCENARIO)

    def python(*arguments: str, path: str = str(target)) -> str:
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        return done.stdout

    alone = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index")
    python("-m", "pip", "install", *alone, "--target", str(target), str(source), path="")
    shutil.rmtree(source / "rigid_plastic_beam")  # what runs is what was installed
    return python


@pytest.mark.thorough
def test_its_model_is_known_by_name_and_answers(call) -> None:
    (known,) = json.loads(call("-c", COMMAND, "models", NAME, "--json"))["models"]
    assert known["distribution"] == NAME
    assert known["options"] == {"dynamic_factor": 1.0}
    assert "Jones, N.: Structural Impact" in call("-c", COMMAND, "models", NAME)
    answer = json.loads(call("-c", COMMAND, "simulate", "bar.toml", "--model", NAME, "--json"))
    # as a string, x^2 + 1/3 = E / (P_0 h), with M_p = 22.2 kN m
    work = 0.5 * 500.0 * 16.0**2 * 500.0 / (500.0 + 7850.0 * 0.005 * 2.0 / 3.0)
    plateau = 2.0 * 355e6 * 0.1 * 0.05**2 / 4.0 * 2.0
    expected = 0.05 * (work / (plateau * 0.05) - 1.0 / 3.0) ** 0.5
    assert answer["peak_displacement"] == pytest.approx(expected, rel=1e-9)
    assert answer["model"] == NAME


@pytest.mark.thorough
def test_its_study_runs_in_quick_form(call) -> None:
    study = call("-m", "rigid_plastic_beam").strip()
    done = json.loads(call("-c", COMMAND, "run", study, "--quick", "--jobs", "1", "--json"))
    assert done["outcomes"] == {"ok": 3}
    (gate,) = done["gates"]
    assert gate["verdict"] == "pass"
    assert -0.06 < gate["value"] < -0.02  # elastic bending is left out


@pytest.mark.thorough
def test_its_own_tests_pass(call) -> None:
    assert " passed" in call("-m", "pytest", "-q", "-p", "no:cacheprovider", "source/tests")
