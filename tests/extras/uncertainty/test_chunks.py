"""Chunks of answers: the same table from one run, threads, processes, slices; what is refused."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import UNCERTAIN

from workbench.base.errors import WorkbenchError
from workbench.cli import run
from workbench.extras.uncertainty.chunks import SampleRequest, Span
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.single_dof import SingleDof

# one in some samples collapses, one in some is refused, one input is a text
SECTION = '{ discrete = { values = ["HEB 220", "HEA 240"], weights = [1.0, 1.0] } }'
TEXT = f"""{UNCERTAIN}mass = 1500.0
velocity = {{ normal = [14.0, 2.5] }}
""".replace('"HEB 220"', SECTION).replace("mean = 500e3, cov = 0.15", "mean = 1.0e6, cov = 0.6")
ASKED = ("--model", "single-dof", "--jobs", "1", "--samples", "450", "--first", "30")


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """Arguments that ask for samples, in chunks of 100."""
    monkeypatch.setattr("workbench.extras.uncertainty.chunks.STACKED", 100)
    monkeypatch.setattr("workbench.extras.uncertainty.chunks.ALONE", 100)
    path = tmp_path / "column.toml"
    path.write_text(TEXT)
    return ["sample", str(path), *ASKED]


@pytest.fixture
def whole(asked, tmp_path):
    """The table of one run."""
    out = tmp_path / "whole.csv"
    run([*asked, "--out", str(out)])
    return out.read_bytes()


def slices_in(folder: Path, asked, count: int) -> None:
    for number in range(count, 0, -1):
        run([*asked, "--slice", f"{number}/{count}", "--out", str(folder)])


def test_the_table_has_what_it_should(asked, whole, tmp_path):
    table = pd.read_csv(tmp_path / "whole.csv", keep_default_na=False)
    assert set(table["outcome"]) == {"ok", "collapse", "invalid-input"}
    assert set(table["column.section"]) == {"HEB 220", "HEA 240"}
    assert table["failure"].nunique() > 20
    assert len(table) == 450


@pytest.mark.thorough
@pytest.mark.parametrize("ending", ["csv", "nc", "parquet", "xlsx"])
def test_slices_make_the_same_table(asked, tmp_path, ending):
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    out, joined = tmp_path / f"whole.{ending}", tmp_path / f"joined.{ending}"
    status = run([*asked, "--out", str(out)])
    slices_in(tmp_path / "a.chunks", asked, 3)
    assert run(["gather", str(tmp_path / "a.chunks"), "--out", str(joined)]) == status
    if ending == "xlsx":  # a workbook says when it was made
        pd.testing.assert_frame_equal(pd.read_excel(out), pd.read_excel(joined))
    else:
        assert joined.read_bytes() == out.read_bytes()


@pytest.mark.thorough
@pytest.mark.parametrize("stacked", [True, False])
def test_threads_and_processes_make_the_same_table(asked, whole, tmp_path, monkeypatch, stacked):
    if not stacked:
        monkeypatch.setattr("workbench.extras.uncertainty.chunks.can_stack", lambda *_: False)
    out = tmp_path / "answers.csv"
    run([*asked, "--jobs", "2", "--out", str(out)])
    assert out.read_bytes() == whole


def test_a_folder_goes_on_and_damaged_chunks_are_answered_again(asked, whole, tmp_path, capsys):
    folder, joined = tmp_path / "a.chunks", tmp_path / "joined.csv"
    run([*asked, "--out", str(folder)])
    first, second, *_ = sorted(folder.iterdir())
    content = bytearray(first.read_bytes())
    content[-9] ^= 1
    first.write_bytes(content)
    second.unlink()
    assert run(["gather", str(folder), "--out", str(joined)]) == 2
    assert "no sound chunk" in capsys.readouterr().err
    run([*asked, "--out", str(folder)])
    assert "3 of 5 chunks are there already" in capsys.readouterr().err
    run(["gather", str(folder), "--out", str(joined)])
    assert joined.read_bytes() == whole


def test_a_sequence_goes_on_in_the_same_folder(asked, tmp_path):
    folder = tmp_path / "a.chunks"
    run([*asked, "--out", str(folder)])
    run([*asked, "--first", "480", "--samples", "150", "--out", str(folder)])
    run([*asked, "--samples", "600", "--out", str(tmp_path / "whole.csv")])
    run(["gather", str(folder), "--out", str(tmp_path / "joined.csv")])
    assert (tmp_path / "joined.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_what_cannot_be_gathered_is_one_line(asked, tmp_path, capsys):
    folder, out = tmp_path / "a.chunks", str(tmp_path / "joined.csv")

    def refused(*parts: Path) -> str:
        capsys.readouterr()
        assert run(["gather", *map(str, parts), "--out", out]) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert not Path(out).exists()
        return error

    slices_in(folder, asked, 2)
    files = sorted(folder.iterdir(), key=lambda file: int(file.name.split("-")[1]))
    assert "samples 30 to 99 are missing" in refused(*files[1:])
    assert "samples 100 to 199 are missing" in refused(files[0], *files[2:])
    assert "samples 400 to 479 are missing" in refused(*files[:-1])
    run([*asked, "--samples", "40", "--out", str(tmp_path / "b.chunks")])
    assert "samples 30 to 69 stand in two files" in refused(folder, tmp_path / "b.chunks")
    run([*asked, "--seed", "2", "--out", str(tmp_path / "c.chunks")])
    assert "another seed than" in refused(folder, tmp_path / "c.chunks")
    files[0].rename(files[0].with_name(files[0].name.replace("-30-100-", "-0-70-")))
    assert "its name does not go with its content" in refused(folder)
    (tmp_path / "empty").mkdir()
    assert "no chunk" in refused(tmp_path / "empty")
    assert "No such file" in refused(tmp_path / "nothing")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--slice", "3/2", "--out", "a.chunks"), "3/8"),
        (("--slice", "third", "--out", "a.chunks"), "3/8"),
        (("--slice", "9/9", "--samples", "50", "--out", "a.chunks"), ""),
        (("--slice", "1/9", "--samples", "50", "--out", "a.chunks"), "must divide"),
        (("--slice", "1/2", "--out", "a.csv"), ".chunks"),
    ],
)
def test_wrong_slices_are_one_line(asked, tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    status = run([*asked, *arguments])
    assert (status == 2) == bool(message)
    assert message in capsys.readouterr().err


def test_chunks_do_not_depend_on_what_is_asked_for(asked):
    question = SampleRequest(TEXT, SingleDof(), 1)
    spans = question.spans(Span(30, 480))
    assert spans == [(30, 100), (100, 200), (200, 300), (300, 400), (400, 480)]
    assert question.spans(Span(100, 200)) == [(100, 200)]
    assert question.spans(Span(0, 1000))[1:4] == spans[1:4]


def test_what_an_answer_depends_on_is_in_its_key():
    others = [
        SampleRequest(TEXT, SingleDof(), 1),
        SampleRequest(TEXT, SingleDof(), 2),
        SampleRequest(TEXT, SingleDof(radiation_damping=10.0), 1),
        SampleRequest(TEXT, EnergyEstimate(), 1),
        SampleRequest(TEXT.replace("1500.0", "1501.0"), SingleDof(), 1),
    ]
    assert len({question.key for question in others}) == len(others)
    with pytest.raises(WorkbenchError, match="install the same everywhere"):
        SampleRequest(TEXT, SingleDof(), 1, "0.0").table(Span(0, 1))


IN_PROCESSES = """
import sys
from workbench.cli import run
from workbench.extras.uncertainty import chunks
chunks.STACKED = chunks.ALONE = 100
chunks.can_stack = lambda *_: False
if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
"""


def children_of(process: subprocess.Popen[str]) -> list[int]:
    text = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return [int(word) for word in text.read_text().split()]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs to see child processes")
@pytest.mark.parametrize("what", ["run", "process"])
def test_killed_at_random_moments_nothing_finished_is_lost(tmp_path, what):
    script, path = tmp_path / "sample.py", tmp_path / "column.toml"
    script.write_text(IN_PROCESSES)
    path.write_text(TEXT)
    asked = ["sample", str(path), "--model", "energy-estimate", "--samples", "20000", "--jobs", "2"]

    def started(out: Path) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, str(script), *asked, "--out", str(out)],
            **{"stderr": subprocess.PIPE, "stdout": subprocess.DEVNULL, "text": True},
            start_new_session=True,
        )

    started(tmp_path / "whole.csv").communicate()
    random, folder, finished = np.random.default_rng(1), tmp_path / ".answers.csv.chunks", set()
    for _ in range(20):
        process = started(tmp_path / "answers.csv")
        while process.poll() is None and {file.name for file in folder.glob("*.nc")} <= finished:
            time.sleep(0.01)
        time.sleep(random.uniform(0.0, 0.1))
        with suppress(ProcessLookupError, FileNotFoundError, IndexError):  # it is over
            if what == "run":
                os.killpg(process.pid, signal.SIGKILL)
            else:
                os.kill(children_of(process)[-1], signal.SIGKILL)
        error = process.communicate()[1]
        assert "Traceback" not in error
        if (tmp_path / "answers.csv").exists():
            break  # all chunks were there
        assert process.returncode in (1, -signal.SIGKILL)
        now = {file.name for file in folder.glob("*.nc")}
        assert finished <= now
        finished = now
    started(tmp_path / "answers.csv").communicate()
    assert (tmp_path / "answers.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
