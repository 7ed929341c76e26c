"""The study of impact tests: validation over tests; synthetic rows can validate nothing."""

from __future__ import annotations

import csv
import re
import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pages import View, views
from scipy.stats import beta
from scipy.stats import t as student

from workbench.base.catalogue import dataset
from workbench.base.tables import plain_rows
from workbench.extras.intake.add import add_table
from workbench.report.build import build_report, document, summary
from workbench.report.chapters.answer import in_brief
from workbench.report.chapters.results import footnote
from workbench.report.page.documents import render_markdown
from workbench.report.page.terminal import show
from workbench.study import Study, load_study, run_study
from workbench.study.assessor import Assessment, assess, read_assessment

ROOT = Path(__file__).resolve().parents[3]
FILE = ROOT / "studies" / "impact_tests.py"
KEPT = ("SYNTHETIC rows", "tests", "4-DOF", "energy estimate")
MARK = "SYNTHETIC, no tests: "


def study_here(cases: int = 12) -> Study:
    """The study as its file defines it here, of two cheap models over its first cases."""
    whole: Study = runpy.run_path(str(FILE))["study"]
    names = {case.name for case in whole.cases[:cases]}
    return replace(
        whole,
        models={label: model for label, model in whole.models.items() if label in KEPT},
        cases=tuple(case for case in whole.cases if case.name in names),
        groups={g: tuple(n for n in of if n in names) for g, of in whole.groups.items()},
        gates=tuple(gate for gate in whole.gates if gate.model in KEPT),
        figures=tuple(
            replace(figure, models=("4-DOF", "energy estimate")) for figure in whole.figures
        ),
        quick_models=(),
    )


