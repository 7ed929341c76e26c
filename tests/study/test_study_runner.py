from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
from concurrent.futures import Future
from pathlib import Path

import pytest
from toy_models import Spring, Troubled

from workbench.base.errors import InputError, WorkbenchError
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import ColumnImpact
from workbench.study import Case, CellProgress, Store, Study, cells_of, gather, run_study, survey
from workbench.study.cells import task_of
from workbench.study.runner import Workers


def with_models(study: Study, **models: object) -> Study:
    reference = study.reference if study.reference in models else next(iter(models))
    return dataclasses.replace(
        study, models=models, reference=reference, ladder=(), quick_models=()
    )


def digests(directory: Path) -> dict[str, str]:
    return {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in (*directory.glob("cells/*.nc"), directory / "manifest.json")
    }


def stamps(directory: Path) -> dict[str, tuple[int, int]]:
    return {
        path.name: (path.stat().st_ino, path.stat().st_mtime_ns)
        for path in directory.glob("cells/*")
    }


def outcomes(study: Study, root: Path) -> dict[str, str]:
    store = Store(root / study.name)
    return {cell.name: store.record(cell.key)["outcome"] for cell in cells_of(study)}


@pytest.mark.thorough
def test_serial_and_parallel_and_repeated_runs_give_the_same_bytes(
    toy_study: Study, tmp_path: Path
) -> None:
    in_process = run_study(toy_study, tmp_path / "a", jobs=0)
    one = run_study(toy_study, tmp_path / "b", jobs=1)
    two = run_study(toy_study, tmp_path / "c", jobs=2)
    assert in_process.answered == one.answered == two.answered == 12
    assert digests(one.directory) == digests(two.directory) == digests(in_process.directory)
    assert len(digests(one.directory)) == 13
    before = digests(two.directory)
    again = run_study(toy_study, tmp_path / "c", jobs=0, fresh=True)
    assert again.answered == 12
    assert digests(two.directory) == before


def test_a_second_run_answers_nothing(toy_study: Study, tmp_path: Path) -> None:
    first = run_study(toy_study, tmp_path, jobs=0)
    before = stamps(first.directory)
    second = run_study(toy_study, tmp_path, jobs=0)
    assert (second.answered, second.stored) == (0, 12)
    assert stamps(first.directory) == before


def test_stored_bytes_hold_nothing_that_changes_from_run_to_run(
    toy_study: Study, tmp_path: Path
) -> None:
    run_study(toy_study, tmp_path, jobs=0)
    store = Store(tmp_path / "toy")
    key = cells_of(toy_study)[0].key
    stored, record = store.response(key), store.record(key)
    assert {"wall_time", "provenance"}.isdisjoint(stored.attrs)
    assert record["wall_time"] > 0.0
    assert record["provenance"]["numpy"]
    assert record["started"].endswith("+00:00")
    fresh = cells_of(toy_study)[0].model.simulate(cells_of(toy_study)[0].scenario)
    for name in fresh.variables:
        assert stored[name].identical(fresh[name]), name


def test_only_a_pattern(toy_study: Study, tmp_path: Path) -> None:
    assert run_study(toy_study, tmp_path, jobs=0, only="soft").answered == 3
    assert run_study(toy_study, tmp_path, jobs=0, only="v15*/fine").answered == 1
    with pytest.raises(InputError, match="matches no cell; cases and labels are v10"):
        run_study(toy_study, tmp_path, jobs=0, only="nothing")
    states = [
        entry.state for entry in survey(toy_study, cells_of(toy_study), Store(tmp_path / "toy"))
    ]
    assert states.count(CellProgress.DONE) == 4


def test_the_quick_form_has_its_own_store(toy_study: Study, tmp_path: Path) -> None:
    summary = run_study(toy_study, tmp_path, jobs=0, quick=True)
    assert summary.directory == tmp_path / "toy-quick"
    assert summary.answered == 9
    assert summary.study.ladder == ("middle", "fine")


