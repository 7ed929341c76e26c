"""`workbench fit --report`: what a laboratory puts into an appendix."""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd
import pytest

from workbench.cli import run

STRENGTH = """campaign,specimen,test,diameter_mm,height_mm,slab,fcm_MPa,fu_MPa,shear_kN,failure_mode
TU lab,A1,push-out,19,100,solid,31.2,472,104.5,shank
TU lab,A2,push-out,19,100,solid,31.2,472,109.8,shank
TU lab,A3,push-out,19,100,solid,31.2,472,101.9,concrete
TU lab,A4,push-out,19,100,solid,31.2,472,107.3,shank
TU lab,B1,push-out,22,125,solid,31.2,468,140.2,concrete
TU lab,B2,push-out,22,125,solid,31.2,468,133.4,concrete
TU lab,B3,push-out,22,125,solid,31.2,468,145.1,shank
TU lab,B4,push-out,22,125,solid,31.2,468,137.0,concrete
TU lab,C1,push-out,19,100,solid,45.6,472,131.0,shank
TU lab,C2,push-out,19,100,solid,45.6,472,126.8,shank
TU lab,C3,push-out,19,100,solid,45.6,472,133.9,shank
TU lab,C4,push-out,19,100,solid,45.6,472,98.0,weld
"""
POINTS = "campaign,specimen,slip_mm,load_kN\n" + "".join(
    f"TU lab,{name},{slip},{top * share:.1f}\n"
    for name, top, speed in (("A1", 104.5, 1.0), ("A2", 109.8, 1.2), ("A3", 101.9, 0.9))
    for slip, share in ((0.2 / speed, 0.4), (0.8 / speed, 0.7), (2.5 / speed, 0.9), (6.0, 1.0))
)
HEADINGS = ("The answer", "What it rests on", "Warnings, the decisive ones first", "Figures",
            "Numbers", "Formulas and method", "The tests", "Software", "References")  # fmt: skip


def damaged() -> str:
    lines = ["campaign,specimen,test,diameter_mm,shear_kN,undamaged_shear_kN,predamage,"
             "predamage_measure,predamage_level"]  # fmt: skip
    for k, left in enumerate((0.97, 0.93, 0.90, 0.84, 0.82, 0.74, 0.71, 0.72)):
        level = 0.1 * (k + 1)
        lines.append(f"TU lab,D{k},push-out,19,{100 * left},100,fatigue,life fraction,{level:.1f}")
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """HTML of all fits, the residual also as PDF, in a folder whose name no report may tell."""
    folder = tmp_path_factory.mktemp("secretplace")
    for name, text in (("strength", STRENGTH), ("curves", POINTS), ("residual", damaged())):
        (folder / f"{name}.csv").write_text(text)
    verbs = {"strength": "stud-strength", "curves": "load-slip", "residual": "residual"}
    for name, verb in verbs.items():
        wanted = ["--report", str(folder / f"{name}.html")]
        wanted += {
            "strength": ["--model", "en1994", "--model", "ollgaard"],
            "curves": ["--law", "ollgaard"],
            "residual": ["--quantity", "strength", "--report", str(folder / "residual.pdf")],
        }[name]
        assert run(["fit", verb, str(folder / f"{name}.csv"), *wanted]) == 0
    return folder


def words_of(page: str) -> str:
    text = re.sub(r"<(style|script|svg)\b.*?</\1>", " ", page, flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", text).split())


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["strength", "curves", "residual"])
def test_a_report_has_the_answer_first_and_all_that_it_rests_on(reports: Path, name: str) -> None:
    page = (reports / f"{name}.html").read_text()
    text = words_of(page)
    places = [text.rindex(heading) for heading in HEADINGS]
    assert places == sorted(places)
    assert text.index("Grade: fitted to ") < text.index("What it rests on")
    assert "SHA-256 of the table" in text
    assert f"table: {name}.csv" in text
    assert "secretplace" not in page
    assert "\x02" not in page  # every value stands in its place
    assert not re.search(r"(src|href)=\"(?!#)", page)  # self-contained
    for kind in ("Figure", "Table"):
        numbers = [int(n) for n in re.findall(rf"\b{kind} (\d+)\. ", text)]
        assert numbers == list(range(1, len(numbers) + 1))
        assert len(numbers) >= 2
    for file in re.findall(rf"{name}-curves/[\w-]+\.csv", text):
        assert len(pd.read_csv(reports / file)) > 0
    assert (reports / f"{name}-curves" / "tests.csv").is_file()
    assert (reports / f"{name}-curves" / "influence.csv").is_file()


