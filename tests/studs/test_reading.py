"""Tables of tests: what is read, and how what cannot be read is named."""

from __future__ import annotations

import os
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.base.datafiles import LARGEST_FILE
from workbench.base.errors import InputError
from workbench.extras.intake.kinds import check_file
from workbench.scenarios import load_scenario
from workbench.studs import POINTS, TESTS, examine, read_tests
from workbench.studs.schema import from_frame, read_text

HEADER = "campaign,specimen,test,diameter_mm,height_mm,fcm_MPa,fu_MPa,shear_kN"
GOOD = "lab,A1,push-out,19,100,30,450,100"


def table(tmp_path: Path, *lines: str, header: str = HEADER) -> Path:
    path = tmp_path / "tests.csv"
    path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    return path


def test_a_good_table_is_read_and_completed(tmp_path: Path) -> None:
    rows = read_tests(table(tmp_path, GOOD, "lab,A2,push-out,19,,30,450,99.5"))
    assert list(rows["specimen"]) == ["A1", "A2"]
    assert rows["diameter_mm"].tolist() == [19.0, 19.0]
    assert np.isnan(rows["height_mm"][1])
    assert rows["predamage"].tolist() == ["none", "none"]
    assert rows["origin"].tolist() == ["measured", "measured"]
    assert rows["connector"].tolist() == ["headed stud", "headed stud"]
    assert rows["use_for_fit"].tolist() == [1.0, 1.0]
    assert set(TESTS.names) == set(rows.columns)


def test_columns_of_the_user_are_kept(tmp_path: Path) -> None:
    rows = read_tests(table(tmp_path, GOOD + ",hello", header=HEADER + ",x_note"))
    assert rows["x_note"].tolist() == ["hello"]


# name: (lines, header, what the message must hold)
MALFORMED: dict[str, tuple[list[str], str, str]] = {
    "metres instead of millimetres": (
        ["lab,A1,push-out,0.019,100,30,450,100"], HEADER,
        r"line 2, column diameter_mm = 0\.019: must be a number from 5 to 40 mm; .*19 mm stud",
    ),
    "pascals instead of megapascals": (
        ["lab,A1,push-out,19,100,30e6,450,100"], HEADER,
        r"line 2, column fcm_MPa = 30000000\.0: must be a number from 5 to 250 MPa",
    ),
    "newtons instead of kilonewtons": (
        ["lab,A1,push-out,19,100,30,450,100000"], HEADER,
        r"line 2, column shear_kN = 100000\.0: must be a number above 0 to 2000 kN; loads are",
    ),
    "meganewtons that pass the range": (
        ["lab,A1,push-out,19,100,30,450,0.1"], HEADER,
        r"line 2, column shear_kN = 0\.1: means 0\.353 MPa over a shank of 19 mm",
    ),
    "inches that pass the range": (
        ["lab,A1,push-out,19,4,30,450,100"], HEADER,
        r"line 2, column height_mm = 4\.0: must be a number from 15",
    ),
    "missing required column": (
        ["A1,push-out,100"], "specimen,test,shear_kN",
        r"line 1 = 'campaign': required column missing",
    ),
    "misspelt column": (
        [GOOD + ",3"], HEADER + ",fcm_Mpa",
        r"line 1 = 'fcm_Mpa': unknown column; did you mean fcm_MPa\?",
    ),
    "column twice": ([GOOD + ",3"], HEADER + ",fu_MPa", r"'fu_MPa': the column stands twice"),
    "text in a number": (
        ["lab,A1,push-out,19,100,about 30,450,100"], HEADER,
        r"line 2, column fcm_MPa = 'about 30': must be a number .*no unit, no words",
    ),
    "unit in a number": (
        ["lab,A1,push-out,19 mm,100,30,450,100"], HEADER, r"column diameter_mm = '19 mm'",
    ),
    "not a number": (["lab,A1,push-out,nan,100,30,450,100"], HEADER, r"must be finite"),
    "specimen twice": (
        [GOOD, GOOD], HEADER,
        r"line 3, column specimen = 'lab, A1': stands in line 2 too",
    ),
    "negative load": (
        ["lab,A1,push-out,19,100,30,450,-100"], HEADER, r"column shear_kN = -100\.0: must be a num",
    ),
    "zero load": (["lab,A1,push-out,19,100,30,450,0"], HEADER, r"column shear_kN = 0\.0"),
    "a decimal comma among decimal points": (
        ['lab,A1,push-out,"19,05",100,30.5,450,100.5'], HEADER,
        r"column diameter_mm = '19,05': .*and a decimal point as in this table, or tell --decimal",
    ),
    "decimal comma without quotes": (
        [GOOD, "lab,A2,push-out,19,05,100,30,450,100"], HEADER,
        r"line 3 = .*has 9 cells where the header has 8; .*decimal points",
    ),
    "short row": (["lab,A1,push-out,19"], HEADER, r"has 4 cells where the header has 8"),
    "only a header": ([], HEADER, r"must hold one row or more"),
    "unknown kind of test": (
        ["lab,A1,push,19,100,30,450,100"], HEADER,
        r"column test = 'push': must be one of push-out, pull-out, combined",
    ),
    "no result": (
        ["lab,A1,push-out,19,100,30,450,"], HEADER,
        r"column shear_kN = '': must be given for a push-out test",
    ),
    "pull-out without tension": (
        ["lab,A1,pull-out,19,100,30,450,100"], HEADER, r"column tension_kN = '': must be given",
    ),
    "pre-damage without level": (
        [GOOD + ",fatigue"], HEADER + ",predamage",
        r"column predamage_level = '': must be given with predamage fatigue",
    ),
    "level in per cent": (
        [GOOD + ",fatigue,life fraction,40"],
        HEADER + ",predamage,predamage_measure,predamage_level",
        r"column predamage_level = 40\.0: must be a number from 0 to 3; .*40 % is 0\.4",
    ),
    "level without pre-damage": (
        [GOOD + ",0.4"], HEADER + ",predamage_level", r"needs a predamage other than none",
    ),
    "total that does not fit": (
        [GOOD + ",4,390"], HEADER + ",n_studs,total_load_kN",
        r"column total_load_kN = 390\.0: does not fit .*4 studs of 100 kN make 400 kN",
    ),
    "quotation mark left open": (
        ['lab,"A1,push-out,19,100,30,450,100'], HEADER, r"is not valid CSV",
    ),
    "empty name": ([",A1,push-out,19,100,30,450,100"], HEADER, r"column campaign = '': must"),
}  # fmt: skip


