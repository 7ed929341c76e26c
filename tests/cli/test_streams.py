"""What is printed reaches pipes of any encoding, closed ones too; what is read is not replaced."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from workbench.cli import plain, run
from workbench.scenarios import ColumnImpact, to_toml

COMMAND = [sys.executable, "-c", "from workbench.cli import main; main()"]


@pytest.fixture
def scenario(thesis_impact: ColumnImpact, tmp_path: Path) -> Path:
    path = tmp_path / "scenario.toml"
    text = to_toml(thesis_impact).replace(thesis_impact.name, "Stoß ± λ")
    path.write_text(text, encoding="utf-8")
    return path


# several calls in one process, each as `main` ends it; a line of its own between them
CALLS = """
import json, sys
from workbench.cli import main
for sys.argv[1:] in json.loads(sys.argv[1]):
    try:
        main()
    except SystemExit as ended:
        for stream in (sys.stdout, sys.stderr):
            print(f"<{ended.code or 0}>", file=stream, flush=True)
"""


@pytest.mark.thorough
@pytest.mark.parametrize(
    "environment",
    [
        {"PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
    ids=["ascii", "C"],
)
def test_a_pipe_that_is_not_utf_8_gets_ascii(scenario: Path, environment: dict[str, str]) -> None:
    calls = [["simulate", str(path), "--model", "energy-estimate"] for path in (scenario, "Stoß")]
    calls.insert(1, [*calls[0], "--json"])
    command = [sys.executable, "-c", CALLS, json.dumps(calls)]
    given = {**os.environ, **environment}
    done = subprocess.run(command, capture_output=True, env=given, timeout=600)
    text, content, nothing = re.split(rb"<\d>\n", done.stdout)[:3]
    assert re.findall(rb"<(\d)>", done.stdout) == [b"0", b"0", b"2"]
    assert text.startswith(b"Stoss +/- lamda: 193 mm; expected 304, 90 %: ")
    assert content.isascii()
    assert "Stoß ± λ" in json.loads(content)["provenance"]["scenario"]
    assert nothing == b""
    words = re.sub(rb"workbench: [^\n]* at work for 2 s[^\n]*\n", b"", done.stderr)  # if slow
    assert words.startswith(b"<0>\n<0>\nworkbench: ")
    assert words.count(b"\n") == 4


@pytest.mark.thorough
def test_a_pipe_or_stream_that_is_closed_ends_without_a_traceback() -> None:
    show = [*COMMAND, "data", "show", "stud-load-slip", "--json"]  # more than a pipe holds
    with subprocess.Popen(show, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == b"{\n"
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1
    for closed in (1, 2):
        script = f"import os, sys; os.close({closed}); os.execv(sys.executable, sys.argv[1:])"
        arguments = [sys.executable, *COMMAND[1:], "data", "list"]
        done = subprocess.run([sys.executable, "-c", script, *arguments], capture_output=True)
        assert (done.returncode, done.stderr) == (0, b"")


def test_signs_have_a_spelling_in_ascii() -> None:
    assert plain("10⁻⁵ N/mm² ≤ −3 ± ½ µm × √2 → Δσ 日") == (
        "10^-5 N/mm^2 <= -3 +/- 1/2 um x sqrt 2 -> deltasigma ?"
    )


def named(path: Path, ending: str) -> Path:
    """The same file by another name."""
    other = path.with_suffix(ending)
    other.hardlink_to(path)
    return other


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (lambda scenario: scenario, "is a file that is read here"),
        (lambda scenario: named(scenario, ".nc"), "is a file that is read here"),
        (lambda scenario: scenario.with_suffix(".docx"), "must end in nc"),
    ],
)
def test_an_output_never_replaces_an_input(
    scenario: Path,
    out: Callable[[Path], Path],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    before, target = scenario.read_bytes(), out(scenario)
    arguments = ["simulate", str(scenario), "--model", "four-dof", "--out", str(target)]
    assert run(arguments) == 2
    assert message in capsys.readouterr().err
    assert scenario.read_bytes() == before


def test_a_chart_is_an_svg(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["chart", "ductility", "--figure", str(tmp_path / "chart.docx")]) == 2
    assert "--figure" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
