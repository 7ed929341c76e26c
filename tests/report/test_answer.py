"""The first page: one matrix, its words, and the same nodes in every renderer."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from builders import MOST_WORDS, portal, words_in_sight
from pages import View, assessment, views
from synthetic_study import Synthetic, store_of, sweep_study
from toy_models import Spring

from workbench.models.base import model_names
from workbench.report.build import build_report, document, summary
from workbench.report.chapters.answer import (
    answer,
    decisive,
    in_brief,
    in_labels,
    matrix,
    matrix_rows,
)
from workbench.report.chapters.configuration import hit_distance, subject
from workbench.report.chapters.results import numbers
from workbench.report.drawing.sheet import Request
from workbench.report.drawing.style import looks
from workbench.report.figures import draw
from workbench.report.page.terminal import render_text
from workbench.responses import Finding
from workbench.scenarios import FrameImpact, FrameStriker
from workbench.study import Case
from workbench.study.assessor import Assessment, CellState
from workbench.study.definition import holds_data


@pytest.fixture(scope="module")
def stored(tmp_path_factory) -> Assessment:
    """A sweep in two groups: models 1 and 30 % off, one of them outside its domain when hit low."""
    study = sweep_study()
    low, middle = (
        tuple(c.name for c in study.cases if c.name.startswith(f"HEB 160, {position}"))
        for position in ("0.1", "0.5")
    )
    cases = tuple(case for case in study.cases if case.name in low + middle)
    models = {
        "close": Synthetic(gain=1.01, warns=False),
        "off": Synthetic(gain=0.7, fails_above=22.0),
        "reference": Synthetic(warns=False),
    }
    groups = {"hit low": low, "hit at mid-height": middle}
    study = replace(
        study, name="grouped", cases=cases, models=models, groups=groups, ladder=("reference",)
    )
    return store_of(study, tmp_path_factory.mktemp("grouped"))


@pytest.fixture(scope="module")
def ranked(stored: Assessment, tmp_path_factory) -> Assessment:
    """The same cases against two references, both outside their domain where the hit is low."""
    models = {
        "close": Synthetic(gain=1.01, warns=False),
        "web": Synthetic(gain=2.0, fails_above=12.0),
        "reference": Synthetic(),
    }
    study = replace(stored.study, name="ranked", models=models, references=("web", "reference"))
    return store_of(study, tmp_path_factory.mktemp("ranked"))


def table_of(stored: Assessment) -> View:
    (table,) = views(matrix(stored.study, stored), "table")
    return table


def test_a_cell_says_bias_cases_and_domain(stored: Assessment) -> None:
    table = table_of(stored)
    assert table.titles == ["model", "hit low", "hit at mid-height", "time / reference"]
    reference, close, off = table.rows
    assert reference[0].text == "reference"
    assert (reference[1].text, reference[1].more[:7]) == ("reference", "4 cases")
    assert close[1].text == "+1.0 (+1.0…+1.0)"
    assert (close[1].tone, close[1].hatched) == ("doubt", False)  # of unknown uncertainty
    assert off[1].text.endswith(", 1 failed")  # one line, the rest where a pointer rests
    assert off[1].more.endswith("4 cases, all outside its domain")
    assert (off[1].tone, off[1].hatched, off[2].hatched) == ("bad", True, False)


def test_models_that_may_be_relied_on_are_named_first(stored: Assessment) -> None:
    first = views(matrix(stored.study, stored))[0]
    # no uncertainty of the reference is known: nobody knows whether 1 % is within 10 %
    groups = "hit low; hit at mid-height: "  # a sentence for both: the same is said of them
    nearest = "nearest is close (off by up to 1\u2009%, numerical error not known)"
    assert first.items[0].startswith(f"{groups}{nearest}; no model is shown to be within 10\u2009%")


@pytest.mark.thorough
@pytest.mark.parametrize("reference_falls", [False, True])
def test_a_model_that_errs_on_collapse_or_fails_is_neither_green_nor_taken(
    toy_study, tmp_path, reference_falls: bool
) -> None:
    """All are 1 % off where they answer; at 20 m/s one collapses and one does not converge."""
    ends = {"trouble": "collapse"} if reference_falls else {}
    models = {
        "stands": Spring(error=0.01),
        "falls": Spring(error=0.01, trouble="collapse"),
        "breaks": Spring(error=0.01, trouble="solver"),
        **{f"mesh {n}": Spring(error=0.08, level=n, **ends) for n in range(4)},
    }
    study = replace(
        toy_study, models=models, reference="mesh 3", ladder=tuple(models)[3:], quick_models=()
    )
    stored = store_of(study, tmp_path)
    tones = {row[0].text: row[1].tone for row in table_of(stored).rows}
    wrong, right = ("stands", "falls") if reference_falls else ("falls", "stands")
    assert (tones[right], tones[wrong]) == ("good", "bad")
    text = views(matrix(study, stored), "bullets")[0].items[0]
    assert text.startswith(f"all cases: {right}, peak within 2\u2009% of mesh 3 in 3 cases")
    assert not re.search(rf"{wrong}|breaks", text)


def test_every_form_of_frame_is_named_with_its_hits() -> None:
    low, high = (portal(height=height) for height in (3.0, 4.0))
    hits = [
        FrameImpact("a", low.split("A0-A1", 1.0, "hit"), FrameStriker(500.0, 5.0, node="hit"), 0.1),
        FrameImpact("b", low.split("A0-A1", 2.0, "hit"), FrameStriker(500.0, 9.0, node="hit"), 0.1),
        FrameImpact("c", high.split("B0-B1", 2.5, "hit"), FrameStriker(80.0, 7.0, node="hit"), 0.1),
    ]
    cases = tuple(Case(hit.name, hit) for hit in hits)
    study = replace(sweep_study(), cases=cases, groups={"low": ("a", "b"), "high": ("c",)})
    (finding,) = views(subject(study))
    first, second = str(finding).split("; ")
    assert "3 m high of 4 members" in first
    assert "hit 1 m, 2 m above the ground, by a rigid striker of 500 kg at 5 and 9 m/s" in first
    assert "4 m high of 4 members" in second
    assert "hit 2.5 m above the ground, by a rigid striker of 80 kg at 7 m/s" in second
    # squares of 0.2 m, hit 1 m from base and head, and 1.5 m from the head
    assert hit_distance(study, "low") == "5 section heights"
    assert hit_distance(study, "high") == "7.5 section heights"
    assert hit_distance(replace(sweep_study(), groups={"x": ()}), "x") == ""


def test_the_first_page_says_what_is_hit_and_whether_it_stands(stored: Assessment) -> None:
    page = answer(stored.study, stored, [])
    text = " ".join(view.text for view in views(page, "paragraph"))
    assert "What is hit: HEB 160" in text
    assert "by a rigid striker of" in text
    assert "m/s" in text
    assert ("No structure collapses" in text) == (
        not any(cell.collapse for cell in stored.cells.values())
    )


def test_models_of_the_registry_are_named_as_the_study_calls_them(stored: Assessment) -> None:
    name = stored.study.models["close"].name
    label = next(iter(stored.study.models))
    finding = Finding("any", "a text", instead=(name, f"{name}-more"))
    assert in_labels(stored.study, finding).remedy == f"take {name} ({label}) or {name}-more"
    assert in_labels(stored.study, Finding("any", "a text", remedy="wait")).remedy == "wait"


def test_a_reference_outside_its_domain_can_neither_clear_nor_condemn(ranked: Assessment) -> None:
    first = views(matrix(ranked.study, ranked))[0]
    low = "hit low: not known, as no reference is inside its domain; "
    assert first.items[0].startswith(f"{low}nearest is close (off by up to 50")
    close = table_of(ranked).rows[2]
    assert close[0].text == "close"
    assert "all with the reference outside its own" in close[1].more
    assert [close[1].tone, close[2].tone] == ["doubt", "bad"]


def test_a_map_holds_every_case_against_the_reference_that_counts(ranked: Assessment) -> None:
    study = ranked.study
    chosen = Request(study, study.figures[0], ranked, study.cases, ("close",), looks(study))
    drawing = draw(chosen)
    assert drawing.canvas is not None
    assert "against the best reference" in drawing.statements[0]
    data = drawing.data.set_index("case")
    held = {name: data.loc[f"HEB 160, 0.5 L, {name} mps", "against"] for name in ("10", "20")}
    assert held == {"10": "web", "20": "reference"}
    written = {text.get_text() for panel in drawing.canvas.axes for text in panel.texts}
    assert written == {"\u221250", "+1"}  # in whole percent, in the fields


def test_numbers_stand_with_what_is_known_of_them(small: Assessment, ranked: Assessment) -> None:
    case = small.study.cases[0].name
    width = small.number(case, "reference", "peak_displacement_uncertainty")
    assert width == pytest.approx(small.ladder(case, "peak_displacement")["uncertainty"])
    assert small.number(case, "four-dof", "peak_displacement_uncertainty") is None  # no mesh
    tables = views(numbers(small.study, small), "table")
    table = next(table for table in tables if table.key.endswith("peak_displacement"))
    by_label = {row[0].text: row[1].text for row in table.rows}
    assert re.fullmatch(r"[\d.]+ ± [\d.]+", by_label["reference"])
    assert re.fullmatch(r"[\d.]+\s[+\u2212][\d.]+ ± [\d.]+\u2009%", by_label["four-dof"])
    # of several references the one that counts in a case
    table = views(numbers(ranked.study, ranked), "table")[0]
    assert "governing reference" in table.text
    row = next(row for row in table.rows if row[0].text == "HEB 160, 0.5 L, 20 mps")
    assert "\u2009%" in row[1].text  # close, against the reference
    assert "\u2009%" not in row[-1].text


def test_the_top_of_a_report_counts_models_and_says_what_a_quick_form_lacks(
    small: Assessment,
) -> None:
    models = {**small.study.models, "solid": Spring()}
    quick = replace(small.study, name="small-quick", whole=replace(small.study, models=models))
    form, counted, _ = document(quick, small, []).facts
    assert form == f"Quick form: without 1 model of {small.study.name}"
    data = [label for label, model in quick.models.items() if holds_data(model)]
    assert f", {len(quick.models) - len(data)} models" in counted
    texts = [view.text for view in views(matrix(small.study, small), "paragraph")]
    names = [text for text in texts if "Names at the command" in text]
    assert len(names) == any(
        label != model.name and model.name in model_names()
        for label, model in small.study.models.items()
    )


@pytest.mark.thorough
def test_every_renderer_shows_the_same_cells(stored: Assessment, tmp_path) -> None:
    files = build_report(stored, out=tmp_path)
    html = files["html"].read_text(encoding="utf-8")
    page = summary(stored, tmp_path / "kept").read_text(encoding="utf-8")
    text = render_text(in_brief(stored.study, stored))
    assert files["pdf"].read_bytes().startswith(b"%PDF")
    for cell in (cell for row in table_of(stored).rows for cell in row):
        texts = re.escape(cell.text.split("\n")[0])
        assert all(re.search(texts, shown) for shown in (html, page, text)), cell.text
    assert '<td class="bad hatched"' in html
    assert "❌ ▨ " in page
    assert html.index('id="plot-map"') < html.index('id="table-matrix"') < html.index("<nav")
    assert html.count('id="plot-map"') == 1  # not again among the results
    assert html.index("<nav") < html.index('id="verdicts"')


def test_the_decisive_figure_is_named_or_the_first_over_cases(stored: Assessment, small) -> None:
    assert decisive(stored.study) == "map"
    assert decisive(small.study) == "peaks"
    assert decisive(replace(small.study, decisive="shape")) == "shape"


def test_an_error_that_is_measured_is_no_hatching(stored: Assessment) -> None:
    """The error model warns of 30 %, and the study measures it: no matter of the domain."""
    rows = [{**row, "outside": 0, "warned": row["answered"]} for row in stored.records("matrix")]
    rows = [row for row in rows if row["label"] == "off"]
    warned = assessment(matrix=rows)
    cell = matrix_rows(warned)[0].cells["hit low"]
    assert (cell.tone, cell.hatched) == ("bad", False)
    assert "all warned of by the error model" in cell.details
    at_fault = Finding("error", "expect -30 %", number=0.9)
    physics = Finding("shear", "V/Vpl = 1.79", number=1.79)
    state = CellState("a", "b", "ok", "", (at_fault, physics), {}, "")
    assert state.outside == (physics,)


def test_the_first_page_begins_with_a_picture_and_is_short(stored: Assessment, tmp_path) -> None:
    html = build_report(stored, out=tmp_path)["html"].read_text(encoding="utf-8")
    page = html[html.index("<header") : html.index("<nav")]
    body = page[page.index("<h2") :]
    assert body.index("<figure") < body.index("<p>")
    assert words_in_sight(html) <= MOST_WORDS


@pytest.mark.thorough
def test_many_models_stay_one_click_away(stored: Assessment, tmp_path) -> None:
    """Eight rows stand in sight, those to rely on first; paper and terminals have all."""
    models = {f"spare {i}": Synthetic(gain=0.7, warns=False) for i in range(8)}
    study = replace(stored.study, name="many", models={**models, **stored.study.models})
    many = store_of(study, tmp_path)
    labels = [row[0].text for row in table_of(many).rows]
    assert labels[0] == "reference"
    assert len(labels) == 11
    html = build_report(many, ("html",), tmp_path / "out")["html"].read_text(encoding="utf-8")
    (table,) = re.findall(r'id="table-matrix".*?</div>\s*<section', html, re.DOTALL)
    seen, folded = table.split("<details><summary>3 more</summary>")
    assert [seen.count("<tr>"), folded.count("<tr>")] == [1 + 8, 1 + 3]
    assert '<td class="bad" data-sort="0.7" title="\u221230 (\u221230…\u221230)' in table
    assert words_in_sight(html) <= MOST_WORDS


def test_cases_without_a_peak_make_no_matrix(small, tmp_path) -> None:
    push = tuple(case for case in small.study.cases if case.scenario.STATIC)
    study = replace(small.study, name="pushed", cases=push, gates=(), figures=())
    result = store_of(study, tmp_path)
    assert not matrix(study, result)
    first = document(study, result, []).sections[0]
    assert (first.key, len(first.blocks)) == ("answer", 1)


def test_reasons_stand_once_for_all_gates_alike(small) -> None:
    whole = document(small.study, small, [])
    (gates,) = (s for s in whole.sections if s.key == "verdicts")
    values = [pair for view in views(gates, "definitions") for pair in view.pairs]
    assert ("gates 1 to 5", "a tenth is what design can absorb [@heng2017]") in values
    assert len(views(answer(small.study, small, ()), "table")) == 1
