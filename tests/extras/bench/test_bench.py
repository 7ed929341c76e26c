"""The impact bench: seals, answers of anyone, scores, and the verbs."""

from __future__ import annotations

import json
import runpy
import tomllib
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tomli_w

import workbench as wb
from workbench.base.datafiles import data_directory
from workbench.base.errors import InputError
from workbench.cli import run
from workbench.extras.bench import cases as bench_cases
from workbench.extras.bench.answers import PEAK, answer_bytes, read_answers, submissions
from workbench.extras.bench.cases import ReferenceAnswer, commitment, load_bench, opened
from workbench.extras.bench.run import entrants
from workbench.extras.bench.scores import by_group, judged, scores
from workbench.scenarios import scenario_hash, to_toml

SALT = "salt of a test"
TRUTHS = {
    "a": ReferenceAnswer("ok", 0.1, 0.005),
    "b": ReferenceAnswer("collapse"),
    "c": ReferenceAnswer("ok", 0.2, 0.0),
    "d": ReferenceAnswer("ok", 0.4, 0.01),
}
SEALED = ("b", "d")


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four cases of columns, two of them sealed, and the key beside them."""
    folder = tmp_path / "cases"
    for number, (name, truth) in enumerate(TRUTHS.items()):
        column = wb.Column("HEB 220", 2.0, 2.0)
        scenario = wb.impact(column, mass=1500, velocity=3.0 + number)
        (folder / name).mkdir(parents=True)
        (folder / name / "scenario.toml").write_text(to_toml(scenario), encoding="utf-8")
        sealed = {"commitment": commitment(SALT, name, truth.text)}
        content = {
            "group": "first" if number < 2 else "second",
            "scenario": scenario_hash(scenario),
            "model": {"name": "fiber-shear", "version": 8, "options": {"levels": 3}},
            "reference": sealed if name in SEALED else truth.table,
        }
        (folder / name / "case.toml").write_text(tomli_w.dumps(content), encoding="utf-8")
    key = {"salt": SALT, "sealed": {name: TRUTHS[name].text for name in SEALED}}
    (tmp_path / "key.json").write_text(json.dumps(key), encoding="utf-8")
    monkeypatch.setattr(bench_cases, "bench_directory", lambda: folder)
    monkeypatch.setenv("WORKBENCH_DATA", str(tmp_path / "own"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table(*rows: str, header: str = "case,outcome,peak_displacement_mm") -> str:
    return "\n".join((header, *rows)) + "\n"


def submitted(path: Path, text: str, name: str = "LS-DYNA, shell 10 mm") -> int:
    (path / "given.csv").write_text(text, encoding="utf-8")
    return run(["bench", "submit", "given.csv", "--name", name, "--contact", "a@b.org"])


# -- the seal ------------------------------------------------------------------------------------


def test_a_key_opens_what_is_sealed(bench: Path) -> None:
    cases = load_bench()
    assert [case.name for case in cases if case.seal] == [*SEALED]
    assert opened(cases) == {name: TRUTHS[name] for name in "ac"}
    assert opened(cases, bench / "key.json") == TRUTHS


def test_a_reference_that_moved_is_noticed(bench: Path) -> None:
    key = json.loads((bench / "key.json").read_text())
    key["sealed"]["d"] = ReferenceAnswer("ok", 0.41, 0.01).text
    (bench / "key.json").write_text(json.dumps(key))
    with pytest.raises(InputError, match=r"does not open d: another seal, or the answer"):
        opened(load_bench(), bench / "key.json")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{}", "is no key of the bench"),
        ("no JSON", "is no key of the bench"),
        ('{"salt": "another", "sealed": {}}', "does not open b"),
        ("[" * 100_000, "is no key of the bench"),
    ],
)
def test_what_is_no_key_is_refused(bench: Path, text: str, words: str) -> None:
    (bench / "key.json").write_text(text)
    with pytest.raises(InputError, match=words):
        opened(load_bench(), bench / "key.json")


def test_a_scenario_that_was_changed_is_refused(bench: Path) -> None:
    file = bench / "cases" / "a" / "scenario.toml"
    file.write_text(file.read_text().replace("velocity = 3.0", "velocity = 3.5"))
    with pytest.raises(InputError, match="is not the scenario that the reference answered"):
        load_bench()


# -- answers of anyone ---------------------------------------------------------------------------


def test_lengths_have_the_unit_of_their_column(bench: Path) -> None:
    header = "case,outcome,peak_displacement_in,half_width (mm),wall_time_ms,warned"
    (bench / "given.csv").write_text(table("a,ok,4,5,1500,yes", "b,collapse,,,,", header=header))
    rows = read_answers(bench / "given.csv", TRUTHS, "mine")
    assert rows.loc[0].tolist() == ["a", "mine", "ok", 0.1016, 0.005, 1.5, "yes"]
    assert rows.loc[1, "warned"] == "no"
    assert np.isnan(rows.loc[1, PEAK])


BAD = {
    "no unit": (table("a,ok,4", header="case,outcome,peak_displacement"), "says no unit"),
    "unit": (table("a,ok,4", header="case,outcome,peak_displacement_kN"), "kN"),
    "column": (table("a,ok,4,1", header="case,outcome,peak_displacement_m,mesh"), "mesh"),
    "without": (table("ok,4", header="outcome,peak_displacement_m"), "required column missing"),
    "unknown": (table("a,ok,4", "e,ok,4"), "is no case of the bench"),
    "path": (table("../../etc/passwd,ok,4"), "is no case of the bench"),
    "twice": (table("a,ok,4", "a,ok,5"), "stands twice"),
    "negative": (table("a,ok,-4"), "must be a number above 0"),
    "infinite": (table("a,ok,inf"), "must be finite"),
    "word": (table("a,ok,four"), "must be a number above 0"),
    "no peak": (table("a,ok,"), "must be given where the outcome is ok"),
    "peak": (table("a,collapse,4"), "is no answer where the outcome is collapse"),
    "outcome": (table("a,survives,4"), "must be one of ok, collapse, refused, failed"),
    "width": (
        table("a,collapse,,1", header="case,outcome,peak_displacement_mm,half_width_mm"),
        "is the half-width of no peak",
    ),
    "cell": (table("a,ok,4" + "9" * 60_000), "characters"),
    "large": (table("a,ok," + "9" * 10_000_000), "must not exceed 2 MB"),
    "long line": (table("a,ok," + "9" * 1_000_000), "has more than 65536 characters"),
    "formula": (
        table("a,=cmd|' /C calc'!A0,ok,4", header="case,model,outcome,peak_displacement_mm"),
        "must be 1 to 80 letters",
    ),
    "script": (
        table("a,<script>alert(1)</script>,ok,4", header="case,model,outcome,peak_displacement_mm"),
        "must be 1 to 80 letters",
    ),
    "binary": ("case\0", "binary"),
    "empty": ("", "empty"),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_answers_are_one_message_and_nothing_written(
    bench: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    text, words = BAD[kind]
    if kind == "cell":
        words = "must be a number above 0"
    assert submitted(bench, text) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert len(error) < 1000
    assert not (bench / "own").exists()


@pytest.mark.parametrize(
    "name", ["=cmd|' /C calc'!A0", "<b>x</b>", "../../x", "", "a" * 81, "x\ny", "[@heng]", "`x`"]
)
def test_bad_names_are_refused(bench: Path, name: str) -> None:
    assert submitted(bench, table("a,ok,100"), name) == 2
    assert not (bench / "own").exists()


def test_a_name_stands_once(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert submitted(bench, table("a,ok,100")) == 0
    assert "3 cases without an answer count as failed" in capsys.readouterr().out
    assert submitted(bench, table("a,ok,101")) == 2
    (kept,) = submissions(TRUTHS)
    assert kept[["model", PEAK]].to_numpy().tolist() == [["LS-DYNA, shell 10 mm", 0.1]]


def test_a_submission_that_was_spoilt_is_refused(bench: Path) -> None:
    submitted(bench, table("a,ok,100"))
    (kept,) = (bench / "own" / "bench").glob("*/answers.csv")
    kept.write_text(kept.read_text().replace("LS-DYNA", "<script>"))
    with pytest.raises(InputError, match="must be 1 to 80 letters"):
        list(submissions(TRUTHS))


# -- scores --------------------------------------------------------------------------------------


def answers(**peaks: dict[str, float | str]) -> pd.DataFrame:
    """Answers by series and case: a peak, or how it ended; a star: with a warning."""
    rows = []
    for model, of in peaks.items():
        for case, value in of.items():
            ok = not isinstance(value, str)
            rows.append((case, model, "ok" if ok else value, value if ok else np.nan))
    frame = pd.DataFrame(rows, columns=["case", "model", "outcome", PEAK])
    return frame.assign(half_width_m=np.nan, wall_time_s=1.0, warned="no")


def scored(frame: pd.DataFrame, folder: Path) -> pd.DataFrame:
    return scores(judged(load_bench(), TRUTHS, frame)).set_index("model")


def test_errors_count_beyond_the_interval_of_the_reference(bench: Path) -> None:
    given = {"a": 0.104, "b": "collapse", "c": 0.25, "d": 0.36}
    row = scored(answers(mine=given), bench).loc["mine"]
    assert row["mean_error"] == pytest.approx((0.0 + 0.0 + 0.25 + 0.075) / 4)
    assert row["within"] == 3
    assert row["silent_misses"] == 1
    assert row["median_error"] == pytest.approx(0.1)
    assert row["median_ratio"] == pytest.approx(1.04)


def test_refusals_failures_and_gaps_are_errors_and_are_counted(bench: Path) -> None:
    row = scored(answers(mine={"a": 0.1, "b": "failed", "c": "refused"}), bench).loc["mine"]
    assert row["mean_error"] == pytest.approx(0.75)
    assert row[["asked", "within", "refused", "failed", "silent_misses"]].tolist() == [
        4,
        1,
        1,
        2,
        0,
    ]


def test_wrong_verdicts_on_collapse_are_told_apart(bench: Path) -> None:
    frame = answers(bold={"b": 0.3, "c": 0.2}, shy={"b": "collapse", "c": "collapse"})
    table = scored(frame, bench)
    assert table["false_safe"].to_dict() == {"bold": 1, "shy": 0}
    assert table["false_alarm"].to_dict() == {"bold": 0, "shy": 1}
    assert table["silent_misses"].to_dict() == {"bold": 1, "shy": 1}
    warned = scored(frame.assign(warned="yes"), bench)
    assert warned["silent_misses"].sum() == 0


def test_intervals_hold_with_that_of_the_reference(bench: Path) -> None:
    frame = answers(mine={"a": 0.12, "c": 0.22, "d": 0.4}).assign(half_width_m=[0.0196, 0.015, 0.1])
    row = scored(frame, bench).loc["mine"]
    assert row[["intervals", "intervals_held"]].tolist() == [3, 2]


def test_ranks_have_intervals(bench: Path) -> None:
    best = {"a": 0.1, "b": "collapse", "c": 0.2, "d": 0.4}
    frame = answers(
        one={**best, "a": 0.3}, best=best, other={**best, "c": 0.6}, none={"a": "failed"}
    )
    table = scored(frame, bench)
    ends = table[["rank", "rank_low", "rank_high"]]
    assert table.index[0] == "best"
    assert ends.loc["best"].tolist() == [1, 1, 1]
    assert ends.loc["none", "rank"] == 4
    assert ends.loc["one"].tolist() == ends.loc["other"].tolist() == [2, 1, 3]
    again = scored(frame, bench)
    pd.testing.assert_frame_equal(table, again)


def test_common_cases_compare_what_both_answer(bench: Path) -> None:
    best = {"a": 0.1, "b": "collapse", "c": 0.21, "d": 0.4}
    row = scored(answers(best=best, narrow={"c": 0.2}), bench).loc["narrow"]
    assert row["common"] == 1
    assert row["common_error"] == 0.0
    assert row["common_error_of_first"] == pytest.approx(0.05)


def test_groups_count_what_was_asked(bench: Path) -> None:
    rows = judged(load_bench(), TRUTHS, answers(mine={"a": 0.1, "c": 0.2}))
    assert by_group(rows).to_dict("records") == [{"model": "mine", "first": 1, "second": 1}]


# -- verbs ---------------------------------------------------------------------------------------


def test_a_submission_becomes_a_line_of_the_page(
    bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert submitted(bench, table("a,ok,100", "b,ok,90", "c,ok,150"), "R&D: x") == 0
    assert run(["bench", "report", "--no-own", "--json"]) == 0
    shown = capsys.readouterr().out
    assert json.loads(shown[shown.index("{") :])["scores"][0]["asked"] == 2
    page = (bench / "reports" / "bench-report" / "report.html").read_text(encoding="utf-8")
    assert "R&amp;D: x" in page
    assert "those whose reference stands in the open" in " ".join(page.split())
    assert run(["bench", "report", "--no-own", "--key", "key.json", "--out", "all"]) == 0
    ranking = pd.read_csv(bench / "all" / "ranking.csv")
    assert ranking.loc[0, ["model", "asked", "false_safe"]].tolist() == ["R&D: x", 4, 1]
    assert "R&D: x" in (bench / "all" / "README.md").read_text(encoding="utf-8")


def test_errors_of_sealed_cases_are_not_told(bench: Path) -> None:
    submitted(bench, table("a,ok,100", "d,ok,390"))
    assert run(["bench", "report", "--no-own", "--key", "key.json", "--out", "all"]) == 0
    assert set(pd.read_csv(bench / "all" / "cases.csv")["case"]) == {"a", "c"}


def test_a_submission_is_not_called_like_a_model(bench, capsys) -> None:
    (bench / "mine.csv").write_text(f"case,outcome\n{next(iter(TRUTHS))},refused\n")
    for name in ("Biggs", "hand-estimate", "flexible superelements"):
        command = ["bench", "submit", "mine.csv", "--name", name, "--contact", "jane@example.org"]
        assert run(command) == 2
        assert "is a model of the workbench" in capsys.readouterr().err


def test_models_answer_in_the_form_that_anyone_submits(
    bench: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["bench", "run", "--model", "4-DOF", "--model", "column-of-frame", "--jobs", "1"]
    assert run([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outcomes"] == {"ok": 4, "refused": 4}
    written = bench / "reports" / "bench-answers.csv"
    rows = read_answers(written, TRUTHS)
    alone = wb.make_model("four-dof").simulate(load_bench()[0].scenario)
    assert rows.loc[0, PEAK] == pytest.approx(float(alone["peak_displacement"]), rel=1e-5)
    assert answer_bytes(rows) == written.read_bytes()
    assert run(["bench", "report", "--no-own", "--answers", str(written)]) == 0
    assert "bench-answers: 4-DOF" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["run", "--model", "4-DOFF"], "is no model of the workbench"),
        (["run", "--out", "answers.txt"], "must end in csv"),
        (["run", "--jobs", "-1"], "--jobs"),
        (["report", "--no-own"], "has no answers to compare"),
        (["report", "--no-own", "--answers", "none.csv"], "cannot be read"),
        (["report", "--no-own", "--answers", "[@heng].csv"], "must be 1 to 80 letters"),
        (["report", "--key", "none.json"], "cannot be read"),
    ],
)
def test_bad_commands_are_one_message(
    bench: Path, capsys: pytest.CaptureFixture[str], command: list[str], words: str
) -> None:
    assert run(["bench", *command]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_every_model_of_the_list_can_be_made() -> None:
    default, every = entrants(), entrants(every=True)
    assert 15 < len(default) < len(every)
    assert {"four-dof", "biggs"} <= {model.name for model in default.values()}


# -- the bench that ships ------------------------------------------------------------------------

BENCH = data_directory() / "bench"
SIZES = {
    **{"column": 20, "frame": 10, "pulse": 8, "shear": 8, "near-collapse": 8, "hollow": 8},
    **{"rate": 6, "weak-axis": 6, "oblique": 4, "thesis": 2},
}


def test_eighty_cases_of_which_half_are_sealed() -> None:
    cases = load_bench(BENCH)
    assert Counter(case.group for case in cases) == SIZES
    assert sum(bool(case.seal) for case in cases) == 40
    assert len({scenario_hash(case.scenario) for case in cases}) == 80
    known = [case.reference for case in cases if case.reference is not None]
    assert all(each.half_width <= 0.05 * each.peak for each in known)
    assert {each.outcome for each in known} == {"ok", "collapse"}
    assert sum(path.stat().st_size for path in BENCH.rglob("*.*")) < 400_000


def test_the_answers_and_the_first_table_that_ship_fit_the_cases() -> None:
    names = [case.name for case in load_bench(BENCH)]
    rows = read_answers(BENCH / "workbench.csv", names)
    models = set(rows["model"])
    assert set(entrants()) <= models <= set(entrants(every=True))
    assert len(rows) == len(names) * len(models)
    first = pd.read_csv(BENCH / "first_table.csv")
    assert set(first["model"]) == models
    assert (first["asked"] == len(names)).all()
    assert (first["rank_low"] <= first["rank"]).all()
    assert (first["rank"] <= first["rank_high"]).all()
    own = judged(load_bench(BENCH), opened(load_bench(BENCH)), rows)
    assert scores(own)["asked"].eq(40).all()


@pytest.mark.thorough
def test_an_open_reference_can_be_computed_again() -> None:
    case = next(case for case in load_bench(BENCH) if case.group == "pulse" and case.reference)
    content = tomllib.loads((BENCH / case.name / "case.toml").read_text(encoding="utf-8"))
    solver = wb.make_model(content["model"]["name"], content["model"]["options"])
    peak = float(solver.simulate(case.scenario)["peak_displacement"])
    assert case.reference is not None
    assert abs(peak) == pytest.approx(case.reference.peak, rel=1e-5)


def test_rotation_opens_one_half_and_seals_the_other(bench: Path) -> None:
    script = runpy.run_path(str(BENCH / "rotate.py"))
    folder, old, new = bench / "cases", bench / "key.json", bench / "new.json"
    script["rotate"](folder, old, new)
    cases = load_bench(folder)
    assert [case.name for case in cases if case.seal] == ["a", "c"]
    assert opened(cases) == {name: TRUTHS[name] for name in SEALED}
    assert opened(cases, new) == TRUTHS
    with pytest.raises(InputError, match="does not open a"):
        opened(cases, old)
    assert json.loads(new.read_text())["salt"] != SALT
    with pytest.raises(FileExistsError):
        script["rotate"](folder, new, old)
    assert opened(load_bench(folder), new) == TRUTHS
