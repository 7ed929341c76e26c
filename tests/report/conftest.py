"""Stored synthetic studies, run once for all report tests."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from builders import made_once
from synthetic_frames import frame_study
from synthetic_study import shared_store_of, small_study, sweep_study

from workbench.study import Study
from workbench.study.assessor import Assessment, read_assessment


@pytest.fixture(scope="session")
def small(tmp_path_factory) -> Assessment:
    return shared_store_of(small_study(), tmp_path_factory)


@pytest.fixture(scope="session")
def sweep(tmp_path_factory) -> Assessment:
    return shared_store_of(sweep_study(), tmp_path_factory)


@pytest.fixture(scope="session")
def frames(tmp_path_factory) -> Assessment:
    return shared_store_of(frame_study(), tmp_path_factory)


@pytest.fixture(scope="session")
def stills_study(frames) -> Study:
    """The study of frames with still pictures of its motion as the only figure."""
    stills = tuple(figure for figure in frames.study.figures if figure.key == "stills")
    return replace(frames.study, figures=stills)


@pytest.fixture(scope="session")
def stills_report(frames, stills_study, tmp_path_factory) -> dict[str, Path]:
    from workbench.report.build import build_report

    out = made_once(
        tmp_path_factory,
        "stills",
        lambda out: build_report(read_assessment(frames.directory, stills_study), out=out),
    )
    return paths_of(out)


@pytest.fixture(scope="session")
def built(small, tmp_path_factory) -> dict[str, Path]:
    from workbench.report.build import build_report

    out = made_once(tmp_path_factory, "report", lambda out: build_report(small, out=out))
    return paths_of(out)


def paths_of(out: Path) -> dict[str, Path]:
    return {"html": out / "report.html", "pdf": out / "report.pdf", "figures": out / "figures"}
