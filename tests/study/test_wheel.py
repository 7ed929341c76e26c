"""What the wheel holds: the studies and data that README and commands name."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import workbench

TREE = Path(workbench.__file__).resolve().parents[1]
BUILD = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
LOOK = """
import workbench
from workbench.base.datafiles import data_directory
from workbench.study.store import load_study, study_files
print(workbench.__file__, data_directory(), *sorted(study_files()), sep="\\n")
assert len(load_study("drawn_frames").study.cases) > 0  # which imports another one
"""


@pytest.mark.thorough
def test_the_wheel_holds_data_and_studies(tmp_path: Path) -> None:
    command = [sys.executable, "-c", BUILD, str(tmp_path)]
    built = subprocess.run(command, cwd=TREE, capture_output=True, text=True, check=True)
    site = tmp_path / "site"
    with zipfile.ZipFile(tmp_path / built.stdout.split()[-1]) as wheel:
        wheel.extractall(site)
    done = subprocess.run(
        [sys.executable, "-c", LOOK],
        **{"cwd": tmp_path, "capture_output": True, "text": True, "check": False},
        env={**os.environ, "PYTHONPATH": str(site)},
    )
    assert done.returncode == 0, done.stderr
    package, data, *studies = done.stdout.split("\n")[:-1]
    assert Path(package).parent == site / "workbench"
    assert Path(data) == site / "workbench" / "_data"
    assert studies == sorted(path.stem for path in (TREE / "studies").glob("*.py"))
    shipped = {path.name for path in (site / "workbench" / "_data").rglob("*")}
    assert {path.name for path in (TREE / "data").rglob("*")} <= shipped
