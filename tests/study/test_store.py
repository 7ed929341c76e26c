"""The store of a study against a second run, exchanged cells and links that lead elsewhere."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any, ClassVar

import numpy as np
import pytest
import xarray as xr
from toy_models import Spring

from workbench.base.errors import InputError
from workbench.models.four_dof import FourDof
from workbench.report.build import build_report
from workbench.responses import Outcome, Response, failed_response
from workbench.responses.build import provenance
from workbench.scenarios import ColumnImpact, Scenario
from workbench.study import Case, CellProgress, Store, Study, assess, cells_of, run_study, survey
from workbench.study.assessor import read_assessment
from workbench.study.store import (
    canonical_json,
    read_netcdf,
    to_netcdf_bytes,
    write_atomically,
)


@pytest.fixture
def small(toy_study: Study) -> Study:
    """Two velocities, two stiffnesses."""
    models = {name: toy_study.models[name] for name in ("soft", "fine")}
    cases = toy_study.cases[:2]
    return dataclasses.replace(toy_study, cases=cases, models=models, ladder=(), quick_models=())


def written(study: Study, root: Path) -> None:
    """All that `run` and `report` write into a store."""
    run_study(study, root, jobs=0)
    assess(study, root)
    build_report(read_assessment(root / study.name, study), formats=("html",))


def states(study: Study, root: Path) -> list[CellProgress]:
    return [entry.state for entry in survey(study, cells_of(study), Store(root / study.name))]


def test_refused_runs_and_reports_leave_the_files_of_a_run_alone(
    small: Study, tmp_path: Path
) -> None:
    run_study(small, tmp_path, jobs=0, only="soft")
    store = Store(tmp_path / "toy")
    with store.alone():
        written = [d / "x.1.partial" for d in (store.directory, store.cells, store.tables)]
        for path in written:
            path.write_bytes(b"being written")
        for _ in range(50):
            with pytest.raises(InputError, match="in use by another run"):
                run_study(small, tmp_path, jobs=0)
        assess(small, tmp_path)  # as `workbench report` does beside a run
        assert all(path.is_file() for path in written)
    run_study(small, tmp_path, jobs=0, only="soft")
    assert not any(path.exists() for path in written)


@pytest.mark.parametrize("forged", [False, True])
def test_exchanged_cells_are_answered_again(small: Study, tmp_path: Path, forged: bool) -> None:
    run_study(small, tmp_path, jobs=0)
    store = Store(tmp_path / "toy")
    cells = cells_of(small)
    # the other velocity, the other options: each differs from the first in one thing
    for other in (2, 1):
        one, two = cells[0].key, cells[other].key
        names = [
            (store.cells / f"{one}{end}", store.cells / f"{two}{end}") for end in (".nc", ".json")
        ]
        for a, b in names:
            content = a.read_bytes()
            a.write_bytes(b.read_bytes())
            b.write_bytes(content)
        if forged:  # the records agree with their names and files, the responses do not
            for key in (one, two):
                record = json.loads((store.cells / f"{key}.json").read_text())
                digest = hashlib.sha256((store.cells / f"{key}.nc").read_bytes()).hexdigest()
                record |= {"key": key, "sha256": digest}
                write_atomically(store.cells / f"{key}.json", canonical_json(record))
        assert states(small, tmp_path).count(CellProgress.TO_DO) == 2
        table = assess(small, tmp_path).tables["cells"]
        assert list(table["outcome"]).count("not run") == 2
        assert run_study(small, tmp_path, jobs=0).answered == 2
        assert states(small, tmp_path).count(CellProgress.TO_DO) == 0


def test_records_of_any_content_are_corrupt(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    path = Store(tmp_path / "toy").cells / f"{cells_of(small)[0].key}.json"
    sound = json.loads(path.read_text())
    wrong = {"outcome": [], "wall_time": "2 s", "limit": {}, "provenance": "me", "sha256": 1}
    forged = [json.dumps({**sound, name: value}) for name, value in wrong.items()]
    lacking = [json.dumps({k: sound[k] for k in sound if k != name}) for name in wrong]
    nonsense = ["[]", "7", "[" * 100_000, '{"outcome": "fine"}', "\xff"]
    for record in (*forged, *lacking, *nonsense):
        path.write_bytes(record.encode("latin-1"))
        assert states(small, tmp_path).count(CellProgress.TO_DO) == 1, record[:20]
    assert run_study(small, tmp_path, jobs=0).answered == 1


def test_a_cell_under_the_name_of_another_is_none(small: Study, tmp_path: Path) -> None:
    """As of another version of the package, which only the key tells."""
    run_study(small, tmp_path, jobs=0)
    store, cell = Store(tmp_path / "toy"), cells_of(small)[0]
    assert store.answer(cell.key, cell.ingredients) is not None
    record = json.loads((store.cells / f"{cell.key}.json").read_text())
    path = store.cells / f"{cell.key}.json"
    path.write_bytes(canonical_json({**record, "outcome": "collapse"}))  # the file says ok
    assert store.holds(cell.key)
    assert store.answer(cell.key, cell.ingredients) is None
    path.write_bytes(canonical_json(record))
    other = "0" * len(cell.key)
    for end in (".nc", ".json"):
        (store.cells / f"{cell.key}{end}").rename(store.cells / f"{other}{end}")
    assert store.holds(other)
    assert store.answer(other, cell.ingredients) is None


def test_manifests_of_any_content_are_refused(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    path = Store(tmp_path / "toy").manifest
    sound = json.loads(path.read_text())
    entry = sound["cells"][0]
    entries = [7, [], {}, {**entry, "key": 1}, {**entry, "ingredients": []}]
    entries += [{**entry, "case": None}, {**entry, "answered": "yes"}]
    forged = [json.dumps({**sound, "cells": [each]}) for each in entries]
    for content in (*forged, '{"cells": 7}', "[]", "[" * 100_000):
        path.write_text(content)
        with pytest.raises(InputError, match="cannot be read; remove it and run again"):
            survey(small, cells_of(small), Store(tmp_path / "toy"))
    path.unlink()
    assert run_study(small, tmp_path, jobs=0).answered == 0


@pytest.mark.thorough
def test_what_is_written_already_is_not_written_again(small: Study, tmp_path: Path) -> None:
    """A store that can only be read, on a shared disk, can be judged and reported."""
    written(small, tmp_path)
    files = [path for path in (tmp_path / "toy").rglob("*") if path.is_file()]
    before = {path: path.stat().st_mtime_ns for path in files}
    assess(small, tmp_path)
    build_report(
        read_assessment(tmp_path / "toy", small), formats=("html",), out=tmp_path / "elsewhere"
    )
    assert {path: path.stat().st_mtime_ns for path in files} == before


def test_a_pipe_in_the_place_of_a_cell_does_not_hang(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    path = Store(tmp_path / "toy").cells / f"{cells_of(small)[0].key}.nc"
    path.unlink()
    os.mkfifo(path)
    assert states(small, tmp_path).count(CellProgress.TO_DO) == 1
    assert run_study(small, tmp_path, jobs=0).answered == 1
    assert path.is_file()


@pytest.mark.thorough
@pytest.mark.parametrize("place", ["cells", "tables", "report", "report/figures", ".lock"])
def test_nothing_is_written_through_a_link_in_place_of_a_directory_or_the_lock(
    small: Study, tmp_path: Path, place: str
) -> None:
    run_study(small, tmp_path, jobs=0)
    store, target = tmp_path / "toy", tmp_path / "precious"
    assess(small, tmp_path)
    link = store / place
    if place == ".lock":
        link.unlink()
        target.write_text("precious")
    else:
        target.mkdir()
        for name in ("cells.csv", "structure.svg", "report.html", "x.1.partial"):
            (target / name).write_text("precious")
        link.parent.mkdir(exist_ok=True)
        if link.exists():
            link.rename(tmp_path / "aside")
    link.symlink_to(target)
    with pytest.raises(InputError, match=r"link|cannot be written"):
        written(small, tmp_path)
    kept = [target] if target.is_file() else sorted(target.iterdir())
    assert {path.read_text() for path in kept} == {"precious"}
    assert len(kept) in (1, 4)


@pytest.mark.thorough
def test_files_of_a_report_replace_links_and_do_not_follow_them(
    small: Study, tmp_path: Path
) -> None:
    for directory in ("report/figures", "tables"):
        (tmp_path / "toy" / directory).mkdir(parents=True)
    names = ("figures/cost.svg", "figures/cost.csv", "report.html", "../tables/cells.csv")
    links = [tmp_path / "toy" / "report" / name for name in names]
    precious = tmp_path / "precious"
    precious.write_text("precious")
    for link in links:
        link.symlink_to(precious)
    written(small, tmp_path)
    assert precious.read_text() == "precious"
    assert all(link.is_file() and not link.is_symlink() for link in links)


def test_a_link_planted_where_a_file_is_prepared_is_not_followed(tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("precious")
    (tmp_path / f"table.csv.{os.getpid()}.partial").symlink_to(precious)
    write_atomically(tmp_path / "table.csv", b"new")
    assert (precious.read_text(), (tmp_path / "table.csv").read_bytes()) == ("precious", b"new")


def test_stored_answers_are_read_as_xarray_reads_them(
    thesis_impact: ColumnImpact, tmp_path: Path
) -> None:
    hit = FourDof().simulate(thesis_impact)
    given = hit.assign(
        {
            "toy.words": ("toy", ["a", "b"], {"units": "1", "long_name": "words"}),
            "toy.flags": ("toy", [True, False], {"units": "1", "long_name": "flags"}),
            "toy.counts": ("toy", np.array([1, 2], dtype=np.int32), {"units": "1"}),
        }
    )
    failed = failed_response(Outcome.CRASHED, "no reason")
    for response in (
        hit,
        given,
        given.assign_coords(toy=["x", "y"], at=("toy", [0.1, 0.2])),
        failed,
    ):
        path = tmp_path / "cell.nc"
        path.write_bytes(to_netcdf_bytes(response))
        expected = xr.open_dataset(path, decode_times=False).load().drop_encoding()
        read = read_netcdf(path)
        xr.testing.assert_identical(read, expected)
        for name, variable in expected.variables.items():
            kind = read.variables[name].dtype.kind  # xarray reads names as objects
            assert kind == variable.dtype.kind or (kind, variable.dtype.kind) == ("U", "O")
        assert not set(read.xindexes) ^ set(expected.xindexes)


def test_cells_cost_the_same_whatever_their_number(
    small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    provenance()  # read once, for all cells
    monkeypatch.setattr("importlib.metadata.version", lambda name: pytest.fail(f"{name} again"))
    assert len(cells_of(small)) == 4


@pytest.mark.slow
def test_six_thousand_cells_are_assessed_in_ten_seconds(small: Study, tmp_path: Path) -> None:
    hit = small.cases[0].scenario
    speeds = np.linspace(3.0, 20.0, 3000).tolist()
    cases = tuple(Case(f"v{i}", hit.at_velocity(v)) for i, v in enumerate(speeds))
    many = dataclasses.replace(small, cases=cases)
    run_study(many, tmp_path, jobs=0)
    begin = process_time()
    assert len(assess(many, tmp_path).responses) == 6000
    assert process_time() - begin <= 10.0


def no_parts(response: Response) -> Response:
    values = {"outcome": "collapse", "collapse": '{"mechanism": "geometry", "parts": 7}'}
    return response.drop_vars(list(response.variables)).assign_attrs(values)


def instead(name: str, *variable: Any) -> Change:
    """A change of a response: another variable under a name."""
    values = {"units": "m", "long_name": "x"}
    return lambda response: response.assign({name: (*variable, values)})


def saying(name: str, *message: Any) -> list[Change]:
    """Changes of a response: an attribute that says something else."""
    return [lambda response, one=one: response.assign_attrs({name: one}) for one in message]


Change = Callable[[Response], Response]
FINDING = '[{"subject": "a", "severity": "warning", "sentence": %s, "remedy": "", "number": %s}]'
MESHES = '{"levels": [1, 2], "directions": [], "statements": %s, "quantities": %s}'
BROKEN: dict[str, list[Change]] = {
    "values": [
        instead("peak_displacement", (), value) for value in ("large", b"1", float("nan"), 1e300)
    ],
    "dimensions": [
        instead("peak_displacement", "z", [0.1, 0.2]),
        instead("displacement", (), 0.1),
        lambda response: response.isel(time=slice(0, 0)),
        lambda response: response.assign_coords(time=response["time"].values[::-1]),
    ],
    "units": [lambda response: response.assign(peak_displacement=0.1)],
    "unknown": [instead("peak_dsplacement", (), 0.1)],
    "findings": saying(
        "findings", "", "[1]", "null", 7, FINDING % (7, 1), FINDING % ('"b"', '"c"')
    ),
    "collapse": [no_parts, lambda response: no_parts(response).assign_attrs(collapse="{}")],
    "outcome": saying("outcome", "collapse", "fine", 7),
    "message": saying("message", 7),
    "scenario": saying("scenario", 7),
    "widths": saying("numerical_uncertainty", "", "[]", 7, '{"peak_displacement": "x"}'),
    "meshes": saying("refinement", "[]", "{}", MESHES % (7, "{}"), MESHES % ("[]", '{"a": {}}')),
    "data": saying("data_uncertainty", "7", '{"peak_displacement": NaN}'),
    "interval": saying("sampling_interval", '{"peak_displacement": [1]}', "[]"),
}


REPORTED = ("findings",)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", BROKEN)
def test_cells_that_are_signed_but_broken_are_answered_again(
    small: Study, tmp_path: Path, kind: str
) -> None:
    run_study(small, tmp_path, jobs=0)
    store, cell = Store(tmp_path / "toy"), cells_of(small)[0]
    sound, record = store.response(cell.key), store.record(cell.key)
    for change in BROKEN[kind]:
        broken = change(sound.copy(deep=True))
        outcome = broken.attrs["outcome"]
        values = {**record, "outcome": outcome if isinstance(outcome, str) else "ok"}
        store.put(cell.key, to_netcdf_bytes(broken), values)
        assert states(small, tmp_path).count(CellProgress.TO_DO) == 1
        assert assess(small, tmp_path).tables["cells"]["outcome"][0] == "not run"
    if kind in REPORTED:  # a report reads what `assess` has read: nothing of a broken cell
        build_report(read_assessment(store.directory, small), formats=("html",))
    assert run_study(small, tmp_path, jobs=0).answered == 1
    assert states(small, tmp_path).count(CellProgress.TO_DO) == 0


def test_a_model_that_says_what_no_one_can_read_has_crashed(small: Study, tmp_path: Path) -> None:
    study = dataclasses.replace(small, models={"soft": Garbled(), "fine": small.models["fine"]})
    assert run_study(study, tmp_path, jobs=0).outcomes == {"crashed": 2, "ok": 2}
    assert "garbled" in assess(study, tmp_path).tables["cells"]["message"][0]


@dataclasses.dataclass(frozen=True)
class Garbled(Spring):
    """A model from elsewhere whose findings are none."""

    name: ClassVar[str] = "garbled"

    def simulate(self, scenario: Scenario) -> Response:
        return super().simulate(scenario).assign_attrs(findings="[1]")
