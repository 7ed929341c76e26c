"""The studies that come with the workbench load, fit together and ask what their titles say."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from workbench.report.figures import KINDS
from workbench.study import load_study

STUDIES = Path(__file__).resolve().parents[2] / "studies"
FILES = sorted(STUDIES.glob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_studies_load_and_their_quick_form_is_smaller(path: Path) -> None:
    study = load_study(str(path)).study
    assert study.name == path.stem
    quick = study.quickened()
    assert 0 < len(list(quick.cells())) < len(list(study.cells()))
    assert quick.gates
    for figure in (*study.figures, *quick.figures):
        assert figure.kind in KINDS
        named = {*figure.options.get("cases", ()), figure.options.get("case", "")} - {""}
        assert named <= {case.name for case in study.cases}


def test_every_impact_of_the_flagship_has_published_numbers() -> None:
    study = load_study(str(STUDIES / "thesis_column.py")).study
    for case in study.cases:
        if case.scenario.KIND != "column-impact":
            continue
        published = [study.models[m] for m in case.models if m.startswith("Heng")]
        assert published
        for model in published:
            assert model.domain(case.scenario) == []


def test_a_study_is_a_script_too() -> None:
    command = [sys.executable, str(STUDIES / "column_sweep.py"), "--help"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0
    assert "Usage" in done.stdout
