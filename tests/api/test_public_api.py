"""Docstrings of the public names: numpydoc sections, each thing once, and examples that run."""

from __future__ import annotations

import doctest
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import workbench as wb
from workbench.base.fields import Declared
from workbench.cli import run
from workbench.studs.schema import TEMPLATES, template

NAMES = [name for name in wb.__all__ if not name.startswith("_")]
HEADING = re.compile(r"^(\w+)\n-+\n(.*?)(?=^\w+\n-+\n|\Z)", re.MULTILINE | re.DOTALL)
NEW = {"scenario.toml": "new column", "studies/mine.py": "new study"}  # files, printed by commands


def sections_of(name: str) -> dict[str, str]:
    """Sections of the docstring of a public name."""
    return dict(HEADING.findall(inspect.getdoc(getattr(wb, name)) or ""))


def arguments_of(value: Any) -> set[str]:
    """Names of the arguments that a docstring describes; declared fields describe themselves."""
    if isinstance(value, type) and issubclass(value, Declared):
        return set()
    if isinstance(value, type) and value.__init__ is Exception.__init__:
        return set()
    return set(inspect.signature(value).parameters)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the files that examples read."""
    path, rows = tmp_path_factory.mktemp("examples"), TEMPLATES["residual"].rows
    (path / "residual.csv").write_text(template("residual") + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("name", NAMES)
def test_sections_describe_every_argument_and_the_result(name: str) -> None:
    value, sections = getattr(wb, name), sections_of(name)
    described = re.findall(r"^([*\w][\w, *]*?)(?: : .+)?$", sections.get("Parameters", ""), re.M)
    arguments = {word.strip(" *") for line in described for word in line.split(",")}
    assert arguments == arguments_of(value)
    if inspect.isfunction(value):
        assert "Returns" in sections
        code = inspect.getsource(value)
        assert "Raises" in sections or not arguments or "InputError" not in code
    assert "`InputError`" not in (inspect.getdoc(value) or ""), "a section Raises says so"


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
def test_the_example_runs(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    text = sections_of(name)["Examples"]
    for file, command in NEW.items():
        if f'"{file}"' in text and not Path(file).exists():
            assert run(command.split()) == 0
            Path(file).parent.mkdir(exist_ok=True)
            Path(file).write_text(capsys.readouterr().out, encoding="utf-8")
    example = doctest.DocTestParser().get_doctest(text, {"wb": wb}, name, None, None)
    assert 1 <= len(example.examples) <= 5
    assert doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example).failed == 0


def test_the_reference_has_every_name() -> None:
    page = (Path(wb.__file__).parents[1] / "docs" / "reference.md").read_text(encoding="utf-8")
    assert [name for name in NAMES if not re.search(rf"[. ]{name}\b", page)] == []
