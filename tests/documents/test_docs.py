"""The tutorial's commands and the notebooks' cells run as they stand."""

from __future__ import annotations

import ast
import itertools
import re
import runpy
import shlex
import textwrap
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib.pyplot as plt
import pytest

from workbench.base.offered import offered
from workbench.cli import run
from workbench.report.drawing.style import house_style
from workbench.report.figures import KINDS
from workbench.report.gallery import to_svg
from workbench.scenarios import Column, ColumnImpact, Striker

DOCS = Path(__file__).parents[2] / "docs"
GLOBBED = ("guide", "reference", "theory", "decisions")
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)


def cells_of_notebook(name: str) -> list[str]:
    return CELL.findall((DOCS / "notebooks" / f"{name}.md").read_text(encoding="utf-8"))


def test_the_gallery_names_what_is_there() -> None:
    """Its pictures are of kinds that are drawn; what it imports can be imported."""
    trees = [ast.parse(cell) for cell in cells_of_notebook("gallery")]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    calls = [node for node in nodes if isinstance(node, ast.Call) and len(node.args) > 1]
    kinds = {ast.literal_eval(n.args[1]) for n in calls if ast.unparse(n.func) == "picture"}
    assert len(kinds) > 15
    assert kinds <= {*KINDS, *(point.name for point in offered("figures"))}
    for node in nodes:
        if isinstance(node, ast.ImportFrom):
            module = import_module(str(node.module))
            assert all(hasattr(module, alias.name) for alias in node.names)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "name", ["column", "frame", "studs", pytest.param("gallery", marks=pytest.mark.slow)]
)
def test_cells_of_notebooks_run(name: str) -> None:
    cells = cells_of_notebook(name)
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


def test_files_that_pages_name_are_there() -> None:
    root, named = DOCS.parent, re.compile(r"`((?:\w+/)+\w+\.py)`")
    pages = (root / "README.md", *DOCS.rglob("*.md"))
    paths = {path for page in pages for path in named.findall(page.read_text(encoding="utf-8"))}
    assert len(paths) > 20
    gone = [p for p in paths if not (root / p).is_file() and not (root / "workbench" / p).is_file()]
    assert {p for p in gone if "NAME" not in p} == {"studies/mine.py"}  # of the reader


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


# a command of a page, or lines that the commands before it print
STEP = re.compile(r"^    (workbench [^\n]+)$|^```text\n(.*?)^```", re.MULTILINE | re.DOTALL)
# commands that take more than some seconds, or that never end: the first only with --run-slow
LONG = ("fragility", "verify", "rare", "sensitivity", "sample", "limit")
LONG += ("run", "report", "validate", "status", "gather")
ENDLESS = ("serve", "app")
PLACEHOLDERS = {"STUDY": "studies/mine.py", "FILE": "scenario.toml"}
PREPARED = {  # files that a page speaks of before, or without, a command that makes them
    "scenario.toml": "new column",
    "uncertain.toml": "new uncertain",
    "studies/mine.py": "new study",
}
GUIDE, THEORY = (
    sorted(path.relative_to(DOCS.parent).as_posix() for path in (DOCS / folder).glob("*.md"))
    for folder in ("guide", "theory")
)


def plain(text: str) -> str:
    """Text with single plain spaces."""
    return " ".join(text.split())


def steps_of(page: str) -> list[tuple[list[str], list[str]]]:
    """Commands that a page shows, each with the lines that it says they print by then."""
    steps: list[tuple[list[str], list[str]]] = []
    for command, printed in STEP.findall(page):
        if printed:
            steps[-1][1].extend(printed.splitlines())
        calls = re.split(r"\s#\s", command)[0].split("&&")
        words = [shlex.split(call)[1:] for call in calls if call and ":" not in call.split()[0]]
        steps += [([PLACEHOLDERS.get(word, word) for word in each], []) for each in words if each]
    return [(words, lines) for words, lines in steps if not words[0].endswith(":")]


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
    starts |= {"case,outcome,": "answers.csv"}
    starts |= {"time_ms,": "result.csv", 'kind = "column-impact"': "column.toml"}
    for block in blocks_of(page):
        for start, name in starts.items():
            if block.startswith(start) and not (folder / name).exists():
                (folder / name).write_text(block, encoding="utf-8")