@pytest.mark.thorough
def test_every_failure_is_a_stored_result_and_the_rest_goes_on(
    toy_study: Study, tmp_path: Path
) -> None:
    study = with_models(
        toy_study,
        good=Spring(),
        killed=Troubled("kill", above=17.0),
        left=Troubled("exit", above=17.0),
        hung=Troubled("hang", above=17.0),
        stuck=Troubled("solver"),
        refused=Troubled("refuse"),
        invalid=Troubled("input"),
        broken=Troubled("raise"),
        unfinite=Troubled("nan"),
    )
    summary = run_study(study, tmp_path, jobs=2, timeout=3.0)
    ends = outcomes(study, tmp_path)
    for velocity in ("v10.0", "v15.0", "v20.0"):
        slow = velocity != "v20.0"
        assert ends[f"{velocity}/good"] == "ok"
        assert ends[f"{velocity}/killed"] == ("ok" if slow else "crashed")
        assert ends[f"{velocity}/left"] == ("ok" if slow else "crashed")
        assert ends[f"{velocity}/hung"] == ("ok" if slow else "timed-out")
        assert ends[f"{velocity}/stuck"] == "not-converged"
        assert ends[f"{velocity}/refused"] == "out-of-domain"
        assert ends[f"{velocity}/invalid"] == "invalid-input"
        assert ends[f"{velocity}/broken"] == "crashed"
        assert ends[f"{velocity}/unfinite"] == "crashed"
    assert summary.failed == 15
    tree = gather(study, tmp_path)
    messages = {label: tree[f"v20.0/{label}"].attrs["message"] for label in study.models}
    assert "by signal SIGKILL" in messages["killed"]
    assert "with status 3" in messages["left"]
    assert "stopped after the 3 s" in messages["hung"]
    assert "ZeroDivisionError: division by zero" in messages["broken"]
    assert "toy.option = 1: must be 2" in messages["invalid"]
    assert "not finite" in messages["unfinite"]
    for label, message in messages.items():
        outcome = outcome_of(tree[f"v20.0/{label}"].to_dataset())
        assert message.endswith("" if outcome is Outcome.OK else outcome.advice)
    # crashed cells are tried again, timed-out ones only with more time
    states = {e.cell.name: e.state for e in survey(study, cells_of(study), Store(tmp_path / "toy"))}
    assert states["v20.0/killed"] is states["v20.0/left"] is states["v20.0/broken"]
    assert run_study(study, tmp_path, jobs=0, only="broken").answered == 3
    answered = [
        run_study(study, tmp_path, jobs=1, timeout=seconds, only="hung").answered
        for seconds in (3.0, 3.1)
    ]
    assert answered == [0, 1]


def test_a_trace_of_a_crash_is_kept_without_paths(toy_study: Study, tmp_path: Path) -> None:
    study = with_models(toy_study, broken=Troubled("raise"))
    run_study(study, tmp_path, jobs=0)
    record = Store(tmp_path / "toy").record(cells_of(study)[0].key)
    assert any(line.startswith("toy_models.py:") for line in record["trace"])
    assert not any("/" in line for line in record["trace"])


