"""The core without its companions: all of it imports, answers, sweeps and reports."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HIDDEN = """
import importlib, importlib.metadata as metadata, pkgutil, sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.startswith("workbench.extras"):
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Hidden())
every = metadata.entry_points
metadata.entry_points = lambda **group: every() if not group else metadata.EntryPoints(
    point for point in every(**group) if not point.value.startswith("workbench.extras")
)
"""
ALL_MODULES = """
import workbench
for module in pkgutil.walk_packages(workbench.__path__, "workbench."):
    if not module.name.startswith("workbench.extras") and "._" not in module.name:
        importlib.import_module(module.name)
"""
ANSWERS = """
import workbench as wb
from pathlib import Path
from workbench.report.build import build_report
from workbench.study.assessor import Assessment
from workbench.study import Case, Study, assess, run_study

assert "biggs" not in wb.model_names()
impact = wb.impact(wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN"), mass=1500, velocity=15)
assert "mm" in wb.simulate(impact).workbench.headline
assert wb.sweep(impact, {"striker.velocity": [5.0, 10.0]}, ["four-dof"]).outcome.shape == (1, 2)
models = {name: wb.make_model(name) for name in ("four-dof", "single-dof")}
study = Study("small", "Small", "How far?", (Case("hit", impact),), models, "four-dof")
run_study(study, Path(), jobs=1)
result = assess(study, Path())
assert build_report(result, ["html"])["html"].is_file()
"""
VERBS = """
from workbench.cli import run
assert run(["new", "column"]) == 0
assert run(["models"]) == 0
assert run(["data", "list"]) == 0
assert run(["fragility", "scenario.toml"]) == 2
"""


@pytest.mark.thorough
@pytest.mark.parametrize("code", [ALL_MODULES, ANSWERS, VERBS], ids=["modules", "answers", "verbs"])
def test_the_core_works_without_companions(code: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", HIDDEN + code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
