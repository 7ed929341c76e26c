"""One verdict: the tables, the command line, the report and the front page say the same."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from toy_models import Troubled

from workbench.cli.studies import gate_objects
from workbench.content.tree import Callout, Table
from workbench.report.build import summary
from workbench.report.chapters.verdicts import verdicts
from workbench.report.stored import Stored
from workbench.study import Assessment, Gate, Study, assess, run_study


@pytest.fixture
def judged(toy_study: Study, tmp_path: Path) -> tuple[Stored, Assessment]:
    """Two gates that differ in their cases alone, and one whose last case collapses."""
    same = Gate("soft", "fine", "peak_displacement", "relative_error", 0.2, "why", "where")
    gates = (
        dataclasses.replace(same, cases=("v10.0",)),
        dataclasses.replace(same, cases=("v15.0", "v20.0")),
        dataclasses.replace(same, model="collapsing", bound=1e3),
    )
    models = {**toy_study.models, "collapsing": Troubled("collapse", above=18.0)}
    study = dataclasses.replace(toy_study, models=models, gates=gates, figures=(), quick_models=())
    run_study(study, tmp_path, jobs=0)
    found = assess(study, tmp_path)
    return Stored(found.directory, study), found


def test_gates_that_differ_only_in_their_cases_are_two_everywhere(judged, tmp_path) -> None:
    stored, found = judged
    objects = gate_objects(found)
    assert [gate["counts"]["asked"] for gate in objects] == [1, 2, 3]
    assert [row["asked"] for row in stored.rows["verdicts"]] == [1, 2, 3]
    assert [row["verdict"] for row in stored.rows["verdicts"]] == [
        gate["verdict"] for gate in objects
    ]
    section = verdicts(stored)
    (table,) = [b for b in section.blocks if isinstance(b, Table) and b.key == "verdict-table"]
    assert [row[0].text for row in table.rows] == ["pass", "pass", "inconclusive"]
    assert [row[4].text for row in table.rows] == ["1 of 1", "2 of 2", "2 of 3"]
    page = summary(stored.directory, stored.study, tmp_path / "kept").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| ")]
    assert len(rows) == 1 + 3


def test_a_collapse_is_said_in_the_first_line(judged, tmp_path) -> None:
    stored, _ = judged
    first = verdicts(stored).blocks[0]
    assert isinstance(first, Callout)
    assert first.tone == "doubt"
    assert first.text.startswith("Of 3 gates, 2 passed, 0 failed, 1 inconclusive. ")
    assert "no answer in 1 of 3 asked cases: v20.0 (collapsing: out-of-domain" in first.text
    page = summary(stored.directory, stored.study, tmp_path / "kept").read_text(encoding="utf-8")
    assert "no answer in 1 of 3 asked cases: v20.0" in page
    assert page.index("no answer in 1 of 3") < page.index("| verdict")
