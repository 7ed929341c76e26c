"""`data add` takes what laboratories have: Excel, semicolons, decimal commas, kip and inches."""

from __future__ import annotations

from pathlib import Path

import pytest
from openpyxl import Workbook

from workbench.base.catalogue import check, dataset, load
from workbench.base.errors import InputError
from workbench.base.tables import Reading
from workbench.cli import run
from workbench.extras.intake.add import add_table
from workbench.extras.intake.kinds import problems_of_own
from workbench.studs.tables import shipped

PROVENANCE = """\
title = "{title}"
source = "Report 7, table 2"
licence = "CC BY 4.0"
year = 2024
role = "calibrate"
ignore = ["Remark"]
[columns]
{columns}
[constants]
campaign = "report7"
"""
STUDS = '"Versuch" = "specimen"\n"d" = "diameter_mm"\n"h" = "height_mm"\n"fcm" = "fcm_MPa"\n'
STUDS += '"fu" = "fu_MPa"\n"Pu" = "shear_kN"'
ROWS = [
    ["Versuch", "d", "h", "fcm", "fu", "Pu", "Remark"],
    ["", "mm", "mm", "N/mm2", "N/mm2", "kN", ""],
    ["P1", 19, 100, 31.2, 472, 104.5, "ok"],
    ["P2", 19, 100, 31.2, 472, 109.8, "1,5 mm crack; see photo"],
    ["P3", 19, 100, 31.2, 472, 101.9, ""],
]
POINTS = """\
Test,Remark,Slip (in),Force (kip)
ST1,a,0.00053,2.0
ST1,a,0.0161,15.0
ST1,b,0.2,21.5
ST2,a,0.0005,2.2
ST2,a,0.017,15.5
ST2,b,0.21,22.0
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("WORKBENCH_DATA", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def mapping(columns: str, more: str = "", title: str = "Push-outs") -> Path:
    text = PROVENANCE.format(title=title, columns=columns) + more
    Path("mapping.toml").write_text(text, encoding="utf-8")
    return Path("mapping.toml")


def european(*changes: tuple[str, str]) -> Path:
    """The rows with semicolons and decimal commas."""
    lines = [[str(cell).replace(".", ",") for cell in row] for row in ROWS]
    text = "\n".join(";".join(f'"{c}"' if ";" in c else c for c in row) for row in lines) + "\n"
    for old, new in changes:
        text = text.replace(old, new)
    Path("eu.csv").write_text(text, encoding="utf-8")
    return Path("eu.csv")


def excel(*titles: str) -> Path:
    book = Workbook()
    for row in [*([title] for title in titles), *ROWS]:
        book.active.append(row)
    book.active.title = "Push-outs"
    book.create_sheet("Notes").append(["by J. Doe"])
    book.save("lab.xlsx")
    return Path("lab.xlsx")


def test_semicolons_and_decimal_commas_come_in() -> None:
    added = add_table(european(), mapping=mapping(STUDS, 'test = "push-out"\nEcm = 1.5\n'[:18]))
    assert load("eu")["shear_kN"].tolist() == [104.5, 109.8, 101.9]
    assert load("eu")["fcm_MPa"].tolist() == [31.2] * 3
    assert {"columns are separated by semicolons", "numbers have decimal commas"} < {*added.notes}
    assert "numbers have decimal commas" in dataset("eu").made
    assert check() == problems_of_own() == []


def test_constants_of_a_mapping_have_decimal_points() -> None:
    """The mapping is a file of its own: its 19.05 is 19.05 beside a table of decimal commas."""
    text = STUDS.replace('"d" = "diameter_mm"\n', "")
    given = mapping(text, 'test = "push-out"\ndiameter_in = 0.75\nslip_at_max_mm = 6.25\n')
    given.write_text(given.read_text("utf-8").replace('["Remark"]', '["Remark", "d"]'))
    add_table(european(), mapping=given)
    assert load("eu")["diameter_mm"].tolist() == [19.05] * 3
    assert load("eu")["slip_at_max_mm"].tolist() == [6.25] * 3


def test_a_workbook_comes_in_with_its_title() -> None:
    given = mapping(STUDS, 'test = "push-out"\n')
    table = excel("Push-outs of June 2024", "all loads per stud")
    with pytest.raises(InputError, match=r"--sheet: must be given: lab\.xlsx has Push-outs, Notes"):
        add_table(table, mapping=given)
    added = add_table(table, mapping=given, how=Reading(sheet="Push-outs"))
    assert load("lab")["shear_kN"].tolist() == [104.5, 109.8, 101.9]
    assert "the header is line 3, below 'Push-outs of June 2024'" in added.notes
    again = ["data", "add", "eu.csv", "--mapping", "mapping.toml"]
    european()
    assert run(again) == 0  # the same rows, whatever they are saved as
    assert not Path("lab_data/eu.csv").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("104,5", "1.104,5"), r"line 3, column shear_kN \(from Pu.*no separators of thousands"),
        (("104,5", "104.5"), r"line 3, column shear_kN .*a decimal comma as in this table"),
    ],
)
def test_numbers_of_another_form_are_named_not_guessed(
    change: tuple[str, str], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        add_table(european(change), mapping=mapping(STUDS, 'test = "push-out"\n'))
    assert not Path("lab_data").exists()


def test_points_in_kip_and_inches_come_in_and_are_fitted(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("kwon.csv").write_text(POINTS, encoding="utf-8")
    columns = '"Test" = "specimen"\n"Slip" = "slip_mm"\n"Force" = "load_kN"'
    added = add_table(Path("kwon.csv"), mapping=mapping(columns))
    assert (added.entry.kind, added.rows) == ("stud-points", 6)
    assert "Force (kip) in kip is load_kN, times 4.44822162" in added.notes
    rows = shipped("kwon")
    assert rows["slip_mm"][2] == pytest.approx(0.2 * 25.4, rel=1e-11)
    assert rows["load_kN"][2] == pytest.approx(21.5 * 4.4482216152605, rel=1e-11)
    assert set(rows["reference"]) == {"Report 7, table 2"}
    assert check() == problems_of_own() == []
    assert added.then == "workbench fit load-slip lab_data/kwon.csv"
    assert run(["data", "add", "kwon.csv", "--mapping", "mapping.toml", "--kind", "studs"]) == 2
    assert "must be one of impact-tests, stud-tests, stud-points" in capsys.readouterr().err
    assert run(["fit", "load-slip", "lab_data/kwon.csv", "--law", "ollgaard"]) == 0
    assert "2 curves of report7" in capsys.readouterr().out


def test_made_points_show_that_they_are() -> None:
    Path("made.csv").write_text(POINTS, encoding="utf-8")
    columns = '"Test" = "specimen"\n"Slip" = "slip_mm"\n"Force" = "load_kN"'
    given = mapping(columns)
    given.write_text(given.read_text("utf-8").replace('"calibrate"', '"synthetic"'), "utf-8")
    add_table(Path("made.csv"), mapping=given)
    assert set(load("made")["campaign"]) == {"SYNTHETIC report7"}
