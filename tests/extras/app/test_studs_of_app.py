"""Tab of studs without a browser: from a table that is dropped to its appendix, step by step."""

from __future__ import annotations

import asyncio
import hashlib
import io
import json
import zipfile
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import openpyxl
import pytest

from workbench.base.datafiles import LARGEST_FILE
from workbench.cli import run
from workbench.studs.fit_protocol import plain
from workbench.studs.schema import template

pytest.importorskip("panel")

from workbench.extras.app.studs import MOST_COLUMNS, StudDesk, read_table

STRENGTH, CURVES, RESIDUAL = (
    template(k, filled=True) for k in ("strength", "load-slip", "residual")
)
HOSTILE = "<img src=x onerror=alert(1)>"
FOREIGN = """\
Test No.,Stud diam. d,Length L,f'c,fu,Qu (kip),Remark
,in.,in.,ksi,ksi,kips,
S1,0.75,4.0,4.35,68.5,29.1,shank
S2,0.75,4.0,4.35,68.5,28.0,
S3,0.75,4.0,5.10,68.5,30.6,shank
"""


class AtOnce:
    """A desk that answers where it is asked; ``asked`` are the functions."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def ask(self, function: Any, *arguments: Any, lane: str) -> Future[Any]:
        self.asked.append(function.__name__)
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


class Waiting:
    """A desk whose work ends when a test says so."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Future[Any], Any]] = []

    def ask(self, function: Any, *arguments: Any, lane: str) -> Future[Any]:
        future: Future[Any] = Future()
        self.waiting.append((future, lambda: function(*arguments)))
        return future

    def end(self, place: int) -> None:
        future, work = self.waiting[place]
        future.set_result(work())


def dropped(content: str | bytes, name: str = "lab.csv") -> StudDesk:
    """The tab after a table has been dropped."""
    studs = StudDesk(AtOnce())
    studs.view()
    studs.drop.value = {name: content}
    return studs


def fitted(content: str | bytes, name: str = "lab.csv") -> StudDesk:
    """The tab after the columns of a table have been confirmed."""
    studs = dropped(content, name)
    studs.examine()
    return studs


def shown(studs: StudDesk) -> list[str]:
    return [name for name, step in studs.steps.items() if step.visible]


def uses(studs: StudDesk) -> dict[str, str]:
    """Use of every test in the picture."""
    data = studs.source.data
    return dict(zip(data["test"], data["use"], strict=True))


def workbook(*rows: tuple[Any, ...], more: bool = False) -> bytes:
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    if more:
        book.create_sheet("second").append(("campaign", "specimen"))
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


def rows_of(text: str) -> list[tuple[Any, ...]]:
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return [tuple(line.split(",")) for line in lines]


# -- from the table to its answer ----------------------------------------------------------------


def test_a_new_tab_shows_the_first_step_alone() -> None:
    studs = StudDesk(AtOnce())
    studs.view()
    assert shown(studs) == ["table"]
    assert not studs.status.object


@pytest.mark.parametrize(
    ("content", "question", "answers"),
    [
        (STRENGTH, "stud-strength", {"AISC 360-22", "EN 1994-1-1"}),
        (CURVES, "load-slip", {"ollgaard", "rational"}),
        pytest.param(RESIDUAL, "residual", {"strength"}, marks=pytest.mark.thorough),
    ],
)
def test_a_table_of_known_columns_needs_one_confirmation(
    content: str, question: str, answers: set[str]
) -> None:
    studs = dropped(content)
    assert shown(studs) == ["table", "columns"]
    assert all(column.value for column, _ in studs.columns)  # each was matched
    studs.examine()
    assert not studs.status.object
    assert shown(studs) == ["table", "columns", "question", "picture", "answer"]
    head, tables, *_ = studs.answered
    assert head["fit"] == question
    assert answers <= set(tables["fit"]["of"])
    assert "Grade" in studs.page.object
    assert set(uses(studs).values()) == {"fitted"}


