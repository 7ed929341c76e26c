"""THE reader of tables: what people save is read as it is, and how it was read is said."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openpyxl import Workbook

import workbench
from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.base.tables import Cells, Reading, cells_of, read_points

NAMES = ("specimen", "d", "load", "note")
TABLE = [["specimen", "d", "load", "note"], ["P1", 19, 104.5, "ok"], ["P2", 22, 0.25, "a b"]]


def cells(text: str | bytes, **how: str) -> Cells:
    data = text.encode() if isinstance(text, str) else text
    return cells_of(data, "t.csv", NAMES.__contains__, Reading(**how))


def text_with(sep: str, decimal: str) -> str:
    rows = [[str(cell).replace(".", decimal) for cell in row] for row in TABLE]
    quoted = [[f'"{c}"' if sep in c else c for c in row] for row in rows]
    return "\n".join(map(sep.join, quoted)) + "\n"


def workbook(*sheets: list[list[Any]], names: tuple[str, ...] = ("Tests", "Curves")) -> bytes:
    book = Workbook()
    book.remove(book.active)
    for name, rows in zip(names, sheets, strict=False):
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    buffer = io.BytesIO()
    book.save(buffer)
    return buffer.getvalue()


def values(table: Cells) -> list[list[Any]]:
    return [[each if (n := table.number(each)) is None else n for each in row]
            for _, row in table.rows]  # fmt: skip


@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("sep", [",", ";", "\t"])
def test_every_separator_and_decimal_sign_is_found_out_and_said(sep: str, decimal: str) -> None:
    table = cells(text_with(sep, decimal))
    assert values(table) == TABLE
    words = {";": "semicolons", "\t": "tabulators"}
    assert table.notes == (
        *([f"columns are separated by {words[sep]}"] if sep in words else []),
        *(["numbers have decimal commas"] if decimal == "," else []),
    )
    told = cells(text_with(sep, decimal), sep="tab" if sep == "\t" else sep, decimal=decimal)
    assert (values(told), told.notes) == (TABLE, ())


def test_workbooks_are_read_and_their_sheets_chosen() -> None:
    assert values(cells(workbook(TABLE))) == TABLE
    two = workbook(TABLE, [["slip", "force"], [0.1, 5]])
    with pytest.raises(InputError, match=r"--sheet: must be given: t\.csv has Tests, Curves"):
        cells(two)
    assert cells(two, sheet="Curves").rows[1] == (2, ["0.1", "5"])
    assert cells(two, sheet="Tests").notes == ("the rows are those of the sheet Tests",)
    with pytest.raises(InputError, match=r"--sheet = 'Curvs': .*did you mean Curves"):
        cells(two, sheet="Curvs")
    assert values(cells(workbook(TABLE, []))) == TABLE  # a sheet without rows is no choice
    with pytest.raises(InputError, match="is a text, which has no sheets"):
        cells(text_with(",", "."), sheet="Tests")


def test_titles_above_the_header_are_named() -> None:
    titles = [["Push-out tests of June"], [], ["Tested by", "J. Doe"]]
    for table in (
        cells("Push-out tests of June\n\nTested by,J. Doe\n" + text_with(",", ".")),
        cells("# not read\nPush-out tests of June;;;\n\nTested by;J. Doe;;\n"
              + text_with(";", ",")),
        cells(workbook([*titles, *TABLE])),
        cells(workbook([[], *titles, *([None, None, *row] for row in TABLE)])),
    ):  # fmt: skip
        assert values(table) == TABLE
        assert table.notes[-1].startswith("the header is line ")
        assert table.notes[-1].endswith(", below 'Push-out tests of June'")
    # names that nobody knows: the header is the first line that is as wide as the table
    foreign = cells("Report 7\nVersuch;a;b;c\nV1;1;2,5;3\nV2;1;2,7;3\n")
    assert foreign.header == ["Versuch", "a", "b", "c"]
    assert foreign.rows[0][0] == 2


def test_a_number_is_never_taken_for_another() -> None:
    """1,137 may be 1.137 or 1137: no guess where commas separate columns, a word to choose."""
    table = cells('specimen,d,load,note\nP1,19,"1,137",\nP2,19,"1,204",\n')
    assert table.number("1,137") is None
    assert "a decimal point as in this table, or tell --decimal" in table.advice
    assert cells('specimen,load\nP1,"1,137"\n', decimal=",").number("1,137") == 1.137
    german = cells("specimen;d;load\nP1;19;104,5\nP2;19;1.137,0\nP3;19;1.137\n")
    assert [german.number(row[2]) for _, row in german.rows[1:]] == [104.5, None, None]
    assert "no separators of thousands, and a decimal comma as in this table" in german.advice
    wrong = ("1_0", "", "x", "1,2,3", "\u0661,5", "1,5 mm", "1" * 70)
    assert not any(german.number(each) for each in wrong)
    assert [german.number(each) for each in ("-,5", "1e-3", "7")] == [-0.5, 1e-3, 7.0]


def test_hostile_workbooks_end_in_one_message() -> None:
    formulas = workbook([["specimen", "load"], ["P1", "=2*B9"]])
    with pytest.raises(InputError, match=r"line 2: holds a formula without a value"):
        cells(formulas)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/workbook.xml", b"0" * 210_000_000)
    with pytest.raises(InputError, match="must not unpack to over"):
        cells(packed.getvalue())
    other = io.BytesIO()
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
    with pytest.raises(InputError, match="is no workbook of Excel that can be read"):
        cells(other.getvalue())
    with pytest.raises(InputError, match="is empty"):
        cells(workbook([]))


@pytest.mark.parametrize(("flag", "value"), [("sep", "x"), ("decimal", ";")])
def test_signs_are_checked(flag: str, value: str) -> None:
    with pytest.raises(InputError, match=f"--{flag} = '{value}': must be one of"):
        cells(text_with(",", "."), **{flag: value})


def test_points_are_read_alike() -> None:
    rules = {"slip": Number(0.0, 1.0), "force": Number(0.0, 1e6)}
    right = np.array([[0.0, 0.0], [0.1, 2.5], [0.2, 3.0]])
    texts = ["slip,force\n0,0\n0.1,2.5\n0.2,3\n", "Curve 3\nslip;force\n0;0\n0,1;2,5\n0,2;3\n"]
    book = workbook([["slip", "force"], *right.tolist()])
    for data in (*(text.encode() for text in texts), book):
        points, lines = read_points(data, "p", "option", rules)
        np.testing.assert_array_equal(points, right)
    assert lines == [2, 3, 4]


def test_rows_of_a_sweep_may_be_a_workbook(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from workbench.cli import run

    assert run(["new", "column"]) == 0
    scenario, book = tmp_path / "column.toml", tmp_path / "cases.xlsx"
    scenario.write_text(capsys.readouterr().out, encoding="utf-8")
    book.write_bytes(workbook([["Runs"], ["striker.velocity", "striker.mass"], [2.5, 900]]))
    text = tmp_path / "cases.csv"
    text.write_text("striker.velocity;striker.mass\n2,5;900\n", encoding="utf-8")
    printed = []
    for file in (book, text):
        asked = ["sweep", str(scenario), "--cases", str(file), "--model", "energy-estimate"]
        assert run(asked) == 0
        printed.append(capsys.readouterr().out)
    assert "the header is line 2, below 'Runs'" in printed[0]
    assert "numbers have decimal commas" in printed[1]
    assert printed[0].splitlines()[-1] == printed[1].splitlines()[-1]


def test_no_other_module_reads_tables() -> None:
    package = Path(workbench.__file__).parent
    readers = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        for words in ("import csv\n", "read_csv(", "csv.reader", "load_workbook", "read_excel")
        if words in path.read_text(encoding="utf-8")
    }
    assert readers == {"base/tables.py"}
