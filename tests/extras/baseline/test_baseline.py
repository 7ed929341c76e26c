"""Physics baselines: what moves is told in physical terms, and taken over for a reason only."""

import tomllib
from pathlib import Path

import pytest

from workbench.base.datafiles import data_directory
from workbench.cli import run
from workbench.extras.baseline.baseline import of_other_versions, read_baselines
from workbench.models.base import model_kind, model_names
from workbench.models.references.fiber_beams import FiberShear

PLAN = """
model = { hand-estimate = {}, en-1991-hard-impact = {} }
case.hit = { file = "published/heng2017_impact_column.toml", set = ["striker.velocity=10"] }
case.light = { file = "published/heng2017_impact_column.toml", set = ["striker.mass=100"] }
"""
ELSEWHERE = {"imported", "opensees", "remote"}  # their programs, or files, are not here


@pytest.fixture
def table(tmp_path: Path) -> Path:
    (tmp_path / "own.toml").write_text(PLAN, encoding="utf-8")
    file = tmp_path / "own.csv"
    file.touch()
    assert run(["baseline", "mint", "--reason=first", "--jobs=1", f"--table={file}"]) == 0
    return file


def said(capsys: pytest.CaptureFixture[str], status: int, table: Path, *mint: str) -> str:
    """What a check says, or minting for a reason, and that it ends with this status."""
    verb = ["mint", "--reason", *mint] if mint else ["check"]
    capsys.readouterr()
    assert run(["baseline", *verb, "--jobs", "1", "--table", str(table)]) == status
    return " ".join("".join(capsys.readouterr()).split())


def edit(table: Path, old: str, new: str) -> bytes:
    text = table.read_text(encoding="utf-8")
    assert old in text
    table.write_text(text.replace(old, new), encoding="utf-8")
    return table.read_bytes()


def peak(table: Path, factor: float = 1.0) -> str:
    """Peak of the hand estimate in the first scenario, changed by a factor."""
    value = read_baselines(table)[1]["hit", "hand-estimate", "peak_displacement"]["value"]
    edit(table, value, changed := f"{float(value) * factor:.6g}")
    return changed


def test_a_number_that_moves_is_told_and_not_taken_over_under_its_version(table, capsys) -> None:
    now = peak(table)
    peak(table, 1.0009)
    assert "0 differ" in said(capsys, 0, table)
    before = peak(table, 1.0 / 1.0079)
    text = said(capsys, 1, table)
    values = " -> ".join(f"{float(each) * 1e3:#.4g} mm" for each in (before, now))
    assert f"`peak_displacement` of `hand-estimate` in `hit`: {values}, +0.70 %" in text
    assert "model version 2 unchanged: raise it, and give a reason" in text
    moved = table.read_bytes()
    assert "nothing is written" in said(capsys, 1, table, "better")
    assert table.read_bytes() == moved


def test_numbers_of_a_new_version_are_taken_over_for_a_reason(table, capsys) -> None:
    now = peak(table)
    peak(table, 1.2)
    edit(table, ",hand-estimate,2,", ",hand-estimate,1,")
    text = said(capsys, 1, table)
    assert "%; model version 1 -> 2" in text
    assert "`hand-estimate` in `light`: model version 1 -> 2" in text
    said(capsys, 0, table, "Momentum of the whole column.")
    assert "0 differ" in said(capsys, 0, table)
    reasons, lines = read_baselines(table)
    assert [reason[11:] for reason in reasons] == ["first", "Momentum of the whole column."]
    assert peak(table) == now
    assert {each["model"] for each in lines.values() if each["change"] == "2"} == {"hand-estimate"}


def test_another_end_a_scenario_that_goes_and_other_inputs_are_told(table, capsys) -> None:
    edit(table, "light,en-1991-hard-impact", "gone,en-1991-hard-impact")
    edit(table, "outcome,ok", "outcome,collapse")
    text = said(capsys, 1, table)
    assert "`outcome` of `hand-estimate` in `hit`: collapse -> ok; model version" in text
    assert "`outcome` of `en-1991-hard-impact` in `gone`: collapse -> none" in text
    edit(table.with_suffix(".toml"), "velocity=10", "velocity=11")
    assert "scenario, options or data are others" in said(capsys, 1, table)


@pytest.mark.parametrize(
    ("old", "new", "reason", "message"),
    [
        ("first", "first", " ", "--reason"),
        ("first", "first", "two\nlines", "--reason"),
        (",m,1", ",m,2", "why", "restore the line"),
        (",m,1", ",m", "why", "restore the line"),
        ("light,", "hit,", "why", "stands twice"),
    ],
)
def test_bad_inputs_are_refused(table, capsys, old, new, reason, message) -> None:
    before = edit(table, old, new)
    assert message in said(capsys, 2, table, reason)
    assert table.read_bytes() == before
    assert "No such file" in said(capsys, 2, table.with_name("none.csv"))


@pytest.mark.parametrize(("old", "new"), [("case.hit =", "case.hit"), ("file", "fil"), ("{}", "1")])
def test_a_plan_that_is_none_is_refused(table, capsys, old, new) -> None:
    edit(table.with_suffix(".toml"), old, new)
    assert "own.toml: is no plan" in said(capsys, 2, table)


def test_the_shipped_table_is_of_the_models_as_they_are() -> None:
    file = data_directory() / "baselines.csv"
    lines = read_baselines(file)[1].values()
    models = tomllib.loads(file.with_suffix(".toml").read_text(encoding="utf-8"))["model"]
    names = {label: of.get("of", label) for label, of in models.items()}
    assert len(lines) >= 300
    assert len({line["scenario"] for line in lines}) >= 30
    assert {names[line["model"]] for line in lines} == {*model_names()} - ELSEWHERE
    for line in lines:  # else: workbench baseline check, then mint
        assert line["version"] == str(model_kind(names[line["model"]]).version), line


def test_tables_of_other_versions_are_refused_at_release(monkeypatch) -> None:
    before = of_other_versions()
    monkeypatch.setattr(FiberShear, "version", 99)
    stale = [text for text in of_other_versions() if text not in before]
    assert all("with `fiber-shear` 8, which is now 99" in text for text in stale)
    assert {text.split("`")[1] for text in stale} >= {"validation/columns.csv", "bench/column-01"}