@pytest.mark.thorough
@pytest.mark.parametrize("content", [STRENGTH, CURVES])
def test_the_numbers_are_those_of_the_command_line(
    content: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("lab.csv").write_text(content)
    studs = fitted(content)
    head, tables, *_ = studs.answered
    assert run(["fit", head["fit"], "lab.csv", "--report", "lab.pdf", "--json"]) == 0
    other = json.loads(capsys.readouterr().out)
    assert other.pop("results") == plain(tables)
    assert other == plain(head)
    # the very document too, with the name of its folder of curves
    packed = zipfile.ZipFile(asyncio.run(studs.save("zip")))
    for name in Path("lab-curves").iterdir():
        assert packed.read(f"studs-curves/{name.name}") == name.read_bytes()


@pytest.mark.thorough
def test_the_appendix_is_a_pdf_and_a_zip_of_it() -> None:
    studs = fitted(STRENGTH)
    pdf = asyncio.run(studs.save("pdf")).getvalue()
    assert pdf.startswith(b"%PDF")
    packed = zipfile.ZipFile(asyncio.run(studs.save("zip")))
    assert packed.read("studs.pdf") == pdf
    assert "our lab,A1," in packed.read("studs-curves/tests.csv").decode()


@pytest.mark.thorough
def test_the_shipped_tables_need_no_file() -> None:
    for name, question in (("stud-push-out", "stud-strength"), ("stud-load-slip", "load-slip")):
        studs = StudDesk(AtOnce())
        studs.view()
        studs.use(name)
        head = studs.answered[0]
        assert (head["fit"], head["tables"], head["digest"]) == (question, ["shipped"], None)


def test_a_workbook_is_read_like_its_text() -> None:
    text, book = fitted(STRENGTH), fitted(workbook(*rows_of(STRENGTH)), "lab.xlsx")
    assert plain(text.answered[1]) == plain(book.answered[1])
    digest = hashlib.sha256(book.file[1]).hexdigest()
    assert book.answered[0]["digest"] == digest[:16]


def test_the_sheet_of_a_workbook_is_asked_for() -> None:
    studs = dropped(workbook(*rows_of(STRENGTH), more=True), "lab.xlsx")
    assert studs.sheet.visible
    assert "must be given" in studs.status.object
    studs.sheet.value = "Sheet"
    assert shown(studs) == ["table", "columns"]
    assert not studs.status.object


# -- columns, units, values of all rows ----------------------------------------------------------


def test_foreign_columns_are_chosen_and_converted() -> None:
    studs = dropped(FOREIGN)
    chosen = {"Test No.": "specimen", "Stud diam. d": "diameter_mm", "Length L": "height_mm"}
    chosen |= {"f'c": "fcm_MPa", "fu": "fu_MPa", "Qu (kip)": "shear_kN"}
    for name, (column, _) in zip(studs.cells.header, studs.columns, strict=True):
        assert column.value in ("", "fu_MPa")  # that one is known without its unit
        column.value = chosen.get(name, "")
    studs.examine()
    assert "required column missing" in studs.status.object
    assert shown(studs)[-1] == "columns"
    for field in studs.constants:
        field.value = {"campaign": "doe1999", "test": "push-out"}.get(field.tags[0], "")
    studs.examine()
    assert shown(studs)[-1] == "answer"
    assert studs.rows["diameter_mm"].tolist() == [19.05] * 3
    assert studs.rows["shear_kN"][0] == pytest.approx(29.1 * 4.4482216152605)
    assert any("Qu (kip) in kip is shear_kN" in note for note in studs.told["notes"])


def test_a_unit_that_no_one_says_is_asked_for() -> None:
    studs = dropped(STRENGTH.replace("shear_kN", "shear"))
    studs.examine()
    assert "says no unit" in studs.status.object
    place = studs.cells.header.index("shear")
    column, unit = studs.columns[place]
    assert column.value == "shear_kN"
    unit.value = "N"
    studs.examine()
    assert studs.found.problems  # 104.5 N is no strength of a stud
    unit.value = "kN"
    studs.examine()
    assert studs.rows["shear_kN"].tolist() == [104.5, 109.8, 101.9, 137.0]


def test_bad_rows_are_named_and_left_out_on_demand() -> None:
    bad = STRENGTH.replace("solid,109.8", "solid,-109.8") + "our lab,B2,push-out\n"
    studs = fitted(bad)
    assert studs.answered is None
    assert studs.leave.visible
    assert "-109.8" in studs.status.object
    assert "has 3 cells" in studs.status.object
    studs.take()
    assert shown(studs)[-1] == "answer"
    head = studs.answered[0]
    assert len(head["rows_left_out"]) == 2
    assert head["options"] == {"keep_good": True}
    assert list(uses(studs)) == ["our lab A1", "our lab A3", "our lab B1"]


def test_the_kind_of_row_can_be_said() -> None:
    studs = dropped(CURVES)
    before = studs.kind.value
    studs.kind.value = next(kind for kind in studs.kind.options.values() if kind != before)
    assert [column.value for column, _ in studs.columns] == ["campaign", "specimen", "", ""]


# -- hostile tables ------------------------------------------------------------------------------


def packed_bomb() -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("xl/worksheets/sheet1.xml", b" " * 250_000_000)
    return target.getvalue()


def formulas() -> bytes:
    return workbook(
        *rows_of(STRENGTH)[:2], ("lab", "=1+1", '=cmd|" /C calc"!A0', 1, 2, 3, 4, "", 5, 6)
    )


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("lab.exe", b"MZ", "must end in .csv or .xlsx"),
        ("lab.csv.html", STRENGTH, "must end in .csv or .xlsx"),
        ("lab.csv", b"\x00\x01\x02", "is binary data"),
        ("lab.csv", b"\xff\xfe\xfa", "is not UTF-8 text"),
        ("lab.xlsx", workbook(("campaign", "specimen"))[:400], "not text"),
        ("lab.csv", "", "is empty"),
        ("lab.csv", b"a" * (LARGEST_FILE + 1), "exceeds 20 MB"),
        ("lab.csv", "campaign,campaign\n1,2\n", "the column stands twice"),
        ("lab.csv", ",".join(f"c{k}" for k in range(MOST_COLUMNS + 1)) + "\n", "columns"),
        ("lab.csv", "campaign,specimen\n" + "a,b\n" * 100_000, "more than 50000 rows"),
    ],
)
def test_a_file_that_is_no_table_is_refused(name: str, content: str | bytes, message: str) -> None:
    studs = dropped(content, name)
    assert message in studs.status.object
    assert studs.status.object.count("<p>") == 1  # one line
    assert shown(studs) == ["table"]
    assert studs.answered is None


