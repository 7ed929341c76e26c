"""Set-up: no answer of the first page, and no cell of the flagship, waits for the compiler."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ANSWERS = """
from dataclasses import replace
from numba.core.event import install_recorder
from workbench.base.datafiles import data_directory
from workbench.cli import run
from workbench.study import load_study

study = load_study("thesis_column").study
file = str(data_directory() / "published" / "heng2017_impact_column.toml")
with install_recorder("numba:compile") as recorder:
    for more in ([], ["--model", "four-dof", "--model", "biggs"]):
        assert run(["simulate", file, *more]) == 0
    for case in study.cases:
        brief = {"duration": 1e-3} if hasattr(case.scenario, "duration") else {"displacement": 1e-3}
        for label in case.models:
            study.models[label].simulate(replace(case.scenario, **brief))
functions = (event.data["dispatcher"].py_func for _, event in recorder.buffer)
print("compiled", sorted({f"{each.__module__}.{each.__qualname__}" for each in functions}))
"""


@pytest.mark.thorough
def test_set_up_compiles_what_the_first_page_and_the_flagship_run(tmp_path: Path) -> None:
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    warm = "from workbench.cli import main; main(['warm', '--jobs', '2'])"
    for code, end in ((warm, ""), (ANSWERS, "compiled []\n")):
        done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True)
        assert (done.returncode, done.stdout.endswith(end)) == (0, True), done
