"""Where cells are answered: in this process, in worker processes, or on a Dask cluster.

An executor has ``run(tasks)``, which gives results in the order in which they are ready. All of
them call `work.perform`, so their numbers are bit-identical.
"""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from multiprocessing import get_context, resource_tracker
from typing import Any

from pebble import ProcessExpired, ProcessPool

from workbench.base.errors import InputError, WorkbenchError
from workbench.responses import Outcome
from workbench.study.cells import Result, Task, perform, timed_out, unanswered

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
                            answer = pool.schedule(_answer, (task,), timeout=limit)
                        at_work[answer] = task, time.monotonic()
                    if not at_work:
                        return
                    for future in wait(at_work, return_when=FIRST_COMPLETED).done:
                        task, since = at_work.pop(future)
                        yield _result_of(future, task, time.monotonic() - since)
            finally:
                pool.stop()
                pool.join()


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
        why = "a script that runs a study needs: if __name__ == '__main__'; else somebody or the "
        why += "system stopped it: is there memory for this many --jobs?"
        raise WorkbenchError(f"a worker process ended before it had a cell; {why}") from error
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
