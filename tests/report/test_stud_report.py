"""The report of the studs: what is not validated first, the grade on the chart, design numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pages import views
from synthetic_study import shared_store_of, store_of

from workbench.report.build import build_report
from workbench.report.chapters import stud_study
from workbench.report.drawing.sheet import Request
from workbench.report.drawing.style import looks
from workbench.report.figures import draw
from workbench.report.gallery import cases_of, figures_of, to_svg
from workbench.report.page.bibliography import bibliography
from workbench.scenarios import StudTests
from workbench.studs.answers import StudMeasured, StudResidual
from workbench.study import Case, Figure, Study, assess, load_study
from workbench.study.assessment import Gate
from workbench.study.assessor import Assessment

pytestmark = pytest.mark.thorough

STUDY = Path(__file__).resolve().parents[2] / "studies" / "studs.py"
GRADE = "mechanical prediction, not validated by tests after pre-damage"


@pytest.fixture(scope="module")
def studs(tmp_path_factory) -> Assessment:
    """The quick form of the study, run in this process."""
    return shared_store_of(load_study(str(STUDY)).study.quickened(), tmp_path_factory)


def drawn(stored: Assessment, key: str):
    study = stored.study
    figure = next(figure for figure in figures_of(study) if figure.key == key)
    labels = figure.models or tuple(study.models)
    return draw(Request(study, figure, stored, cases_of(study, figure), labels, looks(study)))


def texts(canvas) -> str:
    return "\n".join(text.get_text() for axes in canvas.axes for text in axes.texts)


KEYS = ("guideline", "scatter", "residuals", "curves", "model", "unseen", "interaction")


@pytest.mark.parametrize("key", KEYS)
def test_every_figure_has_something_to_show(studs, key):
    drawing = drawn(studs, key)
    assert drawing.canvas is not None
    assert len(drawing.data) > 0
    assert drawing.alt
    assert drawing.statements
    if key == "guideline":
        assert to_svg(drawing.canvas, key) == to_svg(drawn(studs, key).canvas, key)


@pytest.mark.parametrize("key", KEYS)
def test_figures_of_other_cases_say_that_nothing_is_there(studs, key):
    study = studs.study
    figure = next(figure for figure in study.figures if figure.key == key)
    wrong = "interaction" if key != "interaction" else "strength"
    cases = tuple(case for case in study.cases if case.scenario.asked == wrong)
    request = Request(study, figure, studs, cases, tuple(study.models), looks(study))
    drawing = draw(request)
    assert drawing.canvas is None
    assert drawing.statements


def test_the_guideline_carries_its_grade(studs):
    drawing = drawn(studs, "guideline")
    shown = texts(drawing.canvas).replace("\n", " ")
    assert shown.count(GRADE) == 2  # strength and stiffness
    assert all(GRADE in statement for statement in drawing.statements)
    assert drawing.data["left"].between(0.0, 1.01).all()


def test_the_interaction_says_that_no_test_is_there(studs):
    assert "nothing here is validated" in texts(drawn(studs, "interaction").canvas)


def test_there_is_no_structure_to_draw(studs):
    assert "structure" not in {figure.kind for figure in figures_of(studs.study)}


def test_what_is_not_validated_comes_first(studs):
    short = stud_study.in_short(studs.study, studs)
    (first,) = views(short, "callout")
    assert first.tone == "bad"
    assert first.text.startswith("Not validated: strength and stiffness left after damage")
    assert GRADE in first.text
    assert "no combined test is in the tables" in first.text
    page = stud_study.design(studs.study, studs)
    (second, _) = views(page, "callout")
    assert "24 of 26 tests exceed the tensile strength of their shank" in second.text
    items = [item for view in views(short + page, "bullets") for item in view.items]
    values = {word: next(i for i in items if word in i) for word in SAID}
    assert all(text in values[word] for word, text in SAID.items())


# the questions of a designer, each with numbers of its own
SAID = {
    "by EN 1994-1-1: ": "characteristic 102 kN, design 81.7 kN with γ_V = 1.25; steel governs",
    "Least of 26 tests": "To take, as every test exceeds it: EN 1994 characteristic form.",
    "EN 1994 mean form: ": "0.909 and 1.32 of the prediction; so few cannot tell how good it is: "
    "median 1.09 (90\u2009% interval 0.339 to 3.53)",
    "mechanical stud: ": "no result of its own for strength",
    "Left after damage by pull-out": "Computed, no test: do not design",
    "of the largest load)": "rational law, fitted (0.052 of the largest load), then Ollgaard law",
    "root mean square": "rational law, fitted (0.052); then Ollgaard law, published (0.066)",
    "carried by the shank": "0.93 (0.85 to 1.0) at level 0.50, 0.84 (0.57 to 1.0) at level 1.0",
    "partial factor": "no reason to go below 1.25",
    "Not known": "strength other than for studs 12.7 to 22.23 x 76.2 to 152.4 mm",
}


def test_design_numbers_are_those_of_the_fits(studs):
    page = stud_study.design(studs.study, studs)
    tables = {table.key: table for table in views(page, "table")}
    assert set(tables) == {"design-d8", "design-left-out", "design-load-slip", "design-residual"}
    (_, callout) = views(page, "callout")
    assert "none of the 14 groups of nominally equal tests has three" in callout.text
    row = next(row for row in tables["design-d8"].rows if row[0].text.startswith("EN 1994 mean"))
    assert row[-1].text == "1.059"
    assert {row[1].text for row in tables["design-left-out"].rows} == {"provines2019", "lehigh279"}
    assert all(row[-1].tone == "bad" for row in tables["design-residual"].rows)


def test_gates_mean_something(studs):
    """An unsafe unseen test fails, what no test shows stays open, nothing passes by silence."""
    rows = pd.DataFrame(studs.records("gates"))
    by_model = rows.groupby("model")["verdict"].agg(set)
    assert "fail" in by_model["EN 1994 mean form, corrected"]
    assert "mechanical stud" not in by_model  # its strength is that of the mean form
    assert by_model["5/3 power"] == {"refused"}
    assert by_model["left after a pull-out, by uplift"] == {"refused"}
    ends = pd.DataFrame(studs.records("verdicts")).groupby("model")["verdict"].agg(set)
    assert ends["5/3 power"] == ends["left after a pull-out, by uplift"] == {"inconclusive"}
    bias = rows[(rows["model"] == "EN 1994 mean form") & rows["low"].notna()].iloc[0]
    assert bias["low"] == pytest.approx(0.339 - 1.0, abs=1e-3)  # 0.339 to 3.53 of the prediction
    assert bias["high"] == pytest.approx(3.533 - 1.0, abs=1e-3)
    unknown = rows[rows["uncertainty"].isna()]
    assert not (unknown["verdict"] == "pass").any()


def test_the_whole_report(studs, tmp_path):
    files = build_report(studs, out=tmp_path)
    html = files["html"].read_text(encoding="utf-8")
    assert files["pdf"].read_bytes().startswith(b"%PDF")
    order = [html.index(f">{title}<") for title in ("The answer", "Verdicts")]
    assert order == sorted(order)
    assert "1.094 (0.3389 to 3.533)" in html
    assert "(−66.1\u2009% to +253.3\u2009%)" in html
    for key in ("provines2019", "culver1960", "mcgarraugh1971", "en1990", "hanswille2007"):
        assert f'id="ref-{key}"' in html
        assert bibliography()[key].title.split(":")[0] in html


def damaged(path: Path) -> Path:
    """Tests of three laboratories that lose strength in proportion to a pull-out before."""
    generator = np.random.default_rng(1)
    lines = [
        "campaign,specimen,test,diameter_mm,shear_kN,undamaged_shear_kN,predamage,"
        "predamage_measure,predamage_level"
    ]
    for lab in ("lab 0", "lab 1", "lab 2", "lab 3"):
        effect = 2.0 * generator.normal()
        for i in range(5):
            level = 0.2 * i + 0.1
            load = 100.0 - 40.0 * level + effect + generator.normal()
            damage = f"pull-out,displacement ratio,{level:.1f}"
            lines.append(f"{lab},d{i},push-out,19,{load:.2f},100,{damage}")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_tests_after_pre_damage_flip_the_chart(tmp_path):
    """The same labels and figure with a table of a laboratory: another grade, a judged gate."""
    file = str(damaged(tmp_path / "lab.csv"))
    scenario = StudTests("left", "residual-strength", (file,), validate=("lab 3",))
    figure = Figure("guideline", "stud-guideline", "chart", "chart", ("left",))
    study = Study(
        "lab", "lab", "what is left?",
        (Case("strength left", scenario),),
        {"tests": StudMeasured(), "left": StudResidual()},
        "tests",
        quantities=("test_over_prediction",),
        gates=(Gate("left", "tests", "test_over_prediction", "relative_error", 0.2, "x", "y"),),
        figures=(figure,),
    )  # fmt: skip
    stored = store_of(study, tmp_path)
    drawing = drawn(stored, "guideline")
    shown = texts(drawing.canvas).replace("\n", " ")
    assert GRADE not in shown
    assert "cross-validated over campaigns" in shown
    assert "band of a new test" in {
        text.get_text() for text in drawing.canvas.legends[0].get_texts()
    }
    (only,) = views(stud_study.in_short(study, stored))
    assert "5 unseen tests of lab 3" in only.items[0]
    (result,) = assess(study, tmp_path).verdicts
    assert result.verdict.value == "pass"
    mechanical = replace(study, models={**study.models, "left": StudResidual(predamage="fire")})
    refused = store_of(mechanical, tmp_path / "other")
    assert not refused.ok("strength left", "left")
