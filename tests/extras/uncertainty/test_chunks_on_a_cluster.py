"""Chunks on a Dask cluster of processes, where the library ``distributed`` is installed."""

from __future__ import annotations

import os
import signal
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from builders import UNCERTAIN

from workbench.cli import run
from workbench.study.runner import DaskCluster

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with (
        pytest.MonkeyPatch.context() as patch,
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
    ):
        patch.setattr("workbench.study.runner.WINDOW", 3)
        yield cluster


def die_once(mark: str) -> int:
    """Kill this worker, unless one has died before."""
    file = Path(mark)
    if file.exists():
        return os.getpid()
    file.touch()
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def fail(mark: str) -> None:
    with Path(mark).open("a") as stream:
        stream.write("asked\n")
    raise ValueError("a fault of the task")


def tables_near_and_far(cluster, folder: Path, samples: int) -> list[bytes]:
    """The table of one process and that of a cluster."""
    path = folder / "column.toml"
    path.write_text(f"{UNCERTAIN}mass = 1500.0\nvelocity = {{ normal = [14.0, 2.5] }}\n")
    asked = ["sample", str(path), "--model", "single-dof", "--samples", str(samples)]
    near, far = folder / "near.csv", folder / "far.csv"
    status = run([*asked, "--jobs", "1", "--out", str(near)])
    assert run([*asked, "--scheduler", cluster.scheduler_address, "--out", str(far)]) == status
    return [near.read_bytes(), far.read_bytes()]


def test_a_cluster_makes_the_same_table(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr("workbench.extras.uncertainty.chunks.STACKED", 100)
    near, far = tables_near_and_far(cluster, tmp_path, 1000)
    assert far == near


@pytest.mark.slow
def test_workers_killed_at_random_moments_change_nothing(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr("workbench.extras.uncertainty.chunks.STACKED", 1000)
    random, over = np.random.default_rng(1), threading.Event()
    killed: list[int] = []

    def kill() -> None:
        before = 0
        while not over.is_set() and len(killed) < 6:
            time.sleep(random.uniform(0.05, 0.5))
            done = len(list(tmp_path.glob(".far.csv.chunks/*.nc")))
            with suppress(ProcessLookupError, TypeError):  # one that starts has no process yet
                if done > before:
                    os.kill(cluster.workers[len(killed) % 2].pid, signal.SIGKILL)
                    killed.append(done)
                    before = done

    thread = threading.Thread(target=kill)
    thread.start()
    try:
        near, far = tables_near_and_far(cluster, tmp_path, 100_000)
    finally:
        over.set()
        thread.join()
    assert len(killed) > 2
    assert far == near


def test_lost_workers_are_replaced_and_faults_are_not_tried_again(cluster, tmp_path):
    far = DaskCluster(cluster.scheduler_address)
    (task, process, lost), *_ = far.results(die_once, [str(tmp_path / "died")])
    assert task == str(tmp_path / "died")
    assert lost is None
    assert process != os.getpid()
    (_, _, lost), *_ = far.results(fail, [str(tmp_path / "failed")])
    assert isinstance(lost, ValueError)
    assert (tmp_path / "failed").read_text() == "asked\n"


def test_a_window_of_tasks_is_at_the_cluster_at_a_time(cluster):
    taken = []
    tasks = (taken.append(k) or k for k in range(50))
    results = DaskCluster(cluster.scheduler_address).results(abs, tasks)
    done = [next(results)[1]]
    assert len(taken) <= 5  # twice the threads of the cluster, and one more
    done += [result for _, result, _ in results]
    assert sorted(done) == list(range(50))