def ran(study: Study, store: Path) -> Assessment:
    run_study(study, store, jobs=0)
    return assess(study, store)


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("WORKBENCH_DATA", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def tested(empty: Path) -> dict[str, float]:
    """Six tests of two laboratories in the user's data: the shipped rows with other peaks."""
    rows = shipped()[6:]
    drawn, peaks = np.random.default_rng(3), {}
    for number, row in enumerate(rows):
        peak = float(row["peak_m"]) * float(np.exp(0.06 * drawn.normal()))
        campaign = "lab two" if number > 3 else "lab one"
        row |= {"campaign": campaign, "role": "validate", "peak_m": repr(peak), "source": "R"}
        row |= {"residual_m": repr(0.9 * peak)}
        row["peak_uncertainty_m"] = repr(4.0 * float(row["peak_uncertainty_m"]))
        peaks[f"{campaign} {row['specimen']}"] = peak
    with Path("lab.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    add_table(Path("lab.csv"), despite_doubts=True)
    return peaks


@pytest.mark.thorough
def test_synthetic_rows_judge_nothing_and_are_named_everywhere(
    empty: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = study_here(2)
    study = replace(study, figures=study.figures[:1])
    result = ran(study, empty)
    assert [v.verdict.value for v in result.verdicts] == ["inconclusive"] * 2
    for verdict in result.verdicts:
        assert {case.doubt for case in verdict.cases} == {"synthetic, shows the form only,"}
        assert verdict.reasons[0].startswith("synthetic, shows the form only, in 2 of 2 asked")
    # a bound that every number breaks fails no model either
    strict = replace(study, gates=tuple(replace(gate, bound=1e-9) for gate in study.gates))
    assert {v.verdict.value for v in assess(strict, empty).verdicts} == {"inconclusive"}
    assert all(row["synthetic"] for row in plain_rows(result.tables["validation"]))
    assert all(row["synthetic"] == 2 for row in plain_rows(result.tables["matrix"]))
    build_report(read_assessment(result.directory, study), formats=("html",))
    page = (result.directory / "report" / "report.html").read_text(encoding="utf-8")
    assert f"<h1>{MARK}Impacts" in page
    captions = re.findall(r"<((?:fig)?caption)\b[^>]*>(.*?)</\1>", page, re.DOTALL)
    assert len(captions) > 6
    for _, caption in captions:
        assert MARK.strip() in caption
    assert not re.findall(r'class="[^"]*\b(good|doubt|bad)\b[^"]*"[^>]*>[^<]*peak', page)
    assert "No model is validated or refuted by them" in page
    assert "No tests here: no measured impact on a steel member" in page
    beside = (result.directory / "report" / "explorer.html").read_text(encoding="utf-8")
    assert f"<h1>{MARK}Impacts" in beside
    assert "No model is validated or refuted by them" in beside
    assert not re.findall(r'<td class="[^"]*\b(good|doubt|bad)\b', beside)
    assert set(re.findall(r'"tone":"(\w*)"', beside)) == {""}
    assert len(re.findall(r'"model":"SYNTHETIC rows"[^{}]*"main":[^{}]*"width":', beside)) == 2
    front = summary(read_assessment(result.directory, study), empty / "git").read_text(
        encoding="utf-8"
    )
    assert front.startswith(f"# {MARK}")
    assert "no model is judged" in front
    matrix = [
        row
        for row in read_assessment(result.directory, study).records("matrix")
        if row["synthetic"]
    ]
    assert {row["label"] for row in matrix} == {"SYNTHETIC rows", "4-DOF", "energy estimate"}
    show(in_brief(study, read_assessment(result.directory, study)))
    output = capsys.readouterr().out
    assert output.startswith("SYNTHETIC rows, no tests: made numbers")
    assert f"{MARK}Error of the peak" in " ".join(output.split())


@pytest.mark.thorough
def test_measured_rows_give_bias_scatter_and_coverage(tested: dict[str, float]) -> None:
    study = study_here()
    assert study.reference == "tests"
    assert set(study.groups) == {"lab one", "lab two"}
    assert not any("SYNTHETIC" in case.name for case in study.cases)
    result = ran(study, Path("reports"))
    rows = {
        (row["model"], row["quantity"]): row
        for row in plain_rows(result.tables["validation"])
        if not row["synthetic"]
    }
    row = rows["energy estimate", "peak_displacement"]
    cells = {
        (cell["case"], cell["label"]): cell["peak_displacement"]
        for cell in plain_rows(result.tables["cells"])
    }
    ratios = np.array([peak / cells[n, "energy estimate"] for n, peak in tested.items()])
    lines = csv.DictReader(dataset("lab").path.read_text(encoding="utf-8").splitlines())
    widths = np.array([float(line["peak_uncertainty_m"]) for line in lines])
    assert (row["tests"], row["campaigns"]) == (6, 2)
    off = np.abs(1.0 / ratios - 1.0) * ratios * np.array([*tested.values()]) / widths
    inside = int(np.sum(off <= 1.0))
    assert 0 < inside < int(np.sum(off <= 2.0))
    assert (row["covered"], row["counted"]) == (inside, 6)
    low = beta.ppf(0.025, inside, 7 - inside) if inside else 0.0
    high = beta.ppf(0.975, inside + 1, 6 - inside) if inside < 6 else 1.0
    assert (row["coverage_low"], row["coverage_high"]) == pytest.approx((low, high), rel=1e-6)
    assert row["least"] == pytest.approx(ratios.min())
    assert row["measurement"] == pytest.approx(
        np.sqrt(np.mean((widths / np.array([*tested.values()])) ** 2)) / 1.96
    )
    assert ratios.min() < row["bias"] < ratios.max()
    assert row["low"] < row["bias"] < row["high"]
    verdicts = {verdict.verdict.value for verdict in result.verdicts}
    assert verdicts <= {"pass", "fail", "inconclusive"}
    assert not any(case.doubt for verdict in result.verdicts for case in verdict.cases)
    assert {row["against"] for row in plain_rows(result.tables["cost"])} <= {
        "4-DOF",
        "energy estimate",
    }
    assert "tests" not in {row["label"] for row in plain_rows(result.tables["cost"])}
    page = render_markdown(document(study, read_assessment(result.directory, study), []))
    assert "SYNTHETIC" not in page
    assert "No tests here: no measured impact" not in page
    assert "Models over tests" in page
    assert "Where the tests are from." in page
    # of one laboratory: Student's interval of the mean logarithm
    fewer = study_here(4)
    (row,) = (
        row
        for row in plain_rows(assess(fewer, Path("reports")).tables["validation"])
        if (row["model"], row["quantity"]) == ("energy estimate", "peak_displacement")
    )
    logs = np.log(ratios[:4])
    width = student.ppf(0.975, 3) * np.std(logs, ddof=1) / 2.0
    expected = np.exp([logs.mean(), logs.mean() - width, logs.mean() + width])
    assert [row["bias"], row["low"], row["high"]] == pytest.approx(expected, rel=1e-4)
    assert row["scatter"] == pytest.approx(np.std(logs, ddof=1), rel=1e-4)


def test_studies_of_impacts_without_tests_carry_the_footnote(empty: Path) -> None:
    def notes(name: str) -> list[View]:
        study = load_study(ROOT / "studies" / f"{name}.py").study
        stored = Assessment(empty, study, {"findings": pd.DataFrame({"subject": []})})
        return views(footnote(study, stored))

    (statements,) = notes("column_sweep")
    assert statements.text.startswith("No tests here: no measured impact on a steel member")
    assert "workbench data add" in statements.text
    assert notes("studs") == notes("cyclic_clamped_beam") == []


def shipped() -> list[dict[str, str]]:
    text = dataset("synthetic-impacts").path.read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def test_the_shipped_rows_are_those_of_their_script() -> None:
    script = runpy.run_path(str(ROOT / "data" / "impacts" / "make_synthetic.py"))
    named = {(row["campaign"], row["specimen"]): row for row in shipped()}
    assert list(named) == list(script["HITS"])
    for key, hit in script["HITS"].items():
        assert float(named[key]["velocity_m_per_s"]) == hit[-1]
        assert named[key]["section"] == hit[0]


@pytest.mark.slow
def test_the_script_makes_the_shipped_rows() -> None:
    script = runpy.run_path(str(ROOT / "data" / "impacts" / "make_synthetic.py"))
    for made, row in zip(script["rows"](), shipped(), strict=True):
        assert {name: str(value) for name, value in made.items()} == row
