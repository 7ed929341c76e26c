"""Malformed tables through the command: one message, exit status 2, no traceback, quickly."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from workbench.cli import run

HEADER = "campaign,specimen,test,diameter_mm,height_mm,fcm_MPa,fu_MPa,shear_kN"
GOOD = "lab,A1,push-out,19,100,30,450,100"
LEAST_MEMORY = 400_000  # kB: what the libraries need; a file read into memory would be 1 GB more
# A small parent: a process counts the memory of the parent that it was forked from as its own.
MEASURE = """
import resource, subprocess, sys
status = subprocess.run(sys.argv[1:]).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(status, used.ru_maxrss, used.ru_utime + used.ru_stime)
"""


def command(verb: str, file: str) -> list[str]:
    code = "from workbench.cli import main; main()"
    return [sys.executable, "-c", code, "fit", verb, file]


def rows(*lines: str, header: str = HEADER) -> bytes:
    return ("\n".join([header, *lines]) + "\n").encode()


# name: (content, what the message must say)
MALFORMED: dict[str, tuple[bytes, str]] = {
    "diameter in metres": (rows("lab,A1,push-out,0.019,100,30,450,100"), "lengths are in mm"),
    "strength in pascals": (rows("lab,A1,push-out,19,100,30e6,450,100"), "stresses are in MPa"),
    "load in newtons": (rows("lab,A1,push-out,19,100,30,450,100000"), "loads are in kN per stud"),
    "load in meganewtons": (rows("lab,A1,push-out,19,100,30,450,0.1"), "MPa over a shank of 19 mm"),
    "missing column": (rows("A1,push-out,100", header="specimen,test,shear_kN"), "'campaign': req"),
    "unknown column": (rows(GOOD + ",3", header=HEADER + ",fcm_Mpa"), "did you mean fcm_MPa?"),
    "column twice": (rows(GOOD + ",3", header=HEADER + ",fu_MPa"), "the column stands twice"),
    "text in a number": (rows("lab,A1,push-out,19,100,about 30,450,100"), "no unit, no words"),
    "specimen twice": (rows(GOOD, GOOD), "stands in line 2 too"),
    "negative load": (rows("lab,A1,push-out,19,100,30,450,-100"), "column shear_kN = -100.0"),
    "not a number": (rows("lab,A1,push-out,nan,100,30,450,100"), "must be finite"),
    "infinite": (rows("lab,A1,push-out,19,100,30,450,inf"), "must be finite"),
    "decimal commas": (rows(GOOD, "lab,A2,push-out,19,05,100,30,450,100"), "decimal points"),
    "quoted decimal comma": (rows('lab,A1,push-out,"19,05",100,30.1,450,99.5'), "point as"),
    "bars": (rows(GOOD.replace(",", "|"), header=HEADER.replace(",", "|")), "unknown column"),
    "thousands separator": (rows('lab,A1,push-out,19,100,30,450,"1,000.5"'), "no unit, no words"),
    "underscore": (rows("lab,A1,push-out,1_9,100,30,450,100"), "diameter_mm = '1_9'"),
    "digits of another script": (rows("lab,A1,push-out,\u0661\u0669,100,30,450,100"), "no words"),
    "specimen twice but for case": (rows(GOOD, GOOD.replace("A1", "a1")), "stands in line 2 too"),
    "campaign in two spellings": (rows(GOOD, GOOD.replace("lab,A1", "Lab,A2")), "is spelled lab"),
    "too many cells": (rows(GOOD + ",5,6"), "has 10 cells where the header has 8"),
    "trailing commas": (rows(GOOD + ",,", header=HEADER + ",,"), "column 9 has no name"),
    "line end in a cell": (rows(GOOD.replace("A1", '"A\n1"')), "must be one line"),
    "beyond any float": (rows("lab,A1,push-out,19,100,30,450,1e400"), "must be finite"),
    "negative zero": (rows("lab,A1,push-out,19,100,30,450,-0"), "column shear_kN = -0.0"),
    "empty file": (b"", "is empty"),
    "only a header": (rows(), "must hold one row or more"),
    "binary": (b"PK\x03\x04\0\0\0\0" * 10, "is binary data, not text"),
    "UTF-16": ((HEADER + "\n" + GOOD).encode("utf-16"), "save the table as CSV (UTF-8)"),
    "Latin-1": (rows(GOOD).replace(b"A1", b"A\xe9"), "line 2 = b"),
    "unknown kind of test": (rows("lab,A1,push,19,100,30,450,100"), "must be one of push-out"),
    "unknown pre-damage": (rows(GOOD + ",rust", header=HEADER + ",predamage"), "must be one of"),
    "level in per cent": (
        rows(GOOD + ",fatigue,life fraction,40",
             header=HEADER + ",predamage,predamage_measure,predamage_level"), "40 % is 0.4",
    ),
    "no line ends": (b"a" * 200_000, "has more than 65536 characters"),
    "quotation mark left open": (rows('lab,"A1,push-out,19,100,30,450,100'), "is not valid CSV"),
    "nothing to fit": (rows("lab,A1,pull-out,19,100,30,450,100", header=HEADER.replace(
        "shear_kN", "tension_kN")), "holds no undamaged headed stud"),
}  # fmt: skip


def check_message(status: int, out: str, err: str, name: str) -> None:
    assert status == 2, err
    assert out == ""
    assert err.startswith("workbench: ")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert MALFORMED[name][1] in err
    if name != "nothing to fit":
        assert "tests.csv" in err


@pytest.mark.parametrize("name", MALFORMED)
def test_a_malformed_table_is_one_message_and_status_2(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "tests.csv"
    file.write_bytes(MALFORMED[name][0])
    status = run(["fit", "stud-strength", str(file)])
    check_message(status, *capsys.readouterr(), name)


def test_a_process_says_the_same(tmp_path: Path) -> None:
    name, file = "decimal commas", tmp_path / "tests.csv"
    file.write_bytes(MALFORMED[name][0])
    done = subprocess.run(command("stud-strength", str(file)), capture_output=True, text=True)
    check_message(done.returncode, done.stdout, done.stderr, name)


def test_there_are_more_than_twenty() -> None:
    assert len(MALFORMED) >= 20


@pytest.mark.parametrize(
    ("verb", "content", "message"),
    [
        ("load-slip", b"campaign,specimen,slip_mm\nlab,A,0.1\n", "required column missing"),
        ("load-slip", b"campaign,specimen,slip_mm,load_kN\nlab,A,x,3\n", "column slip_mm = 'x'"),
        ("load-slip", b"campaign,specimen,slip_mm,load_kN\nlab,A,0.1,3\n", "two curves or more"),
        ("residual", b"", "is empty"),
    ],
)
def test_the_other_verbs_refuse_alike(
    tmp_path: Path, verb: str, content: bytes, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "tests.csv"
    file.write_bytes(content)
    assert run(["fit", verb, str(file)]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert message in err


@pytest.mark.parametrize("value", ["-1", "0", "nan", "1e9"])
def test_an_impossible_specified_strength_is_refused(
    capsys: pytest.CaptureFixture[str], value: str
) -> None:
    assert run(["fit", "stud-strength", "--specified-fu", value]) == 2
    errors = capsys.readouterr().err
    assert errors.startswith("workbench: --specified-fu = ")
    assert "from 200 to 1500 MPa" in errors


def test_missing_files_and_directories(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for file, text in ((tmp_path / "no.csv", "No such file"), (tmp_path, "is a directory")):
        assert run(["fit", "stud-strength", str(file)]) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        assert text in err


@pytest.mark.thorough
def test_a_gigabyte_of_nonsense_is_refused_early(tmp_path: Path) -> None:
    """A sparse file of 1 GB: refused by its size, in the time and memory of an empty one."""
    huge, empty = tmp_path / "huge.csv", tmp_path / "empty.csv"
    with huge.open("wb") as stream:
        stream.truncate(1_000_000_000)
    empty.write_bytes(b"")
    seconds = {}
    for file, text in ((empty, "is empty"), (huge, "must not exceed 20 MB")):
        done = subprocess.run(
            [sys.executable, "-c", MEASURE, *command("stud-strength", str(file))],
            capture_output=True,
            text=True,
        )
        status, memory, seconds[file] = (float(word) for word in done.stdout.split())
        assert status == 2
        assert text in done.stderr
        assert done.stderr.count("\n") == 1
        assert memory < LEAST_MEMORY
    assert seconds[huge] < 2.0 * seconds[empty]  # of the processor, whatever else it has to do


def test_a_byte_order_mark_does_no_harm(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "tests.csv"
    lines = [
        f"lab {j},A{i},push-out,19,100,30,450,{100 + 3 * i + j}" for j in (1, 2) for i in (1, 2)
    ]
    file.write_bytes(b"\xef\xbb\xbf" + rows(*lines).replace(b"\n", b"\r\n"))
    assert run(["fit", "stud-strength", str(file)]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    assert "4 tests of lab 1, lab 2" in captured.out