@pytest.mark.thorough
def test_the_report_of_strength_tells_design_values_and_every_test(reports: Path) -> None:
    text = words_of((reports / "strength.html").read_text())
    assert "on the characteristic resistance of EN 1994-1-1 [2] , which has 1.25" in text
    assert "f_c 31.2 MPa, 4 tests: P_Rk = 91.71 kN" in text
    assert "Annex B does not apply to TU lab, 19 mm, solid, f_c 45.6 MPa, 4 tests" in text
    assert "P = min(0.8 A_s f_u; 0.29 α d² √(f_c E_c))" in text
    assert all(f"{series}{k}" in text for series in "ABC" for k in range(1, 5))
    assert "Decisive: one campaign" in text
    (named,) = re.findall(r"Of ([^:]*) alone: outlier: TU lab C4", text)
    assert named.startswith("Ollgaard 1971")


@pytest.mark.thorough
def test_influence_is_that_of_leaving_a_test_out(reports: Path, tmp_path: Path) -> None:
    result = pd.read_csv(reports / "strength-curves" / "influence.csv")
    given = result[(result["panel"] == "EN 1994-1-1") & (result["specimen"] == "C4")].iloc[0]
    file = tmp_path / "without.csv"
    file.write_text("".join(line for line in STRENGTH.splitlines(True) if ",C4," not in line))
    out = tmp_path / "without.html"
    assert run(["fit", "stud-strength", str(file), "--model", "en1994", "--report", str(out)]) == 0
    rest = pd.read_csv(tmp_path / "without-curves" / "influence.csv")
    assert given["without"] == pytest.approx(rest["value"].iloc[0], rel=1e-8)  # of CSV digits


COMBINED = """campaign,specimen,test,diameter_mm,fcm_MPa,shear_kN,tension_kN
TU lab,V1,push-out,19,31,104.5,
TU lab,T1,pull-out,19,31,,72.0
TU lab,C1,combined,19,31,88.0,28.0
TU lab,C2,combined,19,31,70.0,48.0
TU lab,C3,combined,19,31,45.0,61.0
"""


@pytest.mark.parametrize(
    ("verb", "text", "more", "message"),
    [
        ("interaction", COMBINED, [], "t^p + v^p = 1, fitted"),
        ("few-tests", "\n".join(STRENGTH.splitlines()[:3]) + "\n",
         ["--known-variation", "0.1"], "rests on a scatter that is taken as known, V_r = 0.1"),
    ],
)  # fmt: skip
def test_interaction_and_few_tests_have_reports_too(
    tmp_path: Path, verb: str, text: str, more: list[str], message: str
) -> None:
    (tmp_path / "lab.csv").write_text(text)
    out = tmp_path / "out.html"
    assert run(["fit", verb, str(tmp_path / "lab.csv"), *more, "--report", str(out)]) == 0
    shown = words_of(out.read_text())
    assert message in shown
    assert "None of the checks" not in shown
    data = shown.partition("The tests as they stand in the table")[2]
    assert data.count("companion") == (2 if verb == "interaction" else 0)
    assert (tmp_path / "out-curves" / "tests.csv").is_file()


@pytest.mark.thorough
def test_unseen_tests_are_shown_as_such(tmp_path: Path) -> None:
    file, out = tmp_path / "two.csv", tmp_path / "two.html"
    lines = STRENGTH.splitlines()
    other = [line.replace("TU lab", "other").replace("31.2", "33") for line in lines[5:9]]
    file.write_text("\n".join([*lines, *other]) + "\n")
    arguments = ["--model", "en1994", "--validate", "other", "--report", str(out)]
    assert run(["fit", "stud-strength", str(file), *arguments]) == 0
    drawn = pd.read_csv(tmp_path / "two-curves" / "prediction.csv")
    assert drawn.groupby("unseen").size().to_dict() == {False: 12, True: 4}
    text = words_of(out.read_text())
    assert "4 unseen tests of other bore" in text
    assert "unseen" in text.partition("The tests as they stand")[2]


def test_the_pdf_holds_the_same(reports: Path) -> None:
    content = (reports / "residual.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    assert b"secretplace" not in content


@pytest.mark.thorough
def test_equal_input_gives_equal_bytes(reports: Path, tmp_path: Path) -> None:
    again = tmp_path / "residual.html"
    arguments = ["fit", "residual", str(reports / "residual.csv"), "--quantity", "strength"]
    assert run([*arguments, "--report", str(again)]) == 0
    assert again.read_bytes() == (reports / "residual.html").read_bytes()


@pytest.mark.parametrize(
    ("name", "message"),
    [("a.docx", "must end in html or pdf"), ("none/a.pdf", "there is no directory"),
     (".", "is a directory")],
)  # fmt: skip
def test_a_report_that_cannot_be_is_refused_before_the_fit(
    name: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["fit", "stud-strength", "--report", str(tmp_path / name)]) == 2
    assert message in capsys.readouterr().err
