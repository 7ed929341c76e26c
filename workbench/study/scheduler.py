"""Answering cells on an existing Dask cluster (optional library ``distributed``)."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

from workbench.errors import InputError
from workbench.responses import Outcome
from workbench.study.work import Result, Task, is_late, perform, timed_out, unanswered

CONNECT_SECONDS = 10.0


@dataclass(frozen=True)
class DaskCluster:
    """Answers cells on the cluster whose scheduler listens at `address` (``tcp://host:8786``).

    The workers need this package in the same version and, for models that a study file defines,
    the study file at the same path. Results come back to this process, which alone writes the
    store. A time limit is judged when the cell is back: a cluster stops no running task.
    """

    address: str

    def run(self, tasks: Sequence[Task]) -> Generator[Result, None, None]:
        """Answer every task.

        Raises `InputError` if `distributed` is not installed or the scheduler does not answer.
        """
        distributed = _library()
        try:
            client = distributed.Client(self.address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as error:
            said, advice = f"does not answer: {error}", "start it, or leave it out"
            raise InputError("--scheduler", self.address, said, advice) from error
        with client, client.as_current():
            by_key = {task.key: task for task in tasks}
            futures = [
                client.submit(perform_remotely, task, key=f"workbench-{task.key}", pure=False)
                for task in tasks
            ]
            for future in distributed.as_completed(futures):
                task = by_key[future.key.removeprefix("workbench-")]
                lost = future.exception()
                if lost is None:
                    yield future.result()
                else:
                    message = f"the cluster lost this cell: {type(lost).__name__}: {lost}"
                    yield unanswered(task, Outcome.CRASHED, message, 0.0)
                future.release()


def perform_remotely(task: Task) -> Result:
    """Answer a task on a Dask worker, with one numerical thread."""
    from threadpoolctl import threadpool_limits

    worker: Any = _library().get_worker()
    if not hasattr(worker, "workbench_warm"):
        worker.workbench_warm = set()
    with threadpool_limits(1):
        result = perform(task, worker.workbench_warm)
    seconds = float(result.record["first_call"])
    return timed_out(task, seconds) if is_late(task, seconds) else result


def _library() -> Any:
    try:
        import distributed
    except ImportError as error:
        said = "needs the library distributed, which is not installed"
        advice = 'pip install "workbench[scale]"'
        raise InputError("--scheduler", "dask", said, advice) from error
    return distributed
