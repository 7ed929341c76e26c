"""The first study of the user guide is one whose answer is known."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

import workbench
from workbench.scenarios import to_toml
from workbench.study.error_model.error_model import advise

GUIDE = Path(workbench.__file__).parents[1] / "docs" / "guide" / "study.md"


@pytest.mark.thorough
def test_its_models_are_inside_their_domain(thesis_impact, tmp_path: Path, monkeypatch) -> None:
    text = GUIDE.read_text(encoding="utf-8").split("`studies/mine.py`:\n")[1]
    code = dedent(text.split("Kinds of figures")[0])
    (tmp_path / "scenario.toml").write_text(to_toml(thesis_impact), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    made: dict = {}
    exec(code, made)
    study = made["study"]
    assert len(study.cases) == 3
    for case in study.cases:
        for label, model in study.models.items():
            response = model.simulate(case.scenario)
            outside = [f for f in advise(model, case.scenario, response) if f.outside or f.refusal]
            assert not outside, f"{case.name}, {label}: {outside[0]}"
