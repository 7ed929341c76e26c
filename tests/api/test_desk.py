"""The workbench as a person writes it: examples run, collapse is an answer, pictures have axes."""

from __future__ import annotations

import doctest
import importlib
import re
import subprocess
import sys
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

import workbench as wb
from workbench.base.errors import InputError
from workbench.responses import Finding, Outcome
from workbench.steel.sections import find

ROOT = Path(wb.__file__).parent
PAGES, BEGIN = ("README.md", "docs/guide/python.md"), "    import workbench as wb"


@pytest.fixture(scope="module")
def column() -> Any:
    return wb.Column(
        "HEB 220", 0.8, 3.2, fillets=False, axial_load="500 kN", restraint_stiffness=1e7
    )


@pytest.fixture(scope="module")
def response(column: Any) -> Any:
    return wb.simulate(wb.impact(column, mass=1500, velocity=15), "four-dof", beta=1.3)


def test_the_top_level_is_light() -> None:
    heavy = ("numpy", "xarray", "pandas", "scipy", "numba", "matplotlib", "typer")
    code = f"import sys, workbench as wb; dir(wb); print([n for n in {heavy} if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there_and_is_no_room() -> None:
    rooms = {path.stem for path in ROOT.iterdir()}
    for name in wb.__all__:
        assert name not in rooms  # a module of that name would hide it once it is imported
        assert getattr(wb, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = wb.nothing


def test_examples_of_the_accessor_run() -> None:  # those of public names: test_public_api.py
    done = doctest.testmod(importlib.import_module("workbench.api.accessor"))
    assert done.attempted > 2
    assert done.failed == 0


@pytest.mark.thorough
@pytest.mark.parametrize("page", PAGES)
def test_the_python_of_the_pages_runs(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT.parent / page).read_text(encoding="utf-8")
    text = text[text.index(BEGIN) :]
    code = re.match(r"(?:(?:    .*)?\n)+", text)
    assert code is not None
    monkeypatch.chdir(tmp_path)
    exec(re.sub("(?m)^    ", "", code[0]), {})
    printed = capsys.readouterr().out.strip().replace("\u00a0", " ")
    if page == "README.md":
        assert f"    {printed}\n" in text
        assert (tmp_path / "history.png").stat().st_size > 10_000


def test_a_response_tells_what_it_knows(response: Any, column: Any) -> None:
    answer = response.workbench
    assert answer.outcome is Outcome.OK
    assert all(isinstance(each, Finding) for each in answer.findings)
    assert answer.scenario == wb.impact(column, mass="1.5 t", velocity="54 km/h")
    assert answer.number("peak_displacement") == float(response["peak_displacement"])
    assert np.isnan(answer.number("largest_drift"))
    with pytest.raises(InputError, match="did you mean peak_displacement"):
        answer.number("peak_displacment")
    assert answer.error.low is not None
    ends = 1.0 + np.array([answer.error.high, answer.error.low])
    least, most = 1e3 * answer.number("peak_displacement") / ends
    assert f"90 %: {least:.3g} to {most:.3g}; survives; by four-dof, as asked" in answer.headline
    assert "<dl" in answer._repr_html_()
    assert "HEB 220" in column._repr_html_()


def test_a_notebook_shows_pictures_by_themselves(response: Any) -> None:
    assert "<svg" in response.workbench.plot.history().figure._repr_svg_()


def test_a_grade_is_a_field_of_the_steel() -> None:
    with pytest.raises(InputError, match=r"write steel=wb\.Steel\(grade='S355'\)"):
        wb.Column("HEB 220", 0.8, 3.2, grade="S355")


def test_a_collapse_is_an_answer_without_numbers(column: Any) -> None:
    answer = wb.simulate(wb.impact(column, 1500, 80), "four-dof").workbench
    assert answer.outcome is Outcome.COLLAPSE
    assert answer.collapse.displacement > 0.0
    assert np.isnan(answer.number("peak_displacement"))
    assert "collapses: geometry (below)" in answer.headline
    drawn, structure = answer.plot.history(), answer.plot.structure()  # no history is kept
    assert len(drawn.patches) == len(structure.patches)
    assert "collapse" in {text.get_text() for text in drawn.texts}
    with pytest.raises(InputError, match="Collapse in four-dof"):
        answer.plot.axes("history")
    assert isinstance(answer.plot.structure(), Axes)


@pytest.mark.parametrize("kind", ["history", "structure", "deformed", "interaction", "energy"])
def test_every_picture_has_axes(response: Any, kind: str) -> None:
    axes = getattr(response.workbench.plot, kind)()
    assert isinstance(axes, Axes)
    assert axes.lines or axes.collections or axes.patches


def test_the_history_drawn_is_the_history(response: Any) -> None:
    (line,) = response.workbench.plot.history().lines
    assert max(line.get_ydata()) == pytest.approx(1e3 * response["displacement"].values.max())


def test_models_stand_side_by_side(column: Any, tmp_path: Path) -> None:
    push = wb.ColumnPushover("push", column, 0.02)
    answers = wb.compare(push, {"mine": "four-dof", "other": wb.make_model("single-dof")}, "mine")
    assert list(answers.table["model"]) == ["mine", "other"]
    assert np.isfinite(answers.table["wall_time"]).all()
    hit = wb.compare(wb.impact(column, 1500, 5), ["four-dof", "single-dof"], "four-dof")
    peaks = hit.table["peak_displacement"]
    assert list(hit.table["error"]) == pytest.approx([0.0, peaks[1] / peaks[0] - 1.0])
    hit.plot.save(tmp_path / "both.svg")
    assert (tmp_path / "both.svg").read_text().count("<svg") == 1
    assert "four-dof" in hit._repr_html_()
    with pytest.raises(InputError, match="must end in"):
        hit.plot.save(tmp_path / "both.gif")
    with pytest.raises(InputError, match="must be one of four-dof, single-dof"):
        _ = hit["fiber"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda c: wb.impact(c, "1.5 m", 15),
            "striker.mass = '1.5 m': must be a number from 0.001",
        ),
        (lambda c: wb.impact(c, 1500, 15, node="hit"), "node = 'hit': is for frames"),
        (lambda c: wb.impact("column", 1500, 15), "must be a Column or a Frame"),
        (lambda c: wb.simulate(wb.impact(c, 1500, 5), "four-dfo"), "did you mean four-dof?"),
        (lambda c: wb.simulate(wb.impact(c, 1500, 5), "four-dof", gama=1.0), "option.gama"),
        (lambda c: wb.Column("HEB 225", 0.8, 3.2), "did you mean HEB 220"),
        (lambda c: wb.fit_residual("none.csv"), "table = 'none.csv': is not a file"),
    ],
)
def test_bad_input_is_one_line(column: Any, call: Any, message: str) -> None:
    with pytest.raises(InputError) as error:
        call(column)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_studs_are_fitted_from_a_file(tmp_path: Path) -> None:
    from workbench.studs.schema import TEMPLATES, template

    file = tmp_path / "tests.csv"
    file.write_text(template("residual") + "\n".join(TEMPLATES["residual"].rows) + "\n")
    fit = wb.fit_residual(str(file), "strength")
    assert fit.quantity == "strength"
    shown = fit._repr_html_()
    assert fit.relation.formula in shown
    assert shown.count("<table") == 3  # answer, parameters, values for design
    assert all(escape(str(finding)) in shown for finding in fit.findings)


def test_a_table_of_answers_prints_all_columns(column: Any) -> None:
    answers = wb.compare(wb.impact(column, 1500, 5), ["four-dof", "energy-estimate"], "four-dof")
    for table in (answers.table, answers.table.sort_values("error")):
        text = str(table)
        assert "..." not in text
        assert all(name in text for name in table.columns)
        assert max(map(len, text.splitlines())) <= 100
    assert f"{answers.table['error'][1]:.4g}" in str(answers.table)


def test_a_notebook_shows_a_scenario_in_units_that_people_use(column: Any) -> None:
    """What is left at its default is left out; a part in a part is one line."""
    text = wb.impact(column, mass="1.5 t", velocity="54 km/h")._repr_html_()
    assert text.count("<table>") == 1
    assert "mass 1.5 t, velocity 15 m/s (54 km/h)" in text
    assert "section HEB 220, length_below 800 mm, length_above 3.2 m" in text
    assert "restitution" not in text
    frame = wb.regular_frame([3.0] * 4, [4.0, 4.0], find("HEB 200"), find("IPE 300"))
    assert "(15)" in frame._repr_html_()
    steel = wb.Steel(yield_stress=355e6, elastic_modulus=200e9)
    assert {*steel.words.values()} >= {"200 GPa"}
