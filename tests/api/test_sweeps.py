"""Sweeps: every value with every other, by models, in one dataset."""

import io
import json

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import workbench as wb
from workbench.base.errors import InputError
from workbench.cli import run
from workbench.report.gallery import to_csv
from workbench.study.tables import csv_bytes, from_spreadsheets, workbook_bytes

MODELS = ("single-dof", "four-dof")


@pytest.fixture(scope="module")
def impact():
    return wb.impact(wb.Column("HEB 220", 2.0, 2.0, axial_load=5e5), mass=1500, velocity=5)


@pytest.fixture(scope="module")
def swept(impact):
    over = {"striker.velocity": [5.0, "36 km/h", 90.0], "striker.mass": [800, 1500]}
    return wb.sweep(impact, over, MODELS)


def test_dimensions_are_the_keys_and_values_are_in_si(swept):
    assert swept.peak_displacement.dims == ("model", "striker.velocity", "striker.mass")
    assert swept["striker.velocity"].to_numpy().tolist() == [5.0, 10.0, 90.0]
    assert swept.peak_displacement.attrs["units"] == "m"


def test_cells_are_the_answers_of_single_calls(impact, swept):
    for model in MODELS:
        at = {"model": model, "striker.velocity": 10.0, "striker.mass": 1500}
        single = wb.simulate(impact.at_velocity(10.0), model)
        assert float(swept.peak_displacement.sel(at)) == float(single.peak_displacement)


def test_collapse_is_an_outcome_without_a_number(swept):
    fast = swept.sel({"striker.velocity": 90.0, "model": "four-dof"})
    assert set(fast.outcome.to_numpy().tolist()) == {"collapse"}
    assert np.isnan(fast.peak_displacement).all()
    assert all(fast.failure.to_numpy() != "")


def test_values_that_are_lists_stand_in_words(impact):
    laws = [[[0.0, 0.0], [0.5, last]] for last in (4e5, 6e5)]
    swept = wb.sweep(impact, {"striker.crush": laws}, ["single-dof"])
    assert swept["striker.crush"].to_numpy().tolist() == [str(law) for law in laws]
    assert swept.outcome.to_numpy().tolist() == [["ok", "ok"]]
    with pytest.raises(InputError, match=r"striker.mass = \[nan\]: needs a value"):
        wb.sweep(impact, {"striker.mass": [800.0, float("nan")]}, ["single-dof"])


def test_processes_change_nothing(impact):
    over = {"striker.velocity": np.linspace(3.0, 9.0, 4)}
    pair = [wb.sweep(impact, over, MODELS, jobs=n) for n in (1, 2)]
    xr.testing.assert_identical(*pair)


@pytest.mark.thorough
def test_wrong_values_stand_in_their_cell_unless_all_are(impact):
    answers = wb.sweep(impact, {"striker.mass": [-1.0, 1500.0]}, ["single-dof"])
    assert answers.outcome.to_numpy().tolist() == [["invalid-input", "ok"]]
    for over, message in (
        ({"striker.mass": [-1.0]}, "striker.mass"),
        ({"striker.colour": [1.0]}, "colour"),
        ({"striker.mass": []}, "striker.mass"),
        ({}, "over"),
    ):
        with pytest.raises(wb.InputError, match=message):
            wb.sweep(impact, over, ["single-dof"])
    with pytest.raises(wb.InputError, match="different values"):
        wb.sweep(impact, {"striker.velocity": [10.0, "36 km/h"]}, ["single-dof"])
    with pytest.raises(wb.InputError, match="different models"):
        wb.sweep(impact, {"striker.mass": [900.0]}, ["single-dof", "single-dof"])


@pytest.fixture
def column_file(tmp_path, capsys):
    assert run(["new", "column"]) == 0
    path = tmp_path / "column.toml"
    path.write_text(capsys.readouterr().out)
    return str(path)


