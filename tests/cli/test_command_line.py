from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from workbench.cli import run
from workbench.scenarios import ColumnImpact, ColumnPushover, to_toml

HEAVY = (
    *("numpy", "scipy", "numba", "xarray", "pandas", "matplotlib", "rich", "typst", "bokeh"),
    *(
        "jinja2",
        "pydantic",
        "waitress",
        "panel",
        "tornado",
        "pebble",
        "workbench.models",
        "workbench.scenarios",
    ),
    "workbench.studs",
)
NOT_ASKED = (  # of an answer
    *("scipy.optimize", "scipy.special", "scipy.stats", "matplotlib", "typst", "bokeh", "jinja2"),
    *("workbench.models.references", "workbench.mechanics.structures.space", "workbench.studs"),
    *("workbench.study.store", "workbench.study.runner", "workbench.extras", "waitress"),
)


def process(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", "from workbench.cli import main; main()", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
    )


@pytest.fixture
def scenario_file(thesis_impact: ColumnImpact, tmp_path: Path) -> Path:
    path = tmp_path / "scenario.toml"
    path.write_text(to_toml(thesis_impact))
    return path


def unasked(modules: tuple[str, ...], *arguments: str) -> str:
    """What the command line prints, after a check that it imported none of the modules."""
    code = (
        "import sys\n"
        "from workbench.cli import run\n"
        "status = run(sys.argv[1:])\n"
        f"heavy = [name for name in {modules!r} if name in sys.modules]\n"
        "print('loaded', heavy, status, file=sys.stderr)\n"
    )
    call = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(call, capture_output=True, text=True)
    assert done.stderr.splitlines()[-1] == "loaded [] 0"
    return done.stdout


@pytest.mark.parametrize("model", ["four-dof", "energy-estimate"])
def test_an_answer_imports_only_what_it_takes(model: str, scenario_file: Path) -> None:
    assert f"by {model}, as asked" in unasked(
        NOT_ASKED, "simulate", str(scenario_file), "--model", model
    )


def test_help_imports_nothing_heavy() -> None:
    text = unasked(HEAVY, "--help")
    for verb in (
        "models",
        "simulate",
        "advise",
        "limit",
        "fragility",
        "verify",
        "sweep",
        "sample",
        "gather",
        "sensitivity",
        "rare",
        "serve",
        "app",
        "baseline",
        "bench",
        "run",
        "status",
        "report",
        "validate",
        "fit",
        "data",
        "doctor",
        "warm",
    ):
        assert f"\n  {verb}" in text
    assert "..." not in text.partition("Commands:")[2]
    page = [name for name in HEAVY if name != "pydantic"]  # which typer takes for a verb
    assert "--no-browser" in unasked(tuple(page), "app", "--help")


@pytest.mark.parametrize(
    "verb",
    [
        ("models",),
        ("simulate",),
        ("limit",),
        ("run",),
        ("status",),
        ("report",),
        ("validate",),
        ("data", "list"),
        ("data", "show"),
        ("data", "check"),
        ("doctor",),
        ("warm",),
        ("app",),
        ("baseline", "check"),
        ("baseline", "mint"),
        ("bench", "list"),
        ("bench", "run"),
        ("bench", "submit"),
        ("bench", "report"),
        ("fit", "stud-strength"),
        ("fit", "load-slip"),
        ("fit", "residual"),
    ],
)
def test_every_verb_has_help_and_json(
    verb: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*verb, "--help"]) == 0
    text = capsys.readouterr().out
    assert "--json" in text
    assert text.startswith(f"Usage: workbench {' '.join(verb)}")


def test_no_verb_shows_the_help_and_version(capsys: pytest.CaptureFixture[str]) -> None:
    from workbench import __version__

    assert run([]) == 0
    assert "Usage: workbench" in capsys.readouterr().out
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.strip() == __version__


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["simulat"], "No such command 'simulat'. Did you mean 'simulate'?"),
        (["simulate"], "Missing argument 'SCENARIO.toml'"),
        (["simulate", "a.toml"], "cannot be read: No such file"),
        (["models", "--jsn"], "No such option: --jsn"),
        (["run", "x", "--jobs", "two"], "Invalid value for '--jobs'"),
        (["models", "four-dfo"], "did you mean four-dof?"),
        (["status", "no_such_study"], "study = 'no_such_study': is not known"),
        (["report", "no_such_study", "--format", "docx"], "--format = 'docx': must be among html"),
        (["data", "show", "nothing"], "dataset = 'nothing': must be one of"),
        (["simulate", "none.toml", "--model", "four-dof"], "cannot be read: No such file"),
    ],
)
def test_bad_usage_is_one_line_and_status_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("workbench: ")
    assert message in captured.err


