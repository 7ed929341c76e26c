"""The tutorial's commands and the notebooks' cells run as they stand."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from workbench.cli import run

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
