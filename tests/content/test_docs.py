"""The tutorial's commands and the notebooks' cells run as they stand."""

from __future__ import annotations

import json
import re
import runpy
import shlex
import textwrap
from pathlib import Path
from types import ModuleType

import matplotlib.pyplot as plt
import pytest

from workbench.cli import run
from workbench.report.drawing.style import house_style
from workbench.report.gallery import to_svg
from workbench.scenarios import Column, ColumnImpact, Striker

DOCS = Path(__file__).parents[2] / "docs"
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("name", ["column", "frame", "studs", "gallery"])
def test_cells_of_notebooks_run(name: str) -> None:
    cells = CELL.findall((DOCS / "notebooks" / f"{name}.md").read_text(encoding="utf-8"))
    assert len(cells) >= 2
    names: dict[str, object] = {}
    try:
        for cell in cells:
            exec(compile(cell, name, "exec"), names)
    finally:
        plt.close("all")


def test_the_plug_in_of_the_guide_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = (DOCS / "contributing.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    file = tmp_path / "plug_in.py"
    file.write_text(code, encoding="utf-8")
    runpy.run_path(str(file), run_name="__main__")
    assert "rigid-plastic" in capsys.readouterr().out


def test_what_a_column_gives_is_there() -> None:
    page = (DOCS / "reference.md").read_text(encoding="utf-8")
    column = Column("HEB 220", 0.8, 3.2)
    names = {"column": column, "scenario": ColumnImpact("hit", column, Striker(1500.0, 10.0))}
    names |= {"steel": column.steel}
    rows = re.findall(r"^\| (`(?:column|scenario)\..*?) \|", page, re.MULTILINE)
    assert len(rows) > 8
    for row in rows:
        first, *others = re.findall(r"`([^`]+)`", row)
        parent = first.partition("(")[0].rpartition(".")[0]
        for each in (first, *others):
            known = each.startswith(("column.", "scenario."))
            eval(each if known else f"{parent}.{each.lstrip('.')}", dict(names))


COMMAND = re.compile(r"^    (workbench .+)$", re.MULTILINE)
# commands that take more than some seconds, or that never end: the first only with --run-slow
LONG = ("fragility", "verify", "rare", "sensitivity", "sample", "limit")
LONG += ("run", "report", "validate", "status", "gather")
ENDLESS = ("serve",)
PLACEHOLDERS = {"STUDY": "studies/mine.py", "FILE": "scenario.toml"}
PREPARED = {  # files that a page speaks of before, or without, a command that makes them
    "scenario.toml": "new column",
    "blast.toml": "new pulse",
    "studies/mine.py": "new study",
}


def plain(text: str) -> str:
    """Text with plain spaces between numbers and units."""
    return text.replace("\N{NO-BREAK SPACE}", " ")


def commands_of(page: str) -> list[list[str]]:
    """Arguments of all commands that a page shows, in their order."""
    shown = (re.split(r"\s#\s", line)[0] for line in COMMAND.findall(page))
    calls = [call.strip() for line in shown for call in line.split("&&")]
    words = [shlex.split(call)[1:] for call in calls if ":" not in call.split()[0]]
    return [[PLACEHOLDERS.get(word, word) for word in each] for each in words]


def blocks_of(page: str) -> list[str]:
    """Indented blocks of a page that are no commands: contents of files."""
    blocks = re.findall(r"((?:^(?:    .*)?\n)+)", page, re.MULTILINE)
    files = (
        re.split(r"^workbench ", textwrap.dedent(block), flags=re.MULTILINE)[0] for block in blocks
    )
    return [file.strip("\n") + "\n" for file in files]


def prepare(folder: Path, page: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Files that the commands of a page take for there."""
    (folder / "studies").mkdir()
    for name, command in PREPARED.items():
        assert run(command.split()) == 0
        (folder / name).write_text(capsys.readouterr().out, encoding="utf-8")
    starts = {"Test No.": "doe1999.csv", 'title = "Push': "mapping.toml"}
    starts |= {'kind = "impact-problem"': "ball.toml", "campaign,specimen,section": "tests.csv"}
    for block in blocks_of(page):
        for start, name in starts.items():
            if block.startswith(start) and not (folder / name).exists():
                (folder / name).write_text(block, encoding="utf-8")


@pytest.mark.parametrize(
    ("page", "long"),
    [
        ("README.md", False),
        ("docs/user-guide.md", False),
        ("docs/tutorial.md", True),
        pytest.param("README.md", True, marks=pytest.mark.slow),
        pytest.param("docs/user-guide.md", True, marks=pytest.mark.slow),
    ],
)
def test_commands_of_a_page_run(
    page: str,
    long: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (DOCS.parent / page).read_text(encoding="utf-8")
    prepare(tmp_path, text, capsys)
    calls = commands_of(text)
    assert len(calls) > 8
    for words in calls:
        if words[0] in ENDLESS:
            words = [words[0], "--help"]
        elif words[0] in LONG and not long:
            continue
        arguments, _, target = " ".join(words).partition(" > ")
        if target:
            words = arguments.split()
        capsys.readouterr()
        assert run(words) == 0, (words, capsys.readouterr().err)
        if target and not (tmp_path / target).exists():
            (tmp_path / target).write_text(capsys.readouterr().out, encoding="utf-8")


def test_the_python_of_the_readme_prints_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    code, printed = re.search(  # type: ignore[union-attr]
        r"((?:    import workbench as wb\n)(?:(?:    .*)?\n)+?)\S(?:.*\n)+?\n    (\d.*)\n", page
    ).groups()
    names: dict[str, object] = {}
    exec(compile(textwrap.dedent(code), "README.md", "exec"), names)
    assert plain(capsys.readouterr().out).strip() == printed
    wb = names["wb"]
    ((grade, answer),) = re.findall(r'Steel\(grade="(\w+)"\)\)` .* rate: (.*)\.\n', page)
    assert isinstance(wb, ModuleType)
    column = names["column"].changed(steel=wb.Steel(grade=grade))  # type: ignore[attr-defined]
    response = wb.simulate(wb.hit(column, mass=1500, velocity="54 km/h"))
    assert plain(response.workbench.headline).startswith(answer)


def test_numbers_of_the_guide_are_those_of_its_commands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    guide = (DOCS / "user-guide.md").read_text(encoding="utf-8")
    assert run(["new", "column"]) == 0
    Path("scenario.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    assert run(["simulate", "scenario.toml", "--json"]) == 0
    headline = plain(json.loads(capsys.readouterr().out)["headline"])
    assert f'"{headline}"' in guide
    page = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    column = next(block for block in blocks_of(page) if block.startswith("kind = "))
    Path("readme.toml").write_text(column, encoding="utf-8")
    (printed,) = re.findall(r"`([\d.]+ ± [\d.]+ mm) \(numerical\)`", guide)
    assert run(["simulate", "readme.toml", "--model", "fiber-reissner"]) == 0
    assert printed in plain(capsys.readouterr().out)


def test_every_page_stands_in_the_site() -> None:
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    pages = {path.relative_to(DOCS).with_suffix("").as_posix() for path in DOCS.rglob("*.md")}
    listed = set(re.findall(r"^([\w/-]+)$", index, re.MULTILINE))
    globbed = {page for page in pages if page.partition("/")[0] in ("theory", "decisions")}
    assert pages - globbed - {"index"} == listed - {"toctree"}


def test_pages_of_theory_show_the_figures_that_their_script_draws() -> None:
    folder = DOCS / "theory" / "figures"
    script = runpy.run_path(str(folder / "theory.py"))
    for name in script["FIGURES"]:
        page = (DOCS / "theory" / f"{name}.md").read_text(encoding="utf-8")
        assert f"(figures/{name}.svg)" in page
        assert (folder / f"{name}.svg").read_text(encoding="utf-8").startswith("<svg")
        assert page.count("$$") >= 2
        assert page.count("$$") % 2 == 0
    with house_style():  # the one that runs no model
        drawn = to_svg(script["FIGURES"]["strain-rate"](), "strain-rate")
    assert drawn == (folder / "strain-rate.svg").read_text(encoding="utf-8")