def test_a_reader_that_leaves_early_is_no_fault() -> None:
    command = f"{sys.executable} -c 'from workbench.cli import main; main()' --help | true"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True)
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_standard_output_is_one_line_and_status_2() -> None:
    command = f"{sys.executable} -c 'from workbench.cli import main; main()' --help > /dev/full"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("workbench: standard output: No space left on device; ")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ("status", "thesis_column", "--store", "x" * 5000),
        ("run", "y" * 300),
        ("simulate", "z" * 5000 + ".toml", "--model", "four-dof"),
        ("data", "check", "w" * 300 + ".csv"),
    ],
)
def test_overlong_names_are_one_line_and_status_2(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1
    assert len(errors) < 500


BAD = {
    "unknown key": ("axial_load", "axial_laod", "column.axial_laod"),
    "negative mass": ("mass = 1500.0", "mass = -1500.0", "striker.mass = -1500.0"),
    "above squash": ("axial_load = 500000.0", "axial_load = 4e6", "squash load 3.13323e+06 N"),
    "restitution": ("restitution = 0.0", "restitution = 1.5", "striker.restitution = 1.5"),
    "millimetres": ("length_below = 0.8", "length_below = 800.0", "not millimetres"),
    "unknown section": ('section = "HEB 220"', 'section = "HEB 225"', "column.section"),
    "not TOML": ("[striker]", "[striker", "is not valid TOML"),
    "not finite": ("velocity = 15.0", "velocity = nan", "striker.velocity = nan"),
    "zero duration": ("duration = 0.1", "duration = 0.0", "time.duration = 0.0"),
    "missing striker": (None, None, "the table [striker] is missing"),
}


@pytest.mark.parametrize("bad", BAD)
def test_a_bad_scenario_is_one_line_and_status_2(
    bad: str, scenario_file: Path, thesis_impact: ColumnImpact, capsys: pytest.CaptureFixture[str]
) -> None:
    before, after, words = BAD[bad]
    text = scenario_file.read_text()
    if before is None or after is None:
        import tomli_w

        tables = tomllib.loads(to_toml(thesis_impact))
        del tables["striker"]
        text = tomli_w.dumps(tables)
    else:
        assert before in text
        text = text.replace(before, after)
    scenario_file.write_text(text)
    assert run(["simulate", str(scenario_file), "--model", "four-dof", "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("workbench: ")
    assert captured.err.count("\n") == 1
    assert words in captured.err


def test_a_process_says_the_same(scenario_file: Path) -> None:
    before, after, text = BAD["negative mass"]
    scenario_file.write_text(scenario_file.read_text().replace(before, after))
    done = process("simulate", str(scenario_file), "--model", "four-dof", "--json")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("workbench: ")
    assert done.stderr.count("\n") == 1
    assert text in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "column.axial_load"], "--set = 'column.axial_load'"),
        (["--set", "column.axial_load=heavy"], "column.axial_load = 'heavy'"),
        (["--set", "kind.deep=1"], "kind is a value, not a table"),
        (["--option", "beta"], "--option = 'beta': must look like beta=1.3"),
        (["--option", "bta=1.3"], "option.bta"),
        (["--option", "beta=0.5"], "beta = 0.5"),
        (["--out", "nowhere/run.nc"], "there is no directory nowhere"),
        (["--out", "."], "is a directory"),
    ],
)
def test_bad_settings(
    arguments: list[str], message: str, scenario_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["simulate", str(scenario_file), "--model", "four-dof", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert message in captured.err


def test_a_pipe_is_not_replaced_by_a_file(
    scenario_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    arguments = ["simulate", str(scenario_file), "--model", "four-dof", "--out", str(pipe)]
    assert run(arguments) == 2
    assert "is a pipe or a device" in capsys.readouterr().err
    assert pipe.is_fifo()


KEYS = {
    *("model", "outcome", "message", "collapse", "peak_displacement", "time_of_peak"),
    *(
        "residual_displacement",
        "peak_force",
        "resistance",
        "impulse",
        "energies",
        "shear_utilisation",
    ),
    *("warnings", "refusals", "wall_time", "provenance", "numerical_uncertainty", "refinement"),
    *("error", "headline", "reference"),
    "notes",
    "rate_factor",
    *("largest_drift", "largest_plastic_rotation", "largest_compression", "largest_tension"),
    *("places", "hinges", "drift", "struck", "largest_sliding"),
    *("edge_factor", "edge_factor_low", "edge_factor_high"),
}


def test_simulate_prints_one_object(
    scenario_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--set", "striker.velocity=10", "--option", "beta=1.3", "--option", "alpha=1"]
    arguments += ["--option", "rotational_stiffness=6"]
    status = run(["simulate", str(scenario_file), "--model", "four-dof", "--json", *arguments])
    answer = json.loads(capsys.readouterr().out)
    assert status == 0
    assert set(answer) == KEYS
    assert answer["outcome"] == "ok"
    assert answer["peak_displacement"] == pytest.approx(0.0903, rel=1e-3)
    assert answer["energies"]["input_energy"] == 75e3
    assert answer["energies"]["relative_balance_error"] < 1e-6
    assert answer["shear_utilisation"]["below"] > 1.0
    assert answer["largest_drift"] is None
    low, high = answer["hinges"]["base"]["plastic_rotation"]
    assert answer["largest_plastic_rotation"] >= max(-low, high) > 0.0
    assert [finding["subject"] for finding in answer["warnings"]] == ["error", "off-web"]
    error = answer["error"]
    assert error["low"] < error["expected"] < error["high"] < -0.1
    assert 0.9 < error["chance"] < 1.0
    assert (error["collapse"] < 0.1, error["reason"]) == (True, "")
    assert answer["provenance"]["options"]["beta"] == 1.3
    assert "velocity = 10" in answer["provenance"]["scenario"]
    assert answer["wall_time"] > 0.0


def test_simulate_prints_a_short_table_and_writes_the_response(
    scenario_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from workbench.study.store import read_netcdf

    target = scenario_file.parent / "run.nc"
    arguments = ["--model", "four-dof", "--out", str(target)]
    assert run(["simulate", str(scenario_file), *arguments]) == 0
    text = capsys.readouterr().out
    assert "largest displacement of the hit or pushed point" in text
    assert "warning (error): expect -" in text
    assert "Error of the peak displacement: expect -" in text
    response = read_netcdf(target)
    assert f"{1e3 * float(response['peak_displacement']):.1f}\u00a0mm" in text
    assert response.attrs["model"] == "four-dof"
    assert {path.name for path in target.parent.iterdir()} == {"scenario.toml", "run.nc"}


def test_simulate_with_its_error_budget(
    scenario_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["simulate", str(scenario_file), "--model", "single-dof", "--budget"]
    arguments += ["--option", "resistance=analytic", "--spread", "velocity=0.1"]
    assert run([*arguments, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    real = {term["term"]: term for term in content["budget"]["peak_displacement"]}
    assert real["rate sensitivity"]["low"] < 0.0 < real["rate sensitivity"]["high"]
    terms = content["budget_static"]["peak_displacement"]
    assert real["velocity ±10 %"]["value"] < 0.8 * terms[0]["value"]
    assert [term["term"] for term in terms][-2:] == ["best reference", "total"]
    assert terms[1]["low"] > 0.2  # the web yields, the model does not know
    assert not any(term["collapses"] for term in terms)
    assert terms[-1]["least"] == pytest.approx(terms[0]["least"] * (1.0 + terms[-1]["low"]))
    assert run(arguments) == 0
    shown = capsys.readouterr().out
    least, most = (f"{1e3 * terms[-1][end]:.0f}" for end in ("least", "most"))
    assert f" mm ({least} to {most} mm)" in shown.replace("\u00a0", " ")
    assert "velocity ±10 %" in shown
    assert "===" in shown
    assert run([*arguments[:-1], "speed=0.1"]) == 2
    assert run([*arguments[:4], "--spread", "velocity=0.1"]) == 2
    assert run([*arguments[:5], "--spread", "velocity"]) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 3
    assert errors[0].startswith("workbench: spread.speed: unknown key; known are velocity")
    assert "is for --budget" in errors[1]
    assert "must look like velocity=0.1" in errors[2]


def test_simulate_a_pushover(
    thesis_impact: ColumnImpact, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    push = ColumnPushover("push", column=thesis_impact.column, displacement=0.05)
    path = tmp_path / "push.toml"
    path.write_text(to_toml(push))
    assert run(["simulate", str(path), "--model", "four-dof", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert set(answer) == KEYS | {"displacement", "force"}
    assert len(answer["force"]) == len(answer["displacement"]) > 10
    assert answer["displacement"][-1] == pytest.approx(0.05, rel=1e-9)
    assert answer["time_of_peak"] is None
    assert answer["impulse"] is None


def test_an_answer_that_fails_is_status_1(
    thesis_impact: ColumnImpact, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    push = ColumnPushover("push", column=thesis_impact.column, displacement=0.05)
    path = tmp_path / "push.toml"
    path.write_text(to_toml(push))
    options = ["--option", "dataset=heng2017-figure-5-9", "--option", "series=SDOF"]
    assert run(["simulate", str(path), "--model", "published", *options, "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["outcome"] == "out-of-domain"
    assert answer["message"]
    assert answer["peak_displacement"] is None
    assert answer["energies"]["kinetic"] is None
    assert answer["shear_utilisation"] is None
    assert run(["simulate", str(path), "--model", "published", *options]) == 1
    assert "out-of-domain" in capsys.readouterr().out


def test_published_numbers_must_be_named(
    scenario_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["simulate", str(scenario_file), "--model", "published"]
    assert run(arguments) == 2
    assert "option.dataset: must be one of heng2017-figure-5-" in capsys.readouterr().err
    named = [*arguments, "--option", "dataset=heng2017-figure-5-9"]
    assert run(named) == 2
    errors = capsys.readouterr().err
    assert "option.series: must be one of 4-DOF nonlinear yield surface; SDOF" in errors
    assert run([*named, "--option", "series=SDOF"]) == 0
    assert "191.1\u00a0mm" in capsys.readouterr().out
    wrong = [*arguments, "--option", "dataset=profiles"]
    assert run(wrong) == 2
    assert "option.dataset = 'profiles': must be one of" in capsys.readouterr().err


def test_models(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["models", "--json"]) == 0
    entries = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)["models"]}
    assert entries["four-dof"]["answers"] == ["column-impact", "column-pushover"]
    assert entries["four-dof"]["assumptions"]
    assert entries["published"]["options"] == {"dataset": None, "series": None}
    assert run(["models", "four-dof"]) == 0
    text = capsys.readouterr().out
    assert entries["four-dof"]["assumptions"][0][:60] in " ".join(text.split())
    assert "default thesis" in text
    assert run(["models"]) == 0
    assert "four-dof" in capsys.readouterr().out


def test_data(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["data", "list", "--json"]) == 0
    names = [entry["name"] for entry in json.loads(capsys.readouterr().out)["datasets"]]
    assert "heng2017-figure-5-9" in names
    assert run(["data", "show", "heng2017-figure-5-9", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert {"source", "licence", "role", "uncertainty", "columns", "rows"} <= set(shown)
    assert len(shown["rows"]) > 3
    assert run(["data", "show", "heng2017-figure-5-9"]) == 0
    assert shown["source"] in capsys.readouterr().out
    assert run(["data", "list"]) == 0
    assert run(["data", "check", "--json"]) == 0
    listed, _, checked = capsys.readouterr().out.partition("{\n")
    assert "heng2017-figure-5-9" in listed
    assert json.loads("{" + checked)["problems"] == []


def test_a_collapse_is_an_answer(
    parked: ColumnImpact, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "car.toml"
    path.write_text(to_toml(parked))
    arguments = ["simulate", str(path), "--model", "four-dof-shear"]
    assert run([*arguments, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["outcome"], answer["peak_displacement"]) == ("collapse", None)
    assert answer["refusals"] == []
    assert answer["collapse"]["mechanism"] == "geometry"
    assert answer["collapse"]["parts"] == ["below"]
    assert 0.4 < answer["collapse"]["displacement"] < 0.54
    assert 0.05 < answer["collapse"]["time"] < 0.1
    assert run(arguments) == 0
    text = capsys.readouterr().out
    assert "geometry (below)" in text
    assert "collapses: geometry (below); by four-dof-shear, as asked" in text


def test_a_broken_catalogue_is_status_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("workbench.base.catalogue.check", lambda: ["dataset x: file y is missing"])
    assert run(["data", "check"]) == 1
    assert "file y is missing" in capsys.readouterr().out