def test_a_packed_bomb_and_formulas_are_refused() -> None:
    studs = dropped(packed_bomb(), "lab.xlsx")
    assert "must not unpack" in studs.status.object
    studs = dropped(formulas(), "lab.xlsx")
    assert "formula without a value" in studs.status.object


def test_a_table_without_rows_is_refused() -> None:
    studs = fitted(template("strength"))
    assert "must hold one row or more" in studs.status.object
    assert shown(studs)[-1] == "columns"


def test_texts_of_a_table_never_become_markup() -> None:
    studs = fitted(STRENGTH.replace("our lab", HOSTILE), f"{HOSTILE}.csv")
    assert shown(studs)[-1] == "answer"
    assert "<img" not in studs.page.object
    assert "&lt;img" in studs.page.object
    studs = dropped(b"\x00", f"{HOSTILE}.csv")
    assert "<img" not in studs.status.object
    assert "&lt;img" in studs.status.object
    studs = dropped(STRENGTH.replace("shear_kN", f"shear {HOSTILE}"))
    studs.columns[-2][0].value = "shear_kN"
    studs.examine()
    assert "&lt;img" in studs.status.object
    assert "<img" not in studs.status.object


def test_a_refused_file_leaves_no_answer_of_the_one_before() -> None:
    studs = fitted(STRENGTH)
    studs.drop.value = {"lab.csv": b"\x00"}
    assert shown(studs) == ["table"]


@pytest.mark.thorough
def test_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    asyncio.run(fitted(STRENGTH).save("pdf"))
    assert not list(tmp_path.iterdir())


# -- the picture ---------------------------------------------------------------------------------


def test_list_and_picture_select_the_same_tests() -> None:
    studs = fitted(CURVES)
    studs.tests.value = ["our lab A2"]
    assert studs.source.selected.indices == [4, 5, 6, 7]  # the points of that curve
    studs.source.selected.indices = [0]
    assert studs.tests.value == ["our lab A1"]
    assert studs.source.selected.indices == [0, 1, 2, 3]


