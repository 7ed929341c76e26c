"""The examples of the user guide on tests of one's own are run as they stand there."""

from __future__ import annotations

from pathlib import Path

import pytest

import workbench
from workbench.base.catalogue import load
from workbench.cli import run

GUIDE = Path(workbench.__file__).parents[1] / "docs" / "guide"


def block(text: str, begin: str, end: str) -> str:
    """The indented block between two marks of the guide."""
    result = text[text.index(begin) : text.index(end)]
    return "\n".join(line.removeprefix("    ") for line in result.splitlines())


def test_the_tables_of_the_guide_come_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pages = ("impact-tests.md", "published-tables.md")
    guide = "\n".join((GUIDE / name).read_text(encoding="utf-8") for name in pages)
    monkeypatch.delenv("WORKBENCH_DATA", raising=False)
    monkeypatch.chdir(tmp_path)
    parts = {
        "tests.csv": block(guide, "    campaign,specimen,section", "The uncertainty is the half"),
        "doe1999.csv": block(guide, "    Test No.,d,h", "with `mapping.toml`"),
        "mapping.toml": block(guide, '    title = "Push-outs of', "comes in by"),
    }
    for name, text in parts.items():
        Path(name).write_text(text, encoding="utf-8")
    commands = [
        line.strip().removeprefix("workbench ").split("  ")[0].split()
        for line in guide.splitlines()
        if line.startswith(("    workbench data add", "    workbench data check tests"))
    ]
    assert len(commands) == 3
    for command in commands:
        assert run(command) == 0, capsys.readouterr().err
    assert load("tests")["peak_m"].tolist() == [0.045, 0.096, 0.047]
    assert run(["data", "show", "tests"]) == 0
    assert run(["fit", "stud-strength", "lab_data/doe1999.csv", "--model", "roik-mean"]) == 0
    assert "3 tests of doe1999" in capsys.readouterr().out