@pytest.mark.parametrize("case", MALFORMED, ids=str)
def test_a_malformed_table_gives_one_clear_message(tmp_path: Path, case: str) -> None:
    lines, header, message = MALFORMED[case]
    with pytest.raises(InputError, match=message) as caught:
        read_tests(table(tmp_path, *lines, header=header))
    text = str(caught.value)
    assert "tests.csv" in text
    assert "\n" not in text
    assert len(text) < 500


def test_there_are_twenty_malformed_tables() -> None:
    assert len(MALFORMED) >= 20


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"\n\n", "is empty"),
        (b"PK\x03\x04\0\0\0\0", "is binary data, not text"),
        (b"\x89PNG\r\n\x1a\n", "is not UTF-8 text"),
        (HEADER.encode() + b"\nlab,A1\xff,push-out,19,100,30,450,100\n", "line 2.*is not UTF-8"),
        (b"a" * 200_000, "has more than 65536 characters"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "tests.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_tests(path)


def test_a_missing_file_and_a_directory_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.csv.*cannot be read: No such file"):
        read_tests(tmp_path / "nothing.csv")
    with pytest.raises(InputError, match="is a directory"):
        read_tests(tmp_path)


def test_a_gigabyte_of_nonsense_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "huge.csv"
    with path.open("wb") as stream:
        stream.truncate(1_000_000_000)
    tracemalloc.start()
    with pytest.raises(InputError, match=r"huge\.csv = '1000 MB': must not exceed 20 MB"):
        read_tests(path)
    assert tracemalloc.get_traced_memory()[1] < LARGEST_FILE
    tracemalloc.stop()


def test_pipes_and_devices_are_refused_without_waiting_for_them(tmp_path: Path) -> None:
    path = tmp_path / "pipe.csv"
    os.mkfifo(path)  # nobody will ever write to it
    for endless in (path, Path("/dev/zero")):
        for read in (read_tests, check_file, load_scenario):
            with pytest.raises(InputError, match="a pipe or a device, which may never end"):
                read(endless)


def test_long_cells_and_headers_take_no_longer_than_their_length(tmp_path: Path) -> None:
    path = tmp_path / "tests.csv"
    digits = "1" * 50_000
    began = time.process_time()
    for shear in (digits + "x", digits + "." + digits[:9000] + "x", digits, "." + digits + "e"):
        path.write_text(f"{HEADER}\n{GOOD}{shear}\n")
        with pytest.raises(InputError, match="must be a number above 0 to 2000 kN"):
            read_tests(path)
    path.write_text(",".join(f"x_{i:x}" for i in range(9000)) + "\n1\n")
    with pytest.raises(InputError, match="required column missing"):
        read_tests(path)
    assert time.process_time() - began < 2.0


def test_bad_rows_take_nothing_else_with_them(tmp_path: Path) -> None:
    path = table(
        tmp_path, GOOD, "lab,A2,push-out,19,100,30,450,-1", "lab,A3,push-out,x,100,30,450,y",
        "lab,A4,push-out,19,100,30,450,99",
    )  # fmt: skip
    result = examine(path, TESTS)
    assert result.rows["specimen"].tolist() == ["A1", "A4"]
    assert [(p.line, p.column) for p in result.problems] == [
        (3, "shear_kN"), (4, "diameter_mm"), (4, "shear_kN"),
    ]  # fmt: skip
    assert read_tests(path, keep_good=True)["specimen"].tolist() == ["A1", "A4"]
    with pytest.raises(InputError, match=r"line 3, column shear_kN.*also look at line 4"):
        read_tests(path)


def test_a_byte_order_mark_and_blank_lines_do_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "tests.csv"
    path.write_text("\ufeff" + HEADER + "\r\n" + GOOD + "\r\n\r\n", encoding="utf-8")
    assert len(read_tests(path)) == 1


def test_the_same_specimen_may_have_many_points(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("campaign,specimen,slip_mm,load_kN\nlab,A,0.1,20\nlab,A,0.2,30\n")
    points = examine(path, POINTS).accept()
    assert points["single_specimen"].tolist() == [1.0, 1.0]
    assert points["branch"].tolist() == ["", ""]


def test_frames_and_texts_pass_the_same_checks() -> None:
    frame = pd.DataFrame({"campaign": ["l"], "specimen": ["s"], "slip_mm": [300.0], "load_kN": [1]})
    with pytest.raises(InputError, match="line 2, column slip_mm = 300"):
        from_frame(frame, POINTS)
    assert len(from_frame(frame.assign(slip_mm=3.0), POINTS)) == 1
    assert len(read_text(HEADER + "\n" + GOOD, TESTS).rows) == 1


def test_the_size_is_counted_where_it_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("workbench.base.tables.LARGEST_FILE", 200)
    with pytest.raises(InputError, match="the file exceeds"):
        read_text(HEADER + "\n" + "\n".join([GOOD] * 10), TESTS)
