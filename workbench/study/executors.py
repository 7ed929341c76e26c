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
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any

from workbench.base.errors import InputError, WorkbenchError
from workbench.responses import Outcome
from workbench.study.cells import Result, Task, is_late, perform, timed_out, unanswered

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
READY, ANSWERED = "ready", "answered"  # words of a worker; from the second on it advises
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

    A worker that dies costs the cell that it was at (outcome crashed); one that is at a cell
    for longer than allowed is stopped (timed-out); both are replaced.
    """

    jobs: int

    def run(self, tasks: Sequence[Task]) -> Generator[Result, None, None]:
        """Answer every task. Raises `WorkbenchError` if workers cannot start at all."""
        waiting = list(reversed(tasks))
        crew: list[_Worker] = []
        try:
            while waiting or any(worker.task for worker in crew):
                idle = sum(worker.task is None for worker in crew)
                while len(crew) < self.jobs and idle < len(waiting):
                    crew.append(_Worker())
                    idle += 1
                for worker in crew:
                    if worker.ready and worker.task is None and waiting:
                        worker.give(waiting.pop())
                _wait_for(crew)
                for worker in list(crew):
                    result = worker.collect()
                    if worker.over:
                        crew.remove(worker)
                    if result is not None:
                        yield result
        finally:
            for worker in crew:
                worker.stop()


@dataclass
class _Worker:
    """One worker process, the pipe to it, and the task that it is at."""

    ready: bool = False  # it has imported everything and waits
    over: bool = False  # it has died or has been stopped
    task: Task | None = None
    since: float = 0.0
    pipe: Connection = field(init=False)
    process: multiprocessing.process.BaseProcess = field(init=False)

    def __post_init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, end = context.Pipe()
        self.process = context.Process(target=serve, args=(end,), daemon=True)
        with _one_thread_environment(), deaf_to_interrupts():
            self.process.start()
        end.close()

    def give(self, task: Task) -> None:
        """Send a task."""
        self.task, self.since = task, time.monotonic()
        with suppress(OSError):  # it died while idle: `collect` sees the end of the pipe
            self.pipe.send(task)

    def collect(self) -> Result | None:
        """What the worker has to say, if anything; notices death and lateness.

        Raises `WorkbenchError` if it could not start or could not load its task.
        """
        try:
            if self.pipe.poll():
                message = self.pipe.recv()
                if isinstance(message, Result):
                    self.task = None
                    return message
                if message == ANSWERED and self.task is not None:
                    self.task = replace(self.task, limit=None)  # that was the time of the model
                    return None
                if message != READY:
                    raise WorkbenchError(f"a worker process cannot handle its cell: {message}")
                self.ready = True
                return None
        except (EOFError, OSError):
            return self._died()
        seconds = time.monotonic() - self.since
        if self.task is not None and is_late(self.task, seconds):
            task = self.task
            self.stop()
            return timed_out(task, seconds)
        return None

    def _died(self) -> Result | None:
        self.process.join()
        code, task = self.process.exitcode or 0, self.task
        self.stop()
        how = f"with status {code}"
        if code < 0:
            known = {int(each): each.name for each in signal.Signals}
            how = f"by signal {known.get(-code, -code)}"
        if not self.ready:
            why = "a script that runs a study needs: if __name__ == '__main__'"
            if code < 0:
                why = "somebody or the system stopped it: is there memory for this many --jobs?"
            raise WorkbenchError(f"a worker process ended {how} before it was ready; {why}")
        if task is None:
            return None
        message = f"the worker process ended {how} in this cell"
        return unanswered(task, Outcome.CRASHED, message, time.monotonic() - self.since)

    def stop(self) -> None:
        """End the process at once."""
        self.over, self.task = True, None
        self.process.kill()
        self.process.join()
        self.pipe.close()


def serve(pipe: Connection) -> None:
    """The main loop of a worker process: say ready, then answer tasks until the pipe closes."""
    # Ctrl-C reaches the whole process group; the parent decides what happens then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    warm: set[str] = set()
    pipe.send(READY)
    while True:
        try:
            task = pipe.recv()
        except EOFError:
            return
        try:
            answer: Result | str = perform(task, warm, partial(pipe.send, ANSWERED))
        except Exception as error:  # not the model's: its failures are results
            answer = f"{type(error).__name__}: {error}"
        pipe.send(answer)


def end_with_parent() -> None:
    """Have this worker process end as soon as its parent has ended, in any way."""
    parent = multiprocessing.parent_process()

    def wait_for_it() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=wait_for_it, daemon=True).start()


def _wait_for(crew: list[_Worker]) -> None:
    """Sleep until a worker has something to say or the next time limit is over."""
    ends = [
        worker.since + worker.task.limit
        for worker in crew
        if worker.task is not None and worker.task.limit is not None
    ]
    timeout = max(0.0, min(ends) - time.monotonic()) + 0.001 if ends else None
    wait([worker.pipe for worker in crew], timeout)


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
