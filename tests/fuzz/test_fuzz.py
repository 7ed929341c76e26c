"""The small form of the fuzzing script: the same jobs in every run, and those kept for good."""

from __future__ import annotations

import random
from itertools import islice
from pathlib import Path

import pytest
from builders import made_once
from fuzz import CORPUS, jobs, make_store, perform, replay, scenario_job

KEPT = sorted(CORPUS.glob("*.json"))


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    def make(directory: Path) -> None:
        directory.mkdir()
        make_store(directory)

    return made_once(tmp_path_factory, "fuzz", make)


@pytest.mark.thorough
def test_disturbed_input_ends_in_an_answer_or_one_message(base: Path) -> None:
    root = base / "store"
    paths = [path for path in root.rglob("*") if path.is_file() and path.stat().st_size]
    stored = {str(path.relative_to(root)): path.read_bytes() for path in paths}
    endings = []
    for job in islice(jobs(random.Random(0), stored, quick=True), 16):
        ending = perform(job, base)
        assert ending.fault == "", job.arguments
        endings.append(ending.status)
    assert endings.count(0) >= 4  # most jobs must get beyond the reader
    assert endings.count(2) >= 3


@pytest.mark.slow
def test_five_hundred_disturbed_scenarios_mostly_reach_a_solver(tmp_path: Path) -> None:
    """Without a traceback, a hang, or a peak of 0 beside a history that moves."""
    random_jobs, reached = random.Random(5), 0
    for _ in range(500):
        job = scenario_job(random_jobs, quick=True)
        ending = perform(job, tmp_path)
        if "processor time" in ending.fault:  # the first run of a model compiles it
            ending = perform(job, tmp_path)
        assert ending.fault == "", job
        reached += ending.reaches_solver
    assert reached >= 250


@pytest.mark.thorough
@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.stem)
def test_what_ended_badly_once_does_so_no_more(path: Path, base: Path) -> None:
    assert replay(path, base).fault == ""
