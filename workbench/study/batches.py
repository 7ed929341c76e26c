"""Answers of one model to many scenarios, in processes where they are worth them."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing import get_context
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits

from workbench.base.errors import WorkbenchError
from workbench.models.base import Model
from workbench.models.batch import FAILURE, OUTCOME, can_stack, simulate_many
from workbench.responses import SCALARS
from workbench.scenarios import Scenario
from workbench.scenarios.varied import Varied
from workbench.study.runner import deaf_to_interrupts, end_with_parent

CHUNK, PARTS = 256, 8  # scenarios that a process answers at a time, at most; times that it is asked

Run = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]


class Processes:
    """Run a function over tasks in processes of one thread each; in this one if `jobs` is 1.

    Results come in the order of the tasks. With `threads`, in those of this process instead. Raises
    `WorkbenchError` if a process is stopped from outside.
    """

    def __init__(self, jobs: int, threads: bool = False) -> None:
        self.jobs, self.threads = jobs, threads
        self.pool: Executor | None = None

    def __enter__(self) -> Run:
        if self.jobs == 1:
            return map
        if self.threads:
            self.pool = ThreadPoolExecutor(self.jobs)
        else:
            context = get_context("spawn")
            self.pool = ProcessPoolExecutor(self.jobs, context, initializer=_one_thread)
        return self._map

    def _map(self, function: Callable[[Any], Any], tasks: Iterable[Any]) -> Iterator[Any]:
        assert self.pool is not None
        with deaf_to_interrupts():  # processes start with their first task
            return self.pool.map(function, tasks)

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if self.pool is not None:
            if error is not None:  # such as an interrupt: nobody waits for what is at work
                for process in dict(getattr(self.pool, "_processes", None) or {}).values():
                    process.kill()
            self.pool.shutdown(cancel_futures=True)
        if isinstance(error, BrokenProcessPool):
            text = "a process was stopped from outside; is there memory for this many --jobs?"
            raise WorkbenchError(text) from error


def _one_thread() -> None:
    end_with_parent()
    threadpool_limits(1)


def answers_of(model: Model, varied: Varied, like: Scenario, jobs: int = 1) -> pd.DataFrame:
    """Answers of a model by row, see `simulate_many`, in so many threads or else processes.

    `like`, one of the scenarios.
    """
    with Processes(1 if len(varied) <= CHUNK else jobs) as run:
        return answers_by(run, jobs, model, varied, like)


def answers_by(run: Run, jobs: int, model: Model, varied: Varied, like: Scenario) -> pd.DataFrame:
    """Answers as of `answers_of`, by the processes of a `run`, started where answers do not stack.

    A few rows of superelements, which march beside each other, are not worth processes.
    """
    if can_stack(model, like) or (run is map and hasattr(model, "numbers")):
        return simulate_many(model, varied, jobs)
    size = min(CHUNK, max(1, len(varied) // (PARTS * jobs)))
    parts = [varied[k : k + size] for k in range(0, len(varied), size)]
    tables = run(partial(simulate_many, model, threads=1), parts)
    whole: pd.DataFrame = pd.concat(tables, ignore_index=True)
    return whole[[*(name for name in SCALARS if name in whole), OUTCOME, FAILURE]]
