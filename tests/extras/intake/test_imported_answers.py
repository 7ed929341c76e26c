"""Answers of other programs: they come in whole or not at all, and stand beside the models."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import workbench
from workbench.base.catalogue import check, dataset, datasets
from workbench.base.errors import InputError
from workbench.cli import run
from workbench.extras.intake.answers import Imported, contrasts, half_width, joined
from workbench.extras.intake.kinds import problems_of_own
from workbench.models.base import make_model
from workbench.report.chapters import choice
from workbench.responses import Outcome, collapse_of, findings_of, outcome_of
from workbench.scenarios import ColumnImpact, load_scenario
from workbench.study import Study, assess, load_study, run_study
from workbench.study.definition import Case, Figure

ROOT = Path(workbench.__file__).parents[1]
PROGRAM = "LS-DYNA, shell 10 mm"
STUDY = """
from workbench.scenarios import load_scenario
from workbench.models.base import make_model
from workbench.study import Case, Figure, Study

hit = load_scenario("scenario.toml")
names = "single-dof", "four-dof", "energy-estimate"
study = Study(
    "small",
    "Small",
    "How far?",
    tuple(Case(f"{v:g} m/s", hit.at_velocity(v)) for v in (10.0, 15.0)),
    {name: make_model(name) for name in names},
    "four-dof",
    figures=(
        Figure("over", "history", "Over time", "All.", names, {"cases": ("15 m/s",)}),
        Figure("slow", "history", "Slow", "All.", names, {"cases": ("10 m/s",)}),
    ),
)
"""


def readme() -> str:
    """The scenario that the README shows."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    block = page.partition("this one is the column of the thesis:")[2].partition("\nBlasts")[0]
    return "\n".join(line.removeprefix("    ") for line in block.splitlines())


