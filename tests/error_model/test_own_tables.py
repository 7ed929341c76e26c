"""Tables of one's own that are no tables end in one line each, whatever reads them."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import pytest

from workbench.base.catalogue import check, load
from workbench.base.errors import InputError
from workbench.cli import run

ENTRY = """
[[dataset]]
name = "mine"
title = "Points"
file = "mine.csv"
source = "me"
licence = "CC0"
role = "verify"
uncertainty = "unknown"
columns = { name = "whose", value = "how much" }
"""
GOOD = b"name,value\nNA,1\nNone,2\n"


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "catalogue.toml").write_text(ENTRY, "utf-8")
    (tmp_path / "mine.csv").write_bytes(GOOD)
    monkeypatch.setenv("WORKBENCH_DATA", str(tmp_path))
    return tmp_path / "mine.csv"


def test_names_that_look_missing_are_names(mine: Path) -> None:
    assert load("mine")["name"].tolist() == ["NA", "None"]
    mine.write_bytes(b"name,value\nnull,\n,nan\n")
    assert load("mine").isna().to_numpy().tolist() == [[False, True], [True, False]]


@pytest.mark.parametrize(
    "broken",
    [
        lambda table: table + b"a,1,2,3\n",
        lambda table: table.replace(b"1\n", b"1,9\n").replace(b"2\n", b"2,9\n"),
        lambda table: table.replace(b"NA", "Stöß".encode("latin-1")),
        lambda table: table.decode().encode("utf-16"),
        lambda table: b"",
        lambda table: b"\n\n",
        lambda table: b'"' + table,
        lambda table: random.Random(1).randbytes(4000),
    ],
    ids=["ragged", "all ragged", "latin-1", "utf-16", "empty", "blank", "quoted", "binary"],
)
def test_a_table_that_is_none_is_one_line(
    mine: Path, broken: Callable[[bytes], bytes], capsys: pytest.CaptureFixture[str]
) -> None:
    mine.write_bytes(broken(GOOD))
    assert run(["data", "show", "mine"]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert "dataset mine" in shown.err
    assert "save it as CSV (UTF-8)" in shown.err
    assert run(["data", "check"]) == 1
    assert "dataset mine: cannot be read" in capsys.readouterr().out


def test_a_table_without_rows_or_of_other_columns_is_shown(
    mine: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine.write_bytes(b"name,value\n")
    assert run(["data", "show", "mine"]) == 0
    mine.write_bytes(b"name,worth\na,1\n")
    assert run(["data", "show", "mine"]) == 0
    assert "worth" in capsys.readouterr().out
    assert [text.split(":")[1] for text in check()] == [
        " column worth is not described",
        " column value is missing in the file",
    ]


def test_what_is_no_file_is_not_waited_for(mine: Path) -> None:
    mine.unlink()
    mine.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="is a pipe or a device"):
        load("mine")
    assert check() == ["dataset mine: file mine.csv is missing"]
