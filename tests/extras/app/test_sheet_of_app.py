"""Files that the page saves: one page always, numbers of the command line, hostile names."""

from __future__ import annotations

import io
import json
import re
import sys
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import workbench as wb
from workbench.api.accessor import as_object, blocks_of, table_blocks
from workbench.base.errors import InputError
from workbench.cli import run
from workbench.extras.app import sheet
from workbench.report.page.documents import html_of_blocks, render_markdown, typst_source
from workbench.report.page.formatting import in_unit
from workbench.report.page.markdown import paragraph
from workbench.scenarios import ColumnImpact, Scenario, Striker, to_toml

COLUMN = wb.Column("HEB 220", 0.8, 3.2, axial_load="500 kN")
QUICK = ["four-dof", "single-dof", "energy-estimate"]
HOSTILE = [
    '<script>alert(1)</script> & "quotes"',
    '#panic("x") $x$ *b* _i_ ] [#set page(width: 1pt)] \\',
    "שלום عربي \u202e txt",
    "W" * 200,
    "long " * 39 + "name",
]


def hit(velocity: float | str = 5.0, name: str = "hit", **more: Any) -> ColumnImpact:
    return ColumnImpact(name, COLUMN, Striker(1500.0, velocity, **more))


def frame() -> Scenario:
    bays = wb.regular_frame([5.0] * 2, [3.5] * 3, "HEB 200", "IPE 300")
    return wb.impact(bays.split("A0-A1", 1.2, "hit"), 1500, 8, node="hit", name="2 bays, 3 storeys")


STRUCTURES = {
    "survives": (lambda: hit("54 km/h"), QUICK),
    "collapses": (lambda: hit(80.0), QUICK[:2]),
    "oblique": (lambda: hit(8.0, angle="30 deg"), ["seven-dof", "superelement-space", "four-dof"]),
    "frame": (frame, ["column-of-frame", "plastic-hinge"]),
    "blast": (
        lambda: wb.MemberPulse("blast", COLUMN, wb.Pulse("triangular", 2e5, 0.01), "uniform", 0.05),
        ["flexible-superelement"],
    ),
    "pushed": (lambda: wb.ColumnPushover("pushed", COLUMN, 0.1), ["four-dof"]),
    "warned": (
        lambda: wb.impact(wb.Column("IPE 120", 0.06, 3.9, axial_load="50 kN"), 5e4, "20 km/h"),
        [*QUICK, "seven-dof", "soft-impact", "biggs"],
    ),
    "refused": (lambda: hit(8.0, angle="30 deg"), ["four-dof"]),
}


def asked(scenario: Scenario, models: list[str]) -> dict[str, Any]:
    return {name: wb.simulate(scenario, name) for name in models}


def pages(pdf: bytes) -> int:
    return len(re.findall(rb"/Type ?/Page\b", pdf))


@pytest.fixture
def words(monkeypatch: pytest.MonkeyPatch) -> Any:
    """What a sheet says, as Markdown; its Typst code after it."""

    def said(*arguments: Any, **options: Any) -> tuple[str, str]:
        documents: list[Any] = []
        with monkeypatch.context() as patched:
            patched.setattr(sheet, "render_pdf", documents.append)
            sheet.one_page(*arguments, **options)
        return render_markdown(documents[0]), typst_source(documents[0])

    return said


@pytest.fixture(scope="module")
def answers() -> dict[str, Any]:
    return asked(hit(), QUICK)


@pytest.mark.thorough
@pytest.mark.parametrize("name", STRUCTURES)
def test_every_structure_takes_one_page(name: str) -> None:
    make, models = STRUCTURES[name]
    scenario = make()
    responses = asked(scenario, models)
    pdf = sheet.one_page(scenario, responses, models[-1])
    assert pages(pdf) == 1
    assert pdf == sheet.one_page(scenario, responses, models[-1])
    assert b"scenario.toml" in pdf  # attached


@pytest.mark.parametrize("name", HOSTILE)
def test_names_are_never_read_as_markup(name: str) -> None:
    scenario = hit(name=name)
    responses = asked(scenario, QUICK[:1])
    assert pages(sheet.one_page(scenario, responses, more=[paragraph(name)] * 3)) == 1
    fragment = html_of_blocks(*blocks_of_all(scenario, responses))
    assert "<script" not in fragment
    assert "<button" not in fragment  # that sorts, by the script of reports
    assert "<script" not in sheet.picture(scenario, responses, "history", "svg").decode()


def blocks_of_all(scenario: Scenario, responses: dict[str, Any]) -> list[Any]:
    first = next(iter(responses.values()))
    answer = as_object(first, scenario)
    told = blocks_of(first, scenario.name, answer, full=True)
    return [*told, *table_blocks(scenario.name, responses)]


def test_the_sheet_shrinks_what_is_too_long(answers: dict[str, Any]) -> None:
    more = [paragraph("A long remark on the drawing and the site. " * 12)] * 14
    assert pages(sheet.one_page(hit(), answers, more=more)) == 1