def test_all_cells_are_checked_before_the_first_one_is_answered(
    toy_study: Study, tmp_path: Path, thesis_impact: ColumnImpact
) -> None:
    @dataclasses.dataclass(frozen=True)
    class Local(Spring):
        pass

    for change, message in (
        ({"models": {"fine": Spring(), "bad": Local()}, "ladder": ()}, "sent to a worker"),
        ({"models": {"fine": Spring(), "bad": Spring}, "ladder": ()}, "model object"),
        ({"models": {"fine": Spring(stiffness=1 + 2j)}, "ladder": ()}, "cannot be stored"),
        ({"cases": ()}, "no cell"),
    ):
        study = dataclasses.replace(toy_study, quick_models=(), **change)
        with pytest.raises(InputError, match=message):
            run_study(study, tmp_path, jobs=0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("bad", [{"jobs": -1}, {"timeout": 0.0}, {"timeout": float("nan")}])
def test_bad_arguments(toy_study: Study, tmp_path: Path, bad: dict[str, float]) -> None:
    with pytest.raises(InputError):
        run_study(toy_study, tmp_path, **bad)


def test_a_corrupt_cell_is_answered_again_and_said_so(
    toy_study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from workbench.study.runner import Progress

    run_study(toy_study, tmp_path, jobs=0)
    before = digests(tmp_path / "toy")
    cells = cells_of(toy_study)
    store = Store(tmp_path / "toy")
    flipped = store.cells / f"{cells[0].key}.nc"
    flipped.write_bytes(flipped.read_bytes()[:-7] + b"garbage")
    (store.cells / f"{cells[1].key}.nc").unlink()
    (store.cells / f"{cells[2].key}.json").write_text("{")
    (store.cells / f"{cells[3].key}.json").unlink()  # killed between file and record
    statuses = survey(toy_study, cells, store)
    assert [entry.state for entry in statuses].count(CellProgress.TO_DO) == 4
    assert "corrupt" in statuses[0].reason
    summary = run_study(toy_study, tmp_path, jobs=0, progress=Progress(sys.stderr))
    assert summary.answered == 4
    errors = capsys.readouterr().err
    assert errors.count("corrupt and is answered again") == 3
    assert "4 cells to answer, 8 already stored, about " in errors  # from what the stored ones took
    assert digests(tmp_path / "toy") == before


def test_leftovers_of_a_killed_run_are_cleaned(toy_study: Study, tmp_path: Path) -> None:
    cells = tmp_path / "toy" / "cells"
    cells.mkdir(parents=True)
    (cells / "abc.nc.99.partial").write_bytes(b"half")
    run_study(toy_study, tmp_path, jobs=0)
    assert list(cells.glob("*.partial")) == []


@pytest.mark.thorough
def test_an_interrupt_leaves_a_consistent_store(toy_study: Study, tmp_path: Path) -> None:
    class Impatient:
        def __init__(self) -> None:
            self.seen = 0

        def begin(self, *arguments: object) -> None: ...
        def note(self, text: str) -> None: ...
        def end(self) -> None: ...
        def advance(self, *arguments: object) -> None:
            self.seen += 1
            if self.seen == 5:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(toy_study, tmp_path, jobs=2, progress=Impatient())
    states = survey(toy_study, cells_of(toy_study), Store(tmp_path / "toy"))
    assert sum(entry.state is CellProgress.DONE for entry in states) == 5
    summary = run_study(toy_study, tmp_path, jobs=0)
    assert (summary.answered, summary.stored) == (7, 5)
    whole = run_study(toy_study, tmp_path / "whole", jobs=0)
    assert digests(tmp_path / "toy") == digests(whole.directory)


def test_two_runs_do_not_share_a_store(toy_study: Study, tmp_path: Path) -> None:
    class Nested:
        def begin(self, *arguments: object) -> None:
            with pytest.raises(InputError, match="in use by another run"):
                run_study(toy_study, tmp_path, jobs=0)

        def note(self, text: str) -> None: ...
        def end(self) -> None: ...
        def advance(self, *arguments: object) -> None: ...

    assert run_study(toy_study, tmp_path, jobs=0, progress=Nested()).answered == 12


def test_cases_that_differ_in_name_only_share_an_answer(
    toy_study: Study, tmp_path: Path, thesis_impact: ColumnImpact
) -> None:
    twins = (
        Case("first", thesis_impact),
        Case("second", dataclasses.replace(thesis_impact, name="another name")),
    )
    study = dataclasses.replace(toy_study, cases=twins)
    run_study(study, tmp_path / "a", jobs=0, only="second")
    run_study(study, tmp_path / "a", jobs=0)
    run_study(study, tmp_path / "b", jobs=0)
    assert len(list((tmp_path / "b" / "toy" / "cells").glob("*.nc"))) == 4
    assert digests(tmp_path / "a" / "toy") == digests(tmp_path / "b" / "toy")


def test_fresh_drops_what_no_longer_belongs_to_the_study(toy_study: Study, tmp_path: Path) -> None:
    run_study(toy_study, tmp_path, jobs=0)
    fewer = dataclasses.replace(toy_study, cases=toy_study.cases[:1])
    run_study(fewer, tmp_path, jobs=0)
    assert len(Store(tmp_path / "toy").keys()) == 12
    run_study(fewer, tmp_path, jobs=0, fresh=True)
    assert Store(tmp_path / "toy").keys() == {cell.key for cell in cells_of(fewer)}


def test_gather_is_a_tree_of_cases_and_labels(toy_study: Study, tmp_path: Path) -> None:
    run_study(toy_study, tmp_path, jobs=0, only="v1*")
    tree = gather(toy_study, tmp_path)
    assert list(tree.children) == ["v10.0", "v15.0"]
    assert list(tree["v10.0"].children) == ["soft", "coarse", "middle", "fine"]
    node = tree["v15.0/fine"]
    assert node["peak_displacement"].item() == pytest.approx(
        1.02 * 15.0 / (5e6 / 1500.0) ** 0.5, rel=1e-14
    )
    assert node["time"].dtype == float
    assert node.attrs["wall_time"] > 0.0
    assert json.loads(tree.attrs["missing"]) == [f"v20.0/{label}" for label in toy_study.models]


def test_slashes_in_names(toy_study: Study, tmp_path: Path, thesis_impact: ColumnImpact) -> None:
    study = dataclasses.replace(toy_study, cases=(Case("15 m/s", thesis_impact),))
    assert run_study(study, tmp_path, jobs=0, only="15 m/s").answered == 4
    assert list(gather(study, tmp_path).children) == ["15 m_s"]


def test_workers_that_cannot_start_end_the_run_with_a_reason(
    toy_study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:

    task = dataclasses.replace(task_of(cells_of(toy_study)[0]), payload=b"cnowhere\nNothing\n.")
    with pytest.raises(WorkbenchError, match="cannot handle its cell: ModuleNotFoundError"):
        list(Workers(1).run([task]))


@pytest.mark.parametrize("knows", [True, False], ids=["refuses the task", "forgets the task"])
def test_a_pool_that_breaks_at_once_is_told(
    toy_study: Study, monkeypatch: pytest.MonkeyPatch, knows: bool
) -> None:
    """A worker killed before its pool has taken the task down: no answer of it will ever come."""

    class Broken:
        active = False

        def __init__(self, *arguments: object, **options: object) -> None: ...
        def stop(self) -> None: ...
        def join(self) -> None: ...
        def schedule(self, *arguments: object, **options: object) -> Future[object]:
            if knows:
                raise RuntimeError("Unexpected error within the Pool")
            return Future()

    monkeypatch.setattr("workbench.study.runner.ProcessPool", Broken)
    with pytest.raises(WorkbenchError, match="a worker process ended before it had a cell"):
        list(Workers(1).run([task_of(cells_of(toy_study)[0])]))


def test_scheduler_without_the_library(
    toy_study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"not installed; pip install .*workbench\[scale\]"):
        run_study(toy_study, tmp_path, scheduler="tcp://127.0.0.1:8786")
