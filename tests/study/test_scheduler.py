"""Runs where the optional library ``distributed`` is installed."""

from __future__ import annotations

from pathlib import Path

import pytest

from workbench.base.errors import InputError
from workbench.study import Study, run_study

distributed = pytest.importorskip("distributed")


def test_a_cluster_gives_the_same_bytes(
    toy_study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # workers import the toy models as any module that is installed on the cluster
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[1]))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        far = run_study(toy_study, tmp_path / "far", scheduler=cluster.scheduler_address)
    near = run_study(toy_study, tmp_path / "near", jobs=1)
    assert far.outcomes == {"ok": 12}
    contents = [
        {path.name: path.read_bytes() for path in run.directory.glob("cells/*.nc")}
        for run in (far, near)
    ]
    assert contents[0] == contents[1]


def test_a_scheduler_that_is_not_there(
    toy_study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("workbench.study.runner.CONNECT_SECONDS", 0.5)
    with pytest.raises(InputError, match="does not answer"):
        run_study(toy_study, tmp_path, scheduler="tcp://127.0.0.1:1")