def history(time: str = "time_ms", displacement: str = "displacement_mm", stop: int = 101) -> str:
    """A history of 300 mm at 40 ms with a contact force until then, a row per ms."""
    lines = [f"{time},{displacement},force_kN"]
    for ms in range(stop):
        moved = 300.0 * np.sin(0.5 * np.pi * min(ms, 40) / 40)
        moved -= 4.0 - 4.0 * np.cos(max(ms - 40, 0) / 3)
        lines.append(f"{ms},{moved:.6f},{600.0 if ms < 40 else 0.0:g}")
    return "\n".join(lines) + "\n"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A working directory of its own with the scenario of the README and an answer to it."""
    monkeypatch.delenv("WORKBENCH_DATA", raising=False)
    monkeypatch.chdir(tmp_path)
    Path("scenario.toml").write_text(readme(), encoding="utf-8")
    Path("result.csv").write_text(history(), encoding="utf-8")


def command(*more: str, file: str = "result.csv", model: str = PROGRAM) -> list[str]:
    """Arguments that add the answer."""
    given = ["--scenario", "scenario.toml", "--model", model, "--source", "Report 12"]
    return ["data", "add-answer", file, *given, *more]


def process(*arguments: str) -> subprocess.CompletedProcess[str]:
    """The command line in a process of its own."""
    code = "from workbench.cli import main; main()"
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)


def test_a_spoilt_entry_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(command()) == 0
    catalogue = Path("lab_data/catalogue.toml")
    text = catalogue.read_text(encoding="utf-8")
    assert "length_below" in text
    catalogue.write_text(text.replace("length_below", "length_belwo"), encoding="utf-8")
    capsys.readouterr()
    assert run(["simulate", "scenario.toml", "--model", "imported"]) == 2
    error = capsys.readouterr().err
    assert "answer result" in error
    assert "mend the entry or delete it" in error
    with pytest.raises(InputError, match="answer result"):
        load_study("thesis_column")


def test_a_history_in_another_unit_is_refused(capsys) -> None:
    """In mm, as its column does not say."""
    Path("result.csv").write_text(history(displacement="displacement_cm"), encoding="utf-8")
    assert run(command()) == 2
    assert "times as fast as the striker" in capsys.readouterr().err


def test_a_history_in_smaller_units_is_refused(capsys) -> None:
    """Centimetres under a column of millimetres."""
    rows = [line.split(",") for line in history().splitlines()]
    rows[1:] = [[row[0], str(0.1 * float(row[1])), *row[2:]] for row in rows[1:]]
    Path("result.csv").write_text("\n".join(map(",".join, rows)) + "\n", encoding="utf-8")
    code = run(command())
    assert (code, "times as fast as the striker" in capsys.readouterr().err) == (2, True)


@pytest.mark.thorough
def test_the_readme_column_becomes_a_line_of_the_flagship_with_two_commands() -> None:
    before = load_study("thesis_column").study
    added = process(*command("--uncertainty", "3 %", "--study", "thesis_column"))
    assert added.returncode == 0, added.stderr
    assert "It answers 15 m/s of thesis_column." in added.stdout
    study = load_study("thesis_column").study
    assert set(study.models) - set(before.models) == {PROGRAM}
    asked = {case.name for case in study.cases if PROGRAM in case.models}
    assert asked == {"10 m/s", "15 m/s", "20 m/s"}  # the group of the case that it answers
    shown = {figure.key for figure in study.figures if PROGRAM in figure.models}
    assert shown == {"shear-peaks", "rate", "figure-5-9a", "figure-5-9b"}
    assert PROGRAM in study.quickened().models
    assert (study.gates, study.groups) == (before.gates, before.groups)
    only = ("run", "thesis_column", "--jobs", "0", "--only", f"*/{PROGRAM}")
    done = process(*only)
    assert done.returncode == 0, done.stderr
    assert "1 ok" in done.stdout
    assert "2 out-of-domain" in done.stdout


@pytest.mark.thorough
def test_an_answer_is_drawn_compared_and_refused_outside_of_its_scenario() -> None:
    Path("small.py").write_text(STUDY, encoding="utf-8")
    for_all = ("small.py", "--store", "out")
    assert process("run", *for_all, "--jobs", "0").returncode == 0
    assert process("report", *for_all, "--format", "html").returncode == 0
    report = Path("out/small/report")
    first = {each: each.read_bytes() for each in sorted(report.rglob("*")) if each.is_file()}
    assert process(*command("--uncertainty", "6 mm")).returncode == 0
    done = process("run", *for_all, "--jobs", "0")
    assert done.returncode == 0, done.stderr
    assert "1 refused" in done.stdout  # in the matrix, as of a model
    assert process("report", *for_all, "--format", "html").returncode == 0
    assert PROGRAM in (report / "figures" / "over.csv").read_text(encoding="utf-8")
    assert PROGRAM not in (report / "figures" / "slow.csv").read_text(encoding="utf-8")
    result = assess(load_study("small.py").study, Path("out"))
    rows = result.records("comparisons", case="15 m/s", against=PROGRAM, model="single-dof")
    found = {(row["quantity"], row["metric"]): row for row in rows}
    assert found["peak_displacement", "relative_error"]["uncertainty"] > 0.0
    history_row = found["displacement", "sprague_geers_magnitude"]
    assert history_row["error"] == history_row["error"]
    assert history_row["uncertainty"] is None  # unknown, not zero
    (refusal,) = result.cells["10 m/s", PROGRAM].findings
    assert refusal.text.endswith("striker.velocity: theirs 15.0, ours 10.0")
    assert PROGRAM not in {row["label"] for row in result.records("cost")}  # a table has no cost
    Path("lab_data/catalogue.toml").unlink()
    Path("lab_data/result.csv").unlink()
    assert process("run", *for_all, "--jobs", "0").returncode == 0
    assert process("report", *for_all, "--format", "html").returncode == 0
    again = {each: each.read_bytes() for each in sorted(report.rglob("*")) if each.is_file()}
    assert again == first  # bit for bit


def test_an_exact_answer_has_a_row_and_is_not_the_model_to_take(tmp_path: Path) -> None:
    hit = load_scenario("scenario.toml")
    models = {name: make_model(name) for name in ("four-dof", "single-dof")}
    exact = models["four-dof"].simulate(hit)
    rows = pd.DataFrame({"time_s": exact["time"], "displacement_m": exact["displacement"]})
    rows.to_csv("result.csv", index=False)
    assert run(command("--uncertainty", "0.1 %")) == 0
    study = joined(Study("s", "S", "?", (Case("hit", hit),), models, "four-dof"))
    run_study(study, tmp_path / "out", jobs=0)
    result = assess(study, tmp_path / "out")
    (row,) = result.records("matrix", label=PROGRAM)
    assert row["peak_displacement_bias"] == pytest.approx(1.0, abs=1e-5)
    assert choice.named(study, result, [row["group"]]) == {"single-dof"}


def test_without_answers_a_study_is_itself() -> None:
    study = load_study("thesis_column").study
    assert joined(study) is study
    assert run(command()) == 0
    assert joined(study) is not study
    Path("lab_data/result.csv").unlink()  # half taken back: `data check` says so
    assert joined(study) is study
    assert any("result.csv is missing" in problem for problem in check())


def test_simulate_answers_by_an_answer_and_lists_what_differs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(command("--uncertainty", "4 mm")) == 0
    capsys.readouterr()
    asked = ["simulate", "scenario.toml", "--model", "imported", "--option", "answer=result"]
    assert run([*asked, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["peak_displacement"] == pytest.approx(0.3, rel=2e-3)
    assert answer["impulse"] == pytest.approx(600e3 * 0.0395, rel=1e-9)
    assert run([*asked, "--set", "striker.velocity=20", "--set", "column.base=pinned"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "column.base: theirs 'clamped', ours 'pinned'; striker.velocity: theirs 15.0" in said
    assert run([*asked, "--set", "time.duration=0.3"]) == 0  # no part of the scenario
    assert run(["data", "show", "result"]) == 0
    assert run(["data", "list"]) == 0
    assert PROGRAM in capsys.readouterr().out
    assert run(["simulate", "scenario.toml", "--model", "imported", "--option", "answer=x"]) == 2
    assert "there are result" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "width"), [("3 %", 0.009), ("4 mm", 0.004), ("0.01 m", 0.01), ("not known", None)]
)
def test_the_uncertainty_is_of_the_peak_or_a_length(text: str, width: float | None) -> None:
    assert half_width(text, 0.3) == (None if width is None else pytest.approx(width))
    assert run(command("--uncertainty", text)) == 0
    response = Imported("result").simulate(load_scenario("scenario.toml"))
    widths = json.loads(response.attrs["data_uncertainty"])
    peak = float(response["peak_displacement"])
    assert widths.get("peak_displacement") == half_width(text, peak)


@pytest.mark.parametrize("text", ["3", "-1 %", "0 mm", "2 kN", "120 %", "nan %", "", "3 % or so"])
def test_an_uncertainty_that_cannot_be_meant_is_refused(
    text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(command("--uncertainty", text)) == 2
    assert "uncertainty" in capsys.readouterr().err
    assert not Path("lab_data").exists()


def changed(old: str, new: str) -> Callable[[], str]:
    def text() -> str:
        assert old in history()
        return history().replace(old, new)

    return text


BIG = "9" * 10_000_000
BAD: dict[str, tuple[Callable[[], str], str]] = {
    "column": (changed("displacement_mm", "displ_mm"), "did you mean displacement_m"),
    "no displacement": (changed("displacement_mm", "velocity_mm/s"), "required column missing"),
    "unit": (changed("displacement_mm", "displacement_furlong"), "displacement_furlong"),
    "no unit": (changed("time_ms", "time"), "says no unit"),
    "unit of another quantity": (changed("displacement_mm", "displacement_ms"), "displacement_ms"),
    "mm for m": (changed("displacement_mm", "displacement_m"), "is it in mm?"),
    "m for mm": (lambda: history(displacement="displacement_um"), "displacement_um"),
    "s for ms": (changed("time_ms", "time_s"), "times as fast as the striker"),
    "us for ms": (changed("time_ms", "time_us"), "times as fast as the striker"),
    "time falls": (changed("\n20,", "\n18.5,"), "must be later than the row before, 0.019 s"),
    "time stands": (changed("\n20,", "\n19,"), "must be later"),
    "nan": (changed("\n20,2", "\n20,nan2"), "line 22, column displacement_m"),
    "a nan": (changed(",600\n21", ",nan\n21"), "the number must be finite"),
    "empty": (changed(",600\n21", ",\n21"), "force_N"),
    "ends early": (lambda: history(stop=35), "ends before its peak"),
    "late": (lambda: history().replace("\n0,", "\n-9,"), "time_s (from time_ms in ms)"),
    "against the strike": (lambda: history().replace(",", ",-"), "is no column"),
    "formula": (changed("\n20,2", "\n20,=cmd|'/c calc'!A1"), "write the number alone"),
    "html": (changed("\n20,2", "\n20,<img src=x onerror=alert(1)>"), "write the number alone"),
    "path": (changed("\n20,2", "\n20,../../etc/passwd"), "write the number alone"),
    "10 MB cell": (lambda: history() + f"101,{BIG},0\n", "has more than 65536 characters"),
    "binary": (lambda: history() + "101,\0,0\n", "binary data"),
    "cells": (changed(",600\n21", "\n21"), "has 2 cells where the header has 3"),
    "header alone": (lambda: "time_ms,displacement_mm\n", "must hold one row or more"),
    "empty file": (lambda: "", "is empty"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_history_is_refused_with_one_message_and_nothing_written(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text, said = BAD[name]
    Path("result.csv").write_text(text(), encoding="utf-8")
    assert run(command()) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.err.count("\n") == 1
    assert len(captured.err) < 1000
    assert captured.out == ""
    assert not Path("lab_data").exists()


def test_a_history_that_goes_the_other_way_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    rows = [line.split(",") for line in history().splitlines()[1:]]
    lines = [f"{time},{-float(moved)},{force}" for time, moved, force in rows]
    Path("result.csv").write_text("\n".join([history().splitlines()[0], *lines]), encoding="utf-8")
    assert run(command()) == 2
    assert "change the sign" in capsys.readouterr().err


def test_a_clock_that_starts_before_the_contact_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = [line.split(",") for line in history().splitlines()[1:]]
    lines = [f"{float(time) + 20},{moved},{force}" for time, moved, force in rows]
    Path("result.csv").write_text("\n".join([history().splitlines()[0], *lines]), encoding="utf-8")
    assert run(command()) == 2
    assert "from first contact" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--scenario", "none.toml"), "scenario file"),
        (("--scenario", "result.csv"), "not valid TOML"),
        (("--outcome", "boom"), "collapse"),
        (("--units", "displacement"), "must look like displacement=mm"),
        (("--units", "x=mm"), "does not have"),
        (("--name", "../../evil"), "must be lower-case letters"),
        (("--name", "thickness"), ""),
        (("--source", "unknown"), "must say it"),
        (("--model", "x" * 200), "--model"),
        (("--model", "two\nlines"), "title"),
        (("--model", " "), "title"),
        (("--mapping", "none.toml"), "mapping file"),
        (("--study", "none"), "is not known"),
    ],
)
def test_a_bad_option_is_refused(
    more: tuple[str, str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    status = run(command(*more))
    if not said:
        assert status == 0
        return
    assert status == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert not Path("lab_data").exists()


def test_another_scenario_than_that_of_the_study_is_listed_input_by_input() -> None:
    text = readme().replace("velocity = 15.0", "velocity = 14.0").replace("1500.0", "1400.0")
    Path("scenario.toml").write_text(text, encoding="utf-8")
    done = process(*command("--study", "thesis_column"))
    assert done.returncode == 2
    assert "beside its case" in done.stderr
    assert "striker.mass: theirs 1400.0, ours 1500.0" in done.stderr
    assert "striker.velocity: theirs 14.0" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not Path("lab_data").exists()


def test_what_tables_of_sections_round_makes_no_other_scenario() -> None:
    ours = load_scenario("scenario.toml")
    assert isinstance(ours, ColumnImpact)
    area = ours.column.properties.area
    near = replace(ours, column=replace(ours.column, area=1.0009 * area), name="x", duration=0.3)
    differ, rounded = contrasts(near, ours)
    assert differ == []
    assert len(rounded) == 1
    far = replace(ours, column=replace(ours.column, area=1.002 * area))
    assert len(contrasts(far, ours)[0]) == 1
    assert run(command()) == 0
    (noted,) = [f for f in findings_of(Imported().simulate(near)) if "0.1 %" in f.text]
    assert not noted.outside
    assert outcome_of(Imported().simulate(far)) is Outcome.OUT_OF_DOMAIN


def test_a_collapse_is_an_answer() -> None:
    Path("result.csv").write_text(history(stop=30), encoding="utf-8")
    assert run(command("--outcome", "shear")) == 0
    collapse = collapse_of(Imported().simulate(load_scenario("scenario.toml")))
    assert collapse is not None
    assert (collapse.mechanism, collapse.time) == ("shear", 0.029)
    assert collapse.displacement == pytest.approx(0.3 * np.sin(0.5 * np.pi * 29 / 40))
    assert problems_of_own() == []


def test_units_stand_in_a_row_in_an_option_or_in_a_mapping() -> None:
    plain = history().replace("time_ms", "time").replace("displacement_mm", "displacement")
    Path("row.csv").write_text(plain.replace("force_kN\n", "force\nms,mm,kN\n"), encoding="utf-8")
    Path("option.csv").write_text(plain, encoding="utf-8")
    own = history().replace("time_ms", "T [ms]").replace("displacement_mm", "UX [mm]")
    Path("own.csv").write_text(own.replace("force_kN", "junk"), encoding="utf-8")
    Path("map.toml").write_text(
        'title = "t"\nsource = "s"\nlicence = "MIT"\nyear = 2026\nrole = "verify"\n'
        'ignore = ["junk"]\n[columns]\n"T" = "time_s"\n"UX" = "displacement_m"\n',
        encoding="utf-8",
    )
    assert run(command(file="row.csv", model="a")) == 0
    units = ("--units", "time=ms", "--units", "displacement=mm")
    assert run(command(*units, file="option.csv", model="b")) == 0
    assert run(command("--mapping", "map.toml", file="own.csv", model="c")) == 0
    assert dataset("own").licence == "MIT"
    scenario = load_scenario("scenario.toml")
    peaks = {float(Imported(n).simulate(scenario)["peak_displacement"]) for n in ("a", "b", "own")}
    assert len(peaks) == 1


@pytest.mark.claim("model:imported", "peak of a table in inches, m", "closed form", 0.03, 3e-6)
def test_a_workbook_in_inches_answers_a_frame(capsys: pytest.CaptureFixture[str], claim) -> None:
    from openpyxl import Workbook

    assert run(["new", "frame"]) == 0
    Path("scenario.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    book = Workbook()
    rows = [line.split(",") for line in history().splitlines()[1:]]
    book.active.append(["time", "displacement"])
    book.active.append(["ms", "in"])
    for time, moved, _ in rows:
        book.active.append([float(time), float(moved) / 254.0])  # a tenth of it
    book.save("frame.xlsx")
    assert run(command(file="frame.xlsx")) == 0
    response = Imported("frame").simulate(load_scenario("scenario.toml"))
    claim(response["peak_displacement"])
    assert "residual_displacement" not in response  # without a force nobody knows when it is over


def test_energies_make_a_ledger_only_with_the_force() -> None:
    lines = history().splitlines()
    for name, header in (("with", lines[0]), ("without", lines[0].rpartition(",")[0])):
        rows = [f"{header},kinetic_kJ,elastic_kJ,dissipated_kJ"]
        for line in lines[1:]:
            kept = line if name == "with" else line.rpartition(",")[0]
            rows.append(f"{kept},100,8.75,60")
        Path(f"{name}.csv").write_text("\n".join(rows), encoding="utf-8")
        assert run(command(file=f"{name}.csv", model=name)) == 0
        response = Imported(name).simulate(load_scenario("scenario.toml"))
        assert float(response["kinetic"][0]) == 100e3
        assert ("balance_error" in response) == (name == "with")
        if name == "with":  # of 168.75 kJ, stored energy counts from its begin
            assert float(response["balance_error"][-1]) == pytest.approx(8.75e3)


def test_a_push_takes_no_history(capsys: pytest.CaptureFixture[str]) -> None:
    column = readme().partition("[striker]")[0].replace("column-impact", "column-pushover")
    Path("scenario.toml").write_text(column + "[pushover]\ndisplacement = 0.1\n", encoding="utf-8")
    assert run(command()) == 2
    assert "column-pushover" in capsys.readouterr().err


def test_the_same_answer_twice_changes_nothing_and_another_one_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(command()) == 0
    before = Path("lab_data/catalogue.toml").read_bytes()
    assert run(command("--name", "again")) == 0
    assert "Nothing was written" in capsys.readouterr().out
    Path("other.csv").write_text(history(stop=90), encoding="utf-8")
    assert run(command(file="other.csv")) == 2
    assert "has answered this scenario already, as result" in capsys.readouterr().err
    assert Path("lab_data/catalogue.toml").read_bytes() == before
    assert run(command(file="other.csv", model="Abaqus")) == 0
    refused = Imported().simulate(load_scenario("scenario.toml"))  # which of the two?
    assert "result, other" in refused.attrs["message"]
    text = readme().replace("velocity = 15.0", "velocity = 10.0")
    Path("scenario.toml").write_text(text, encoding="utf-8")
    assert run(command("--name", "slower")) == 0  # the same program, another scenario
    assert [e.name for e in Imported(PROGRAM).entries] == ["result", "slower"]


def test_stored_answers_are_checked_again() -> None:
    assert run(command()) == 0
    assert problems_of_own() == []
    table = Path("lab_data/result.csv")
    lines = table.read_text(encoding="utf-8").splitlines()
    table.write_text("\n".join([*lines[:30], *lines[20:]]), encoding="utf-8")
    (problem,) = problems_of_own()
    assert "must be later than the row before" in problem
    digest = Imported("result").data_digest
    table.write_text("\n".join(lines), encoding="utf-8")
    assert Imported("result").data_digest != digest  # stored cells follow


def test_a_history_without_its_scenario_is_no_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["data", "add", "result.csv", "--kind", "answers"]) == 2
    assert "data add-answer" in capsys.readouterr().err
    assert not Path("lab_data").exists()


def test_no_answer_at_all_is_a_refusal() -> None:
    assert not any(entry.kind == "answers" for entry in datasets())
    refused = make_model("imported").simulate(load_scenario("scenario.toml"))
    assert outcome_of(refused) is Outcome.OUT_OF_DOMAIN
    assert "workbench data add-answer" in refused.attrs["message"]
    with pytest.raises(InputError, match="there are none"):
        Imported("result")


@pytest.mark.thorough
def test_a_name_is_shown_and_never_executed() -> None:
    hostile = "<script>alert(1)</script> =cmd|' /C calc'!A0"
    Path("small.py").write_text(STUDY, encoding="utf-8")
    assert run(command(model=hostile)) == 0
    assert run(["run", "small.py", "--jobs", "0", "--store", "out"]) == 0
    assert run(["report", "small.py", "--store", "out", "--format", "html"]) == 0
    page = Path("out/small/report/report.html").read_text(encoding="utf-8")
    assert "<script>alert(1)" not in page
    assert "&lt;script&gt;alert(1)" in page
    explorer = Path("out/small/report/explorer.html").read_text(encoding="utf-8")
    assert "<script>alert(1)" not in explorer
    tables = [each.read_text(encoding="utf-8") for each in Path("out/small").rglob("*.csv")]
    assert any(hostile in each for each in tables)


def test_a_label_that_a_study_has_is_told_apart() -> None:
    assert run(command(model="four-dof")) == 0
    hit = load_scenario("scenario.toml")
    models = {name: make_model(name) for name in ("four-dof", "single-dof")}
    figure = Figure("all", "history", "All", "All.", ("four-dof",))
    study = Study("s", "S", "?", (Case("hit", hit),), models, "four-dof", figures=(figure,))
    both = joined(study)
    assert [*both.models] == ["four-dof", "single-dof", "four-dof (imported)"]
    assert both.figures[0].models == ("four-dof", "four-dof (imported)")
