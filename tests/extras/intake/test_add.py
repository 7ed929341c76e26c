"""`workbench data add`: tables of any header and unit become one's own data, or nothing changes."""

from __future__ import annotations

import random
import runpy
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import workbench
from workbench.base.catalogue import check, dataset, datasets, load
from workbench.base.errors import InputError
from workbench.cli import run
from workbench.extras.intake.add import add_table
from workbench.extras.intake.kinds import check_file, problems_of_own
from workbench.responses import Outcome, outcome_of
from workbench.studs.answers import StudStrength
from workbench.study import Case, Study

HEADER = (
    "campaign,specimen,section,span,hit_at,base,head,axial_load,mass,velocity,yield_stress,"
    "peak,peak_uncertainty,residual,residual_uncertainty,source,licence,year,role"
)
UNITS = ",,,mm,mm,,,kN,kg,m/s,MPa,mm,mm,mm,mm,,,,"
ROWS = (
    "our lab,B1,HEB 220,4000,2000,pinned,pinned,0,1500,5,355,68,3,40,3,Report 12,CC BY 4.0,2026,{}",
    "our lab,B2,HEB 220,4000,800,clamped,guided,200,1500,8,355,70,4,55,4,Report 12,CC BY 4.0,2026,"
    "{}",
)
PUSH_OUTS = """\
Test No.,Stud diam. d,Length L,f'c,fu,Qu (kip),Smax,Remark
,in.,in.,ksi,ksi,kips,in.,
S1,0.75,4.0,4.35,68.5,29.1,0.24,shank
S2,0.75,4.0,4.35,68.5,28.0,0.22,
S3,0.75,4.0,5.10,68.5,30.6,-,shank
"""
MAPPING = """\
title = "Push-outs of J. Doe, table 3"
source = "Doe, J., 1999, table 3"
licence = "CC BY 4.0"
year = 1999
role = "calibrate"
name = "doe"
ignore = ["Remark"]
[columns]
"Test No." = "specimen"
"Stud diam. d" = "diameter_mm"
"Length L" = "height_mm"
"f'c" = "fcm_MPa"
"fu" = "fu_MPa"
"Qu" = "shear_kN"
"Smax" = "slip_at_max_mm"
[constants]
campaign = "doe1999"
test = "push-out"
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory of its own, in which nothing of the user's is."""
    monkeypatch.delenv("WORKBENCH_DATA", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def impacts(*changes: tuple[str, str], role: str = "validate") -> Path:
    """A table of two impact tests, with replacements."""
    text = "\n".join((HEADER, UNITS, *(row.format(role) for row in ROWS))) + "\n"
    return written(text, "tests.csv", *changes)


def written(text: str, name: str, *changes: tuple[str, str]) -> Path:
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    Path(name).write_text(text, encoding="utf-8")
    return Path(name)


def push_outs(*changes: tuple[str, str]) -> Path:
    return written(PUSH_OUTS, "doe.csv", *changes)


def mapping(*changes: tuple[str, str]) -> Path:
    return written(MAPPING, "doe.toml", *changes)


def test_impact_tests_are_converted_and_catalogued() -> None:
    added = add_table(impacts())
    assert (added.rows, added.already, added.read, added.doubts) == (2, False, True, ())
    entry = dataset("tests")
    assert (entry.kind, entry.role, entry.licence) == ("impact-tests", "validate", "CC BY 4.0")
    assert (entry.source, entry.year) == ("Report 12", "2026")
    rows = load("tests")
    assert rows["span_m"].tolist() == [4.0, 4.0]
    assert rows["axial_load_N"].tolist() == [0.0, 200e3]
    assert rows["yield_stress_Pa"].tolist() == [355e6, 355e6]
    assert rows["peak_uncertainty_m"].tolist() == [0.003, 0.004]
    assert check() == []
    assert problems_of_own() == []
    raw = tomllib.loads(Path("lab_data/catalogue.toml").read_text("utf-8"))["dataset"][0]
    assert "span in mm is span_m, times 0.001" in raw["made"]
    assert raw["file"] == "tests.csv"


def test_a_share_in_percent_is_one_of_a_hundred() -> None:
    header, units = HEADER.replace("mass", "restitution,mass"), UNITS.replace("kg", "%,kg")
    table = impacts((HEADER, header), (UNITS, units), (",0,1500,", ",0,20,1500,"),
                    (",200,1500,", ",200,5,1500,"))  # fmt: skip
    add_table(table)
    assert load("tests")["restitution"].tolist() == [0.2, 0.05]


def test_a_published_table_in_kips_and_inches_is_fitted_without_code() -> None:
    added = add_table(push_outs(), mapping=mapping())
    assert "Qu (kip) in kip is shear_kN, times 4.44822162" in added.notes
    rows = load("doe")
    assert rows["diameter_mm"].tolist() == [19.05] * 3
    assert rows["shear_kN"][0] == pytest.approx(29.1 * 4.4482216152605)
    assert rows["fcm_MPa"][0] == pytest.approx(4.35 * 6.894757293168)
    assert rows["slip_at_max_mm"].isna().tolist() == [False, False, True]
    assert set(rows["campaign"]) == {"doe1999"}
    assert set(rows["reference"]) == {"Doe, J., 1999, table 3"}
    assert added.then.endswith("workbench fit stud-strength lab_data/doe.csv")


def test_a_campaign_joins_the_study_of_studs_without_code() -> None:
    studies = Path(workbench.__file__).parents[1] / "studies"

    def cases() -> dict[str, Case]:
        study: Study = runpy.run_path(str(studies / "studs.py"))["study"]
        judged = {name for gate in study.gates for name in gate.cases if gate.bound == 0.10}
        return {case.name: case for case in study.cases if case.name in judged}

    before, digest = cases(), StudStrength("roik-mean").data_digest
    add_table(push_outs(), mapping=mapping(('role = "calibrate"', 'role = "synthetic"')))
    assert cases().keys() == before.keys()  # made numbers judge nothing
    changed = push_outs(("29.1", "29.4"), ("28.0", "28.3"), ("30.6", "30.9"))
    add_table(changed, mapping=mapping(('role = "calibrate"', 'role = "validate"')), name="real")
    (new,) = cases().keys() - before.keys()
    assert new == "unseen: real"
    assert StudStrength("roik-mean").data_digest != digest
    answer = StudStrength("roik-mean").simulate(cases()[new].scenario)
    assert outcome_of(answer) is Outcome.OK
    assert 0.8 < float(answer["test_over_prediction"]) < 1.25


@pytest.mark.thorough
def test_a_bad_table_is_refused_by_a_real_process() -> None:
    impacts((",CC BY 4.0,2026", ",,2026"))
    command = [sys.executable, "-c", "from workbench.cli import main; main()", "data", "add"]
    refused = subprocess.run([*command, "tests.csv"], capture_output=True, text=True, timeout=600)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr == (
        "workbench: tests.csv, line 3, column licence = '': must not be empty; "
        "also look at line 4\n"
    )
    assert not Path("lab_data").exists()


def test_a_filled_template_is_taken(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new", "impact-tests"]) == 0
    template = capsys.readouterr().out
    with pytest.raises(InputError, match=r"empty\.csv = 'only a header'"):
        add_table(written(template, "empty.csv"))
    example = [line[1:].strip() for line in template.splitlines() if "   our lab" in line]
    path = written(template + "\n".join(example), "filled.csv")
    assert check_file(path) == ([], [], [])
    added = add_table(path)
    assert (added.rows, added.doubts) == (2, ())
    assert run(["new", "mapping"]) == 0
    template = written(capsys.readouterr().out, "template.toml")
    with pytest.raises(InputError, match="title = '': must be one line"):
        add_table(push_outs(), mapping=template)


def test_the_same_table_is_not_doubled(capsys: pytest.CaptureFixture[str]) -> None:
    table = impacts()
    assert run(["data", "add", str(table)]) == 0
    before = Path("lab_data/catalogue.toml").read_bytes()
    table.rename("again.csv")
    assert run(["data", "add", "again.csv"]) == 0
    assert "The same rows are in the catalogue already, as tests" in capsys.readouterr().out
    assert Path("lab_data/catalogue.toml").read_bytes() == before
    changed = impacts(("68,3,", "69,3,"))
    with pytest.raises(InputError, match="name of another table"):
        add_table(changed)
    with pytest.raises(InputError, match="our lab B2 holds the same numbers as tests: our lab B2"):
        add_table(changed, name="other")
    added = add_table(changed, name="other", despite_doubts=True)
    assert "taken despite: our lab B2" in dataset("other").uncertainty
    assert len(added.doubts) == 1
    assert [entry.name for entry in datasets()][-2:] == ["tests", "other"]


def test_data_live_where_the_user_says(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    added = add_table(impacts(), into=tmp_path / "elsewhere")
    assert not added.read
    assert "tests" not in [entry.name for entry in datasets()]
    monkeypatch.setenv("WORKBENCH_DATA", str(tmp_path / "elsewhere"))
    assert len(load("tests")) == 2
    assert add_table(impacts()).already
    from workbench.base.datafiles import data_directory

    with pytest.raises(InputError, match="read only"):
        add_table(impacts(), into=data_directory() / "mine")


def test_synthetic_rows_say_so_in_their_names() -> None:
    add_table(impacts(role="synthetic"), name="made")
    assert set(load("made")["campaign"]) == {"SYNTHETIC our lab"}
    assert dataset("made").role == "synthetic"
    add_table(push_outs(), mapping=mapping(('role = "calibrate"', 'role = "synthetic"')))
    rows = load("doe")
    assert set(rows["campaign"]) == {"SYNTHETIC doe1999"}
    assert set(rows["role"]) == {"verify"}
    assert set(rows["origin"]) == {"synthetic"}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((HEADER, HEADER.replace("span", "sspan")), "sspan.*is no column.*did you mean"),
        ((HEADER, HEADER.replace("mass", "span_m")), "span_m.*is span_m, and so is span"),
        (
            (HEADER, HEADER.replace("span", "span_ft")),
            "column span_ft = 'ft and mm': says two units",
        ),
        ((UNITS, UNITS.replace("kN", "furlong")), "'furlong': is no unit of a force"),
        ((UNITS, UNITS.replace("kN", "MPa")), "'MPa': is no unit of a force"),
        ((UNITS, UNITS.replace("m/s", "")), "column velocity: says no unit"),
        (("4000,2000", "4000;2000"), "line 3.*18 cells where the header has 19"),
        (("68,3,", "sixty,3,"), r"line 3, column peak_m \(from peak in mm\) = 'sixty'"),
        (("68,3,", "680000,3,"), "line 3, column peak_m"),
        (("68,3,", "3500,3,"), "is 0.88 times the span; is it in mm or cm"),
        (("68,3,40", "40,3,68"), "residual_m.*exceeds peak_m.*swapped"),
        (("68,3,", "3,68,"), "column peak_uncertainty_m.*is no less than peak_m.*swapped"),
        (("68,3,", "68,,"), "column peak_uncertainty_m.*must be given with peak_m"),
        (("68,3,40,3", ",,,"), "a test without a result is none"),
        (("4000,2000", "2000,4000"), "column hit_at_m.*must be less than the span, 2 m"),
        (("HEB 220,4000,2000", "HEB 221,4000,2000"), "column section = 'HEB 221'.*did you mean"),
        (("HEB 220,4000,2000", ",4000,2000"), "column section.*must name a profile"),
        (("pinned,pinned", "hinged,pinned"), "column base.*must be one of clamped, pinned"),
        (("guided,200", "guided,20000"), "column axial_load_N.*squash load"),
        (("m/s,MPa", "m/s,Pa"), "column yield_stress_Pa.*stresses are in Pa"),
        (("our lab,B2", "our lab,B1"), "stands in line 3 too"),
        (("our lab,B2", "Our Lab,B2"), "is spelled our lab in line 3"),
        (("Report 12,CC BY 4.0,2026,validate\nour", ",CC BY 4.0,2026,validate\nour"), "source"),
        (("CC BY 4.0,2026,validate\nour", ",2026,validate\nour"), "column licence.*not be empty"),
        (("CC BY 4.0", "unknown"), "licence = 'unknown': must say it"),
        (("Report 12", "?"), "source = '\\?': must say it"),
        (("2026,validate\nour", "2026,verify\nour"), "role = 'verify, validate': must be one"),
        ((",CC BY 4.0,2026", ",CC BY 4.0,"), "column year.*must not be empty"),
        ((HEADER, HEADER.replace(",", ";")), "column span: says no unit"),
    ],
)
def test_bad_tables_are_refused_with_one_message(
    change: tuple[str, str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["data", "add", str(impacts(change))]) == 2
    from re import search

    output = capsys.readouterr()
    assert search(message, output.err), output.err
    assert output.err.count("\n") == 1
    assert output.out == ""
    assert not Path("lab_data").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("m/s,", "mph,"), ""),
        (("kg,m/s", "lb,mm/s"), "times those of the energy estimate: "),
        (("kg,m/s", "g,m/s"), "mass in g instead of kg|mass in t instead of kg"),
        (("kN,kg", "N,kg"), "axial loads of our lab are at most .* of the squash load: kN?"),
        (
            ("B2,HEB 220,4000,800,clamped,guided,200,1500,8,355,70,4,55,4", "B2,HEB 220,4000,2000,"
             "pinned,pinned,0,1500,5,355,68,3,40,3"),
            "B1 and our lab B2 hold the same numbers",
        ),
    ],
)  # fmt: skip
def test_what_looks_absurd_is_named_and_taken_only_on_demand(
    change: tuple[str, str], message: str
) -> None:
    table = impacts(change)
    if change[0] == "m/s,":  # velocities that were in km/h
        table = impacts(("1500,5,355", "1500,18,355"), ("1500,8,355", "1500,28.8,355"))
        message = "velocity in km/h instead of m/s|velocity in mph instead of m/s"
    with pytest.raises(InputError, match=message):
        add_table(table)
    assert not Path("lab_data").exists()
    problems, doubts, _ = check_file(table)
    assert problems == []
    assert doubts
    assert add_table(table, despite_doubts=True).doubts


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('licence = "CC BY 4.0"\n', ""), "doe.toml, licence: is missing"),
        (('source = "Doe, J., 1999, table 3"\n', ""), "doe.toml, source: is missing"),
        (("year = 1999\n", ""), "doe.toml, year: is missing"),
        (('title = "Push-outs of J. Doe, table 3"\n', ""), "doe.toml, title: is missing"),
        (('role = "calibrate"\n', ""), "doe.toml, role: is missing"),
        (('"CC BY 4.0"', '"none"'), "licence = 'none': must say it"),
        (("year = 1999", "year = 99"), "doe.toml, year = 99: must be a whole number"),
        (('"calibrate"', '"truth"'), "role = 'truth': must be one of"),
        (('"doe"', '"Doe 1"'), "--name = 'Doe 1': must be lower-case"),
        (("[columns]", "[column]"), "column: unknown key"),
        (('"Qu" = "shear_kN"', '"Pu" = "shear_kN"'), "columns = 'Pu': names a column"),
        (('"Qu" = "shear_kN"', '"Qu" = "sheer_kN"'), "'sheer_kN': is no column.*did you mean"),
        (('["Remark"]', '["Remarks"]'), "ignore = 'Remarks': names a column"),
        (('["Remark"]', "[]"), "'Remark': is no column of the workbench"),
        (('test = "push-out"', 'test = "pushout"'), "column test = 'pushout'"),
        (('test = "push-out"', 'tests = "push-out"'), "constants.tests.*did you mean test"),
        (
            ('test = "push-out"', "fu = 450"),
            "constants.fu = '450': stands in the table too|no unit",
        ),
        (('test = "push-out"', "density = 2400"), "constants.density.*says no unit"),
        (("[constants]", '[units]\n"Smax" = "mm"\n[constants]'), "'in and mm': says two units"),
        (("[constants]", "[constants"), "mapping file = 'doe.toml': cannot be read"),
        (('campaign = "doe1999"', "campaign = [1]"), "constants.campaign.*number or a text"),
        (('name = "doe"', 'kind = "studs"'), "--kind = 'studs': must be one of"),
        (('name = "doe"', "unit_row = 3"), "unit_row = 3: must be true or false"),
    ],
)
def test_bad_mappings_are_refused_with_one_message(change: tuple[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        add_table(push_outs(), mapping=mapping(change))
    assert not Path("lab_data").exists()


def test_studs_in_another_unit_or_without_units_are_refused() -> None:
    with pytest.raises(InputError, match=r"loads of doe1999 are 0.2.* kip instead of kN"):
        add_table(push_outs(("(kip)", "(kN)"), ("kips", "")), mapping=mapping())
    bare = push_outs((PUSH_OUTS.splitlines()[1] + "\n", ""), ("Qu (kip)", "Qu"))
    with pytest.raises(InputError, match=r"column Stud diam\. d: says no unit"):
        add_table(bare, mapping=mapping())
    with pytest.raises(InputError, match=r"line 2.*is no row of units"):
        add_table(bare, mapping=mapping(('name = "doe"', "unit_row = true")))
    with pytest.raises(InputError, match="cannot be read: No such file"):
        add_table(Path("absent.csv"))


def test_tables_that_no_one_can_tell_apart_are_asked_for() -> None:
    table = written("campaign,specimen,licence\na,b,MIT\n", "odd.csv")
    with pytest.raises(InputError, match=r"--kind: cannot be told from the columns"):
        add_table(table)
    with pytest.raises(InputError, match="required column missing"):
        add_table(table, kind="impact-tests")


def test_nothing_is_left_where_a_write_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    add_table(impacts())
    before = {path.name: path.read_bytes() for path in Path("lab_data").iterdir()}
    from workbench.extras.intake import add

    def full(path: Path, content: bytes) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(add, "write_atomically", full)
    with pytest.raises(InputError, match=r"lab_data.*cannot be written: No space left"):
        add_table(push_outs(), mapping=mapping())
    assert {path.name: path.read_bytes() for path in Path("lab_data").iterdir()} == before


PIECES = (
    *("", "nan", "inf", "-1", "1e400", "mm", "kN", "ksi", "%", "1,5", "n/a", "-", "synthetic"),
    *("HEB 220", "pinned", '"', "\n", "\u0663", "\u00b2", "99999999999999999999", "#", "0"),
)


@pytest.mark.thorough
def test_mutilated_tables_end_in_one_message_or_in_a_good_catalogue() -> None:
    drawn = random.Random(7)
    taken = 0
    for _ in range(25):
        studs = drawn.random() < 0.5
        table = push_outs() if studs else impacts()
        lines = [line.split(",") for line in table.read_text(encoding="utf-8").splitlines()]
        for _ in range(drawn.randint(0, 2)):
            line = drawn.choice(lines)
            line[drawn.randrange(len(line))] = drawn.choice(PIECES)
        table.write_text("\n".join(map(",".join, lines)), encoding="utf-8")
        given = mapping() if studs else None
        try:
            add_table(table, mapping=given, despite_doubts=drawn.random() < 0.5)
        except InputError:
            assert not Path("lab_data").exists()
            continue
        taken += 1
        assert check() == problems_of_own() == []
        shutil.rmtree("lab_data")
    assert taken > 3


def test_a_broken_catalogue_of_ones_own_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    add_table(impacts())
    given = Path("lab_data/catalogue.toml")
    given.write_text(given.read_text("utf-8").replace('"validate"', '"perhaps"'), encoding="utf-8")
    assert run(["data", "list"]) == 2
    assert "lab_data/catalogue.toml" in capsys.readouterr().err
    given.write_text("[[dataset]\n", encoding="utf-8")
    assert run(["data", "list"]) == 2


def test_a_file_that_is_not_of_the_catalogue_is_never_replaced() -> None:
    """The table may lie where it would be written; any other file of that name is the user's."""
    Path("lab_data").mkdir()
    table = impacts().rename("lab_data/tests.csv")
    before = table.read_bytes()
    Path("lab_data/tests-2.csv").write_text("precious", encoding="utf-8")
    added = add_table(table)
    assert table.read_bytes() == before
    assert Path("lab_data/tests-2.csv").read_text("utf-8") == "precious"
    assert added.entry.path == dataset("tests").path == Path("lab_data/tests-3.csv")
    assert load("tests")["span_m"].tolist() == [4.0, 4.0]
    assert [note for note in added.notes if "is left as it is" in note] == [
        f"lab_data/tests{end}.csv was there and is left as it is" for end in ("", "-2")
    ]
    assert add_table(table).already


@pytest.mark.thorough
def test_tables_that_are_added_at_once_are_all_catalogued() -> None:
    count = 3
    for number in range(count):
        text = "\n".join((HEADER, UNITS, ROWS[0].format("validate"))) + "\n"
        text = text.replace("our lab", f"lab {number}").replace("68,3,", f"68.{number},3,")
        Path(f"t{number}.csv").write_text(text, encoding="utf-8")
    command = [sys.executable, "-c", "from workbench.cli import main; main()", "data", "add"]
    ran = [
        subprocess.Popen([*command, f"t{number}.csv"], stdout=subprocess.PIPE, stderr=-2)
        for number in range(count)
    ]
    output = [each.communicate(timeout=600)[0].decode() for each in ran]
    assert [each.returncode for each in ran] == [0] * count, output
    for number, text in enumerate(output):
        assert f"1 rows of impact-tests are in lab_data/t{number}.csv" in text
    assert {f"t{number}" for number in range(count)} <= {entry.name for entry in datasets()}
    assert check() == problems_of_own() == []


def test_one_waits_for_who_adds_a_table_and_does_not_hang(monkeypatch: pytest.MonkeyPatch) -> None:
    from workbench.extras.intake import add
    from workbench.study.store import locked

    add_table(impacts())
    before = Path("lab_data/catalogue.toml").read_bytes()
    monkeypatch.setattr(add, "_PATIENCE", 0.1)
    with locked(Path("lab_data/.lock")), pytest.raises(InputError, match="in use by another"):
        add_table(push_outs(), mapping=mapping())
    assert Path("lab_data/catalogue.toml").read_bytes() == before
    assert not Path("lab_data/doe.csv").exists()
    assert not add_table(push_outs(), mapping=mapping()).already  # the lock itself is never stale
