"""Running a study: answer the cells that are not stored yet, and keep the store consistent."""

import os
from collections import Counter
from contextlib import closing
from dataclasses import dataclass
from math import inf
from pathlib import Path

from workbench.errors import InputError
from workbench.responses import Outcome
from workbench.study.cells import Cell, cells_of, select
from workbench.study.definition import Study
from workbench.study.executors import DaskCluster, InProcess, Workers
from workbench.study.manifest import write_manifest
from workbench.study.progress import Progress
from workbench.study.store import Store
from workbench.study.work import task_of


@dataclass(frozen=True)
class RunSummary:
    """What a run did: cells `answered` now, `stored` before, and how all of them ended."""

    study: Study
    directory: Path
    answered: int
    stored: int
    outcomes: dict[str, int]

    @property
    def failed(self) -> int:
        """Cells that should have an answer and have none (a refusal, out-of-domain, is one)."""
        return sum(n for outcome, n in self.outcomes.items() if Outcome(outcome).is_failure)


def run_study(
    study: Study,
    root: Path,
    jobs: int | None = None,
    quick: bool = False,
    fresh: bool = False,
    only: str | None = None,
    timeout: float | None = None,
    progress: Progress | None = None,
    scheduler: str | None = None,
    file: Path | None = None,
) -> RunSummary:
    """Answer every cell of a study that the store under ``root/<study name>`` does not hold.

    Arguments: `jobs`, worker processes (None: one per core; 0: no worker, in this process);
    `quick`, run the quick form of the study; `fresh`, answer stored cells again and drop those
    that no longer belong to the study; `only`, a shell pattern on case, label or case/label;
    `timeout`, wall time in s that a cell may take; `scheduler`, address of a Dask cluster;
    `file`, the study file, if it defines models of its own.

    All cells are checked before the first one is answered. A cell that fails is a stored result;
    crashed cells are answered again by the next run, timed-out ones if it allows more time.
    Killing the run at any moment loses at most the cells in flight.
    Raises `InputError` for a study, pattern, store or scheduler that cannot be used;
    KeyboardInterrupt passes through, with everything answered so far in the store.
    """
    study = study.quickened() if quick else study
    cells = cells_of(study)
    chosen = {cell.key: cell for cell in reversed(select(cells, only))}
    if timeout is not None and not timeout > 0.0:
        raise InputError("--timeout", timeout, "must be a number of seconds above 0")
    executor = _executor(jobs, scheduler)
    progress = progress or Progress()
    store = Store(Path(root) / study.name)
    with store.alone():
        waiting = [
            cell
            for cell in _costly_first(study, cells)
            if cell.key in chosen and (fresh or _to_do(cell, store, timeout, progress))
        ]
        write_manifest(study, cells, store, runs=bool(waiting))
        stored = len(chosen) - len(waiting)
        tasks = [task_of(cell, timeout, file) for cell in waiting]
        by_key = {cell.key: cell for cell in waiting}
        workers = max(1, min(getattr(executor, "jobs", 1), len(tasks)))
        progress.begin(study.name, waiting, stored, workers)
        try:
            # closing: an interrupt stops the workers here, not whenever memory is tidied
            with closing(executor.run(tasks)) as results:
                for result in results:
                    store.put(result.key, result.content, result.record)
                    seconds = result.record["first_call"]
                    progress.advance(by_key[result.key], result.outcome, seconds)
        finally:
            progress.end()
            write_manifest(study, cells, store, runs=bool(waiting))
        if fresh and only is None:
            for key in store.keys() - {cell.key for cell in cells}:
                store.remove(key)
        outcomes = Counter(store.record(key)["outcome"] for key in chosen)
    return RunSummary(study, store.directory, len(waiting), stored, dict(outcomes))


def _executor(jobs: int | None, scheduler: str | None) -> DaskCluster | Workers | InProcess:
    if scheduler is not None:
        return DaskCluster(scheduler)
    if jobs is None:
        jobs = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    if jobs is None or jobs < 0:
        raise InputError("--jobs", jobs, "must be a whole number from 0")
    return Workers(jobs) if jobs else InProcess()


def _costly_first(study: Study, cells: list[Cell]) -> list[Cell]:
    """One cell per key, the finest references first so that no long cell runs alone at the end.

    Cells that differ in name only share a key; the first one of the study speaks for them, also
    when `only` names another, so that the stored bytes do not depend on what was asked for.
    """
    unique = list({cell.key: cell for cell in reversed(cells)}.values())[::-1]
    chain = [*study.ladder, study.reference]
    rank = {label: -place for place, label in enumerate(chain, 1)}
    return sorted(unique, key=lambda cell: rank.get(cell.label, 0))


def _to_do(cell: Cell, store: Store, timeout: float | None, progress: Progress) -> bool:
    if not store.holds(cell.key):
        return True
    answer, why = store.answer(cell.key, cell.ingredients), ""
    if answer is None:
        why = "the stored cell is corrupt and is answered again"
    else:
        outcome, limit = answer[0]["outcome"], answer[0]["limit"]
        if outcome == Outcome.CRASHED:
            why = "crashed last time and is tried again"
        elif outcome == Outcome.TIMED_OUT and limit and (timeout or inf) > limit:
            why = f"timed out after {limit:g} s and is given more time"
    if why:
        progress.note(f"{cell.name}: {why}")
    return bool(why)