def test_the_sheet_says_the_numbers_of_the_command_line(
    words: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scenario.toml"
    file.write_text(to_toml(hit()))
    assert run(["simulate", str(file), "--model", "four-dof", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    text, source = words(hit(), asked(hit(), ["four-dof"]))
    for name in ("peak_displacement", "time_of_peak", "residual_displacement", "peak_force"):
        assert in_unit(told[name], name) in text
    assert told["headline"] in text
    assert all(each["sentence"] in text for each in told["warnings"])
    assert all(note in text for note in told["notes"])
    assert told["provenance"]["scenario_hash"] in source  # stands at the foot
    assert told["provenance"]["workbench"] in source


def test_a_warning_of_several_models_stands_once(words: Any) -> None:
    responses = asked(hit("54 km/h"), QUICK)
    text, _ = words(hit("54 km/h"), responses)
    assert text.count("close to collapse") == 1
    assert f"warning of {', '.join(QUICK)} (close-to-collapse)" in text


def test_a_refusal_says_why_and_a_picture_that_is_empty_too(words: Any) -> None:
    text, _ = words(hit(8.0, angle="30 deg"), asked(hit(8.0, angle="30 deg"), ["four-dof"]))
    assert "no answer, out-of-domain" in text
    assert "seven-dof answers hits in any direction" in text
    assert "No answer from four-dof" in text


def test_the_reference_stands_beside_the_first(words: Any, answers: dict[str, Any]) -> None:
    text, _ = words(hit(), answers, "single-dof")
    assert "by single-dof, a reference" in text
    with pytest.raises(InputError, match="must hold an answer"):
        sheet.one_page(hit(), {})


def test_histories_are_read_back(answers: dict[str, Any]) -> None:
    labelled = {"=cmd()": answers["four-dof"], **answers}
    table = pd.read_csv(io.StringIO(sheet.histories_csv(labelled)))
    assert list(table.columns[:3]) == ["label", "time_s", "displacement_m"]
    assert set(table["label"]) == {"'=cmd()", "four-dof", "single-dof"}  # the third has none
    of_one = table[table["label"] == "four-dof"]
    known = answers["four-dof"]
    assert of_one["displacement_m"].to_numpy() == pytest.approx(known["displacement"].to_numpy())
    impulse = of_one["percussion_N_s"].sum()
    assert impulse == pytest.approx(float(known["impulse"]), rel=1e-6)
    assert of_one["contact_force_N"].max() == pytest.approx(float(known["peak_force"]), rel=0.05)
    assert sheet.histories_csv({}) == "label,time_s\n"


def test_forces_over_displacements_have_steps() -> None:
    pushed = wb.ColumnPushover("pushed", COLUMN, 0.1)
    table = pd.read_csv(io.StringIO(sheet.histories_csv(asked(pushed, ["four-dof"]))))
    assert {"step", "displacement_m", "force_N"} <= {*table.columns}


@pytest.mark.parametrize("ending", ["svg", "png"])
def test_pictures_are_equal_bytes(answers: dict[str, Any], ending: str) -> None:
    drawn = sheet.picture(hit(), answers, "history", ending, quantity="velocity")
    assert drawn[:4] == {"svg": b"<svg", "png": b"\x89PNG"}[ending]
    assert drawn == sheet.picture(hit(), answers, "history", ending, quantity="velocity")
    with pytest.raises(InputError, match="ending"):
        sheet.picture(hit(), answers, "history", "exe")
    with pytest.raises(InputError, match=r"figure\.kind"):
        sheet.picture(hit(), answers, "../secret", ending)


@pytest.mark.thorough
def test_a_sweep_is_one_file_with_a_slider(tmp_path: Path) -> None:
    given = "striker.velocity", [5.0, 10.0, 15.0], ["four-dof", "single-dof"]
    page = sheet.sweep_page(hit(name="<b>"), *given, folder=tmp_path)
    assert page == sheet.sweep_page(hit(name="<b>"), *given, folder=tmp_path)
    assert "velocity (km/h)" in page
    assert '"stops":["18","36","54"]' in page
    shown = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert "&lt;b&gt;" in shown
    assert "<b>" not in shown
    assert "report.html" not in shown
    assert not re.findall(r'(?:src|href)="http', shown)
    with pytest.raises(InputError, match=r"striker\.velocity"):
        sheet.sweep_page(hit(), "striker.velocity", [-5.0, 5.0], ["four-dof"])


def test_explore_is_public_and_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "explore" in dir(wb)
    monkeypatch.setitem(sys.modules, "panel", None)
    with pytest.raises(InputError, match=r"needs panel.*steel-impact-workbench\[app\]"):
        wb.explore(hit())


@pytest.mark.thorough
def test_explore_shows_the_page_of_a_scenario(monkeypatch: pytest.MonkeyPatch) -> None:
    panel = pytest.importorskip("panel")
    from workbench.extras.app import desk

    opened: list[Any] = []

    class Noted(desk.Desk):
        def __init__(self) -> None:
            super().__init__()
            opened.append(self)

    monkeypatch.setattr(desk, "Desk", Noted)
    try:
        view = wb.explore(hit(7.25))
        assert isinstance(view, panel.viewable.Viewable)
        told = [group for part in view.select() for group in getattr(part, "groups", ())]
        assert "7.25" in str(told)  # the velocity, in the form
    finally:
        for each in opened:
            each.close()
