"""The tutorial's commands and the notebooks' cells run as they stand."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

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


def test_the_plug_in_of_the_guide_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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


def test_commands_of_the_tutorial_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = re.findall(r"^    workbench (.+)$", (DOCS / "tutorial.md").read_text(), re.MULTILINE)
    assert len(lines) > 8
    for line in lines:
        command, _, target = line.partition(" > ")
        capsys.readouterr()
        assert run(command.split()) == 0, line
        if target:
            Path(target).write_text(capsys.readouterr().out, encoding="utf-8")
    assert (tmp_path / "answer.png").stat().st_size > 10_000
    assert (tmp_path / "answers.csv").read_text().count("\n") == 6
    assert list(tmp_path.glob("reports/*/report/report.html"))


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