def runs_of(page: str) -> list[Any]:
    """Parameters of the run of a page: without its long commands, and slowly with them."""
    steps = steps_of((DOCS.parent / page).read_text(encoding="utf-8"))
    is_long = any(words[0] in LONG for words, _ in steps)
    slow = [pytest.param(page, True, marks=pytest.mark.slow)]
    return [(page, False), *slow * is_long] if steps else []


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("page", "long"),
    [("docs/tutorial.md", True), *(run for page in ("README.md", *GUIDE) for run in runs_of(page))],
)
def test_commands_of_a_page_run_and_print_what_it_says(
    page: str,
    long: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (DOCS.parent / page).read_text(encoding="utf-8")
    prepare(tmp_path, text, capsys)
    printed, whole = "", True
    for words, lines in steps_of(text):
        if words[0] in ENDLESS:
            words = [words[0], "--help"]
        if words[0] in LONG and not long:
            whole = False
        else:
            arguments, _, target = " ".join(words).partition(" > ")
            capsys.readouterr()
            status = run(arguments.split() if target else words)
            output = capsys.readouterr()
            assert status == 0, (words, output.err)
            if target and not (tmp_path / target).exists():
                (tmp_path / target).write_text(output.out, encoding="utf-8")
            printed += output.out
        if lines:
            for line in lines if whole else ():
                assert plain(line) in plain(printed)
            printed, whole = "", True


@pytest.mark.parametrize("page", GUIDE)
def test_a_page_of_the_guide_is_short(page: str) -> None:
    text = (DOCS.parent / page).read_text(encoding="utf-8")
    assert len(text.split()) <= 900
    for name in re.findall(r"\]\(([^):#]+)(?:#[^)]*)?\)", text):
        assert (DOCS / "guide" / name).exists(), name


@pytest.mark.parametrize("page", THEORY)
def test_a_page_of_theory_opens_with_its_summary(page: str) -> None:
    _, blank, *lines = (DOCS.parent / page).read_text(encoding="utf-8").splitlines()
    table = list(itertools.takewhile(lambda line: line.startswith("|"), lines))
    rows = [line.strip("| ").split(" | ") for line in table[2:]]
    assert (blank, table[1]) == ("", "| --- | --- |")
    assert [row[0] for row in rows] == ["assumes", "holds for", "error", "cost"]
    assert all(len(row) == 2 and row[1] for row in rows)
    assert sum(len(cell.split()) for row in rows for cell in row) <= 150


def test_reference_pages_are_those_of_the_declarations() -> None:
    folder = DOCS / "reference"
    for name, page in runpy.run_path(str(folder / "generate.py"))["PAGES"].items():
        written = (folder / f"{name}.md").read_text(encoding="utf-8")
        assert written == page(), "run: python docs/reference/generate.py"


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
    response = wb.simulate(wb.impact(column, mass=1500, velocity="54 km/h"))
    assert plain(response.workbench.headline).startswith(answer)


def test_every_page_stands_in_the_site() -> None:
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    pages = {path.relative_to(DOCS).with_suffix("").as_posix() for path in DOCS.rglob("*.md")}
    listed = set(re.findall(r"^([\w/-]+)$", index, re.MULTILINE))
    globbed = {page for page in pages if page.partition("/")[0] in GLOBBED and "/" in page}
    assert pages - globbed - {"index"} == listed - {"toctree", "guide/index"}
    assert all(f"\n{folder}/*\n" in index for folder in GLOBBED)


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
