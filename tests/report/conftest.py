"""Stored synthetic studies, run once for all report tests."""

from __future__ import annotations

from pathlib import Path

import pytest
from synthetic_frames import frame_study
from synthetic_study import small_study, store_of, sweep_study

from workbench.report.stored import Stored


@pytest.fixture(scope="session")
def small(tmp_path_factory) -> Stored:
    return store_of(small_study(), tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="session")
def sweep(tmp_path_factory) -> Stored:
    return store_of(sweep_study(), tmp_path_factory.mktemp("sweep"))


@pytest.fixture(scope="session")
def frames(tmp_path_factory) -> Stored:
    return store_of(frame_study(), tmp_path_factory.mktemp("frames"))


@pytest.fixture(scope="session")
def built(small, tmp_path_factory) -> dict[str, Path]:
    from workbench.report.build import build_report

    out = tmp_path_factory.mktemp("report")
    return build_report(small.directory, small.study, out=out)
