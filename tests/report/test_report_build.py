"""The report as a whole: repeatable, self-contained, complete, and honest about what is missing."""

from __future__ import annotations

import re
import shutil
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from pages import views

from workbench.base.errors import InputError, WorkbenchError
from workbench.models.base import make_model
from workbench.report.build import build_report, document
from workbench.report.chapters.configuration import checks
from workbench.report.explorer import explorer
from workbench.report.page.documents import render_html
from workbench.report.page.terminal import render_text
from workbench.study import assess
from workbench.study.assessor import read_assessment


class Page(HTMLParser):
    """Tags with their attributes, and the text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def html(built) -> str:
    return built["html"].read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(html) -> Page:
    return Page(html)


def files_of(directory: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(directory)): path.read_bytes()
        for path in sorted(directory.rglob("*"))
        if path.is_file()
    }


@pytest.mark.thorough
def test_equal_stores_give_equal_bytes(built, small, tmp_path):
    again = build_report(small, out=tmp_path / "elsewhere")
    first, second = files_of(built["html"].parent), files_of(again["html"].parent)
    assert first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name]] == []
    assert first["report.pdf"].startswith(b"%PDF")


def test_what_the_assessment_has_read_is_not_read_again(small, tmp_path):
    shutil.copytree(small.directory, tmp_path / small.study.name)
    assessment = assess(small.study, tmp_path)
    for path in assessment.directory.glob("cells/*.nc"):
        path.unlink()
    assert explorer(small.study, assessment) == explorer(small.study, small)
    with pytest.raises(WorkbenchError, match="cannot be read"):
        explorer(small.study, read_assessment(assessment.directory, small.study))


@pytest.fixture(scope="module")
def sweep_html(sweep, tmp_path_factory) -> dict[str, Path]:
    out = tmp_path_factory.mktemp("sweep")
    return build_report(sweep, formats=("html",), out=out)


@pytest.mark.thorough
def test_only_the_formats_asked_for_are_written(sweep, sweep_html, tmp_path):
    assert set(sweep_html) == {"figures", "html", "explorer"}
    assert not (sweep_html["html"].parent / "report.pdf").exists()
    with pytest.raises(InputError, match="--format"):
        build_report(sweep, formats=("docx",), out=tmp_path)


def test_nothing_is_loaded_from_outside(html, page):
    for tag, attributes in page.tags:
        assert tag not in ("link", "iframe", "img", "object", "embed")
        for name in ("src", "srcset", "data", "poster"):
            assert name not in attributes
        for name in ("href", "xlink:href"):
            assert (attributes.get(name) or "#").startswith(("#", "explorer.html"))
    assert "@import" not in html
    assert not re.search(r"url\((?!#)", html)
    assert "http://" not in html
    assert "https://" not in html


def test_ids_are_unique_and_links_lead_somewhere(page):
    ids = Counter(attributes["id"] for _, attributes in page.tags if "id" in attributes)
    assert [key for key, times in ids.items() if times > 1] == []
    for _, attributes in page.tags:
        target = attributes.get("href")
        if target and target != "explorer.html":
            assert target[1:] in ids, target


def test_the_explorer_stands_beside_the_report(page, built):
    assert [a["href"] for _, a in page.tags if a.get("href") == "explorer.html"]
    beside = (built["html"].parent / "explorer.html").read_text(encoding="utf-8")
    assert '<a href="report.html">' in beside


def test_names_are_escaped(html, page):
    assert "<b>closed" not in html
    assert "<i>single" not in html
    assert "&lt;i&gt;single &amp; dof" in html
    text = "".join(page.text)
    assert "Small <study> of an impacted column" in text
    assert "A half sine & a cubic <curve>; no mechanics." in text


def test_tables_can_be_sorted_by_what_they_show(page):
    heads = [attributes for tag, attributes in page.tags if tag == "th"]
    assert len(heads) > 30
    assert all(attributes.get("aria-sort") == "none" for attributes in heads)
    numbers = [a for t, a in page.tags if t == "td" and "number" in (a.get("class") or "")]
    sortable = [float(a["data-sort"]) for a in numbers if "data-sort" in a]
    assert len(sortable) > 0.7 * len(numbers)


def test_every_figure_of_the_study_is_there(page, small, built):
    ids = {attributes.get("id") for tag, attributes in page.tags if tag == "figure"}
    expected = {f"plot-{figure.key}" for figure in small.study.figures}
    assert ids == expected | {"plot-convergence", "plot-cost"}
    assert sum(tag == "svg" for tag, _ in page.tags) == len(ids)
    for figure in small.study.figures:
        for suffix in ("svg", "csv"):
            assert (built["figures"] / f"{figure.key}.{suffix}").stat().st_size > 100


def test_failures_are_told(page):
    text = " ".join("".join(page.text).split())
    assert "3 cells of 28 hold no answer" in text
    assert "residual 0.00032; tried halving the step 12 times" in text
    assert "No answer from breaks: 15 metres per second, 20 metres per second." in text
    assert "Without deformed shape: estimate." in text


def test_shear_beyond_the_resistance_is_told(page):
    text = " ".join("".join(page.text).split())
    assert "In 3 of 3 cases the shear force exceeds the plastic shear resistance" in text
    assert "up to V/Vpl = 1.80" in text
    assert "the reference included, is outside its domain" in text


def test_references_are_exactly_those_cited(html, page):
    listed = {
        attributes["id"]
        for tag, attributes in page.tags
        if tag == "li" and (attributes.get("id") or "").startswith("ref-")
    }
    cited = set(re.findall(r'href="#(ref-[^"]+)"', html))
    assert listed == cited
    assert {"ref-heng2017", "ref-celik2008", "ref-sprague-geers"} <= listed


def test_no_section_is_empty(html):
    assert not re.search(r"<h(\d)>[^<]*</h\1>\s*</section>", html)
    assert not re.search(r"<tbody>\s*</tbody>", html)


def test_all_cases_can_be_run_again_from_the_report(page, small):
    import tomllib

    from workbench.scenarios import scenario_from

    text = "".join(page.text)
    listings = re.findall(r'kind = "column-.*?(?=\n\n\n|\n\s*\n\s*\S+ metres|$)', text, re.DOTALL)
    assert len(listings) >= 1
    first = tomllib.loads(listings[0].split("\n\n\n")[0])
    assert scenario_from(first) == small.study.cases[0].scenario


def test_a_study_that_was_not_assessed_is_refused(small, tmp_path):
    with pytest.raises(InputError, match="run it first"):
        build_report(read_assessment(tmp_path, small.study), out=tmp_path / "out")


def test_models_that_were_not_asked_are_told(small):

    from workbench.models.column_of_frame import ColumnOfFrame
    from workbench.report.chapters.limits import missing

    models = {**small.study.models, "frames only": ColumnOfFrame()}
    wider = replace(small.study, models=models)
    asked = {name for (label, _), names in wider.unsupported().items() for name in names
             if label == "frames only"}  # fmt: skip
    assert asked == {case.name for case in wider.cases if not case.models}
    last = views(missing(wider, read_assessment(small.directory, wider)))[-1]
    assert any("frames only (model column-of-frame) does not answer" in t for t in last.items)


@pytest.mark.thorough
def test_cells_that_never_ran_are_told(small, tmp_path):

    from synthetic_study import Synthetic

    from workbench.report.chapters.limits import missing

    peaks = tuple(figure for figure in small.study.figures if figure.kind == "peaks")
    models = {**small.study.models, "late": Synthetic(gain=2.0)}
    wider = replace(small.study, models=models, figures=peaks)
    stored = read_assessment(small.directory, wider)
    assert stored.cells["push", "late"].outcome == "not run"
    tables = views(missing(wider, stored), "table")
    rows = [cell.text for table in tables for row in table.rows for cell in row]
    assert "late" in rows
    assert any("has not been run" in text for text in rows)
    written = build_report(read_assessment(small.directory, wider), formats=("html",), out=tmp_path)
    assert "No answer from late" in written["html"].read_text(encoding="utf-8")


def test_findings_come_back_from_the_table(small):
    findings = small.cells["10 metres per second", "four-dof"].findings
    assert [finding.subject for finding in findings] == ["shear"]
    assert findings[0].text.endswith("V/Vpl = 1.80; no shear model")


def test_long_tables_are_cut_on_paper_only(sweep_html):
    text = sweep_html["html"].read_text(encoding="utf-8")
    assert text.count('<tr class="screen-only">') > 10
    assert "more rows are in the electronic report" in text
    assert "is not refined in this study" in text
    assert "sets no acceptance gates" in text


def test_what_is_folded_stands_on_the_screen_and_not_on_paper(small) -> None:
    whole = document(small.study, small, [])
    folded = [view for view in views(whole.text, "section") if view.folded]
    assert {"asked", "numbers", "gate-reasons"} <= {section.key for section in folded}
    html = render_html(whole)
    assert html.count('<details class="fold screen-only">') == len(folded)
    paper = replace(whole, on_paper=True)
    seen = [view for part in paper.sections for view in views(part)]
    assert not [view for view in seen if view.folded]
    assert all(section.title in seen[-1].text for section in folded)


def test_checks_are_those_of_what_the_study_used(small):
    ours = {**small.study.models, "ours": make_model("four-dof")}
    text = render_text(checks(replace(small.study, models=ours), small))
    assert "static force off fig. 5.8" in text
    assert "`model:four-dof` rests on (Heng, P. 2017)" in text
    assert "`model:synthetic`" in text.partition("Without an independent check")[2]
    assert "biggs" not in text
