"""Where cells are answered: in this process, in worker processes, or on a Dask cluster.

An executor has ``run(tasks)``, which gives results in the order in which they are ready. All of
them call `work.perform`, so their numbers are bit-identical.

**Second part.** Running a study: answer the cells that are not stored yet, keep the store
consistent.

Progress has an estimate of the time left: a bar on a terminal, lines elsewhere.
"""

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import timedelta
from importlib import import_module
from itertools import chain, islice
from math import inf
from multiprocessing import get_context, resource_tracker
from pathlib import Path
from statistics import fmean
from types import MappingProxyType
from typing import Any, TextIO

from pebble import ProcessExpired, ProcessPool

from workbench.base.errors import InputError, WorkbenchError
from workbench.responses import Outcome
from workbench.study.cells import (
    Result,
    StudyCell,
    Task,
    cells_of,
    perform,
    select,
    task_of,
    timed_out,
    unanswered,
    write_manifest,
)
from workbench.study.definition import Study
from workbench.study.store import Store

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
_ALARM = hasattr(signal, "setitimer")  # a POSIX system
_WARM: set[str] = set()  # kinds of cell that this worker process has answered
CONNECT_SECONDS = 10.0  # to a cluster
WINDOW = 256  # tasks at a cluster at a time, at least


@dataclass(frozen=True)
class InProcess:
    """Answers one cell after the other in this process: for a debugger.

    A time limit can only be judged afterwards here, and a crash ends the run.
    """

    def run(self, tasks: Sequence[Task]) -> Generator[Result, None, None]:
        """Answer every task in turn."""
        warm: set[str] = set()
        yield from (perform(task, warm) for task in tasks)


@dataclass(frozen=True)
class Workers:
    """Answers cells in `jobs` worker processes of this machine.

    A worker that dies costs the cell that it was at (outcome crashed); one whose model takes
    longer than allowed ends itself (timed-out); both are replaced.
    """

    jobs: int

    def run(self, tasks: Sequence[Task]) -> Generator[Result, None, None]:
        """Answer every task. Raises `WorkbenchError` if workers cannot start at all."""
        waiting, at_work = iter(tasks), dict[Any, tuple[Task, float]]()
        pool: Any = ProcessPool(self.jobs, initializer=_begin, context=get_context("spawn"))
        with _one_thread_environment():
            try:
                while True:
                    for task in islice(waiting, self.jobs - len(at_work)):
                        with deaf_to_interrupts():  # processes start with the first task
                            limit = None if _ALARM else task.limit
                            try:
                                answer = pool.schedule(_answer, (task,), timeout=limit)
                            except RuntimeError as error:  # the pool is broken
                                raise _no_workers() from error
                        at_work[answer] = task, time.monotonic()
                    if not at_work:
                        return
                    for future in _ready(at_work, pool):
                        task, since = at_work.pop(future)
                        yield _result_of(future, task, time.monotonic() - since)
            finally:
                pool.stop()
                pool.join()


def _ready(at_work: Iterable[Any], pool: Any) -> set[Any]:
    """The futures that are done: at least one. Raises `WorkbenchError` for a broken pool.

    A pool that breaks before it has taken a task down never speaks of that task again.
    """
    while not (ready := wait(at_work, 1.0, FIRST_COMPLETED).done):
        if not pool.active:
            raise _no_workers()
    return ready


def _no_workers() -> WorkbenchError:
    why = "a script that runs a study needs: if __name__ == '__main__'; else somebody or the "
    why += "system stopped it: is there memory for this many --jobs?"
    return WorkbenchError(f"a worker process ended before it had a cell; {why}")


def _result_of(future: Any, task: Task, seconds: float) -> Result:
    """The result of a task that a worker is done with after so many `seconds`, in any way."""
    try:
        result: Result = future.result()
    except TimeoutError:
        return timed_out(task, seconds)
    except ProcessExpired as error:
        code = error.exitcode
        if _ALARM and code == -signal.SIGALRM:
            return timed_out(task, seconds)
        names = {int(each): each.name for each in signal.Signals}
        how = f"with status {code}" if code >= 0 else f"by signal {names.get(-code, -code)}"
        message = f"the worker process ended {how} in this cell"
        return unanswered(task, Outcome.CRASHED, message, seconds)
    except BrokenProcessPool as error:
        raise _no_workers() from error
    except Exception as error:  # not the model's: its failures are results
        text = f"a worker process cannot handle its cell: {type(error).__name__}: {error}"
        raise WorkbenchError(text) from error
    return result


