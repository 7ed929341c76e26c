"""One verdict: the tables, the command line, the report and the front page say the same."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from pages import views
from toy_models import Troubled

from workbench.cli.studies import gate_objects
from workbench.report.build import summary
from workbench.report.chapters.limits import collapses, missing
from workbench.report.chapters.verdicts import verdicts
from workbench.study import Assessment, Gate, Study, assess, run_study
from workbench.study.assessor import read_assessment


@pytest.fixture
def judged(toy_study: Study, tmp_path: Path) -> tuple[Assessment, Assessment]:
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
    assessment = assess(study, tmp_path)
    return read_assessment(assessment.directory, study), assessment


def test_gates_that_differ_only_in_their_cases_are_two_everywhere(judged, tmp_path) -> None:
    stored, result = judged
    objects = gate_objects(result)
    assert [gate["counts"]["asked"] for gate in objects] == [1, 2, 3]
    assert [row["asked"] for row in stored.records("verdicts")] == [1, 2, 3]
    assert [row["verdict"] for row in stored.records("verdicts")] == [
        gate["verdict"] for gate in objects
    ]
    (table, *_) = views(verdicts(stored), "table")
    assert table.key == "verdict-table"
    assert [row[0].text for row in table.rows] == ["pass", "pass", "fail"]
    assert table.rows[2][3].text == "collapsing collapses (v20.0)"
    assert [row[5].text for row in table.rows] == ["1 of 1", "2 of 2", "2 of 3"]
    page = summary(stored, tmp_path / "kept").read_text(encoding="utf-8")
    assert len(re.findall(r"^\| \S+ (?:pass|fail) ", page, re.MULTILINE)) == 3


def test_a_collapse_is_said_in_the_first_line(judged, tmp_path) -> None:
    stored, _ = judged
    first = views(verdicts(stored))[1]
    assert first.kind == "callout"
    assert first.tone == "bad"
    assert first.text == (
        "Of 3 gates, 2 passed, 1 failed, 0 inconclusive. One side collapses where the other "
        "survives in 1 gate: v20.0 (collapsing collapses)."
    )
    page = summary(stored, tmp_path / "kept").read_text(encoding="utf-8")
    assert page.index("One side collapses where the other survives") < page.index("| verdict")


def test_collapses_are_counted_apart_from_refusals_and_failures(judged) -> None:
    stored, _ = judged
    collapse = stored.cells["v20.0", "collapsing"].collapse
    assert collapse == ("geometry", ("below",), 0.5, 0.02)
    _, statements, table = views(collapses(stored))
    assert statements.tone == "note"
    assert statements.text.startswith("In 1 cell of 15 the structure collapses, which is an answer")
    assert [cell.text for cell in table.rows[0]] == [
        *("v20.0", "collapsing", "geometry", "below", "0.0200", "0.500")
    ]
    (_, callout) = views(missing(stored.study, stored))
    assert callout.text == "All 15 cells hold an answer; nothing is missing."
