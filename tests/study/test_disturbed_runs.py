"""Runs that are killed; stores that are damaged, shared, misdated or another's; other locales.

The long form, with 50 kills and 50 damages: `pytest --run-slow tests/study/test_disturbed_runs.py`.
"""

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
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from workbench.base.errors import InputError
from workbench.report.build import build_report
from workbench.study import assess, load_study, run_study

STUDY = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parents[1])!r})
import workbench as wb
from toy_models import Spring

hit = wb.impact(wb.Column("HEB 220", 2.0, 2.0), mass=1500, velocity=4.0)
study = wb.Study(
    name="toy", title="Toy", question="Is it whole?", reference="fine",
    cases=tuple(wb.Case(f"{{v}} m/s", hit.at_velocity(v)) for v in range(2, 14)),
    models={{"soft": Spring(delay=0.1), "fine": Spring(error=0.08, delay=0.1)}},
)
"""
CALLS = """
import json, locale, sys
from workbench.cli import main
locale.setlocale(locale.LC_ALL, "")
for sys.argv[1:] in json.loads(sys.argv[1]):
    try:
        main()
    except SystemExit as ended:
        assert not ended.code, (sys.argv, ended.code)
"""
TURNS = [
    pytest.param(4, marks=pytest.mark.thorough),
    pytest.param(50, marks=pytest.mark.slow),
]
NOBODY = 65534
ENVIRONMENTS = {
    "tr_TR": {"LC_ALL": "tr_TR.UTF-8"},
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "POSIX": {"LC_ALL": "POSIX", "PYTHONIOENCODING": "ascii"},
    "cp1252": {"PYTHONIOENCODING": "cp1252"},
}
HIT = """kind = "column-impact"
name = "Stoß ± λ ı"
column = { section = "HEB 220", length_below = 2.0, length_above = 2.0 }
striker = { mass = 1500.0, velocity = 8.0 }
"""


@pytest.fixture
def folder() -> Iterator[Path]:
    """A folder that all users may enter, with a study file and its whole store."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        (folder / "toy.py").write_text(STUDY, encoding="utf-8")
        run_study(load_study(folder / "toy.py").study, folder / "whole", jobs=0)
        yield folder


def begun(folder: Path, store: str, *more: str) -> subprocess.Popen[str]:
    """A run of the study in processes of its own that has said how many cells it will answer."""
    calls = json.dumps([["run", "toy.py", "--store", store, *more]])
    process = subprocess.Popen([sys.executable, "-c", CALLS, calls], cwd=folder, text=True,
                               start_new_session=True, stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE)  # fmt: skip
    assert process.stderr is not None
    while "cells to answer" not in (line := process.stderr.readline()) and line:
        continue
    return process


def stored(root: Path) -> dict[str, str]:
    """Digests of the files of a store that are the same in every run."""
    paths = sorted([*root.glob("toy/cells/*.nc"), root / "toy" / "manifest.json"])
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def workers(process: int) -> list[int]:
    lists = [path.read_text().split() for path in Path(f"/proc/{process}/task").glob("*/children")]
    return [int(one) for several in lists for one in several
            if b"spawn_main" in Path(f"/proc/{one}/cmdline").read_bytes()]  # fmt: skip


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs to see other processes")
@pytest.mark.parametrize("kills", TURNS)
def test_killed_runs_end_in_the_store_of_an_undisturbed_one(folder: Path, kills: int) -> None:
    """Killed as a group or in their workers alone, at random moments, and resumed."""
    chance, killed, whole, ended = random.Random(kills), 0, stored(folder / "whole"), 1
    while killed < kills or ended != 0:
        process = begun(folder, "store", "--jobs", "2")
        if killed < kills:
            time.sleep(chance.uniform(0.0, 5.0))
            if process.poll() is None:
                killed += 1
                victims = workers(process.pid) if chance.random() < 0.5 else []
                for victim in victims:
                    with suppress(ProcessLookupError):
                        os.kill(victim, signal.SIGKILL)
                if not victims:
                    os.killpg(process.pid, signal.SIGKILL)
        said = process.communicate(timeout=300)[1]
        assert process.returncode in (0, 1, -signal.SIGKILL), said
        ended = process.returncode
        if ended == 0:
            assert stored(folder / "store") == whole
            shutil.rmtree(folder / "store")