def test_sweep_verb_writes_both_tables(column_file, tmp_path, capsys):
    over = ("--over", "striker.velocity=2:4:0.5", "--over", "striker.mass=900, 1500")
    for ending in ("csv", "nc"):
        out = tmp_path / f"answers.{ending}"
        arguments = (*over, "--model", "single-dof", "--out", str(out), "--jobs", "1")
        assert run(["sweep", column_file, *arguments]) == 0
    assert "10 answers, 10 ok" in capsys.readouterr().out
    assert len(pd.read_csv(tmp_path / "answers.csv")) == 10
    with xr.open_dataset(tmp_path / "answers.nc") as answers:
        assert answers.sizes == {"model": 1, "striker.velocity": 5, "striker.mass": 2}
    assert run(["sweep", column_file, *over, "--model", "single-dof", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["answers"]) == 10


@pytest.mark.parametrize(
    "over",
    [
        "striker.velocity",
        "striker.velocity=5:1:1",
        "striker.velocity=1:5:0",
        "striker.velocity=1:5",
        "striker.velocity=a:b:c",
        "striker.velocity=0:1e9:1e-3",
        "striker.shade=1,2",
    ],
)
def test_wrong_sweeps_are_one_line(column_file, capsys, over):
    assert run(["sweep", column_file, "--over", over, "--model", "single-dof"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_key_stands_once(column_file, capsys):
    twice = ("--over", "striker.mass=900", "--over", "striker.mass=800")
    assert run(["sweep", column_file, *twice, "--model", "single-dof"]) == 2
    assert "each key once" in capsys.readouterr().err


def test_rows_of_a_table_are_cases(impact, column_file, tmp_path, capsys):
    table = pd.DataFrame({"striker.velocity": [4.0, 6.0, 6.0], "striker.mass": [900, 900, 800]})
    answers = wb.sweep(impact, models=["single-dof"], cases=table)
    assert answers.peak_displacement.dims == ("model", "case")
    assert answers["striker.mass"].dims == ("case",)
    assert answers["striker.velocity"].attrs["units"] == "m/s"
    for row in table.itertuples():
        hit = wb.impact(impact.column, mass=row[2], velocity=row[1])
        single = float(wb.simulate(hit, "single-dof").peak_displacement)
        assert float(answers.peak_displacement[0, row.Index]) == single
    file, out = tmp_path / "cases.csv", tmp_path / "answers.csv"
    table.to_csv(file, index=False)
    asked = ("sweep", column_file, "--cases", str(file), "--model", "single-dof")
    assert run([*asked, "--out", str(out)]) == 0
    assert pd.read_csv(out)["striker.mass"].tolist() == [900, 900, 800]
    assert "3 answers, 3 ok" in capsys.readouterr().out
    for wrong in (
        "",
        "striker.mass\n",
        "striker.mass,striker.velocity\n900,\n",
        'striker.mass\n"\n',
    ):
        file.write_text(wrong)
        assert run(list(asked)) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert run([*asked, "--over", "striker.mass=900"]) == 2
    assert "not both" in capsys.readouterr().err


def test_sweeps_are_drawn(column_file, tmp_path, capsys):
    over = ("--over", "striker.velocity=2:4:1", "--over", "striker.mass=900,1500")
    picture = tmp_path / "peaks.svg"
    asked = ["sweep", column_file, *over, "--model", "single-dof", "--plot"]
    assert run([*asked, str(picture)]) == 0
    text = picture.read_text()
    assert "striker.velocity (m/s)" in text
    assert "striker.mass = 1500" in text
    assert run([*asked, str(tmp_path / "peaks.txt")]) == 2
    names = ["sweep", column_file, "--over", "column.base=clamped,pinned", "--model", "single-dof"]
    capsys.readouterr()
    assert run([*names, "--plot", str(picture)]) == 2
    assert "needs numbers first" in capsys.readouterr().err


def test_many_hits_are_a_table(impact):
    hits = [impact.at_velocity(v) for v in (5.0, 10.0)]
    table = wb.simulate_many("single-dof", hits, threads=1)
    alone = [float(wb.simulate(each, "single-dof").peak_displacement) for each in hits]
    assert table.peak_displacement.tolist() == alone
    assert len(wb.simulate_many("single-dof", [])) == 0
    for wrong, words in ((("no-model", hits), "no-model"), (("single-dof", hits, 0), "threads")):
        with pytest.raises(wb.InputError, match=words):
            wb.simulate_many(*wrong)


def test_a_key_within_another_is_refused(impact, column_file, tmp_path, capsys):
    file = tmp_path / "cases.csv"
    for keys in ("striker,striker.velocity", "striker.velocity,striker"):
        file.write_text(f"{keys}\n5,6\n")
        asked = ("sweep", column_file, "--cases", str(file), "--model", "single-dof")
        assert run(asked) == 2
        error = capsys.readouterr().err
        assert "striker.velocity: stands within striker, which is varied too" in error
        assert error.count("\n") == 1
    with pytest.raises(InputError, match="stands within"):
        wb.sweep(impact, {"striker": [5], "striker.velocity": [6, 7]}, ["single-dof"])


def test_texts_of_tables_are_no_formulas(tmp_path):
    """What a spreadsheet would run stands behind an apostrophe, and is read back without it."""
    name = "=cmd|'/C calc'!A0"
    table = pd.DataFrame({name: ["+1", "-x", "@a"], "b": ["\tc", "fine", "5"], "c": [-1.5, 2, 3]})
    text = csv_bytes(table).decode()
    assert text.splitlines()[0] == f"'{name},b,c"
    rows = [line.split(",") for line in text.splitlines()[1:]]
    assert [row[0] for row in rows] == ["'+1", "'-x", "'@a"]
    assert [row[1] for row in rows] == ["'\tc", "fine", "5"]
    assert [row[2] for row in rows] == ["-1.5", "2.0", "3.0"]
    assert to_csv(table).splitlines()[1] == "'+1,'\tc,-1.5"
    again = from_spreadsheets(pd.read_csv(io.StringIO(text)))
    assert again["b"].tolist() == table["b"].tolist()
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.load_workbook(io.BytesIO(workbook_bytes({"table": table})))
    cells = [cell for row in book["table"].iter_rows() for cell in row]
    assert {cell.data_type for cell in cells} == {"s", "n"}


@pytest.mark.thorough
def test_angles_are_read_in_degrees_also_at_the_default(impact):
    """Files leave an angle of zero out."""
    swept = wb.sweep(impact, {"striker.angle": ["0 deg", "30 deg"]}, ["seven-dof"])
    assert swept["striker.angle"].to_numpy() == pytest.approx([0.0, np.pi / 6.0])
    straight, oblique = swept["peak_displacement"].to_numpy()[0]
    assert oblique > 1.3 * straight
