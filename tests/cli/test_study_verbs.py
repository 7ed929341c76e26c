from __future__ import annotations

import hashlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from workbench.cli import run
from workbench.scenarios import ColumnImpact, to_toml
from workbench.study.assessor import Assessment

TOYS = Path(__file__).parents[1] / "toy_models.py"

STUDY = """
from pathlib import Path

from {toys} import Spring, Troubled
from workbench.scenarios import load_scenario
from workbench.study import Case, Gate, Study

impact = load_scenario(Path(__file__).parent / "scenario.toml")
gate = dict(against="fine", quantity="peak_displacement", metric="relative_error",
            rationale="why", source="where")
study = Study(
    name="slow-toy", title="Toy", question="Does it survive?",
    cases=tuple(Case(f"v{{v}}", impact.at_velocity(v)) for v in (8.0, 10.0, 12.0, 14.0)),
    models={{
        "soft": Spring(stiffness={stiffness}, delay={delay}),
        "coarse": Spring(error=0.08, delay={delay}),
        "fine": Spring(error=0.08, level=1, delay={delay}),
        {more}
    }},
    reference="fine", ladder=("coarse", "fine"),
    gates=(Gate("soft", bound=0.5, **gate), Gate("soft", bound={bound}, **gate)),
    quick_models=("soft", "coarse", "fine"),
)
"""


@pytest.fixture
def study_file(thesis_impact: ColumnImpact, tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    # a module name of its own for each test: one process imports a name only once
    toys = "toys_" + hashlib.sha256(str(tmp_path).encode()).hexdigest()[:8]
    shutil.copy(TOYS, tmp_path / f"{toys}.py")
    (tmp_path / "scenario.toml").write_text(to_toml(thesis_impact))
    return write(tmp_path / "slow_toy.py")


def write(
    path: Path, stiffness: float = 4e6, delay: float = 0.0, bound: float = 0.4, more: str = ""
) -> Path:
    toys = next(path.parent.glob("toys_*.py")).stem
    path.write_text(
        STUDY.format(toys=toys, stiffness=stiffness, delay=delay, bound=bound, more=more)
    )
    return path


# A background job ignores Ctrl-C and hands that on to its children: the tests' own must hear it.
START = """
import resource, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)), resource.RLIM_INFINITY))
from workbench.cli import main
main()
"""


def start(*arguments: str, largest_file: int = 10**12) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", START, str(largest_file), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def stamps(store: Path) -> dict[str, tuple[int, int]]:
    """Identity of the files of all finished cells."""
    finished = {path.stem for path in store.glob("slow-toy/cells/*.json")}
    return {
        path.name: (path.stat().st_ino, path.stat().st_mtime_ns)
        for path in store.glob("slow-toy/cells/*")
        if path.stem in finished and path.suffix in (".nc", ".json")
    }


def contents(store: Path) -> dict[str, bytes]:
    directory = store / "slow-toy"
    paths = [*directory.glob("cells/*.nc"), directory / "manifest.json"]
    paths += [directory / "tables" / f"{n}.csv" for n in ("comparisons", "ladder", "gates")]
    return {path.name: path.read_bytes() for path in paths}


def until(condition: object, seconds: float = 300.0) -> None:
    end = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.01)


def processes_of_group(group: int) -> list[int]:
    values = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group and fields[0] != "Z":
            values.append(int(path.parent.name))
    return values