@pytest.mark.parametrize("damages", TURNS)
def test_damaged_stores_are_answered_again_or_refused(folder: Path, damages: int) -> None:
    chance, whole, study = random.Random(damages), stored(folder / "whole"), "toy.py"
    given = load_study(folder / study).study
    for _ in range(damages):
        shutil.copytree(folder / "whole", folder / "store")
        files = [path for path in (folder / "store").rglob("*") if path.suffix in (".nc", ".json")]
        one, other = chance.sample(files, 2)
        content = bytearray(one.read_bytes())
        at = chance.randrange(len(content))
        content[at] ^= 1 << chance.randrange(8)
        kinds = (content, content[:at], other.read_bytes(), b"", None)
        if (damaged := chance.choice(kinds)) is None:
            one.unlink()
        else:
            one.write_bytes(damaged)
        try:
            run_study(given, folder / "store", jobs=0)
        except InputError:  # it alone is not made again unasked
            (folder / "store" / "toy" / "manifest.json").unlink()
            assert one.name == "manifest.json"
            run_study(given, folder / "store", jobs=0)
        assert stored(folder / "store") == whole
        shutil.rmtree(folder / "store")


@pytest.mark.thorough
def test_six_writers_of_one_store_lose_nothing(folder: Path) -> None:
    runs = [begun(folder, "store", "--jobs=0") for _ in range(6)]
    said = [run.communicate(timeout=300)[1] for run in runs]
    statuses = [run.returncode for run in runs]
    assert 0 in statuses
    assert set(statuses) <= {0, 1}, said
    assert stored(folder / "store") == stored(folder / "whole")


@pytest.mark.parametrize("now", [0.0, 4e9])
def test_clocks_change_nothing(folder: Path, now: float, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, given = stored(folder / "whole"), load_study(folder / "toy.py").study
    for path in (folder / "whole").rglob("*"):
        os.utime(path, (now, now))
    monkeypatch.setattr(time, "time", lambda: now)
    assert run_study(given, folder / "whole", jobs=0).answered == 0
    run_study(given, folder / "fresh", jobs=0, only="2 m/s")
    fresh = stored(folder / "fresh")
    del fresh["manifest.json"]
    assert fresh.items() <= whole.items()


@pytest.mark.thorough
def test_a_store_that_can_only_be_read_is_run_judged_and_reported_by_another(folder: Path) -> None:
    """By nobody where root wrote it, else by its owner without the right to write."""
    given, root, own = load_study(folder / "toy.py").study, folder / "whole", folder / "own"
    first = build_report(assess(given, root), formats=("html",), out=folder / "first")["html"]
    (root / "toy" / ".lock").unlink()
    before = {path: path.stat().st_mtime_ns for path in root.rglob("*")}
    own.mkdir()
    own.chmod(0o777)
    for path in (*before, root):
        path.chmod(0o555)
    user = os.getuid()
    os.setresuid(user or NOBODY, user or NOBODY, user)
    try:
        assert run_study(given, root, jobs=0).answered == 0
        again = build_report(assess(given, root), formats=("html",), out=own)["html"]
        with pytest.raises(InputError, match="cannot be written"):
            run_study(given, root / "toy", jobs=0)
    finally:
        os.setresuid(user, user, user)
        for path in (*before, root):
            path.chmod(0o755)
    assert again.read_bytes() == first.read_bytes()
    assert {path: path.stat().st_mtime_ns for path in root.rglob("*")} == before


@pytest.mark.thorough
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_numbers_and_files_do_not_depend_on_the_locale(folder: Path, name: str) -> None:
    store, outputs = ["toy.py", "--store", "here"], []
    calls = [["run", *store, "--jobs=0"], ["report", *store, "--format=html"], ["models"]]
    calls += [["simulate", "hit.toml", "--model=four-dof", *more] for more in ([], ["--json"])]
    (folder / "hit.toml").write_text(HIT, encoding="utf-8")
    for given in ({"PYTHONIOENCODING": "utf-8"}, ENVIRONMENTS[name]):
        command = [sys.executable, "-c", CALLS, json.dumps(calls)]
        environment = {**os.environ, **given}
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True)
        if b"unsupported locale" in done.stderr:
            pytest.skip(f"needs the locale {name}")
        assert done.returncode == 0, done.stderr
        assert stored(folder / "here") == stored(folder / "whole")
        pages = [each.read_text(encoding="utf-8") for each in folder.glob("here/toy/**/*.html")]
        compared = (folder / "here" / "toy" / "tables" / "comparisons.csv").read_bytes()
        outputs.append(
            (re.findall(rb'"(?:peak|residual|impulse).*', done.stdout), len(pages), compared)
        )
        shutil.rmtree(folder / "here")
    assert outputs[0] == outputs[1]
    assert len(outputs[0][0]) >= 3
