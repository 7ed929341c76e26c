"""Budgets of a study: varied runs are stored, the terms are a table."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd
import pytest
from toy_models import Spring

from workbench.base.errors import InputError
from workbench.report.chapters.answer import in_brief
from workbench.report.chapters.budgets import budget_tables, budgets
from workbench.report.drawing.sheet import Request
from workbench.report.drawing.style import looks
from workbench.report.figures import draw
from workbench.report.gallery import figures_of
from workbench.report.page.terminal import render_text
from workbench.scenarios import ColumnImpact
from workbench.study import Budget, Case, Store, Study, assess, cells_of, run_study
from workbench.study.assessment.gates import TOTAL
from workbench.study.assessment.variations import RATED, STATIC
from workbench.study.assessor import Assessment, read_assessment


@pytest.fixture(scope="module")
def stored(thesis_impact: ColumnImpact, tmp_path_factory: pytest.TempPathFactory) -> Assessment:
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
    return read_assessment(assess(study, root).directory, study)


def test_varied_runs_are_stored_and_compared_with_nothing_else(stored: Assessment) -> None:
    cells = cells_of(stored.study)
    # 3 inputs both ways; the real column, its inputs, and both ends of D
    assert len(cells) == 2 * 2 + 2 * (6 + 1 + 6 + 2)
    assert all(Store(stored.directory).holds(cell.key) for cell in cells)
    for name in ("cells", "comparisons", "references", "matrix", "findings"):
        table = pd.read_csv(stored.directory / "tables" / f"{name}.csv")
        assert "hit: velocity +5 %" not in set(table.get("case", ()))


def test_the_terms_are_a_table(stored: Assessment) -> None:
    named = [row for row in stored.records("budget") if row["label"] == "soft"]
    assert list(dict.fromkeys(row["form"] for row in named)) == [RATED, STATIC]
    rows = [row for row in named if row["form"] == RATED]
    assert [row["term"] for row in rows][2] == "velocity ±5 %"
    assert rows[2]["high"] == pytest.approx(0.05)
    assert rows[2]["most"] == pytest.approx(1.05 * rows[2]["value"])
    assert "mass ±5 %" not in {row["term"] for row in rows}


def test_the_report_shows_the_budget(stored: Assessment) -> None:
    (figure,) = (each for each in figures_of(stored.study) if each.kind == "budget")
    assert figure.options["case"] == "hit"
    study = stored.study
    request = Request(study, figure, stored, study.cases, figure.models, looks(study))
    drawing = draw(request)
    assert set(drawing.data["label"]) == {"soft", "stiff"}
    assert set(drawing.data["form"]) == {RATED}
    other = replace(figure, options={"case": "slow"})
    assert draw(replace(request, figure=other)).canvas is None
    words = render_text(budgets(stored, {"hit": "soft", "slow": "stiff"}))
    start = "With total uncertainty (90 %), hit, soft: with strain rate "
    assert words.startswith(start)
    assert "; at the static yield stress " in words
    soft = [row for row in stored.records("budget") if row["label"] == "soft"]
    terms = {row["term"] for row in soft if row["form"] == RATED}
    assert ("without an interval" in words) == (TOTAL not in terms)
    assert words.count("With total uncertainty") == 1  # one headline, that of the model to take
    assert "With total uncertainty" not in render_text(in_brief(stored.study, stored))  # none is
    section = budget_tables(stored)
    text = render_text(section)
    assert "one input varied, both ways" in text
    assert (", 90 %), most of it by" in text) == (TOTAL in terms)
    assert ("without an interval, as parts are not known: model form (" in text) == (
        TOTAL not in terms
    )


def test_the_quick_form_keeps_the_budgets_of_its_models(stored: Assessment) -> None:
    (kept,) = stored.study.quickened().budgets
    assert kept.models == ("stiff",)
    with pytest.raises(InputError, match="is not a case"):
        replace(stored.study, budgets=(Budget("hat", ("soft",)),))
    with pytest.raises(InputError, match="must be one of soft"):
        replace(stored.study, budgets=(Budget("hit", ("sift",)),))


def test_answers_of_an_earlier_version_count_if_asked(
    stored: Assessment, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Spring, "version", 2)
    root = stored.directory.parent
    now = assess(stored.study, root).tables["cells"]
    then = assess(stored.study, root, earlier=True).tables["cells"]
    assert set(now["outcome"]) == {"not run"}
    assert set(zip(then["outcome"], then["model_version"], strict=True)) == {("ok", 1)}
