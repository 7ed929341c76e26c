"""Budgets of a study: varied runs are stored, the terms are a table; measuring the model form."""

from __future__ import annotations

from dataclasses import replace
from math import exp
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from toy_models import Spring

from workbench.assessment.budget import TOTAL
from workbench.content.terminal import render_text
from workbench.errors import InputError
from workbench.evidence.descriptors import DEMAND, YIELDING, descriptors
from workbench.report.chapters.answer import in_brief
from workbench.report.chapters.budgets import budget_tables, budgets
from workbench.report.drawing.sheet import Request
from workbench.report.drawing.style import looks
from workbench.report.figures import draw
from workbench.report.gallery import figures_of
from workbench.report.stored import Stored
from workbench.scenarios import ColumnImpact
from workbench.study import Assessment, Budget, Case, Store, Study, assess, cells_of, run_study
from workbench.study.model_form import model_form_rows, range_rows


@pytest.fixture(scope="module")
def stored(thesis_impact: ColumnImpact, tmp_path_factory: pytest.TempPathFactory) -> Stored:
    study = Study(
        name="budgeted",
        title="Budgeted",
        question="What may the errors make of it?",
        cases=(Case("hit", thesis_impact), Case("slow", thesis_impact.at_velocity(5.0))),
        models={"soft": Spring(stiffness=4e6), "stiff": Spring()},
        reference="stiff",
        budgets=(Budget("hit", ("soft", "stiff"), {"mass": 0.0}),),
        quick_models=("stiff",),
    )
    root = tmp_path_factory.mktemp("budget")
    run_study(study, root, jobs=0)
    return Stored(assess(study, root).directory, study)


def test_varied_runs_are_stored_and_compared_with_nothing_else(stored: Stored) -> None:
    cells = cells_of(stored.study)
    assert len(cells) == 2 * 2 + 2 * 7  # 3 inputs both ways, and the rate
    assert all(Store(stored.directory).holds(cell.key) for cell in cells)
    for name in ("cells", "comparisons", "references", "matrix", "findings"):
        table = pd.read_csv(stored.directory / "tables" / f"{name}.csv")
        assert "hit: velocity +5 %" not in set(table.get("case", ()))


def test_the_terms_are_a_table(stored: Stored) -> None:
    rows = [row for row in stored.rows["budget"] if row["label"] == "soft"]
    assert [row["term"] for row in rows][2] == "velocity ±5 %"
    assert rows[2]["high"] == pytest.approx(0.05)
    assert rows[2]["most"] == pytest.approx(1.05 * rows[2]["value"])
    assert TOTAL not in {row["term"] for row in rows}  # nobody measured the model form of a toy
    assert "mass ±5 %" not in {row["term"] for row in rows}


def test_the_report_shows_the_budget(stored: Stored) -> None:
    (figure,) = (each for each in figures_of(stored.study) if each.kind == "budget")
    assert figure.options["case"] == "hit"
    study = stored.study
    request = Request(study, figure, stored, study.cases, figure.models, looks(study))
    drawing = draw(request)
    assert set(drawing.data["label"]) == {"soft", "stiff"}
    assert len(drawing.data) == len(stored.rows["budget"])
    other = replace(figure, options={"case": "slow"})
    assert draw(replace(request, figure=other)).canvas is None
    said = render_text(*budgets(stored, {"hit": "soft", "slow": "stiff"}))
    assert said.startswith("With total uncertainty, hit, soft: peak displacement ")
    assert "without an interval: the model form is not known (not measured here" in said
    assert said.count("With total uncertainty") == 1  # one headline, that of the model to take
    assert "With total uncertainty" not in render_text(*in_brief(stored.study, stored))  # none is
    section = budget_tables(stored)
    assert section is not None
    assert "one input varied, both ways" in render_text(section)


def test_the_quick_form_keeps_the_budgets_of_its_models(stored: Stored) -> None:
    (kept,) = stored.study.quickened().budgets
    assert kept.models == ("stiff",)
    with pytest.raises(InputError, match="is not a case"):
        replace(stored.study, budgets=(Budget("hat", ("soft",)),))
    with pytest.raises(InputError, match="must be one of soft"):
        replace(stored.study, budgets=(Budget("hit", ("sift",)),))


def drawn(thesis_impact: ColumnImpact, count: int) -> tuple[Case, ...]:
    """Hits ever lower on the column, so that V/Vpl rises."""
    column = thesis_impact.column
    lengths = np.linspace(1.3, 0.6, count)
    return tuple(
        Case(f"{low:g}", replace(thesis_impact, column=replace(column, length_below=low)))
        for low in lengths.tolist()
    )


def test_the_model_form_of_a_known_bias_is_found(
    thesis_impact: ColumnImpact, tmp_path: Path
) -> None:
    """Model over reference exp(-0.4 (V/Vpl - 1)): bias and slope come back, without scatter."""
    cases = drawn(thesis_impact, 8)
    study = Study("drawn", "", "", cases, {"soft": Spring(), "fine": Spring()}, "fine")
    demand = [descriptors(case.scenario)[DEMAND] for case in cases]  # type: ignore[arg-type]
    pairs = [
        {
            "case": case.name,
            "model": "soft",
            "against": "fine",
            "quantity": "peak_displacement",
            "metric": "relative_error",
            "value": 0.2 * exp(-0.4 * (own - 1.0)),
            "against_value": 0.2,
        }
        for case, own in zip(cases, demand, strict=True)
    ]
    references = [{"case": case.name, "label": "fine", "inside": 1} for case in cases]
    cells = [
        {"case": case.name, "label": label, "model_version": 1, "outcome": "not run", "key": ""}
        for case in cases
        for label in study.models
    ]
    rows = {"comparisons": pairs, "references": references, "cells": cells}
    tables = {name: pd.DataFrame(of) for name, of in rows.items()}
    (row,) = model_form_rows(study, Assessment(tmp_path, tables, ()))
    assert row["region"] == "V/Vpl above 1"
    assert row["count"] == sum(own >= 1.0 for own in demand)
    assert row["slope"] == pytest.approx(-0.4, rel=1e-3)
    assert row["bias"] == pytest.approx(exp(-0.4 * (row["centre"] - 1.0)), rel=1e-3)
    assert row["scatter"] < 1e-9
    ranges = {each["descriptor"]: each for each in range_rows(study)}
    assert ranges[DEMAND]["low"] <= min(demand) < max(demand) <= ranges[DEMAND]["high"]
    assert ranges[YIELDING]["low"] > 5.0
    with pytest.raises(InputError, match="no impact on a column"):
        list(
            model_form_rows(
                study,
                Assessment(tmp_path, {**tables, "comparisons": tables["comparisons"][:0]}, ()),
            )
        )


def test_answers_of_an_earlier_version_count_if_asked(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Spring, "version", 2)
    root = stored.directory.parent
    now = assess(stored.study, root).tables["cells"]
    then = assess(stored.study, root, earlier=True).tables["cells"]
    assert set(now["outcome"]) == {"not run"}
    assert set(zip(then["outcome"], then["model_version"], strict=True)) == {("ok", 1)}