def test_an_outlier_is_left_out_and_taken_back() -> None:
    studs = fitted(STRENGTH)
    whole = plain(studs.answered[1])
    studs.mark("left out")
    assert "Select tests" in studs.status.object
    studs.tests.value = ["our lab B1"]
    studs.mark("left out")
    assert uses(studs)["our lab B1"] == "left out"  # still there, where it was
    head, tables, *_ = studs.answered
    assert set(tables["fit"]["tests"]) == {3}
    assert "our lab B1: left out in the picture" in head["notes"]
    studs.tests.value = ["our lab B1"]
    studs.mark("")
    assert plain(studs.answered[1]) == whole
    assert set(uses(studs).values()) == {"fitted"}


def test_tests_held_out_judge_the_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    studs = fitted(STRENGTH)
    studs.tests.value = ["our lab A2"]
    studs.mark("held out")
    head, tables, *_ = studs.answered
    assert uses(studs)["our lab A2"] == "held out"
    assert head["validate"] == ["our lab"]
    assert set(tables["judged"]["specimen"]) == {"A2"}
    # a file that says so gives the same numbers
    monkeypatch.chdir(tmp_path)
    lines = [line for line in STRENGTH.splitlines() if not line.startswith("#")]
    roles = ["role", "calibrate", "validate", "calibrate", "calibrate"]
    text = "\n".join(f"{line},{role}" for line, role in zip(lines, roles, strict=True))
    Path("lab.csv").write_text(text)
    assert run(["fit", "stud-strength", "lab.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["results"] == plain(tables)


def test_a_choice_that_leaves_too_little_is_taken_back_with_a_message() -> None:
    studs = fitted(STRENGTH)
    before = plain(studs.answered[1])
    studs.tests.value = list(uses(studs))
    studs.mark("held out")
    assert studs.status.object
    assert studs.marks == {}
    assert plain(studs.answered[1]) == before
    assert set(uses(studs).values()) == {"fitted"}


def test_uses_are_of_one_table() -> None:
    studs = fitted(STRENGTH)
    studs.tests.value = ["our lab B1"]
    studs.mark("left out")
    studs.drop.value = {"lab.csv": STRENGTH}
    studs.examine()
    assert set(uses(studs).values()) == {"fitted"}
    assert not studs.answered[0]["notes"]


def test_options_answer_again() -> None:
    studs = fitted(STRENGTH)
    confidence = next(each for each in studs.options if each.tags == ["confidence"])
    confidence.value = 0.95
    head = studs.answered[0]
    assert head["confidence"] == 0.95
    assert head["options"] == {"confidence": 0.95}
    slab = next(each for each in studs.options if each.tags == ["slab"])
    slab.value = "deck"
    assert "holds no undamaged headed stud" in studs.status.object
    assert studs.answered[0] == head  # what was found before


def test_another_formula_is_drawn_without_a_fit() -> None:
    studs = fitted(STRENGTH)
    before, asked = list(studs.source.data["x"]), len(studs.desk.asked)
    studs.of.value = next(name for name in studs.of.options if name != studs.of.value)
    assert list(studs.source.data["x"]) != before
    assert len(studs.desk.asked) == asked


# -- work elsewhere ------------------------------------------------------------------------------


def test_what_was_asked_last_is_shown() -> None:
    desk = Waiting()
    studs = StudDesk(desk)
    studs.view()
    studs.drop.value = {"first.csv": STRENGTH}
    studs.drop.value = {"second.csv": CURVES}
    assert "Working" in studs.status.object
    desk.end(-1)
    assert len(studs.columns) == 4
    desk.end(0)
    assert len(studs.columns) == 4
    assert studs.cells.name == "second.csv"


def test_a_worker_that_dies_is_said() -> None:
    desk = Waiting()
    studs = StudDesk(desk)
    studs.view()
    studs.drop.value = {"lab.csv": STRENGTH}
    desk.waiting[0][0].set_exception(TimeoutError("task timeout"))
    assert "no answer within the time limit" in studs.status.object


def test_cells_of_a_table_travel_to_the_worker_and_back() -> None:
    import pickle

    cells = read_table("lab.csv", STRENGTH.encode())
    assert pickle.loads(pickle.dumps(cells)) == cells