@pytest.mark.thorough
def test_a_killed_run_goes_on_where_it_was(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(study_file, delay=0.1)
    store = tmp_path / "killed"
    running = start("run", str(study_file), "--jobs", "2", "--store", str(store))
    until(lambda: len(stamps(store)) >= 8)
    os.kill(running.pid, signal.SIGKILL)
    running.communicate()
    assert running.returncode == -signal.SIGKILL
    before = stamps(store)
    assert 8 <= len(before) < 24
    until(lambda: not processes_of_group(running.pid))  # no worker stays behind
    (store / "slow-toy" / "cells" / "abc.nc.1.partial").write_bytes(b"half a cell")

    here = ["run", str(study_file), "--jobs", "0", "--store"]
    assert run([*here, str(store)]) == 0
    output, progress = capsys.readouterr()
    assert f"{12 - len(before) // 2} cells to answer, {len(before) // 2} already stored" in progress
    after = stamps(store)
    assert len(after) == 24
    assert {name: after[name] for name in before} == before
    assert not list(store.glob("slow-toy/cells/*.partial"))
    assert "The results are in" in output

    assert run([*here, str(tmp_path / "whole")]) == 0
    assert contents(store) == contents(tmp_path / "whole")
    assert len(contents(store)) == 16


@pytest.mark.slow
def test_twenty_kills_at_random_moments_lose_nothing_finished(
    study_file: Path, tmp_path: Path
) -> None:
    write(study_file, delay=0.05)
    store, chance = tmp_path / "killed", random.Random(3)
    asked = ["run", str(study_file), "--jobs", "2", "--store"]
    assert run([*asked[:2], "--jobs", "0", "--store", str(tmp_path / "whole")]) == 0
    before: dict[str, tuple[int, int]] = {}
    for _ in range(20):
        running = start(*asked, str(store))
        time.sleep(chance.uniform(0.0, 4.0))
        second = start(*asked, str(store))  # refused, or first in: both leave the store sound
        time.sleep(chance.uniform(0.0, 0.5))
        for process in (running, second):
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        after = stamps(store)
        assert {name: after[name] for name in before} == before
        before = after
    assert run([*asked[:2], "--jobs", "0", "--store", str(store)]) == 0
    assert contents(store) == contents(tmp_path / "whole")


@pytest.mark.thorough
def test_an_interrupt_says_what_is_stored(study_file: Path, tmp_path: Path) -> None:
    write(study_file, delay=0.5)  # long enough that the run cannot end before the signal arrives
    store = tmp_path / "store"
    running = start("run", str(study_file), "--jobs", "2", "--store", str(store))
    until(lambda: len(stamps(store)) >= 4)
    os.killpg(running.pid, signal.SIGINT)  # as the terminal does on Ctrl-C
    _, output = running.communicate()
    assert running.returncode == 130
    stored = len(stamps(store)) // 2
    last = output.splitlines()[-1]
    assert last.startswith(f"workbench: interrupted: {stored} of 12 cells are stored in {store}")
    assert "Traceback" not in output
    until(lambda: not processes_of_group(running.pid))


def workers_of_group(group: int) -> list[int]:
    def command(pid: int) -> bytes:
        try:
            return Path(f"/proc/{pid}/cmdline").read_bytes()
        except OSError:
            return b""

    return [pid for pid in processes_of_group(group) if b"spawn_main" in command(pid)]


def blocks_interrupts(pid: int) -> bool:
    status = Path(f"/proc/{pid}/status").read_text()
    blocked = re.search(r"^SigBlk:\s*([0-9a-f]+)$", status, re.M)
    assert blocked is not None
    return bool(int(blocked[1], 16) >> (signal.SIGINT - 1) & 1)


@pytest.mark.thorough
def test_an_interrupt_while_workers_import_is_for_the_run_alone(
    study_file: Path, tmp_path: Path
) -> None:
    running = start("run", str(study_file), "--jobs", "2", "--store", str(tmp_path / "store"))
    until(lambda: len(workers_of_group(running.pid)) == 2)
    assert all(blocks_interrupts(pid) for pid in workers_of_group(running.pid))
    os.killpg(running.pid, signal.SIGINT)
    _, output = running.communicate()
    assert running.returncode == 130
    # 0 of them, but on a machine that has so much to do that the workers are seen late
    assert re.search(r"interrupted: \d+ of 12 cells are stored", output)
    assert "Traceback" not in output
    until(lambda: not processes_of_group(running.pid))


@pytest.mark.thorough
def test_a_worker_killed_while_it_starts_is_told_as_such(study_file: Path, tmp_path: Path) -> None:
    running = start("run", str(study_file), "--jobs", "1", "--store", str(tmp_path / "store"))
    until(lambda: workers_of_group(running.pid))
    os.kill(workers_of_group(running.pid)[0], signal.SIGKILL)
    _, output = running.communicate()
    assert running.returncode == 1
    assert "a worker process ended before it had a cell" in output
    assert "Traceback" not in output


@pytest.mark.thorough
def test_a_full_disk_is_one_message_and_loses_nothing(study_file: Path, tmp_path: Path) -> None:
    """A limit of the size of files stands for it: the system refuses to write in the same way."""
    store = tmp_path / "store"
    command = ["run", str(study_file), "--jobs", "0", "--store", str(store)]
    assert run([*command, "--only", "v8.0"]) == 0
    before = {path: path.read_bytes() for path in store.rglob("*.*") if path.is_file()}
    full = start(*command, largest_file=4000)
    _, output = full.communicate()
    assert full.returncode in (1, 2)
    last = output.splitlines()[-1]
    assert last.startswith("workbench: ")
    assert "cannot be" in last
    assert "Traceback" not in output
    assert {path: path.read_bytes() for path in before} == before
    assert not list(store.rglob("*.partial"))
    assert run(command) == 0
    assert len(stamps(store)) == 24


@pytest.mark.thorough
def test_run_status_validate(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--store", str(tmp_path / "store")]
    assert run(["validate", str(study_file), *where]) == 2
    assert "run it first" in capsys.readouterr().err
    assert run(["status", str(study_file), *where]) == 0
    assert "0 done, 0 failed, 12 to do" in capsys.readouterr().out
    assert run(["run", str(study_file), "--jobs", "0", *where]) == 0
    text = capsys.readouterr().out
    assert "soft against fine: relative error of peak displacement" in text
    assert "Cells: 12 ok." in text
    assert run(["status", str(study_file), *where, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["counts"] == {"done": 12, "failed": 0, "to do": 0}
    assert run(["validate", str(study_file), *where, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [gate["verdict"] for gate in answer["gates"]] == ["pass", "pass"]
    assert run(["run", str(study_file), "--jobs", "0", *where, "--json"]) == 0
    captured = capsys.readouterr()
    answer = json.loads(captured.out)
    assert captured.err == ""
    assert (answer["answered"], answer["stored"]) == (0, 12)
    assert answer["outcomes"] == {"ok": 12}


@pytest.mark.thorough
def test_validate_fails_when_a_gate_does(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--store", str(tmp_path / "store")]
    strict = write(study_file.with_name("strict.py"), stiffness=1e6, bound=0.4)
    assert run(["run", str(strict), "--jobs", "0", *where]) == 0  # its cells are fine
    capsys.readouterr()
    assert run(["validate", str(strict), *where]) == 1
    text = capsys.readouterr().out
    assert any(line.startswith("fail  ") for line in text.splitlines())
    assert "fail: soft against fine" in text


def test_status_explains_a_changed_option(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--store", str(tmp_path / "store")]
    assert run(["run", str(study_file), "--jobs", "0", *where]) == 0
    other = write(study_file.with_name("other.py"), stiffness=3e6)
    capsys.readouterr()
    assert run(["status", str(other), *where]) == 0
    text = capsys.readouterr().out
    assert "8 done, 0 failed, 4 to do" in text
    assert "to do (4), option stiffness 4000000.0 -> 3000000.0: v8.0/soft, v10.0/soft" in text


@pytest.mark.thorough
def test_a_cell_that_fails_is_status_1_and_shown(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--store", str(tmp_path / "store")]
    more = '"bad": Troubled("solver", above=13.0), "no": Troubled("refuse"),'
    troubled = write(study_file.with_name("troubled.py"), more=more)
    assert run(["run", str(troubled), "--jobs", "0", *where]) == 1
    text = capsys.readouterr().out
    assert "v14.0/bad: not-converged: no convergence at" in text
    assert "Cells: 1 not-converged, 15 ok, 4 out-of-domain" in text
    assert run(["status", str(troubled), *where]) == 0
    text = capsys.readouterr().out
    assert "15 done, 5 failed, 0 to do" in text
    assert "not-converged (1): v14.0/bad" in text
    assert run(["run", str(troubled), "--only", "soft", "--jobs", "0", *where]) == 0


@pytest.mark.thorough
def test_the_quick_form(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--store", str(tmp_path / "store")]
    more = '"bad": Troubled("solver"),'
    study = write(study_file.with_name("quick.py"), more=more)
    assert run(["run", str(study), "--quick", "--jobs", "0", *where]) == 0
    assert (tmp_path / "store" / "slow-toy-quick" / "tables" / "gates.csv").is_file()
    assert run(["validate", str(study), "--quick", *where]) == 0
    assert "12 ok" in capsys.readouterr().out


@pytest.mark.thorough
def test_report_hands_the_store_to_the_builder(
    study_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[object] = []

    def build(stored: Assessment, formats: object, out: object) -> dict[str, Path]:
        seen.extend((stored.directory, len(stored.responses), formats, out))
        return {"html": stored.directory / "report.html"}

    monkeypatch.setattr("workbench.report.build.build_report", build)
    where = ["--store", str(tmp_path / "store")]
    assert run(["report", str(study_file), *where]) == 2
    assert "run it first" in capsys.readouterr().err
    assert run(["run", str(study_file), "--jobs", "0", *where]) == 0
    capsys.readouterr()
    assert run(["report", str(study_file), *where, "--format", "html", "--json"]) == 0
    directory = tmp_path / "store" / "slow-toy"
    assert seen == [directory, 12, ("html",), None]  # all cells are read by now
    answer = json.loads(capsys.readouterr().out)
    assert answer["files"] == {"html": str(directory / "report.html")}
    assert run(["report", str(study_file), *where, "--format", "html"]) == 0
    assert (
        "No explorer: no answer of this study is a history or a curve." in capsys.readouterr().out
    )
    monkeypatch.setattr("workbench.report.explorer.MOST_CELLS", 11)
    assert run(["report", str(study_file), *where, "--format", "html"]) == 0
    assert "No explorer: a browser does not hold 12 answers." in capsys.readouterr().out


def test_an_unknown_kind_of_figure_stops_the_run_before_it_begins(
    study_file: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(study_file.parent)
    text = study_file.read_text().replace("Case, Gate, Study", "Case, Figure, Gate, Study")
    study_file.write_text(text.replace('reference="fine",', 'reference="fine", figures=(PIE,),'))
    study_file.write_text(
        study_file.read_text().replace(
            "study = Study(", 'PIE = Figure("pie", "pie", "Pie", "Of nothing.")\nstudy = Study('
        )
    )
    assert run(["run", str(study_file), "--jobs", "0"]) == 2
    assert "figure.kind" in capsys.readouterr().err
    assert not (study_file.parent / "reports").exists()