def _begin() -> None:
    """Begin as a worker process: it ends at once when it is stopped, and with its parent.

    What answers import with their first use counts for none of them.
    """
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with_parent()
    for part in ("linalg", "optimize", "sparse.linalg"):
        import_module(f"scipy.{part}")


def _answer(task: Task) -> Result:
    """Answer a task in a worker process, which ends where the model takes longer than it may.

    The alarm ends compiled code, too; it is off once the model has answered, before the advice.
    """
    _set_alarm(task.limit or 0.0)
    try:
        return perform(task, _WARM, _set_alarm)
    finally:
        _set_alarm()


def _set_alarm(seconds: float = 0.0) -> None:
    """Let the system end this process after so many seconds; 0: never."""
    if _ALARM:
        signal.setitimer(signal.ITIMER_REAL, seconds)


def end_with_parent() -> None:
    """Have this worker process end as soon as its parent has ended, in any way."""
    parent = multiprocessing.parent_process()

    def wait_for_it() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=wait_for_it, daemon=True).start()


@contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """A child inherits what is blocked: Ctrl-C while it imports is then for its parent alone."""
    if not hasattr(signal, "pthread_sigmask"):  # not a POSIX system
        yield
        return
    resource_tracker.ensure_running()  # else the first child starts it, which unblocks interrupts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread_environment() -> Iterator[None]:
    """Numerical libraries read these variables when they load, so a child must inherit them."""
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@dataclass(frozen=True)
class DaskCluster:
    """Answers cells on the Dask cluster whose scheduler listens at `address` (``tcp://host:8786``).

    The workers need this package in the same version and, for models that a study file defines,
    the study file at the same path. Results come back to this process, which alone writes the
    store. A time limit is judged when the cell is back: a cluster stops no running task.
    """

    address: str

    def run(self, tasks: Sequence[Task]) -> Generator[Result, None, None]:
        """Answer every task. Raises what `results` raises."""
        for task, result, lost in self.results(perform_remotely, tasks):
            if lost is None:
                yield result
            else:
                message = f"the cluster lost this cell: {type(lost).__name__}: {lost}"
                yield unanswered(task, Outcome.CRASHED, message, 0.0)

    def results(
        self, function: Callable[[Any], Any], tasks: Iterable[Any]
    ) -> Generator[tuple[Any, Any, BaseException | None], None, None]:
        """Tasks with what a function makes of them, or why it makes nothing, as they get ready.

        A window of tasks is at the cluster at a time. The task of a worker that dies goes to others
        (Dask says how often); what the function raises is not tried again. Raises `InputError` if
        `distributed` is not installed or the scheduler does not answer.
        """
        distributed = _library()
        try:
            client = distributed.Client(self.address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as error:
            text, advice = f"does not answer: {error}", "start it, or leave it out"
            raise InputError("--scheduler", self.address, text, advice) from error
        with client, client.as_current():
            waiting, by_key = iter(tasks), {}

            def submitted(count: int) -> list[Any]:
                futures = []
                for task in islice(waiting, count):
                    futures.append(client.submit(function, task, pure=False))
                    by_key[futures[-1].key] = task
                return futures

            window = max(WINDOW, 2 * sum(client.nthreads().values()))
            ready = distributed.as_completed(submitted(window))
            for future in ready:
                result: Any = None
                lost: BaseException | None = None
                try:
                    result = future.result()  # whose worker may have died since
                except Exception as error:
                    lost = error
                future.release()
                ready.update(submitted(1))
                yield by_key.pop(future.key), result, lost


def perform_remotely(task: Task) -> Result:
    """Answer a task on a Dask worker."""
    worker: Any = _library().get_worker()
    if not hasattr(worker, "workbench_warm"):
        worker.workbench_warm = set()
    return perform(task, worker.workbench_warm)


def _library() -> Any:
    try:
        import distributed
    except ImportError as error:
        text = "needs the library distributed, which is not installed"
        advice = 'pip install "steel-impact-workbench[scale]"'
        raise InputError("--scheduler", "dask", text, advice) from error
    return distributed


SILENCE = 60.0  # s, between two lines of a run that goes to a file
KNOWN = 0.9  # share of the cells left whose labels have a time, from which there is an estimate


class Progress:
    """Counts what the runner tells; a plain line every tenth of the run, and every `SILENCE` s.

    Without a `stream` it says nothing.
    """

    total = done = failed = 0
    began = _last = 0.0

    def __init__(self, stream: TextIO | None = None) -> None:
        self.stream = stream

    def begin(
        self,
        study: str,
        waiting: Sequence[StudyCell],
        stored: int,
        jobs: int,
        costs: Mapping[str, Sequence[float]] = MappingProxyType({}),
    ) -> None:
        """A run of `jobs` begins with `waiting` cells to answer and `stored` ones there.

        `costs`, the seconds that stored cells have taken, by label.
        """
        self.total, self.done, self.failed = len(waiting), 0, 0
        self.began, self._jobs = time.monotonic(), jobs
        self._left = Counter(cell.label for cell in waiting)
        self._costs = {label: [*seconds] for label, seconds in costs.items()}
        left = f", {self.left}" if self.left else ""
        self._say(f"{study}: {self.total} cells to answer, {stored} already stored{left}")

    def advance(self, cell: StudyCell, outcome: Outcome, seconds: float) -> None:
        """A cell has been answered, in `seconds` as far as possible without compilation."""
        before = 10 * self.done // self.total
        self.done += 1
        self.failed += outcome.is_failure
        self._left[cell.label] -= 1
        self._costs.setdefault(cell.label, []).append(seconds)
        silent = time.monotonic() - self._last > SILENCE and self.done < self.total
        if silent or before < 10 * self.done // self.total < 10:
            left = self.left or "time left not known yet"
            self._say(f"{self.done} of {self.total} cells, {self.failures}{left}")

    def note(self, text: str) -> None:
        """Something that the user should know."""
        self._say(text)

    def end(self) -> None:
        """The run is over, or was interrupted."""
        if self.total:
            took = timedelta(seconds=round(time.monotonic() - self.began))
            self._say(f"{self.done} of {self.total} cells answered, {self.failures}in {took}")

    def _say(self, text: str) -> None:
        self._last = time.monotonic()
        if self.stream is not None:
            print(text, file=self.stream, flush=True)

    def seconds_left(self) -> float | None:
        """Expected time left in s, from the mean cost of each label.

        None until `KNOWN` of the cells left are of labels that have answered, now or before: dear
        labels come first, and their mean says nothing of the others. Few others may cost it.
        """
        known = sum(count for label, count in self._left.items() if label in self._costs)
        if not self._costs or known < KNOWN * self._left.total():
            return None
        means = {label: fmean(costs) for label, costs in self._costs.items()}
        overall = fmean(chain.from_iterable(self._costs.values()))
        work = sum(count * means.get(label, overall) for label, count in self._left.items())
        return work / self._jobs

    @property
    def failures(self) -> str:
        """How many cells have failed, in words."""
        return f"{self.failed} failed, " if self.failed else ""

    @property
    def left(self) -> str:
        """The time left, in words; empty as long as it is not known."""
        seconds = self.seconds_left() if self.total else None
        return "" if seconds is None else f"about {timedelta(seconds=round(seconds))} left"


class ProgressBar(Progress):
    """A progress bar with the cell that was answered last and the time left."""

    display: Any = None
    task: Any = None

    def begin(
        self,
        study: str,
        waiting: Sequence[StudyCell],
        stored: int,
        jobs: int,
        costs: Mapping[str, Sequence[float]] = MappingProxyType({}),
    ) -> None:
        """Draw the bar."""
        from rich import progress
        from rich.console import Console

        super().begin(study, waiting, stored, jobs, costs)
        self.display = progress.Progress(
            progress.TextColumn(study),
            progress.BarColumn(),
            progress.MofNCompleteColumn(),
            progress.TextColumn("{task.fields[left]}"),
            progress.TextColumn("{task.fields[last]}", markup=False),
            console=Console(stderr=True),
        )
        stored_text = f"({stored} already stored)" if stored else ""
        self.task = self.display.add_task(study, total=len(waiting), left="", last=stored_text)
        self.display.start()

    def advance(self, cell: StudyCell, outcome: Outcome, seconds: float) -> None:
        """Move the bar."""
        super().advance(cell, outcome, seconds)
        last = f"{self.failures}{cell.name}: {outcome}"
        self.display.update(self.task, advance=1, left=self.left, last=last)

    def note(self, text: str) -> None:
        """Print a line above the bar."""
        if self.display is None:
            print(text, file=sys.stderr)
        else:
            self.display.console.print(text, markup=False, highlight=False)

    def end(self) -> None:
        """Leave the bar as it is."""
        if self.display is not None:
            self.display.update(self.task, left="", last=self.failures)
            self.display.stop()
            self.display = None


def progress_for(stream: TextIO, environment: Mapping[str, str]) -> Progress:
    """A bar if `stream` is a terminal and this is no automatic build (CI), else lines."""
    return ProgressBar() if stream.isatty() and not environment.get("CI") else Progress(stream)


@dataclass(frozen=True)
class RunSummary:
    """Summary of a run: cells `answered` now, `stored` before, and how all of them ended."""

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

    All cells are checked before the first one is answered. A cell that fails is a stored result;
    crashed cells are answered again by the next run, timed-out ones if it allows more time.
    Killing the run at any moment loses at most the cells in flight.

    Parameters
    ----------
    study : Study
        Cases and models.
    root : Path
        Folder of stores.
    jobs : int, optional
        Worker processes; None: one per core; 0: none, in this process.
    quick : bool
        Whether to run the quick form of the study.
    fresh : bool
        Whether to answer stored cells again, and to drop those that no longer belong to the study.
    only : str, optional
        Shell pattern on case, label or case/label.
    timeout : float, optional
        Wall time of a cell, in s.
    progress : Progress, optional
        Callbacks of the run.
    scheduler : str, optional
        Address of a Dask cluster.
    file : Path, optional
        The study file, if it defines models of its own.

    Returns
    -------
    RunSummary
        Cells `answered` now and `stored` before, their `outcomes`, and the `directory`.

    Raises
    ------
    InputError
        For a study, pattern, store or scheduler that cannot be used.
    KeyboardInterrupt
        Passed through, with everything answered so far in the store.

    Examples
    --------
    >>> from pathlib import Path
    >>> impact = wb.impact(wb.Column("HEB 220", 2.0, 2.0), mass=1500, velocity=5)
    >>> study = wb.study_of([impact], ["energy-estimate", "single-dof"], "single-dof")
    >>> wb.run_study(study, Path("results"), jobs=0).outcomes
    {'ok': 2}
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
        by_key = {cell.key: cell for cell in waiting}
        there = [cell for key, cell in chosen.items() if key not in by_key]
        costs = _costs(there, store) if waiting else {}
        tasks = [task_of(cell, timeout, file) for cell in waiting]
        workers = max(1, min(getattr(executor, "jobs", 1), len(tasks)))
        progress.begin(study.name, waiting, len(there), workers, costs)
        try:
            # closing: an interrupt stops the workers here, not whenever memory is tidied
            with closing(executor.run(tasks)) as results:
                for result in results:
                    store.put(result.key, result.content, result.record)
                    seconds = result.record["wall_time"]  # of a second call, if there was one
                    progress.advance(by_key[result.key], result.outcome, seconds)
        finally:
            progress.end()
            write_manifest(study, cells, store, runs=bool(waiting))
        if fresh and only is None:
            for key in store.keys() - {cell.key for cell in cells}:
                store.remove(key)
        outcomes = Counter(store.record(key)["outcome"] for key in chosen)
    return RunSummary(study, store.directory, len(waiting), len(there), dict(outcomes))


def _executor(jobs: int | None, scheduler: str | None) -> DaskCluster | Workers | InProcess:
    if scheduler is not None:
        return DaskCluster(scheduler)
    if jobs is None:
        jobs = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    if jobs is None or jobs < 0:
        raise InputError("--jobs", jobs, "must be a whole number from 0")
    return Workers(jobs) if jobs else InProcess()


def _costs(cells: Sequence[StudyCell], store: Store) -> dict[str, list[float]]:
    """Seconds of the stored answers of each label, as far as possible without compilation."""
    costs: dict[str, list[float]] = {}
    for cell in cells:
        costs.setdefault(cell.label, []).append(store.record(cell.key)["wall_time"])
    return costs


def _costly_first(study: Study, cells: list[StudyCell]) -> list[StudyCell]:
    """One cell per key, the best references first so that no long cell runs alone at the end.

    Cells that differ in name only share a key; the first one of the study speaks for them, also
    when `only` names another, so that the stored bytes do not depend on what was asked for.
    """
    unique = list({cell.key: cell for cell in reversed(cells)}.values())[::-1]
    chain = [*study.ladder, study.reference, *reversed(study.references)]
    rank = {label: -place for place, label in enumerate(chain, 1)}
    return sorted(unique, key=lambda cell: rank.get(cell.label, 0))


def _to_do(cell: StudyCell, store: Store, timeout: float | None, progress: Progress) -> bool:
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
