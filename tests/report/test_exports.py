"""What leaves the workbench: shapes for ParaView, tables for spreadsheets, a crate for a paper."""

from __future__ import annotations

import hashlib
import io
import json
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.extras.exchange.crate import METADATA, write_crate
from workbench.extras.exchange.vtk import write_shapes
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof
from workbench.models.superelements import FlexibleSuperelement
from workbench.report.drawing.shapes import shapes_of
from workbench.scenarios import load_scenario
from workbench.study.tables import table_bytes, workbook_bytes

pytestmark = pytest.mark.thorough

FRAME = Path(__file__).parents[2] / "data" / "published" / "heng2017_frame.toml"
COLUMN = FRAME.with_name("heng2017_impact_column.toml")
TABLE = pd.DataFrame({"model": ["a", "b"], "peak": [1.5, np.nan], "parts": [["x"], None]})


@pytest.fixture
def column():
    return load_scenario(COLUMN)


def arrays_of(path: Path) -> dict[str, np.ndarray]:
    """Numbers of a VTU file by the name of the array, "" for the points."""
    piece = ElementTree.parse(path).getroot().find("UnstructuredGrid/Piece")
    assert piece is not None
    result = {}
    for each in piece.iter("DataArray"):
        width = int(each.get("NumberOfComponents", "1"))
        values = np.array((each.text or "").split(), float)
        result[each.get("Name", "")] = values.reshape(-1, width) if width > 1 else values
    assert len(result[""]) == int(piece.get("NumberOfPoints", ""))
    assert len(result["offsets"]) == int(piece.get("NumberOfCells", ""))
    return result


def test_shapes_of_a_struck_frame_for_paraview(tmp_path: Path) -> None:
    scenario = load_scenario(FRAME)
    response = FlexibleSuperelement().simulate(scenario)
    write_shapes(tmp_path / "run.pvd", scenario, response)
    shapes = shapes_of(scenario, response)
    assert shapes is not None
    sets = ElementTree.parse(tmp_path / "run.pvd").getroot().findall("Collection/DataSet")
    assert [float(each.attrib["timestep"]) for each in sets] == shapes.at.tolist()
    arrays = arrays_of(tmp_path / sets[shapes.peak].attrib["file"])
    z = shapes.curves[..., shapes.peak].ravel()
    places = arrays[""] + arrays["displacement"]
    assert np.allclose(places, np.stack([z.real, z.imag, 0.0 * z.real], axis=1), atol=1e-12)
    assert arrays["connectivity"].tolist() == list(range(len(z)))
    known = arrays["utilisation"][np.isfinite(arrays["utilisation"])]
    assert np.sort(known) == pytest.approx(np.sort(shapes.used[:, shapes.peak]))
    assert known.max() > 0.99


def test_chords_of_a_column_for_paraview(column, tmp_path: Path) -> None:
    response = FourDof().simulate(column)
    write_shapes(tmp_path / "run.pvd", column, response)
    last = sorted((tmp_path / "run").iterdir())[-1]
    arrays = arrays_of(last)
    moved = float(response["displacement"][-1])
    assert abs(arrays["displacement"]).max() == pytest.approx(moved, rel=1e-9)
    assert "utilisation" not in arrays


def test_an_answer_without_shapes_is_refused(column, tmp_path: Path) -> None:
    response = EnergyEstimate().simulate(column)
    with pytest.raises(InputError, match="knows no deformed shape"):
        write_shapes(tmp_path / "run.pvd", column, response)
    assert not list(tmp_path.iterdir())


def test_a_file_in_place_of_the_folder_of_shapes(column, tmp_path: Path) -> None:
    (tmp_path / "run").write_text("mine")
    response = FourDof().simulate(column)
    with pytest.raises(InputError, match="needs the folder run beside it"):
        write_shapes(tmp_path / "run.pvd", column, response)
    assert (tmp_path / "run").read_text() == "mine"


def test_tables_name_the_extra_that_they_need(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"pip install 'steel-impact-workbench\[tables\]'"):
        table_bytes(TABLE, "parquet")


@pytest.mark.parametrize("ending", ["parquet", "xlsx"])
def test_tables_come_back(ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    read = pd.read_parquet if ending == "parquet" else pd.read_excel
    back = read(io.BytesIO(table_bytes(TABLE, ending)))
    assert back["peak"].tolist()[0] == 1.5
    assert np.isnan(back["peak"].tolist()[1])
    assert back["parts"].tolist()[0] == '["x"]'


def test_a_workbook_has_a_sheet_for_each_table() -> None:
    book = pd.read_excel(io.BytesIO(workbook_bytes({"cells": TABLE, "bias": TABLE})), None)
    assert list(book) == ["cells", "bias"]


def test_a_crate_tells_what_made_what(small, built: dict[str, Path], tmp_path: Path) -> None:
    out = built["html"].parent
    target = tmp_path / "crate.zip"
    write_crate(small, out, target, ("workbench run small", "workbench report small"))
    again = tmp_path / "again.zip"
    write_crate(small, out, again, ("workbench run small", "workbench report small"))
    assert target.read_bytes() == again.read_bytes()
    with zipfile.ZipFile(target) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    graph = {each["@id"]: each for each in json.loads(files[METADATA])["@graph"]}
    parts = {each["@id"] for each in graph["./"]["hasPart"]}
    assert parts == set(files) - {METADATA}
    for name in parts:
        assert graph[name]["sha256"] == hashlib.sha256(files[name]).hexdigest()
    figures = [graph[name] for name in parts if name.startswith("report/figures/")]
    assert figures
    for figure in figures:
        cells = {each["@id"] for each in figure["isBasedOn"]}
        assert cells
        assert cells <= parts
    act = graph["#report"]
    assert act["name"] == "workbench run small; workbench report small"
    programs = [graph[each["@id"]] for each in act["instrument"]]
    assert all(each["identifier"].startswith("commit ") for each in programs)
    assert not any("machine" in json.dumps(each) for each in programs)
    assert len(graph["./"]["datePublished"]) == len("2026-01-01")


def test_the_command_line_exports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "run.pvd"
    asked = ["simulate", str(FRAME), "--model", "rigid-superelement", "--out"]
    assert run([*asked, str(target)]) == 0
    assert target.is_file()
    capsys.readouterr()
    assert run([*asked, "run.vtk"]) == 2
    assert "must end in nc or pvd" in capsys.readouterr().err


def test_a_missing_library_is_said_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    over, target = ["--over", "striker.velocity=5,6"], tmp_path / "a.parquet"
    assert run(["sweep", str(COLUMN), *over, "--model", "four-dof", "--out", str(target)]) == 2
    assert "needs pyarrow" in capsys.readouterr().err
    assert not target.exists()
