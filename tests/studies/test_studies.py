"""The studies that come with the workbench load, fit together and ask what their titles say."""

from __future__ import annotations

import re
import subprocess
import sys
from functools import cache
from math import ceil
from pathlib import Path

import pytest
from builders import MOST_WORDS, words_in_sight

from workbench.cli import run
from workbench.report.drawing.style import looks
from workbench.report.figures import KINDS, check_kind
from workbench.responses.uncertainty import uncertainty_of
from workbench.study import Study, cells_of, load_study

STUDIES = Path(__file__).resolve().parents[2] / "studies"
FILES = sorted(STUDIES.glob("*.py"))


@cache
def shipped(name: str) -> Study:
    """A study that comes with the workbench, drawn and laid out once."""
    return load_study(str(STUDIES / f"{name}.py")).study


@pytest.mark.thorough
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_studies_load_and_their_quick_form_is_smaller(path: Path) -> None:
    study = shipped(path.stem)
    assert study.name == path.stem
    quick = study.quickened()
    assert 0 < len(list(quick.cells())) < len(list(study.cells()))
    assert bool(quick.gates) == bool(study.gates)  # a study that ranks judges nothing
    for figure in (*study.figures, *quick.figures):
        check_kind(figure.kind)
        named = {*figure.options.get("cases", ()), figure.options.get("case", "")} - {""}
        assert named <= {case.name for case in study.cases}


@pytest.mark.slow
def test_references_of_pulses_are_closed() -> None:
    """Within 3 % of the peak; default meshes leave 5 and 29 % open here."""
    study = shipped("pulses")
    case = next(c for c in study.cases if c.name == "HEB 220 clamped, point, 10 T, ductility 3")
    for label in study.references:
        answer = study.models[label].simulate(case.scenario)
        width = uncertainty_of(answer, "peak_displacement")
        assert width is not None
        assert width <= 0.03 * float(answer["peak_displacement"]), label


@pytest.mark.slow
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_first_pages_of_quick_forms_answer_in_a_picture(path: Path, tmp_path: Path) -> None:
    quick = [str(path), "--quick", "--store", str(tmp_path)]
    assert run(["run", *quick]) in (0, 1)  # gates may fail
    assert run(["report", *quick, "--format", "html"]) == 0
    html = (tmp_path / f"{path.stem}-quick" / "report" / "report.html").read_text("utf-8")
    page = html.split('id="answer"')[1].split("<section")[0]
    assert page.count("<svg") == 1
    assert "Not drawn" not in page
    assert re.search(r"\d\s%", re.sub("<[^>]*>", "", page))
    assert words_in_sight(html) <= MOST_WORDS


def indented(text: str, begin: str, end: str) -> str:
    """The block of code between two marks of a page."""
    block = text[text.index(begin) : text.index(end)]
    return "\n".join(line.removeprefix("    ") for line in block.splitlines())


def test_the_readme_says_of_the_flagship_what_its_summary_says() -> None:
    root = STUDIES.parent
    caption = " ".join((root / "README.md").read_text("utf-8").split("\n## Start")[0].split())
    page = (root / "reports" / "README.md").read_text("utf-8").replace("\u2009", " ")
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| ")]
    heads = next(row for row in rows if row[0] == "| model")
    near = ("flexible-superelement", "4-DOF with panels")
    taken = [next(row for row in rows if row[0].endswith(name)) for name in near]
    ends = [re.search(r"\((.*)…(.*)\)", row[2].replace("\u2212", "-")).groups() for row in taken]
    within = ceil(max(abs(float(end)) for pair in ends for end in pair))
    times = " and ".join(re.search(r"1/(\d+)000", row[-1])[0][:-3] + " 000" for row in taken)
    assert f"within {within} % from 10 to 20 m/s, in {times} of its time" in caption
    webs = ("solid", "web-yielding", *near, "energy with panels")
    low = [row for row in rows if len(row) == len(heads) and not row[0].startswith(webs, 2)]
    for columns, words in (((1, 2), "{} to {} % low in the mean"), ((4,), "{} to {} % with the")):
        cells = (re.search(r"\u2212(\d+) \(", row[column]) for row in low for column in columns)
        means = sorted(int(cell[1]) for cell in cells if cell)
        assert words.format(means[0], means[-1]) in caption


def test_the_study_of_the_guide_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    readme = (STUDIES.parent / "README.md").read_text(encoding="utf-8")
    guide = (STUDIES.parent / "docs" / "guide" / "study.md").read_text(encoding="utf-8")
    scenario = indented(readme, '    kind = "column-impact"', "Blasts, frames,")
    (tmp_path / "scenario.toml").write_text(scenario, encoding="utf-8")
    text = indented(guide, "    from workbench.study.assessment import Gate", "Kinds of figures:")
    (tmp_path / "mine.py").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    study = load_study("mine.py").study
    assert len(cells_of(study)) == 6
    assert {figure.kind for figure in study.figures} <= set(KINDS)
    kinds = guide[guide.index("Kinds of figures:") : guide.index("and more;")].split("`")[1::2]
    assert set(kinds) <= set(KINDS)


def test_published_numbers_are_asked_their_own_impacts() -> None:
    study = shipped("thesis_column")
    asked = 0
    for case in study.cases:
        if case.scenario.KIND == "column-impact":
            for model in (study.models[m] for m in case.models if m.startswith("Heng")):
                asked += 1
                assert model.domain(case.scenario) == []
    assert asked == 3 * 3 + 2


@pytest.mark.thorough
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_captions_of_the_quick_form_name_nothing_that_it_leaves_out(path: Path) -> None:
    study = shipped(path.stem)
    quick = study.quickened()
    gone = {*study.models} - {*quick.models}
    gone |= {case.name for case in study.cases} - {case.name for case in quick.cases}
    words = [text for f in quick.figures for text in (f.title, f.caption)]
    words += [gate.rationale for gate in quick.gates]
    values = {
        name for name in gone for text in words if re.search(rf"\bthe {re.escape(name)}\b", text)
    }
    assert not values


def test_the_flagship_has_a_reference_inside_its_domain_in_its_quick_form() -> None:
    quick = shipped("thesis_column").quickened()
    assert quick.ranked == ("web-yielding beam", "fiber beam")
    assert quick.decisive == "shear-peaks"


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_models_look_the_same_in_the_quick_form(path: Path) -> None:
    study = shipped(path.stem)
    whole, quick = looks(study), looks(study.quickened())
    kept = [label for label in quick if label != study.quickened().reference]
    assert {label: quick[label] for label in kept} == {label: whole[label] for label in kept}


def test_a_study_is_a_script_too() -> None:
    command = [sys.executable, str(STUDIES / "column_sweep.py"), "--help"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0
    assert "Usage" in done.stdout


def test_the_quick_form_says_what_it_leaves_out() -> None:
    study = shipped("thesis_column")
    quick = study.quickened()
    assert quick.notes[:-1] == study.notes
    assert quick.notes[-1].startswith(
        f"Quick form, {len(quick.gates)} of {len(study.gates)} gates."
    )
    for label in set(study.models) - set(quick.models):
        assert label in quick.notes[-1]
    assert quick.whole is study
    assert study.whole is None
    sweep = shipped("column_sweep").quickened()
    assert sweep.notes[-1].endswith("Left out: cases (69 of 81).")
